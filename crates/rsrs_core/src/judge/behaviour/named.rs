//! A behaviour as files name it that people write.

use serde::de::value::{MapAccessDeserializer, StrDeserializer};
use serde::de::{self, Deserialize, Deserializer, MapAccess, Visitor};
use serde::{Serialize, Serializer};

use super::Behaviour;

/// A behaviour by its name, as a whole, or by a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum NamedBehaviour {
    /// One that is built in, or was read.
    Known(Behaviour),
    /// The path of its file, `.yaml`, relative to the file that names it.
    File(String),
}

impl NamedBehaviour {
    /// Whether it is the one that files do not name.
    pub fn is_usual(&self) -> bool {
        *self == Self::default()
    }

    /// The behaviour.
    ///
    /// # Panics
    ///
    /// If its file was not read: whoever reads a file reads what it names.
    pub fn known(&self) -> Behaviour {
        match self {
            Self::Known(behaviour) => *behaviour,
            Self::File(path) => panic!("the behaviour in {path} was not read"),
        }
    }

    /// Whether a text is the path of a file, and not a name.
    pub fn is_path(text: &str) -> bool {
        [".yaml", ".yml"].iter().any(|end| text.ends_with(end))
    }
}

impl Default for NamedBehaviour {
    fn default() -> Self {
        Self::Known(Behaviour::default())
    }
}

impl Serialize for NamedBehaviour {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Known(behaviour) => behaviour.serialize(serializer),
            Self::File(path) => serializer.serialize_str(path),
        }
    }
}

impl<'de> Deserialize<'de> for NamedBehaviour {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct PathOrKnown;
        impl<'de> Visitor<'de> for PathOrKnown {
            type Value = NamedBehaviour;
            fn expecting(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                formatter.write_str("the name of a behaviour, the path of its file, or all of it")
            }
            fn visit_str<E: de::Error>(self, text: &str) -> Result<NamedBehaviour, E> {
                if NamedBehaviour::is_path(text) {
                    return Ok(NamedBehaviour::File(text.to_owned()));
                }
                Behaviour::deserialize(StrDeserializer::new(text)).map(NamedBehaviour::Known)
            }
            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<NamedBehaviour, A::Error> {
                Behaviour::deserialize(MapAccessDeserializer::new(map)).map(NamedBehaviour::Known)
            }
        }
        deserializer.deserialize_any(PathOrKnown)
    }
}

impl schemars::JsonSchema for NamedBehaviour {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "NamedBehaviour".into()
    }

    fn json_schema(generator: &mut schemars::SchemaGenerator) -> schemars::Schema {
        let known = generator.subschema_for::<Behaviour>();
        schemars::json_schema!({
            "description": "A behaviour by its name, by the path of its file, or as a whole.",
            "anyOf": [known, {"type": "string", "pattern": "\\.ya?ml$"}],
        })
    }
}
