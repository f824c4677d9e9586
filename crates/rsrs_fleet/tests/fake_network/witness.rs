//! What an all-knowing witness sees of each robot, and which movements it calls a violation.
//!
//! It keeps its own books on the true clock and asks the machines only whether the wheels turn.

use std::collections::BTreeMap;

use rsrs_fleet::message::{Lease, LeaseState, Status};

/// Books on one robot.
#[derive(Clone, Debug, Default)]
pub struct Witness {
    /// When each status was sent.
    sent_ms: BTreeMap<u64, u64>,
    /// By epoch: the latest time up to which an echo of an own status allows movement.
    fresh_until_ms: BTreeMap<u64, u64>,
    /// By epoch: the digest that leases named, and whether one said `Running`.
    leases: BTreeMap<u64, (u64, bool)>,
    /// The digest that its controller named last.
    controller_digest: Option<u64>,
    /// When it first heard the e-stop that holds it.
    e_stop_ms: Option<u64>,
    /// Whether it ever heard the e-stop, in whichever life.
    has_heard_e_stop: bool,
    /// The highest epoch it ever moved in.
    moved_in: u64,
}

const LEASE_MS: u64 = 500;

impl Witness {
    pub fn sent(&mut self, status: &Status, now_ms: u64) {
        self.sent_ms.insert(status.counter, now_ms);
    }

    pub fn lease(&mut self, lease: &Lease, name: &str) {
        let echo = lease.echo(name).expect("every lease of the tests names every robot");
        let entry = self.leases.entry(lease.epoch).or_insert((lease.parameter_digest, false));
        entry.1 |= lease.state == LeaseState::Running;
        if let Some(sent_ms) = self.sent_ms.get(&echo) {
            let until_ms = self.fresh_until_ms.entry(lease.epoch).or_default();
            *until_ms = (*until_ms).max(sent_ms + LEASE_MS);
        }
    }

    pub fn controller(&mut self, digest: u64) {
        self.controller_digest = Some(digest);
    }

    pub fn e_stop_engaged(&mut self, now_ms: u64) {
        self.has_heard_e_stop = true;
        self.e_stop_ms.get_or_insert(now_ms);
    }

    pub fn e_stop_released(&mut self) {
        self.e_stop_ms = None;
    }

    /// Whether it ever heard the e-stop, before it restarted or after.
    pub fn has_heard_e_stop(&self) -> bool {
        self.has_heard_e_stop
    }

    /// The gate restarts: what it sent before no longer counts.
    pub fn reboot(&mut self) {
        let (moved_in, has_heard_e_stop) = (self.moved_in, self.has_heard_e_stop);
        *self = Self { has_heard_e_stop, moved_in, ..Self::default() };
    }

    /// Called while the wheels turn.
    ///
    /// # Errors
    ///
    /// Why they must not.
    pub fn moves(&mut self, epoch: u64, now_ms: u64) -> Result<(), String> {
        let until_ms = self.fresh_until_ms.get(&epoch).copied().unwrap_or(0);
        if now_ms > until_ms {
            return Err(format!("moves at {now_ms} ms, its lease ran out at {until_ms} ms"));
        }
        match self.leases.get(&epoch) {
            Some((digest, true)) if self.controller_digest == Some(*digest) => {}
            found => {
                return Err(format!(
                    "moves under {found:?} with controller {:?}",
                    self.controller_digest
                ));
            }
        }
        if let Some(heard_ms) = self.e_stop_ms {
            return Err(format!("moves at {now_ms} ms, heard the e-stop at {heard_ms} ms"));
        }
        if epoch < self.moved_in {
            return Err(format!("moves in epoch {epoch} after epoch {}", self.moved_in));
        }
        self.moved_in = epoch;
        Ok(())
    }
}
