//! Definitions of types out of prefixes as ROS 2 installs them, such as `AMENT_PREFIX_PATH` lists.

use std::fs;
use std::path::{Path, PathBuf};

use rsrs_bags::definitions::{Definition, DefinitionError, Definitions};
use rsrs_core::help::Help;

use crate::recording::damage::temporary;

fn write(folder: &Path, name: &str, text: &str) {
    let path = folder.join(name);
    fs::create_dir_all(path.parent().expect("it is in a folder")).expect("it is writable");
    fs::write(path, text).expect("it is writable");
}

/// Installs a package of messages as `colcon build` and the packages of a distribution do: what is
/// made of the messages stands beside their `.msg` files.
fn install(prefix: &Path, package: &str, messages: &[(&str, &str)]) {
    let resources = "share/ament_index/resource_index";
    write(prefix, &format!("{resources}/packages/{package}"), "");
    let names: Vec<String> = messages
        .iter()
        .flat_map(|(name, _)| [format!("msg/{name}.idl"), format!("msg/{name}.msg")])
        .collect();
    write(prefix, &format!("{resources}/rosidl_interfaces/{package}"), &names.join("\n"));
    write(prefix, &format!("share/{package}/package.xml"), "<package format=\"3\"/>");
    for (name, text) in messages {
        write(prefix, &format!("share/{package}/msg/{name}.msg"), text);
        write(prefix, &format!("share/{package}/msg/{name}.idl"), "module made { };");
    }
}

/// A distribution, and a workspace on top of it that uses a package of the distribution.
fn prefixes(folder: &Path) -> Vec<PathBuf> {
    let (workspace, distribution) = (folder.join("ws/install/lab_msgs"), folder.join("opt/ros/x"));
    install(
        &workspace,
        "lab_msgs",
        &[
            ("Battery", "std_msgs/Header header\npower_msgs/Cell[] cells\nfloat32 voltage_v\n"),
            ("Broken", "float32 voltage_v\nthis is no field at all\n"),
            ("Orphan", "nowhere_msgs/Part part\n"),
        ],
    );
    install(
        &distribution,
        "power_msgs",
        &[
            ("Cell", "uint32 number\nChemistry chemistry\n"),
            ("Chemistry", "uint8 LIPO=1\nuint8 kind\n"),
        ],
    );
    // The same package below, which the workspace overlays.
    install(&distribution, "lab_msgs", &[("Battery", "float32 older\n")]);
    vec![workspace, distribution]
}

#[test]
fn a_type_of_an_installed_package_comes_with_those_of_other_prefixes() {
    let folder = temporary();
    let definitions = Definitions::new(prefixes(folder.path()));

    let battery = definitions.find("lab_msgs/msg/Battery").unwrap();

    let line = "=".repeat(80);
    let parts: Vec<&str> = battery.text.split(&format!("\n{line}\n")).collect();
    assert!(parts[0].contains("float32 voltage_v"), "the workspace lies on top: {}", parts[0]);
    let named: Vec<&str> = parts[1..].iter().map(|part| part.lines().next().unwrap()).collect();
    let expected = [
        "MSG: power_msgs/Cell",
        "MSG: power_msgs/Chemistry",
        "MSG: std_msgs/Header",
        "MSG: builtin_interfaces/Time",
    ];
    assert_eq!(named, expected);
    assert!(battery.type_hash.unwrap().starts_with("RIHS01_"));
    let stock = Definitions::new(Vec::new()).find("nav_msgs/msg/Odometry").unwrap();
    assert_eq!(Some(stock), Definition::of_known_type("nav_msgs/msg/Odometry"));
}

#[test]
fn a_type_that_is_in_no_prefix_is_named_with_where_it_was_looked_for() {
    let folder = temporary();
    let prefixes = prefixes(folder.path());
    let definitions = Definitions::new(prefixes.clone());

    let missing = definitions.find("lab_msgs/msg/Wheel").unwrap_err();
    let orphan = definitions.find("lab_msgs/msg/Orphan").unwrap_err();

    let searched: Vec<String> =
        prefixes.iter().map(|prefix| prefix.display().to_string()).collect();
    let searched = searched.join(", ");
    assert_eq!(missing.to_string(), format!("no file lab_msgs/msg/Wheel.msg in {searched}"));
    assert!(missing.help().unwrap().contains("/opt/ros/jazzy"));
    assert_eq!(
        orphan.to_string(),
        format!("no file nowhere_msgs/msg/Part.msg in {searched}, needed by lab_msgs/msg/Orphan")
    );
}

#[test]
fn a_definition_that_is_none_is_named_with_file_and_line() {
    let folder = temporary();
    let definitions = Definitions::new(prefixes(folder.path()));

    let error = definitions.find("lab_msgs/msg/Broken").unwrap_err();

    let no_name = definitions.find("Battery").unwrap_err();
    assert!(matches!(no_name, DefinitionError::TypeName { .. }), "{no_name}");
    let DefinitionError::Syntax { path, line, found } = error else { panic!("{error}") };
    assert!(path.ends_with("share/lab_msgs/msg/Broken.msg"), "{}", path.display());
    assert_eq!((line, found.as_str()), (2, "this is no field at all"));
}
