//! The `ros2msg` text and the RIHS01 hash of a type, as bags want them.
//!
//! A bag carries the definition of every type in it, so that it can be read on a machine that has
//! none of the packages; by the hash ROS distinguishes two versions of one type.

mod definitions;
mod fields;
mod hash;

use definitions::{DEFINITIONS, Definition};
pub use fields::{TypeName, dependencies};
pub use hash::rihs01;

/// What rosbag2 puts between two definitions.
const DELIMITER: &str =
    "================================================================================";

/// The definition of a type, such as `nav_msgs/msg/Odometry`, and of all types in it, in the format
/// that bags call `ros2msg`; `None` for a type that this crate does not define.
///
/// The type's own definition comes first, then each type it needs, once, depth first and sorted by
/// name, behind a line of 80 `=` and a line `MSG: package/Type`; this is what rosbag2 writes.
///
/// # Example
///
/// ```
/// let text = rsrs_msgs::schema::schema_text("rosgraph_msgs/msg/Clock").expect("it is ours");
/// assert!(text.starts_with("builtin_interfaces/Time clock\n"));
/// assert!(text.ends_with("MSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n"));
/// ```
pub fn schema_text(type_name: &str) -> Option<String> {
    let package = type_name.split('/').next()?;
    // A test closes the table under dependencies.
    let text_of = |known: &TypeName| own_text(&known.to_string()).unwrap_or_default();
    Some(with_dependencies(own_text(type_name)?, package, &text_of))
}

/// The definition of a type alone; `None` for a type that this crate does not define.
pub fn own_text(type_name: &str) -> Option<&'static str> {
    find(type_name).map(|definition| definition.text)
}

/// The hash of a type by REP 2016, `RIHS01_` and 64 hexadecimal digits; `None` for a type that this
/// crate does not define.
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

/// The definition of a type of a package, and behind it those of all types in it, as bags keep
/// them; `text_of` has the own definition of each, at whatever depth.
///
/// Each type comes once, depth first and sorted by name, behind a line of 80 `=` and a line
/// `MSG: package/Type`; this is what rosbag2 writes.
///
/// # Panics
///
/// If [`dependencies`] refuses one of the definitions.
pub fn with_dependencies<'a>(
    text: &str,
    package: &str,
    text_of: &dyn Fn(&TypeName) -> &'a str,
) -> String {
    let mut joined = text.to_owned();
    append_dependencies(text, package, text_of, &mut Vec::new(), &mut joined);
    joined
}

fn append_dependencies<'a>(
    text: &str,
    package: &str,
    text_of: &dyn Fn(&TypeName) -> &'a str,
    seen: &mut Vec<TypeName>,
    joined: &mut String,
) {
    for dependency in dependencies(text, package).expect("definitions are parsed before") {
        if seen.contains(&dependency) {
            continue;
        }
        let TypeName { package, name } = &dependency;
        let own = text_of(&dependency);
        for part in ["\n", DELIMITER, "\nMSG: ", package, "/", name, "\n", own] {
            joined.push_str(part);
        }
        seen.push(dependency.clone());
        append_dependencies(own, package, text_of, seen, joined);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_is_sorted_and_closed_under_dependencies() {
        assert!(DEFINITIONS.is_sorted_by_key(|definition| definition.type_name));
        for definition in DEFINITIONS {
            let package = definition.type_name.split('/').next().unwrap();
            for dependency in dependencies(definition.text, package).unwrap() {
                assert!(find(&dependency.to_string()).is_some(), "{dependency}");
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
}
