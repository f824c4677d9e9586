//! In what two measured robots differ.

use serde_json::Value;

use super::RobotProfile;

impl RobotProfile {
    /// The numbers of this robot that are not those of another one, as sentences name them:
    /// `<path of the key> <number> (<whose> <number>)`, `whose` being a word for the other one. Where
    /// they come from, and what the robots are called, is left out.
    ///
    /// # Panics
    ///
    /// Never: a profile is plain data.
    pub fn differences(&self, other: &Self, whose: &str) -> Vec<String> {
        let document = |profile: &Self| {
            let mut value = serde_json::to_value(profile).expect("a profile is plain data");
            let keys = value.as_object_mut().expect("a profile is an object");
            keys.retain(|key, _| !matches!(key.as_str(), "name" | "provenance"));
            value
        };
        let mut differences = Vec::new();
        compare("", [&document(self), &document(other)], whose, &mut differences);
        differences.sort();
        differences
    }
}

/// Goes down into objects; what is in a list is one value.
fn compare(path: &str, [one, other]: [&Value; 2], whose: &str, found: &mut Vec<String>) {
    if one == other {
        return;
    }
    let (Value::Object(keys), Value::Object(others)) = (one, other) else {
        found.push(format!("{path} {} ({whose} {})", short(one), short(other)));
        return;
    };
    let only_there = others.keys().filter(|key| !keys.contains_key(*key));
    for key in keys.keys().chain(only_there) {
        let inner = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
        let at = |object: &serde_json::Map<String, Value>| {
            object.get(key).cloned().unwrap_or(Value::Null)
        };
        compare(&inner, [&at(keys), &at(others)], whose, found);
    }
}

/// A value in a few words.
fn short(value: &Value) -> String {
    match value {
        Value::Null => "none".to_owned(),
        Value::Array(entries) if entries.iter().all(Value::is_number) => {
            let entries: Vec<String> = entries.iter().map(Value::to_string).collect();
            format!("[{}]", entries.join(", "))
        }
        // Of measured gains, which a line has no room for the commands of.
        Value::Array(entries) => {
            let means: Vec<String> = entries.iter().map(|entry| short(mean(entry))).collect();
            format!("[{}]", means.join(", "))
        }
        Value::Object(keys) => {
            let keys: Vec<String> =
                keys.iter().map(|(key, value)| format!("{key}: {}", short(value))).collect();
            format!("{{{}}}", keys.join(", "))
        }
        Value::String(text) => text.clone(),
        other => other.to_string(),
    }
}

/// The mean of a measured gain; of anything else, all of it.
fn mean(entry: &Value) -> &Value {
    entry.get("mean").unwrap_or(entry)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::sensor::Cone;

    use rsrs_testing::conditions::FLOCKBOT;

    #[test]
    fn only_numbers_that_differ_are_named_with_those_of_the_other() {
        let fleet = RobotProfile::parse("flockbot.yaml", FLOCKBOT).unwrap();
        let mut own = fleet.clone();
        "Flockbot 3".clone_into(&mut own.name);
        "measured again".clone_into(&mut own.provenance.source);
        assert_eq!(own.differences(&fleet, "fleet"), Vec::<String>::new());

        own.actuation.speed.limits_m_s[1] = 0.25;
        own.sensing.latency_steps = 2;
        own.actuation.speed.gain_by_command[0].mean = 0.5;
        let found = own.differences(&fleet, "fleet");

        assert_eq!(found.len(), 3, "{found:?}");
        assert!(found[0].starts_with("actuation.speed.gain_by_command [0.5, "), "{found:?}");
        assert_eq!(found[1], "actuation.speed.limits_m_s [0.02, 0.25] (fleet [0.02, 0.3])");
        assert_eq!(found[2], "sensing.latency_steps 2 (fleet 0)");
    }

    #[test]
    fn a_sensor_of_another_shape_is_named_as_what_each_has() {
        let fleet = RobotProfile::parse("flockbot.yaml", FLOCKBOT).unwrap();
        let mut own = fleet.clone();
        own.sensing.cone = None;
        own.sensing.polygon_m = Some(vec![[0.0, -0.1], [0.5, -0.2], [0.5, 0.2], [0.0, 0.1]]);

        let Cone { half_angle_rad, range_m } = fleet.sensing.cone.unwrap();
        let found = own.differences(&fleet, "fleet");

        let cone = format!("{{half_angle_rad: {half_angle_rad}, range_m: {range_m}}}");
        let expected = [
            &format!("sensing.cone none (fleet {cone})"),
            "sensing.polygon_m [[0.0, -0.1], [0.5, -0.2], [0.5, 0.2], [0.0, 0.1]] (fleet none)",
        ];
        assert_eq!(found, expected);
    }
}
