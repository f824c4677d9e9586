//! A campaign of a fleet to its end: robots in processes of their own, placed by somebody who reads
//! what the command prints, interrupted in the middle and gone on with.

use std::fmt::Write as _;
use std::io::Read;
use std::path::Path;
use std::process::Stdio;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use rsrs_fleet::record::Backend;
use rsrs_msgs::builtin_interfaces::Time;
use rsrs_msgs::geometry_msgs::{PoseStamped, Twist};
use rsrs_msgs::sensor_msgs::Range;
use rsrs_msgs::topics::{self, Qos};
use rsrs_msgs::{cdr, std_msgs::Bool};
use rsrs_ros::session::{Publisher, Session, Subscription};
use serde_json::Value;

use super::{manifest, wait_for, write};
use crate::processes::{Process, fail, in_own_network, rsrs};
use crate::recorded::record_of;
use crate::terminal::Terminal;
use rsrs_testing::network::{TIMEOUT, session};

const ROBOTS: [&str; 3] = ["robot_1", "robot_2", "robot_3"];
const EXPERIMENTS: [&str; 3] = ["001_short", "002_short", "003_short"];
const DURATION_S: u32 = 5;
/// Between two poses, and two readings, of a robot.
const READING: Duration = Duration::from_millis(100);
/// How far a robot sees, in metres, and to which side, as a cosine.
const SIGHT: (f64, f64) = (0.75, 0.98);

/// Where a robot is, and what it was commanded last.
#[derive(Clone, Copy, Default)]
struct Body {
    x_m: f64,
    y_m: f64,
    heading_rad: f64,
    given: Twist,
}

impl Body {
    fn drive(&mut self, for_s: f64) {
        self.heading_rad += self.given.angular.z * for_s;
        let (sine, cosine) = libm::sincos(self.heading_rad);
        self.x_m += self.given.linear.x * cosine * for_s;
        self.y_m += self.given.linear.x * sine * for_s;
    }

    /// The distance of another robot, if it is in front.
    fn sees(&self, other: &Self) -> Option<f64> {
        let (dx_m, dy_m) = (other.x_m - self.x_m, other.y_m - self.y_m);
        let distance_m = libm::hypot(dx_m, dy_m);
        let (sine, cosine) = libm::sincos(self.heading_rad);
        let along = (dx_m * cosine + dy_m * sine) / distance_m.max(1e-9);
        (distance_m < SIGHT.0 && along > SIGHT.1).then_some(distance_m)
    }
}

/// The bodies of all robots, which hardware and tracker share.
#[derive(Clone, Default)]
struct Bodies(Arc<Mutex<[Body; ROBOTS.len()]>>);

impl Bodies {
    fn lock(&self) -> MutexGuard<'_, [Body; ROBOTS.len()]> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Puts the robots where the last table states, as a person would who reads it.
    fn place(&self, printed: &str) {
        let table = printed.rsplit("place the robots:").next().expect("it was printed");
        let mut bodies = self.lock();
        for (robot, body) in ROBOTS.iter().zip(bodies.iter_mut()) {
            let row = table.lines().find(|line| line.starts_with(robot)).expect("it is listed");
            let numbers: Vec<f64> = row
                .split_whitespace()
                .skip(1)
                .map(|word| word.parse().expect("a number"))
                .collect();
            let [x_m, y_m, _, heading_rad] = numbers[..] else { panic!("{row}") };
            *body = Body { x_m, y_m, heading_rad, given: Twist::default() };
        }
    }

    fn is_driving(&self) -> bool {
        self.lock().iter().all(|body| body.given.linear.x > 0.0)
    }

    fn stands(&self) -> bool {
        self.lock().iter().all(|body| body.given == Twist::default())
    }
}

/// What the robots' hardware and the tracker above them publish and receive.
struct Hardware {
    bodies: Bodies,
    ranges: Vec<Publisher<Range>>,
    tracker: Vec<Publisher<PoseStamped>>,
    _commands: Vec<Subscription>,
}

impl Hardware {
    fn new(session: &Session) -> Self {
        let node = session.node("/", "hardware").expect("the name is allowed");
        let bodies = Bodies::default();
        let commands = ROBOTS.iter().enumerate().map(|(robot, name)| {
            let (topic, bodies) = (topics::HARDWARE_CMD_VEL_UNSTAMPED, bodies.clone());
            let given =
                session.subscribe(&node, &topic.for_robot(name), topic.qos, move |sample| {
                    bodies.lock()[robot].given = sample.message;
                });
            given.expect("the topic is allowed")
        });
        let commands = commands.collect();
        let ranges = ROBOTS.iter().map(|name| {
            let topic = topics::HARDWARE_RANGE.for_robot(name);
            session.publish_on(&node, &topic, Qos::best_effort(10)).expect("it is allowed")
        });
        let tracker = ROBOTS.iter().map(|name| {
            let topic = topics::POSE;
            session.publish_on(&node, &topic.for_robot(name), topic.qos).expect("it is allowed")
        });
        Self { bodies, ranges: ranges.collect(), tracker: tracker.collect(), _commands: commands }
    }

    /// Moves the robots as they are commanded, and publishes what is seen of them.
    async fn live(&self) {
        let mut readings = tokio::time::interval(READING);
        let mut before = Instant::now();
        loop {
            readings.tick().await;
            let now = Instant::now();
            let bodies = {
                let mut bodies = self.bodies.lock();
                for body in bodies.iter_mut() {
                    body.drive((now - before).as_secs_f64());
                }
                *bodies
            };
            before = now;
            for (robot, body) in bodies.iter().enumerate() {
                let others = bodies.iter().enumerate().filter(|(other, _)| *other != robot);
                let seen_m = others.filter_map(|(_, other)| body.sees(other)).fold(2.0, f64::min);
                let range = Range { range: in_f32(seen_m), max_range: 2.0, ..Range::default() };
                self.ranges[robot].publish(range).await.expect("a healthy network");
                self.tracker[robot].publish(tracked(body)).await.expect("a healthy network");
            }
        }
    }
}

#[expect(clippy::cast_possible_truncation, reason = "a sensor has fewer digits")]
fn in_f32(number: f64) -> f32 {
    number as f32
}

fn tracked(body: &Body) -> PoseStamped {
    let mut message = PoseStamped::default();
    let since = SystemTime::now().duration_since(UNIX_EPOCH).expect("it is after 1970");
    let nanos = u64::try_from(since.as_nanos()).expect("it is before 2554");
    message.header.stamp = Time::from_nanos(nanos);
    "map".clone_into(&mut message.header.frame_id);
    (message.pose.position.x, message.pose.position.y) = (body.x_m, body.y_m);
    let (sine, cosine) = libm::sincos(body.heading_rad / 2.0);
    (message.pose.orientation.z, message.pose.orientation.w) = (sine, cosine);
    message
}

/// A folder with a campaign of three short runs of robots that have base drivers.
fn lab_folder() -> tempfile::TempDir {
    let place = super::place();
    let mut fleet = "fileversion: 1\nall: {cmd_vel: twist_stamped, pose: pose}\nrobot_types:\n  \
        flockbot: {profile: ../profiles/flockbot.yaml, driver: {kind: ros}}\nrobots:\n"
        .to_owned();
    for name in ROBOTS {
        writeln!(fleet, "  {name}: {{enabled: true, type: flockbot}}").expect("memory is there");
    }
    write(place.path(), "fleets/three.yaml", &fleet);
    let experiment = format!(
        "fleet: fleets/three.yaml\n\
         cell: {{speed_m_s: 0.15, turn_rate_rad_s: 0.75, robots: 3}}\n\
         placement: {{kind: disc_facing_out, radius_m: 0.6}}\n\
         duration_s: {DURATION_S}\nseed: 1\n\
         # A robot that gets no processor for half a second stops.\n\
         robot_lost: note\n"
    );
    write(place.path(), "short.yaml", &experiment);
    let campaign = "experiments:\n- {experiment: short.yaml, seeds: [1, 2, 3]}\n";
    write(place.path(), "campaign.yaml", campaign);
    place
}

fn robot(name: &str) -> Process {
    let mut command = rsrs();
    command.args(["node", "robot", "--interface", "127.0.0.1", "--robots", name]);
    command.args(["--driver", "ros"]).stdout(Stdio::null()).stderr(Stdio::null());
    Process(command.spawn().expect("the program was built for this test"))
}

/// The command in a terminal, and what it has printed so far.
struct Console {
    process: Process,
    terminal: Terminal,
    printed: Arc<Mutex<String>>,
}

impl Console {
    fn open(place: &Path) -> Self {
        let terminal = Terminal::open();
        let mut command = rsrs();
        command.current_dir(place).args(["campaign", "campaign.yaml", "-o", "out"]);
        command.args(["--format", "json", "--backend", "fleet", "--interface", "127.0.0.1"]);
        let mut process = Process::start(command.stdin(terminal.input()));
        let mut stderr = process.0.stderr.take().expect("it is piped");
        let printed = Arc::new(Mutex::new(String::new()));
        let reception = printed.clone();
        thread::spawn(move || {
            let mut piece = [0; 4096];
            while let Ok(n_bytes @ 1..) = stderr.read(&mut piece) {
                let text = String::from_utf8_lossy(&piece[..n_bytes]);
                reception.lock().unwrap_or_else(PoisonError::into_inner).push_str(&text);
            }
        });
        Self { process, terminal, printed }
    }

    fn printed(&self) -> String {
        self.printed.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Waits until it prints something.
    fn until(&mut self, what: &str) {
        let start = Instant::now();
        while !self.printed().contains(what) {
            let has_ended = self.process.0.try_wait().expect("it is our child").is_some();
            let is_late = has_ended || start.elapsed() > TIMEOUT;
            assert!(!is_late, "it never printed {what:?}: {}", self.printed());
            thread::sleep(Duration::from_millis(10));
        }
    }

    /// Waits until it asks for an experiment, places the robots, and starts it.
    fn start(&mut self, experiment: &str, bodies: &Bodies) {
        self.until(&format!("\n{experiment}: "));
        let asked = || self.printed().rsplit("place the robots:").next().map(str::to_owned);
        wait_for("the keys", || asked().is_some_and(|asked| asked.contains("Enter starts")));
        bodies.place(&self.printed());
        // The tracker must have seen where they stand.
        thread::sleep(5 * READING);
        self.terminal.type_line("");
    }

    /// Waits for the end.
    fn end(mut self) -> (Option<i32>, String, String) {
        let (status, stdout, _) = self.process.output();
        thread::sleep(Duration::from_millis(100));
        (status.code(), stdout, self.printed())
    }
}

#[test]
fn a_campaign_of_a_fleet_is_placed_interrupted_and_gone_on_with_to_its_end() {
    in_own_network(async || with_live_robots(run_interrupted).await);
}

/// Runs the nodes of robots and their hardware while something is done with them.
async fn with_live_robots(done: fn(&Bodies)) {
    let session = session();
    let hardware = Hardware::new(&session);
    let _robots = ROBOTS.map(robot);
    let given = async {
        for name in ROBOTS {
            let status = topics::STATUS.for_robot(name);
            session.wait_for_writers(&status, 1, TIMEOUT).await.expect("the robot starts");
            let range = topics::HARDWARE_RANGE.for_robot(name);
            session.wait_for_readers(&range, 1, TIMEOUT).await.expect("the robot starts");
        }
        let bodies = hardware.bodies.clone();
        if let Err(panic) = tokio::task::spawn_blocking(move || done(&bodies)).await {
            fail(&panic.to_string());
        }
    };
    tokio::select! {
        () = hardware.live() => {}
        () = given => {}
    }
    drop(hardware);
    session.close().await;
}

fn run_interrupted(bodies: &Bodies) {
    let place = lab_folder();
    let out = place.path().join("out");
    let [first, second, third] = EXPERIMENTS;

    // Through the first, and interrupted in the second.
    let mut console = Console::open(place.path());
    console.start(first, bodies);
    console.until(&format!("{first}: completed, not judged: "));
    console.start(second, bodies);
    let is_over = || console.printed().contains(&format!("{second}: completed"));
    wait_for("the robots that drive", || bodies.is_driving() || is_over());
    if is_over() {
        // A robot that is lost is noted, and no more.
        fail(&format!("not all robots drove: {}", console.printed()));
    }
    let pid = console.process.0.id().to_string();
    let status = std::process::Command::new("kill").args(["-s", "INT", &pid]).status();
    assert!(status.expect("every system has `kill`").success());
    let (interrupted, _, printed) = console.end();

    assert_eq!(interrupted, Some(130), "{printed}");
    let help = "help: what was recorded is in out/002_short/bag.unfinished_1; `rsrs campaign \
                campaign.yaml -o out --backend fleet --interface 127.0.0.1` goes on where it was\n";
    assert!(printed.ends_with(help), "{printed}");
    wait_for("the robots that stand", || bodies.stands());
    assert!(out.join(first).join("manifest.json").exists());
    assert!(!out.join(second).join("manifest.json").exists());
    let kept = std::fs::read(out.join(first).join("bag/bag_0.mcap")).expect("it is finished");

    // The rest of it.
    let mut console = Console::open(place.path());
    console.until("1 of 3 are finished");
    console.start(second, bodies);
    console.until(&format!("{second}: completed"));
    console.start(third, bodies);
    let (ended, summary, printed) = console.end();

    let summary: Value =
        serde_json::from_str(&summary).unwrap_or_else(|error| panic!("{error}: {printed}"));
    // They are too short to be judged, and would be again.
    assert_eq!((ended, &summary["n_finished"]), (Some(3), &Value::from(3)), "{printed}");
    assert_eq!(std::fs::read(out.join(first).join("bag/bag_0.mcap")).ok(), Some(kept));
    for (folder, seed) in EXPERIMENTS.iter().zip(1..) {
        let manifest = manifest(&out.join(folder));
        assert_eq!(manifest["ending"], "completed", "{manifest}");
        check_bag(&out.join(folder).join("bag"), seed);
    }
    assert_eq!(manifest(&out.join(second))["kept_aside"][0], "bag.unfinished_1");

    // Once it is finished nobody is asked again.
    let (again, _, printed) = Console::open(place.path()).end();
    assert_eq!(again, Some(3), "{printed}");
    assert!(!printed.contains("place the robots"), "{printed}");
}

/// Goes through a campaign of one run whose robots a program places.
fn run_placed(bodies: &Bodies) {
    let place = lab_folder();
    let one = "experiments:\n- {experiment: short.yaml, seeds: [5]}\n";
    write(place.path(), "campaign.yaml", one);
    let start = |program: &str| {
        let mut command = rsrs();
        command.current_dir(place.path()).args(["campaign", "campaign.yaml", "-o", "out"]);
        command.args([
            "--backend",
            "fleet",
            "--interface",
            "127.0.0.1",
            "--place-command",
            program,
        ]);
        Process::start(command.stdin(Stdio::null()))
    };

    let (failed, printed) = start("echo robot_2 is stuck; exit 7").wait();

    assert_eq!(failed.code(), Some(1), "{printed}");
    assert!(printed.contains("did not place the robots (exit status: 7)"), "{printed}");
    assert!(printed.contains("robot_2 is stuck"), "{printed}");
    assert!(!place.path().join("out/001_short/manifest.json").exists(), "nothing was run");

    let mut run = start("cat > wanted.json; until [ -e placed ]; do sleep 0.05; done; sleep 0.5");
    let wanted = place.path().join("wanted.json");
    let text = || std::fs::read_to_string(&wanted).unwrap_or_default();
    wait_for("the placement", || text().ends_with('\n'));
    let given: Value = serde_json::from_str(&text()).expect("a line of JSON");
    assert_eq!(given["purpose"], "001_short");
    for (robot, body) in given["robots"].as_array().expect("robots").iter().zip(0..) {
        let number = |key: &str| robot[key].as_f64().expect("a number");
        assert_eq!(robot["name"], ROBOTS[body]);
        let (x_m, y_m, heading_rad) = (number("x_m"), number("y_m"), number("heading_rad"));
        bodies.lock()[body] = Body { x_m, y_m, heading_rad, given: Twist::default() };
    }
    write(place.path(), "placed", "");
    let (status, printed) = run.wait();

    assert_eq!(status.code(), Some(3), "{printed}");
    assert!(printed.contains("all 3 robots stand where they should start"), "{printed}");
    check_bag(&place.path().join("out/001_short/bag"), 5);
}

#[test]
fn a_program_places_the_robots_of_a_campaign_and_stops_it_when_it_cannot() {
    in_own_network(async || with_live_robots(run_placed).await);
}

/// The bag of a run of the fleet, in which every robot began where it was to begin, and drove.
fn check_bag(path: &Path, seed: u64) {
    let (bag, record) = record_of(path);
    assert_eq!((record.backend, record.seed), (Backend::Fleet, seed));
    assert!(bag.damage().is_empty());
    for name in ROBOTS {
        let poses: Vec<PoseStamped> = bag
            .messages_on([topics::POSE.for_robot(name)])
            .map(|message| cdr::decode(&message.expect("it is whole").bytes).expect("it is one"))
            .collect();
        let place = |pose: &PoseStamped| (pose.pose.position.x, pose.pose.position.y);
        let (first, last) = (place(&poses[0]), place(&poses[poses.len() - 1]));
        assert!(libm::hypot(first.0, first.1) <= 0.61, "{name} began at {first:?}");
        assert!(libm::hypot(last.0 - first.0, last.1 - first.1) > 0.01, "{name} never drove");
        let detection = topics::DETECTION.for_robot(name);
        let n_detections = bag.messages_on([detection]).filter(|message| {
            let bytes = &message.as_ref().expect("it is whole").bytes;
            cdr::decode::<Bool>(bytes).is_ok()
        });
        assert!(n_detections.count() > 10, "{name} was never received");
    }
}
