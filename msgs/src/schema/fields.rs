//! The lines of a `.msg` file.

use std::fmt;

/// Types that need no definition.
const BUILT_IN: [&str; 17] = [
    "bool", "byte", "char", "float32", "float64", "int8", "uint8", "int16", "uint16", "int32",
    "uint32", "int64", "uint64", "string", "wstring", "time", "duration",
];

/// The name of a message type, `package/msg/Name`.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct TypeName {
    /// Such as `std_msgs`.
    pub package: String,
    /// Such as `Bool`.
    pub name: String,
}

impl TypeName {
    /// Reads `package/msg/Name` or `package/Name`; `None` for anything else.
    pub fn parse(text: &str) -> Option<Self> {
        let mut parts: Vec<&str> = text.split('/').collect();
        if parts.len() == 3 && parts[1] == "msg" {
            parts.remove(1);
        }
        match parts[..] {
            [package, name] if parts.iter().all(|part| is_word(part)) => {
                Some(Self { package: package.to_owned(), name: name.to_owned() })
            }
            _ => None,
        }
    }

    /// The file with its definition, from the folder of its package's folder.
    pub fn file(&self) -> String {
        format!("{}/msg/{}.msg", self.package, self.name)
    }
}

impl fmt::Display for TypeName {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        write!(formatter, "{}/msg/{}", self.package, self.name)
    }
}

/// Whether something could be a name.
fn is_word(text: &str) -> bool {
    let mut characters = text.chars();
    characters.next().is_some_and(|first| first.is_ascii_alphabetic())
        && characters.all(|other| other.is_ascii_alphanumeric() || other == '_')
}

/// Whether ROS 2 would take it for a type: their names start with a capital letter, as those of
/// fields do not.
fn is_of_ros(type_name: &TypeName) -> bool {
    type_name.name.starts_with(|first: char| first.is_ascii_uppercase())
}

/// The name at the start of what follows a type.
fn name_in(rest: &str) -> &str {
    let end = rest.find(|character: char| character == '=' || character.is_whitespace());
    &rest[..end.unwrap_or(rest.len())]
}

/// The types of the fields that are not built in; sorted, each once.
///
/// # Errors
///
/// The number of the first line, counted from 1, that is neither field, constant, nor comment.
pub fn dependencies(text: &str, package: &str) -> Result<Vec<TypeName>, usize> {
    let mut found = Vec::new();
    for (index, line) in text.lines().enumerate() {
        let Some((field_type, rest)) = code(line) else { continue };
        if !is_word(name_in(rest)) {
            return Err(index + 1);
        }
        let element = element_of(field_type);
        if !BUILT_IN.contains(&element) {
            found.push(nested(element, package).filter(is_of_ros).ok_or(index + 1)?);
        }
    }
    found.sort_unstable();
    found.dedup();
    Ok(found)
}

/// How many elements a field has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Length {
    /// One, and no array.
    One,
    /// So many.
    Array(u64),
    /// So many at most.
    AtMost(u64),
    /// Any number.
    Any,
}

/// A field of a message.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Field<'a> {
    /// Its name.
    pub name: &'a str,
    /// The type of its elements, without limits.
    pub element: &'a str,
    /// That type, if it is not built in.
    pub nested: Option<TypeName>,
    /// How many elements it has.
    pub length: Length,
    /// The longest string, in characters; 0 without limit.
    pub string_capacity: u64,
}

/// The fields of a definition, in order, without constants; what does not read is left out.
pub fn fields<'a>(text: &'a str, package: &str) -> Vec<Field<'a>> {
    text.lines().filter_map(|line| field(code(line)?, package)).collect()
}

fn field<'a>((field_type, rest): (&'a str, &'a str), package: &str) -> Option<Field<'a>> {
    let name = name_in(rest);
    let behind = &rest[name.len()..];
    if behind.trim_start().starts_with('=') {
        return None;
    }
    let (of_one, array) = field_type.split_once('[').unwrap_or((field_type, ""));
    let length = match array.trim_end_matches(']') {
        "" if array.is_empty() => Length::One,
        "" => Length::Any,
        limit => match limit.strip_prefix("<=") {
            Some(limit) => Length::AtMost(limit.parse().ok()?),
            None => Length::Array(limit.parse().ok()?),
        },
    };
    let string_capacity = of_one.split_once("<=").map_or(Ok(0), |(_, limit)| limit.parse()).ok()?;
    let element = element_of(field_type);
    let nested = if BUILT_IN.contains(&element) { None } else { Some(nested(element, package)?) };
    Some(Field { name, element, nested, length, string_capacity })
}

fn element_of(field_type: &str) -> &str {
    field_type.split(['[', '<']).next().unwrap_or(field_type)
}

/// The full name of a type as a field has it.
fn nested(element: &str, package: &str) -> Option<TypeName> {
    TypeName::parse(&match element {
        // The one type that older definitions name without its package.
        "Header" => "std_msgs/Header".to_owned(),
        bare if !bare.contains('/') => format!("{package}/{bare}"),
        full => full.to_owned(),
    })
}

/// The first word of a line and what follows, without comment; `None` for an empty line.
fn code(line: &str) -> Option<(&str, &str)> {
    // A `#` within a string constant is cut off too, which leaves the constant a constant.
    let line = line.split('#').next().unwrap_or_default().trim();
    // `float64[ 3 ] x` is not valid, so the first space ends the type.
    let (field_type, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
    (!line.is_empty()).then_some((field_type, rest.trim()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(text: &str) -> Vec<String> {
        let found = dependencies(text, "lab_msgs").unwrap();
        found.iter().map(ToString::to_string).collect()
    }

    #[test]
    fn fields_of_other_types_are_found_whatever_surrounds_them() {
        let text = "
            # a comment
            std_msgs/Header header # another
            Wheel[] wheels
            Wheel[<=3] spare
            geometry_msgs/Point32[4] corners
            string<=10 name
            float64[9] covariance
            uint8 STATE=1
            string NOTE = \"a # b\"
        ";

        let expected = ["geometry_msgs/msg/Point32", "lab_msgs/msg/Wheel", "std_msgs/msg/Header"];
        assert_eq!(names(text), expected);
        assert_eq!(names("Header header"), ["std_msgs/msg/Header"]);
    }

    #[test]
    fn fields_have_lengths_and_limits_and_constants_are_none() {
        let text = "string<=10[<=3] names\nfloat64[9] covariance 1\nuint8 STATE = 1\nWheel[] w";

        let found = fields(text, "lab_msgs");

        let lengths: Vec<_> =
            found.iter().map(|field| (field.name, field.length, field.string_capacity)).collect();
        let expected = [
            ("names", Length::AtMost(3), 10),
            ("covariance", Length::Array(9), 0),
            ("w", Length::Any, 0),
        ];
        assert_eq!(lengths, expected);
        assert_eq!(found[2].nested, TypeName::parse("lab_msgs/Wheel"));
    }

    #[test]
    fn a_line_without_a_name_is_refused() {
        assert_eq!(dependencies("bool data\nbool\n", "lab_msgs"), Err(2));
        assert_eq!(dependencies("a/b/c/d field\n", "lab_msgs"), Err(1));
    }

    #[test]
    fn only_types_of_messages_are_type_names() {
        assert!(TypeName::parse("std_msgs/msg/Bool").is_some());
        assert!(TypeName::parse("std_msgs/Bool").is_some());
        for other in ["Bool", "std_msgs/srv/Bool", "../msg/Bool", "a/b/c/d", "", "a/"] {
            assert_eq!(TypeName::parse(other), None, "{other}");
        }
    }
}
