//! Nodes that are started by hand, as the documentation has it.

use std::path::Path;
use std::process::{Command, Output};

use rsrs_bags::Bag;
use rsrs_core::robot::profile::RobotProfile;
use rsrs_fleet::record::{ENDING, Ending};
use rsrs_msgs::cdr;
use rsrs_msgs::nav_msgs::Odometry;

use crate::fleet::{ROBOTS, experiment, node};
use crate::processes::{Process, is_starved, rsrs};
use rsrs_testing::network::{TIMEOUT, in_own_network};

const PAGE: &str = include_str!("../docs/fleet_without_robots.md");
const PAGES_OF_RCLPY: [&str; 2] =
    [include_str!("../docs/your_robots_in_rclpy.md"), include_str!("../docs/measure_them.md")];
/// How much the page measures, and how much of that is enough to see whether it works.
const PLAN_OF_THE_PAGE: &str = "--distances 5 --bearings 3 --rate-precision 0.15";
const SHORTER_PLAN: &str = "--distances 4 --bearings 2 --rate-precision 0.25";
const RCLPY_FLEET: &str = include_str!("../docs/examples/rclpy_fleet.py");
const PROFILE: &str = include_str!("../launch_configs/profiles/flockbot.yaml");

/// What the page tells its reader to type, in its order.
fn commands_of(page: &str) -> String {
    let blocks = page.split("```sh\n").skip(1);
    blocks.map(|block| block.split("```").next().expect("a block ends")).collect()
}

/// Types it, in a folder that has what is shipped.
///
/// # Arguments
///
/// * `more` — folders in which the shell looks for programs besides ours.
fn typed(script: &str, folder: &Path, (more, patience_s): (&[&Path], u32)) -> Output {
    let ends = "trap 'kill $(jobs -p); wait' EXIT\n";
    let program = Path::new(env!("CARGO_BIN_EXE_rsrs")).parent().expect("it is in a folder");
    let path = std::env::var("PATH").expect("every shell has one");
    Command::new("timeout")
        .args([&patience_s.to_string(), "bash", "-e", "-c", &format!("{ends}{script}")])
        .env("PATH", format!("{}{}:{path}", more_of(more), program.display()))
        .env("ROS_LOG_DIR", folder.join("logs"))
        .env_remove("ROS_AUTOMATIC_DISCOVERY_RANGE")
        .env("ROS_DOMAIN_ID", "42")
        .env_remove("RSRS_INTERFACE")
        .current_dir(folder)
        .output()
        .expect("every system has bash")
}

/// Types it in a new folder; again if the machine starved a robot, which ends a run, as it should.
///
/// # Arguments
///
/// * `files` — what the reader has, by name.
fn typed_in_time(
    script: &str,
    files: &[(&str, &str)],
    limits: (&[&Path], u32),
) -> (tempfile::TempDir, Output) {
    let mut n_left = 3;
    loop {
        let folder = tempfile::tempdir().expect("a temporary folder");
        for (name, text) in files {
            std::fs::write(folder.path().join(name), text).expect("writable");
        }
        let output = typed(script, folder.path(), limits);
        let errors = String::from_utf8_lossy(&output.stderr);
        n_left -= 1;
        if output.status.success() || !is_starved(&errors) || n_left == 0 {
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
    in_own_network("by_hand::the_page_of_a_fleet_without_robots_works_to_the_letter", async || {
        let files = [("flockbot.yaml", PROFILE)];

        let (folder, output) = typed_in_time(&commands_of(PAGE), &files, (&[], 300));

        let text = String::from_utf8_lossy(&output.stdout);
        let errors = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{text}\n{errors}");
        assert_eq!(text.matches("stopped: e-stop").count(), 3, "{text}\n{errors}");
        let bag = Bag::open(&folder.path().join("bag")).expect("the run was recorded");
        let ending = Ending::from_pairs(bag.metadata(ENDING).expect("it has ended"));
        assert_eq!(ending, Some(Ending::completed()));
        for robot in &ROBOTS[..3] {
            let strayed_m = strayed_m(&bag, robot);
            assert!((0.1..2.0).contains(&strayed_m), "{robot} strayed {strayed_m} m");
        }
    });
}

#[test]
fn robots_of_a_simulator_without_a_world_are_refused() {
    in_own_network("by_hand::robots_of_a_simulator_without_a_world_are_refused", async || {
        let folder = tempfile::tempdir().expect("a temporary folder");
        // As a fleet file of real robots, on a network where only the simulator answers.
        let real = ("driver: {kind: virtual}", "driver: {kind: ros}");
        let experiment = experiment(folder.path(), 5, &[real]);
        let (_simulator, _controllers) = (node("sim", &ROBOTS), node("controller", &ROBOTS));

        let mut command = rsrs();
        command.args(["run", "--backend", "fleet", "--interface", "127.0.0.1"]);
        command.arg(experiment).arg("-o").arg(folder.path().join("bag"));
        let mut run = Process::start(&mut command);
        let (status, errors) = run.wait(2 * TIMEOUT);

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
    in_own_network("by_hand::the_pages_of_robots_in_rclpy_work_to_the_letter", async || {
        let files = [("rclpy_fleet.py", RCLPY_FLEET)];
        let mut script: String = PAGES_OF_RCLPY.map(commands_of).concat();
        if std::env::var_os("RSRS_LONG_TESTS").is_none() {
            let [plan, shorter] = [PLAN_OF_THE_PAGE, SHORTER_PLAN];
            assert!(script.contains(plan), "the page has another plan");
            script = script.replace(plan, shorter);
        }
        let programs = python.parent().expect("it is in a folder");

        let (folder, output) = typed_in_time(&script, &files, (&[programs], 1500));

        let text = String::from_utf8_lossy(&output.stdout);
        let printed = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{}\n{text}\n{printed}", output.status);
        assert!(text.contains(" rows filled in, 0 left"), "{text}");
        let profile = std::fs::read_to_string(folder.path().join("mine.yaml")).expect("it is made");
        check_profile(&RobotProfile::parse("mine.yaml", &profile).expect("it is a profile"));
        let bag = Bag::open(&folder.path().join("bag")).expect("the run was recorded");
        for robot in ROBOTS.iter().take(3) {
            assert!(strayed_m(&bag, robot) > 0.1, "{robot} did not move");
        }
    });
}
