//! Where two sweeps differ first.

use serde::Serialize;
use serde_json::Value;

use crate::sweep::source::ResolvedSweep;

/// What other keys follow from where they are left out, so that a difference is named where it was made.
const FIRST: [&str; 2] = ["profile", "harsher"];

/// The first difference between the sweep of a folder and another one, in words: `replicates is 16
/// there, and 32 here`. `None` if both ask for the same results: everything but the program's
/// version is the same.
pub fn first_difference(there: &ResolvedSweep, here: &ResolvedSweep) -> Option<String> {
    let sweeps = [there, here].map(|source| keys(&source.sweep));
    let [a, b] = &sweeps;
    let others = a.keys().chain(b.keys()).map(String::as_str);
    let of_key = |key: &str| differ(key, entry(a, key), entry(b, key));
    FIRST
        .into_iter()
        .chain(others)
        .find_map(of_key)
        .or_else(|| {
            // The order of the axes counts: it is that of the cells.
            let axes = [there, here].map(|source| value(&source.sweep.swept_axes()));
            differ("axes", &axes[0], &axes[1])
        })
        .or_else(|| differ("the robot's profile", &value(&there.profile), &value(&here.profile)))
}

/// A sweep by its keys: all of them, also those that nobody thought of here.
fn keys(sweep: &impl Serialize) -> serde_json::Map<String, Value> {
    match value(sweep) {
        Value::Object(keys) => keys,
        other => unreachable!("a sweep is a map, and not {other}"),
    }
}

fn entry<'a>(map: &'a serde_json::Map<String, Value>, key: &str) -> &'a Value {
    map.get(key).unwrap_or(&Value::Null)
}

fn value(part: &impl Serialize) -> Value {
    serde_json::to_value(part).expect("sweeps and profiles are plain data")
}

fn differ(path: &str, there: &Value, here: &Value) -> Option<String> {
    if there == here {
        return None;
    }
    match (there, here) {
        (Value::Object(a), Value::Object(b)) => a
            .keys()
            .chain(b.keys())
            .find_map(|key| differ(&format!("{path}.{key}"), entry(a, key), entry(b, key))),
        (Value::Array(there), Value::Array(here)) if there.len() == here.len() => {
            let pairs = there.iter().zip(here).enumerate();
            let differ = |(index, (there, here))| differ(&format!("{path}[{index}]"), there, here);
            pairs.into_iter().find_map(differ)
        }
        (Value::Array(there), Value::Array(here)) => {
            Some(format!("{path} has {} values there, and {} here", there.len(), here.len()))
        }
        _ => Some(format!("{path} is {} there, and {} here", printed(there), printed(here))),
    }
}

fn printed(value: &Value) -> String {
    match value {
        Value::Null => "not given".to_owned(),
        Value::Object(_) => "given".to_owned(),
        other => other.to_string(),
    }
}
