//! Everything that a run listens to, each topic once, as the bytes that the bag keeps.

use rsrs_fleet::fleet_file::{CmdVel, FleetRobot};
use rsrs_msgs::topics::{self, Qos, Topic};
use rsrs_ros::session::{ReceivedRaw, Session, SessionError, Subscription};
use tokio::sync::mpsc::UnboundedSender;

/// What a topic is in a run; robots by their index.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// What a robot's sensor says.
    Detection,
    /// A robot's velocity command.
    Command,
    /// Where a robot says it is.
    Odometry(usize),
    /// Where a tracker sees a robot.
    Pose(usize),
    /// A robot's gate.
    Robot(usize),
    /// A robot's controller.
    Controller(usize),
    /// The simulator's word on itself.
    Simulator,
    /// The fingerprint of the simulated world.
    WorldDigest,
    /// Simulated time.
    Clock,
    /// Leases, our own among them.
    Lease,
    /// The e-stop.
    EStop,
    /// The health of parts.
    Diagnostics,
    /// Changes of parameters and what nodes say, kept also from before the bag is open: they tell how
    /// a run was set up.
    Preparation,
    /// Kept, and not looked at.
    Other,
}

/// One topic that is listened to.
#[derive(Clone, Debug)]
pub struct Ear {
    /// Its full name.
    pub name: String,
    /// Its type and quality of service.
    pub topic: Topic,
    /// What it is in this run.
    pub role: Role,
}

/// A sample on one of the ears.
#[derive(Debug)]
pub struct Sample {
    /// Index of the ear.
    pub ear: usize,
    /// What came.
    pub received: ReceivedRaw,
}

/// Deeper than what is published between two looks, for topics whose newest sample alone counts to
/// others.
const LEAST_DEPTH: u32 = 100;

/// The topics of a run.
pub fn ears(robots: &[FleetRobot]) -> Vec<Ear> {
    let mut ears = Vec::new();
    for (index, robot) in robots.iter().enumerate() {
        let cmd_vel = match robot.cmd_vel {
            CmdVel::TwistStamped => topics::CMD_VEL,
            CmdVel::Twist => topics::CMD_VEL_UNSTAMPED,
        };
        for (topic, role) in [
            (topics::DETECTION, Role::Detection),
            (cmd_vel, Role::Command),
            (topics::ODOM, Role::Odometry(index)),
            (topics::POSE, Role::Pose(index)),
            (topics::RANGE, Role::Other),
            (topics::STATUS, Role::Robot(index)),
            (topics::CONTROLLER_STATUS, Role::Controller(index)),
        ] {
            ears.push(Ear { name: topic.for_robot(&robot.name), topic, role });
        }
    }
    for (topic, role) in [
        (topics::CLOCK, Role::Clock),
        (topics::WORLD_DIGEST, Role::WorldDigest),
        (topics::SIMULATOR_STATUS, Role::Simulator),
        (topics::LEASE, Role::Lease),
        (topics::E_STOP, Role::EStop),
        (topics::DIAGNOSTICS, Role::Diagnostics),
        (topics::TF, Role::Other),
        (topics::PARAMETER_EVENTS, Role::Preparation),
        (topics::ROSOUT, Role::Preparation),
    ] {
        ears.push(Ear { name: topic.name.to_owned(), topic, role });
    }
    ears
}

/// Starts to listen.
///
/// # Errors
///
/// If a subscription cannot be made.
pub fn listen(
    session: &Session,
    ears: &[Ear],
    samples: &UnboundedSender<Sample>,
) -> Result<Vec<Subscription>, SessionError> {
    ears.iter()
        .enumerate()
        .map(|(index, ear)| {
            let samples = samples.clone();
            let qos = Qos { depth: ear.topic.qos.depth.max(LEAST_DEPTH), ..ear.topic.qos };
            session.subscribe_raw(&ear.name, ear.topic.type_name, qos, move |received| {
                // Nobody listens any more once the run is over.
                drop(samples.send(Sample { ear: index, received }));
            })
        })
        .collect()
}
