//! Numbers by which the environment sets how much is tested.

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
