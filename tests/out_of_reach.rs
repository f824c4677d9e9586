//! A robot that is out of reach of its network, over real DDS, watched at the wheels.
//!
//! One robot has a network of its own, which a virtual cable ties to that of all others. While a run goes
//! on the cable is pulled: the robot must stand within its lease. When the cable is back, the next run
//! must move the robot. If it was away for longer than the leases of DDS its middleware receives
//! nothing any more; then its process must end by itself, as its service expects, which the test
//! plays.
//!
//! A robot whose interface was down goes on, and one that has another address must end by itself.
//!
//! `RSRS_CUTS` sets what is done, and for how many seconds: `cable:20,cable:200,interface:20,address:20`.
//! With the feature `security` the same is done to a secured fleet.

use std::net::{IpAddr, Ipv4Addr};
use std::path::PathBuf;
use std::process::Stdio;
use std::time::{Duration, Instant};

use crate::cables::{ip, ip_of, start_at_cable};
use crate::fleet::{ROBOTS, experiment, signal, track};
use crate::micro::{Micro, Socket};
use crate::processes::{Process, in_own_network, join_alone, rsrs};
use rsrs_ros::security::Enclave;
use rsrs_ros::session::{Session, SessionOptions};
use rsrs_testing::network::TIMEOUT;

/// A cut that is longer than the leases of DDS (50 s), one that is shorter, and another address.
const CUTS: &str = "cable:60,cable:5,address:5";
/// How long participants of DDS remember each other.
const LEASE: Duration = Duration::from_secs(50);
/// Where all but the robot are.
const BASE: Ipv4Addr = Ipv4Addr::new(10, 77, 0, 1);
/// The lease of a run, and what a busy machine adds.
const STANDS_WITHIN: Duration = Duration::from_millis(500 + 400);
/// How long after the cable is back the robot is announced: the middleware announces itself so often.
const ANNOUNCED_WITHIN: Duration = Duration::from_secs(40);
/// How often a run is started on a busy machine, until the robot drives.
const STARTS: usize = 3;
const POLL_PERIOD: Duration = Duration::from_millis(10);

/// The network of all but the robot: a bridge, with a port so that it is up without cables.
fn make_base() {
    ip("link add base type bridge");
    ip("link add port type veth peer name other_end");
    ip("link set other_end up");
    ip("link set port master base up");
    ip(&format!("address add {BASE}/24 dev base"));
    ip("link set base up");
}

/// How the robot's computer is cut off.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Cut {
    /// The cable is pulled behind the first switch: its own interface stays as it was.
    Cable,
    /// Its interface is down.
    Interface,
    /// Its interface has no address, and then another one.
    Address,
}

/// What is done, and for how long.
fn cuts() -> Vec<(Cut, Duration)> {
    let text = std::env::var("RSRS_CUTS").unwrap_or_else(|_| CUTS.to_owned());
    let cut = |text: &str| {
        let (cut, seconds) = text.split_once(':').expect("a kind, a colon and seconds");
        let cut = match cut {
            "cable" => Cut::Cable,
            "interface" => Cut::Interface,
            "address" => Cut::Address,
            _ => panic!("`{cut}` is none of cable, interface, address"),
        };
        (cut, Duration::from_secs(seconds.parse().expect("whole seconds")))
    };
    text.split(',').map(cut).collect()
}

/// The robot's computer: its node in a network of its own, at the end of a cable.
struct Computer {
    node: Process,
    cable: String,
    address: String,
}

impl Computer {
    /// Starts the node, and ties its network to the base.
    fn start(n: usize, socket: &Socket) -> Self {
        let address = format!("10.77.0.{}", n + 2);
        let mut node = rsrs();
        node.args(["node", "robot", "--interface", &address, "--robots", ROBOTS[0]]);
        node.args(["--driver", "serial", "--without-controller", "--port"]).arg(socket.path());
        let cable = format!("cable{n}");
        let plug = || ip(&format!("link set {cable} master base up"));
        let node = start_at_cable(&node, &cable, (&address, plug));
        Self { node, cable, address }
    }

    /// Runs `ip` in the network of the robot's computer.
    fn ip(&self, arguments: &str) {
        ip_of(&self.node, arguments);
    }

    fn cut_off(&self, cut: Cut) {
        match cut {
            Cut::Cable => ip(&format!("link set {} nomaster", self.cable)),
            Cut::Interface => self.ip("link set eth0 down"),
            Cut::Address => self.ip(&format!("address del {}/24 dev eth0", self.address)),
        }
    }

    fn connect(&self, cut: Cut) {
        match cut {
            Cut::Cable => ip(&format!("link set {} master base", self.cable)),
            Cut::Interface => self.ip("link set eth0 up"),
            Cut::Address => self.ip(&format!("address add {}0/24 dev eth0", self.address)),
        }
    }
}

/// A node in the base.
fn node(kind: &str, robots: &[&str]) -> Process {
    let mut command = rsrs();
    command.args(["node", kind, "--interface", &BASE.to_string(), "--robots", &robots.join(",")]);
    command.stdout(Stdio::null()).stderr(Stdio::null());
    join_alone();
    Process(command.spawn().expect("the program was built for this test"))
}

struct FleetUnderTest {
    folder: tempfile::TempDir,
    experiment: PathBuf,
    socket: Socket,
    micro: Micro,
    _nodes: [Process; 2],
    n_runs: usize,
}

impl FleetUnderTest {
    fn new() -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let changes = [
            ("robots: 9", "robots: 4"),
            ("time: lockstep", "time: real_time"),
            ("pose: odom", "pose: pose"),
            ("robot_1: {enabled: true, type: flockbot}", "robot_1: {enabled: true, type: serial}"),
            (
                "robots:\n  robot_1",
                "  serial: {profile: ../profiles/flockbot.yaml, driver: {kind: serial, port: /dev/null, \
                 baud: 115200}}\nrobots:\n  robot_1",
            ),
        ];
        let socket = Socket::new();
        Self {
            experiment: experiment(folder.path(), 1_000, &changes),
            micro: Micro::plug_in(&socket.path()),
            socket,
            _nodes: [node("controller", &ROBOTS[..4]), node("sim", &ROBOTS[1..4])],
            folder,
            n_runs: 0,
        }
    }

    /// Starts a run, and waits until the robot's wheels turn. A machine that is too busy to keep a
    /// robot's deadlines ends a run, as it should; then the next one is started.
    fn start_driving(&mut self) -> Process {
        let mut endings = String::new();
        for _ in 0..STARTS {
            self.n_runs += 1;
            let bag = self.folder.path().join(format!("bag_{}", self.n_runs));
            let mut command = rsrs();
            command.args(["run", "--backend", "fleet", "--interface", &BASE.to_string()]);
            let mut run = Process::start(command.arg(&self.experiment).arg("-o").arg(&bag));
            let start = Instant::now();
            while run.0.try_wait().expect("it is our child").is_none() {
                if self.micro.wheels() != (0, 0) {
                    return run;
                }
                if start.elapsed() > TIMEOUT {
                    signal(&run, "INT");
                    let (_, printed) = run.wait();
                    panic!("the wheels do not turn:\n{printed}");
                }
                std::thread::sleep(POLL_PERIOD);
            }
            endings += &run.wait().1;
        }
        panic!("{STARTS} runs in a row ended before the robot moved:\n{endings}");
    }

    /// Cuts off the computer of the driving robot, and connects it again after a while.
    fn cut(&mut self, n: usize, (cut, duration): (Cut, Duration)) {
        let mut computer = Computer::start(n, &self.socket);
        let mut run = self.start_driving();

        let begun = Instant::now();
        computer.cut_off(cut);
        std::thread::sleep(STANDS_WITHIN);
        assert_eq!(self.micro.wheels(), (0, 0), "the wheels stand within the lease");
        let (status, errors) = run.wait();
        assert!(!status.success(), "a run without a robot was completed\n{errors}");
        std::thread::sleep(duration.saturating_sub(begun.elapsed()));
        assert!(computer.node.0.try_wait().expect("it is our child").is_none(), "nobody is back");
        computer.connect(cut);

        let ends_with = match cut {
            Cut::Address => Some("receives at the old address only"),
            Cut::Cable | Cut::Interface if duration <= LEASE => None,
            // A secured participant whose interface was down notices it by itself.
            Cut::Cable | Cut::Interface => Some("longer than"),
        };
        if let Some(reason) = ends_with {
            let restored = Instant::now();
            let (status, errors) = computer.node.wait();
            assert!(restored.elapsed() < ANNOUNCED_WITHIN, "{:?}: {errors}", restored.elapsed());
            assert_eq!(status.code(), Some(1), "{errors}");
            assert!(errors.contains(reason) && !errors.contains("leave_multicast"), "{errors}");
            assert_eq!(self.micro.wheels(), (0, 0), "the wheels stand");
            computer = Computer::start(n + 1, &self.socket);
        }
        let mut run = self.start_driving();
        signal(&run, "INT");
        run.wait();
        drop(computer);
    }
}

#[test]
fn a_robot_that_was_out_of_reach_stands_and_drives_in_the_next_run() {
    in_own_network(async || cut_again_and_again(None).await);
}

#[cfg(feature = "security")]
#[test]
fn a_secured_robot_that_was_out_of_reach_stands_and_drives_in_the_next_run() {
    in_own_network(async || {
        let (_keys, tracker) = crate::secured_fleet::secure_this_test();
        cut_again_and_again(tracker).await;
    });
}

/// In a secured fleet, `enclave` is that of the tracker.
async fn cut_again_and_again(enclave: Option<Enclave>) {
    make_base();
    let options = SessionOptions { domain_id: 42, interfaces: vec![IpAddr::V4(BASE)], enclave };
    let session = Session::open(&options).expect("the bridge is there");
    let cutting = tokio::task::spawn_blocking(|| {
        let mut fleet = FleetUnderTest::new();
        for (n, cut) in cuts().into_iter().enumerate() {
            fleet.cut(2 * n, cut);
        }
    });
    tokio::select! {
        ended = cutting => ended.expect("the panic above gives the reason"),
        () = track(&session, &ROBOTS[..1]) => {}
    }
    session.close().await;
}
