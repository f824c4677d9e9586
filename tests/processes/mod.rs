//! The program under test as a process.

use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::OnceLock;
use std::time::{Duration, Instant};

use rsrs_ros::confine;
use rsrs_testing::network::{self, TIMEOUT};

/// The keystore of all programs that this test starts.
static KEYSTORE: OnceLock<PathBuf> = OnceLock::new();

/// From now on every program under test takes part in a fleet with this keystore. A test that calls
/// this is alone in its process, as those in a network of their own are.
#[cfg_attr(
    not(feature = "security"),
    expect(dead_code, reason = "without DDS Security there is none")
)]
pub fn secure_all(keystore: &Path) {
    KEYSTORE.set(keystore.to_owned()).expect("a test has one keystore");
}

/// The program under test.
pub fn rsrs() -> Command {
    let mut command = plain_rsrs();
    if let Some(keystore) = KEYSTORE.get() {
        secure(&mut command, keystore);
    }
    command
}

/// In a secured fleet, lets the program that was started before this one join: programs that join at
/// once lose handshakes.
pub fn join_alone() {
    if KEYSTORE.get().is_some() {
        std::thread::sleep(Duration::from_secs(1));
    }
}

/// Makes a program take part in a fleet with a keystore.
pub fn secure(command: &mut Command, keystore: &Path) {
    command
        .env("ROS_SECURITY_ENABLE", "true")
        .env("ROS_SECURITY_STRATEGY", "Enforce")
        .env("ROS_SECURITY_KEYSTORE", keystore)
        .env_remove("ROS_SECURITY_ENCLAVE_OVERRIDE");
}

fn plain_rsrs() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_rsrs"));
    for variable in
        ["RSRS_INTERFACE", "ROS_AUTOMATIC_DISCOVERY_RANGE", "ROS_LOCALHOST_ONLY", "RUST_LOG"]
    {
        command.env_remove(variable);
    }
    command.env("ROS_DOMAIN_ID", "42");
    command
}

/// The program in a network of its own, whatever it does itself.
pub fn confined_rsrs() -> Command {
    let mut command = rsrs();
    confine::start_in_own_network(&mut command);
    command
}

/// Runs the body of the test whose thread this is in a process and a network of their own.
pub fn in_own_network(body: impl AsyncFnOnce()) {
    let thread = std::thread::current();
    network::in_own_network(thread.name().expect("a test's thread has the test's name"), body);
}

/// Runs an experiment to its end, in a network of its own and with `more` arguments, into a bag in the folder that
/// it is run from; again what a busy machine has frozen, as `rsrs dry-run` does. Returns what it printed.
pub fn run_in_lockstep(experiment: &Path, more: &[&str], bag: &Path) -> String {
    let run = || {
        let mut command = confined_rsrs();
        command.current_dir(bag.parent().expect("a bag is in a folder"));
        command.arg("run").arg(experiment).args(more).arg("-o").arg(bag);
        Process::start(&mut command).output()
    };
    let (mut status, mut printed, mut errors) = run();
    for _ in 0..2 {
        if printed.contains("void: frozen") {
            std::fs::remove_dir_all(bag).expect("it is there");
            (status, printed, errors) = run();
        }
    }
    assert!(status.success(), "{printed}{errors}");
    printed
}

/// A process that does not outlive its test.
pub struct Process(pub Child);

impl Drop for Process {
    fn drop(&mut self) {
        // It may have ended already.
        drop(self.0.kill());
        drop(self.0.wait());
    }
}

impl Process {
    /// Starts a program whose standard error can be read at its end.
    pub fn start(command: &mut Command) -> Self {
        command.stdout(Stdio::piped()).stderr(Stdio::piped());
        Self(command.spawn().expect("the program was built for this test"))
    }

    /// Waits for the end: how it ended, and what it wrote to standard error.
    pub fn wait(&mut self) -> (ExitStatus, String) {
        let start = Instant::now();
        let status = loop {
            if let Some(status) = self.0.try_wait().expect("it is our child") {
                break status;
            }
            assert!(start.elapsed() < TIMEOUT, "the program does not end");
            std::thread::sleep(Duration::from_millis(20));
        };
        let mut errors = String::new();
        if let Some(stderr) = &mut self.0.stderr {
            stderr.read_to_string(&mut errors).expect("errors are text");
        }
        (status, errors)
    }

    /// As [`Self::wait`], with what it wrote to standard output before that to standard error.
    pub fn output(&mut self) -> (ExitStatus, String, String) {
        let (status, errors) = self.wait();
        let mut printed = String::new();
        let stdout = self.0.stdout.as_mut().expect("it is a pipe");
        stdout.read_to_string(&mut printed).expect("results are text");
        (status, printed, errors)
    }

    /// As [`Self::wait`], while the test goes on: its exit code, and what it wrote to standard error.
    pub async fn ended(mut self) -> (Option<i32>, String) {
        let waiting = tokio::task::spawn_blocking(move || self.wait());
        let (status, errors) = waiting.await.expect("waiting does not panic");
        (status.code(), errors)
    }
}

/// Asserts that a run went to its end, by its exit code and what it wrote to standard error.
pub fn assert_completed(code: Option<i32>, printed: &str) {
    if code != Some(0) {
        fail(printed);
    }
}

/// Fails the test in whose network a run ended as it should not have; the test is run again if the machine starved
/// the run.
pub fn fail(printed: &str) -> ! {
    if is_starved(printed) {
        network::fail_as_starved(printed);
    }
    panic!("{printed}");
}

/// Fails the test in whose network a robot in rclpy did not move at all; the test is run again. Where many programs
/// start beside each other on few processors, it happens that Fast DDS never hears of the controller's first writers,
/// and of those alone: no command reaches these robots, and poses that do not follow commands keep the run from
/// being counted.
pub fn fail_unless_moved(robot: &str, by_m: f64, more_than_m: f64) {
    if by_m > more_than_m {
        return;
    }
    let reason = format!("{robot} moved by {by_m} m, expected more than {more_than_m}");
    assert!(by_m < 1e-3, "{reason}");
    network::fail_as_starved(&reason);
}

/// Whether a run ended because the machine gave one of its processes no processor for half a second, as
/// it should end then, or because the threads of its middleware wait for each other, as they may where many
/// programs start at once, by what it wrote to standard error.
pub fn is_starved(printed: &str) -> bool {
    [
        "lease ran out",
        "commands paused in",
        ": silent",
        "controller silent",
        "too slow for real time",
        "this machine is too slow",
        "was not acknowledged for",
        "% of the poses",
        "no detection received for more than",
        "no valid reading of the sensor for more than",
        "no state of the microcontroller for",
        "the threads of the middleware wait for each other",
    ]
    .iter()
    .any(|sign| printed.contains(sign))
}

/// Processes that a program has started as its nodes and that run now.
pub fn nodes_of(pid: u32) -> Vec<u32> {
    let wanted = format!("--parent\0{pid}\0");
    std::fs::read_dir("/proc")
        .expect("/proc is there")
        .filter_map(|entry| entry.ok()?.file_name().to_str()?.parse().ok())
        .filter(|process: &u32| {
            // A process may end while we look.
            std::fs::read(format!("/proc/{process}/cmdline"))
                .is_ok_and(|line| String::from_utf8_lossy(&line).contains(&wanted))
        })
        .collect()
}
