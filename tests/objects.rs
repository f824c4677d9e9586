//! Worlds with objects and goals: from the sweep to the label, and over ROS 2.

use std::path::{Path, PathBuf};

use crate::command::{
    bring, code, done, json, rsrs as typed, shipped, stderr, stdout, text_in, write,
};
use crate::fleet::{ROBOTS, experiment, rewrite, usual_sensing, without_gates};
use crate::interop_robot::{controllers_with_leases, foreign_robots, python, run_on_fleet};
use crate::processes::{assert_completed, confined_rsrs, in_own_network, run_in_lockstep};
use crate::recorded::{
    assert_commands_of_replicate, assert_digests_of_replicate, assert_objects_of_replicate,
    record_of, seed_of,
};
use rsrs_bags::Bag;
use rsrs_bags::trajectory::{TrajectoryOptions, read_trajectory};
use rsrs_core::judge::trajectory::Trajectory;
use rsrs_sim::episode::run_episode;

/// One sensor that tells robots, objects and walls from each other, and one for goals.
const SENSORS: &str = "\
sensors:
  - one_of:
      - {name: detection, detects: robot, true_positive: 0.95, false_positive: 0.02}
      - {name: object, detects: object, true_positive: 0.97, false_positive: 0.01}
      - {name: wall, detects: wall, true_positive: 0.97, false_positive: 0.01}
    cone: {half_angle_rad: 0.05, range_m: 1.5}
    hidden_by: [robot, object]
  - name: goal
    detects: goal
    cone: {half_angle_rad: 0.3, range_m: 0.3}
    true_positive: 0.9
    false_positive: 0.05
";

/// Who has an object ahead pushes it, and turns back where a wall is.
const TABLE: &str = "\
rows:
  - {state: go, when: {wall: true}, command: {speed_m_s: 0.05, turn_rate_rad_s: 1.5}}
  - {state: go, when: {object: true}, command: {speed_m_s: 0.2, turn_rate_rad_s: 0.0}}
  - {state: go, when: {detection: true, goal: true}, command: {speed_m_s: 0.1, turn_rate_rad_s: -1.0}}
  - {state: go, command: {speed_m_s: 0.1, turn_rate_rad_s: 0.8}, next: {state: search, probability: 0.01}}
  - {state: search, command: {speed_m_s: 0.2, turn_rate_rad_s: 0.1}, next: {state: go, after_s: 1}}
";

const WORLD: &str = "\
objects:
  - {count: 8, radius_m: 0.06, friction: 0.1}
  - {places_m: [[0.9, 0.9]], radius_m: 0.1}
goals:
  - {place_m: [-0.6, 0.6], radius_m: 0.4}
";

const CLUSTERS: &str = "\
name: heaping
words: {noun: heaping, swarm: a swarm that heaps, verb: [heap, heaps, heaped]}
phases: [{key: heaped}, {key: strewn}]
rules: [{phase: heaped, when: {objects_clustered: {at_least: 0.5}, goal_distance_m: {below: 3}}}]
otherwise: strewn
";

/// A Flockbot with these sensors.
fn profile() -> String {
    let text = std::fs::read_to_string(shipped("profiles/flockbot.yaml")).expect("it is shipped");
    text.replace(&usual_sensing(), SENSORS)
}

/// An experiment of three such robots, where `driver` moves them.
fn files(folder: &Path, driver: &str) -> PathBuf {
    write(folder, &[("push.yaml", TABLE), ("things.yaml", WORLD), ("heap.yaml", CLUSTERS)]);
    let usual = "cell: {speed_m_s: 0.15, turn_rate_rad_s: 0.75, robots: 9}";
    let cell = "cell: {robots: 3, arena_m: 2.6}\ncontroller: ../push.yaml\nworld: \
                ../things.yaml\nbehaviour: ../heap.yaml";
    let sensing = usual_sensing();
    let driver = format!("kind: {driver}");
    let changes = [(usual, cell), (sensing.as_str(), SENSORS), ("kind: virtual", &driver)];
    experiment(folder, 62, &changes)
}

fn bits(run: &Trajectory) -> Vec<[u64; 2]> {
    run.objects_m.iter().map(|place_m| place_m.map(f64::to_bits)).collect()
}

#[test]
fn a_world_with_objects_over_ros_2_in_lockstep_is_the_replicate_to_the_bit() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = files(folder.path(), "virtual");
    let path = folder.path().join("bag");
    run_in_lockstep(&file, &[], &path);

    let (bag, record) = record_of(&path);
    assert_eq!(record.conditions.world.in_words(), "9 objects and 1 goal");
    assert_digests_of_replicate(&bag, &record);
    assert_commands_of_replicate(&bag, &record);
    let attached = bag.attachment("world.yaml").expect("the file is in the bag");
    assert_eq!(String::from_utf8_lossy(&attached.data), WORLD);
    let expected = run_episode(&record.conditions, seed_of(&record), record.duration_s);
    let expected = expected.expect("they fit");
    assert!(assert_objects_of_replicate(&bag, &record) > 1, "some were pushed");

    let recorded = read_trajectory(&bag, &TrajectoryOptions::default()).expect("it has poses");
    let n_samples = recorded.trajectory.n_samples();
    assert_eq!(recorded.trajectory.n_objects, 9);
    assert_eq!(bits(&recorded.trajectory), bits(&expected)[..9 * n_samples]);
    let labelled = typed(folder.path(), &["label", "bag", "--format", "json"]);
    assert_eq!(code(&labelled), 0, "{}", stderr(&labelled));
    assert!(json(&labelled)[0]["evidence"]["objects_clustered"].is_f64(), "{}", stdout(&labelled));
    let replay = done(folder.path(), &["replay", "bag", "--into", "controller"]);
    assert!(replay.contains(" 0 different"), "{replay}");
}

#[test]
fn objects_among_real_and_virtual_robots_are_refused_before_anything_moves() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = files(folder.path(), "virtual");
    let one_is_real = (
        "robot_1: {enabled: true, type: flockbot}",
        "robot_1: {enabled: true, type: flockbot, driver: {kind: ros}}",
    );
    rewrite(&folder.path().join("fleets/nine_virtual.yaml"), &[one_is_real]);

    let mut command = confined_rsrs();
    command.arg("run").arg(&file).args(["--backend", "fleet", "--interface", "127.0.0.1"]);
    let output = command.output().expect("the program was built for this test");

    assert!(!output.status.success(), "{}", stdout(&output));
    let expected = "there are 9 objects and 1 goal in this world, and real and virtual robots in this \
                    fleet, which cannot push the same objects";
    assert!(stderr(&output).contains(expected), "{}", stderr(&output));
}

#[test]
fn objects_among_real_robots_are_placed_and_judged_as_a_tracker_sees_them_and_missing_ones_named() {
    let python = python();
    in_own_network(async || {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let file = files(folder.path(), "ros");
        let window = ("otherwise: strewn", "otherwise: strewn\nwindow: {last_s: 10}");
        rewrite(&folder.path().join("heap.yaml"), &[window]);
        without_gates(
            folder.path(),
            &[("duration_s: 62", "duration_s: 12"), ("arena_m: 2.6", "arena_m: 12")],
        );
        let placed =
            done(folder.path(), &["place", file.to_str().expect("text"), "-o", "start.svg"]);
        assert!(placed.contains("object_9   0.900   0.900"), "{placed}");
        let _controllers = controllers_with_leases(&ROBOTS[..3], "twist_stamped");
        let robots = |n_objects: usize, frame: &str| {
            let of_robot = |robot: &&str| format!("{robot}:twist_stamped:default:default");
            let given = [
                "--further=object,wall,goal".to_owned(),
                format!("--objects={n_objects}"),
                format!("--frame={frame}"),
            ];
            let arguments = given.into_iter().chain(ROBOTS[..3].iter().map(of_robot));
            foreign_robots(&python, folder.path(), arguments)
        };

        let of_eight = robots(8, "map");
        let (code_of_run, printed, _) = run_on_fleet(&file, folder.path().join("refused"));
        assert_eq!(code_of_run, Some(1), "{printed}");
        assert!(printed.contains("/objects/object_9/pose"), "{printed}");
        assert!(!printed.contains("/objects/object_8/pose"), "{printed}");
        drop(of_eight);

        let of_ten = robots(10, "map");
        let (code_of_run, printed, _) = run_on_fleet(&file, folder.path().join("refused_too"));
        assert_eq!(code_of_run, Some(1), "{printed}");
        let strange =
            "/objects/object_10/pose: the run's world has 9 objects, object_1 to object_9";
        assert!(printed.contains(strange), "{printed}");
        drop(of_ten);

        let of_all = robots(9, "map");
        let (code_of_run, printed, bag) = run_on_fleet(&file, folder.path().join("bag"));
        assert_completed(code_of_run, &printed);
        let bag = Bag::open(&bag).expect("the run was recorded");
        let recorded = read_trajectory(&bag, &TrajectoryOptions::default()).expect("it has poses");
        let run = recorded.trajectory;
        assert_eq!(run.n_objects, 9, "{:?}", recorded.findings);
        let [first, last] = [0, run.n_samples() - 1].map(|sample| run.objects_at(sample)[0]);
        let way_m = last[1] - first[1];
        assert!((0.08..0.16).contains(&way_m), "pushed by {way_m} m in 12 s");
        let labelled = typed(folder.path(), &["label", "bag", "--format", "json"]);
        assert_eq!(code(&labelled), 0, "{}", stderr(&labelled));
        let evidence = &json(&labelled)[0]["evidence"];
        assert!(evidence["objects_clustered"].is_f64(), "{}", stdout(&labelled));
        drop(of_all);

        let _elsewhere = robots(9, "lab");
        let (code_of_run, printed, _) = run_on_fleet(&file, folder.path().join("elsewhere"));
        assert_completed(code_of_run, &printed);
        let labelled = typed(folder.path(), &["label", "elsewhere"]);
        assert_ne!(code(&labelled), 0, "{}", stdout(&labelled));
        let expected = "it is judged by objects, and poses of object_1 are in the frame `lab`, and those of \
                        robots in `map`";
        assert!(stderr(&labelled).contains(expected), "{}", stderr(&labelled));
        done(folder.path(), &["draw", "elsewhere", "-o", "run.svg"]);
    });
}

const SWEEP: &str = "\
profile: robots.yaml
controller: push.yaml
behaviour: heap.yaml
world: things.yaml
axes: {robots: [3, 4]}
fixed: {arena_m: 2.6, walls: clamp}
replicates: 4
duration_s: 70
seed: 1
";

fn swept() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    write(
        folder.path(),
        &[
            ("push.yaml", TABLE),
            ("things.yaml", WORLD),
            ("heap.yaml", CLUSTERS),
            ("robots.yaml", &profile()),
            ("sweep.yaml", SWEEP),
        ],
    );
    done(folder.path(), &["sweep", "sweep.yaml", "-o", "out"]);
    folder
}

#[test]
fn a_world_goes_from_the_sweep_to_a_labelled_and_drawn_episode() {
    let folder = swept();
    let here = folder.path();
    let kept = text_in(here, "out/sweep.yaml");
    assert!(kept.contains("count: 8") && kept.contains("radius_m: 0.06"), "{kept}");

    let episode = ["episode", "out", "--cell", "robots=3", "--replicate", "1", "-o", "run"];
    let episode = typed(here, &[&episode[..], &["--format", "json"]].concat());
    assert_eq!(code(&episode), 0, "{}", stderr(&episode));
    let labelled = typed(here, &["label", "run", "--format", "json"]);
    assert_eq!(code(&labelled), 0, "{}", stderr(&labelled));
    let of_bag = json(&labelled)[0]["evidence"].clone();
    assert_eq!(of_bag, json(&episode)["evidence"], "the bag has what the simulator saw");
    assert!(of_bag["goal_distance_m"].is_f64());

    let drawn = typed(here, &["draw", "run", "-o", "run.svg"]);
    assert_eq!(code(&drawn), 0, "{}", stderr(&drawn));
    let svg = text_in(here, "run.svg");
    assert!(svg.contains("judged for heaping; controller: a table of"), "{svg}");
    assert_eq!(svg.matches("fill=\"#e69f00\"").count(), 9 + 1, "each object, and the legend");
    assert_eq!(svg.matches("stroke-dasharray=\"5 3\"").count(), 1, "the goal");
    done(here, &["film", "run", "-o", "run.gif", "--rate", "30", "--width", "120"]);
}

#[test]
fn the_only_cell_of_a_sweep_needs_no_name_and_its_only_run_does_not_settle_anything() {
    let folder = swept();
    let here = folder.path();
    let single = SWEEP.replace("robots: [3, 4]", "robots: [3]");
    let single = single.replace("replicates: 4", "replicates: 1").replace(": 70", ": 120");
    write(here, &[("single.yaml", &single)]);
    let swept = typed(here, &["sweep", "single.yaml", "-o", "single"]);

    let only = ["episode", "single", "--replicate", "0", "-o", "only", "--format", "json"];
    let only = typed(here, &only);
    let of_two = typed(here, &["episode", "out", "--replicate", "0", "-o", "of_two"]);

    assert_eq!((code(&swept), code(&only)), (0, 0), "{}{}", stderr(&swept), stderr(&only));
    assert_eq!(json(&only)["cell"]["robots"], 3.0);
    assert!(json(&only)["settling"].is_null(), "{}", stdout(&only));
    let svg = text_in(here, "single/diagram.svg");
    assert!(svg.contains("objects"), "what is in the world is stated: {svg}");
    assert_eq!(code(&of_two), 1);
    assert!(stderr(&of_two).contains("no cell is named"), "{}", stderr(&of_two));
}

#[test]
fn another_world_is_another_sweep() {
    let folder = swept();
    let here = folder.path();
    write(here, &[("things.yaml", &WORLD.replace("count: 8", "count: 7"))]);

    let again = typed(here, &["sweep", "sweep.yaml", "-o", "out"]);
    assert_ne!(code(&again), 0);
    assert!(
        stderr(&again).contains("world.objects[0].count is 8 there, and 7 here"),
        "{}",
        stderr(&again)
    );
    let other = typed(here, &["sweep", "sweep.yaml", "-o", "other"]);
    assert_eq!(code(&other), 0, "{}", stderr(&other));
    let differ = typed(here, &["diff", "out", "other", "--format", "json"]);
    let changed = json(&differ)["changed"].to_string();
    assert!(changed.contains("world.objects[0].count"), "{changed}");
}

#[test]
fn a_behaviour_over_objects_without_a_world_and_a_wrong_file_have_a_cure() {
    let folder = swept();
    let here = folder.path();
    bring("profiles/flockbot.yaml", &here.join("plain.yaml"));
    let without = SWEEP
        .replace("robots.yaml", "plain.yaml")
        .replace("controller: push.yaml\n", "")
        .replace("world: things.yaml\n", "")
        .replace("fixed: {", "fixed: {speed_m_s: 0.15, turn_rate_rad_s: 0.75, ");
    write(here, &[("without.yaml", &without), ("wrong.yaml", &WORLD.replace("-0.6", "-1.6"))]);
    let refused = |text: &str| {
        write(here, &[("new.yaml", text)]);
        let output = typed(here, &["sweep", "new.yaml", "-o", "new"]);
        assert_ne!(code(&output), 0);
        stderr(&output)
    };

    let text = refused(&without);
    assert!(text.contains("objects_clustered is of objects, and there are none"), "{text}");
    assert!(text.contains("help: name a world that has some: `world: world.yaml`"), "{text}");
    let text = refused(&SWEEP.replace("things.yaml", "wrong.yaml"));
    let expected = "wrong.yaml:5: a goal of radius 0.4 m at (-1.6, 0.6) m is not within the arena of \
                    2.6 m";
    assert!(text.contains(expected) && text.contains("help: move it"), "{text}");
    let text = refused(&SWEEP.replace("world: things.yaml\n", ""));
    assert!(text.contains("sensor `detection` detects objects, and there are none"), "{text}");
    assert!(text.contains("help: name a world with `objects`"), "{text}");
}

#[test]
fn a_file_that_a_sweep_names_and_that_is_not_there_is_named_with_its_key() {
    let folder = swept();
    let here = folder.path();

    for (key, file) in [
        ("profile", "robots.yaml"),
        ("controller", "push.yaml"),
        ("behaviour", "heap.yaml"),
        ("world", "things.yaml"),
    ] {
        write(here, &[("new.yaml", &SWEEP.replace(file, "nowhere.yaml"))]);
        let output = typed(here, &["sweep", "new.yaml", "-o", "new"]);

        assert_eq!(code(&output), 1);
        let text = stderr(&output);
        let expected = format!("error: new.yaml: the file that `{key}` names cannot be read\n");
        assert!(text.starts_with(&expected) && text.contains("cannot read nowhere.yaml"), "{text}");
        assert!(
            text.contains("help: write its path as it is from the folder of new.yaml"),
            "{text}"
        );
    }
}

#[test]
fn a_file_that_an_experiment_names_and_that_is_not_there_is_named_with_its_key() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = files(folder.path(), "virtual");
    let text = std::fs::read_to_string(&file).expect("it was written");

    for (key, name) in
        [("controller", "push.yaml"), ("behaviour", "heap.yaml"), ("world", "things.yaml")]
    {
        std::fs::write(&file, text.replace(name, "nowhere.yaml")).expect("the folder is writable");
        let path = file.to_str().expect("the path is text");
        let output = typed(folder.path(), &["run", path, "-o", "bag"]);

        assert_eq!(code(&output), 1, "{}", stdout(&output));
        let expected = format!("the file that `{key}` names cannot be read\n");
        let text = stderr(&output);
        assert!(text.contains(&expected) && text.contains("nowhere.yaml"), "{text}");
    }
}

#[test]
fn a_search_that_finds_nothing_does_not_say_that_it_did() {
    let folder = swept();
    let never = CLUSTERS.replace("{at_least: 0.5}", "{at_least: 1}");
    write(folder.path(), &[("never.yaml", &never)]);
    let asked = ["explore", "robots.yaml", "--controller", "numbered.yaml", "-o", "gallery"];
    let few = ["--controllers", "4", "--replicates", "2", "--duration", "60", "--robots", "3"];
    let world = ["--behaviour", "never.yaml", "--arena", "2.6", "--world-file", "things.yaml"];
    write(folder.path(), &[("numbered.yaml", &numbered())]);

    let output = typed(folder.path(), &[&asked[..], &few, &world].concat());

    assert_eq!(code(&output), 3, "{}{}", stdout(&output), stderr(&output));
    let text = stdout(&output);
    assert!(text.contains("nearest to heaping: 0.0 % of 200 fresh runs"), "{text}");
    assert!(text.contains("next: the same command with `--controllers 20`"), "{text}");
    let page = std::fs::read_to_string(folder.path().join("gallery/gallery.html"));
    assert!(page.expect("it is written").contains("nearest to heaping"));
}

/// The table with a number to search.
fn numbered() -> String {
    let numbered = TABLE.replace(
        "speed_m_s: 0.2, turn_rate_rad_s: 0.0",
        "speed_m_s: $push_m_s, turn_rate_rad_s: 0.0",
    );
    format!("numbers: {{push_m_s: {{value: 0.2, from: 0.05, to: 0.25}}}}\n{numbered}")
}

#[test]
fn a_search_has_a_world_and_a_report_shows_it() {
    let folder = swept();
    let here = folder.path();
    write(here, &[("numbered.yaml", &numbered())]);
    let explore = |more: &[&str]| {
        let asked = ["explore", "robots.yaml", "--controller", "numbered.yaml", "-o", "gallery"];
        let few = ["--controllers", "6", "--replicates", "2", "--duration", "60", "--robots", "3"];
        typed(here, &[&asked[..], &few, &["--behaviour", "heap.yaml"], more].concat())
    };

    let without = explore(&["--arena", "2.6"]);
    let found = explore(&["--arena", "2.6", "--world-file", "things.yaml"]);
    let report = typed(here, &["report", "out", "-o", "report.html"]);

    assert_eq!(code(&without), 1);
    assert!(stderr(&without).contains("help: name a world with `"), "{}", stderr(&without));
    assert!([0, 3].contains(&code(&found)), "{}{}", stdout(&found), stderr(&found));
    let read = |name: &str| text_in(here, name);
    assert!(read("gallery/world.yaml").contains("count: 8"));
    let gallery = read("gallery/gallery.svg");
    assert!(gallery.contains("fill=\"#e69f00\""), "runs are drawn with their objects: {gallery}");
    let sweeps = std::fs::read_dir(here.join("gallery/sweeps")).expect("it is made");
    let sweeps: Vec<PathBuf> = sweeps.flatten().map(|sweep| sweep.path()).collect();
    for sweep in &sweeps {
        let text = std::fs::read_to_string(sweep).expect("it is text");
        assert!(text.contains("world: ../world.yaml"), "{text}");
    }
    assert_eq!(code(&report), 0, "{}", stderr(&report));
    let html = read("report.html");
    assert_eq!(html.matches("\"radii_m\":[0.06,").count(), 2, "a replay of each cell");
    assert!(html.contains("\"goals_m\":[[-0.6,0.6,0.4]]") && !html.contains("lights up"));
}
