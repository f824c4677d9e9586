//! Words on a terminal: colours, how much is printed, and commands that can be pasted.

use std::path::Path;
use std::process::{Command, Output, Stdio};

use crate::command::{code, done, json, rsrs, shipped, stderr, stdout, text_in};
use crate::prepared_sweeps::{SPEEDS, chosen, swept, workplace};
use crate::simulated_bags::Run;
use crate::terminal::Terminal;

const ESCAPE: char = '\u{1b}';

/// A folder with the bag of a run that mills.
fn milled() -> tempfile::TempDir {
    let place = tempfile::tempdir().expect("a temporary folder");
    Run::new(1).record(place.path(), "monday");
    place
}

/// What a person sees who labels a bag at a terminal, in an environment and with options.
fn on_a_terminal(place: &Path, environment: &[(&str, &str)], options: &[&str]) -> String {
    let terminal = Terminal::open();
    let mut command = Command::new(env!("CARGO_BIN_EXE_rsrs"));
    command.args(["label", "monday"]).args(options).current_dir(place);
    for name in ["NO_COLOR", "CLICOLOR", "CLICOLOR_FORCE", "CI"] {
        command.env_remove(name);
    }
    command.env("TERM", "xterm-256color").envs(environment.iter().copied());
    let status = command.stdin(Stdio::null()).stdout(terminal.input()).stderr(terminal.input());
    let status = status.status().expect("the program was built for this test");
    drop(command);
    assert!(status.success(), "{status}");
    terminal.printed()
}

fn with(place: &Path, environment: (&str, &str), arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_rsrs"));
    command.args(arguments).current_dir(place).env(environment.0, environment.1);
    command.output().expect("the program was built for this test")
}

#[test]
fn verdicts_are_coloured_on_a_terminal_unless_somebody_does_not_want_it() {
    let place = milled();
    let green = "\u{1b}[1m\u{1b}[32mstable milling\u{1b}[0m";
    let on_a_terminal = |environment, options| on_a_terminal(place.path(), environment, options);

    assert!(on_a_terminal(&[], &[]).contains(green));
    assert!(on_a_terminal(&[("NO_COLOR", "")], &[]).contains(green), "an empty one is ignored");
    for (environment, options) in [
        (&[("NO_COLOR", "1")][..], &[][..]),
        (&[("TERM", "dumb")], &[]),
        (&[], &["--color", "never"]),
    ] {
        let printed = on_a_terminal(environment, options);
        assert!(printed.contains("monday: stable milling ("), "{printed}");
        assert!(!printed.contains(ESCAPE), "{environment:?} {options:?}: {printed}");
    }
}

#[test]
fn pipes_and_programs_get_no_colours_unless_they_ask_for_them() {
    let place = milled();
    let here = place.path();
    let is_coloured = |output: &Output| stdout(output).contains(ESCAPE);

    let piped = rsrs(here, &["label", "monday"]);
    let forced = with(here, ("CLICOLOR_FORCE", "1"), &["label", "monday"]);
    let always = rsrs(here, &["--color", "always", "label", "monday"]);
    let program = rsrs(here, &["label", "monday", "--color", "always", "--format", "json"]);
    let wrong = rsrs(here, &["label", "tuesday", "--color", "always"]);

    assert!(!is_coloured(&piped) && is_coloured(&forced) && is_coloured(&always));
    assert!(!is_coloured(&program));
    assert_eq!(json(&program)[0]["phase"], "stable_milling");
    assert!(stderr(&wrong).starts_with("\u{1b}[1m\u{1b}[31merror:\u{1b}[0m "), "{wrong:?}");
}

#[test]
fn a_quiet_program_prints_results_and_a_talkative_one_every_file() {
    let place = workplace(SPEEDS, "true_positive: 0.8");
    let here = place.path();

    let usual = rsrs(here, &["sweep", "sweep.yaml", "-o", "usual"]);
    let quiet = rsrs(here, &["sweep", "sweep.yaml", "-o", "quiet", "--quiet"]);
    let verbose = rsrs(here, &["-v", "sweep", "sweep.yaml", "-o", "verbose"]);
    let both = rsrs(here, &["sweep", "sweep.yaml", "-o", "both", "-q", "-v"]);

    let result = |output: &Output, folder: &str| stdout(output).replace(folder, "FOLDER");
    assert_eq!(result(&quiet, "quiet"), result(&usual, "usual"));
    assert_eq!(result(&verbose, "verbose"), result(&usual, "usual"));
    let steps = stderr(&verbose);
    for step in [
        "read sweep.yaml: ",
        "read flockbot.yaml: ",
        "wrote verbose/cells.csv: ",
        "wrote verbose/replicates.parquet: ",
        "wrote verbose/diagram.svg: ",
        "wrote verbose/diagram.png: ",
    ] {
        assert!(steps.contains(step), "{step}: {steps}");
        assert!(!stderr(&usual).contains(step) && !stderr(&quiet).contains(step));
    }
    assert_eq!(code(&both), 2, "{}", stderr(&both));
}

/// The command behind a label at the beginning of a line.
fn command_after<'a>(printed: &'a str, label: &str) -> &'a str {
    let line = printed.lines().find_map(|line| line.strip_prefix(label));
    line.unwrap_or_else(|| panic!("no line begins with “{label}”: {printed}"))
}

/// Pastes a command into a shell.
fn paste(place: &Path, command: &str) -> Output {
    let program = Path::new(env!("CARGO_BIN_EXE_rsrs"));
    let folder = program.parent().expect("a program is in a folder");
    let path = std::env::var("PATH").unwrap_or_default();
    let output = Command::new("sh")
        .args(["-c", command])
        .current_dir(place)
        .env("PATH", format!("{}:{path}", folder.display()))
        .output()
        .expect("there is a shell");
    assert_eq!(code(&output), 0, "{command}: {}{}", stdout(&output), stderr(&output));
    output
}

#[test]
fn every_next_command_can_be_pasted_as_it_is() {
    let place = workplace(SPEEDS, "true_positive: 0.8");
    let here = place.path();

    let swept = stdout(&rsrs(here, &["sweep", "sweep.yaml", "-o", "Ana's sweep"]));
    let choose = command_after(&swept, "next: ");
    assert_eq!(choose, r"rsrs choose 'Ana'\''s sweep' -o 'Ana'\''s sweep/choice.json'");
    let chosen = stdout(&paste(here, choose));
    assert!(chosen.contains("\nwrote Ana's sweep/choice.json\n"), "{chosen}");
    paste(here, command_after(&chosen, "next: "));

    let kept = stdout(&rsrs(here, &["choose", "Ana's sweep", "--confirm", "200"]));
    paste(here, command_after(&kept, "next: "));
    let cell = "speed_m_s=0.15,turn_rate_rad_s=0.75";
    let replicate = ["--cell", cell, "--replicate", "0", "-o", "first try"];
    let episode = stdout(&rsrs(here, &[&["episode", "Ana's sweep"], &replicate[..]].concat()));
    let labelled = stdout(&paste(here, command_after(&episode, "next: ")));
    assert!(labelled.starts_with("first try: "), "{labelled}");
}

#[test]
fn the_next_experiment_names_the_files_that_are_there() {
    let place = chosen();
    let here = place.path();
    Run::new(1).record(here, "monday");
    let compared = || stdout(&rsrs(here, &["compare", "out", "--bags", "monday"]));

    let without = compared();
    let shipped = std::fs::read_to_string(shipped("experiments/flockbot_milling.yaml"))
        .expect("it is shipped");
    let write = |text: &str| std::fs::write(here.join("experiment.yaml"), text);
    write(&shipped).expect("the folder is writable");
    let other = compared();
    write(&shipped.replace("duration_s: 300", "duration_s: 120")).expect("the folder is writable");
    let beside = compared();

    // Another folder than that of the run.
    let cell =
        "--cell speed_m_s=0.15,turn_rate_rad_s=0.75 --backend fleet --interface NAME -o run_2";
    let expected = format!("rsrs run EXPERIMENT.yaml --from out {cell}");
    assert_eq!(command_after(&without, "next: "), expected);
    assert_eq!(command_after(&other, "next: "), expected, "it lasts another time");
    let expected = format!("rsrs run experiment.yaml --from out {cell}");
    assert_eq!(command_after(&beside, "next: "), expected);
}

#[test]
fn pictures_state_where_they_are() {
    let place = swept(SPEEDS, "true_positive: 0.8");
    let here = place.path();
    Run { duration_s: 64.0, recorded_s: 64.0, ..Run::new(1) }.record(here, "monday");

    for (arguments, path) in [
        (&["diagram", "out", "-o", "diagram.png"][..], "diagram.png"),
        (&["diagram", "out", "-o", "diagram.html"], "diagram.html"),
        (&["draw", "monday", "-o", "monday.svg"], "monday.svg"),
        (&["film", "monday", "-o", "monday.gif", "--fps", "1", "--width", "64"], "monday.gif"),
    ] {
        let output = rsrs(here, arguments);

        assert_eq!(stdout(&output), format!("wrote {path}\n"), "{}", stderr(&output));
        assert!(here.join(path).is_file());
    }
}

/// Records runs until the label of one is near another one, and names it.
fn borderline(here: &Path) -> String {
    let is_near = |name: &String| {
        let label = json(&rsrs(here, &["label", name, "--format", "json"]));
        label[0]["is_settled"] == false
    };
    // Robots that miss every second neighbour mill badly.
    let runs = (1..=30).map(|seed| {
        let name = format!("run_{seed}");
        Run { sight: 0.5, ..Run::new(seed) }.record(here, &name);
        name
    });
    { runs }.find(is_near).expect("of 30 bad mills one is near another phase")
}

#[test]
fn a_label_near_another_one_is_marked_wherever_it_is_shown() {
    let place = chosen();
    let here = place.path();
    let near = borderline(here);
    let read = |file: &str| text_in(here, file);
    let printed = |arguments: &[&str]| done(here, arguments);

    let label = printed(&["label", &near]);
    let compared = printed(&["compare", "out", "--bags", &near]);
    printed(&["report", "out", "--bags", &near, "-o", "report.html"]);
    printed(&["diagram", "out", "--bags", &near, "-o", "diagram.svg"]);
    printed(&["draw", &near, "-o", "drawing.svg"]);

    assert!(label.contains("not settled: look again"), "{label}");
    assert!(compared.contains("(not settled: look again)"), "{compared}");
    for file in ["report.html", "diagram.svg", "drawing.svg"] {
        assert!(read(file).contains("(not settled: look again)"), "{file}");
    }
}
