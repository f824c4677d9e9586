//! Arenas that are no squares, obstacles, and robots that fail: from the sweep to the label, and over ROS 2.

use std::path::{Path, PathBuf};

use crate::command::{code, done, json, rsrs as typed, stderr, stdout, text_in, write};
use crate::fleet::{experiment, usual_sensing};
use crate::processes::{confined_rsrs, run_in_lockstep};
use crate::recorded::{
    assert_commands_of_replicate, assert_digests_of_replicate, assert_objects_of_replicate,
    record_of,
};

/// A sensor that tells robots, objects and walls from each other, and sees through none.
const SENSORS: &str = "\
sensors:
  - one_of:
      - {name: detection, detects: robot, true_positive: 0.95, false_positive: 0.02}
      - {name: object, detects: object, true_positive: 0.97, false_positive: 0.01}
      - {name: wall, detects: wall, true_positive: 0.97, false_positive: 0.01}
    cone: {half_angle_rad: 0.1, range_m: 1.5}
    hidden_by: [robot, object, wall]
";

/// Who has an object ahead pushes it, and turns back where a wall is.
const TABLE: &str = "\
rows:
  - {when: {wall: true}, command: {speed_m_s: 0.05, turn_rate_rad_s: 1.5}}
  - {when: {object: true}, command: {speed_m_s: 0.2, turn_rate_rad_s: 0.0}}
  - {when: {detection: true}, command: {speed_m_s: 0.1, turn_rate_rad_s: -1.0}}
  - {command: {speed_m_s: 0.1, turn_rate_rad_s: 0.8}}
";

/// An L with a pillar and a triangle, in which the second robot stops.
const WORLD: &str = "\
arena: {polygon_m: [[-1.3, -1.3], [1.3, -1.3], [1.3, 0.3], [0.3, 0.3], [0.3, 1.3], [-1.3, 1.3]]}
obstacles:
  - {place_m: [-0.6, 0.9], radius_m: 0.15}
  - {polygon_m: [[0.7, -0.9], [1.1, -0.9], [0.9, -0.6]]}
objects:
  - {count: 10, radius_m: 0.06}
failures:
  - {robot: 2, at_s: 15, stops: true}
  - {count: 1, at_s: 30, sensors_stick: true}
";

const SPREADING: &str = "\
name: spreading
words: {noun: spreading, swarm: a swarm that spreads, verb: [spread, spreads, spread]}
phases: [{key: spread}, {key: narrow}]
rules: [{phase: spread, when: {visited: {at_least: 0.01}, wall_distance_m: {at_least: 0.01}}}]
otherwise: narrow
";

const PLACEMENT: &str = "{kind: box_facing_any_way, width_m: 2, height_m: 2}";

const SWEEP: &str = "\
profile: profiles/flockbot.yaml
controller: push.yaml
behaviour: spreading.yaml
world: room.yaml
axes: {robots: [3, 4]}
fixed: {walls: clamp}
placement: {kind: box_facing_any_way, width_m: 2, height_m: 2}
harsher: none
replicates: 4
duration_s: 70
seed: 3
";

/// A sweep of such robots, and an experiment whose cell is from it.
fn files(folder: &Path) -> PathBuf {
    write(
        folder,
        &[
            ("push.yaml", TABLE),
            ("room.yaml", WORLD),
            ("spreading.yaml", SPREADING),
            ("sweep.yaml", SWEEP),
        ],
    );
    let sensing = usual_sensing();
    let usual = "cell: {speed_m_s: 0.15, turn_rate_rad_s: 0.75, robots: 9}";
    let placement = ("{kind: disc_facing_out, radius_m: 0.825}", PLACEMENT);
    experiment(folder, 70, &[(usual, "from: ../out"), placement, (sensing.as_str(), SENSORS)])
}

#[test]
fn an_arena_with_obstacles_over_ros_2_in_lockstep_is_the_replicate_to_the_bit() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let here = folder.path();
    let file = files(here);
    done(here, &["sweep", "sweep.yaml", "-o", "out"]);
    let chosen = typed(here, &["choose", "out", "--confirm", "50", "-o", "out/choice.json"]);
    assert!([0, 3].contains(&code(&chosen)), "{}{}", stdout(&chosen), stderr(&chosen));
    let path = here.join("bag");

    run_in_lockstep(&file, &[], &path);

    let (bag, record) = record_of(&path);
    let expected = "a polygon of 6 corners, 2 obstacles, 10 objects and 2 failures";
    assert_eq!(record.conditions.world.in_words(), expected);
    assert_digests_of_replicate(&bag, &record);
    assert_commands_of_replicate(&bag, &record);
    assert!(assert_objects_of_replicate(&bag, &record) >= 1, "some were pushed");
    let labelled = json(&typed(here, &["label", "bag", "--format", "json"]))[0].clone();
    assert!(labelled["evidence"]["wall_distance_m"].is_f64(), "{labelled:#}");
    assert!(!labelled.to_string().contains("stood"), "it is known that it stands: {labelled:#}");
    let compare = ["compare", "out", "--bags", "bag", "--margin", "0.3", "--format", "json"];
    let compared = json(&typed(here, &compare));
    assert!(compared["cells"][0]["real"].is_object(), "{compared:#}");
}

#[test]
fn an_arena_with_obstacles_is_in_the_picture_the_film_and_the_report() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let here = folder.path();
    files(here);
    done(here, &["sweep", "sweep.yaml", "-o", "out"]);
    let episode = ["episode", "out", "--cell", "robots=4", "--replicate", "1", "-o", "run"];
    let episode = done(here, &[&episode[..], &["--format", "json"]].concat());
    let episode: serde_json::Value = serde_json::from_str(&episode).expect("it is JSON");

    let labelled = json(&typed(here, &["label", "run", "--format", "json"]))[0].clone();
    done(here, &["draw", "run", "-o", "run.svg"]);
    done(here, &["film", "run", "-o", "run.gif", "--rate", "30", "--width", "120"]);
    done(here, &["diagram", "out", "-o", "diagram.svg"]);
    done(here, &["report", "out", "-o", "report.html"]);

    assert_eq!(labelled["evidence"], episode["evidence"], "the bag has what the simulator saw");
    let read = |name: &str| text_in(here, name);
    let svg = read("run.svg");
    assert_eq!(svg.matches("stroke=\"#8a6d4b\"").count(), 3 + 1, "the border, obstacles, legend");
    assert_eq!(svg.matches("fill=\"#d3c4b1\"").count(), 2, "each obstacle");
    assert!(svg.contains(">walls and obstacles<"), "{svg}");
    assert!(read("diagram.svg").contains("arena a polygon of 6 corners"));
    let html = read("report.html");
    assert!(html.contains("\"walls_m\":[[[-1.3,-1.3],[1.3,-1.3],"), "replays have the walls");
    assert!(!html.contains("lights up"));
}

#[test]
fn a_side_beside_an_arena_of_the_worlds_own_is_refused_and_so_are_obstacles_without_walls() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let here = folder.path();
    files(here);
    let refused = |text: &str| {
        write(here, &[("new.yaml", text)]);
        let output = typed(here, &["sweep", "new.yaml", "-o", "new"]);
        assert_ne!(code(&output), 0);
        stderr(&output)
    };

    let text = refused(&SWEEP.replace("walls: clamp", "walls: clamp, arena_m: 3"));
    let expected =
        "`arena_m` is 3 m, and the world has an arena of its own, a polygon of 6 corners";
    assert!(text.contains(expected) && text.contains("help: leave `arena_m` out"), "{text}");
    let text = refused(&SWEEP.replace("robots: [3, 4]", "robots: [3, 4], arena_m: [2, 3]"));
    assert!(text.contains("`arena_m` is 2 m, and the world has an arena"), "{text}");
    let text = refused(&SWEEP.replace("walls: clamp", "walls: none"));
    assert!(text.contains("obstacles, which are walls, and `walls` is none"), "{text}");
    assert!(text.contains("help: have robots stop or slide at walls"), "{text}");
    write(
        here,
        &[("room.yaml", &WORLD.replace("[0.3, 1.3], [-1.3, 1.3]", "[-1.3, 1.3], [0.3, 1.3]"))],
    );
    let text = refused(SWEEP);
    assert!(text.contains("room.yaml:1: the sides of `polygon_m` from"), "{text}");
    assert!(text.contains("help: give the corners in order, one way round"), "{text}");
}

#[test]
fn robots_fail_in_the_simulator_alone() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    write(folder.path(), &[("failing.yaml", "failures: [{robot: 2, at_s: 5, stops: true}]\n")]);
    let usual = "cell: {speed_m_s: 0.15, turn_rate_rad_s: 0.75, robots: 9}";
    let cell = "cell: {speed_m_s: 0.15, turn_rate_rad_s: 0.75, robots: 3}\nworld: ../failing.yaml";
    let file = experiment(folder.path(), 62, &[(usual, cell), ("kind: virtual", "kind: ros")]);

    let mut command = confined_rsrs();
    command.arg("run").arg(&file).args(["--backend", "fleet", "--interface", "127.0.0.1"]);
    let output = command.output().expect("the program was built for this test");

    assert!(!output.status.success(), "{}", stdout(&output));
    let expected =
        "robots of this world fail, and they do so where the simulator is all of the fleet";
    assert!(stderr(&output).contains(expected), "{}", stderr(&output));
    assert!(stderr(&output).contains("leave `failures` out of the `world`"), "{}", stderr(&output));
}

#[test]
fn a_search_takes_the_arena_of_the_world() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let here = folder.path();
    files(here);
    let numbered = TABLE.replace("speed_m_s: 0.2, turn", "speed_m_s: $push_m_s, turn");
    let numbered =
        format!("numbers: {{push_m_s: {{value: 0.2, from: 0.05, to: 0.25}}}}\n{numbered}");
    let square = WORLD.lines().skip(1).collect::<Vec<_>>().join("\n");
    write(here, &[("numbered.yaml", &numbered), ("square.yaml", &square)]);
    let explore = |more: &[&str]| {
        let asked = ["explore", "profiles/flockbot.yaml", "--controller", "numbered.yaml"];
        let few = ["--controllers", "4", "--replicates", "2", "--duration", "60", "--robots", "3"];
        let wanted = ["--behaviour", "spreading.yaml", "-o", "gallery"];
        typed(here, &[&asked[..], &few, &wanted, more].concat())
    };

    let neither = explore(&["--world-file", "square.yaml"]);
    let both = explore(&["--world-file", "room.yaml", "--arena", "3"]);
    let found = explore(&["--world-file", "room.yaml"]);

    assert_eq!(code(&neither), 2, "{}", stderr(&neither));
    let expected = "the world has no arena of its own, and there is no `--arena`";
    assert!(stderr(&neither).contains(expected), "{}", stderr(&neither));
    assert_ne!(code(&both), 0);
    assert!(stderr(&both).contains("`arena_m` is 3 m, and the world has"), "{}", stderr(&both));
    assert!([0, 3].contains(&code(&found)), "{}{}", stdout(&found), stderr(&found));
    let gallery = text_in(here, "gallery/gallery.svg");
    assert!(gallery.contains("fill=\"#d3c4b1\""), "runs are drawn with obstacles");
    let sweeps = std::fs::read_dir(here.join("gallery/sweeps")).expect("it is made");
    for sweep in sweeps.flatten() {
        let text = std::fs::read_to_string(sweep.path()).expect("it is text");
        assert!(text.contains("world: ../world.yaml") && !text.contains("arena_m"), "{text}");
    }
}
