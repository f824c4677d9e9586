//! What may stand for a number in a table, and for a list of transitions.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fmt;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::value::{MapAccessDeserializer, SeqAccessDeserializer};
use serde::de::{self, Deserialize, Deserializer, MapAccess, SeqAccess, Visitor};
use serde::{Serialize, Serializer};

use super::TableTransition;

/// A number in a row: `0.15`, `$NAME` or `-$NAME`.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// As written.
    Number(f64),
    /// A named number.
    Named {
        /// Its name, without the `$`.
        name: String,
        /// Whether it is taken times -1.
        is_negated: bool,
    },
}

impl Default for Value {
    fn default() -> Self {
        Self::Number(0.0)
    }
}

impl Value {
    /// The number, where named ones have these values.
    ///
    /// # Panics
    ///
    /// If none has that name.
    pub(super) fn at(&self, values: &BTreeMap<String, f64>) -> f64 {
        match self {
            Self::Number(number) => *number,
            Self::Named { name, is_negated: false } => values[name],
            Self::Named { name, is_negated: true } => -values[name],
        }
    }

    pub(super) fn is_one(&self) -> bool {
        *self == Self::Number(1.0)
    }

    pub(super) fn is_zero(&self) -> bool {
        *self == Self::Number(0.0)
    }
}

impl fmt::Display for Value {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Number(number) => write!(out, "{number}"),
            Self::Named { name, is_negated } => {
                write!(out, "{}${name}", if *is_negated { "-" } else { "" })
            }
        }
    }
}

impl Serialize for Value {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Number(number) => serializer.serialize_f64(*number),
            Self::Named { .. } => serializer.collect_str(self),
        }
    }
}

impl<'de> Deserialize<'de> for Value {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct ValueVisitor;
        impl Visitor<'_> for ValueVisitor {
            type Value = Value;
            fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
                formatter.write_str("a number, `$NAME` or `-$NAME`")
            }
            fn visit_f64<E: de::Error>(self, number: f64) -> Result<Value, E> {
                if number.is_finite() {
                    return Ok(Value::Number(number));
                }
                Err(E::custom(format!("{number} is not a finite number")))
            }
            fn visit_i64<E: de::Error>(self, number: i64) -> Result<Value, E> {
                Ok(Value::Number(number as f64))
            }
            fn visit_u64<E: de::Error>(self, number: u64) -> Result<Value, E> {
                Ok(Value::Number(number as f64))
            }
            fn visit_str<E: de::Error>(self, text: &str) -> Result<Value, E> {
                let (is_negated, named) = match text.strip_prefix('-') {
                    Some(rest) => (true, rest),
                    None => (false, text),
                };
                match named.strip_prefix('$') {
                    Some(name) => Ok(Value::Named { name: name.to_owned(), is_negated }),
                    None => Err(E::custom(format!(
                        "`{text}` is no number: expected one, or `$NAME` or `-$NAME`"
                    ))),
                }
            }
        }
        deserializer.deserialize_any(ValueVisitor)
    }
}

impl JsonSchema for Value {
    fn schema_name() -> Cow<'static, str> {
        "Value".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "anyOf": [{"type": "number"}, {"type": "string", "pattern": "^-?\\$[a-z][a-z0-9_]*$"}],
        })
    }
}

/// Transitions in order: in a file one, or a list.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[serde(transparent)]
pub struct Next(pub Vec<TableTransition>);

impl Next {
    pub(super) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

impl<'de> Deserialize<'de> for Next {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct NextVisitor;
        impl<'de> Visitor<'de> for NextVisitor {
            type Value = Next;
            fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
                formatter.write_str("{state, probability, after_s}, or a list of them")
            }
            fn visit_seq<A: SeqAccess<'de>>(self, list: A) -> Result<Next, A::Error> {
                Deserialize::deserialize(SeqAccessDeserializer::new(list)).map(Next)
            }
            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Next, A::Error> {
                let one = TableTransition::deserialize(MapAccessDeserializer::new(map))?;
                Ok(Next(vec![one]))
            }
        }
        deserializer.deserialize_any(NextVisitor)
    }
}

impl JsonSchema for Next {
    fn schema_name() -> Cow<'static, str> {
        "Next".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let one: serde_json::Value = generator.subschema_for::<TableTransition>().into();
        json_schema!({
            "description": "One transition, or a list of them.",
            "anyOf": [one, {"type": "array", "items": one}],
        })
    }
}
