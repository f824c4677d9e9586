//! The `ros2msg` text and the RIHS01 hash of a type, as bags want them.
//!
//! A bag carries the definition of every type in it, so that it can be read on a machine that has
//! none of the packages; the hash lets ROS tell two versions of one type apart.

mod definitions;

use definitions::{DEFINITIONS, Definition};

/// What rosbag2 puts between two definitions.
const DELIMITER: &str =
    "================================================================================";

/// The definition of a type and of all types in it, in the format that bags call `ros2msg`.
///
/// The type's own definition comes first, then each type it needs, once, depth first and sorted by
/// name, behind a line of 80 `=` and a line `MSG: package/Type`; this is what rosbag2 writes.
///
/// # Arguments
///
/// * `type_name` — a full name such as `nav_msgs/msg/Odometry`.
///
/// # Returns
///
/// `None` for a type that this crate does not define.
///
/// # Example
///
/// ```
/// let text = rsrs_msgs::schema::schema_text("rosgraph_msgs/msg/Clock").expect("it is ours");
/// assert!(text.starts_with("builtin_interfaces/Time clock\n"));
/// assert!(text.ends_with("MSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n"));
/// ```
pub fn schema_text(type_name: &str) -> Option<String> {
    let root = find(type_name)?;
    let mut text = root.text.to_owned();
    let mut seen = vec![root.type_name.to_owned()];
    append_dependencies(root, &mut seen, &mut text);
    Some(text)
}

/// The hash of a type by REP 2016, `RIHS01_` and 64 hexadecimal digits.
///
/// # Returns
///
/// `None` for a type that this crate does not define.
pub fn type_hash(type_name: &str) -> Option<&'static str> {
    find(type_name).map(|definition| definition.hash)
}

/// The full names of all types that have a schema, sorted.
pub fn type_names() -> impl Iterator<Item = &'static str> {
    DEFINITIONS.iter().map(|definition| definition.type_name)
}

fn find(type_name: &str) -> Option<&'static Definition> {
    DEFINITIONS.iter().find(|definition| definition.type_name == type_name)
}

fn append_dependencies(of: &Definition, seen: &mut Vec<String>, text: &mut String) {
    for dependency in dependencies(of) {
        let type_name = dependency.replacen('/', "/msg/", 1);
        if seen.contains(&type_name) {
            continue;
        }
        let definition = find(&type_name).expect("a test closes the table under dependencies");
        for part in ["\n", DELIMITER, "\nMSG: ", &dependency, "\n", definition.text] {
            text.push_str(part);
        }
        seen.push(type_name);
        append_dependencies(definition, seen, text);
    }
}

/// The types of the fields of one definition that are not built in, as `package/Type`; sorted, each
/// once.
fn dependencies(of: &Definition) -> Vec<String> {
    let mut dependencies: Vec<String> = of
        .text
        .lines()
        .filter_map(|line| line.split('#').next().and_then(|code| code.split_whitespace().next()))
        .map(|field_type| field_type.split(['[', '<']).next().unwrap_or(field_type))
        .filter(|field_type| field_type.contains('/'))
        .map(str::to_owned)
        .collect();
    dependencies.sort_unstable();
    dependencies.dedup();
    dependencies
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_is_sorted_and_closed_under_dependencies() {
        assert!(DEFINITIONS.is_sorted_by_key(|definition| definition.type_name));
        for definition in DEFINITIONS {
            for dependency in dependencies(definition) {
                assert!(find(&dependency.replacen('/', "/msg/", 1)).is_some(), "{dependency}");
            }
        }
    }

    #[test]
    fn the_types_of_one_package_are_written_with_their_package() {
        // `dependencies` knows no package context, so a bare `Vector3` would be lost.
        const BUILT_IN: [&str; 15] = [
            "bool", "byte", "char", "float32", "float64", "int8", "uint8", "int16", "uint16",
            "int32", "uint32", "int64", "uint64", "string", "wstring",
        ];

        for definition in DEFINITIONS {
            for line in definition.text.lines() {
                let code = line.split('#').next().unwrap();
                let Some(field_type) = code.split_whitespace().next() else { continue };
                let name = field_type.split(['[', '<']).next().unwrap();
                assert!(name.contains('/') || BUILT_IN.contains(&name), "{line}");
            }
        }
    }

    #[test]
    fn dependencies_follow_depth_first_sorted_and_once() {
        let text = schema_text("nav_msgs/msg/Odometry").unwrap();

        let order: Vec<&str> = text.lines().filter_map(|line| line.strip_prefix("MSG: ")).collect();

        let expected = [
            "geometry_msgs/PoseWithCovariance",
            "geometry_msgs/Pose",
            "geometry_msgs/Point",
            "geometry_msgs/Quaternion",
            "geometry_msgs/TwistWithCovariance",
            "geometry_msgs/Twist",
            "geometry_msgs/Vector3",
            "std_msgs/Header",
            "builtin_interfaces/Time",
        ];
        assert_eq!(order, expected);
    }

    #[test]
    fn a_type_that_is_not_ours_has_neither_text_nor_hash() {
        assert_eq!(schema_text("std_msgs/msg/Nothing"), None);
        assert_eq!(type_hash("std_msgs/msg/Nothing"), None);
    }
}
