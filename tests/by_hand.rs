//! Nodes that are started by hand, as the documentation has it.

use std::path::Path;
use std::process::{Command, Output};

use rsrs_bags::Bag;
use rsrs_core::robot::profile::RobotProfile;
use rsrs_fleet::record::{ENDING, Ending};
use rsrs_msgs::cdr;
use rsrs_msgs::nav_msgs::Odometry;
use rsrs_ros::confine;

use crate::command::{repository, stderr, stdout, text_in};
use crate::fleet::{ROBOTS, experiment, node, start_run};
use crate::pages::{
    IN_RCLPY, OF_CONTROLLERS, OF_OWN_SWARM, OF_SENSORS, OF_WORLDS, WITHOUT_FLOOR, WITHOUT_ROBOTS,
    script_of,
};
use crate::processes::{assert_completed, fail_unless_moved, in_own_network, is_starved};
use rsrs_testing::environment::is_long;

/// How much a page measures, and how much of that is enough to see whether it works.
const SHORTER_PLAN: [(&str, &str); 2] = [
    ("--robots 2 --speed", "--robots 1 --speed"),
    (
        "--distances 5 --bearings 3 --rate-precision 0.15",
        "--distances 3 --bearings 2 --rate-precision 0.25",
    ),
];
/// The same of pages that simulate.
const SHORTER_RUNS: [(&str, &str); 10] = [
    ("rsrs dry-run\n", "rsrs dry-run --experiments 1\n"),
    ("-o run.gif\n", "-o run.gif --speed 100 --width 240\n"),
    ("-o wall.png\n", "-o wall.png --replicates 20\n"),
    ("answer mine/results --format json", "answer mine/results --replicates 20"),
    ("diagnose mine/profile.yaml\n", "diagnose mine/profile.yaml --robots 7 --confirm 400\n"),
    (
        "diagnose short_sighted/profile.yaml",
        "diagnose short_sighted/profile.yaml --robots 4 --confirm 100",
    ),
    ("turn_rate_rad_s=0.75 \\\n    --cell", "turn_rate_rad_s=0.75 --margin 0.3 --cell"),
    ("-o results/gallery\n", "-o results/gallery --controllers 100 --replicates 4\n"),
    ("--behaviour milling --forward\n", "--behaviour milling --forward --controllers 200\n"),
    ("seeds: [2, 3]", "seeds: [2]"),
];
/// The same of the swarm that is written from nothing.
const FEWER_RUNS: [(&str, &str); 2] =
    [("choose results -o", "choose results --confirm 100 -o"), ("seq 11", "seq 2")];
/// The same of robots with several sensors.
const FEWER_CONFIRMED: [(&str, &str); 1] = [("--confirm 200", "--confirm 40")];
/// Its reader sees by `ros2 topic hz` that robots in rclpy are alive.
const START: &str = "<> placements &\n";
const UNTIL_ALIVE: &str = "python3 - <<'END'
import time, rclpy
rclpy.init()
reader = rclpy.create_node('reader')
while not all(reader.count_publishers(f'/robot_{n}/detection') for n in [1, 2, 3]):
    time.sleep(0.05)
END
";
const RCLPY_FLEET: &str = include_str!("../docs/examples/rclpy_fleet.py");

/// What pages have their reader type, with less to wait for where no long tests are asked for.
fn shortened(pages: &[&str], shorter: &[(&str, &str)]) -> String {
    let mut script = script_of(pages);
    if !is_long() {
        for (from, to) in shorter {
            assert_eq!(script.matches(from).count(), 1, "{pages:?} have `{from}`");
            script = script.replace(from, to);
        }
    }
    script
}

/// Types it, in a folder that has what is shipped and in a network of its own or that of its test; the shell looks for programs in
/// the folders `more`, too.
fn typed(script: &str, folder: &Path, (more, patience_s): (&[&Path], u32)) -> Output {
    let ends = "trap 'kill $(jobs -p) 2>/dev/null || true; wait' EXIT\n";
    let program = Path::new(env!("CARGO_BIN_EXE_rsrs")).parent().expect("it is in a folder");
    let path = std::env::var("PATH").expect("every shell has one");
    let mut shell = Command::new("timeout");
    shell
        .args([&patience_s.to_string(), "bash", "-e", "-c", &format!("{ends}{script}")])
        .env("PATH", format!("{}{}:{path}", more_of(more), program.display()))
        .env("ROS_LOG_DIR", folder.join("logs"))
        .env_remove("ROS_AUTOMATIC_DISCOVERY_RANGE")
        .env("ROS_DOMAIN_ID", "42")
        .env_remove("RSRS_INTERFACE")
        .current_dir(folder);
    if !confine::is_confined().expect("/proc is readable") {
        confine::start_in_own_network(&mut shell);
    }
    shell.output().expect("every system has bash")
}

/// Types it in a new folder; again if the machine starved a robot, which ends a run, or froze a world, as it should.
fn typed_in_time(script: &str, patience_s: u32) -> (tempfile::TempDir, Output) {
    let mut n_left = 3;
    loop {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let output = typed(script, folder.path(), (&[], patience_s));
        let is_late = is_starved(&stderr(&output)) || stdout(&output).contains("void: frozen");
        n_left -= 1;
        if output.status.success() || !is_late || n_left == 0 {
            return (folder, output);
        }
    }
}

fn more_of(folders: &[&Path]) -> String {
    folders.iter().map(|folder| folder.display().to_string() + ":").collect()
}

/// How far a robot was from where it stood first, at most, in metres.
fn strayed_m(bag: &Bag, robot: &str) -> f64 {
    let mut first = None;
    let mut farthest_m = 0.0_f64;
    for message in bag.messages_on([format!("/{robot}/odom")]) {
        let message = message.expect("the bag is whole");
        let odometry: Odometry = cdr::decode(&message.bytes).expect("it is odometry");
        let place = odometry.pose.pose.position;
        let (x_m, y_m) = *first.get_or_insert((place.x, place.y));
        let (dx_m, dy_m) = (place.x - x_m, place.y - y_m);
        farthest_m = farthest_m.max((dx_m * dx_m + dy_m * dy_m).sqrt());
    }
    farthest_m
}

#[test]
fn the_page_of_a_fleet_without_robots_works_to_the_letter() {
    in_own_network(async || {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let output = typed(&script_of(&WITHOUT_FLOOR), folder.path(), (&[], 300));

        let text = String::from_utf8_lossy(&output.stdout);
        let errors = String::from_utf8_lossy(&output.stderr);
        assert_completed(output.status.code(), &format!("{text}\n{errors}"));
        assert_eq!(text.matches("stopped: e-stop").count(), 3, "{text}\n{errors}");
        let bag = Bag::open(&folder.path().join("bag")).expect("the run was recorded");
        let ending = Ending::from_pairs(bag.metadata(ENDING).expect("it has ended"));
        // A busy machine may have stopped them for a moment, and they went on.
        let ending = ending.map(|ending| Ending { paused: Vec::new(), ..ending });
        assert_eq!(ending, Some(Ending::completed()));
        for robot in &ROBOTS[..3] {
            let strayed_m = strayed_m(&bag, robot);
            assert!((0.1..2.0).contains(&strayed_m), "{robot} strayed {strayed_m} m");
        }
    });
}

#[test]
fn robots_of_a_simulator_without_a_world_are_refused() {
    in_own_network(async || {
        let folder = tempfile::tempdir().expect("a temporary folder");
        // As a fleet file of real robots, on a network where only the simulator answers.
        let real = ("driver: {kind: virtual}", "driver: {kind: ros}");
        let experiment = experiment(folder.path(), 5, &[real]);
        let (_simulator, _controllers) = (node("sim", &ROBOTS), node("controller", &ROBOTS));

        let bag = folder.path().join("bag");
        let (status, errors) = start_run(&experiment, &bag).wait();

        assert_eq!(status.code(), Some(1), "{errors}");
        assert!(errors.contains("robot_9: its simulator has placed no world"), "{errors}");
    });
}

/// A fitted number of a profile, and what it was made with in the example.
fn check_profile(profile: &RobotProfile) {
    let actuation = &profile.actuation;
    let driving = actuation.turn.driving_gain_by_command.as_ref().expect("arcs were driven");
    for (what, found, made_with) in [
        ("speed", actuation.speed.gain_by_command[0].mean, 0.92),
        ("turn in place", actuation.turn.gain_by_command[0].mean, 0.95),
        ("turn while driving", driving[0].mean, 0.88),
        ("period", profile.computation.period_s / 0.1, 1.0),
        ("true positives", profile.sensing.true_positive, 0.95),
    ] {
        // A few trials on a busy machine.
        assert!((found - made_with).abs() < 0.06, "{what}: {found}, made with {made_with}");
    }
    assert!(profile.sensing.false_positive < 0.12, "{:?}", profile.sensing);
    let polygon = profile.sensing.polygon_m.as_ref().expect("it is fitted");
    let farthest_m = polygon.iter().map(|[x_m, y_m]| libm::hypot(*x_m, *y_m)).fold(0.0, f64::max);
    assert!((0.45..0.75).contains(&farthest_m), "{polygon:?}");
}

#[test]
fn the_pages_of_robots_in_rclpy_work_to_the_letter() {
    let python = crate::interop_robot::python();
    in_own_network(async || {
        let folder = tempfile::tempdir().expect("a temporary folder");
        std::fs::write(folder.path().join("rclpy_fleet.py"), RCLPY_FLEET).expect("writable");
        let script = shortened(&IN_RCLPY, &SHORTER_PLAN);
        assert_eq!(script.matches(START).count(), 1, "{script}");
        let script = script.replace(START, &format!("{START}{UNTIL_ALIVE}"));
        let programs = python.parent().expect("it is in a folder");

        let output = typed(&script, folder.path(), (&[programs], 1500));

        let text = String::from_utf8_lossy(&output.stdout);
        let printed = String::from_utf8_lossy(&output.stderr);
        assert_completed(output.status.code(), &format!("{text}\n{printed}"));
        assert!(text.contains(" rows filled in, 0 left"), "{text}");
        let profile = text_in(folder.path(), "mine.yaml");
        check_profile(&RobotProfile::parse("mine.yaml", &profile).expect("it is a profile"));
        let bag = Bag::open(&folder.path().join("bag")).expect("the run was recorded");
        for robot in ROBOTS.iter().take(3) {
            fail_unless_moved(robot, strayed_m(&bag, robot), 0.1);
        }
    });
}

#[test]
fn the_page_of_controllers_works_to_the_letter() {
    let script = script_of(&OF_CONTROLLERS);

    let (folder, output) = typed_in_time(&script, 600);

    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{}\n{errors}", output.status);
    for file in ["results/sweep.yaml", "diagram.png", "run/metadata.yaml", "run.png"] {
        assert!(folder.path().join(file).is_file(), "{file}\n{errors}");
    }
}

#[test]
fn the_page_of_ones_own_swarm_works_to_the_letter_and_finds_what_it_says() {
    let script = shortened(&OF_OWN_SWARM, &FEWER_RUNS);

    let (folder, output) = typed_in_time(&script, 900);

    let text = String::from_utf8_lossy(&output.stdout);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{}\n{text}\n{errors}", output.status);
    let read = |file: &str| {
        std::fs::read_to_string(folder.path().join(file))
            .unwrap_or_else(|error| panic!("{file}: {error}\n{errors}"))
    };
    // Who hardly tumbles mops by the errors of its sensor, and who tumbles at 0.03 without them.
    let cells = read("why/cells.csv");
    let mopped = |cell: &str| -> u32 {
        let row = cells.lines().find_map(|row| row.strip_prefix(&format!("{cell},40,")));
        let share = row.and_then(|row| row.split(',').next()?.parse().ok());
        share.unwrap_or_else(|| panic!("{cell}: {cells}"))
    };
    assert_eq!(mopped("0.0003,0.0005"), 0);
    assert!(mopped("0.0003,0.05") > 30 && mopped("0.03,0.0005") > 30, "{cells}");
    assert!(read("results/choice.json").contains("\"controller.tumble\": 0.0003"));
    assert!(text.contains("run_1: mopped"), "{text}");
    let verdict = if is_long() { "verdict: supported" } else { "2 of 2 runs mopped" };
    assert!(text.contains(verdict), "{text}");
    assert!(folder.path().join("mopped.png").is_file() && folder.path().join("why.png").is_file());
}

#[test]
fn the_page_of_sensors_takes_two_of_them_from_the_sweep_to_an_episode() {
    let script = shortened(&OF_SENSORS, &FEWER_CONFIRMED);

    let (folder, output) = typed_in_time(&script, 600);

    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{}\n{errors}", output.status);
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(text.contains(" 0 different"), "{text}");
    let bag = Bag::open(&folder.path().join("run")).expect("a bag");
    for robot in &ROBOTS[..5] {
        for topic in ["detection", "detection/wall"] {
            let name = format!("/{robot}/{topic}");
            let n_messages = bag.messages_on([name.clone()]).count();
            assert!(n_messages > 2000, "{name}: {n_messages}");
        }
    }
}

#[test]
fn the_page_of_worlds_takes_objects_from_the_sweep_to_a_picture() {
    let script = script_of(&OF_WORLDS);

    let (folder, output) = typed_in_time(&script, 600);

    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{}\n{errors}", output.status);
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(text.contains("objects_clustered"), "{text}");
    let bag = Bag::open(&folder.path().join("run")).expect("a bag");
    let n_messages = bag.messages_on(["/objects/object_20/pose"]).count();
    assert_eq!(n_messages, 6000);
    assert!(folder.path().join("run.png").is_file());
}

#[test]
fn the_pages_without_robots_work_to_the_letter() {
    let configs = repository().join("launch_configs").canonicalize().expect("it is there");
    // The README is read in a clone; the pages after it need nothing but the program.
    let link = format!("ln -s '{}' launch_configs\n", configs.display());
    let script = link + &shortened(&WITHOUT_ROBOTS, &SHORTER_RUNS);

    let (folder, output) = typed_in_time(&script, 1500);

    let text = String::from_utf8_lossy(&output.stdout);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{}\n{text}\n{errors}", output.status);
    for file in [
        "results/dry-run/diagram.png",
        "run.png",
        "run.gif",
        "mine/report.html",
        "wall.png",
        "results/gallery/gallery.html",
        "results/campaign/001_milling/manifest.json",
        "both.svg",
        "column.pdf",
        "report.html",
        "sweep.schema.json",
        "mill/metadata.yaml",
    ] {
        assert!(folder.path().join(file).is_file(), "{file}\n{text}\n{errors}");
    }
}
