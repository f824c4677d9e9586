//! Many robots: separate processes on one machine that start, match and run an experiment, and a
//! hundred simulated ones that are found, set and driven.
//!
//! How long it takes is not asserted; `rsrs run --format json` reports it (`preflight_s`,
//! `parameters_s`).
//! `RSRS_ROBOT_PROCESSES` sets how many robots have their own process and participant, with their
//! own controller in it, as on a floor. One base for all of them moves nobody: how robots sense and
//! drive is others' business.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::time::Duration;

use crate::fleet::{experiment, start_run};
use crate::processes::{Process, assert_completed, in_own_network, rsrs};
use rsrs_bags::Bag;
use rsrs_fleet::record::{ENDING, Ending, EndingKind};
use rsrs_msgs::geometry_msgs::Twist;
use rsrs_msgs::nav_msgs::Odometry;
use rsrs_msgs::sensor_msgs::Range;
use rsrs_msgs::topics::{self, Qos};
use rsrs_ros::session::{Publisher, Received, Session, Subscription};
use rsrs_testing::environment::number;
use rsrs_testing::network::{TIMEOUT, session};

const N_ROBOTS: usize = 6;
const RUN_S: u64 = 5;
/// Of the run of a hundred.
const LOCKSTEP_S: u64 = 2;
/// So many whole periods of 0.13 s.
const LOCKSTEP_STEPS: u64 = 15;
/// Interval of readings and poses.
const READING: Duration = Duration::from_millis(100);

fn n_robots() -> usize {
    number("RSRS_ROBOT_PROCESSES").unwrap_or(N_ROBOTS)
}

/// An experiment of so many robots with this driver: the shipped one with some changes. Also the names of the
/// robots.
fn fleet_of(
    n_robots: usize,
    driver: &str,
    duration_s: u64,
    changes: &[(&str, &str)],
    folder: &Path,
) -> (PathBuf, Vec<String>) {
    let names: Vec<String> = (1..=n_robots).map(|robot| format!("robot_{robot}")).collect();
    let robots = format!("robots: {n_robots}");
    let radius = format!("radius_m: {}", 0.3 + 0.25 * (n_robots as f64).sqrt());
    let sizes = [("robots: 9", robots.as_str()), ("radius_m: 0.825", radius.as_str())];
    let path = experiment(folder, duration_s, &[&sizes, changes].concat());
    let mut text = format!(
        "fileversion: 1\nall: {{cmd_vel: twist_stamped, pose: odom}}\nrobot_types:\n  \
        flockbot: {{profile: ../profiles/flockbot.yaml, driver: {{kind: {driver}}}}}\nrobots:\n"
    );
    for name in &names {
        writeln!(text, "  {name}: {{enabled: true, type: flockbot}}").expect("memory is there");
    }
    std::fs::write(folder.join("fleets/nine_virtual.yaml"), text).expect("writable");
    (path, names)
}

/// The process of one robot, and the file with what it writes.
struct Robot {
    process: Process,
    written: PathBuf,
}

impl Robot {
    fn start(name: &str, folder: &Path) -> Self {
        let written = folder.join(format!("{name}.log"));
        let file = std::fs::File::create(&written).expect("writable");
        let mut command = rsrs();
        command.args(["node", "robot", "--interface", "127.0.0.1", "--robots", name]);
        command.args(["--driver", "ros"]).stdout(Stdio::null()).stderr(file);
        let process = Process(command.spawn().expect("the program was built for this test"));
        Self { process, written }
    }

    /// Whether it still runs, and what it wrote.
    fn state(&mut self) -> String {
        let ended = self.process.0.try_wait().expect("it is our child");
        let written = std::fs::read_to_string(&self.written).expect("what it writes is text");
        format!("its process ended with {ended:?} and wrote:\n{written}")
    }
}

/// The distance sensors, the wheels and the poses of all robots.
struct Base {
    _wheels: Vec<Subscription>,
    ranges: Vec<Publisher<Range>>,
    poses: Vec<(Publisher<Odometry>, Odometry)>,
}

impl Base {
    fn new(session: &Session, names: &[String]) -> Self {
        let node = session.node("/", "base").expect("the name is allowed");
        let range = |name: &String| {
            let topic = topics::HARDWARE_RANGE.for_robot(name);
            session.publish_on(&node, &topic, Qos::best_effort(10)).expect("it is allowed")
        };
        let wheels = |name: &String| {
            let topic = topics::HARDWARE_CMD_VEL_UNSTAMPED;
            let obey = |_: Received<Twist>| {};
            session
                .subscribe(&node, &topic.for_robot(name), topic.qos, obey)
                .expect("it is allowed")
        };
        let pose = |(robot, name): (usize, &String)| {
            let topic = topics::ODOM;
            let publisher = session.publish_on(&node, &topic.for_robot(name), topic.qos);
            (publisher.expect("it is allowed"), start_pose(robot))
        };
        Self {
            _wheels: names.iter().map(wheels).collect(),
            ranges: names.iter().map(range).collect(),
            poses: names.iter().enumerate().map(pose).collect(),
        }
    }

    /// Publishes again and again that nobody sees anything and that nobody has moved.
    async fn speak(&self) {
        let mut readings = tokio::time::interval(READING);
        loop {
            readings.tick().await;
            for range in &self.ranges {
                let nothing = Range { range: 2.0, max_range: 2.0, ..Range::default() };
                range.publish(nothing).await.expect("a healthy network");
            }
            for (publisher, pose) in &self.poses {
                publisher.publish(pose.clone()).await.expect("a healthy network");
            }
        }
    }
}

/// On a sunflower's spiral, facing away from its centre.
fn start_pose(robot: usize) -> Odometry {
    let angle_rad = robot as f64 * 2.399_963;
    let radius_m = 0.25 * (robot as f64).sqrt();
    let (sine, cosine) = libm::sincos(angle_rad);
    let (half_sine, half_cosine) = libm::sincos(angle_rad / 2.0);
    let mut odometry = Odometry::default();
    let pose = &mut odometry.pose.pose;
    (pose.position.x, pose.position.y) = (radius_m * cosine, radius_m * sine);
    (pose.orientation.z, pose.orientation.w) = (half_sine, half_cosine);
    odometry
}

#[test]
fn many_robot_processes_on_one_machine_start_match_and_run_an_experiment() {
    in_own_network(async || {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let changes = [
            ("time: lockstep", "time: real_time"),
            // More processes than cores: a robot that gets no processor for half a second stops.
            ("robot_lost: abort", "robot_lost: note"),
        ];
        let (experiment, names) = fleet_of(n_robots(), "ros", RUN_S, &changes, folder.path());
        let session = session();
        let base = Base::new(&session, &names);
        let bag = folder.path().join("bag");

        let mut robots: Vec<Robot> =
            names.iter().map(|name| Robot::start(name, folder.path())).collect();
        tokio::select! {
            () = base.speak() => {}
            () = async {
                all_are_there(&session, &names, &mut robots).await;
                run(experiment, bag.clone()).await;
            } => {}
        }

        let bag = Bag::open(&bag).expect("the run was recorded");
        let ending = bag.metadata(ENDING).and_then(Ending::from_pairs);
        assert_eq!(ending.map(|ending| ending.kind), Some(EndingKind::Completed));
        let topics = bag.topics();
        // 7.7 in a second, on a machine that has better things to do.
        let at_least = RUN_S * 6;
        for name in &names {
            for topic in ["detection", "cmd_vel", "odom"] {
                let topic = format!("/{name}/{topic}");
                let found = topics.iter().find(|found| found.name == topic);
                let n_messages = found.map_or(0, |found| found.n_messages);
                assert!(n_messages >= at_least, "{topic}: {n_messages} messages");
            }
        }
        drop(base);
        session.close().await;
    });
}

/// Waits until every robot's process and the base have discovered each other.
async fn all_are_there(session: &Session, names: &[String], robots: &mut [Robot]) {
    for (name, robot) in names.iter().zip(robots) {
        let (status, range) =
            (topics::STATUS.for_robot(name), topics::HARDWARE_RANGE.for_robot(name));
        let found = async {
            session.wait_for_writers(&status, 1, TIMEOUT).await?;
            session.wait_for_readers(&range, 1, TIMEOUT).await
        };
        found.await.unwrap_or_else(|error| panic!("{error}; {}", robot.state()));
    }
}

/// Runs the experiment while the base goes on speaking.
async fn run(experiment: PathBuf, bag: PathBuf) {
    let running = tokio::task::spawn_blocking(move || {
        let (status, printed) = start_run(&experiment, &bag).wait();
        assert_completed(status.code(), &printed);
    });
    running.await.expect("the panic above gives the reason");
}

#[test]
fn a_hundred_robots_are_found_set_and_driven() {
    in_own_network(async || {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let (experiment, names) = fleet_of(100, "virtual", LOCKSTEP_S, &[], folder.path());
        let bag = folder.path().join("bag");

        let mut command = rsrs();
        command.arg("run").arg(&experiment).arg("-o").arg(&bag);
        let (status, printed) = Process::start(&mut command).wait();

        // A machine that has better things to do reads no 100 robots' words in time, and the run says so.
        assert_completed(status.code(), &printed);
        let topics = Bag::open(&bag).expect("the run was recorded").topics();
        for name in &names {
            for topic in ["detection", "cmd_vel", "odom"] {
                let topic = format!("/{name}/{topic}");
                let found = topics.iter().find(|found| found.name == topic);
                assert_eq!(found.map(|found| found.n_messages), Some(LOCKSTEP_STEPS), "{topic}");
            }
        }
    });
}
