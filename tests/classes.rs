//! Several classes of robots: from the sweep to the label, over ROS 2, and compared.

use std::path::{Path, PathBuf};

use crate::command::{bring, code, done, json, rsrs as typed, stderr, stdout, text_in, write};
use crate::fleet::{experiment, rewrite, usual_sensing};
use crate::processes::{confined_rsrs, run_in_lockstep};
use crate::recorded::{assert_commands_of_replicate, assert_digests_of_replicate, record_of};

/// A sensor that tells kin from others.
const SENSORS: &str = "\
sensors:
  - one_of:
      - {name: detection, detects: kin, true_positive: 0.95, false_positive: 0.02, taken_for: {other: 0.03}}
      - {name: other, detects: other, true_positive: 0.96, false_positive: 0.02}
    cone: {half_angle_rad: 0.3, range_m: 1.5}
    hidden_by: [robot]
";

/// Towards kin, and around where another one is; robots of class b wait a while before.
const TABLE: &str = "\
numbers:
  search_rad_s: {value: 1.5, from: 0.2, to: 2}
starts: {b: idle}
rows:
  - {state: go, when: {detection: true}, command: {speed_m_s: 0.15, turn_rate_rad_s: 0.7}}
  - {state: go, when: {other: true}, command: {speed_m_s: 0, turn_rate_rad_s: 1.8}}
  - {state: go, command: {speed_m_s: 0.05, turn_rate_rad_s: $search_rad_s}}
  - {state: idle, when: {other: true}, command: {speed_m_s: 0.03, turn_rate_rad_s: -1.5}}
  - {state: idle, command: {speed_m_s: 0.02, turn_rate_rad_s: 1.2}, next: {state: go, probability: 0.005}}
";

const CLASSES: &str = "\
classes:
  - {name: a}
  - {name: b, count: 2}
";

const SORTING: &str = "\
name: sorting
words: {noun: sorting, swarm: a swarm that sorts itself, verb: [sort, sorts, sorted]}
phases: [{key: sorted}, {key: mixed}]
rules: [{phase: sorted, when: {segregated: {at_least: 0.4}, least_segregated: {at_least: 0.2}}}]
otherwise: mixed
";

const SWEEP: &str = "\
profile: profiles/flockbot.yaml
controller: sort.yaml
behaviour: sorting.yaml
world: classes.yaml
axes: {robots: [5, 6]}
fixed: {placement_radius_m: 0.825, arena_m: 3, walls: clamp}
harsher: none
replicates: 16
duration_s: 70
seed: 7
";

/// A sweep of such robots, and an experiment whose cell is from it.
fn files(folder: &Path, more: &[(&str, &str)]) -> PathBuf {
    write(
        folder,
        &[
            ("sort.yaml", TABLE),
            ("classes.yaml", CLASSES),
            ("sorting.yaml", SORTING),
            ("sweep.yaml", SWEEP),
        ],
    );
    let sensing = usual_sensing();
    let usual = "cell: {speed_m_s: 0.15, turn_rate_rad_s: 0.75, robots: 9}";
    let changes = [(usual, "from: ../out"), (sensing.as_str(), SENSORS)];
    experiment(folder, 70, &[&changes, more].concat())
}

/// Gives class b robots that turn worse and see less far, and whose fleet says so.
fn with_profiles(here: &Path) {
    let path = here.join("profiles/flockbot.yaml");
    let profile = std::fs::read_to_string(&path).expect("it was written");
    let (near, worse) = ("range_m: 1.0}", "heading_noise_sd_rad: 0.05\n");
    let profile = profile
        .replace("range_m: 1.5}", near)
        .replace("heading_noise_sd_rad: 0.0\n", worse)
        .replace("name: flockbot\n", "name: near_sighted\n");
    assert!(profile.contains(near) && profile.contains(worse), "{profile}");
    write(here, &[("profiles/b.yaml", &profile)]);
    rewrite(
        &here.join("classes.yaml"),
        &[("name: b, count: 2", "name: b, count: 2, profile: profiles/b.yaml")],
    );
}

/// Gives robots of a fleet that profile.
fn with_profiles_of(here: &Path, robots: &[&str]) {
    let fleet = here.join("fleets/nine_virtual.yaml");
    for robot in robots {
        let from = format!("  {robot}: {{");
        rewrite(&fleet, &[(&from, &format!("{from}profile: ../profiles/b.yaml, "))]);
    }
}

#[test]
fn classes_go_from_the_sweep_over_ros_2_in_lockstep_bit_for_bit_to_the_verdict() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let here = folder.path();
    let file = files(here, &[]);
    with_profiles(here);
    with_profiles_of(here, &["robot_2", "robot_4"]);
    done(here, &["sweep", "sweep.yaml", "-o", "out"]);
    let kept = text_in(here, "out/sweep.yaml");
    assert!(kept.contains("name: b") && kept.contains("count: 2"), "{kept}");
    done(here, &["choose", "out", "--confirm", "50", "-o", "out/choice.json"]);

    let path = here.join("bag");
    run_in_lockstep(&file, &[], &path);

    let (bag, record) = record_of(&path);
    let (robots, world) = (record.conditions.robots, &record.conditions.world);
    assert_eq!(world.in_words(), "2 classes of robots (b with a profile of its own)");
    assert_eq!(world.classes_of(robots)[..4], [0, 1, 0, 1]);
    let noise = |robot: usize| record.conditions.robot_at(robot).heading_noise_sd_rad;
    assert_eq!(
        (0..5).map(noise).filter(|noise| (*noise - 0.05).abs() < 1e-9).count(),
        2,
        "its own profile"
    );
    assert_eq!(record.own_profiles.keys().collect::<Vec<_>>(), ["robot_2", "robot_4"]);
    assert_digests_of_replicate(&bag, &record);
    assert_commands_of_replicate(&bag, &record);
    let labelled = typed(here, &["label", "bag", "--format", "json"]);
    assert_eq!(code(&labelled), 0, "{}", stderr(&labelled));
    let label = &json(&labelled)[0];
    assert!(label["evidence"]["segregated"].is_f64(), "{label:#}");
    assert!(done(here, &["replay", "bag", "--into", "controller"]).contains(" 0 different"));

    done(here, &["report", "out", "-o", "report.html", "--bags", "bag"]);
    let html = text_in(here, "report.html");
    assert!(html.contains(r#""own_regions_m":{"1":[[["#), "a replay has what each class sees");
    for expected in [
        "<h1>Simulated runs and experiments: flockbot (class a), near_sighted (class b)</h1>",
        "<caption>Class b, where it differs from the profile of the sweep: near_sighted: ",
        "<td>actuation.turn.heading_noise_sd_rad</td><td>0.05</td>",
        "<td>digest of the profile of class b</td>",
    ] {
        assert!(html.contains(expected), "{expected}");
    }
    let svg = text_in(here, "out/diagram.svg");
    assert!(
        svg.contains("of a swarm that sorts itself: flockbot (class a), near_sighted (class b)")
    );

    let compare = ["compare", "out", "--bags", "bag", "--margin", "0.3", "--format", "json"];
    let compared = json(&typed(here, &compare));
    assert_eq!(compared["cells"][0]["real"]["sorted"], 1, "{compared:#}");
    assert!(!compared.to_string().contains("profile of their own"), "{compared:#}");
}

#[test]
fn a_simulated_episode_has_the_label_of_its_bag_and_lids_in_the_colours_of_its_classes() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let here = folder.path();
    files(here, &[]);
    done(here, &["sweep", "sweep.yaml", "-o", "out"]);
    let episode = ["episode", "out", "--cell", "robots=6", "--replicate", "1", "-o", "run"];
    let episode = done(here, &[&episode[..], &["--format", "json"]].concat());
    let episode: serde_json::Value = serde_json::from_str(&episode).expect("it is JSON");

    let labelled = json(&typed(here, &["label", "run", "--format", "json"]))[0].clone();
    done(here, &["draw", "run", "-o", "run.svg"]);
    done(here, &["film", "run", "-o", "run.gif", "--rate", "30", "--width", "120"]);
    done(here, &["report", "out", "-o", "report.html"]);

    assert_eq!(labelled["evidence"], episode["evidence"], "the bag has what the simulator saw");
    assert!(labelled["evidence"]["least_segregated"].is_f64(), "{labelled:#}");
    let svg = text_in(here, "run.svg");
    for (class, colour, robots) in [("a", "#56b4e9", 4), ("b", "#f0e442", 2)] {
        let found = svg.matches(&format!("fill=\"{colour}\"")).count();
        assert_eq!(found, robots + 1, "each robot of class {class}, and the legend");
        assert!(svg.contains(&format!("robots of class {class}")));
    }
    let html = text_in(here, "report.html");
    assert!(
        html.contains(r##""names":["a","b"],"lids":["#56b4e9","#f0e442"]"##),
        "in replays, too"
    );
}

#[test]
fn classes_that_are_nobodys_and_sensors_of_no_classes_are_refused_with_their_cure() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let here = folder.path();
    files(here, &[]);
    let refused = |text: &str| {
        write(here, &[("new.yaml", text)]);
        let output = typed(here, &["sweep", "new.yaml", "-o", "new"]);
        assert_ne!(code(&output), 0);
        stderr(&output)
    };

    let text = refused(&SWEEP.replace("robots: [5, 6]", "robots: [5, 2]"));
    let expected = "classes.yaml:3: classes with a `count` have 2 of the 2 robots, which leaves too few for 1 without one";
    assert!(text.contains(expected) && text.contains("help: lower a `count`"), "{text}");
    let without = SWEEP.replace("world: classes.yaml\n", "");
    let text = refused(&without);
    let expected = "controller.starts has class `b`, and no robot is of it";
    assert!(
        text.contains(expected) && text.contains("help: name a world with `classes:"),
        "{text}"
    );
    let rows = TABLE.lines().filter(|line| !line.contains("idle"));
    write(here, &[("sort.yaml", &rows.collect::<Vec<_>>().join("\n"))]);
    let text = refused(&without);
    let expected = "sensor `detection` detects robots of its own class, and there are none";
    assert!(
        text.contains(expected) && text.contains("help: name a world with `classes:"),
        "{text}"
    );
    bring("profiles/flockbot.yaml", &here.join("plain.yaml"));
    let text = refused(
        &SWEEP
            .replace("profiles/flockbot.yaml", "plain.yaml")
            .replace("controller: sort.yaml\n", "")
            .replace("world: classes.yaml\n", "")
            .replace("fixed: {", "fixed: {speed_m_s: 0.15, turn_rate_rad_s: 0.75, "),
    );
    assert!(text.contains("segregated is of classes of robots, and there are none"), "{text}");
    assert!(text.contains("help: name a world that has some: `world: world.yaml`"), "{text}");
}

#[test]
fn a_profile_of_a_class_that_cannot_be_or_that_a_robot_does_not_have_is_refused() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let here = folder.path();
    let cell = "cell: {robots: 5, arena_m: 3}\ncontroller: ../sort.yaml\nworld: ../classes.yaml";
    let file = files(here, &[("from: ../out", cell)]);
    with_profiles(here);
    with_profiles_of(here, &["robot_2"]);

    let mut command = confined_rsrs();
    command.arg("run").arg(&file);
    let output = command.output().expect("the program was built for this test");

    assert!(!output.status.success(), "{}", stdout(&output));
    let text = stderr(&output);
    let expected = "robot_4 is of class b, and has another profile than that class in the world: \
                    actuation.turn.heading_noise_sd_rad and sensors differ";
    assert!(text.contains(expected) && text.contains("give robot_4 `profile: FILE`"), "{text}");
    for (from, to, expected, cure) in [
        (
            "radius_m: 0.075",
            "radius_m: 0.08",
            "class b, by its own profile profiles/b.yaml: the radius of its body is 0.08 m",
            "one radius",
        ),
        ("period_s: 0.13", "period_s: 0.26", "its control period is 0.26 s", "one control period"),
        ("another: 0.03", "another: 0.03", "class b, by its own profile", "unknown sensor `other`"),
        (
            "limits_m_s: [0.02, 0.30]",
            "limits_m_s: [0.02, 0.1]",
            "class b, by its own profile profiles/b.yaml: ",
            "0.1",
        ),
        ("radius_m: 0.075", "radius_m: -1", "profiles/b.yaml does not describe a robot", "is -1"),
    ] {
        let path = here.join("profiles/b.yaml");
        let profile = std::fs::read_to_string(&path).expect("it was written");
        if to.starts_with("another") {
            rewrite(&path, &[("name: other", "name: another"), ("{other:", "{another:")]);
        }
        rewrite(&path, &[(from, to)]);
        let output = typed(here, &["sweep", "sweep.yaml", "-o", "new"]);
        let text = stderr(&output);
        assert_ne!(code(&output), 0, "{to}");
        assert!(text.contains(expected) && text.contains(cure), "{to}: {text}");
        write(here, &[("profiles/b.yaml", &profile)]);
    }
    rewrite(&here.join("classes.yaml"), &[("profiles/b.yaml", "profiles/c.yaml")]);
    let text = stderr(&typed(here, &["sweep", "sweep.yaml", "-o", "new"]));
    assert!(text.contains("classes.yaml: the file that `profile` names cannot be read"), "{text}");
}

#[test]
fn of_a_mixed_swarm_the_robot_of_one_class_is_validated_by_that_classes_trials() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let here = folder.path();
    files(here, &[]);
    write(
        here,
        &[("alike.yaml", &SWEEP.replace("world: classes.yaml", "world: alike_classes.yaml"))],
    );
    write(here, &[("alike_classes.yaml", CLASSES)]);
    with_profiles(here);
    done(here, &["sweep", "sweep.yaml", "-o", "out"]);
    done(here, &["episode", "out", "--cell", "robots=5", "--replicate", "1", "-o", "run"]);
    let validate = |sweep: &str, more: &[&str]| {
        let few = ["validate", sweep, "--trajectories", "run", "--simulated", "--robots", "200"];
        typed(here, &[&few[..], more].concat())
    };

    let nobody = validate("out", &[]);
    let other = validate("out", &["--class", "c"]);
    let of_class = validate("out", &["--class", "b", "--format", "json"]);
    let mixed = validate("alike.yaml", &["-o", "validation"]);

    let text = stderr(&nobody);
    let expected = "out has classes with profiles of their own, so it has several simulated robots";
    assert!(code(&nobody) == 1 && text.contains(expected), "{text}");
    assert!(text.contains("`--class a` or `--class b`"), "{text}");
    let text = stderr(&other);
    assert!(text.contains("there is no class `c`") && text.contains("classes are: a, b"), "{text}");
    assert!([0, 3].contains(&code(&of_class)), "{}", stderr(&of_class));
    let answer = json(&of_class);
    assert_eq!(answer["class"], "b");
    let robots: Vec<&str> = answer["robots"]
        .as_array()
        .expect("a list")
        .iter()
        .map(|robot| robot["robot"].as_str().expect("a name"))
        .collect();
    assert_eq!(robots, ["robot_2", "robot_4"]);
    let svg = text_in(here, "out/diagram.svg");
    assert!(svg.contains("trials inside the simulated 99 % reach (class b)"), "{svg}");
    let text = stderr(&mixed);
    let expected =
        "run: its robots are not alike: robot_2, robot_4 are of another profile than robot_1";
    assert!(code(&mixed) == 1 && text.contains(expected), "{text}");
    assert!(text.contains("`rsrs validate --class NAME`"), "{text}");
}

#[test]
fn a_fleet_that_is_not_in_the_order_of_its_names_has_no_classes() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let cell = "cell: {robots: 5, arena_m: 3}\ncontroller: ../sort.yaml\nworld: ../classes.yaml";
    let swapped = [
        ("from: ../out", cell),
        ("  robot_1: {", "  robot_0: {"),
        ("  robot_2: {", "  robot_1: {"),
        ("  robot_0: {", "  robot_2: {"),
    ];
    let file = files(folder.path(), &swapped);

    let mut command = confined_rsrs();
    command.arg("run").arg(&file);
    let output = command.output().expect("the program was built for this test");

    assert!(!output.status.success(), "{}", stdout(&output));
    let expected = "robots are dealt to 2 classes of robots in the order of the fleet, and robot_1 is listed \
                    after robot_2";
    let text = stderr(&output);
    assert!(text.contains(expected) && text.contains("in the order of their names"), "{text}");
}
