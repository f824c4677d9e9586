//! Everything that a run subscribes to, each topic once, as the bytes that the bag keeps.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};

use rsrs_bags::definitions::Definition;
use rsrs_bags::trajectory::TrackedTopic;
use rsrs_core::robot::sensor::ReadingNames;
use rsrs_core::world::WorldFile;
use rsrs_fleet::experiment::Time;
use rsrs_fleet::fleet_file::{Driver, FleetRobot};
use rsrs_msgs::topics::{self, Qos, Topic};
use rsrs_ros::session::{ReceivedRaw, Session, SessionError, Subscription};
use tokio::sync::mpsc::UnboundedSender;

/// What a topic is in a run; robots by their index.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// The readings of a robot's sensor.
    Detection(usize),
    /// Those of a further one.
    FurtherDetection(usize),
    /// A robot's velocity command.
    Command(usize),
    /// Odometry: the own estimate of a robot, or the ground truth of the simulator.
    Odometry(usize),
    /// Where a tracker sees a robot.
    Pose(usize),
    /// Where a tracker sees robots, on a topic that is not each robot's own.
    Tracker,
    /// Where an object is.
    Object,
    /// A robot's gate.
    Robot(usize),
    /// A robot's controller.
    Controller(usize),
    /// The status of the simulator.
    Simulator,
    /// The fingerprint of the simulated world.
    WorldDigest,
    /// Simulated time.
    Clock,
    /// Leases, our own among them.
    Lease,
    /// The e-stop.
    EStop,
    /// Releases of the e-stop's locks.
    EStopRelease,
    /// The tree of transforms.
    Transforms,
    /// The part of it that stays as it is, kept also from before the bag is open.
    StaticTransforms,
    /// What the simulator shows: kept now and then.
    Markers,
    /// The health of parts.
    Diagnostics,
    /// Changes of parameters and logs of nodes, kept also from before the bag is open: they show how
    /// a run was set up.
    Preparation,
    /// Kept, and not looked at.
    Other,
}

/// One topic that is subscribed to.
#[derive(Clone, Debug)]
pub struct RecordedTopic {
    /// Its full name.
    pub name: String,
    /// Its type, such as `std_msgs/msg/Bool`.
    pub type_name: String,
    /// Its quality of service.
    pub qos: Qos,
    /// What it is in this run.
    pub role: Role,
    /// What the type is, where it is not one of those that are compiled in.
    pub definition: Option<Arc<Definition>>,
    /// Samples that were let go because the queue to the bag was full.
    overflow: Arc<AtomicU64>,
}

impl RecordedTopic {
    /// A topic of which nothing was let go yet.
    pub fn new(name: String, topic: Topic, role: Role) -> Self {
        Self::described(name, topic.type_name, topic.qos, role)
    }

    /// The same with a type of any name.
    pub fn described(name: String, type_name: &str, qos: Qos, role: Role) -> Self {
        let type_name = type_name.to_owned();
        Self { name, type_name, qos, role, definition: None, overflow: Arc::default() }
    }

    /// Counts a sample that was let go because the queue to the bag was full.
    pub fn count_overflow(&self) {
        self.overflow.fetch_add(1, Ordering::Relaxed);
    }

    /// Samples that were let go because the queue to the bag was full.
    pub fn n_overflowed(&self) -> u64 {
        self.overflow.load(Ordering::Relaxed)
    }
}

/// A sample on one of the recorded topics.
#[derive(Debug)]
pub struct Sample {
    /// Index of the recorded topic.
    pub topic_index: usize,
    /// What came.
    pub received: ReceivedRaw,
    /// Free again when the sample is dropped.
    _place: QueueSlot,
}

/// A place in the queue to the bag.
#[derive(Debug)]
struct QueueSlot(Arc<AtomicUsize>);

impl QueueSlot {
    /// The next free place; `None` if there is none.
    fn take(taken: &Arc<AtomicUsize>) -> Option<Self> {
        // Counted by hand, because a bounded channel would have to be waited for on both sides.
        let one_more = |n_taken| (n_taken < QUEUE_SAMPLES).then_some(n_taken + 1);
        let found = taken.fetch_update(Ordering::Relaxed, Ordering::Relaxed, one_more);
        found.ok().map(|_n_before| Self(taken.clone()))
    }
}

impl Drop for QueueSlot {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::Relaxed);
    }
}

/// Samples between the network and the bag, at most: 17 s of 100 robots with three topics at 20 Hz.
///
/// A disk that is slower for longer costs samples, which are counted, and never holds up a robot or
/// takes all memory.
const QUEUE_SAMPLES: usize = 100_000;

/// Deeper than what is published between two looks, for topics whose newest sample alone counts to
/// others.
pub const LEAST_DEPTH: u32 = 100;

/// The topics of a run of these robots, with what they report, and of the objects of its world.
/// Those with the poses of the robots may be among those of every run.
pub fn recorded_topics(
    robots: &[FleetRobot],
    time: Time,
    (readings, n_objects): (&ReadingNames, usize),
    tracked: &[TrackedTopic],
) -> Vec<RecordedTopic> {
    // What the simulator keeps in lockstep, robots and trackers publish as they like.
    let kept_in_lockstep = |topic: Topic, of_others: Qos| match time {
        Time::Lockstep => topic,
        Time::RealTime => Topic { qos: of_others, ..topic },
    };
    let mut recorded_topics = Vec::new();
    for (index, robot) in robots.iter().enumerate() {
        for (topic, role) in [
            (topics::DETECTION, Role::Detection(index)),
            (robot.cmd_vel.topic(), Role::Command(index)),
            (topics::ODOM, Role::Odometry(index)),
            (topics::POSE, Role::Pose(index)),
            (topics::RANGE, Role::Other),
            (topics::STATUS, Role::Robot(index)),
            (topics::CONTROLLER_STATUS, Role::Controller(index)),
        ] {
            recorded_topics.push(RecordedTopic::new(topic.for_robot(&robot.name), topic, role));
        }
        for reading in readings.further() {
            let name = topics::further_detection(&robot.name, reading);
            let topic = kept_in_lockstep(topics::FURTHER_DETECTION, topics::DETECTION.qos);
            let role = Role::FurtherDetection(index);
            recorded_topics.push(RecordedTopic::new(name, topic, role));
        }
        if receives_virtual_detections(robot, robots) {
            let topic = topics::VIRTUAL_DETECTION;
            recorded_topics.push(RecordedTopic::new(
                topic.for_robot(&robot.name),
                topic,
                Role::Other,
            ));
        }
    }
    for object in 0..n_objects {
        let name = topics::object_pose(&WorldFile::object_name(object));
        let topic = kept_in_lockstep(topics::OBJECT_POSE, topics::POSE.qos);
        recorded_topics.push(RecordedTopic::new(name, topic, Role::Object));
    }
    for (topic, role) in [
        (topics::CLOCK, Role::Clock),
        (topics::WORLD_DIGEST, Role::WorldDigest),
        (topics::SIMULATOR_STATUS, Role::Simulator),
        (topics::LEASE, Role::Lease),
        (topics::E_STOP, Role::EStop),
        (topics::E_STOP_RELEASE, Role::EStopRelease),
        (topics::E_STOP_LOCKS, Role::Other),
        (topics::MARKERS, Role::Markers),
        (topics::DIAGNOSTICS, Role::Diagnostics),
        (topics::TF, Role::Transforms),
        (topics::TF_STATIC, Role::StaticTransforms),
        (topics::PARAMETER_EVENTS, Role::Preparation),
        (topics::ROSOUT, Role::Preparation),
    ] {
        recorded_topics.push(RecordedTopic::new(topic.name.to_owned(), topic, role));
    }
    for TrackedTopic { name, topic, .. } in tracked {
        if !recorded_topics.iter().any(|recorded_topic| recorded_topic.name == *name) {
            recorded_topics.push(RecordedTopic::new(name.clone(), *topic, Role::Tracker));
        }
    }
    recorded_topics
}

/// Whether the simulator publishes which virtual robots a real one sees.
fn receives_virtual_detections(robot: &FleetRobot, all: &[FleetRobot]) -> bool {
    let is_virtual = |robot: &FleetRobot| robot.driver == Driver::Virtual;
    !is_virtual(robot) && all.iter().any(is_virtual)
}

/// Starts to listen.
pub fn listen(
    session: &Session,
    recorded_topics: &[RecordedTopic],
    queue: &Queue,
) -> Result<Vec<Subscription>, SessionError> {
    recorded_topics
        .iter()
        .enumerate()
        .map(|(index, recorded_topic)| queue.listen(session, index, recorded_topic))
        .collect()
}

/// The way of samples to the bag, which has room for so many of them.
pub struct Queue {
    samples: UnboundedSender<Sample>,
    taken: Arc<AtomicUsize>,
}

impl Queue {
    /// An empty queue.
    pub fn new(samples: UnboundedSender<Sample>) -> Self {
        Self { samples, taken: Arc::default() }
    }

    /// Starts to listen to one topic.
    pub fn listen(
        &self,
        session: &Session,
        index: usize,
        recorded_topic: &RecordedTopic,
    ) -> Result<Subscription, SessionError> {
        let (samples, taken, overflow) =
            (self.samples.clone(), self.taken.clone(), recorded_topic.overflow.clone());
        let qos = Qos { depth: recorded_topic.qos.depth.max(LEAST_DEPTH), ..recorded_topic.qos };
        session.subscribe_raw(
            &recorded_topic.name,
            &recorded_topic.type_name,
            qos,
            move |received| {
                let Some(place) = QueueSlot::take(&taken) else {
                    overflow.fetch_add(1, Ordering::Relaxed);
                    return;
                };
                // There is no receiver once the run is over.
                drop(samples.send(Sample { topic_index: index, received, _place: place }));
            },
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_full_queue_lets_samples_go_and_takes_them_again_when_there_is_room() {
        let taken = Arc::new(AtomicUsize::new(QUEUE_SAMPLES - 1));

        let last = QueueSlot::take(&taken);
        let refused = QueueSlot::take(&taken);
        drop(last);
        let next = QueueSlot::take(&taken);

        assert!(refused.is_none());
        assert!(next.is_some());
    }
}
