//! Nodes that are killed at any moment, over real DDS, watched at the wheels.
//!
//! Two robots have serial lines on which the test plays the microcontrollers, a third one is the
//! simulator's; a tracker sees the first two where they were set down. Again and again a run is
//! started and one process of the fleet killed; the wheels must stand within the protocol's bounds,
//! and after that one process has been started again, the next run must move them. The killed
//! runner's bag can be read, every other one is closed.
//!
//! `RSRS_NODE_KILLS` sets how often, and `RSRS_SEED` the moments.
//!
//! A second test stops and continues each of them (Ctrl-Z and `fg`), after which its middleware is dead:
//! the process must end by itself, so that a service can start it again. `RSRS_NODE_FREEZES` sets how
//! often. With the feature `security` the same is done to a secured fleet.

use std::path::{Path, PathBuf};
use std::process::{ExitStatus, Stdio};
use std::time::{Duration, Instant};

use crate::fleet::{ROBOTS, experiment, node, signal, start_run, track};
use crate::micro::{Micro, Socket};
use crate::processes::{Process, in_own_network, join_alone, rsrs};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use rsrs_bags::Bag;
use rsrs_fleet::record::ENDING;
use rsrs_ros::session::Session;
#[cfg(feature = "security")]
use rsrs_ros::session::SessionOptions;
use rsrs_testing::environment::number;
use rsrs_testing::network::{TIMEOUT, session};
use rsrs_testing::processor::waited;

const KILLS: u64 = 12;
/// Each kind of process once.
const FREEZES: u64 = 4;
/// How often a process is stopped again whose middleware happened not to wait when it was stopped.
const TRIES: usize = 20;
/// How often a run is started on a busy machine, until robots drive.
const STARTS: usize = 3;
/// Robots with a serial line; the simulator's is the one after them.
const N_REAL: usize = 2;
/// What a busy machine adds to a bound of the protocol.
const SLACK: Duration = Duration::from_millis(400);
const POLL_PERIOD: Duration = Duration::from_millis(10);

/// Who is killed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Victim {
    Runner,
    Controllers,
    Robot(usize),
    Simulator,
}

impl Victim {
    fn draw(generator: &mut ChaCha8Rng) -> Self {
        match generator.random_range(0..4) {
            0 => Self::Runner,
            1 => Self::Controllers,
            2 => Self::Robot(generator.random_range(0..N_REAL)),
            _ => Self::Simulator,
        }
    }

    /// Each kind of process in turn.
    fn in_turn(round: u64) -> Self {
        match round % 4 {
            0 => Self::Runner,
            1 => Self::Controllers,
            2 => Self::Robot(0),
            _ => Self::Simulator,
        }
    }

    /// How long after its death the wheels of a robot may turn.
    fn bound(self, robot: usize) -> Duration {
        let milliseconds = match self {
            // The lease, from the status that was echoed last.
            Self::Runner => 500,
            // 2.5 periods of 130 ms without a command.
            Self::Controllers => 325,
            // The wheels' own timeout.
            Self::Robot(dead) if dead == robot => 250,
            // The runner notices a silence of 1 s, and reports it with its next lease.
            Self::Robot(_) | Self::Simulator => 1_000 + 100 + 200,
        };
        Duration::from_millis(milliseconds) + SLACK
    }
}

/// The moment at which a node is killed.
#[derive(Clone, Copy, Debug)]
enum Moment {
    /// So long after the run was started, before or after robots move.
    Starting(Duration),
    /// So long after the wheels of all robots have turned.
    Driving(Duration),
}

impl Moment {
    fn draw(generator: &mut ChaCha8Rng) -> Self {
        let mut within = |ms| Duration::from_millis(generator.random_range(0..ms));
        let (starting, driving) = (within(5_000), within(1_000));
        if generator.random::<bool>() { Self::Starting(starting) } else { Self::Driving(driving) }
    }
}

struct FleetUnderTest {
    folder: tempfile::TempDir,
    experiment: PathBuf,
    sockets: [Socket; N_REAL],
    micros: [Micro; N_REAL],
    robots: [Process; N_REAL],
    controllers: Process,
    simulator: Process,
    n_runs: usize,
}

fn start_robot(robot: usize, socket: &Socket) -> Process {
    let mut command = rsrs();
    command.args(["node", "robot", "--interface", "127.0.0.1", "--robots", ROBOTS[robot]]);
    command.args(["--driver", "serial", "--without-controller", "--port"]).arg(socket.path());
    command.stdout(Stdio::null()).stderr(Stdio::null());
    Process(command.spawn().expect("the program was built for this test"))
}

fn start_controllers() -> Process {
    node("controller", &ROBOTS[..=N_REAL])
}

fn start_simulator() -> Process {
    node("sim", &ROBOTS[N_REAL..=N_REAL])
}

impl FleetUnderTest {
    fn new() -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let changes = [
            ("robots: 9", "robots: 3"),
            ("time: lockstep", "time: real_time"),
            ("pose: odom", "pose: pose"),
            ("robot_1: {enabled: true, type: flockbot}", "robot_1: {enabled: true, type: serial}"),
            ("robot_2: {enabled: true, type: flockbot}", "robot_2: {enabled: true, type: serial}"),
            (
                "robots:\n  robot_1",
                "  serial: {profile: ../profiles/flockbot.yaml, driver: {kind: serial, port: /dev/null, \
                 baud: 115200}}\nrobots:\n  robot_1",
            ),
        ];
        let sockets = std::array::from_fn(|_| Socket::new());
        let start = |robot: usize| {
            join_alone();
            start_robot(robot, &sockets[robot])
        };
        Self {
            experiment: experiment(folder.path(), 1_000, &changes),
            micros: std::array::from_fn(|robot| Micro::plug_in(&sockets[robot].path())),
            robots: std::array::from_fn(start),
            controllers: {
                join_alone();
                start_controllers()
            },
            simulator: {
                join_alone();
                start_simulator()
            },
            folder,
            sockets,
            n_runs: 0,
        }
    }

    fn start_run(&mut self) -> (Process, PathBuf) {
        self.n_runs += 1;
        let bag = self.folder.path().join(format!("bag_{}", self.n_runs));
        (start_run(&self.experiment, &bag), bag)
    }

    /// Starts a run, and waits until the wheels of all robots turn. A machine that is too busy to keep
    /// a robot's deadlines ends a run, as it should; then the next one is started.
    fn start_driving(&mut self) -> (Process, PathBuf) {
        let mut endings = String::new();
        for _ in 0..STARTS {
            let (mut run, bag) = self.start_run();
            match self.wait_until_all_drive(&mut run) {
                Ok(()) => return (run, bag),
                Err(ending) => endings += &ending,
            }
        }
        panic!("{STARTS} runs in a row ended before robots moved:\n{endings}");
    }

    /// Waits until the wheels of all robots turn.
    ///
    /// # Errors
    ///
    /// What a run wrote that ended before.
    fn wait_until_all_drive(&self, run: &mut Process) -> Result<(), String> {
        let start = Instant::now();
        while self.micros.iter().any(|micro| micro.wheels() == (0, 0)) {
            if run.0.try_wait().expect("it is our child").is_some() {
                return Err(run.wait().1);
            }
            assert!(start.elapsed() < TIMEOUT, "the wheels do not turn");
            std::thread::sleep(POLL_PERIOD);
        }
        Ok(())
    }

    fn process<'a>(&'a mut self, victim: Victim, run: &'a mut Process) -> &'a mut Process {
        match victim {
            Victim::Runner => run,
            Victim::Controllers => &mut self.controllers,
            Victim::Robot(robot) => &mut self.robots[robot],
            Victim::Simulator => &mut self.simulator,
        }
    }

    /// Continues a process that is stopped, and waits for its end: how it ended, and what it wrote to
    /// standard error.
    fn thaw(&mut self, victim: Victim, run: &mut Process) -> (ExitStatus, String) {
        let process = self.process(victim, run);
        for _ in 0..TRIES {
            signal(process, "CONT");
            let continued = Instant::now();
            while continued.elapsed() < Duration::from_secs(3) {
                if process.0.try_wait().expect("it is our child").is_some() {
                    return process.wait();
                }
                std::thread::sleep(POLL_PERIOD);
            }
            signal(process, "STOP");
            std::thread::sleep(POLL_PERIOD);
        }
        signal(process, "CONT");
        process.wait()
    }

    /// Kills, and returns when it was done.
    fn kill(&mut self, victim: Victim, run: &mut Process) -> Instant {
        let process = self.process(victim, run);
        process.0.kill().expect("it is our child");
        process.0.wait().expect("it is our child");
        Instant::now()
    }

    fn restart(&mut self, victim: Victim) {
        match victim {
            Victim::Runner => {}
            Victim::Controllers => self.controllers = start_controllers(),
            Victim::Robot(robot) => {
                self.robots[robot] = start_robot(robot, &self.sockets[robot]);
            }
            Victim::Simulator => self.simulator = start_simulator(),
        }
    }

    /// Watches the wheels until every bound has passed.
    fn judge(&self, victim: Victim, run: &Process, killed: Instant, what: &str) {
        let waited_before = self.waits(run);
        let bounds = (0..N_REAL).map(|robot| victim.bound(robot));
        std::thread::sleep(bounds.max().expect("there are robots"));
        for (robot, micro) in self.micros.iter().enumerate() {
            let (name, bound) = (ROBOTS[robot], victim.bound(robot));
            // What did not get a processor could not keep a deadline.
            let starved = || self.waits(run)[robot].saturating_sub(waited_before[robot]);
            while micro.wheels() != (0, 0) {
                let inside = micro.inside();
                // Whether they turn now, it may not have had a processor to find out.
                let turned = inside.looked.saturating_duration_since(killed);
                assert!(
                    turned <= bound + starved(),
                    "{what}: wheels of {name} turn after {bound:?}, in which its node, the runner and this \
                     test waited {:?} for a processor; last command after {:?}, wheels {:?}",
                    starved(),
                    inside.commanded.map(|at| at.saturating_duration_since(killed)),
                    inside.wheels.last()
                );
                drop(inside);
                std::thread::sleep(POLL_PERIOD);
            }
            let inside = micro.inside();
            let Some(last) = inside.wheels.last() else { continue };
            let took = last.at.saturating_duration_since(killed);
            let starved = starved();
            assert!(
                took <= bound + starved,
                "{what}: {name} stood after {took:?}, not {bound:?}, with {starved:?} without a processor"
            );
        }
    }

    /// For how long a robot's node, the runner and this test have waited for a processor by now.
    fn waits(&self, run: &Process) -> [Duration; N_REAL] {
        let of_all = waited(run.0.id()) + waited(std::process::id());
        std::array::from_fn(|robot| of_all + waited(self.robots[robot].0.id()))
    }
}

/// A bag of a run that was killed can be read; one of a run that ended is closed.
fn judge_bag(bag: &Path, victim: Victim, what: &str) {
    if !bag.exists() {
        return;
    }
    let bag = Bag::open(bag).unwrap_or_else(|error| panic!("{what}: {error}"));
    let n_messages = bag.messages().map_while(Result::ok).count();
    if victim != Victim::Runner {
        assert_eq!(bag.damage().len(), 0, "{what}");
        assert!(bag.metadata(ENDING).is_some() && n_messages > 0, "{what}: the bag is open");
    }
}

#[test]
fn whoever_is_killed_at_whatever_moment_the_wheels_stand_and_the_next_run_moves_them() {
    in_own_network(async || tracking(session(), kill_again_and_again).await);
}

#[test]
fn whoever_is_stopped_and_continued_ends_by_itself_and_started_again_takes_part() {
    in_own_network(async || tracking(session(), freeze_again_and_again).await);
}

#[cfg(feature = "security")]
#[test]
fn whoever_is_stopped_in_a_secured_fleet_ends_by_itself_and_started_again_takes_part() {
    in_own_network(async || {
        let (_keys, enclave) = crate::secured_fleet::secure_this_test();
        let interfaces = vec![rsrs_ros::interfaces::LOOPBACK];
        let tracker = SessionOptions { domain_id: 42, interfaces, enclave };
        let session = Session::open(&tracker).expect("the enclave is well");
        tracking(session, freeze_again_and_again).await;
    });
}

async fn tracking(session: Session, body: fn()) {
    let killing = tokio::task::spawn_blocking(body);
    tokio::select! {
        ended = killing => ended.expect("the panic above gives the reason"),
        () = track(&session, &ROBOTS[..N_REAL]) => {}
    }
    session.close().await;
}

fn kill_again_and_again() {
    let mut generator = ChaCha8Rng::seed_from_u64(number("RSRS_SEED").unwrap_or(1));
    let mut fleet = FleetUnderTest::new();

    for round in 0..number("RSRS_NODE_KILLS").unwrap_or(KILLS) {
        let (victim, moment) = (Victim::draw(&mut generator), Moment::draw(&mut generator));
        let what = format!("round {round}, {victim:?}, {moment:?}");
        let ((mut run, bag), after) = match moment {
            Moment::Starting(after) => (fleet.start_run(), after),
            Moment::Driving(after) => (fleet.start_driving(), after),
        };
        std::thread::sleep(after);

        let killed = fleet.kill(victim, &mut run);
        fleet.judge(victim, &run, killed, &what);

        if victim != Victim::Runner && run.0.try_wait().expect("it is our child").is_none() {
            signal(&run, "INT");
        }
        let (status, errors) = run.wait();
        assert!(!status.success(), "{what}: a run without {victim:?} was completed\n{errors}");
        judge_bag(&bag, victim, &what);
        fleet.restart(victim);
    }

    fleet.start_driving();
}

fn freeze_again_and_again() {
    let mut fleet = FleetUnderTest::new();

    for round in 0..number("RSRS_NODE_FREEZES").unwrap_or(FREEZES) {
        let victim = Victim::in_turn(round);
        let what = format!("round {round}, {victim:?}");
        let (mut run, bag) = fleet.start_driving();

        signal(fleet.process(victim, &mut run), "STOP");
        fleet.judge(victim, &run, Instant::now(), &what);
        let (status, errors) = fleet.thaw(victim, &mut run);

        assert_eq!(status.code(), Some(1), "{what}: {errors}");
        for (micro, robot) in fleet.micros.iter().zip(ROBOTS) {
            assert_eq!(micro.wheels(), (0, 0), "{what}: wheels of {robot} turn again");
        }
        if victim == Victim::Runner {
            assert!(errors.contains("the middleware has ended"), "{errors}");
            let bag = Bag::open(&bag).unwrap_or_else(|error| panic!("{what}: {error}"));
            let ending = bag.metadata(ENDING).expect("the bag is closed");
            assert!(ending["reason"].contains("the middleware has ended"), "{ending:?}");
        } else {
            let (status, errors) = run.wait();
            assert!(!status.success(), "{what}: the run was completed\n{errors}");
            judge_bag(&bag, victim, &what);
        }
        fleet.restart(victim);
    }

    fleet.start_driving();
}
