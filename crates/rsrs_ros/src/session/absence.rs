//! Whether this participant was out of reach for so long that it has to join anew.
//!
//! Two participants that receive nothing of each other for longer than their lease (50 s here, 20 s in
//! Fast DDS) forget each other. When they are back in reach, each discovers the other again, but their
//! endpoints are not matched again: nothing is received any more, and no call fails. A participant that
//! joins anew is matched at once. So of a network that fell apart the smaller part joins anew: a
//! participant that lost at least half of the others at one time belongs to it.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Mutex;
use std::time::{Duration, Instant};

use rustdds::{
    DomainParticipant, DomainParticipantStatusEvent, DomainParticipantStatusListener, LostReason,
    StatusEvented,
};

use super::lock;
use super::prefix::{Prefix, prefix};

/// Leases of participants that went out of reach together expire within this time of each other.
const TOGETHER: Duration = Duration::from_secs(60);

/// This participant was out of reach of others for longer than their leases, and they are back.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "{lost} of {known} other participants were out of reach for longer than their leases, and the \
     middleware does not match their topics again: start this program again"
)]
pub struct OutOfReach {
    /// Participants that were lost together.
    pub lost: usize,
    /// All that were there before.
    pub known: usize,
}

/// Receives who joins, leaves and is lost.
pub(super) struct Absences {
    listener: DomainParticipantStatusListener,
    record: Mutex<Record>,
}

impl Absences {
    pub(super) fn of(participant: &DomainParticipant) -> Self {
        Self { listener: participant.status_listener(), record: Mutex::default() }
    }

    /// Takes in what has happened since the last call.
    pub(super) fn update(&self) -> Option<OutOfReach> {
        let mut record = lock(&self.record);
        while let Some(event) = self.listener.try_recv_status() {
            match event {
                DomainParticipantStatusEvent::ParticipantDiscovered { dpd } => {
                    let found = record.discover(prefix(dpd.guid.to_bytes()));
                    if found.is_some() {
                        return found;
                    }
                }
                DomainParticipantStatusEvent::ParticipantLost { id, reason } => {
                    let id = id.as_ref().try_into().expect("a prefix has 12 bytes");
                    record.lose(id, &reason, Instant::now());
                }
                _ => {}
            }
        }
        None
    }
}

/// Who is there, and who was lost when.
#[derive(Debug, Default)]
struct Record {
    present: BTreeSet<Prefix>,
    lost: BTreeMap<Prefix, Instant>,
}

impl Record {
    /// A participant is there, for the first time or again.
    fn discover(&mut self, id: Prefix) -> Option<OutOfReach> {
        let out_of_reach = self.lost.get(&id).and_then(|&at| self.lost_with(at));
        self.lost.remove(&id);
        self.present.insert(id);
        out_of_reach
    }

    /// A participant has left, or has not been received for longer than its lease.
    fn lose(&mut self, id: Prefix, reason: &LostReason, now: Instant) {
        self.present.remove(&id);
        match reason {
            LostReason::Timeout { .. } => self.lost.insert(id, now),
            LostReason::Disposed => self.lost.remove(&id),
        };
    }

    /// Whether those that were lost at one time were at least half of all.
    fn lost_with(&self, at: Instant) -> Option<OutOfReach> {
        let is_together = |other: Instant| {
            other.saturating_duration_since(at).max(at.saturating_duration_since(other)) <= TOGETHER
        };
        let lost = self.lost.values().filter(|other| is_together(**other)).count();
        let known = lost + self.present.len();
        (2 * lost >= known).then_some(OutOfReach { lost, known })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TIMEOUT: LostReason = LostReason::Timeout {
        lease: rustdds::Duration::from_secs(50),
        elapsed: rustdds::Duration::from_secs(51),
    };

    fn network(n: u8) -> Record {
        let mut record = Record::default();
        for id in 0..n {
            assert_eq!(record.discover([id; 12]), None);
        }
        record
    }

    #[test]
    fn who_lost_at_least_half_is_out_of_reach_when_the_first_is_back() {
        let now = Instant::now();
        for (n_lost, expected) in [
            (4, None),
            (5, Some(OutOfReach { lost: 5, known: 10 })),
            (10, Some(OutOfReach { lost: 10, known: 10 })),
        ] {
            let mut record = network(10);
            for id in 0..n_lost {
                record.lose([id; 12], &TIMEOUT, now + Duration::from_secs(u64::from(id)));
            }

            assert_eq!(record.discover([0; 12]), expected, "{n_lost} lost");
        }
    }

    #[test]
    fn who_left_or_was_lost_at_another_time_does_not_count() {
        let now = Instant::now();
        let mut record = network(4);
        record.lose([0; 12], &LostReason::Disposed, now);
        record.lose([1; 12], &TIMEOUT, now);
        record.lose([2; 12], &TIMEOUT, now + TOGETHER + TOGETHER);
        for id in 4..6 {
            record.discover([id; 12]);
        }

        assert_eq!(record.discover([0; 12]), None, "it said that it left");
        assert_eq!(record.discover([2; 12]), None, "one of five");
    }
}
