//! Whether this participant was out of reach for so long that it has to join anew.
//!
//! Two participants that receive nothing of each other for longer than their lease (50 s here, 20 s in
//! Fast DDS) forget each other. When they are back in reach, each discovers the other again, but their
//! endpoints are not matched again: nothing is received any more, and no call fails. A participant that
//! joins anew is matched at once. So of a network that fell apart and is whole again the smaller part
//! joins anew: a participant to which at least as many others return as were there all the time.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Mutex;
use std::time::{Duration, Instant};

use rustdds::{
    DomainParticipant, DomainParticipantStatusEvent, DomainParticipantStatusListener, LostReason,
    RTPSEntity, StatusEvented,
};

use super::authentication::{self, Handshake, Handshakes};
use super::endpoint::{Prefix, prefix};
use super::{SessionEnded, lock};

/// After the first return, the others announce themselves within this time: every 10 s at the latest.
const ALL_ARE_BACK: Duration = Duration::from_secs(15);

/// Receives who joins, leaves and is lost, and who has authenticated this participant.
pub(super) struct Absences {
    listener: DomainParticipantStatusListener,
    own: Prefix,
    record: Mutex<(Record, Handshakes)>,
}

impl Absences {
    pub(super) fn new(participant: &DomainParticipant) -> Self {
        Self {
            listener: participant.status_listener(),
            own: prefix(participant.guid().to_bytes()),
            record: Mutex::default(),
        }
    }

    /// Whether this participant has dropped itself.
    pub(super) fn has_lost_itself(&self) -> bool {
        lock(&self.record).0.has_lost_itself
    }

    /// Takes in what has happened since the last call.
    pub(super) fn update(&self) -> Option<SessionEnded> {
        let mut record = lock(&self.record);
        let (record, handshakes) = &mut *record;
        let now = Instant::now();
        while let Some(event) = self.listener.try_recv_status() {
            match authentication::of_event(&event) {
                Some((id, Handshake::Begun)) => handshakes.begin(id, now),
                Some((id, Handshake::Completed)) => {
                    handshakes.complete(id);
                    record.discover(id, now);
                }
                Some((id, Handshake::Refused)) => handshakes.forget(&id),
                None => {}
            }
            match event {
                DomainParticipantStatusEvent::ParticipantDiscovered { dpd } => {
                    let id = prefix(dpd.guid.to_bytes());
                    if id != self.own {
                        record.discover(id, now);
                    }
                }
                DomainParticipantStatusEvent::ParticipantLost { id, reason } => {
                    let id = id.as_ref().try_into().expect("a prefix has 12 bytes");
                    handshakes.forget(&id);
                    if id == self.own {
                        record.has_lost_itself = true;
                    } else {
                        record.lose(id, &reason);
                    }
                }
                _ => {}
            }
        }
        record.out_of_reach(now).or_else(|| handshakes.timed_out(now))
    }
}

/// Which participants there are.
#[derive(Debug, Default)]
struct Record {
    /// There since they were discovered.
    present: BTreeSet<Prefix>,
    /// Not received for longer than their lease; processes that were killed stay here.
    lost: BTreeSet<Prefix>,
    /// Lost before, and when they were discovered again.
    returned: BTreeMap<Prefix, Instant>,
    /// This participant itself was lost.
    has_lost_itself: bool,
}

impl Record {
    /// A participant is there, for the first time or again.
    fn discover(&mut self, id: Prefix, now: Instant) {
        if self.lost.remove(&id) {
            self.returned.insert(id, now);
        } else if !self.returned.contains_key(&id) {
            self.present.insert(id);
        }
    }

    /// A participant has left, or has not been received for longer than its lease.
    fn lose(&mut self, id: Prefix, reason: &LostReason) {
        self.present.remove(&id);
        self.returned.remove(&id);
        match reason {
            LostReason::Timeout { .. } => self.lost.insert(id),
            LostReason::Disposed => self.lost.remove(&id),
        };
    }

    /// Whether this participant belongs to the part of the network that has to join anew.
    fn out_of_reach(&mut self, now: Instant) -> Option<SessionEnded> {
        let first = *self.returned.values().min()?;
        let is_settled = now.saturating_duration_since(first) >= ALL_ARE_BACK;
        if !self.present.is_empty() && !is_settled {
            return None;
        }
        let (returned, n_present) = (self.returned.len(), self.present.len());
        if returned >= n_present {
            return Some(SessionEnded::OutOfReach { returned, known: returned + n_present });
        }
        // They belong to the smaller part, and join anew.
        self.present.extend(std::mem::take(&mut self.returned).into_keys());
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TIMEOUT: LostReason = LostReason::Timeout {
        lease: rustdds::Duration::from_secs(50),
        elapsed: rustdds::Duration::from_secs(51),
    };

    /// A network of which some participants are lost, and others were killed before.
    fn network(n: u8, lost: std::ops::Range<u8>) -> Record {
        let mut record = Record::default();
        for id in 0..n {
            record.discover([id; 12], Instant::now());
        }
        for id in lost {
            record.lose([id; 12], &TIMEOUT);
        }
        record
    }

    #[test]
    fn the_part_to_which_at_least_as_many_return_as_stayed_is_out_of_reach() {
        let back = Instant::now();
        let settled = back + ALL_ARE_BACK;
        for (n_lost, expected) in
            [(4, None), (5, Some(SessionEnded::OutOfReach { returned: 5, known: 10 }))]
        {
            let mut record = network(10, 0..n_lost);
            for id in 0..n_lost {
                record.discover([id; 12], back);
            }

            assert_eq!(record.out_of_reach(back), None, "more may return");
            assert_eq!(record.out_of_reach(settled), expected, "{n_lost} lost");
            assert_eq!(record.out_of_reach(settled + ALL_ARE_BACK), expected, "{n_lost} lost");
        }
    }

    #[test]
    fn who_was_alone_is_out_of_reach_when_the_first_is_back() {
        let mut record = network(10, 0..10);
        let back = Instant::now();
        assert_eq!(record.out_of_reach(back), None);

        record.discover([3; 12], back);

        assert_eq!(
            record.out_of_reach(back),
            Some(SessionEnded::OutOfReach { returned: 1, known: 1 })
        );
    }

    #[test]
    fn processes_that_were_killed_or_have_left_do_not_count() {
        let mut record = network(10, 0..8);
        record.lose([8; 12], &LostReason::Disposed);
        let back = Instant::now();
        record.discover([8; 12], back);
        record.discover([0; 12], back);

        assert_eq!(record.out_of_reach(back + ALL_ARE_BACK), None, "one returned, two stayed");
    }
}
