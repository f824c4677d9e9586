//! The reference of all keys: as the repository has it, and as another implementation of JSON Schema
//! understands it.

use std::path::Path;
use std::process::Command;

use rsrs_testing::python;

use crate::command::{code, repository, rsrs, stderr, stdout};

/// Kinds of files, and where the repository has some: folders, or a single one.
const FILES: [(&str, &str); 10] = [
    ("controller", "launch_configs/controllers"),
    ("world", "launch_configs/worlds"),
    ("profile", "launch_configs/profiles"),
    ("fleet", "launch_configs/fleets"),
    ("sweep", "launch_configs/sweeps"),
    ("experiment", "launch_configs/experiments"),
    ("campaign", "launch_configs/campaigns"),
    ("fleet", "docs/examples/mujoco/fleet.yaml"),
    ("sweep", "docs/examples/mujoco/sweep.yaml"),
    ("experiment", "docs/examples/mujoco/experiment.yaml"),
];

#[test]
fn the_reference_in_the_repository_is_the_one_that_the_program_prints() {
    let printed = rsrs(&repository(), &["schema", "--reference"]);

    let written =
        std::fs::read_to_string(repository().join("docs/reference.md")).expect("it is there");
    assert!(
        written == stdout(&printed),
        "docs/reference.md is not up to date: rsrs schema --reference > docs/reference.md"
    );
}

#[test]
fn every_shipped_file_meets_its_schema_and_a_wrong_key_does_not() {
    let place = tempfile::tempdir().expect("a temporary folder");
    for (kind, _) in FILES {
        let printed = rsrs(place.path(), &["schema", kind]);
        assert_eq!(code(&printed), 0, "{}", stderr(&printed));
        std::fs::write(place.path().join(kind), printed.stdout).expect("the folder is writable");
    }
    let python = python::python_with(&python::DEPLOYMENT);
    let script = "import json, pathlib, sys, jsonschema, yaml\n\
        place, shipped, n = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2]), 0\n\
        for pair in sys.argv[3:]:\n\
        \x20   kind, name = pair.split(':')\n\
        \x20   schema = json.loads((place / kind).read_text())\n\
        \x20   jsonschema.Draft202012Validator.check_schema(schema)\n\
        \x20   check = jsonschema.Draft202012Validator(schema)\n\
        \x20   files = sorted((shipped / name).glob('*.yaml')) or [shipped / name]\n\
        \x20   for file in files:\n\
        \x20       document = yaml.safe_load(file.read_text())\n\
        \x20       errors = [error.message for error in check.iter_errors(document)]\n\
        \x20       assert not errors, (file.name, errors)\n\
        \x20       document['no_such_key'] = 1\n\
        \x20       assert not check.is_valid(document), file.name\n\
        \x20       n += 1\n\
        print(n)";
    let shipped = repository();
    let pairs = FILES.map(|(kind, name)| format!("{kind}:{name}"));

    let printed = python::must_run(
        Command::new(python).args(["-c", script]).arg(place.path()).arg(&shipped).args(pairs),
    );

    let n_files: usize = FILES.iter().map(|(_, name)| n_files(&shipped.join(name))).sum();
    assert_eq!(printed.trim(), n_files.to_string());
}

fn n_files(folder: &Path) -> usize {
    if folder.is_file() {
        return 1;
    }
    let entries = std::fs::read_dir(folder).expect("it is there");
    let is_yaml =
        |entry: &std::fs::DirEntry| entry.path().extension().is_some_and(|it| it == "yaml");
    entries.flatten().filter(is_yaml).count()
}
