//! Numbers from the command line.

/// Reads a finite number from the command line that is what is expected, in words.
pub fn number(
    expected: &'static str,
    is_so: fn(f64) -> bool,
) -> impl Fn(&str) -> Result<f64, String> + Clone {
    move |text| {
        let number = text.parse().ok().filter(|number: &f64| number.is_finite() && is_so(*number));
        number.ok_or_else(|| format!("expected {expected}"))
    }
}

/// Reads a share strictly between 0 and 1 from the command line.
pub fn share() -> impl Fn(&str) -> Result<f64, String> + Clone {
    number("a share between 0 and 1", |share| share > 0.0 && share < 1.0)
}
