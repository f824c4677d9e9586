//! The hash of a type, by which two computers agree that they mean the same.
//!
//! # Source
//!
//! REP 2016 (`RIHS01`): SHA-256 over the JSON of `type_description_interfaces/TypeDescription`,
//! without constants, defaults and comments. Held against the hashes of all types that are compiled
//! in.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use sha2::{Digest, Sha256};

use super::fields::{Field, Length, TypeName, fields};

/// A nested type, in the numbers of `type_description_interfaces/FieldType`.
const NESTED: u16 = 1;

/// Added for arrays, for sequences with a limit, and for those without.
const ARRAY: u16 = 48;
const BOUNDED_SEQUENCE: u16 = 96;
const UNBOUNDED_SEQUENCE: u16 = 144;

/// The numbers of the built-in types; `char` has been `uint8` since ROS 1.
const NUMBERS: [(&str, u16); 15] = [
    ("int8", 2),
    ("uint8", 3),
    ("char", 3),
    ("int16", 4),
    ("uint16", 5),
    ("int32", 6),
    ("uint32", 7),
    ("int64", 8),
    ("uint64", 9),
    ("float32", 10),
    ("float64", 11),
    ("bool", 15),
    ("byte", 16),
    ("string", 17),
    ("wstring", 18),
];

/// From a string without limit to one with.
const BOUNDED_STRING: u16 = 4;

/// The hash of a type, `RIHS01_` and 64 hexadecimal digits; `None` if a field is of a type that
/// ROS 2 does not have.
///
/// The `texts` are the definitions of the type and of all types in it, at whatever depth.
///
/// # Panics
///
/// If `texts` has no definition of `root`.
pub fn rihs01(root: &TypeName, texts: &BTreeMap<TypeName, String>) -> Option<String> {
    let mut json = format!("{{\"type_description\": {}", description(root, &texts[root])?);
    json.push_str(", \"referenced_type_descriptions\": [");
    let others: Option<Vec<String>> = texts
        .iter()
        .filter(|(name, _)| *name != root)
        .map(|(name, text)| description(name, text))
        .collect();
    json.push_str(&others?.join(", "));
    json.push_str("]}");
    let mut hash = "RIHS01_".to_owned();
    for byte in Sha256::digest(json) {
        write!(hash, "{byte:02x}").expect("a string takes all that is written to it");
    }
    Some(hash)
}

fn description(name: &TypeName, text: &str) -> Option<String> {
    let mut of_fields: Vec<String> =
        fields(text, &name.package).iter().map(field).collect::<Option<_>>()?;
    if of_fields.is_empty() {
        // C has no empty structures.
        of_fields.push(one_field("structure_needs_at_least_one_member", (3, 0, 0), ""));
    }
    Some(format!("{{\"type_name\": \"{name}\", \"fields\": [{}]}}", of_fields.join(", ")))
}

fn field(field: &Field) -> Option<String> {
    let (number, nested) = if let Some(nested) = &field.nested {
        (NESTED, nested.to_string())
    } else {
        let known = NUMBERS.iter().find(|(name, _)| *name == field.element)?;
        let is_bounded = field.string_capacity > 0;
        (known.1 + if is_bounded { BOUNDED_STRING } else { 0 }, String::new())
    };
    let (offset, capacity) = match field.length {
        Length::One => (0, 0),
        Length::Array(length) => (ARRAY, length),
        Length::AtMost(length) => (BOUNDED_SEQUENCE, length),
        Length::Any => (UNBOUNDED_SEQUENCE, 0),
    };
    Some(one_field(field.name, (number + offset, capacity, field.string_capacity), &nested))
}

fn one_field(name: &str, numbers: (u16, u64, u64), nested: &str) -> String {
    let (type_id, capacity, string_capacity) = numbers;
    format!(
        "{{\"name\": \"{name}\", \"type\": {{\"type_id\": {type_id}, \"capacity\": {capacity}, \
         \"string_capacity\": {string_capacity}, \"nested_type_name\": \"{nested}\"}}}}"
    )
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::super::{TypeName, dependencies, own_text, type_hash, type_names};
    use super::rihs01;

    fn read(type_name: &TypeName, texts: &mut BTreeMap<TypeName, String>) {
        let text = own_text(&type_name.to_string()).unwrap();
        texts.insert(type_name.clone(), text.to_owned());
        for dependency in dependencies(text, &type_name.package).unwrap() {
            read(&dependency, texts);
        }
    }

    #[test]
    fn the_hash_of_every_type_that_is_compiled_in_is_the_known_one() {
        let messages: Vec<TypeName> = type_names().filter_map(TypeName::parse).collect();
        assert!(messages.len() > 30, "{} types", messages.len());
        for root in messages {
            let mut texts = BTreeMap::new();
            read(&root, &mut texts);

            let found = rihs01(&root, &texts);

            assert_eq!(found.as_deref(), type_hash(&root.to_string()), "{root}");
        }
    }
}
