//! The controller of a sweep: a file, and what was read of it.

use std::borrow::Cow;
use std::fmt;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::value::MapAccessDeserializer;
use serde::de::{self, Deserialize, Deserializer, MapAccess, Visitor};
use serde::{Serialize, Serializer};

use super::{SweepFile, SweepFileError};
use crate::conditions::check_axis;
use crate::conditions::controller_table::ControllerTable;

/// What a sweep's robots decide by.
#[derive(Clone, Debug, PartialEq)]
pub enum SweptController {
    /// Path of the file, relative to the one that names it, as a person writes it.
    File(String),
    /// The table that was read, as a sweep leaves it in its folder.
    Table(ControllerTable),
}

impl SweepFile {
    /// Whether the axes are those of the controller, once its table has been read.
    ///
    /// # Errors
    ///
    /// [`SweepFileError::Controller`] or [`SweepFileError::NotOfController`].
    pub fn check_controller(&self, file: &str) -> Result<(), SweepFileError> {
        if let Some(SweptController::File(_)) = self.controller {
            return Ok(());
        }
        let table = self.table();
        if let Some(table) = table {
            let refuse = |source| SweepFileError::Controller { file: file.to_owned(), source };
            table.check().map_err(refuse)?;
        }
        let fixed = self.fixed.values.iter().map(|(axis, _)| *axis);
        self.swept_axes().into_iter().chain(fixed).try_for_each(|axis| {
            let refuse = |source| SweepFileError::NotOfController { file: file.to_owned(), source };
            check_axis(axis, table).map_err(refuse)
        })
    }
}

impl Serialize for SweptController {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::File(path) => serializer.serialize_str(path),
            Self::Table(table) => table.serialize(serializer),
        }
    }
}

impl<'de> Deserialize<'de> for SweptController {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct ControllerVisitor;
        impl<'de> Visitor<'de> for ControllerVisitor {
            type Value = SweptController;
            fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
                formatter.write_str("the path of a controller's file")
            }
            fn visit_str<E: de::Error>(self, path: &str) -> Result<SweptController, E> {
                Ok(SweptController::File(path.to_owned()))
            }
            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<SweptController, A::Error> {
                let table = ControllerTable::deserialize(MapAccessDeserializer::new(map))?;
                Ok(SweptController::Table(table))
            }
        }
        deserializer.deserialize_any(ControllerVisitor)
    }
}

impl JsonSchema for SweptController {
    fn schema_name() -> Cow<'static, str> {
        "SweptController".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({"type": "string"})
    }
}
