//! Where a world is: in a file that another one names, or read.

use std::borrow::Cow;
use std::fmt;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::value::MapAccessDeserializer;
use serde::de::{self, Deserialize, Deserializer, MapAccess, Visitor};
use serde::{Serialize, Serializer};

use super::WorldFile;

/// The world of a sweep or an experiment.
#[derive(Clone, Debug, PartialEq)]
pub enum WorldSource {
    /// Path of the file, relative to the one that names it, as a person writes it.
    File(String),
    /// What was read, as a sweep leaves it in its folder.
    World(WorldFile),
}

impl WorldSource {
    /// The world, once it has been read.
    pub fn world(&self) -> Option<&WorldFile> {
        match self {
            Self::World(world) => Some(world),
            Self::File(_) => None,
        }
    }
}

impl Serialize for WorldSource {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::File(path) => serializer.serialize_str(path),
            Self::World(world) => world.serialize(serializer),
        }
    }
}

impl<'de> Deserialize<'de> for WorldSource {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct WorldVisitor;
        impl<'de> Visitor<'de> for WorldVisitor {
            type Value = WorldSource;
            fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
                formatter.write_str("the path of a world's file")
            }
            fn visit_str<E: de::Error>(self, path: &str) -> Result<WorldSource, E> {
                Ok(WorldSource::File(path.to_owned()))
            }
            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<WorldSource, A::Error> {
                WorldFile::deserialize(MapAccessDeserializer::new(map)).map(WorldSource::World)
            }
        }
        deserializer.deserialize_any(WorldVisitor)
    }
}

impl JsonSchema for WorldSource {
    fn schema_name() -> Cow<'static, str> {
        "WorldSource".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({"type": "string"})
    }
}
