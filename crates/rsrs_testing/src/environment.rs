//! By what the environment sets how much is tested.

use std::fmt::Display;
use std::str::FromStr;

/// The number in a variable of the environment; `None` where it is not set.
///
/// # Panics
///
/// If it is no such number.
pub fn number<T: FromStr<Err: Display>>(variable: &str) -> Option<T> {
    let text = std::env::var_os(variable)?;
    let text = text.to_string_lossy();
    Some(text.parse().unwrap_or_else(|error| panic!("{variable} is `{text}`: {error}")))
}

/// Whether the long tests are asked for, by `RSRS_LONG_TESTS`.
pub fn is_long() -> bool {
    std::env::var_os("RSRS_LONG_TESTS").is_some()
}

/// How many there are, and in the long tests.
pub fn or_if_long<T>(usually: T, long: T) -> T {
    if is_long() { long } else { usually }
}
