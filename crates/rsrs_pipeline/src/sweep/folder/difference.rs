//! Where two sweeps differ first.

use serde::Serialize;
use serde_json::Value;

use crate::sweep::source::ResolvedSweep;

/// The first difference between the sweep of a folder and another one, in words:
/// `replicates is 16 there, and 32 here`.
///
/// # Returns
///
/// `None` if both ask for the same results: everything but the program's version is the same.
pub fn first_difference(there: &ResolvedSweep, here: &ResolvedSweep) -> Option<String> {
    let pairs = sections(there).into_iter().zip(sections(here));
    pairs.into_iter().find_map(|((key, there), (_, here))| differ(key, &there, &here))
}

/// What a sweep consists of, in the order of its file.
fn sections(source: &ResolvedSweep) -> [(&'static str, Value); 12] {
    let sweep = &source.sweep;
    [
        ("profile", value(&sweep.profile)),
        ("harsher", value(&sweep.harsher)),
        // The order of the axes counts: it is that of the cells.
        ("axes", value(&sweep.swept_axes())),
        ("axes", value(&sweep.axes)),
        ("fixed", value(&sweep.fixed)),
        ("placement", value(&sweep.placement)),
        ("cells", value(&sweep.cells)),
        ("replicates", value(&sweep.replicates)),
        ("duration_s", value(&sweep.duration_s)),
        ("seed", value(&sweep.seed)),
        ("adaptive", value(&sweep.adaptive)),
        ("the robot's profile", value(&source.profile)),
    ]
}

fn value(part: &impl Serialize) -> Value {
    serde_json::to_value(part).expect("sweeps and profiles are plain data")
}

fn differ(path: &str, there: &Value, here: &Value) -> Option<String> {
    if there == here {
        return None;
    }
    match (there, here) {
        (Value::Object(there), Value::Object(here)) => {
            let keys = there.keys().chain(here.keys());
            let absent = Value::Null;
            keys.into_iter().find_map(|key| {
                let (there, here) = (there.get(key), here.get(key));
                let path = format!("{path}.{key}");
                differ(&path, there.unwrap_or(&absent), here.unwrap_or(&absent))
            })
        }
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
