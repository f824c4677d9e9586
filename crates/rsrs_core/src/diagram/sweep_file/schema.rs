//! What may stand where a sweep or an experiment names axes, for the reference of all keys.

use std::borrow::Cow;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde_json::{Map, Value, json};

use super::{Axes, Fixed};
use crate::conditions::Walls;
use crate::quantity::{Axis, AxisValues, Cell};
use crate::robot::harsher::{Harsher, HarsherFactors};

/// One value on an axis.
fn value(axis: Axis) -> Value {
    let bounds = axis.bounds();
    let kind = if axis.is_count() { "integer" } else { "number" };
    json!({
        "description": axis.label(),
        "type": kind,
        "minimum": bounds.least,
        "maximum": bounds.most,
    })
}

/// Keys of the numbers of a controller's table.
const NUMBERS: &str = "^controller\\.[a-z][a-z0-9_]*$";

/// An object with a property for each axis.
fn by_axis(property: impl Fn(Axis) -> Value) -> Map<String, Value> {
    Axis::ALL.into_iter().map(|axis| (axis.key().to_owned(), property(axis))).collect()
}

impl JsonSchema for Cell {
    fn schema_name() -> Cow<'static, str> {
        "Cell".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "type": "object",
            "properties": by_axis(value),
            "patternProperties": {(NUMBERS): {"type": "number"}},
            "additionalProperties": false,
        })
    }
}

impl JsonSchema for Fixed {
    fn schema_name() -> Cow<'static, str> {
        "Fixed".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let mut properties = by_axis(value);
        properties.insert("walls".to_owned(), generator.subschema_for::<Walls>().into());
        json_schema!({
            "type": "object",
            "properties": properties,
            "patternProperties": {(NUMBERS): {"type": "number"}},
            "additionalProperties": false,
        })
    }
}

impl JsonSchema for Axes {
    fn schema_name() -> Cow<'static, str> {
        "Axes".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let values: Value = generator.subschema_for::<AxisValues>().into();
        let property = |axis: Axis| json!({"description": axis.label(), "allOf": [values]});
        json_schema!({
            "type": "object",
            "properties": by_axis(property),
            "patternProperties": {(NUMBERS): values},
            "additionalProperties": false,
        })
    }
}

impl JsonSchema for AxisValues {
    fn schema_name() -> Cow<'static, str> {
        "AxisValues".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "A list of values, or evenly spaced ones, both ends included.",
            "anyOf": [
                {"type": "array", "items": {"type": "number"}, "minItems": 1},
                {
                    "type": "object",
                    "properties": {
                        "from": {"type": "number"},
                        "to": {"type": "number"},
                        "steps": {"type": "integer", "minimum": 1},
                    },
                    "required": ["from", "to", "steps"],
                    "additionalProperties": false,
                },
            ],
        })
    }
}

impl JsonSchema for Harsher {
    fn schema_name() -> Cow<'static, str> {
        "Harsher".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let mut factors: Value = HarsherFactors::json_schema(generator).into();
        // What is left out follows from the robot, and is no constant.
        for factor in factors["properties"].as_object_mut().into_iter().flat_map(Map::values_mut) {
            factor.as_object_mut().map(|factor| factor.remove("default"));
        }
        json_schema!({"anyOf": [factors, {"const": "none"}]})
    }
}
