//! A robot of another maker, without a gate of ours in front of its wheels, beside one of ours: its
//! controller holds the lease, and sends zero when it ends.
//!
//! The test plays both bases. That of the foreign robot turns its wheels as it was commanded last,
//! until it is commanded otherwise.

use std::path::{Path, PathBuf};
use std::process::{Output, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use crate::fleet::{ROBOTS, experiment, start_run};
use crate::processes::{Process, assert_completed, in_own_network, rsrs, run_in_lockstep};
use crate::recorded::record_of;
use rsrs_bags::Bag;
use rsrs_fleet::record::{Backend, ENDING, Ending, EndingKind};
use rsrs_msgs::geometry_msgs::Twist;
use rsrs_msgs::nav_msgs::Odometry;
use rsrs_msgs::sensor_msgs::Range;
use rsrs_msgs::std_msgs::Bool;
use rsrs_msgs::topics::{self, Qos, Topic};
use rsrs_ros::session::{NodeHandle, Publisher, Session, Subscription};
use rsrs_testing::network::{eventually, session};

const OURS: &str = ROBOTS[0];
const FOREIGN: &str = ROBOTS[1];
/// A lease, from the status that was echoed last.
const LEASE: Duration = Duration::from_millis(500);
/// What a busy machine adds to a bound of the protocol.
const SLACK: Duration = Duration::from_millis(400);
/// Interval of detections.
const PERIOD: Duration = Duration::from_millis(130);
/// So long that no run of a test comes to its end.
const ENDLESS_S: u64 = 1_000;

/// What the wheels of a robot are commanded.
#[derive(Clone, Copy, Default)]
struct ReceivedCommands {
    n_commands: u64,
    is_moving: bool,
    moved: Option<Instant>,
}

/// The wheels of both robots, ours first.
type Wheels = Arc<Mutex<[ReceivedCommands; 2]>>;

fn lock(wheels: &Wheels) -> MutexGuard<'_, [ReceivedCommands; 2]> {
    wheels.lock().unwrap_or_else(PoisonError::into_inner)
}

struct Bases {
    wheels: Wheels,
    range: Publisher<Range>,
    detection: Publisher<Bool>,
    poses: [Publisher<Odometry>; 2],
    /// Whether the foreign robot has lost its power.
    is_dead: Arc<AtomicBool>,
    _commands: [Subscription; 2],
}

impl Bases {
    fn new(session: &Session) -> Self {
        let node = session.node("/", "bases").expect("the name is allowed");
        let wheels = Wheels::default();
        let range = topics::HARDWARE_RANGE.for_robot(OURS);
        let detection = topics::DETECTION;
        let pose = |robot: &str| {
            let topic = topics::ODOM;
            session.publish_on(&node, &topic.for_robot(robot), topic.qos).expect("it is allowed")
        };
        let detection = session.publish_on(&node, &detection.for_robot(FOREIGN), detection.qos);
        Self {
            range: session.publish_on(&node, &range, Qos::best_effort(10)).expect("it is allowed"),
            detection: detection.expect("the topic is allowed"),
            poses: [pose(OURS), pose(FOREIGN)],
            is_dead: Arc::default(),
            _commands: [
                obey(session, &node, 0, OURS, topics::HARDWARE_CMD_VEL_UNSTAMPED, &wheels),
                obey(session, &node, 1, FOREIGN, topics::CMD_VEL_UNSTAMPED, &wheels),
            ],
            wheels,
        }
    }

    /// Nobody sees anything, and nobody is moved.
    async fn live(&self) {
        let mut beat = tokio::time::interval(PERIOD);
        loop {
            beat.tick().await;
            let nothing = Range { range: 2.0, max_range: 2.0, ..Range::default() };
            self.range.publish(nothing).await.expect("a healthy network");
            let n_alive = if self.is_dead.load(Ordering::Relaxed) { 1 } else { 2 };
            if n_alive == 2 {
                self.detection.publish(Bool { data: false }).await.expect("a healthy network");
            }
            for (robot, publisher) in self.poses.iter().enumerate().take(n_alive) {
                let mut odometry = Odometry::default();
                odometry.pose.pose.position.x = robot as f64;
                odometry.pose.pose.orientation.w = 1.0;
                publisher.publish(odometry).await.expect("a healthy network");
            }
        }
    }
}

fn obey(
    session: &Session,
    node: &NodeHandle,
    robot: usize,
    name: &str,
    topic: Topic,
    wheels: &Wheels,
) -> Subscription {
    let wheels = wheels.clone();
    let subscription = session.subscribe(node, &topic.for_robot(name), topic.qos, move |sample| {
        let twist: Twist = sample.message;
        let given = &mut lock(&wheels)[robot];
        given.n_commands += 1;
        given.is_moving = twist != Twist::default();
        if given.is_moving {
            given.moved = Some(Instant::now());
        }
    });
    subscription.expect("the topic is allowed")
}

/// An experiment of two robots, of which the second one has no gate of ours.
fn two_robots(folder: &Path, duration_s: u64) -> PathBuf {
    let changes = [
        ("robots: 9", "robots: 2"),
        ("time: lockstep", "time: real_time"),
        ("driver: {kind: virtual}", "driver: {kind: ros}"),
        (
            "robot_2: {enabled: true, type: flockbot}",
            "robot_2: {enabled: true, type: flockbot, cmd_vel: twist, lease: controller}",
        ),
    ];
    experiment(folder, duration_s, &changes)
}

fn node_of(arguments: &[&str]) -> Process {
    let mut command = rsrs();
    command.arg("node").args(arguments).stdout(Stdio::null());
    Process(command.spawn().expect("the program was built for this test"))
}

fn our_robot() -> Process {
    node_of(&["robot", "--interface", "127.0.0.1", "--robots", OURS, "--driver", "ros"])
}

/// The controller of the foreign robot.
fn controller(more: &[&str]) -> Process {
    let arguments = ["controller", "--interface", "127.0.0.1", "--robots", FOREIGN, "--ros-args"];
    node_of(&[&arguments[..], &["-p", "cmd_vel_type:=twist"], more].concat())
}

struct Story<'a> {
    folder: &'a Path,
    wheels: Wheels,
    is_dead: Arc<AtomicBool>,
    n_runs: usize,
}

impl Story<'_> {
    fn start_run(&mut self, duration_s: u64) -> (Process, PathBuf) {
        self.n_runs += 1;
        let bag = self.folder.join(format!("bag_{}", self.n_runs));
        let experiment = two_robots(self.folder, duration_s);
        (start_run(&experiment, &bag), bag)
    }

    async fn until_both_move(&self) {
        *lock(&self.wheels) = <[ReceivedCommands; 2]>::default();
        eventually("both robots are commanded to move", || {
            lock(&self.wheels).iter().all(|given| given.is_moving)
        })
        .await;
    }

    /// Both have been commanded to stand within a bound.
    fn judge(&self, since: Instant, bound: Duration, what: &str) {
        for (given, robot) in lock(&self.wheels).iter().zip([OURS, FOREIGN]) {
            assert!(!given.is_moving, "{what}: {robot} is commanded to move");
            let took = given.moved.map(|moved| moved.saturating_duration_since(since));
            assert!(took.is_some_and(|took| took <= bound), "{what}: {robot} after {took:?}");
        }
    }
}

async fn stop(more: &[&str]) -> Output {
    let mut command = rsrs();
    command.args(["stop", "--interface", "127.0.0.1"]).args(more);
    let stopping = tokio::task::spawn_blocking(move || command.output());
    stopping.await.expect("it does not panic").expect("the program was built for this test")
}

#[test]
fn the_controller_of_a_robot_without_a_gate_holds_its_lease() {
    in_own_network(async || {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let session = session();
        let bases = Bases::new(&session);
        let (wheels, is_dead) = (bases.wheels.clone(), bases.is_dead.clone());
        let story = Story { folder: folder.path(), wheels, is_dead, n_runs: 0 };
        tokio::select! {
            () = bases.live() => {}
            () = play(story) => {}
        }
        drop(bases);
        session.close().await;
    });
}

/// A folder with a fleet of one foreign robot that nobody has measured, and a plan of two trials.
fn unmeasured() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let write = |name: &str, text: &str| {
        std::fs::write(folder.path().join(name), text).expect("writable");
    };
    let fleet = format!(
        "fileversion: 1\nall: {{driver: {{kind: ros}}, cmd_vel: twist, lease: controller}}\n\
         robots:\n  {FOREIGN}: {{enabled: true}}\n"
    );
    write("fleet.yaml", &fleet);
    std::fs::create_dir(folder.path().join("trials")).expect("writable");
    let speed = "robot,commanded_m_s,distance_m,duration_s,lateral_m,heading_change_rad,paused_s";
    write("trials/speed.csv", &format!("{speed}\n{FOREIGN},0.2,0.8,,,,\n"));
    let detection = "robot,distance_m,bearing_rad,samples,detections";
    write("trials/detection.csv", &format!("{detection}\n{FOREIGN},,,20,\n"));
    write("trials/period.csv", &format!("robot,period_s\n{FOREIGN},\n{FOREIGN},\n"));
    folder
}

#[test]
fn a_trial_in_which_commands_paused_is_made_again() {
    in_own_network(async || {
        let folder = unmeasured();
        let session = session();
        let bases = Bases::new(&session);
        let (wheels, is_dead) = (bases.wheels.clone(), bases.is_dead.clone());
        tokio::select! {
            () = bases.live() => {}
            () = paused(folder.path(), &wheels, &is_dead) => {}
        }
        drop(bases);
        session.close().await;
    });
}

async fn paused(folder: &Path, wheels: &Wheels, is_dead: &AtomicBool) {
    let mut command = rsrs();
    command.current_dir(folder).args(["measure", "drive", "fleet.yaml", "--plan", "trials"]);
    command.args(["--backend", "fleet", "--interface", "127.0.0.1", "--place-command", "true"]);
    let drive = Process::start(command.stdin(Stdio::null()));
    eventually("the robot is commanded to move", || lock(wheels)[1].is_moving).await;
    tokio::time::sleep(Duration::from_secs(1)).await;
    is_dead.store(true, Ordering::Relaxed);
    tokio::time::sleep(Duration::from_millis(600)).await;
    is_dead.store(false, Ordering::Relaxed);
    let (code, printed) = drive.ended().await;

    assert_completed(code, &printed);
    assert!(printed.contains("trials/speed.csv:2: commands paused for "), "{printed}");
    assert!(printed.contains("it is made again"), "{printed}");
    let limits = "robot_2 has no profile yet; its limits are those of the trials, 0.2 m/s";
    assert!(printed.contains(limits), "{printed}");
    let read = |name: &str| {
        std::fs::read_to_string(folder.join("trials").join(name)).expect("it is there")
    };
    let speed = read("speed.csv");
    let fields: Vec<&str> = speed.lines().nth(1).expect("one row").split(',').collect();
    assert!(!fields[3].is_empty() && fields[6].is_empty(), "{speed}");
    assert!(folder.join("trials/bags/speed_2_2").exists(), "the second trial has a bag, too");
    assert!(read("detection.csv").contains(&format!("{FOREIGN},,,20,0")), "{printed}");
    for row in read("period.csv").lines().skip(1) {
        let period_s: f64 = row.split(',').nth(1).expect("a period").parse().expect("a number");
        assert!((0.05..0.3).contains(&period_s), "{row}");
    }
}

async fn play(mut story: Story<'_>) {
    let _ours = our_robot();
    // Whoever forgets it is shown what to type.
    let careless = controller(&[]);
    let (run, _) = story.start_run(ENDLESS_S);
    let (code, printed) = run.ended().await;
    assert_eq!(code, Some(1), "{printed}");
    assert!(printed.contains("robot_2: nobody holds its lease"), "{printed}");
    assert!(printed.contains("-p lease:=controller"), "{printed}");
    drop(careless);

    // The runner is killed: what the controller sends is zero when the lease has run out.
    let _holding = controller(&["-p", "lease:=controller"]);
    let (mut run, _) = story.start_run(ENDLESS_S);
    story.until_both_move().await;
    run.0.kill().expect("it is our child");
    let killed = Instant::now();
    tokio::time::sleep(LEASE + 2 * SLACK).await;
    story.judge(killed, LEASE + SLACK, "without its runner");

    // A stop stops it, and it acknowledges.
    let (run, _) = story.start_run(ENDLESS_S);
    story.until_both_move().await;
    let stopped = Instant::now();
    let answer = stop(&[]).await;
    let text = String::from_utf8_lossy(&answer.stdout).into_owned();
    assert!(answer.status.success() && text.contains(FOREIGN), "{text}");
    let bound = Duration::from_secs(2) + SLACK;
    story.judge(stopped, bound, "after a stop");
    let (_, printed) = run.ended().await;
    assert!(printed.contains("e-stop"), "{printed}");
    assert!(stop(&["--release"]).await.status.success());

    // A robot that dies under its controller's eyes is lost, and its bag states when.
    let (run, bag) = story.start_run(ENDLESS_S);
    story.until_both_move().await;
    story.is_dead.store(true, Ordering::Relaxed);
    let (code, printed) = run.ended().await;
    story.is_dead.store(false, Ordering::Relaxed);
    assert_eq!(code, Some(1), "{printed}");
    assert!(
        printed.contains("lost robot_2") && printed.contains("no detection received"),
        "{printed}"
    );
    let bag = Bag::open(&bag).expect("the run was recorded");
    let ending = bag.metadata(ENDING).expect("it states how it ended");
    let ending = Ending::from_pairs(ending).expect("it reads");
    assert_eq!(ending.kind, EndingKind::Aborted, "{ending:?}");
    assert!(ending.lost.len() == 1 && ending.lost[0].robot == FOREIGN, "{ending:?}");

    // A run to its end states who held which lease, and so does its bag.
    let (run, bag) = story.start_run(4);
    story.until_both_move().await;
    let (code, printed) = run.ended().await;
    assert_completed(code, &printed);
    story.judge(Instant::now(), SLACK, "after a run");
    assert!(printed.contains("lease: gate on robot_1"), "{printed}");
    assert!(printed.contains("robot_2: lease: controller only"), "{printed}");
    let (_, record) = record_of(&bag);
    assert_eq!(
        (record.backend, record.controller_only),
        (Backend::Fleet, vec![FOREIGN.to_owned()])
    );
}

#[test]
fn robots_that_take_commands_without_a_stamp_are_rehearsed_in_the_simulator() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let unstamped = ("type: flockbot}", "type: flockbot, cmd_vel: twist}");
    let file = experiment(folder.path(), 62, &[("robots: 9", "robots: 3"), unstamped]);

    run_in_lockstep(&file, &[], &folder.path().join("bag"));
}
