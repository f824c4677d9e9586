//! Sensors and wheels: the hardware of a robot, of any make.
//!
//! To add a driver, write one file with a type that implements [`Driver`], name it here and in
//! [`DriverKind`], and give it an arm in `node::run`. The node does all the rest: the gate, limits,
//! debouncing, topics, diagnostics. `ros.rs` is the shortest complete example.

pub mod ros;
pub mod serial;
pub mod virtual_robot;

use std::str::FromStr;

use rsrs_core::robot::controller::Command;
use rsrs_fleet::parameters::one_of;
use rsrs_msgs::sensor_msgs::Range;
use rsrs_ros::parameters::{Descriptor, ParameterServer, ParameterValue};
use rsrs_ros::session::{NodeHandle, Session};
use tokio::sync::mpsc::UnboundedReceiver;

/// Which driver a robot has; the names are those of the fleet file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DriverKind {
    /// A microcontroller on a serial line.
    Serial,
    /// Another node, which takes velocity commands.
    Ros,
    /// No hardware: a robot of the simulator.
    Virtual,
}

/// A driver that there is not.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("driver `{found}`, expected {}", DriverKind::words())]
pub struct NoSuchDriver {
    /// What was given.
    pub found: String,
}

impl FromStr for DriverKind {
    type Err = NoSuchDriver;

    fn from_str(text: &str) -> Result<Self, NoSuchDriver> {
        Self::ALL
            .into_iter()
            .find(|kind| kind.name() == text)
            .ok_or_else(|| NoSuchDriver { found: text.to_owned() })
    }
}

impl DriverKind {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Serial, Self::Ros, Self::Virtual];

    /// Their names, for a sentence.
    pub fn words() -> String {
        one_of(&Self::ALL.map(Self::name))
    }

    /// As the fleet file spells it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Serial => "serial",
            Self::Ros => "ros",
            Self::Virtual => "virtual",
        }
    }

    /// The parameters that this driver has besides those of every robot.
    pub fn parameters(self) -> Vec<(Descriptor, ParameterValue)> {
        match self {
            Self::Serial => serial::SerialDriver::parameters(),
            Self::Ros => ros::RosDriver::parameters(),
            Self::Virtual => virtual_robot::VirtualDriver::parameters(),
        }
    }
}

/// What a driver reports.
#[derive(Clone, Debug, PartialEq)]
pub enum Report {
    /// Sensor and wheels work.
    Up,
    /// They do not, and why. The driver goes on trying, and reports when they work again.
    Down(String),
    /// The sensor measured.
    Sensed(Sensed),
    /// The battery's voltage, in volts.
    Battery(f32),
    /// The hardware sent what is not used, and why not.
    Refused(String),
}

/// One measurement of a robot's sensor.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sensed {
    /// The detection, if the hardware decides it; it goes before the range.
    pub seen: Option<bool>,
    /// The distance that was measured, if there is one.
    pub range: Option<Range>,
    /// What further sensors of the hardware report, by name.
    pub further: Vec<(String, bool)>,
}

/// Where a driver is.
#[derive(Clone, Copy)]
pub struct DriverContext<'a> {
    /// The robot's participant.
    pub session: &'a Session,
    /// The robot's node, for its log and topics.
    pub node: &'a NodeHandle,
    /// The robot's name.
    pub robot: &'a str,
    /// Its parameters.
    pub server: &'a ParameterServer,
}

/// Sensor and wheels of one robot.
///
/// The node waits for [`report`](Driver::report) and for much else at the same time; it is the only
/// one that calls [`drive`](Driver::drive), at least every 50 ms while the driver is up. A driver
/// has to see to it that the wheels stop when these calls stay away for 250 ms, even if this
/// process dies: by a timeout in what moves the wheels.
pub trait Driver: Sized {
    /// The parameters that the driver needs, with the values that they have where none is given.
    fn parameters() -> Vec<(Descriptor, ParameterValue)>;

    /// Starts, with the robot's parameters. Hardware that does not answer yet is no error.
    fn open(place: DriverContext<'_>) -> anyhow::Result<Self>;

    /// Waits for the next report. Loses nothing when it is dropped while it waits.
    fn report(&mut self) -> impl Future<Output = Report>;

    /// Makes the wheels follow a command, until the next one or for 250 ms.
    fn drive(&mut self, command: Command) -> impl Future<Output = anyhow::Result<()>>;

    /// Where its sensor's readings come from, in words: a topic or a port.
    fn sensor(&self) -> String;

    /// Name and value of what is worth a look, for `/diagnostics`.
    fn health(&self) -> Vec<(&'static str, String)>;
}

/// Waits for the next report of a subscription; for ever once the session is closed, because whoever
/// closed it waits for nothing any more.
async fn next_of(reports: &mut UnboundedReceiver<Report>) -> Report {
    match reports.recv().await {
        Some(report) => report,
        None => std::future::pending().await,
    }
}
