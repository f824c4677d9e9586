//! The command line, at the boundary of its process: texts, exit codes, and what is left on disk.

use std::ffi::{OsStr, OsString};
use std::os::unix::ffi::OsStringExt;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::{Command, Stdio};

use rsrs_ros::confine;

use crate::command::{code, done, json, repository, rsrs, shipped, stderr, stdout, text_in};
use crate::prepared_sweeps::{SPEEDS, write_sweep};

/// A folder with the Flockbot's profile and a small sweep of it.
fn workplace() -> tempfile::TempDir {
    crate::prepared_sweeps::workplace(SPEEDS, "true_positive: 0.8")
}

fn bytes(folder: &Path, file: &str) -> Vec<u8> {
    std::fs::read(folder.join(file)).unwrap_or_else(|error| panic!("{file}: {error}"))
}

#[test]
fn who_closes_the_pipe_has_read_enough_and_a_full_disk_is_an_error() {
    let place = tempfile::tempdir().expect("a temporary folder");
    let experiment = &shipped("experiments/flockbot_milling.yaml");
    let into = |stdout: Stdio, arguments: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_rsrs"));
        command.args(arguments).current_dir(place.path()).stdout(stdout);
        command.output().expect("the binary was built for this test")
    };

    for arguments in [&["completions", "bash"][..], &["place", experiment]] {
        let (reader, writer) = std::io::pipe().expect("the system has pipes");
        drop(reader);
        let closed = into(writer.into(), arguments);
        let full = std::fs::File::options().write(true).open("/dev/full").expect("Linux has it");
        let full = into(full.into(), arguments);

        assert_eq!((code(&closed), stderr(&closed).as_str()), (0, ""));
        assert_eq!(code(&full), 1);
        assert!(stderr(&full).starts_with("error: writing to standard output"), "{full:?}");
    }
}

/// Nobody ever writes into the pipe; who waits for somebody is killed, which is no exit code of ours.
#[test]
fn a_pipe_in_the_place_of_a_file_is_refused_at_once_by_every_kind_of_command() {
    let place = workplace();
    let pipe = place.path().join("pipe.yaml");
    rustix::fs::mkfifoat(rustix::fs::CWD, &pipe, rustix::fs::Mode::RUSR).expect("writable");
    let commands = [
        "sweep pipe.yaml -o out",
        "run pipe.yaml",
        "campaign pipe.yaml -o out",
        "place pipe.yaml",
        "measure fit --name mine --speed pipe.yaml --turn pipe.yaml --detection pipe.yaml",
        "measure drive pipe.yaml --robot robot_1 --speed 0.1 --duration 1 --interface lo",
        "answer pipe.yaml",
        "diagnose pipe.yaml",
        "explore pipe.yaml -o out",
        "keystore create keys --fleet pipe.yaml",
        "stop --fleet pipe.yaml --interface lo",
        "label pipe.yaml",
        "bag info pipe.yaml",
        "node robot --robots robot_1 --interface 127.0.0.1 --config pipe.yaml",
        "node sim --robots robot_1 --interface 127.0.0.1 --ros-args --params-file pipe.yaml",
    ];

    for command in commands {
        let mut timed = Command::new("timeout");
        timed.args(["10", env!("CARGO_BIN_EXE_rsrs")]).args(command.split(' '));
        timed.current_dir(place.path());
        let output = confine::start_in_own_network(&mut timed).output().expect("part of coreutils");

        let error = stderr(&output);
        assert!([1, 2].contains(&code(&output)), "rsrs {command}: {}: {error}", code(&output));
        assert!(error.contains("it is not a regular file"), "rsrs {command}: {error}");
    }
}

#[test]
fn an_empty_folder_becomes_a_keystore_of_the_domain_of_the_environment() {
    let place = tempfile::tempdir().expect("a temporary folder");
    std::fs::create_dir(place.path().join("keys")).expect("writable");
    let fleet = repository().join("launch_configs/fleets/nine_virtual.yaml");
    let mut create = Command::new(env!("CARGO_BIN_EXE_rsrs"));
    create.args(["keystore", "create", "keys", "--fleet"]).arg(fleet).current_dir(place.path());

    let made = create.env("ROS_DOMAIN_ID", "7").output().expect("it was built for this test");
    let shown = rsrs(place.path(), &["keystore", "show", "keys"]);

    assert_eq!((code(&made), code(&shown)), (0, 0), "{}{}", stderr(&made), stderr(&shown));
    assert!(stdout(&shown).starts_with("domain 7; "), "{}", stdout(&shown));
    // A key that was copied belongs to root, and the robot's service is not root.
    let copied = "ssh HOST sudo chown rsrs /etc/rsrs/keystore/enclaves/ROBOT/key.pem";
    assert!(stderr(&made).contains(copied), "{}", stderr(&made));
}

#[test]
fn what_is_public_in_a_keystore_is_readable_whatever_the_umask_is_and_what_is_wrong_ends_with_3() {
    let place = tempfile::tempdir().expect("a temporary folder");
    let keystore = place.path().join("keys");
    let fleet = repository().join("launch_configs/fleets/nine_virtual.yaml");
    let mut umask = Command::new("sh");
    umask.args(["-c", "umask 077; $0 keystore create keys --fleet $1 && $0 keystore renew keys"]);
    umask.arg(env!("CARGO_BIN_EXE_rsrs")).arg(fleet).current_dir(place.path());

    let made = umask.output().expect("every system has sh");

    assert_eq!(code(&made), 0, "{}", stderr(&made));
    let mode = |path: &str| {
        let permissions = keystore.join(path).metadata().expect("it was made").permissions();
        permissions.mode() & 0o777
    };
    for folder in ["", "enclaves", "enclaves/robot_1", "public"] {
        assert_eq!(mode(folder), 0o755, "{folder}");
    }
    for file in ["cert.pem", "permissions.p7s", "governance.p7s", "identity_ca.cert.pem"] {
        assert_eq!(mode(&format!("enclaves/robot_1/{file}")), 0o644, "{file}");
    }
    assert_eq!((mode("private"), mode("private/ca.key.pem")), (0o700, 0o600));
    std::fs::remove_file(keystore.join("enclaves/stop/permissions.p7s")).expect("it was made");
    let shown = rsrs(place.path(), &["keystore", "show", "keys"]);
    assert_eq!(code(&shown), 3, "{}", stderr(&shown));
    assert!(stdout(&shown).contains("enclaves/stop/permissions.p7s is missing"));
    let typed = "\n  rsrs keystore create keys --fleet FLEET.yaml\n";
    assert!(stderr(&shown).contains(typed), "{}", stderr(&shown));
}

#[test]
fn a_simulated_run_does_not_start_where_it_is_not_clear_whether_it_is_to_be_secured() {
    let place = tempfile::tempdir().expect("a temporary folder");
    let no_text = OsString::from_vec(b"tr\xffue".to_vec());
    let found = |value: &OsStr| {
        let mut timed = Command::new("timeout");
        timed.args(["10", env!("CARGO_BIN_EXE_rsrs"), "dry-run"]).current_dir(place.path());
        let output = timed.env("ROS_SECURITY_ENABLE", value).output().expect("part of coreutils");
        (code(&output), stderr(&output).lines().next().map(str::to_owned))
    };
    let refused = |text: &str| (1, Some(format!("error: {text}")));

    for value in ["True", "1"] {
        let text = format!("ROS_SECURITY_ENABLE is `{value}`, expected true or false");
        assert_eq!(found(value.as_ref()), refused(&text));
    }
    assert_eq!(found(&no_text), refused("the value of ROS_SECURITY_ENABLE is not UTF-8"));
}

#[test]
fn the_same_sweep_is_not_computed_again_and_another_one_is_refused() {
    let place = workplace();
    rsrs(place.path(), &["sweep", "sweep.yaml", "-o", "out"]);
    let before = bytes(&place.path().join("out"), "cells.csv");

    let again = rsrs(place.path(), &["sweep", "sweep.yaml", "-o", "out"]);
    write_sweep(place.path(), "other.yaml", SPEEDS, "true_positive: 0.9");
    let other = rsrs(place.path(), &["sweep", "other.yaml", "-o", "out"]);

    assert_eq!(code(&again), 0);
    assert_eq!(code(&other), 1);
    let difference =
        "out exists and holds another sweep: fixed.true_positive is 0.8 there, and 0.9 here";
    assert!(stderr(&other).contains(difference), "{}", stderr(&other));
    assert_eq!(bytes(&place.path().join("out"), "cells.csv"), before);
}

#[test]
fn a_folder_of_something_else_is_refused_and_left_alone() {
    let place = workplace();
    std::fs::create_dir(place.path().join("thesis")).expect("the folder is writable");

    let output = rsrs(place.path(), &["sweep", "sweep.yaml", "-o", "thesis"]);

    assert_eq!(code(&output), 1);
    assert!(stderr(&output).contains("thesis exists and is not the folder of a sweep"));
    let entries = std::fs::read_dir(place.path()).expect("the folder is readable");
    let names: Vec<_> = entries.map(|entry| entry.expect("readable").file_name()).collect();
    assert_eq!(names.len(), 3, "nothing half-written: {names:?}");
}

#[test]
fn a_wrong_key_is_answered_with_file_line_column_and_the_nearest_key() {
    let place = workplace();
    let text = text_in(place.path(), "sweep.yaml");
    let wrong = text.replace("duration_s:", "duration:");
    std::fs::write(place.path().join("wrong.yaml"), wrong).expect("the folder is writable");

    let output = rsrs(place.path(), &["sweep", "wrong.yaml", "-o", "out"]);

    assert_eq!(code(&output), 1);
    assert_eq!(
        stderr(&output),
        "error: wrong.yaml:7:1: unknown key `duration`; did you mean `duration_s`?\n\
         help: the keys here are: profile, controller, harsher, behaviour, axes, fixed, placement, world, cells, replicates, duration_s, \
         seed, adaptive\n"
    );
    assert!(!place.path().join("out").exists());
}

#[test]
fn a_picture_of_an_axis_that_was_not_swept_is_refused() {
    let place = workplace();
    rsrs(place.path(), &["sweep", "sweep.yaml", "-o", "out"]);

    let output = rsrs(place.path(), &["diagram", "out", "-o", "p.svg", "--x", "robots"]);
    let misspelt = rsrs(place.path(), &["diagram", "out", "-o", "p.svg", "--x", "robot"]);

    assert_eq!(code(&output), 1);
    assert!(stderr(&output).contains("robots"), "{}", stderr(&output));
    assert_eq!(code(&misspelt), 2);
    assert!(stderr(&misspelt).contains("did you mean `robots`"), "{}", stderr(&misspelt));
    assert!(!place.path().join("p.svg").exists());
}

#[test]
fn of_more_than_two_axes_a_picture_shows_all_slices_or_the_one_asked_for() {
    let folder = workplace();
    let sweep = text_in(folder.path(), "sweep.yaml");
    let sweep = sweep
        .replace("axes:\n", "axes:\n  robots: [5, 7, 9]\n")
        .replace("robots: 9, ", "")
        .replace("duration_s: 120", "duration_s: 61");
    std::fs::write(folder.path().join("sweep.yaml"), sweep).expect("the folder is writable");

    done(folder.path(), &["sweep", "sweep.yaml", "-o", "out"]);
    let svg = |file: &str| String::from_utf8(bytes(folder.path(), file)).expect("SVG is text");
    // The unit is in the next line: panels are narrow.
    for slice in ["turning rate 0.25</text>", "turning rate 0.75</text>"] {
        assert!(svg("out/diagram.svg").contains(slice), "{slice}");
    }
    let at = ["--x", "speed_m_s", "--y", "turn_rate_rad_s", "--at", "robots=9"];
    done(folder.path(), &[&["diagram", "out", "-o", "nine.svg"], &at[..]].concat());
    assert!(svg("nine.svg").contains("Slice at 9 robots"));
}

#[test]
fn a_run_of_what_was_not_swept_is_refused_before_it_starts() {
    let place = workplace();
    done(place.path(), &["sweep", "sweep.yaml", "-o", "swept"]);
    let experiment = &shipped("experiments/flockbot_milling.yaml");

    for (cell, expected) in [
        (
            &["--cell", "speed_m_s=0.2,turn_rate_rad_s=0.75"][..],
            "the nearest swept cell is speed_m_s=0.15,turn_rate_rad_s=0.75",
        ),
        (&[], "`rsrs choose swept -o swept/choice.json`"),
        (
            &["--cell", "speed_m_s=0.15,turn_rate_rad_s=0.75"],
            "the placement radius is 0.825 m, expected 0.6 m",
        ),
    ] {
        let run = rsrs(place.path(), &[&["run", experiment, "--from", "swept"], cell].concat());

        assert_eq!(code(&run), 1, "{cell:?}: {}", stdout(&run));
        assert!(stderr(&run).contains(expected), "{cell:?}: {}", stderr(&run));
    }
}

/// Writes a sweep file of the Flockbot with these lines about its cells and replicates; what they do
/// not sweep is fixed.
fn write_lines(folder: &Path, name: &str, lines: &str) {
    let usual = [
        ("speed_m_s", "0.15"),
        ("turn_rate_rad_s", "0.75"),
        ("robots", "9"),
        ("placement_radius_m", "0.825"),
        ("arena_m", "15"),
    ];
    let fixed = usual.iter().filter(|(axis, _)| !lines.contains(axis));
    let fixed: Vec<String> = fixed.map(|(axis, value)| format!("{axis}: {value}")).collect();
    let sweep = format!(
        "profile: flockbot.yaml\nduration_s: 60\nseed: 7\n{lines}\nfixed: {{{}}}\n",
        fixed.join(", ")
    );
    std::fs::write(folder.join(name), sweep).expect("the folder is writable");
}

#[test]
fn sweeps_of_nothing_or_of_what_is_no_number_are_refused_before_a_folder_is_made() {
    let place = workplace();
    let too_many = "axes: {speed_m_s: {from: 0, to: 1, steps: 2000}, \
                    turn_rate_rad_s: {from: 0, to: 1, steps: 2000}}\nreplicates: 1";

    for (lines, expected) in [
        ("axes: {}\nreplicates: 1", "give either `axes` or `cells`"),
        ("replicates: 1", "give either `axes` or `cells`"),
        ("axes: {speed_m_s: []}\nreplicates: 1", "`speed_m_s` has no values"),
        (
            "axes: {speed_m_s: {from: 0, to: 1, steps: 0}}\nreplicates: 1",
            "`speed_m_s` has no values",
        ),
        ("cells: []\nreplicates: 1", "`cells` has no values"),
        ("cells: [{}]\nreplicates: 1", "`cells[0]` has no values"),
        (
            "axes: {speed_m_s: [.nan]}\nreplicates: 1",
            "`speed_m_s` has the value NaN, which is not a finite number",
        ),
        (
            "axes: {speed_m_s: [0.1, .inf]}\nreplicates: 1",
            "`speed_m_s` has the value inf, which is not a finite number",
        ),
        (
            "axes: {speed_m_s: [0.1, 0.2, 0.1]}\nreplicates: 1",
            "`speed_m_s` has the value 0.1, which occurs twice",
        ),
        (
            "axes: {speed_m_s: {from: 0, to: .inf, steps: 3}}\nreplicates: 1",
            "`to` is inf, expected a finite number",
        ),
        (too_many, "the axes span 4e6 cells, expected at most 1000000"),
        ("axes: {speed_m_s: [0.1]}\nreplicates: 0", "replicates is 0, expected 1 to 10^12"),
        (
            "axes: {robots: [9, 0]}\nreplicates: 1",
            "cell `robots=0` cannot be judged: no robots, expected at least 1",
        ),
        ("axes: {robots: [9, 500]}\nreplicates: 1", "cell `robots=500`: 500 robots do not fit"),
        (
            "axes: {robots: [9]}\nreplicates: 16\nadaptive: {most_replicates: 8}",
            "adaptive.most_replicates is 8, expected at least `replicates`",
        ),
        (
            "axes: {robots: [9]}\nreplicates: 16\nadaptive: {width: 0}",
            "adaptive.width is 0, expected a share between 0 and 1",
        ),
    ] {
        write_lines(place.path(), "odd.yaml", lines);

        let output = rsrs(place.path(), &["sweep", "odd.yaml", "-o", "out"]);

        assert_eq!(code(&output), 1, "{lines}: {}", stdout(&output));
        assert!(stderr(&output).contains(expected), "{lines}: {}", stderr(&output));
        assert!(!place.path().join("out").exists(), "{lines}");
    }
}

#[test]
fn one_robot_and_two_robots_and_one_replicate_are_swept_like_any() {
    let place = workplace();
    write_lines(place.path(), "few.yaml", "axes: {robots: [1, 2]}\nreplicates: 1");

    let sweep = rsrs(place.path(), &["sweep", "few.yaml", "-o", "few"]);
    let choose = rsrs(place.path(), &["choose", "few", "--format", "json"]);

    assert_eq!((code(&sweep), code(&choose)), (0, 3), "{}{}", stderr(&sweep), stderr(&choose));
    let cells = String::from_utf8(bytes(&place.path().join("few"), "cells.csv")).expect("UTF-8");
    assert_eq!(cells.lines().count(), 3);
    assert!(!cells.contains("NaN"), "{cells}");
    let answer = json(&choose);
    assert_eq!(answer["cell"], serde_json::Value::Null);
    assert_eq!(answer["best_swept"]["n_replicates"], 1);
    assert_eq!(answer["best_swept"]["cell"]["robots"], 1.0);
}

#[test]
fn an_adaptive_sweep_has_as_many_replicates_as_each_cell_needs() {
    let place = workplace();

    let sweep = rsrs(
        place.path(),
        &["sweep", "sweep.yaml", "-o", "out", "--adaptive", "--width", "0.15", "--format", "json"],
    );
    let choose = rsrs(place.path(), &["choose", "out", "--confirm", "200", "--format", "json"]);
    let again = rsrs(place.path(), &["sweep", "out/sweep.yaml", "-o", "again", "--threads", "1"]);

    assert_eq!((code(&sweep), code(&choose), code(&again)), (0, 0, 0), "{}", stderr(&sweep));
    let report = json(&sweep);
    assert_eq!(report["adaptive"]["exhausted"], 0, "{report}");
    let folder = place.path().join("out");
    let cells = String::from_utf8(bytes(&folder, "cells.csv")).expect("UTF-8");
    let rows: Vec<Vec<&str>> = cells.lines().map(|line| line.split(',').collect()).collect();
    assert_eq!(rows[0].last(), Some(&"interval"));
    assert!(rows[1..].iter().all(|row| row.last() == Some(&"anytime_valid")), "{cells}");
    let n: Vec<u64> = rows[1..].iter().map(|row| row[2].parse().expect("a count")).collect();
    assert_eq!(report["runs"], n.iter().sum::<u64>());
    assert!(n.iter().max() > n.iter().min(), "every cell has {n:?}");
    assert!(n.iter().all(|n| *n >= 16), "{n:?}");
    let confirmed = json(&choose);
    assert_eq!(confirmed["n_replicates"], 200);
    for file in ["sweep.yaml", "cells.csv", "replicates.parquet", "diagram.svg", "diagram.png"] {
        assert!(bytes(&folder, file) == bytes(&place.path().join("again"), file), "{file}");
    }
}

#[test]
fn pyarrow_reads_a_row_for_each_replicate() {
    let place = workplace();
    done(place.path(), &["sweep", "sweep.yaml", "-o", "out"]);
    let python = rsrs_testing::python::python_with(&rsrs_testing::python::SCIENCE);
    let script = "import sys, pyarrow.parquet, pyarrow.compute as compute\n\
                  table = pyarrow.parquet.read_table(sys.argv[1])\n\
                  table.validate(full=True)\n\
                  print(sorted(compute.value_counts(table['world']).to_pylist(), key=str))\n\
                  table = table.filter(compute.equal(table['world'], 'harsher'))\n\
                  milling = table.filter(compute.equal(table['phase'], 'stable_milling'))\n\
                  print(table.num_rows, table['seed'].unique().to_pylist(), milling.num_rows)\n\
                  print(table.column_names)";

    let printed = rsrs_testing::python::must_run(
        Command::new(python).args(["-c", script]).arg(place.path().join("out/replicates.parquet")),
    );

    let cells = String::from_utf8(bytes(&place.path().join("out"), "cells.csv")).expect("UTF-8");
    let milling = cells
        .lines()
        .skip(1)
        .map(|line| line.split(',').nth(3).expect("a column").parse::<u64>().expect("a count"));
    let expected = format!(
        "[{{'values': 'as_measured', 'counts': 64}}, {{'values': 'harsher', 'counts': 64}}]\n\
         64 [7] {}\n['speed_m_s', 'turn_rate_rad_s', 'replicate', 'seed', 'phase', 'lost', \
         'blocked', 'stuck', 'rotation', 'orbit', 'fatness', 'tangentness', 'circliness', \
         'mean_radius_m', 'contact_onsets_per_s', 'circliness_ceiling', 'clustered', 'world']\n",
        milling.sum::<u64>()
    );
    assert_eq!(printed, expected);
}

#[test]
fn a_diagram_on_a_page_has_the_numbers_too() {
    let place = workplace();
    done(place.path(), &["sweep", "sweep.yaml", "-o", "out"]);

    let page = rsrs(place.path(), &["diagram", "out", "-o", "diagram.html"]);
    let other = rsrs(place.path(), &["diagram", "out", "-o", "diagram.gif"]);

    assert_eq!(code(&page), 0, "{}", stderr(&page));
    let html = text_in(place.path(), "diagram.html");
    assert!(html.contains("<svg") && !html.contains("src="), "it needs no other file");
    assert_eq!(html.matches("<tr><td>").count(), 4, "one row for each cell");
    assert_eq!(code(&other), 2);
    assert!(
        stderr(&other).contains("diagram.gif ends in none of .svg, .png and .pdf, nor in .html")
    );
}

#[test]
fn what_is_typed_wrong_ends_with_2() {
    let place = tempfile::tempdir().expect("a temporary folder");
    let sweep = repository().join("launch_configs/sweeps/flockbot_speed_turn.yaml");
    let sweep = sweep.to_str().expect("a path in UTF-8");
    let robot = ["init", "mine", "--robots", "9", "--radius", "0.07", "--speed", "0.2"];
    let robot = [&robot[..], &["--turn-rate", "2", "--range", "0.8", "--period", "0.1"]].concat();
    for (arguments, expected) in [
        (vec!["compare", "out", "--bags", "run", "-o", "a.pdf"], "name the table `-o a.tex`"),
        (vec!["init", "mine", "--speed", "0.2"], "--name, --robots"),
        ([&robot[..], &["--name", "e-puck2", "--half-angle", "0.3"]].concat(), "`e_puck2`"),
        ([&robot[..], &["--name", "mine", "--half-angle", "17"]].concat(), "looks like degrees"),
        (vec!["stop", "--interface", "nowhere0"], "nowhere0"),
        (vec!["measure", "plan", "--robots", "0"], "robots"),
        (vec!["report", "out", "-o", "a.pdf"], "name the report `-o report.html`"),
        (vec!["sweep", sweep, "-o", "a", "--adaptive", "--width", "1.5"], "error: --adaptive: "),
        (vec!["sweep", sweep, "-o", "a", "--threads", "0"], "'--threads <N>'"),
        (vec!["answer", "a.yaml", "--width", "88mm"], "name it with `-o`"),
        (vec!["diagram", "out", "-o", "a.tex", "--theme", "paper"], "leave it out"),
        (
            vec!["diagram", "out", "-o", "a.svg", "--value", "difference", "--world", "harsher"],
            "leave out `--world`",
        ),
    ] {
        let output = rsrs(place.path(), &arguments);

        assert_eq!(code(&output), 2, "{arguments:?}: {}", stderr(&output));
        assert!(stderr(&output).contains(expected), "{arguments:?}: {}", stderr(&output));
    }
}
