//! What may stand in a fleet file, for the reference of all keys.

use std::borrow::Cow;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};

use super::ordered::Ordered;
use super::{FleetFile, Written};

impl JsonSchema for FleetFile {
    fn schema_name() -> Cow<'static, str> {
        "FleetFile".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        Written::json_schema(generator)
    }
}

impl<T: JsonSchema> JsonSchema for Ordered<T> {
    fn schema_name() -> Cow<'static, str> {
        format!("NamesOf{}", T::schema_name()).into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let of_each = generator.subschema_for::<T>();
        json_schema!({"type": "object", "additionalProperties": of_each})
    }
}
