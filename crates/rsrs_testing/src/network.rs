//! Runs the body of a test in a process of its own, in a network of its own.

use std::ffi::OsString;
use std::io::Write;
use std::process::{Child, Command, Stdio};
use std::sync::{Condvar, Mutex, PoisonError, RwLock, RwLockReadGuard};
use std::time::Duration;

use clap::Parser;
use rsrs_ros::confine;
use rsrs_ros::interfaces::LOOPBACK;
use rsrs_ros::session::{Session, SessionOptions};

/// Set in the process that runs the body.
const IS_CHILD: &str = "RSRS_TEST_IN_OWN_NETWORK";
/// Printed at the end of the body, so that a child which ran no test is noticed.
const DONE: &str = "the body of the test has run";
/// Printed by a body that fails since the machine kept a process waiting.
const STARVED: &str = "as the machine kept a process waiting for longer than it may";
/// How often such a body is run again.
const MOST_TIMES_AGAIN: usize = 2;

/// Robots that are driven in real time have deadlines, and use a fifth of a processor or less: so many
/// networks at once leave each its time.
const MOST_NETWORKS: usize = 4;

/// How many networks there are now.
static N_NETWORKS: Mutex<usize> = Mutex::new(0);
static ONE_ENDED: Condvar = Condvar::new();

/// Room for one network.
struct Permit;

impl Permit {
    /// Waits until there is room for one more.
    fn acquire() -> Self {
        let n_networks = N_NETWORKS.lock().unwrap_or_else(PoisonError::into_inner);
        let mut n_networks = ONE_ENDED
            .wait_while(n_networks, |n_networks| *n_networks >= MOST_NETWORKS)
            .unwrap_or_else(PoisonError::into_inner);
        *n_networks += 1;
        Self
    }
}

impl Drop for Permit {
    fn drop(&mut self) {
        *N_NETWORKS.lock().unwrap_or_else(PoisonError::into_inner) -= 1;
        ONE_ENDED.notify_one();
    }
}

/// Held for reading by bodies and by commands that compute, and for writing by a body that is run again.
static PROCESSORS: RwLock<()> = RwLock::new(());

/// Held by a test while a command of it computes: it waits while a body that was starved is run again.
pub fn share_processors() -> RwLockReadGuard<'static, ()> {
    PROCESSORS.read().unwrap_or_else(PoisonError::into_inner)
}

/// Only what hangs takes so long.
pub const TIMEOUT: Duration = Duration::from_secs(300);

/// Runs `body` in a child that sees no network but its own, and that finds the calling test by its
/// name.
pub fn in_own_network(test: &str, body: impl AsyncFnOnce()) {
    in_own_network_with(test, &[], body);
}

/// As [`in_own_network`], with variables that the child finds in its environment.
pub fn in_own_network_with(test: &str, variables: &[(&str, OsString)], body: impl AsyncFnOnce()) {
    if std::env::var_os(IS_CHILD).is_none() {
        run_child(test, variables);
        return;
    }

    assert!(confine::is_confined().expect("/proc is readable"), "the child sees the LAN");
    rsrs_ros::logging::init(rsrs_ros::logging::Level::Warn);
    tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()
        .expect("a runtime needs no rights")
        .block_on(body());
    writeln!(std::io::stdout(), "{DONE}").expect("the parent reads it");
}

/// Fails the body of a test in a network of its own for what the machine did to it; the body is run again then,
/// while no body of another test is run and no command computes ([`share_processors`]), twice at most.
pub fn fail_as_starved(reason: &str) -> ! {
    panic!("{STARVED}: {reason}");
}

fn run_child(test: &str, variables: &[(&str, OsString)]) {
    let mut failed = {
        let _permit = Permit::acquire();
        let _processors = share_processors();
        run_child_once(test, variables)
    };
    for _ in 0..MOST_TIMES_AGAIN {
        let reason = failed.as_ref().and_then(|printed| printed.split_once(STARVED));
        let Some((_, reason)) = reason else { break };
        let reason = reason.split("\nstack backtrace").next().unwrap_or_default();
        writeln!(std::io::stderr(), "{test} is run again, {STARVED}{reason}").expect("it is read");
        let _processors = PROCESSORS.write().unwrap_or_else(PoisonError::into_inner);
        failed = run_child_once(test, variables);
    }
    if let Some(printed) = failed {
        panic!("{test} failed:\n{printed}");
    }
}

/// What it printed, if it failed.
fn run_child_once(test: &str, variables: &[(&str, OsString)]) -> Option<String> {
    let executable = std::env::current_exe().expect("a running test has an executable");
    // Robots have deadlines, and the tests beside this one do not; where a user may not ask for a
    // higher priority, `nice` runs the command as it is. A real-time class would be no help: nodes of
    // equal priority take turns of 100 ms.
    let mut command = Command::new("nice");
    command
        .args(["-n", "-10"])
        .arg(executable)
        .args(["--exact", test, "--nocapture"])
        .env(IS_CHILD, "1")
        .envs(variables.iter().cloned());
    let output = confine::start_in_own_network(&mut command).output().expect(
        "tests need network namespaces: see `sysctl kernel.apparmor_restrict_unprivileged_userns`",
    );

    let text = String::from_utf8_lossy(&output.stdout);
    let errors = String::from_utf8_lossy(&output.stderr);
    let has_passed = output.status.success() && text.contains(DONE);
    (!has_passed).then(|| format!("{text}\n{errors}"))
}

/// A session on the loopback interface.
pub fn session() -> Session {
    assert!(confine::is_confined().expect("/proc is readable"), "a test would reach the LAN");
    Session::open(&SessionOptions { domain_id: 42, interfaces: vec![LOOPBACK], enclave: None })
        .expect("the loopback interface is there")
}

/// The test in which a node's process is one, by [`run_node`].
const NODE: &str = "node";
/// Stands before the arguments of the node.
const START: &str = "--";

/// Runs a node by its `main` if this is a process of [`NodeProcess`], and nothing otherwise.
///
/// A binary of tests with such processes has a test `node` at its root that calls this and nothing else.
pub fn run_node<F: Parser, E: std::fmt::Debug>(main: impl FnOnce(F) -> Result<(), E>) {
    let mut arguments = std::env::args().skip_while(|argument| argument != START).peekable();
    if arguments.peek().is_some() {
        main(F::parse_from(arguments)).expect("the node ends as it was asked to");
    }
}

/// A node's process, ended with the test whatever happens.
pub struct NodeProcess(pub Child);

impl NodeProcess {
    /// Starts a node of these robots, separated by commas, where [`session`] finds it: this program again, as
    /// [`run_node`].
    pub fn start(robots: &str, arguments: &[&str]) -> Self {
        let program = std::env::current_exe().expect("a running test has an executable");
        let child = Command::new(program)
            .args(["--exact", NODE, "--nocapture", "--test-threads=1", START])
            .args(["--interface", "127.0.0.1", "--robots", robots])
            .args(arguments)
            .env("ROS_DOMAIN_ID", "42")
            .stdout(Stdio::null())
            .spawn()
            .expect("this program can be started again");
        Self(child)
    }
}

impl Drop for NodeProcess {
    fn drop(&mut self) {
        // It may have ended already.
        drop(self.0.kill());
        drop(self.0.wait());
    }
}

/// `CYCLONEDDS_URI` with which Cyclone DDS uses the only interface of a network of its own, which it would
/// avoid.
pub const CYCLONE_ON_LOOPBACK: &str = "<CycloneDDS><Domain><General><Interfaces>\
    <NetworkInterface name=\"lo\" multicast=\"true\"/>\
    </Interfaces></General></Domain></CycloneDDS>";

/// Waits until `condition` holds.
pub async fn eventually(what: &str, condition: impl FnMut() -> bool) {
    within(TIMEOUT, what, condition).await;
}

/// Waits until `condition` holds, which has to be soon.
pub async fn within(bound: Duration, what: &str, mut condition: impl FnMut() -> bool) {
    let start = std::time::Instant::now();
    while !condition() {
        assert!(start.elapsed() < bound, "it never came true that {what}");
        tokio::time::sleep(Duration::from_millis(20)).await;
    }
}
