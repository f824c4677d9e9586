//! Whether the others of a secured network have authenticated this participant.
//!
//! When many participants come at once, messages of their handshakes are lost and not sent again: two
//! of them never receive anything of each other, and no call fails. A participant that joins anew
//! begins new handshakes. A runner does so with each run; a robot that nobody at all has
//! authenticated in time ends, so that its service starts it again. One that some have authenticated
//! stays, because strangers could otherwise send it round and round: their handshakes never end.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Instant;

use rustdds::DomainParticipantStatusEvent;

use super::endpoint::Prefix;
use super::{HANDSHAKE_TIMEOUT, SessionEnded};

/// How far a handshake with another participant has come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    not(feature = "security"),
    expect(dead_code, reason = "without security there are no handshakes")
)]
pub(super) enum Handshake {
    /// Messages go to and fro.
    Begun,
    /// Each has authenticated the other.
    Completed,
    /// The other one does not belong here.
    Refused,
}

/// What an event of the middleware reports of a handshake.
#[cfg(feature = "security")]
pub(super) fn of_event(event: &DomainParticipantStatusEvent) -> Option<(Prefix, Handshake)> {
    let DomainParticipantStatusEvent::Authentication { participant, status } = event else {
        return None;
    };
    let id = participant.as_ref().try_into().expect("a prefix has 12 bytes");
    // The type of the status has no public name.
    let handshake = match format!("{status:?}").as_str() {
        "Authenticated" => Handshake::Completed,
        "Authenticating" => Handshake::Begun,
        _ => Handshake::Refused,
    };
    Some((id, handshake))
}

/// What an event of the middleware reports of a handshake: nothing, without security.
#[cfg(not(feature = "security"))]
pub(super) fn of_event(_event: &DomainParticipantStatusEvent) -> Option<(Prefix, Handshake)> {
    None
}

/// Handshakes with others.
#[derive(Debug, Default)]
pub(super) struct Handshakes {
    begun: BTreeMap<Prefix, Instant>,
    completed: BTreeSet<Prefix>,
}

impl Handshakes {
    /// A handshake has begun; one that has is not begun again.
    pub(super) fn begin(&mut self, id: Prefix, now: Instant) {
        if !self.completed.contains(&id) {
            self.begun.entry(id).or_insert(now);
        }
    }

    pub(super) fn complete(&mut self, id: Prefix) {
        self.begun.remove(&id);
        self.completed.insert(id);
    }

    /// A participant has left, or is refused: it is not waited for.
    pub(super) fn forget(&mut self, id: &Prefix) {
        self.begun.remove(id);
        self.completed.remove(id);
    }

    /// Whether nobody authenticated this participant in time.
    pub(super) fn timed_out(&self, now: Instant) -> Option<SessionEnded> {
        let late = |begun: &&Instant| now.saturating_duration_since(**begun) >= HANDSHAKE_TIMEOUT;
        if !self.completed.is_empty() || !self.begun.values().any(|begun| late(&begun)) {
            return None;
        }
        let digits = |id: &Prefix| id.map(|byte| format!("{byte:02x}")).concat();
        let ids: Vec<String> = self.begun.keys().map(digits).collect();
        Some(SessionEnded::NotAuthenticated { n_others: ids.len(), ids: ids.join(", ") })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn who_has_authenticated_a_peer_or_waits_for_nobody_does_not_end() {
        let settled: [fn(&mut Handshakes); 2] =
            [|handshakes| handshakes.complete([1; 12]), |handshakes| handshakes.forget(&[1; 12])];
        for (n_strangers, settle) in [1, 0].into_iter().zip(settled) {
            let (mut handshakes, start) = (Handshakes::default(), Instant::now());
            handshakes.begin([1; 12], start);
            (0..n_strangers).for_each(|_| handshakes.begin([2; 12], start));

            settle(&mut handshakes);

            assert_eq!(handshakes.timed_out(start + HANDSHAKE_TIMEOUT * 2), None, "{n_strangers}");
        }
    }

    #[test]
    fn who_authenticates_nobody_in_time_ends_and_names_them() {
        let (mut handshakes, start) = (Handshakes::default(), Instant::now());
        handshakes.begin([1; 12], start);
        // Announced again, as every few seconds.
        handshakes.begin([1; 12], start + HANDSHAKE_TIMEOUT / 2);

        assert_eq!(handshakes.timed_out(start + HANDSHAKE_TIMEOUT / 2), None);
        let ids = "010101010101010101010101".to_owned();
        assert_eq!(
            handshakes.timed_out(start + HANDSHAKE_TIMEOUT),
            Some(SessionEnded::NotAuthenticated { n_others: 1, ids })
        );
    }
}
