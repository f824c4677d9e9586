//! Receiving messages, each topic in a task of its own.

use std::collections::BTreeMap;
use std::pin::pin;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};

use futures::{Stream, StreamExt};
use ros2_client::{ROSTime, ReadError};
use rsrs_msgs::RosMessage;
use tokio::runtime::Handle;
use tokio::task::{AbortHandle, JoinSet};

use super::wire::Wire;
use super::{SessionEnded, lock};
use crate::clock::wall_time;

/// A message and where it comes from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Received<T> {
    /// The message.
    pub message: T,
    /// When it was published, in nanoseconds since 1970 on the publisher's clock, if it was sent.
    pub source_time_ns: Option<u64>,
    /// When it came, in nanoseconds since 1970 on our clock: as the middleware's thread took it from
    /// the network, however long it waited here after that.
    pub received_time_ns: u64,
    /// The publisher's count of its samples, from 1.
    pub sequence: u64,
    /// Which publisher.
    pub writer: [u8; 16],
}

/// A message of any type, as bytes with 4 bytes of encapsulation in front.
pub type ReceivedRaw = Received<Vec<u8>>;

/// What has come on a subscription so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Samples that were handed to `deliver`.
    pub taken: u64,
    /// Samples that do not decode as the topic's type.
    pub undecodable: u64,
    /// Samples missing between two of one publisher.
    pub lost: u64,
}

#[derive(Debug, Default)]
struct Counters {
    taken: AtomicU64,
    undecodable: AtomicU64,
    lost: AtomicU64,
}

/// Receives until it is dropped or the session is closed.
#[derive(Debug)]
pub struct Subscription {
    counters: Arc<Counters>,
    task: Task,
}

impl Subscription {
    /// What has come so far.
    pub fn counts(&self) -> Counts {
        Counts {
            taken: self.counters.taken.load(Ordering::Relaxed),
            undecodable: self.counters.undecodable.load(Ordering::Relaxed),
            lost: self.counters.lost.load(Ordering::Relaxed),
        }
    }

    /// Receives until the session is closed, without this handle.
    pub(super) fn until_close(self) {
        self.task.until_close();
    }
}

/// A task that ends when this is dropped.
#[derive(Debug)]
pub(crate) struct Task {
    handle: AbortHandle,
    ends_on_drop: bool,
}

impl Task {
    /// Lets it run until the session is closed, without this handle.
    pub(super) fn until_close(mut self) {
        self.ends_on_drop = false;
    }
}

impl Drop for Task {
    fn drop(&mut self) {
        if self.ends_on_drop {
            self.handle.abort();
        }
    }
}

/// All tasks of a session.
pub(super) struct Tasks {
    runtime: Handle,
    running: Mutex<JoinSet<()>>,
    /// The first subscription that has ended by itself.
    broken: Arc<Mutex<Option<SessionEnded>>>,
}

impl Tasks {
    pub(super) fn on(runtime: Handle) -> Self {
        Self { runtime, running: Mutex::default(), broken: Arc::default() }
    }

    pub(super) fn run(&self, future: impl Future<Output = ()> + Send + 'static) -> Task {
        let handle = lock(&self.running).spawn_on(future, &self.runtime);
        Task { handle, ends_on_drop: true }
    }

    /// Starts a task that hands every sample of a stream to `deliver`.
    pub(super) fn deliver<T: Send + 'static>(
        &self,
        topic: &str,
        samples: impl Stream<Item = Result<Received<T>, Failure>> + Send + 'static,
        deliver: impl FnMut(Received<T>) + Send + 'static,
    ) -> Subscription {
        let counters = Arc::new(Counters::default());
        let (topic, broken) = (topic.to_owned(), Arc::clone(&self.broken));
        let watched = Watched { topic, is_delivering: false, broken };
        let task = self.run(deliver_all(watched, samples, Arc::clone(&counters), deliver));
        Subscription { counters, task }
    }

    /// The first subscription that has ended by itself, if any has.
    pub(super) fn broken(&self) -> Option<SessionEnded> {
        lock(&self.broken).clone()
    }

    /// Ends all tasks and waits for them.
    pub(super) async fn stop(self) {
        let mut running =
            self.running.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner);
        running.abort_all();
        while let Some(ended) = running.join_next().await {
            if let Err(error) = ended
                && error.is_panic()
            {
                std::panic::resume_unwind(error.into_panic());
            }
        }
    }
}

/// Publishers of one topic whose counts are kept, at most. Of one that is forgotten the next sample is as
/// good as its first.
const MOST_WRITERS: usize = 10_000;

/// Why a sample did not become a message.
pub(super) enum Failure {
    /// It is not of the topic's type.
    Undecodable(String),
    /// The reader has failed and gives no more samples.
    Broken(String),
}

/// A subscription of which the session learns if it ends by itself, also by a panic.
struct Watched {
    topic: String,
    is_delivering: bool,
    broken: Arc<Mutex<Option<SessionEnded>>>,
}

impl Watched {
    fn broke(&self, reason: &str) {
        let ended =
            SessionEnded::Subscription { topic: self.topic.clone(), reason: reason.to_owned() };
        log::error!("{ended}");
        lock(&self.broken).get_or_insert(ended);
    }
}

impl Drop for Watched {
    fn drop(&mut self) {
        if self.is_delivering {
            self.broke("what takes its messages has panicked");
        }
    }
}

/// A sample that comes again is at most so many behind the newest. What is further behind is the first of
/// a publisher that counts anew: otherwise one forged number would mute it for good.
const MOST_BEHIND: u64 = 1 << 16;

async fn deliver_all<T>(
    mut watched: Watched,
    samples: impl Stream<Item = Result<Received<T>, Failure>>,
    counters: Arc<Counters>,
    mut deliver: impl FnMut(Received<T>),
) {
    let mut samples = pin!(samples);
    let mut last: BTreeMap<[u8; 16], u64> = BTreeMap::new();
    while let Some(sample) = samples.next().await {
        match sample {
            Ok(received) => {
                let before = last.get(&received.writer).copied();
                // Two readers of one topic share what came for either of them.
                let is_again = |before: &u64| {
                    before.checked_sub(received.sequence).is_some_and(|it| it < MOST_BEHIND)
                };
                if before.as_ref().is_some_and(is_again) {
                    continue;
                }
                if before.is_none() && last.len() >= MOST_WRITERS {
                    last.pop_first();
                }
                last.insert(received.writer, received.sequence);
                let after =
                    |before: u64| received.sequence.saturating_sub(before.saturating_add(1));
                let lost = before.map_or(0, after);
                counters.lost.fetch_add(lost, Ordering::Relaxed);
                counters.taken.fetch_add(1, Ordering::Relaxed);
                watched.is_delivering = true;
                deliver(received);
                watched.is_delivering = false;
            }
            Err(Failure::Undecodable(reason)) => {
                let count = counters.undecodable.fetch_add(1, Ordering::Relaxed) + 1;
                // The first, second, fourth, eighth…: a stream of them does not fill the disk.
                if count.is_power_of_two() {
                    let topic = &watched.topic;
                    log::warn!("`{topic}`: {count} samples of another type, last: {reason}");
                }
            }
            Err(Failure::Broken(reason)) => {
                watched.broke(&reason);
                return;
            }
        }
        // The middleware's streams do not yield to other tasks by themselves.
        tokio::task::coop::consume_budget().await;
    }
}

/// The samples of a typed subscription.
pub(super) fn typed<M: RosMessage>(
    reader: ros2_client::Subscription<Wire<M>>,
) -> impl Stream<Item = Result<Received<M>, Failure>> {
    futures::stream::unfold(reader, async |reader| {
        let sample = match reader.async_take().await {
            Ok((Wire(message), info)) => Ok(Received {
                message,
                source_time_ns: info.source_timestamp().and_then(nanoseconds),
                received_time_ns: info
                    .received_timestamp()
                    .and_then(nanoseconds)
                    .unwrap_or_else(wall_nanoseconds),
                sequence: info.sequence_number().unsigned_abs(),
                writer: info.publisher_gid().to_bytes16(),
            }),
            Err(ReadError::Deserialization { reason }) => Err(Failure::Undecodable(reason)),
            Err(error) => Err(Failure::Broken(error.to_string())),
        };
        Some((sample, reader))
    })
}

fn nanoseconds(time: ROSTime) -> Option<u64> {
    u64::try_from(time.to_nanos()).ok()
}

pub(super) fn wall_nanoseconds() -> u64 {
    wall_time().to_nanos().unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    fn sample(sequence: u64) -> Received<u64> {
        let writer = [1; 16];
        Received { message: sequence, source_time_ns: None, received_time_ns: 0, sequence, writer }
    }

    async fn broken(tasks: &Tasks) -> SessionEnded {
        loop {
            match tasks.broken() {
                Some(ended) => return ended,
                None => tokio::time::sleep(Duration::from_millis(1)).await,
            }
        }
    }

    #[tokio::test(flavor = "current_thread")]
    async fn a_subscription_that_ends_by_itself_is_known_with_the_reason() {
        let tasks = Tasks::on(Handle::current());
        let samples = [Ok(sample(1)), Err(Failure::Broken("poisoned".to_owned()))];

        let _subscription = tasks.deliver("/swarm/e_stop", futures::stream::iter(samples), |_| {});

        let ended = broken(&tasks).await;
        assert_eq!(ended.to_string(), "`/swarm/e_stop` is not received any more: poisoned");
    }

    #[tokio::test(flavor = "current_thread")]
    async fn a_subscription_whose_taker_panics_is_known_and_one_that_is_dropped_is_not() {
        let tasks = Tasks::on(Handle::current());
        let endless = || futures::stream::iter([Ok(sample(1))]).chain(futures::stream::pending());

        drop(tasks.deliver("/a", endless(), |_| {}));
        tokio::time::sleep(Duration::from_millis(20)).await;
        assert_eq!(tasks.broken(), None);
        let _subscription =
            tasks.deliver("/b", endless(), |_| panic!("a message of another world"));

        let SessionEnded::Subscription { topic, .. } = broken(&tasks).await else {
            panic!("a subscription has ended")
        };
        assert_eq!(topic, "/b");
    }

    #[tokio::test(flavor = "current_thread")]
    async fn a_forged_number_mutes_nobody_and_a_sample_that_comes_again_is_left_out() {
        let tasks = Tasks::on(Handle::current());
        let (sender, taken) = std::sync::mpsc::channel();
        let numbers = [5, 6, 6, 5, u64::MAX, 7, 8];

        let samples =
            futures::stream::iter(numbers.map(sample).map(Ok)).chain(futures::stream::pending());
        let subscription = tasks.deliver("/a", samples, move |received: Received<u64>| {
            sender.send(received.message).expect("the test listens");
        });

        while subscription.counts().taken < 5 {
            tokio::time::sleep(Duration::from_millis(1)).await;
        }
        assert_eq!(taken.try_iter().collect::<Vec<_>>(), [5, 6, u64::MAX, 7, 8]);
    }
}
