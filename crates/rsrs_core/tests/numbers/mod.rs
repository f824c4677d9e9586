//! All numbers of a document, by their paths.

use std::collections::BTreeSet;

use serde_json::Value;

/// Dotted paths of all numbers, entries of lists by their position.
pub fn numbers(value: &Value, path: &str, found: &mut BTreeSet<String>) {
    let below = |key: &str| if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") };
    match value {
        Value::Number(_) => {
            found.insert(path.to_owned());
        }
        Value::Array(entries) => {
            for (position, entry) in entries.iter().enumerate() {
                numbers(entry, &below(&position.to_string()), found);
            }
        }
        Value::Object(entries) => {
            for (key, entry) in entries {
                numbers(entry, &below(key), found);
            }
        }
        Value::Null | Value::Bool(_) | Value::String(_) => {}
    }
}
