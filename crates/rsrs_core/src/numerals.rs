//! Counts, shares and sizes as people read them.

/// A count with commas between thousands: `87,666`.
pub fn count(n: u64) -> String {
    let digits = n.to_string();
    let mut text = String::new();
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// A count of things: `1 message`, `2 messages`.
pub fn counted(n: u64, what: &str) -> String {
    if n == 1 { format!("{n} {what}") } else { format!("{} {what}s", count(n)) }
}

/// A number in three significant digits, as a person would write it.
pub fn significant(number: f64) -> f64 {
    format!("{number:.2e}").parse().expect("a number that was written reads")
}

/// Numbers that differ by less than this share were the same before they were written; dimensionless.
pub(crate) const SAME: f64 = 1e-9;

/// Whether a number is nothing, which is not written.
#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde passes references")]
pub(crate) fn is_zero(number: &f64) -> bool {
    *number == 0.0
}

/// A number without the rounding errors of how it was computed: to a millionth.
pub fn rounded(number: f64) -> f64 {
    let rounded = (number * 1e6).round() / 1e6;
    if rounded.is_finite() { rounded + 0.0 } else { number }
}

/// A share: `97.3 %`.
pub fn percent(share: f64) -> String {
    format!("{:.1} %", 100.0 * share)
}

/// Two shares with their unit once: `96.1 to 98.2 %`.
pub fn percents(low: f64, high: f64) -> String {
    format!("{:.1} to {}", 100.0 * low, percent(high))
}

/// A difference of shares: `10 percentage points`.
pub fn percentage_points(share: f64) -> String {
    match format!("{:.0}", 100.0 * share).as_str() {
        "1" => "1 percentage point".to_owned(),
        points => format!("{points} percentage points"),
    }
}

/// A size: `312 bytes`, `3.1 MB`.
pub fn size(n_bytes: u64) -> String {
    let units = [("GB", 1e9), ("MB", 1e6), ("kB", 1e3)];
    match units.into_iter().find(|(_, unit)| n_bytes as f64 >= *unit) {
        Some((name, unit)) => format!("{:.1} {name}", n_bytes as f64 / unit),
        None => counted(n_bytes, "byte"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thousands_have_commas() {
        let texts = [0, 999, 1_000, 87_666, 1_234_567].map(count);

        assert_eq!(texts, ["0", "999", "1,000", "87,666", "1,234,567"]);
        assert_eq!((&*counted(1, "topic"), &*counted(2_000, "topic")), ("1 topic", "2,000 topics"));
    }

    #[test]
    fn one_point_is_a_point() {
        let texts = [0.0, 0.01, 0.1].map(percentage_points);

        assert_eq!(texts, ["0 percentage points", "1 percentage point", "10 percentage points"]);
    }

    #[test]
    fn sizes_have_the_largest_unit_that_fits() {
        let texts = [1, 312, 1_000, 3_140_000, 2_500_000_000].map(size);

        assert_eq!(texts, ["1 byte", "312 bytes", "1.0 kB", "3.1 MB", "2.5 GB"]);
    }
}
