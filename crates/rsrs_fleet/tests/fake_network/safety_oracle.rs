//! The oracle of these tests: which movements of one robot violate its safety.
//!
//! It keeps its own state on the true clock, by what was delivered and to whom, and asks the
//! machines only which epoch they obey and whether they let anything through.

use std::collections::{BTreeMap, BTreeSet};

use rsrs_core::robot::controller::Command;
use rsrs_fleet::e_stop::{LockCause, Locks, Source};
use rsrs_fleet::message::{Lease, LeaseState};

use crate::network::Sent;
use crate::scenario::Body;

/// What the wheels may be commanded at most: the command of the runs.
pub const FASTEST: Command = Command { speed_m_s: 0.15, turn_rate_rad_s: 0.75 };

const LEASE_TIMEOUT_MS: u64 = 500;
/// A robot whose lease ran out may be let go on within this time, and never after it.
const RESUME_TIMEOUT_MS: u64 = 1_000;
const CONTROLLER_TIMEOUT_MS: u64 = 500;
const E_STOP_SILENCE_TIMEOUT_MS: u64 = 500;
const COMMAND_TIMEOUT_MS: u64 = 325;
const STOPPED_WITHIN_MS: u64 = 200;
/// The timeout of the microcontroller that turns the wheels.
pub const WHEELS_TIMEOUT_MS: u64 = 250;
/// A process looks at its gate at least so often, in milliseconds, while its machine lets it.
pub const GLANCE_MS: u64 = 20;
/// What clocks that go wrong by 2,000 ppm make of a second, in milliseconds.
const DRIFT_MS: u64 = 2;

/// What decides whether one robot may move.
#[derive(Clone, Debug, Default)]
pub struct SafetyOracle {
    /// How often its process was started again.
    incarnation: u32,
    /// Whether a lapsed lease may recover, as in lockstep, where it freezes the world meanwhile.
    lapse_recovers: bool,
    /// By epoch: the latest time up to which the runner's having received it allows movement.
    fresh_until_ms: BTreeMap<u64, u64>,
    /// By epoch.
    leases: BTreeMap<u64, LeaseSeen>,
    binding: Binding,
    /// The digest that its controller named last, and when.
    controller: Option<(u64, u64)>,
    /// When the newest status of its controller was published.
    controller_sent_ms: u64,
    /// When the last command came.
    commanded_ms: Option<u64>,
    /// Who has engaged the e-stop, and when it received that first.
    engaged_ms: BTreeMap<Source, u64>,
    /// When each source last published on the e-stop topic.
    last_e_stop_ms: BTreeMap<Source, u64>,
    /// When it received, first, that it has to stand in the epoch that it obeys, and why.
    must_stand_since: Option<(u64, &'static str)>,
    /// It must not move in this epoch any more, nor in an older one, for this reason.
    barred: Option<(u64, &'static str)>,
    /// Whether the e-stop ever locked it, by message or by silence, in any incarnation.
    was_locked: bool,
    /// The highest epoch it ever moved in.
    moved_in: u64,
    /// When it last was allowed to move, and did.
    allowed_ms: Option<u64>,
    /// The epoch in which its lease had run out and it was let go on.
    excused: Option<u64>,
    /// Epochs in which it then moved on.
    resumed: BTreeSet<u64>,
}

/// What the leases of one epoch contained.
#[derive(Clone, Copy, Debug)]
struct LeaseSeen {
    parameter_digest: u64,
    /// Whether one was `Running`.
    has_run: bool,
}

/// The epoch that a robot obeys, and since when.
#[derive(Clone, Copy, Debug, Default)]
struct Binding {
    epoch: u64,
    since_ms: u64,
}

impl SafetyOracle {
    pub fn new(body: Body) -> Self {
        Self { lapse_recovers: body == Body::Lockstep, ..Self::default() }
    }

    pub fn incarnation(&self) -> u32 {
        self.incarnation
    }

    /// The process of its gate starts: what was before counts no more, but for what it obeyed.
    pub fn starts(&mut self) {
        *self = Self {
            incarnation: self.incarnation + 1,
            lapse_recovers: self.lapse_recovers,
            was_locked: self.was_locked,
            moved_in: self.moved_in,
            resumed: std::mem::take(&mut self.resumed),
            ..Self::default()
        };
    }

    /// It was started with what its gate of before had received of the e-stop.
    pub fn keeps_e_stop_of(&mut self, before: &Self) {
        self.last_e_stop_ms = before.last_e_stop_ms.clone();
        self.engaged_ms = before.engaged_ms.clone();
    }

    /// A process of any kind dies: what has locked by silence until then is not forgotten.
    pub fn process_died(&mut self, now_ms: u64) {
        self.was_locked = self.was_locked(now_ms);
    }

    /// A lease arrives; `echo` is what its runner had received from this robot last.
    pub fn lease(&mut self, lease: &Lease, echo: Option<Sent>, now_ms: u64) {
        let first = LeaseSeen { parameter_digest: lease.parameter_digest, has_run: false };
        let seen = self.leases.entry(lease.epoch).or_insert(first);
        seen.has_run |= lease.state == LeaseState::Running;
        if lease.state == LeaseState::Stopped && lease.epoch == self.binding.epoch {
            self.must_stand(now_ms, "its runner stopped it");
        }
        if let Some(sent) = echo.filter(|sent| sent.incarnation == self.incarnation) {
            let until_ms = self.fresh_until_ms.entry(lease.epoch).or_default();
            let has_moved = lease.epoch > 0 && self.moved_in == lease.epoch && *until_ms > 0;
            let has_lapsed = has_moved && now_ms > *until_ms + GLANCE_MS + DRIFT_MS;
            if has_lapsed && !self.lapse_recovers {
                if now_ms > *until_ms + RESUME_TIMEOUT_MS + GLANCE_MS + DRIFT_MS {
                    self.barred = Some((lease.epoch, "its lease ran out for too long"));
                }
                // Its runner must know that it stands: what it echoes is a status that said so.
                if !sent.stands || self.allowed_ms.is_some_and(|at_ms| sent.at_ms < at_ms) {
                    return;
                }
                if lease.state == LeaseState::Running {
                    self.excused = Some(lease.epoch);
                }
            }
            *until_ms = (*until_ms).max(sent.at_ms + LEASE_TIMEOUT_MS + DRIFT_MS);
        }
    }

    /// Whether it stood in this epoch because its lease had run out, and moved on.
    pub fn resumed(&self, epoch: u64) -> bool {
        self.resumed.contains(&epoch)
    }

    /// Its controller reports its parameters; an older report that comes now is no news.
    pub fn controller(&mut self, digest: u64, sent_ms: u64, now_ms: u64) {
        if sent_ms < self.controller_sent_ms {
            return;
        }
        self.controller_sent_ms = sent_ms;
        self.controller = Some((digest, now_ms));
        let epoch = self.binding.epoch;
        let is_final = !self.lapse_recovers && self.moved_in == epoch;
        if is_final && self.leases.get(&epoch).is_some_and(|lease| lease.parameter_digest != digest)
        {
            self.must_stand(now_ms, "its parameters are not the confirmed ones");
        }
    }

    pub fn command(&mut self, now_ms: u64) {
        self.commanded_ms = Some(now_ms);
    }

    pub fn refused(&mut self) {
        self.commanded_ms = None;
    }

    /// A source publishes on the e-stop topic.
    pub fn e_stop(&mut self, (source, engaged): (Source, bool), now_ms: u64) {
        self.was_locked |= self.is_any_silent(now_ms + 2 * DRIFT_MS);
        self.last_e_stop_ms.insert(source, now_ms);
        if engaged {
            self.was_locked = true;
            self.engaged_ms.entry(source).or_insert(now_ms);
            self.must_stand(now_ms, "the e-stop was engaged");
        } else {
            self.engaged_ms.remove(&source);
        }
    }

    /// A release names these sources: their locks end, and no others.
    pub fn e_stop_is_released(&mut self, sources: &BTreeSet<Source>) {
        for source in sources {
            self.engaged_ms.remove(source);
            self.last_e_stop_ms.remove(source);
        }
    }

    /// It has these locks from others, or from before it forgot everything else.
    pub fn adopts(&mut self, locks: &Locks) {
        self.was_locked |= !locks.0.is_empty();
        for (source, cause) in &locks.0 {
            if *cause == LockCause::Engaged {
                self.engaged_ms.entry(*source).or_insert(0);
            }
        }
    }

    /// The run that it belonged to ended with its world.
    pub fn world_is_replaced(&mut self, now_ms: u64) {
        self.must_stand(now_ms, "its world was placed anew");
    }

    fn must_stand(&mut self, now_ms: u64, why: &'static str) {
        self.must_stand_since.get_or_insert((now_ms, why));
        if self.binding.epoch > 0 {
            self.barred = Some((self.binding.epoch, why));
        }
    }

    /// Which epoch it obeys now.
    pub fn obeys(&mut self, epoch: u64, now_ms: u64) -> Result<(), String> {
        if epoch < self.binding.epoch {
            return Err(format!("obeys epoch {epoch} after epoch {}", self.binding.epoch));
        }
        if epoch > self.binding.epoch {
            self.binding = Binding { epoch, since_ms: now_ms };
            self.must_stand_since = None;
        }
        Ok(())
    }

    /// Whether the e-stop ever locked it, before it restarted or after.
    pub fn was_locked(&self, now_ms: u64) -> bool {
        self.was_locked || self.is_any_silent(now_ms + 2 * DRIFT_MS)
    }

    fn is_any_silent(&self, now_ms: u64) -> bool {
        self.last_e_stop_ms.values().any(|at_ms| is_silent(*at_ms, now_ms))
    }

    /// The epoch in which it moved last, and when it was last allowed to.
    pub fn moved(&self) -> (u64, Option<u64>) {
        (self.moved_in, self.allowed_ms)
    }

    /// Called when its gate lets a command through; the error is why it must not.
    pub fn moves(&mut self, now_ms: u64) -> Result<(), String> {
        let Binding { epoch, since_ms } = self.binding;
        // A simulator in lockstep goes by the gates as it saw them last.
        let since_look_ms = if self.lapse_recovers { GLANCE_MS } else { 0 };
        let until_ms = self.fresh_until_ms.get(&epoch).copied().unwrap_or(0) + since_look_ms;
        if now_ms > until_ms {
            return Err(format!("moves at {now_ms} ms, its lease ran out at {until_ms} ms"));
        }
        let lease = self.leases.get(&epoch);
        let is_confirmed = |lease: &LeaseSeen| {
            let last_ms = CONTROLLER_TIMEOUT_MS + DRIFT_MS + since_look_ms;
            let recently = |at_ms: u64| now_ms <= at_ms + last_ms;
            let matches = |its: u64| its == lease.parameter_digest;
            lease.has_run && self.controller.is_some_and(|(its, at)| matches(its) && recently(at))
        };
        if !lease.is_some_and(is_confirmed) {
            return Err(format!(
                "moves at {now_ms} ms under {lease:?} with controller {:?}",
                self.controller
            ));
        }
        if let Some((source, received_ms)) = self.engaged_ms.first_key_value() {
            return Err(format!(
                "moves at {now_ms} ms, received e-stop {source} at {received_ms} ms"
            ));
        }
        let looked_ms = now_ms.saturating_sub(since_look_ms);
        let gone = |(_, last_ms): &(&Source, &u64)| {
            **last_ms >= since_ms && is_silent(**last_ms, looked_ms)
        };
        if let Some((source, last_ms)) = self.last_e_stop_ms.iter().find(gone) {
            return Err(format!("moves at {now_ms} ms, e-stop {source} silent since {last_ms} ms"));
        }
        if let Some((barred, why)) = self.barred
            && epoch <= barred
        {
            return Err(format!("moves in epoch {epoch} at {now_ms} ms again, although {why}"));
        }
        if epoch < self.moved_in {
            return Err(format!("moves in epoch {epoch} after epoch {}", self.moved_in));
        }
        if self.excused.take() == Some(epoch) {
            self.resumed.insert(epoch);
        }
        (self.moved_in, self.allowed_ms) = (epoch, Some(now_ms));
        Ok(())
    }

    /// Called when the gate lets a command through that must not be too old.
    pub fn obeys_command(&self, now_ms: u64) -> Result<(), String> {
        match self.commanded_ms {
            Some(at_ms) if now_ms <= at_ms + COMMAND_TIMEOUT_MS + DRIFT_MS => Ok(()),
            last => Err(format!("moves at {now_ms} ms by the command that came at {last:?} ms")),
        }
    }

    /// Called while real wheels turn; the error is why they must not any more, or not so.
    ///
    /// They may until `last_ms` after their gate let a command through: [`GLANCE_MS`] while its
    /// process lives and has time, else [`WHEELS_TIMEOUT_MS`].
    pub fn wheels(&self, command_sent: Command, last_ms: u64, now_ms: u64) -> Result<(), String> {
        if command_sent.speed_m_s.abs() > FASTEST.speed_m_s
            || command_sent.turn_rate_rad_s.abs() > FASTEST.turn_rate_rad_s
        {
            return Err(format!(
                "wheels are commanded {command_sent:?}, at most {FASTEST:?} was requested"
            ));
        }
        let until_ms = self.allowed_ms.unwrap_or(0) + last_ms;
        if now_ms > until_ms {
            return Err(format!("wheels turn at {now_ms} ms, allowed until {until_ms} ms"));
        }
        if let Some((since_ms, why)) = self.must_stand_since
            && now_ms > since_ms + STOPPED_WITHIN_MS
        {
            return Err(format!("wheels turn at {now_ms} ms, {why} at {since_ms} ms"));
        }
        Ok(())
    }
}

fn is_silent(last_ms: u64, now_ms: u64) -> bool {
    now_ms > last_ms + E_STOP_SILENCE_TIMEOUT_MS + DRIFT_MS
}
