//! Controllers, written once: the sweep, the dry run and the robot call this. That of the paper is two
//! commands over one detection; any other is a [`StateMachine`].

pub mod state_machine;
pub mod structure;

use std::fmt;

use serde::{Deserialize, Serialize};

use state_machine::{Memory, Program, StateMachine, TransitionTable};

use crate::digest::Digest;
use crate::numerals::{counted, rounded};
use crate::robot::sensor::ReadingNames;

/// What the operator sets on every robot: the swept plane of the phase diagram.
///
/// A binary controller has a command for each of the two things that its sensor reports. That of
/// the paper needs two numbers, as one command mirrors the other; any other is given in full.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ControllerParameters {
    /// Forward speed `v` where something is detected, in metres per second; not negative in a
    /// mirrored controller.
    pub speed_m_s: f64,
    /// Turning rate `ω` where something is detected, in radians per second; not negative in a
    /// mirrored controller.
    pub turn_rate_rad_s: f64,
    /// The command where nothing is detected; `None` for the same speed and the opposite turn.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub undetected: Option<Command>,
}

impl ControllerParameters {
    /// The controller of the paper: it turns one way where something is detected, and the other way
    /// where nothing is.
    pub const fn mirrored(speed_m_s: f64, turn_rate_rad_s: f64) -> Self {
        Self { speed_m_s, turn_rate_rad_s, undetected: None }
    }

    /// The controller with one command where something is detected, and one where nothing is; those of
    /// a mirrored one that drives forward make a mirrored one.
    pub fn new(detected: Command, undetected: Command) -> Self {
        let mirrored = Self::mirrored(detected.speed_m_s, detected.turn_rate_rad_s);
        let is_forward = detected.speed_m_s >= 0.0 && detected.turn_rate_rad_s >= 0.0;
        let is_mirrored = is_forward && decide(false, mirrored) == undetected;
        Self { undetected: (!is_mirrored).then_some(undetected), ..mirrored }
    }

    /// Its commands: where something is detected, and where nothing is.
    pub fn commands(self) -> [Command; 2] {
        [true, false].map(|detected| decide(detected, self))
    }

    /// Names these parameters in leases and statuses: a robot moves only under the digest that the
    /// runner confirmed.
    pub fn digest(&self) -> u64 {
        self.digest_with(Reaction::ToDetections)
    }

    /// [`Self::digest`] for a controller with a reaction: one that is left on a constant command is
    /// never taken for one that decides.
    pub fn digest_with(&self, reaction: Reaction) -> u64 {
        let mut digest = Digest::new(match reaction {
            Reaction::ToDetections => "controller_parameters",
            Reaction::Constant => "constant_command",
        });
        digest.number(self.speed_m_s);
        digest.number(self.turn_rate_rad_s);
        if let Some(undetected) = self.undetected {
            digest.number(undetected.speed_m_s);
            digest.number(undetected.turn_rate_rad_s);
        }
        digest.value()
    }
}

/// What decides on every robot's commands.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Controller {
    /// Two commands over one detection.
    Parameters(ControllerParameters),
    /// A machine with states.
    Machine(StateMachine),
}

/// `0.15 m/s at 0.75 rad/s where something is detected, else 0.15 m/s at -0.75 rad/s`, or
/// `a table of 4 rows, turn_rad_s=0.75`.
impl fmt::Display for Controller {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let machine = match self {
            Self::Machine(machine) => machine,
            Self::Parameters(parameters) => {
                let [detected, undetected] = parameters.commands();
                return write!(out, "{detected} where something is detected, else {undetected}");
            }
        };
        write!(out, "a table of {}", counted(machine.rows.len() as u64, "row"))?;
        machine.numbers.iter().try_for_each(|(name, value)| write!(out, ", {name}={value}"))
    }
}

impl Controller {
    /// The numbers of a controller with two constant commands; `None` for any other.
    pub fn parameters(&self) -> Option<ControllerParameters> {
        match self {
            Self::Parameters(parameters) => Some(*parameters),
            Self::Machine(_) => None,
        }
    }

    /// All that it may command.
    pub fn commands(&self) -> Vec<Command> {
        match self {
            Self::Parameters(parameters) => parameters.commands().to_vec(),
            Self::Machine(machine) => machine.rows.iter().map(|row| row.command).collect(),
        }
    }

    /// The fastest that it asks for in either direction: speed in metres per second, and turning rate
    /// in radians per second.
    pub fn fastest(&self) -> Command {
        self.commands().into_iter().fold(Command::STOP, |fastest, command| Command {
            speed_m_s: fastest.speed_m_s.max(command.speed_m_s.abs()),
            turn_rate_rad_s: fastest.turn_rate_rad_s.max(command.turn_rate_rad_s.abs()),
        })
    }

    /// Names it, as [`ControllerParameters::digest`] does: the whole table of a machine.
    pub fn digest(&self) -> u64 {
        self.digest_with(Reaction::ToDetections)
    }

    /// Names it with what it makes of its sensor.
    pub fn digest_with(&self, reaction: Reaction) -> u64 {
        match self {
            Self::Parameters(parameters) => parameters.digest_with(reaction),
            Self::Machine(machine) => {
                let mut digest = Digest::new("state_machine");
                digest.text(&machine.to_json());
                digest.word(u64::from(reaction == Reaction::Constant));
                digest.value()
            }
        }
    }

    /// The same on robots that report this.
    #[must_use]
    pub fn for_robots_with(self, sensors: ReadingNames) -> Self {
        match self {
            Self::Parameters(parameters) => Self::Parameters(parameters),
            Self::Machine(machine) => Self::Machine(StateMachine { sensors, ..machine }),
        }
    }

    /// What it asks of robots: `detection` alone, or the readings of those that it is for.
    pub fn reading_names(&self) -> ReadingNames {
        match self {
            Self::Parameters(_) => ReadingNames::default(),
            Self::Machine(machine) => machine.sensors.clone(),
        }
    }

    /// Where a robot of a class starts, or one of none.
    ///
    /// # Panics
    ///
    /// As [`StateMachine::start`].
    pub fn start(&self, class: Option<&str>) -> Memory {
        match self {
            Self::Parameters(_) => Memory::default(),
            Self::Machine(machine) => machine.start(class),
        }
    }

    /// It, ready to run.
    ///
    /// # Panics
    ///
    /// If it is a machine that [`structure::check`] refuses.
    pub fn program(&self) -> Program {
        match self {
            Self::Parameters(parameters) => Program::Parameters(*parameters),
            Self::Machine(machine) => Program::Machine(TransitionTable::new(machine)),
        }
    }
}

impl From<ControllerParameters> for Controller {
    fn from(parameters: ControllerParameters) -> Self {
        Self::Parameters(parameters)
    }
}

/// What a controller makes of its sensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reaction {
    /// It decides by what is detected.
    ToDetections,
    /// Every detection is a beat, and something is always seen: the command is constant.
    Constant,
}

/// A velocity command `u`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Command {
    /// Forward speed `u₁`, in metres per second.
    pub speed_m_s: f64,
    /// Turning rate `u₂`, in radians per second; positive is counterclockwise (REP 103).
    pub turn_rate_rad_s: f64,
}

/// `0.15 m/s at 0.75 rad/s`
impl fmt::Display for Command {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [speed, turn] = [self.speed_m_s, self.turn_rate_rad_s].map(rounded);
        write!(out, "{speed} m/s at {turn} rad/s")
    }
}

impl Command {
    /// Stand still.
    pub const STOP: Self = Self { speed_m_s: 0.0, turn_rate_rad_s: 0.0 };
}

/// Decides the command from the binary detection `y`: forward at `v`, turning counterclockwise at
/// `ω` if something is detected, clockwise if not. A controller that is not mirrored has a command
/// of its own for nothing.
///
/// # Source
///
/// `eq:controller`, §IV step 3; the turning sense is that of `fig:milling_figure`.
///
/// # Example
///
/// ```
/// use rsrs_core::robot::controller::{ControllerParameters, decide};
///
/// let best = ControllerParameters::mirrored(0.15, 0.75);
/// assert_eq!(decide(true, best).turn_rate_rad_s, 0.75);
/// assert_eq!(decide(false, best).turn_rate_rad_s, -0.75);
/// ```
#[expect(clippy::fn_params_excessive_bools, reason = "binary is what the sensor is")]
pub fn decide(detected: bool, parameters: ControllerParameters) -> Command {
    let ControllerParameters { speed_m_s, turn_rate_rad_s, undetected } = parameters;
    if detected {
        Command { speed_m_s, turn_rate_rad_s }
    } else {
        undetected.unwrap_or(Command { speed_m_s, turn_rate_rad_s: -turn_rate_rad_s })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commands_that_mirror_each_other_make_the_controller_of_the_paper() {
        let command = |speed_m_s, turn_rate_rad_s| Command { speed_m_s, turn_rate_rad_s };

        let mirrored = ControllerParameters::new(command(0.15, 0.75), command(0.15, -0.75));
        let other = ControllerParameters::new(command(0.0, 1.0), command(-0.15, 0.3));

        assert_eq!(mirrored, ControllerParameters::mirrored(0.15, 0.75));
        assert_eq!(other.commands(), [command(0.0, 1.0), command(-0.15, 0.3)]);
        // A mirrored controller is given by two numbers, which are not negative.
        let backward = ControllerParameters::new(command(-0.15, 0.75), command(-0.15, -0.75));
        assert_eq!(backward.undetected, Some(command(-0.15, -0.75)));
        assert_eq!(Controller::Parameters(other).fastest(), command(0.15, 1.0));
        assert_ne!(other.digest(), ControllerParameters::mirrored(0.0, 1.0).digest());
    }
}
