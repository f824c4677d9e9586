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
        let is_word = |part: &&str| {
            let mut characters = part.chars();
            characters.next().is_some_and(|first| first.is_ascii_alphabetic())
                && characters.all(|other| other.is_ascii_alphanumeric() || other == '_')
        };
        match parts[..] {
            [package, name] if parts.iter().all(is_word) => {
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

/// The types of the fields that are not built in; sorted, each once.
///
/// # Errors
///
/// The number of the first line, counted from 1, that is neither field, constant, nor comment.
pub fn dependencies(text: &str, package: &str) -> Result<Vec<TypeName>, usize> {
    let mut found = Vec::new();
    for (index, line) in text.lines().enumerate() {
        let Some((field_type, rest)) = code(line) else { continue };
        if rest.is_empty() {
            return Err(index + 1);
        }
        let element = field_type.split(['[', '<']).next().unwrap_or(field_type);
        if BUILT_IN.contains(&element) {
            continue;
        }
        let full = match element {
            // The one type that older definitions name without its package.
            "Header" => "std_msgs/Header".to_owned(),
            bare if !bare.contains('/') => format!("{package}/{bare}"),
            full => full.to_owned(),
        };
        found.push(TypeName::parse(&full).ok_or(index + 1)?);
    }
    found.sort_unstable();
    found.dedup();
    Ok(found)
}

/// The first word of a line and what follows, without comment; `None` for an empty line.
fn code(line: &str) -> Option<(&str, &str)> {
    // A `#` within a string constant is cut off too, which leaves the constant a constant.
    let line = line.split('#').next().unwrap_or_default().trim();
    // `float64[ 3 ] x` is not valid, so the first space ends the type.
    let (field_type, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
    (!line.is_empty()).then_some((field_type, rest.trim()))
}

/// All that matters of a definition: its words, line by line.
pub fn essence(text: &str) -> Vec<Vec<&str>> {
    let lines = text.lines().map(|line| line.split('#').next().unwrap_or_default());
    lines
        .map(|line| line.split_whitespace().collect::<Vec<_>>())
        .filter(|words| !words.is_empty())
        .collect()
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
