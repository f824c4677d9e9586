//! Results as JSON, with their sentences.

use std::collections::BTreeMap;

use serde::Serialize;

/// A result, and behind its keys another one.
#[derive(Serialize)]
struct With<T, V> {
    #[serde(flatten)]
    result: T,
    #[serde(flatten)]
    more: BTreeMap<&'static str, V>,
}

/// Adds a key behind those of a result.
pub fn with<T: Serialize, V: Serialize>(result: T, key: &'static str, value: V) -> impl Serialize {
    With { result, more: BTreeMap::from([(key, value)]) }
}
