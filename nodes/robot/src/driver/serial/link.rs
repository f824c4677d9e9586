//! The conversation with a microcontroller: bytes in, lines out, no port and no clock.
//!
//! What it holds: no command is sent before the microcontroller has identified itself; and it is up
//! only while states come in, each command is acknowledged, and the wheels have the command that
//! was sent.

use std::collections::VecDeque;
use std::time::Duration;

use rsrs_core::robot::controller::Command;
use rsrs_msgs::sensor_msgs::Range;

use super::super::{Report, Sensed};
use super::line::{
    FromDevice, Identity, LONGEST_STATE, LineError, Mode, RangeReading, Setpoint, State, ToDevice,
    VERSION,
};

/// Greetings are repeated: a microcontroller that restarts when its port is opened receives the first
/// ones not at all.
const GREET_EVERY: Duration = Duration::from_millis(200);
/// How long a microcontroller may take to answer, its boot loader included.
const GREETING: Duration = Duration::from_secs(5);
/// How long it may be silent, or leave a command unacknowledged.
const SILENCE: Duration = Duration::from_millis(500);
/// The longest timeout of the wheels that is acceptable, in ms.
const WHEEL_TIMEOUT_MS: u32 = 250;
/// Commands on their way, at most: what is sent in [`SILENCE`], with room.
const ON_THE_WAY: usize = 256;

/// Why a conversation ended. It begins anew when the port has been opened again.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum LinkError {
    /// Nobody answered.
    #[error("no answer to a greeting in {} s", GREETING.as_secs())]
    NoAnswer,
    /// It has another version of the protocol.
    #[error("microcontroller has version {found} of the protocol, expected {VERSION}")]
    Version {
        /// Its version.
        found: u32,
    },
    /// Its wheels would run on for too long.
    #[error("microcontroller's timeout is {found_ms} ms, expected 1 to {WHEEL_TIMEOUT_MS} ms")]
    Timeout {
        /// Its timeout.
        found_ms: u32,
    },
    /// It fell silent.
    #[error("no state of the microcontroller for {} ms{}", SILENCE.as_millis(), because(refused.as_ref()))]
    Silent {
        /// Why its last line was thrown away, if that came as it was sent.
        refused: Option<LineError>,
    },
    /// It does not receive, or does not obey.
    #[error("a command was not acknowledged for {} ms", SILENCE.as_millis())]
    Unacknowledged,
    /// It was switched off and on.
    #[error("microcontroller restarted")]
    Restarted,
    /// It reports so.
    #[error("microcontroller reports a fault")]
    Fault,
    /// It acknowledges what was never sent.
    #[error("microcontroller took command {found}, which was not sent")]
    NeverSent {
        /// The number.
        found: u16,
    },
    /// Its wheels have another command.
    #[error("wheels are commanded {found:?}, expected {expected:?}")]
    WrongWheels {
        /// What the microcontroller reports.
        found: Setpoint,
        /// What was sent.
        expected: Setpoint,
    },
}

fn because(refused: Option<&LineError>) -> String {
    refused.map_or_else(String::new, |reason| format!(", its last line was refused: {reason}"))
}

/// What came in so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Lines that were understood.
    pub understood: u64,
    /// Lines that meant nothing.
    pub garbled: u64,
}

#[derive(Clone, Debug)]
struct Sent {
    sequence: u16,
    setpoint: Setpoint,
    at: Duration,
}

#[derive(Clone, Debug)]
enum Phase {
    Greeting { since: Duration, next: Duration },
    Up { identity: Identity, received: Duration, time_ms: Option<u32> },
}

/// The conversation over one opening of a port.
#[derive(Clone, Debug)]
pub struct Link {
    phase: Phase,
    nonce: u16,
    line: Vec<u8>,
    sequence: u16,
    on_the_way: VecDeque<Sent>,
    acknowledged: Option<(u16, Setpoint)>,
    counts: Counts,
    /// Why the last line that came as it was sent means nothing.
    refused: Option<LineError>,
}

impl Link {
    /// A conversation that is to begin, with another `nonce` for each opening of a port.
    pub fn new(nonce: u16, now: Duration) -> Self {
        Self {
            phase: Phase::Greeting { since: now, next: now },
            nonce,
            line: Vec::with_capacity(LONGEST_STATE),
            sequence: 0,
            on_the_way: VecDeque::new(),
            acknowledged: None,
            counts: Counts::default(),
            refused: None,
        }
    }

    /// What came in so far.
    pub fn counts(&self) -> Counts {
        self.counts
    }

    /// The identity of the microcontroller, once received.
    pub fn identity(&self) -> Option<&Identity> {
        match &self.phase {
            Phase::Greeting { .. } => None,
            Phase::Up { identity, .. } => Some(identity),
        }
    }

    /// When [`Link::on_tick`] has something to do.
    pub fn due(&self) -> Duration {
        match &self.phase {
            Phase::Greeting { next, .. } => *next,
            Phase::Up { received, .. } => {
                let oldest = self.on_the_way.front().map_or(*received, |sent| sent.at);
                oldest.min(*received) + SILENCE
            }
        }
    }

    /// Looks at the time, for a line to send if one is due.
    ///
    /// # Errors
    ///
    /// [`LinkError::NoAnswer`], [`LinkError::Silent`] and [`LinkError::Unacknowledged`].
    pub fn on_tick(&mut self, now: Duration) -> Result<Option<String>, LinkError> {
        match &mut self.phase {
            Phase::Greeting { since, next } => {
                if now.saturating_sub(*since) >= GREETING {
                    return Err(LinkError::NoAnswer);
                }
                if now < *next {
                    return Ok(None);
                }
                *next = now + GREET_EVERY;
                Ok(Some(ToDevice::Hello { nonce: self.nonce }.encode()))
            }
            Phase::Up { received, .. } if now.saturating_sub(*received) >= SILENCE => {
                Err(LinkError::Silent { refused: self.refused.clone() })
            }
            Phase::Up { .. } => match self.on_the_way.front() {
                Some(sent) if now.saturating_sub(sent.at) >= SILENCE => {
                    Err(LinkError::Unacknowledged)
                }
                _ => Ok(None),
            },
        }
    }

    /// The line that carries a command; `None` while the link is down.
    pub fn drive(&mut self, command: Command, now: Duration) -> Option<String> {
        let Phase::Up { time_ms: Some(time_ms), .. } = self.phase else { return None };
        if self.on_the_way.len() >= ON_THE_WAY {
            return None;
        }
        self.sequence = self.sequence.wrapping_add(1);
        let (sequence, setpoint) = (self.sequence, Setpoint::new(command));
        self.on_the_way.push_back(Sent { sequence, setpoint, at: now });
        Some(ToDevice::Drive { sequence, time_ms, setpoint }.encode())
    }

    /// Takes bytes as they come.
    pub fn on_bytes(&mut self, bytes: &[u8], now: Duration) -> Result<Vec<Report>, LinkError> {
        let mut reports = Vec::new();
        for byte in bytes {
            match byte {
                b'\n' => {
                    let line = std::mem::take(&mut self.line);
                    self.on_line(line.trim_ascii_end(), &mut reports, now)?;
                }
                // A line that lost its end does not take the next one with it.
                b'$' => {
                    self.counts.garbled += u64::from(!self.line.is_empty());
                    self.line.clear();
                    self.line.push(*byte);
                }
                // What comes before a start, or after too much, belongs to no line.
                _ if self.line.is_empty() => {}
                _ if self.line.len() >= LONGEST_STATE => {
                    self.counts.garbled += 1;
                    self.line.clear();
                }
                _ => self.line.push(*byte),
            }
        }
        Ok(reports)
    }

    fn on_line(
        &mut self,
        line: &[u8],
        reports: &mut Vec<Report>,
        now: Duration,
    ) -> Result<(), LinkError> {
        if line.is_empty() {
            return Ok(());
        }
        let message = match FromDevice::decode(line) {
            Ok(message) => message,
            Err(reason) => {
                self.counts.garbled += 1;
                if reason.is_of_its_program() {
                    reports.push(Report::Refused(reason.to_string()));
                    self.refused = Some(reason);
                }
                return Ok(());
            }
        };
        self.counts.understood += 1;
        self.refused = None;
        match message {
            FromDevice::Identity(identity) => self.on_identity(identity, now),
            FromDevice::State(state) => self.on_state(state, reports, now),
        }
    }

    fn on_identity(&mut self, identity: Identity, now: Duration) -> Result<(), LinkError> {
        let is_greeting = matches!(self.phase, Phase::Greeting { .. });
        // The answer to an earlier greeting, or a second one to this.
        if identity.nonce != self.nonce || !is_greeting {
            return Ok(());
        }
        if identity.version != VERSION {
            return Err(LinkError::Version { found: identity.version });
        }
        if !(1..=WHEEL_TIMEOUT_MS).contains(&identity.timeout_ms) {
            return Err(LinkError::Timeout { found_ms: identity.timeout_ms });
        }
        self.phase = Phase::Up { identity, received: now, time_ms: None };
        Ok(())
    }

    fn on_state(
        &mut self,
        state: State,
        reports: &mut Vec<Report>,
        now: Duration,
    ) -> Result<(), LinkError> {
        if matches!(self.phase, Phase::Greeting { .. }) {
            return Ok(());
        }
        match state.mode {
            Mode::Fresh => return Err(LinkError::Restarted),
            Mode::Fault => return Err(LinkError::Fault),
            Mode::Driving | Mode::TimedOut => {}
        }
        self.acknowledge(&state)?;
        let Phase::Up { identity, received, time_ms } = &mut self.phase else {
            unreachable!("the phase was looked at above");
        };
        *received = now;
        if time_ms.replace(state.time_ms).is_none() {
            reports.push(Report::Up);
        }
        let State { seen, range, battery_mv, further, .. } = state;
        if seen.is_some() || range.is_some() || !further.is_empty() {
            let range = range.map(|reading| range_message(reading, identity));
            reports.push(Report::Sensed(Sensed { seen, range, further }));
        }
        reports.extend(battery_mv.map(|mv| Report::Battery(mv as f32 / 1000.0)));
        Ok(())
    }

    /// Holds what the wheels do against what was sent.
    fn acknowledge(&mut self, state: &State) -> Result<(), LinkError> {
        if let Some(found) = state.sequence
            && self.acknowledged.is_none_or(|(sequence, _)| sequence != found)
        {
            let place = self.on_the_way.iter().position(|sent| sent.sequence == found);
            let place = place.ok_or(LinkError::NeverSent { found })?;
            self.acknowledged = self
                .on_the_way
                .drain(..=place)
                .next_back()
                .map(|sent| (sent.sequence, sent.setpoint));
        }
        let expected = match (state.mode, state.sequence, self.acknowledged) {
            (Mode::Driving, Some(_), Some((_, setpoint))) => setpoint,
            _ => Setpoint::default(),
        };
        let found = state.setpoint;
        if found == expected { Ok(()) } else { Err(LinkError::WrongWheels { found, expected }) }
    }
}

fn range_message(reading: RangeReading, identity: &Identity) -> Range {
    let metres = |mm: u32| mm as f32 / 1000.0;
    Range {
        radiation_type: Range::INFRARED,
        field_of_view: metres(identity.field_of_view_mrad),
        min_range: metres(identity.min_range_mm),
        max_range: metres(identity.max_range_mm),
        range: match reading {
            RangeReading::Distance(mm) => metres(mm),
            RangeReading::Nothing => f32::INFINITY,
            RangeReading::Failed => f32::NAN,
        },
        ..Range::default()
    }
}

#[cfg(test)]
mod tests;
