//! Bounds on order parameters, as a rule of a file has them.

use std::fmt;

use serde::de::{self, Deserialize, Deserializer, MapAccess, Visitor};
use serde::{Serialize, Serializer};

use super::condition::{Condition, Needs};
use crate::document::{did_you_mean, nearest};
use crate::judge::order::Parameter;

/// Bounds on order parameters, in the order of the file.
#[derive(Clone, Debug, PartialEq)]
pub struct ParameterBounds(Vec<Condition>);

/// Between which values an order parameter must be, in its unit: one bound, or one to each side.
#[derive(Clone, Copy, Default, Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
struct Interval {
    /// At the bound or above.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    at_least: Option<f64>,
    /// Below it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    below: Option<f64>,
    /// At the bound or below.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    at_most: Option<f64>,
}

impl ParameterBounds {
    /// One after the other.
    pub fn conditions(&self) -> &[Condition] {
        &self.0
    }

    /// Whether these hold wherever others do.
    pub fn follow_from(&self, others: &Self) -> bool {
        self.0.iter().all(|it| others.0.iter().any(|other| follows(it, other)))
    }
}

/// Whether a condition holds wherever another one does.
fn follows(it: &Condition, other: &Condition) -> bool {
    it.parameter == other.parameter
        && match (it.needs, other.needs) {
            (Needs::AtLeast, Needs::AtLeast) => other.bound >= it.bound,
            (Needs::AtLeast, _) | (_, Needs::AtLeast) => false,
            (Needs::Below, Needs::AtMost) => other.bound < it.bound,
            (Needs::Below | Needs::AtMost, _) => other.bound <= it.bound,
        }
}

impl Interval {
    fn conditions(self, parameter: Parameter) -> impl Iterator<Item = Condition> {
        let Self { at_least, below, at_most } = self;
        let all = [(Needs::AtLeast, at_least), (Needs::Below, below), (Needs::AtMost, at_most)];
        let condition = move |(needs, bound): (_, Option<f64>)| {
            Some(Condition { parameter, needs, bound: bound? })
        };
        all.into_iter().filter_map(condition)
    }

    fn with(mut self, condition: &Condition) -> Self {
        *match condition.needs {
            Needs::AtLeast => &mut self.at_least,
            Needs::Below => &mut self.below,
            Needs::AtMost => &mut self.at_most,
        } = Some(condition.bound);
        self
    }

    /// Whether it says something, and nothing twice or against itself.
    fn check(self, key: &str, most: f64) -> Result<(), String> {
        let Self { at_least, below, at_most } = self;
        let bounds = [at_least, below, at_most];
        if bounds.iter().all(Option::is_none) {
            return Err(format!("{key} has no bound, expected `at_least`, `below` or `at_most`"));
        }
        if below.is_some() && at_most.is_some() {
            return Err(format!("{key} has both `below` and `at_most`, expected one of them"));
        }
        let to = if most.is_finite() { format!("to {most}") } else { "on".to_owned() };
        for found in bounds.into_iter().flatten() {
            if !found.is_finite() || !(0.0..=most).contains(&found) {
                return Err(format!(
                    "the bound of {key} is {found}, expected a number from 0 {to}"
                ));
            }
        }
        match (at_least, below, at_most) {
            (Some(least), Some(most), _) if least >= most => {
                Err(format!("no {key} is at least {least} and below {most}"))
            }
            (Some(least), _, Some(most)) if least > most => {
                Err(format!("no {key} is at least {least} and at most {most}"))
            }
            _ => Ok(()),
        }
    }
}

impl Serialize for ParameterBounds {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let of_each = self.0.chunk_by(|one, other| one.parameter == other.parameter);
        serializer.collect_map(of_each.map(|of_one| {
            let interval = of_one.iter().fold(Interval::default(), Interval::with);
            (of_one[0].parameter.key(), interval)
        }))
    }
}

impl<'de> Deserialize<'de> for ParameterBounds {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct ByParameter;
        impl<'de> Visitor<'de> for ByParameter {
            type Value = ParameterBounds;
            fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
                formatter.write_str("a map from order parameters to bounds")
            }
            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<ParameterBounds, A::Error> {
                let mut conditions: Vec<Condition> = Vec::new();
                while let Some((key, interval)) = map.next_entry::<String, Interval>()? {
                    let parameter = Parameter::from_key(&key).ok_or_else(|| {
                        let keys: Vec<&str> = Parameter::all().map(Parameter::key).collect();
                        let meant = did_you_mean(nearest(&key, keys.iter().copied()));
                        let keys = keys.join(", ");
                        de::Error::custom(format!(
                            "unknown order parameter `{key}`, expected one of {keys}{meant}"
                        ))
                    })?;
                    interval.check(&key, parameter.most()).map_err(de::Error::custom)?;
                    conditions.extend(interval.conditions(parameter));
                }
                Ok(ParameterBounds(conditions))
            }
        }
        deserializer.deserialize_map(ByParameter)
    }
}

impl schemars::JsonSchema for ParameterBounds {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Bounds".into()
    }

    fn json_schema(generator: &mut schemars::SchemaGenerator) -> schemars::Schema {
        schemars::json_schema!({
            "type": "object",
            "propertyNames": {"enum": Parameter::all().map(Parameter::key).collect::<Vec<_>>()},
            "additionalProperties": generator.subschema_for::<Interval>(),
        })
    }
}
