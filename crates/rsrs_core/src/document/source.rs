//! Where a part of a document is: in a file that the document names, or read.

use std::borrow::Cow;
use std::fmt;
use std::marker::PhantomData;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::value::MapAccessDeserializer;
use serde::de::{self, Deserialize, Deserializer, MapAccess, Visitor};
use serde::{Serialize, Serializer};

/// What may stand in a file of its own.
pub trait InFile {
    /// What it is: `controller`.
    const WHAT: &'static str;
    /// Name of [`Source`] of it in schemas.
    const SOURCE: &'static str;
}

/// The path of a file, or what was read from it.
#[derive(Clone, Debug, PartialEq)]
pub enum Source<T> {
    /// Path of the file, relative to the one that names it, as a person writes it.
    File(String),
    /// What was read, as a sweep leaves it in its folder.
    Read(T),
}

impl<T> Source<T> {
    /// What was read; `None` where it was not yet.
    pub fn read(&self) -> Option<&T> {
        match self {
            Self::Read(read) => Some(read),
            Self::File(_) => None,
        }
    }
}

impl<T: Serialize> Serialize for Source<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::File(path) => serializer.serialize_str(path),
            Self::Read(read) => read.serialize(serializer),
        }
    }
}

impl<'de, T: Deserialize<'de> + InFile> Deserialize<'de> for Source<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct PathOrMap<T>(PhantomData<T>);
        impl<'de, T: Deserialize<'de> + InFile> Visitor<'de> for PathOrMap<T> {
            type Value = Source<T>;
            fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(formatter, "the path of a {}'s file", T::WHAT)
            }
            fn visit_str<E: de::Error>(self, path: &str) -> Result<Source<T>, E> {
                Ok(Source::File(path.to_owned()))
            }
            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Source<T>, A::Error> {
                T::deserialize(MapAccessDeserializer::new(map)).map(Source::Read)
            }
        }
        deserializer.deserialize_any(PathOrMap(PhantomData))
    }
}

impl<T: InFile> JsonSchema for Source<T> {
    fn schema_name() -> Cow<'static, str> {
        T::SOURCE.into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({"type": "string"})
    }
}
