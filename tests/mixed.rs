//! Real robots among virtual ones, from the first look to the label: two robots in processes of their
//! own, one with somebody's base driver and one with a microcontroller on a serial line, and three of
//! the simulator's, in one world.
//!
//! The test plays the hardware: wheels that turn as they are commanded, sensors that see the
//! other real robot, and a tracker on the ceiling, which sees nobody else.

use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use crate::command::{code, done, json, rsrs, stderr};
use crate::fleet::{ROBOTS, experiment, node, start_run};
use crate::micro::{Micro, Socket};
use crate::processes::{Process, assert_completed, in_own_network, rsrs as program};
use crate::recorded::{messages, record_of};
use rsrs_fleet::record::{Backend, ENDING, Ending, EndingKind};
use rsrs_msgs::geometry_msgs::{PoseStamped, Twist, TwistStamped};
use rsrs_msgs::sensor_msgs::Range;
use rsrs_msgs::std_msgs::Bool;
use rsrs_msgs::topics::{self, Qos};
use rsrs_ros::clock::wall_time;
use rsrs_ros::session::{Publisher, Session, Subscription};
use rsrs_testing::network::session;

/// The judge looks at a minute, and recording begins and ends in the middle of a period.
const RUN_S: u64 = 62;
const SPEED_M_S: f64 = 0.15;
/// Interval of the tracker's poses, of readings, and of the wheels' little steps.
const BEAT: Duration = Duration::from_millis(50);
/// Wheels stop by themselves.
const WHEELS_TIMEOUT: Duration = Duration::from_millis(250);
const SIGHT_M: f64 = 0.75;
const HALF_ANGLE_RAD: f64 = 0.2;
/// What tracker and world call the floor.
const FRAME: &str = "ceiling_camera";
/// The real robots; after them come those of the simulator.
const N_REAL: usize = 2;
const N_ROBOTS: usize = 5;

#[derive(Clone, Copy)]
struct StartPose {
    x_m: f64,
    y_m: f64,
    heading_rad: f64,
}

impl StartPose {
    fn drive(&mut self, (speed_m_s, turn_rate_rad_s): (f64, f64), time_s: f64) {
        let (sine, cosine) = libm::sincos(self.heading_rad);
        self.x_m += speed_m_s * cosine * time_s;
        self.y_m += speed_m_s * sine * time_s;
        self.heading_rad += turn_rate_rad_s * time_s;
    }

    /// How far away the other is, if this one looks at it.
    fn sees(&self, other: &Self) -> Option<f64> {
        let (dx_m, dy_m) = (other.x_m - self.x_m, other.y_m - self.y_m);
        let bearing_rad = libm::atan2(dy_m, dx_m) - self.heading_rad;
        let bearing_rad = libm::remainder(bearing_rad, std::f64::consts::TAU);
        let distance_m = libm::hypot(dx_m, dy_m);
        (bearing_rad.abs() < HALF_ANGLE_RAD && distance_m < SIGHT_M).then_some(distance_m)
    }

    fn message(&self) -> PoseStamped {
        let (sine, cosine) = libm::sincos(self.heading_rad / 2.0);
        let mut message = PoseStamped::default();
        message.header.stamp = wall_time();
        FRAME.clone_into(&mut message.header.frame_id);
        (message.pose.position.x, message.pose.position.y) = (self.x_m, self.y_m);
        (message.pose.orientation.z, message.pose.orientation.w) = (sine, cosine);
        message
    }
}

/// The hardware of the real robots, and the tracker above it.
struct Hardware {
    places: [StartPose; N_REAL],
    /// The last command of the first robot's base driver.
    commanded: Arc<Mutex<(Twist, Instant)>>,
    micro: Micro,
    range: Publisher<Range>,
    tracker: Vec<Publisher<PoseStamped>>,
    _commands: Subscription,
}

impl Hardware {
    fn new(session: &Session, socket: &Socket) -> Self {
        let node = session.node("/", "hardware").expect("the name is allowed");
        let commanded = Arc::new(Mutex::new((Twist::default(), Instant::now())));
        let (topic, last) = (topics::HARDWARE_CMD_VEL_UNSTAMPED, commanded.clone());
        let commands =
            session.subscribe(&node, &topic.for_robot(ROBOTS[0]), topic.qos, move |it| {
                *last.lock().unwrap_or_else(PoisonError::into_inner) = (it.message, Instant::now());
            });
        let range = topics::HARDWARE_RANGE.for_robot(ROBOTS[0]);
        let tracker = ROBOTS[..N_REAL].iter().map(|robot| {
            let topic = topics::POSE;
            session.publish_on(&node, &topic.for_robot(robot), topic.qos).expect("it is allowed")
        });
        Self {
            places: [
                StartPose { x_m: 0.3, y_m: 0.0, heading_rad: 0.0 },
                StartPose { x_m: -0.3, y_m: 0.0, heading_rad: std::f64::consts::PI },
            ],
            commanded,
            micro: Micro::plug_in(&socket.path()),
            range: session.publish_on(&node, &range, Qos::best_effort(10)).expect("it is allowed"),
            tracker: tracker.collect(),
            _commands: commands.expect("the topic is allowed"),
        }
    }

    /// What the wheels are commanded now: forward speed and turning rate.
    fn wheels(&self) -> [(f64, f64); N_REAL] {
        let (twist, at) = *self.commanded.lock().unwrap_or_else(PoisonError::into_inner);
        let is_fresh = at.elapsed() < WHEELS_TIMEOUT;
        let of_base = if is_fresh { (twist.linear.x, twist.angular.z) } else { (0.0, 0.0) };
        let (speed_mm_s, turn_rate_mrad_s) = self.micro.wheels();
        [of_base, (f64::from(speed_mm_s) / 1e3, f64::from(turn_rate_mrad_s) / 1e3)]
    }

    async fn live(&mut self) {
        let mut beat = tokio::time::interval(BEAT);
        let mut last = Instant::now();
        loop {
            beat.tick().await;
            let now = Instant::now();
            let time_s = now.duration_since(last).as_secs_f64();
            last = now;
            let wheels = self.wheels();
            for (place, wheels) in self.places.iter_mut().zip(wheels) {
                place.drive(wheels, time_s);
            }
            let [first, second] = &self.places;
            #[expect(clippy::cast_possible_truncation, reason = "the message has 32 bits")]
            let [range, max_range] =
                [first.sees(second).unwrap_or(SIGHT_M + 1.0), SIGHT_M].map(|metres| metres as f32);
            self.micro.inside().seen = if second.sees(first).is_some() { "1" } else { "0" };
            let reading = Range { range, max_range, ..Range::default() };
            self.range.publish(reading).await.expect("a healthy network");
            for (publisher, place) in self.tracker.iter().zip(&self.places) {
                publisher.publish(place.message()).await.expect("a healthy network");
            }
        }
    }
}

/// An experiment of five robots, of which the first two are real.
fn mixed_experiment(folder: &Path, port: &Path) -> PathBuf {
    let microcontroller = format!(
        "robot_2: {{enabled: true, type: flockbot, \
         driver: {{kind: serial, port: {}, baud: 115200}}}}",
        port.display()
    );
    let changes = [
        ("robots: 9", "robots: 5"),
        ("time: lockstep", "time: real_time"),
        // So near that each has others in its sensor's range wherever it turns.
        ("radius_m: 0.825", "radius_m: 0.6"),
        ("pose: odom", "pose: pose"),
        ("robot_lost: abort", "robot_lost: abort\nrecord: {topics: [/robot_1/hardware/cmd_vel]}"),
        (
            "robot_1: {enabled: true, type: flockbot}",
            "robot_1: {enabled: true, type: flockbot, driver: {kind: ros}}",
        ),
        ("robot_2: {enabled: true, type: flockbot}", &microcontroller),
    ];
    experiment(folder, RUN_S, &changes)
}

/// A real robot's process: it finds its driver in the fleet file.
fn robot_node(name: &str, folder: &Path) -> Process {
    let mut command = program();
    command.args(["node", "robot", "--interface", "127.0.0.1", "--robots", name, "--config"]);
    command.arg(folder.join("fleets/nine_virtual.yaml")).stdout(Stdio::null());
    Process(command.spawn().expect("the program was built for this test"))
}

#[test]
fn real_robots_among_virtual_ones_make_a_run_that_is_labelled_and_never_compared() {
    in_own_network(async || {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let socket = Socket::new();
        let experiment = mixed_experiment(folder.path(), &socket.path());
        let session = session();
        let mut hardware = Hardware::new(&session, &socket);
        let simulated = &ROBOTS[N_REAL..N_ROBOTS];
        let _simulated = [node("sim", simulated), node("controller", simulated)];
        let _real = [ROBOTS[0], ROBOTS[1]].map(|robot| robot_node(robot, folder.path()));

        tokio::select! {
            () = hardware.live() => {}
            () = run(folder.path().to_owned(), experiment) => {}
        }
        let bag = folder.path().join("bag");

        check_bag(&bag);
        check_label(&bag);
        check_comparison(folder.path());
        drop(hardware);
        session.close().await;
    });
}

/// Runs the experiment to its end while the hardware lives.
async fn run(folder: PathBuf, experiment: PathBuf) {
    let running = tokio::task::spawn_blocking(move || {
        let (status, printed) = start_run(&experiment, &folder.join("bag")).wait();
        assert_completed(status.code(), &printed);
    });
    running.await.expect("the panic above gives the reason");
}

fn check_bag(bag: &Path) {
    let (bag, record) = record_of(bag);
    assert_eq!(record.backend, Backend::Mixed);
    let ending = bag.metadata(ENDING).and_then(Ending::from_pairs);
    assert_eq!(ending.map(|ending| ending.kind), Some(EndingKind::Completed));

    let expected_m = SPEED_M_S * RUN_S as f64;
    for robot in &ROBOTS[..N_ROBOTS] {
        // One detection and one command in 130 ms, 7.7 in a second.
        let at_least = usize::try_from(RUN_S * 6).expect("the run is short");
        let n_detections = messages::<Bool>(&bag, robot, "detection").len();
        let commands = messages::<TwistStamped>(&bag, robot, "cmd_vel");
        let n_moving = commands.iter().filter(|command| command.twist.linear.x > 0.0).count();
        assert!(n_detections >= at_least && n_moving >= at_least, "{robot}: {n_moving} commands");

        // Of every robot, from the tracker or in its stead, in the tracker's frame.
        let poses = messages::<PoseStamped>(&bag, robot, "pose");
        assert!(poses.iter().all(|pose| pose.header.frame_id == FRAME), "{robot}");
        let path_m: f64 = poses.windows(2).map(|pair| distance_m(&pair[0], &pair[1])).sum();
        // Whoever runs into another stands for a while.
        assert!((0.3..1.1).contains(&(path_m / expected_m)), "{robot} went {path_m:.2} m");
    }
    // How often each comes near the simulated ones is up to the swarm.
    let given = |robot| messages::<Bool>(&bag, robot, "virtual_detection");
    let given: Vec<Vec<Bool>> = ROBOTS[..N_REAL].iter().map(|robot| given(robot)).collect();
    assert!(given.iter().all(|given| !given.is_empty()), "every real robot is told");
    let n_seen = given.iter().flatten().filter(|seen| seen.data).count();
    assert!(n_seen > 0, "none of the virtual detections is true");
    let gated = messages::<Twist>(&bag, ROBOTS[0], "hardware/cmd_vel");
    assert!(gated.iter().any(|twist| twist.linear.x > 0.0), "gated commands were asked for");
}

fn distance_m(from: &PoseStamped, to: &PoseStamped) -> f64 {
    let (from, to) = (from.pose.position, to.pose.position);
    libm::hypot(to.x - from.x, to.y - from.y)
}

/// The judge takes the one source that has poses of all robots.
fn check_label(bag: &Path) {
    let place = bag.parent().expect("it is in a folder");
    let label = &json(&rsrs(place, &["label", "bag", "--format", "json"]))[0];
    assert_eq!((&label["n_robots"], &label["poses"]), (&N_ROBOTS.into(), &"pose".into()));
    assert!(label["phase"].is_string(), "{label}");
}

/// However well it milled, it is no evidence of reality.
fn check_comparison(folder: &Path) {
    let sweep = "profile: profiles/flockbot.yaml\n\
         axes: {speed_m_s: [0.15], turn_rate_rad_s: [0.75]}\n\
         fixed: {robots: 5, placement_radius_m: 0.6}\n\
         replicates: 16\nduration_s: 62\nseed: 7\n";
    std::fs::write(folder.join("sweep.yaml"), sweep).expect("the folder is writable");
    done(folder, &["sweep", "sweep.yaml", "-o", "swept"]);

    let compared = rsrs(folder, &["compare", "swept", "--bags", "bag"]);

    let printed = stderr(&compared);
    assert_eq!(code(&compared), 1, "{printed}");
    let reason = "at least some of its robots were simulated, so it is no evidence of reality";
    assert!(printed.contains(reason), "{printed}");
}
