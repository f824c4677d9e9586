//! The thread that writes the bag, and the queue in front of it.
//!
//! A disk may take seconds for a single call, above all when a file is synchronised. Nobody who sends
//! leases may wait for that: messages go into a queue, and one that finds it full is dropped and
//! counted.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use rsrs_bags::{BagSummary, BagWriter, ChannelId, Sample};
use rsrs_fleet::timing::RECORDER_TIMEOUT;
use tokio::sync::mpsc::UnboundedSender;

use super::RecorderError;
use crate::recorded_topics::RecordedTopic;

/// How long a recorder that is dropped without being closed waits for a disk on which nothing is written.
const TIMEOUT: Duration = RECORDER_TIMEOUT;
/// How long a bag that is given up may take to notice.
const GIVE_UP: Duration = Duration::from_secs(2);
const POLL_PERIOD: Duration = Duration::from_millis(10);

/// Room of the queue.
#[derive(Clone, Copy, Debug)]
pub struct Room {
    pub messages: usize,
    pub bytes: usize,
}

/// Room for 12 s of 100 robots at 20 Hz.
pub const ROOM: Room = Room { messages: 100_000, bytes: 256 << 20 };

/// What the thread has done.
#[derive(Debug)]
pub enum Written {
    /// The bag is open.
    Opened,
    /// Every topic up to this step is in the bag.
    Step(u64),
    /// The bag cannot be opened, and there is nothing to close.
    NotOpened(RecorderError),
    /// Something cannot be written. The bag is to be closed all the same, if that can be done.
    Failed(RecorderError),
    /// The bag is closed.
    Closed(BagSummary),
    /// The bag cannot be closed; what was written so far can be recovered.
    NotClosed(RecorderError),
}

/// What the thread is to do.
#[derive(Debug)]
pub enum Job {
    /// Add a topic, by its index in the recorded topics.
    AddTopic(usize, Box<RecordedTopic>),
    /// Write a message.
    Write(Message),
    /// Write these records, and close the bag.
    Close(Vec<(&'static str, BTreeMap<String, String>)>),
}

/// A message on its way into the bag.
#[derive(Debug)]
pub struct Message {
    pub recorded_topic: usize,
    pub log_time_ns: u64,
    pub publish_time_ns: u64,
    pub sequence: u32,
    pub data: Vec<u8>,
    /// The step that all topics of the lockstep have made with this message.
    pub step: u64,
}

/// The front end of the thread.
pub struct Disk {
    jobs: Sender<Job>,
    room: Room,
    thread: Writer,
}

/// The thread, and what it still has to do.
struct Writer {
    waiting: Arc<Waiting>,
    /// `None` once it is waited for, or given up.
    thread: Option<JoinHandle<()>>,
}

/// What is in the queue, and behind it.
#[derive(Debug, Default)]
struct Waiting {
    messages: AtomicUsize,
    bytes: AtomicUsize,
    /// Bytes that the system has and the disk may not have yet; known while the bag is closed.
    unsynced: AtomicU64,
    /// What was done so far, in steps of any size.
    done: AtomicU64,
    is_given_up: AtomicBool,
}

impl Waiting {
    fn count_step(&self) {
        self.done.fetch_add(1, Ordering::Relaxed);
    }
}

/// A bag that is being closed.
pub struct Closing(Writer);

impl Closing {
    /// What was done so far, in steps of any size, and bytes that are still to be written: as long as the
    /// first grows, something is written.
    pub fn progress(&self) -> (u64, u64) {
        let waiting = &self.0.waiting;
        let queued = waiting.bytes.load(Ordering::Relaxed) as u64;
        (self.0.done(), queued + waiting.unsynced.load(Ordering::Relaxed))
    }

    /// Waits for the thread, whose last word has come, or gives the bag up: what is still in the queue
    /// then is not written. `false` if the thread hangs in a call to the system; it cannot be ended.
    pub fn end(mut self) -> bool {
        self.0.waiting.is_given_up.store(true, Ordering::Relaxed);
        self.0.wait_for(GIVE_UP)
    }
}

impl Writer {
    fn done(&self) -> u64 {
        self.waiting.done.load(Ordering::Relaxed)
    }

    /// Waits until the thread has ended, or has done nothing for so long.
    fn wait_for(&mut self, timeout: Duration) -> bool {
        let Some(thread) = self.thread.take() else { return true };
        let (mut done, mut since) = (self.done(), Instant::now());
        while !thread.is_finished() {
            if since.elapsed() >= timeout {
                return false;
            }
            std::thread::sleep(POLL_PERIOD);
            let now = self.done();
            if now != done {
                (done, since) = (now, Instant::now());
            }
        }
        // If it has panicked, that was reported as what it was.
        drop(thread.join());
        true
    }
}

impl Drop for Writer {
    /// What is in the queue still belongs into the bag when a run breaks off.
    fn drop(&mut self) {
        self.wait_for(TIMEOUT);
    }
}

impl Disk {
    /// Starts the thread, which opens the bag and reports. Before each job it calls `before`: tests
    /// are slow there.
    pub fn start(
        open: impl FnOnce() -> Result<BagWriter, RecorderError> + Send + 'static,
        mut before: impl FnMut(&Job) + Send + 'static,
        report: UnboundedSender<Written>,
        room: Room,
    ) -> Result<Self, RecorderError> {
        let (jobs, queue) = channel();
        let waiting = Arc::new(Waiting::default());
        let behind = Arc::clone(&waiting);
        let thread = std::thread::Builder::new().name("bag".to_owned()).spawn(move || {
            // Once the run is over there is no receiver.
            let report_written = |written| drop(report.send(written));
            match open() {
                Ok(writer) => {
                    report_written(Written::Opened);
                    let writing = Writing::new(writer, &report_written);
                    writing.run(&mut before, &Queue { queue, behind });
                }
                Err(error) => report_written(Written::NotOpened(error)),
            }
        });
        let thread = thread.map_err(|source| RecorderError::Thread { source })?;
        Ok(Self { jobs, room, thread: Writer { waiting, thread: Some(thread) } })
    }

    /// Adds a topic.
    pub fn add_topic(&self, index: usize, recorded_topic: &RecordedTopic) {
        self.send(Job::AddTopic(index, Box::new(recorded_topic.clone())));
    }

    /// Whether there is room for a message of so many bytes.
    pub fn has_room_for(&self, n_bytes: usize) -> bool {
        self.thread.waiting.messages.load(Ordering::Relaxed) < self.room.messages
            && self.thread.waiting.bytes.load(Ordering::Relaxed) + n_bytes <= self.room.bytes
    }

    /// Messages in the queue.
    pub fn n_waiting(&self) -> usize {
        self.thread.waiting.messages.load(Ordering::Relaxed)
    }

    /// Queues a message; there must be room for it.
    pub fn write(&self, message: Message) {
        self.thread.waiting.messages.fetch_add(1, Ordering::Relaxed);
        self.thread.waiting.bytes.fetch_add(message.data.len(), Ordering::Relaxed);
        self.send(Job::Write(message));
    }

    /// Has the bag closed after what is in the queue; the thread reports when that is done.
    pub fn close(self, records: Vec<(&'static str, BTreeMap<String, String>)>) -> Closing {
        self.send(Job::Close(records));
        Closing(self.thread)
    }

    fn send(&self, job: Job) {
        // A thread that has failed has reported it, and takes nothing more.
        drop(self.jobs.send(job));
    }
}

/// The thread's end of the queue.
struct Queue {
    queue: Receiver<Job>,
    behind: Arc<Waiting>,
}

/// What the thread does.
struct Writing<'a, Report> {
    writer: BagWriter,
    channels: BTreeMap<usize, ChannelId>,
    step: u64,
    has_failed: bool,
    report: &'a Report,
}

impl<'a, Report: Fn(Written)> Writing<'a, Report> {
    fn new(writer: BagWriter, report: &'a Report) -> Self {
        Self { writer, channels: BTreeMap::new(), step: 0, has_failed: false, report }
    }

    /// Does all jobs, until one closes the bag or there is no sender.
    fn run(mut self, before: &mut impl FnMut(&Job), jobs: &Queue) {
        for job in &jobs.queue {
            before(&job);
            if jobs.behind.is_given_up.load(Ordering::Relaxed) {
                return;
            }
            match job {
                Job::AddTopic(index, recorded_topic) => {
                    match add_topic(&mut self.writer, &recorded_topic) {
                        Ok(channel) => drop(self.channels.insert(index, channel)),
                        Err(error) => self.fail(error),
                    }
                }
                Job::Write(message) => {
                    let n_bytes = message.data.len();
                    self.write(message);
                    jobs.behind.messages.fetch_sub(1, Ordering::Relaxed);
                    jobs.behind.bytes.fetch_sub(n_bytes, Ordering::Relaxed);
                }
                Job::Close(records) => return self.close(records, &jobs.behind),
            }
            jobs.behind.count_step();
        }
    }

    /// Closes the bag, also if not all records could be written.
    fn close(mut self, records: Vec<(&'static str, BTreeMap<String, String>)>, waiting: &Waiting) {
        let mut records = records.into_iter();
        if let Err(error) = records.try_for_each(|(name, pairs)| self.writer.metadata(name, pairs))
        {
            self.fail(error.into());
        }
        let goes_on = |n_bytes| {
            waiting.unsynced.store(n_bytes, Ordering::Relaxed);
            waiting.count_step();
            !waiting.is_given_up.load(Ordering::Relaxed)
        };
        (self.report)(match self.writer.finish_watched(goes_on) {
            Ok(summary) => Written::Closed(summary),
            Err(error) => Written::NotClosed(error.into()),
        });
    }

    fn write(&mut self, message: Message) {
        let Message { recorded_topic, log_time_ns, publish_time_ns, sequence, data, step } =
            message;
        // A topic that could not be added has failed already.
        let Some(channel) = self.channels.get(&recorded_topic) else { return };
        let sample = Sample { log_time_ns, publish_time_ns, sequence, data: &data };
        if let Err(error) = self.writer.write(*channel, sample) {
            self.fail(error.into());
        } else if step > self.step {
            self.step = step;
            (self.report)(Written::Step(step));
        }
    }

    /// The first failure ends the run; those that follow from it add nothing.
    fn fail(&mut self, error: RecorderError) {
        if !std::mem::replace(&mut self.has_failed, true) {
            (self.report)(Written::Failed(error));
        }
    }
}

fn add_topic(
    writer: &mut BagWriter,
    recorded_topic: &RecordedTopic,
) -> Result<ChannelId, RecorderError> {
    Ok(match &recorded_topic.definition {
        Some(definition) => {
            writer.add_topic_with_schema(&recorded_topic.name, recorded_topic.qos, definition)?
        }
        None => {
            writer.add_topic(&recorded_topic.name, &recorded_topic.type_name, recorded_topic.qos)?
        }
    })
}
