//! Numbers outside what they can mean.

use std::borrow::Cow;

/// A number that was given, and that cannot be meant.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{name} is {found}, expected {expected}")]
pub struct OutOfRange {
    /// Which one: the key in a file, or words.
    pub name: &'static str,
    /// What it is.
    pub found: f64,
    /// What it may be.
    pub expected: Cow<'static, str>,
}
