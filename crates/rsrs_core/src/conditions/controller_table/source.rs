//! Where a table is: in a file that another one names, or read.

use std::borrow::Cow;
use std::fmt;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::value::MapAccessDeserializer;
use serde::de::{self, Deserialize, Deserializer, MapAccess, Visitor};
use serde::{Serialize, Serializer};

use super::ControllerTable;

/// What robots of a sweep or an experiment decide by.
#[derive(Clone, Debug, PartialEq)]
pub enum ControllerSource {
    /// Path of the file, relative to the one that names it, as a person writes it.
    File(String),
    /// The table that was read, as a sweep leaves it in its folder.
    Table(ControllerTable),
}

impl ControllerSource {
    /// The table, once it has been read.
    pub fn table(&self) -> Option<&ControllerTable> {
        match self {
            Self::Table(table) => Some(table),
            Self::File(_) => None,
        }
    }
}

impl Serialize for ControllerSource {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::File(path) => serializer.serialize_str(path),
            Self::Table(table) => table.serialize(serializer),
        }
    }
}

impl<'de> Deserialize<'de> for ControllerSource {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct ControllerVisitor;
        impl<'de> Visitor<'de> for ControllerVisitor {
            type Value = ControllerSource;
            fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
                formatter.write_str("the path of a controller's file")
            }
            fn visit_str<E: de::Error>(self, path: &str) -> Result<ControllerSource, E> {
                Ok(ControllerSource::File(path.to_owned()))
            }
            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<ControllerSource, A::Error> {
                let table = ControllerTable::deserialize(MapAccessDeserializer::new(map))?;
                Ok(ControllerSource::Table(table))
            }
        }
        deserializer.deserialize_any(ControllerVisitor)
    }
}

impl JsonSchema for ControllerSource {
    fn schema_name() -> Cow<'static, str> {
        "ControllerSource".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({"type": "string"})
    }
}
