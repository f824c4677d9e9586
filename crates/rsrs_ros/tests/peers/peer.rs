//! A program of another maker, as a process in this network.

use std::io::{BufRead, BufReader, Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

use serde::de::DeserializeOwned;
use tempfile::TempDir;
use tokio::sync::mpsc::{UnboundedReceiver, unbounded_channel};

use rsrs_testing::network::CYCLONE_ON_LOOPBACK;
use rsrs_testing::network::TIMEOUT;
use rsrs_testing::python::{CYCLONE, JAZZY, KILTED, python_with};

/// Whose middleware and messages it uses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Maker {
    /// Cyclone DDS, with types that it makes from our definitions.
    Cyclone,
    /// ROS 2 Jazzy: rclpy over Fast DDS, with the messages of its packages.
    Jazzy,
    /// ROS 2 Kilted, the same.
    Kilted,
}

impl Maker {
    /// Its interpreter; to be asked for outside the network namespace, where the package index can
    /// be reached.
    pub fn python(self) -> PathBuf {
        python_with(match self {
            Self::Cyclone => &CYCLONE,
            Self::Jazzy => &JAZZY,
            Self::Kilted => &KILTED,
        })
    }

    /// Whether it has the messages of a package. The package index has neither of these two for
    /// rclpy; Cyclone DDS makes the types of all packages.
    pub fn has(self, package: &str) -> bool {
        let unpackaged = ["tf2_msgs", "rsrs_msgs", "motion_capture_tracking_interfaces"];
        self == Self::Cyclone || !unpackaged.contains(&package)
    }
}

/// A running script, which is sent lines and answers in lines of JSON.
pub struct Peer {
    process: Child,
    input: ChildStdin,
    output: UnboundedReceiver<String>,
    _logs: TempDir,
}

impl Drop for Peer {
    fn drop(&mut self) {
        // It may have ended already.
        drop(self.process.kill());
        drop(self.process.wait());
    }
}

impl Peer {
    /// Starts one of the scripts beside this file.
    pub fn start(python: &Path, script: &str) -> Self {
        let logs = tempfile::tempdir().expect("a folder to write in");
        let scripts = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/peers");
        let mut command = Command::new(python);
        for variable in ["ROS_AUTOMATIC_DISCOVERY_RANGE", "ROS_STATIC_PEERS", "ROS_LOCALHOST_ONLY"]
        {
            command.env_remove(variable);
        }
        // Without `-B` it would write its bytecode beside the scripts.
        command.arg("-B").arg(scripts.join(script));
        command.env("ROS_DOMAIN_ID", "42").env("ROS_LOG_DIR", logs.path());
        command.env("CYCLONEDDS_URI", CYCLONE_ON_LOOPBACK);
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut process = command.spawn().expect("python starts");
        let input = process.stdin.take().expect("it was asked for");
        let output = lines_of(process.stdout.take().expect("it was asked for"));
        Self { process, input, output, _logs: logs }
    }

    /// Sends it a line.
    pub fn send(&mut self, something: &impl serde::Serialize) {
        let line = serde_json::to_string(something).expect("it is plain data") + "\n";
        self.input.write_all(line.as_bytes()).expect("the script reads its input");
    }

    /// What it prints next.
    ///
    /// # Panics
    ///
    /// If it ends before, with what it wrote to standard error; or if it prints nothing for long.
    pub async fn receive<T: DeserializeOwned>(&mut self) -> T {
        let line = tokio::time::timeout(TIMEOUT, self.output.recv()).await;
        let Some(line) = line.expect("the script prints something in time") else {
            let mut errors = String::new();
            let stderr = self.process.stderr.as_mut().expect("it was asked for");
            stderr.read_to_string(&mut errors).expect("errors are text");
            panic!("the script ended: {errors}");
        };
        serde_json::from_str(&line).unwrap_or_else(|error| panic!("not JSON: {error}: {line}"))
    }

    /// Requests that it ends, and receives its last words.
    pub async fn end<T: DeserializeOwned>(mut self) -> T {
        self.send(&"end");
        let last = self.receive().await;
        let status = self.process.wait().expect("it is our child");
        assert!(status.success(), "{status}");
        last
    }
}

/// Lines as they come, read in a thread, which ends with the script.
fn lines_of(output: ChildStdout) -> UnboundedReceiver<String> {
    let (to_reader, lines) = unbounded_channel();
    std::thread::spawn(move || {
        for line in BufReader::new(output).lines().map_while(Result::ok) {
            // The test has seen enough and has dropped its receiver.
            to_reader.send(line).unwrap_or_default();
        }
    });
    lines
}
