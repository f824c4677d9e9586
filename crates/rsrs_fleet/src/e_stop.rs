//! The e-stop, by who engaged it: one publisher cannot undo what another one did.
//!
//! A lock is taken by a source that publishes `true`, or by the silence of one that was received
//! while a run could move the robot. It ends when the same source publishes `false`, or by a
//! release that names it: `rsrs stop --release`. Who takes a lock may leave; the lock stays.
//!
//! A robot whose node was started again has forgotten its locks. It asks the other robots, which keep
//! theirs on a transient-local topic, and takes part in no run until it has received for a while; see
//! [`robot`](crate::robot).

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::time::Duration;

pub use rsrs_msgs::rsrs::LockCause;

use crate::timing::E_STOP_TIMEOUT;

/// Who publishes on the e-stop topic: the GUID of its publisher.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Source(pub [u8; 16]);

impl Source {
    /// All sources beyond those that are listed one by one; no publisher has this GUID.
    const OTHERS: Self = Self([0xff; 16]);
}

impl fmt::Display for Source {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|byte| write!(formatter, "{byte:02x}"))
    }
}

/// Sources that lock, and why.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Locks(pub BTreeMap<Source, LockCause>);

/// What is received on one of the topics of the e-stop.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Message {
    /// A source reports that it is engaged, or that it is not.
    State {
        /// Who.
        source: Source,
        /// What.
        engaged: bool,
    },
    /// Somebody ends the locks of these sources.
    Release(BTreeSet<Source>),
    /// What is locked on the robots of a process.
    Locks {
        /// The publisher of that process.
        reporter: Source,
        /// The locks.
        locks: Locks,
    },
}

/// Sources that are listed one by one; a lab has a few.
pub(crate) const MOST_SOURCES: usize = 64;

/// The e-stop as one robot, or a runner, has received it.
#[derive(Clone, Debug, Default)]
pub(crate) struct EStop {
    sources: BTreeMap<Source, Received>,
}

#[derive(Clone, Copy, Debug)]
struct Received {
    lock: Option<LockCause>,
    at: Duration,
}

impl Received {
    fn is_silent(self, now: Duration) -> bool {
        now.saturating_sub(self.at) > E_STOP_TIMEOUT
    }
}

impl EStop {
    /// Takes a message of a source.
    pub fn receive(&mut self, (source, engaged): (Source, bool), now: Duration) {
        let lock = engaged.then_some(LockCause::Engaged);
        self.insert(source, Received { lock, at: now });
    }

    /// Takes over the locks of another robot.
    pub fn adopt(&mut self, locks: &Locks, now: Duration) {
        for (source, cause) in &locks.0 {
            self.insert(*source, Received { lock: Some(*cause), at: now });
        }
    }

    fn insert(&mut self, source: Source, received: Received) {
        let is_known = self.sources.contains_key(&source);
        if is_known || self.sources.len() < MOST_SOURCES || self.evict() {
            self.sources.insert(source, received);
        } else if received.lock.is_some() {
            self.sources.insert(Source::OTHERS, received);
        }
    }

    /// Makes room by forgetting the source that locks nothing and was received longest ago.
    fn evict(&mut self) -> bool {
        let free = self.sources.iter().filter(|(_, received)| received.lock.is_none());
        let oldest = free.min_by_key(|(_, received)| received.at).map(|(source, _)| *source);
        oldest.is_some_and(|source| self.sources.remove(&source).is_some())
    }

    /// Takes these sources' locks away.
    pub fn release(&mut self, locks: &BTreeSet<Source>) {
        self.sources.retain(|source, received| received.lock.is_none() || !locks.contains(source));
    }

    /// Locks for every source that has fallen silent; to be called while a run could move the robot.
    pub fn lapse(&mut self, now: Duration) {
        for received in self.sources.values_mut() {
            if received.lock.is_none() && received.is_silent(now) {
                received.lock = Some(LockCause::Silent);
            }
        }
    }

    /// Whether [`EStop::lapse`] would lock now.
    pub fn would_lapse(&self, now: Duration) -> bool {
        let mut free = self.sources.values().filter(|received| received.lock.is_none());
        free.any(|received| received.is_silent(now))
    }

    /// A run begins: who has left without a lock need not come back; who publishes now must stay.
    pub fn forget_silent(&mut self, now: Duration) {
        self.sources.retain(|_, received| received.lock.is_some() || !received.is_silent(now));
    }

    /// Whether any source was ever received.
    pub fn is_used(&self) -> bool {
        !self.sources.is_empty()
    }

    pub fn is_engaged(&self) -> bool {
        self.sources.values().any(|received| received.lock.is_some())
    }

    /// Who locks.
    pub fn locks(&self) -> Locks {
        let locks = self.sources.iter();
        Locks(locks.filter_map(|(source, received)| Some((*source, received.lock?))).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wire;
    fn ms(milliseconds: u64) -> Duration {
        Duration::from_millis(milliseconds)
    }

    #[test]
    fn any_number_of_sources_takes_bounded_room_and_a_lock_is_never_forgotten() {
        let mut e_stop = EStop::default();
        let source = |number: u16| {
            let [high, low] = number.to_be_bytes();
            let mut guid = [0; 16];
            (guid[0], guid[1]) = (high, low);
            Source(guid)
        };
        e_stop.receive((source(0), true), ms(0));
        for number in 1..1_000 {
            e_stop.receive((source(number), false), ms(u64::from(number)));
        }
        assert_eq!(e_stop.locks(), Locks([(source(0), LockCause::Engaged)].into()));
        for number in 1..1_000 {
            e_stop.receive((source(number), true), ms(u64::from(number)));
        }

        let mut locks = e_stop.locks();
        assert_eq!(locks.0.len(), MOST_SOURCES + 1);
        assert_eq!(wire::locks(wire::locks_message(&locks)), Ok(locks.clone()));
        locks.0.remove(&Source::OTHERS);
        e_stop.release(&locks.0.into_keys().collect());
        assert!(e_stop.is_engaged(), "those that are not listed lock as well");
    }
}
