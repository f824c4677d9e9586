//! The bag of a run while it is written: what came when, and whether a step is complete.

mod account;
mod disk;
#[cfg(test)]
mod tests;

use std::collections::{BTreeMap, BTreeSet};
use std::io;

use rsrs_bags::{BagError, BagOptions, BagWriter};
use rsrs_fleet::experiment::Time;
use rsrs_fleet::record::{ATTACHMENT, ENDING, Ending, ExperimentRecord, RECORDING};
use rsrs_msgs::cdr::{self, CdrError, ENCAPSULATION};
use rsrs_msgs::rosgraph_msgs::Clock;
use rsrs_msgs::rsrs::{LeaseState, RunLease, WorldDigest};
use rsrs_msgs::std_msgs;
use rsrs_msgs::topics::{self, Topic};
use rsrs_ros::clock::wall_time;
use rsrs_ros::session::ReceivedRaw;
use tokio::sync::mpsc::UnboundedSender;

use crate::plan::Plan;
use crate::recorded_topics::{RecordedTopic, Role};
use account::Account;
pub use disk::{Closing, Written};
use disk::{Disk, Message, ROOM};

/// Why a bag is not what the run was.
#[derive(Debug, thiserror::Error)]
pub enum RecorderError {
    /// The bag cannot be written.
    #[error(transparent)]
    Bag(#[from] BagError),
    /// There is no thread to write in.
    #[error("no thread for the bag")]
    Thread {
        /// The system's error.
        #[source]
        source: io::Error,
    },
    /// The queue to the bag is full.
    #[error(
        "the disk is too slow: {n_waiting} messages wait to be written, and the queue is full; \
         record to another disk, or fewer topics"
    )]
    TooSlow {
        /// Messages in the queue.
        n_waiting: usize,
    },
    /// A topic of the lockstep has skipped or repeated a step.
    #[error("{topic}: message {count} is of step {found}, expected step {count}")]
    OutOfStep {
        /// The topic.
        topic: String,
        /// Which message of the topic it is, from 1.
        count: u64,
        /// The step in the message.
        found: u64,
    },
    /// A message without a time stamp.
    #[error("{topic}: {n_bytes} bytes without a stamp")]
    Unstamped {
        /// The topic.
        topic: String,
        /// Length of the message.
        n_bytes: usize,
    },
    /// A message that is not of its topic's type.
    #[error("{topic}: not of its type")]
    Undecodable {
        /// The topic.
        topic: String,
        /// What is wrong with it.
        #[source]
        source: CdrError,
    },
}

impl RecorderError {
    /// What went wrong, with the system's reason, such as a full disk.
    pub fn in_full(self) -> String {
        format!("{:#}", anyhow::Error::from(self))
    }
}

/// The recorder of one run.
///
/// It decides what time it is in the bag and counts what is missing; another thread writes.
pub struct Recorder {
    disk: Disk,
    /// A topic is added with its first message, so that the bag lists no topic without messages.
    added: BTreeSet<usize>,
    clock: BagClock,
    account: Account,
    has_overflowed: bool,
    run_id: String,
    /// Log time of the last markers that were kept, in nanoseconds.
    marked_ns: Option<u64>,
}

/// Least log time between two markers that are kept: ten in a second, as live viewers get them, would
/// be most of the bag.
const MARKERS_EVERY_NS: u64 = 450_000_000;

/// Where a topic is known by the index of its subscription, these are those without one: what the
/// runner itself publishes about the run.
const EXPERIMENT: usize = usize::MAX;
const ENDED: usize = usize::MAX - 1;

/// What time it is in the bag.
enum BagClock {
    /// The time of the wall.
    Wall,
    /// Simulated time, how many steps each topic of the lockstep has made, and whether the lease that lets
    /// the robots move was taken.
    Lockstep { period_ns: u64, now_ns: u64, steps: Steps, has_begun: bool },
}

impl Recorder {
    /// Has the bag opened, with all in it that it takes to repeat the run; the `record` is the
    /// plan's, with what was read since. Messages may be taken at once.
    ///
    /// The `report` receives [`Written::Opened`], or why the bag cannot be opened, such as a folder
    /// that exists; later what has been written.
    pub fn open(
        plan: &Plan,
        record: &ExperimentRecord,
        recorded_topics: &[RecordedTopic],
        report: UnboundedSender<Written>,
    ) -> Result<Self, RecorderError> {
        let custom_data = BTreeMap::from([
            ("run_id".to_owned(), record.run_id.clone()),
            ("rsrs_version".to_owned(), record.provenance.version.clone()),
        ]);
        let (folder, packing) = (plan.bag.clone(), plan.recording.packing);
        let (record_json, files) = (record.to_json(), plan.files.clone());
        let open = move || {
            let mut writer =
                BagWriter::create_packed(&folder, BagOptions { custom_data }, packing)?;
            writer.attach(ATTACHMENT, "application/json", record_json.as_bytes())?;
            for (name, text) in &files {
                writer.attach(name, "application/yaml", text.as_bytes())?;
            }
            Ok(writer)
        };
        let clock = match record.time {
            Time::RealTime => BagClock::Wall,
            Time::Lockstep => BagClock::Lockstep {
                period_ns: period_ns(record.conditions.period_s),
                now_ns: 0,
                has_begun: false,
                steps: Steps::new(
                    recorded_topics
                        .iter()
                        .enumerate()
                        .filter(|(_, recorded_topic)| makes_a_step(recorded_topic.role))
                        .map(|(index, _)| index),
                ),
            },
        };
        let mut recorder =
            Self::around(Disk::start(open, |_| {}, report, ROOM)?, clock, recorded_topics);
        recorder.run_id.clone_from(&record.run_id);
        recorder.note(EXPERIMENT, topics::EXPERIMENT, record.to_json());
        Ok(recorder)
    }

    fn around(disk: Disk, clock: BagClock, recorded_topics: &[RecordedTopic]) -> Self {
        let account = Account::new(recorded_topics);
        let (added, run_id) = (BTreeSet::new(), String::new());
        Self { disk, added, clock, account, has_overflowed: false, run_id, marked_ns: None }
    }

    /// Takes a message, which is written later. It never waits for the disk.
    ///
    /// # Errors
    ///
    /// In lockstep a message that is missing shows with the next one. The first message that finds
    /// the queue full is [`RecorderError::TooSlow`]; those after it are counted only.
    pub fn take(
        &mut self,
        index: usize,
        recorded_topic: &RecordedTopic,
        received: &ReceivedRaw,
    ) -> Result<(), RecorderError> {
        let data = &received.message;
        let log_time_ns = self.clock.log_time_ns(index, recorded_topic, data, &self.run_id)?;
        if recorded_topic.role == Role::Markers && !self.keeps_markers(log_time_ns) {
            self.account.add((index, received.writer), received.sequence);
            return Ok(());
        }
        if !self.disk.has_room_for(data.len()) {
            recorded_topic.count_overflow();
            if std::mem::replace(&mut self.has_overflowed, true) {
                return Ok(());
            }
            return Err(RecorderError::TooSlow { n_waiting: self.disk.n_waiting() });
        }
        let publish_time_ns = match self.clock {
            BagClock::Wall => received.source_time_ns.unwrap_or(log_time_ns),
            BagClock::Lockstep { .. } => log_time_ns,
        };
        if self.added.insert(index) {
            self.disk.add_topic(index, recorded_topic);
        }
        // The field of the file has 32 bits; counts beyond them start over.
        let sequence = u32::try_from(received.sequence & u64::from(u32::MAX))
            .expect("the mask leaves 32 bits");
        let (data, step) = (data.clone(), self.step());
        let recorded_topic = index;
        self.disk.write(Message {
            recorded_topic,
            log_time_ns,
            publish_time_ns,
            sequence,
            data,
            step,
        });
        self.account.add((index, received.writer), received.sequence);
        Ok(())
    }

    /// Whether it is time for the next markers.
    fn keeps_markers(&mut self, now_ns: u64) -> bool {
        let is_due =
            self.marked_ns.is_none_or(|last_ns| now_ns.abs_diff(last_ns) >= MARKERS_EVERY_NS);
        if is_due {
            self.marked_ns = Some(now_ns);
        }
        is_due
    }

    /// Writes a text of the runner itself: converters of bags keep messages, and neither attachments
    /// nor metadata.
    fn note(&self, index: usize, topic: Topic, text: String) {
        let now_ns = match self.clock {
            BagClock::Wall => wall_time().to_nanos().unwrap_or(0),
            BagClock::Lockstep { now_ns, .. } => now_ns,
        };
        self.disk.add_topic(index, &RecordedTopic::new(topic.name.to_owned(), topic, Role::Other));
        self.disk.write(Message {
            recorded_topic: index,
            log_time_ns: now_ns,
            publish_time_ns: now_ns,
            sequence: 0,
            data: cdr::encode(&std_msgs::String { data: text }),
            step: 0,
        });
    }

    /// The last step that every topic of the lockstep has made; 0 in real time.
    fn step(&self) -> u64 {
        match &self.clock {
            BagClock::Wall => 0,
            BagClock::Lockstep { steps, .. } => steps.made_by_all,
        }
    }

    /// Messages missing so far between two that were taken, on topics that are to lose none.
    pub fn n_lost(&self) -> u64 {
        self.account.n_missing_of_reliable()
    }

    /// Has the bag closed, with how the run ended and what of it is missing.
    /// [`Written::Closed`] reports it.
    pub fn close(self, ending: &Ending) -> Closing {
        self.note(ENDED, topics::ENDING, ending.to_json(&self.run_id));
        let records = vec![(RECORDING, self.account.to_pairs()), (ENDING, ending.to_pairs())];
        self.disk.close(records)
    }
}

/// Whether a topic has exactly one message for each step of the lockstep.
fn makes_a_step(role: Role) -> bool {
    matches!(
        role,
        Role::Detection(_)
            | Role::FurtherDetection(_)
            | Role::Command(_)
            | Role::Odometry(_)
            | Role::Object
            | Role::WorldDigest
            | Role::Clock
    )
}

/// How many steps each topic of the lockstep has made.
#[derive(Debug, Default)]
struct Steps {
    of_topic: BTreeMap<usize, u64>,
    /// Steps that every topic has made.
    made_by_all: u64,
    /// Topics that have made more steps than that. Hundreds of robots have no time to be asked, each
    /// with each message.
    n_ahead: usize,
}

impl Steps {
    fn new(topics: impl Iterator<Item = usize>) -> Self {
        Self { of_topic: topics.map(|topic| (topic, 0)).collect(), ..Self::default() }
    }

    /// Counts a step of a topic, and returns how many it has made; `None` if it makes none.
    fn count(&mut self, topic: usize) -> Option<u64> {
        let made = self.of_topic.get_mut(&topic)?;
        *made += 1;
        let made = *made;
        if made == self.made_by_all + 1 {
            self.n_ahead += 1;
        }
        if self.n_ahead == self.of_topic.len() {
            self.made_by_all += 1;
            let ahead = self.of_topic.values().filter(|made| **made > self.made_by_all);
            self.n_ahead = ahead.count();
        }
        Some(made)
    }
}

impl BagClock {
    /// When a message counts as received: in lockstep, the time of its step.
    fn log_time_ns(
        &mut self,
        index: usize,
        recorded_topic: &RecordedTopic,
        data: &[u8],
        run_id: &str,
    ) -> Result<u64, RecorderError> {
        let Self::Lockstep { period_ns, now_ns, steps, has_begun } = self else {
            return Ok(wall_time().to_nanos().unwrap_or(0));
        };
        // By how many steps it comes late is up to the network: the run begins with the first one.
        if recorded_topic.role == Role::Lease && !*has_begun {
            *has_begun = cdr::decode::<RunLease>(data)
                .is_ok_and(|lease| lease.state == LeaseState::Running && lease.run_id == run_id);
            return Ok((*now_ns).min(*period_ns));
        }
        let Some(count) = steps.count(index) else {
            return Ok(*now_ns);
        };
        let unstamped =
            || RecorderError::Unstamped { topic: recorded_topic.name.clone(), n_bytes: data.len() };
        let undecodable =
            |source| RecorderError::Undecodable { topic: recorded_topic.name.clone(), source };
        let stamped_ns = match recorded_topic.role {
            // Its type has no stamp; the simulator publishes one for each step, and reliably.
            Role::Detection(_) | Role::FurtherDetection(_) => count * *period_ns,
            Role::WorldDigest => {
                let message: WorldDigest = cdr::decode(data).map_err(undecodable)?;
                message.step * *period_ns
            }
            Role::Clock => {
                let message: Clock = cdr::decode(data).map_err(undecodable)?;
                message.clock.to_nanos().ok_or_else(unstamped)?
            }
            _ => header_stamp_ns(data).ok_or_else(unstamped)?,
        };
        if stamped_ns != count * *period_ns {
            return Err(RecorderError::OutOfStep {
                topic: recorded_topic.name.clone(),
                count,
                found: stamped_ns / *period_ns,
            });
        }
        *now_ns = (*now_ns).max(stamped_ns);
        Ok(stamped_ns)
    }
}

/// The stamp of a message that starts with a `std_msgs/Header`, without looking at the rest.
fn header_stamp_ns(data: &[u8]) -> Option<u64> {
    let body = data.strip_prefix(&ENCAPSULATION)?;
    let seconds = i32::from_le_bytes(*body.first_chunk::<4>()?);
    let nanoseconds = u32::from_le_bytes(*body.get(4..)?.first_chunk::<4>()?);
    Some(u64::try_from(seconds).ok()? * 1_000_000_000 + u64::from(nanoseconds))
}

/// The period as a whole number of nanoseconds, as the simulator stamps it.
fn period_ns(period_s: f64) -> u64 {
    u64::try_from(std::time::Duration::from_secs_f64(period_s).as_nanos())
        .expect("conditions allow at most 60 s")
}
