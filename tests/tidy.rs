//! The house keeps its rules: who may depend on whom, and what no source may contain.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::iter;
use std::path::{Path, PathBuf};
use std::process::Command;

use rsrs_fleet::parameters::gate;
use rsrs_msgs::node_kind::NodeKind;
use rsrs_msgs::topics::{Durability, Qos, Reliability};
use serde_json::Value;

/// The crates that touch nothing outside their arguments, with their folders.
const PURE: [(&str, &str); 4] = [
    ("rsrs_core", "crates/rsrs_core/src"),
    ("rsrs_sim", "crates/rsrs_sim/src"),
    ("rsrs_fleet", "crates/rsrs_fleet/src"),
    ("rsrs_view", "crates/rsrs_view/src"),
];
/// What a pure crate must not reach, at any depth.
const IMPURE: [&str; 5] = ["rustdds", "ros2-client", "tokio", "mcap", "clap"];
/// What a pure crate must not name outside its tests: files, environment, clocks.
const AMBIENT: [&str; 4] = ["std::fs", "std::env", "std::time::Instant", "SystemTime::now"];
/// For each crate, the crates of ours that it may reach.
const ONE_WAY: [(&str, &[&str]); 16] = [
    ("rsrs_files", &[]),
    ("rsrs_core", &[]),
    ("rsrs_sim", &["rsrs_core"]),
    ("rsrs_fleet", &["rsrs_core", "rsrs_msgs"]),
    ("rsrs_view", &["rsrs_core"]),
    ("rsrs_msgs", &[]),
    ("rsrs_bags", &["rsrs_core", "rsrs_files", "rsrs_msgs"]),
    ("rsrs_keystore", &["rsrs_core", "rsrs_files", "rsrs_msgs"]),
    ("rsrs_ros", &["rsrs_core", "rsrs_files", "rsrs_fleet", "rsrs_keystore", "rsrs_msgs"]),
    (
        "rsrs_controller_node",
        &["rsrs_core", "rsrs_files", "rsrs_fleet", "rsrs_keystore", "rsrs_msgs", "rsrs_ros"],
    ),
    (
        "rsrs_robot_node",
        &[
            "rsrs_controller_node",
            "rsrs_core",
            "rsrs_files",
            "rsrs_fleet",
            "rsrs_keystore",
            "rsrs_msgs",
            "rsrs_ros",
        ],
    ),
    (
        "rsrs_sim_node",
        &[
            "rsrs_core",
            "rsrs_files",
            "rsrs_fleet",
            "rsrs_keystore",
            "rsrs_msgs",
            "rsrs_ros",
            "rsrs_sim",
        ],
    ),
    (
        "rsrs_experiment_runner",
        &[
            "rsrs_bags",
            "rsrs_core",
            "rsrs_files",
            "rsrs_fleet",
            "rsrs_keystore",
            "rsrs_msgs",
            "rsrs_ros",
        ],
    ),
    (
        "rsrs_pipeline",
        &["rsrs_bags", "rsrs_core", "rsrs_files", "rsrs_fleet", "rsrs_msgs", "rsrs_sim"],
    ),
    (
        "rsrs_render",
        &[
            "rsrs_bags",
            "rsrs_core",
            "rsrs_files",
            "rsrs_fleet",
            "rsrs_msgs",
            "rsrs_pipeline",
            "rsrs_sim",
            "rsrs_view",
        ],
    ),
    (
        "rsrs_operate",
        &[
            "rsrs_bags",
            "rsrs_core",
            "rsrs_files",
            "rsrs_experiment_runner",
            "rsrs_fleet",
            "rsrs_keystore",
            "rsrs_msgs",
            "rsrs_pipeline",
            "rsrs_render",
            "rsrs_ros",
            "rsrs_sim",
            "rsrs_view",
        ],
    ),
];
/// The rooms of the core, each of which names only those before it.
const CORE: [&str; 23] = [
    "bounds",
    "help",
    "natural_order",
    "numerals",
    "out_of_range",
    "plane",
    "digest",
    "draw",
    "document",
    "printable",
    "program",
    "statistics",
    "robot",
    "tracker",
    "quantity",
    "world",
    "judge",
    "trials",
    "conditions",
    "exploration",
    "capability",
    "diagram",
    "comparison",
];

#[test]
fn pure_crates_reach_no_middleware_runtime_recorder_or_argument_parser() {
    for (package, _) in PURE {
        let reached = reached_by(package);
        let wrong: Vec<_> = IMPURE.into_iter().filter(|name| reached.contains(*name)).collect();

        assert!(wrong.is_empty(), "{package} is pure and must not reach {wrong:?}");
    }
}

#[test]
fn the_analysis_and_its_words_need_no_middleware_and_no_runtime() {
    for package in ["rsrs_pipeline", "rsrs_render"] {
        let reached = reached_by(package);

        for name in ["rustdds", "ros2-client", "tokio", "openssl"] {
            assert!(!reached.contains(name), "{package} reaches {name}");
        }
    }
}

#[test]
fn the_steps_and_their_words_parse_no_arguments_and_print_nothing() {
    for name in ["rsrs_pipeline", "rsrs_render", "rsrs_operate"] {
        let folder = Path::new("crates").join(name);
        let manifest = text(&folder.join("Cargo.toml"));
        let wrong: Vec<_> =
            ["clap", "indicatif"].into_iter().filter(|name| manifest.contains(name)).collect();
        let mut sources = files();
        sources.retain(|file| file.starts_with(folder.join("src")));
        let prints = ["print!(", "println!(", "stdout()", "stderr()"];
        let printing: Vec<_> =
            sources.iter().flat_map(|file| lines_with(file, &text(file), &prints)).collect();

        assert!(wrong.is_empty(), "{name} must not name {wrong:?}");
        assert!(!sources.is_empty() && printing.is_empty(), "it prints:\n{}", printing.join("\n"));
    }
}

#[test]
fn the_crate_that_hides_the_middleware_does_reach_it() {
    let reached = reached_by("rsrs_ros");

    for name in ["rustdds", "ros2-client"] {
        assert!(reached.contains(name), "rsrs_ros does not reach {name}, found {reached:?}");
    }
}

#[test]
fn dependencies_point_one_way() {
    for (package, allowed) in ONE_WAY {
        let wrong: Vec<_> = reached_by(package)
            .into_iter()
            .filter(|name| name == "rsrs" || name.starts_with("rsrs_"))
            .filter(|name| name != package && !allowed.contains(&name.as_str()))
            .collect();

        assert!(wrong.is_empty(), "{package} may reach {allowed:?}, found also {wrong:?}");
    }
}

#[test]
fn rooms_of_the_core_name_only_those_before_them() {
    let rooms = named_modules(Path::new("crates/rsrs_core/src"));
    for (room, others) in &rooms[&Vec::new()] {
        let place = CORE.iter().position(|other| other == room);
        let place = place.unwrap_or_else(|| panic!("{room} has no place among {CORE:?}"));
        let wrong: Vec<_> =
            others.iter().filter(|other| !CORE[..place].contains(&other.as_str())).collect();

        assert!(wrong.is_empty(), "`{room}` names {wrong:?}, which do not come before it");
    }
}

#[test]
fn no_modules_name_each_other_in_a_circle() {
    let mut manifests = files();
    manifests.retain(|file| file.ends_with("Cargo.toml"));
    let folders = manifests.iter().map(|manifest| manifest.with_file_name("src"));
    let folders: Vec<PathBuf> = folders.filter(|folder| modules_of(folder).len() > 1).collect();
    assert!(folders.len() > 15, "found only {folders:?}");

    let mut circles = Vec::new();
    for folder in folders {
        for (parent, mut children) in named_modules(&folder) {
            // Those that name no other, and those that no other names, are taken away, until none or circles are left.
            loop {
                let before = children.len();
                let left: BTreeSet<String> = children.keys().cloned().collect();
                let named: BTreeSet<String> = children.values().flatten().cloned().collect();
                for others in children.values_mut() {
                    others.retain(|it| left.contains(it));
                }
                children.retain(|child, others| !others.is_empty() && named.contains(child));
                if children.len() == before {
                    break;
                }
            }
            if !children.is_empty() {
                circles.push(format!("{}: {}: {children:?}", folder.display(), parent.join("::")));
            }
        }
    }

    assert!(circles.is_empty(), "modules name each other in circles:\n{}", circles.join("\n"));
}

#[test]
fn paths_of_modules_are_found_however_they_are_written() {
    let code = "use crate::a::{b, c::{self, D as E}};\npub use super::{\n    e,\n    f::{G, H},\n};\nsuper::super::i::j()";

    let paths = paths_in(code, &["x", "y"].map(str::to_owned));

    let joined: Vec<String> = paths.iter().map(|path| path.join("::")).collect();
    assert_eq!(joined, ["a::b", "a::c", "a::c::D", "x::e", "x::f::G", "x::f::H", "i::j"]);
}

#[test]
fn names_that_a_parent_imports_are_those_of_its_children() {
    let path = |text: &str| -> ModulePath { text.split("::").map(str::to_owned).collect() };
    let modules = ["a", "a::b", "a::c"].map(path).into();
    let code = "pub mod b;\n\nuse std::fmt;\n\n#[cfg(unix)]\npub use b::{B, Wide as Narrow};\npub(crate) use self::c::made;";

    let imports = BTreeMap::from([(path("a"), imports_in(code, &path("a"), &modules))]);

    for (written, expected) in [
        ("a::B::new", &["a::B::new", "a::b::B::new"][..]),
        ("a::Narrow", &["a::Narrow", "a::b::Wide"]),
        ("a::made", &["a::made", "a::c::made"]),
        ("a::fmt", &["a::fmt"]),
        ("a::b::B", &["a::b::B"]),
    ] {
        let found = followed(path(written), &imports, &modules);
        assert_eq!(found, expected.iter().map(|it| path(it)).collect::<Vec<_>>());
    }
}

#[test]
fn no_command_uses_another_and_nothing_below_uses_any() {
    let commands = Path::new("crates/rsrs/src/commands");
    let mut sources = files();
    sources.retain(|file| file.starts_with("crates/rsrs/src") && !file.ends_with("main.rs"));
    let of_command = |file: &Path| {
        let first = file.strip_prefix(commands).ok()?.iter().next()?.to_str()?;
        Some(first.trim_end_matches(".rs").to_owned())
    };
    let names: BTreeSet<String> = sources.iter().filter_map(|file| of_command(file)).collect();
    assert!(names.contains("run") && names.contains("sweep"), "found only {names:?}");

    for file in sources {
        let own = of_command(&file);
        let is_below = own.is_none() && file != Path::new("crates/rsrs/src/commands.rs");
        let wrong: Vec<String> = names
            .iter()
            .filter(|name| own.as_ref() != Some(*name))
            .flat_map(|name| ["::", ";"].map(|end| format!("crate::commands::{name}{end}")))
            .chain(is_below.then(|| "crate::commands".to_owned()))
            .filter(|path| text(&file).contains(path))
            .collect();

        assert!(
            wrong.is_empty(),
            "{file:?} uses {wrong:?}: what is shared belongs beside commands"
        );
    }
}

#[test]
fn only_one_manifest_names_the_middleware() {
    let names_it = |file: &PathBuf| {
        text(file)
            .lines()
            .any(|line| line.starts_with("rustdds") || line.starts_with("ros2-client"))
    };
    let mut manifests = files();
    manifests.retain(|file| file.ends_with("Cargo.toml") && file != Path::new("Cargo.toml"));

    manifests.retain(names_it);

    assert_eq!(manifests, [Path::new("crates/rsrs_ros/Cargo.toml")]);
}

#[test]
fn pure_crates_name_no_file_environment_or_clock() {
    for (package, folder) in PURE {
        let wrong = ambient_lines(folder);

        assert!(wrong.is_empty(), "{package} is pure and must not name:\n{}", wrong.join("\n"));
    }
}

#[test]
fn the_search_for_ambient_names_finds_them_where_they_are() {
    let found = ambient_lines("crates/rsrs_ros/src");

    assert!(found.iter().any(|line| line.contains("std::env")), "found only {found:?}");
}

#[test]
fn no_source_contains_what_nobody_should_commit() {
    // In two pieces, so that this file does not contain them either.
    let tests_and_seams = [concat!("#[", "ignore"), concat!("todo", "!(")];
    let paths_of_a_machine = [concat!("/wo", "rk/"), concat!("/ro", "ot/"), concat!("/ho", "me/")];
    let unwelcome = [&tests_and_seams[..], &paths_of_a_machine[..]].concat();

    let wrong: Vec<_> =
        files().iter().flat_map(|file| lines_with(file, &text(file), &unwelcome)).collect();

    assert!(wrong.is_empty(), "ignored tests, seams or paths:\n{}", wrong.join("\n"));
}

#[test]
fn the_map_of_the_project_names_files_that_exist() {
    let map = text(Path::new("ARCHITECTURE.md"));
    let missing: Vec<_> = map
        .split('`')
        .skip(1)
        .step_by(2)
        .filter(|name| name.contains('/') && !name.contains('{') && !root().join(name).exists())
        .collect();

    assert!(missing.is_empty(), "ARCHITECTURE.md names files that are not there: {missing:?}");
}

#[test]
fn workspaces_of_their_own_are_built_of_the_versions_of_the_workspace() {
    let locked = |file: &str| -> BTreeSet<(String, String)> {
        let text = text(Path::new(file));
        let packages = text.split("[[package]]").skip(1);
        let of = |package: &str, key: &str| {
            let line = package.lines().find_map(|line| line.strip_prefix(key).map(str::to_owned));
            line.expect("every package has a name and a version")
        };
        packages.map(|package| (of(package, "name = "), of(package, "version = "))).collect()
    };
    let workspace = locked("Cargo.lock");
    let names: BTreeSet<&String> = workspace.iter().map(|(name, _)| name).collect();
    for file in ["page/Cargo.lock", "python/Cargo.lock"] {
        let package = locked(file);

        let others: Vec<_> =
            package.difference(&workspace).filter(|(name, _)| names.contains(name)).collect();

        assert!(others.is_empty(), "{file} has other versions of {others:#?}");
    }
}

#[test]
fn the_page_of_the_interface_has_every_topic_as_the_table_has_it_and_no_other() {
    let page = text(Path::new("docs/ros_interface.md"));
    let of_topics = |row: &&str| row.starts_with("| `") && row.contains("/msg/");
    let rows: Vec<&str> = page.lines().filter(of_topics).collect();
    for topic in rsrs_msgs::topics::ALL {
        let Qos { reliability, durability, depth } = topic.qos;
        let reliability = match reliability {
            Reliability::Reliable => "reliable",
            Reliability::BestEffort => "best effort",
        };
        let durability = match durability {
            Durability::Volatile => "",
            Durability::TransientLocal => ", transient local",
        };
        let [from, to] = [topic.publishers, topic.subscribers].map(|nodes| {
            let names: Vec<String> = nodes.iter().map(ToString::to_string).collect();
            if nodes == NodeKind::ALL { "all".to_owned() } else { names.join(", ") }
        });
        let row = format!(
            "| `{}` | `{}` | {reliability}{durability}, {depth} | {from} | {to} | ",
            topic.name, topic.type_name
        );
        let found = rows.iter().filter(|found| found.starts_with(&row)).count();
        assert_eq!(found, 1, "rows of docs/ros_interface.md with {row}");
    }
    assert_eq!(rows.len(), rsrs_msgs::topics::ALL.len(), "docs/ros_interface.md has other topics");
}

#[test]
fn the_page_of_the_interface_has_every_service_and_no_other() {
    let page = text(Path::new("docs/ros_interface.md"));
    let offered = page.lines().find(|line| line.starts_with("The simulator also has, of `sim"));
    let named = offered.expect("it has a line of them").split('`').skip(1).step_by(2).skip(1);

    assert_eq!(named.collect::<Vec<_>>(), rsrs_msgs::simulation_interfaces::SERVICES);
}

#[test]
fn the_page_of_drivers_has_every_parameter_of_a_gate_as_the_table_has_it_and_no_other() {
    let page = text(Path::new("docs/robot_drivers.md"));
    let parts = page.split("\n## Parameters\n").nth(1).expect("it has a part of them");
    let part = parts.split("\n## ").next().expect("a part has text");
    let mut named = BTreeSet::new();
    for row in part.lines().filter(|line| line.starts_with("| `")) {
        let mut cells = row.trim_matches('|').split('|').map(str::trim);
        let [names, units, defaults, more] = std::array::from_fn(|_| cells.next().expect(row));
        for (name, unit) in names.split(", ").zip(units.split(", ").chain(iter::repeat(""))) {
            let name = name.trim_matches('`');
            named.insert(name.to_owned());
            let Some(number) = gate::number(name) else { continue };
            assert_eq!(unit, number.unit, "{row}");
            let mut numbers = defaults.split([' ', ',', ';']).filter_map(|word| word.parse().ok());
            assert!(numbers.any(|found: f64| found.total_cmp(&number.usual).is_eq()), "{row}");
            assert_eq!(more.contains("read-only"), number.read_only, "{row}");
        }
    }

    let parameters: BTreeSet<String> = gate::names().into_iter().map(str::to_owned).collect();
    assert_eq!(named, parameters);
}

#[test]
fn what_the_walks_name_exists() {
    let map = text(Path::new("ARCHITECTURE.md"));
    let walks = map.split("\n## ").find(|part| part.starts_with("Three walks"));
    let walks = walks.expect("the map has walks");
    let named: Vec<&str> = walks.split('`').skip(1).step_by(2).collect();
    let sources: Vec<(PathBuf, String)> =
        sources().map(|file| (file.clone(), text(&file))).collect();
    let says = |text: &str, words: &str| {
        text.match_indices(words).any(|(at, words)| {
            let after = text[at + words.len()..].chars().next();
            after.is_none_or(|after| !after.is_alphanumeric() && after != '_')
        })
    };
    // What is named with its room or type is in a file of that room, or beside what that type does.
    let is_in = |(file, text): &(PathBuf, String), room: &str| {
        let room = room.strip_prefix("rsrs_").unwrap_or(room);
        let mut parts = file.iter().filter_map(|part| part.to_str());
        parts.any(|part| part.trim_end_matches(".rs").trim_start_matches("rsrs_") == room)
            || says(text, &format!("impl {room}"))
    };
    let is_there = |name: &str| {
        let (room, last) = name.rsplit_once("::").unwrap_or(("", name));
        let room = room.rsplit("::").next().unwrap_or(room);
        sources.iter().filter(|source| room.is_empty() || is_in(source, room)).any(|(_, text)| {
            ["fn", "struct", "mod"].iter().any(|kind| says(text, &format!("{kind} {last}")))
        })
    };
    let missing: Vec<&&str> =
        named.iter().filter(|name| !name.contains('/') && !is_there(name)).collect();

    assert!(named.len() > 20, "found only {named:?}");
    assert!(missing.is_empty(), "the walks name what is not there: {missing:?}");
}

#[test]
fn every_test_that_the_list_of_invariants_names_exists() {
    let paths: Vec<PathBuf> = sources().collect();
    let code: String = paths.iter().map(|file| text(file)).collect();
    let list = text(Path::new("tests/README.md"));
    let (_, invariants) = list.split_once("\n## Invariants").expect("the list has invariants");
    let laws = invariants.lines().filter(|line| line.starts_with("- "));
    let named: Vec<&str> = laws
        .map(|law| law.rsplit_once(": ").map_or("", |(_, tests)| tests))
        .flat_map(|tests| tests.split('`').skip(1).step_by(2))
        .collect();

    // A file goes by the end of its path.
    let has_tests = |text: String| ["#[test]", "#[tokio::test"].iter().any(|it| text.contains(it));
    let is_there = |name: &str| {
        if Path::new(name).extension().is_some_and(|end| end == "rs") {
            paths.iter().any(|path| path.ends_with(name) && has_tests(text(path)))
        } else {
            code.contains(&format!("fn {name}("))
        }
    };
    let missing: Vec<_> = named.iter().filter(|name| !is_there(name)).collect();

    assert!(named.len() > 250, "found only {} tests in the list", named.len());
    assert!(missing.is_empty(), "tests/README.md names tests that are not there: {missing:#?}");
}

#[test]
fn every_test_is_in_one_tier() {
    let tiers = text(Path::new(".ci/tier"));
    let packages = |tier: &str| -> Vec<&str> {
        let list = tiers.lines().find_map(|line| line.strip_prefix(tier)?.strip_prefix("=("));
        list.expect("it is there")
            .trim_end_matches(')')
            .split("-p ")
            .skip(1)
            .map(str::trim)
            .collect()
    };
    let [pure, nodes] = ["pure", "nodes"].map(packages);
    let mut cargo = Command::new(env!("CARGO"));
    cargo.args(["metadata", "--no-deps", "--offline", "--format-version", "1"]);
    let output = cargo.current_dir(root()).output().expect("the cargo that built this starts");
    let metadata: Value = serde_json::from_slice(&output.stdout).expect("cargo writes JSON");

    for package in metadata["packages"].as_array().expect("the workspace has packages") {
        let name = package["name"].as_str().expect("it is a text");
        let targets = package["targets"].as_array().expect("it has targets").iter();
        let tested = targets.filter(|target| target["test"] == true || target["doctest"] == true);
        let tested: Vec<(&str, &str)> = tested
            .filter_map(|target| Some((target["kind"][0].as_str()?, target["name"].as_str()?)))
            .collect();

        // What `.ci/tier` runs of a package.
        let n_tiers = [&pure, &nodes].iter().filter(|tier| tier.contains(&name)).count();
        let is_run = match name {
            "rsrs" => {
                n_tiers == 0
                    && tested.iter().all(|it| [("bin", "rsrs"), ("test", "rsrs")].contains(it))
            }
            "rsrs_testing" => n_tiers == 0 && tested == [("test", "install")],
            _ if pure.contains(&name) => {
                n_tiers == 1 && tested.iter().all(|(kind, _)| ["lib", "test"].contains(kind))
            }
            _ => n_tiers == usize::from(!tested.is_empty()),
        };
        assert!(is_run, "{name}: {tested:?} are not all in one tier of .ci/tier");
    }
}

/// All code in Rust.
fn sources() -> impl Iterator<Item = PathBuf> {
    files().into_iter().filter(|file| file.extension().is_some_and(|end| end == "rs"))
}

/// The names of all packages that a package reaches by normal dependencies, itself included.
///
/// The registry is asked only when the local cache does not have a package for another platform.
fn reached_by(package: &str) -> BTreeSet<String> {
    let tree = |more: &[&str]| {
        let mut cargo = Command::new(env!("CARGO"));
        cargo.args(["tree", "--package", package, "--edges", "normal", "--prefix", "none"]);
        cargo.args(more).current_dir(root()).output().expect("the cargo that built this starts")
    };

    let offline = tree(&["--offline"]);
    let output = if offline.status.success() { offline } else { tree(&[]) };

    assert!(output.status.success(), "cargo tree: {}", String::from_utf8_lossy(&output.stderr));
    let names = String::from_utf8_lossy(&output.stdout);
    names.lines().filter_map(|line| line.split_whitespace().next()).map(str::to_owned).collect()
}

/// A module, by its names from the crate's root.
type ModulePath = Vec<String>;

/// Names of a module, each with the path that it imports under it.
type Imports = BTreeMap<String, ModulePath>;

/// The files of a crate's modules, of which the root, that of its library if it has one, has no names.
fn modules_of(sources: &Path) -> BTreeMap<ModulePath, PathBuf> {
    let module = |file: PathBuf| {
        let inner = file.strip_prefix(sources).ok()?.with_extension("");
        let path: ModulePath =
            inner.iter().map(|part| part.to_string_lossy().into_owned()).collect();
        match path[0].as_str() {
            "bin" => None,
            "lib" | "main" => Some((Vec::new(), file)),
            _ => Some((path, file)),
        }
    };
    // Of two roots the later one stays.
    files().into_iter().rev().filter_map(module).collect()
}

/// For each module of a crate that has some, its children, each with the siblings that it and those below it
/// name outside comments and unit tests, be it by what a module above imports of them.
fn named_modules(sources: &Path) -> BTreeMap<ModulePath, BTreeMap<String, BTreeSet<String>>> {
    let files = modules_of(sources);
    let modules: BTreeSet<ModulePath> = files.keys().cloned().collect();
    let code: BTreeMap<&ModulePath, String> =
        files.iter().map(|(module, file)| (module, code_of(file))).collect();
    let imports: BTreeMap<ModulePath, Imports> = code
        .iter()
        .map(|(module, code)| ((*module).clone(), imports_in(code, module, &modules)))
        .collect();
    let mut named: BTreeMap<ModulePath, BTreeMap<String, BTreeSet<String>>> = BTreeMap::new();
    for (module, code) in code {
        let Some((name, parent)) = module.split_last() else { continue };
        named.entry(parent.to_vec()).or_default().entry(name.clone()).or_default();
        let paths = paths_in(&code, module).into_iter();
        for path in paths.flat_map(|path| followed(path, &imports, &modules)) {
            let together = path.iter().zip(module).take_while(|(one, other)| one == other).count();
            let (Some(other), Some(own)) = (path.get(together), module.get(together)) else {
                continue;
            };
            if modules.contains(&path[..=together]) {
                let siblings = named.entry(module[..together].to_vec()).or_default();
                siblings.entry(own.clone()).or_default().insert(other.clone());
            }
        }
    }
    named
}

/// A source without its unit tests and lines of comments.
fn code_of(file: &Path) -> String {
    let whole = text(file);
    let code = whole.split("mod tests {").next().unwrap_or_default();
    let lines = code.lines().filter(|line| !line.trim_start().starts_with("//"));
    lines.collect::<Vec<_>>().join("\n")
}

/// What a module imports of its own crate.
fn imports_in(code: &str, module: &[String], modules: &BTreeSet<ModulePath>) -> Imports {
    let mut imports = Imports::new();
    for statement in code.split(';') {
        let Some((before, tree)) = statement.rsplit_once("use ") else { continue };
        let before = before.rsplit('\n').next().unwrap_or_default();
        if !before.is_empty() && !before.starts_with("pub") {
            continue;
        }
        for (path, name) in expanded(tree) {
            let first = path.split("::").next().unwrap_or_default();
            let is_own = ["crate", "super", "self"].contains(&first)
                || modules.contains(&absolute(first, module));
            if is_own {
                imports.insert(name, absolute(&path, module));
            }
        }
    }
    imports
}

/// A path and, as long as a module on it imports its next name, the path that this stands for.
fn followed(
    path: ModulePath,
    imports: &BTreeMap<ModulePath, Imports>,
    modules: &BTreeSet<ModulePath>,
) -> Vec<ModulePath> {
    let next = |path: &ModulePath| {
        // The first name on it that is of no module.
        let end = (0..path.len()).find(|end| !modules.contains(&path[..=*end]))?;
        let imported = imports.get(&path[..end])?.get(&path[end])?;
        Some([imported.as_slice(), &path[end + 1..]].concat())
    };
    iter::successors(Some(path), next).collect()
}

/// The paths that begin with `crate` or `super` in the code of a module, from the crate's root.
fn paths_in(code: &str, module: &[String]) -> Vec<ModulePath> {
    let mut paths = Vec::new();
    let mut rest = code;
    while let Some(at) = rest.find("crate::").into_iter().chain(rest.find("super::")).min() {
        rest = &rest[at..];
        let is_of_path = |letter: char| letter.is_alphanumeric() || "_:".contains(letter);
        let mut end = rest.find(|letter| !is_of_path(letter)).unwrap_or(rest.len());
        if rest[..end].ends_with("::") && rest[end..].starts_with('{') {
            end = rest.find(';').unwrap_or(rest.len());
        }
        paths.extend(expanded(&rest[..end]).iter().map(|(path, _)| absolute(path, module)));
        rest = &rest[end..];
    }
    paths
}

/// The paths of a tree as `use` has them, each with the name that it imports.
fn expanded(tree: &str) -> Vec<(String, String)> {
    let Some((head, list)) = tree.split_once('{') else {
        let (path, name) = tree.split_once(" as ").unwrap_or((tree, tree));
        let path = path.trim();
        let name = name.trim().trim_end_matches("::self").rsplit("::").next().unwrap_or_default();
        return vec![(path.to_owned(), name.to_owned())];
    };
    let mut depth = 1;
    let entries = list.split(|letter| {
        depth += i32::from(letter == '{') - i32::from(letter == '}');
        depth == 0 || (depth == 1 && letter == ',')
    });
    entries
        .filter(|entry| !entry.trim().is_empty())
        .flat_map(|entry| expanded(&format!("{}{}", head.trim(), entry.trim())))
        .collect()
}

/// A path in the code of a module, from the crate's root.
fn absolute(path: &str, module: &[String]) -> ModulePath {
    let mut absolute = module.to_vec();
    for name in path.split("::") {
        match name {
            "crate" => absolute.clear(),
            "super" => _ = absolute.pop(),
            "self" | "" => {}
            name => absolute.push(name.to_owned()),
        }
    }
    absolute
}

/// Lines of code outside comments and unit tests that name a file, the environment or a clock.
fn ambient_lines(folder: &str) -> Vec<String> {
    let sources: Vec<_> = files().into_iter().filter(|file| file.starts_with(folder)).collect();
    assert!(!sources.is_empty(), "{folder} has no sources");

    sources
        .iter()
        .flat_map(|file| {
            let whole = text(file);
            let code = whole.split("#[cfg(test)]\nmod tests").next().unwrap_or_default();
            lines_with(file, code, &AMBIENT)
        })
        .filter(|line| !line.split_once(": ").is_some_and(|(_, code)| code.starts_with("//")))
        .collect()
}

/// `file:line: text` of each line with one of the fragments.
fn lines_with(file: &Path, text: &str, fragments: &[&str]) -> Vec<String> {
    text.lines()
        .enumerate()
        .filter(|(_, line)| fragments.iter().any(|fragment| line.contains(fragment)))
        .map(|(row, line)| format!("{}:{}: {}", file.display(), row + 1, line.trim()))
        .collect()
}

/// Every file of the project that a person writes, relative to the root, sorted.
fn files() -> Vec<PathBuf> {
    let ends = ["rs", "toml", "yaml", "md", "py", "msg", "xml", "txt"];
    let mut found = vec![PathBuf::from(".ci/run")];
    let mut folders = vec![root()];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder).expect("a folder of the project can be listed") {
            let path = entry.expect("an entry of a folder can be read").path();
            let name = path.file_name().expect("an entry has a name").to_string_lossy();
            let built = name.starts_with('.') || name.starts_with("target") || name == "results";
            if path.is_dir() && !built {
                folders.push(path);
            } else if path.extension().is_some_and(|end| ends.iter().any(|known| end == *known)) {
                found.push(path.strip_prefix(root()).expect("the root came first").to_owned());
            }
        }
    }
    found.sort();
    found
}

fn text(file: &Path) -> String {
    fs::read_to_string(root().join(file)).expect("a source of the project is text")
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../..")
        .canonicalize()
        .expect("the workspace exists")
}
