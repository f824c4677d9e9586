//! A controller with states: a probabilistic finite-state machine over what is detected.

#![expect(clippy::fn_params_excessive_bools, reason = "binary is what the sensor is")]

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::{Command, ControllerParameters, decide, structure};
use crate::draw::{Key, Purpose, RunKey, Seed, threshold};

/// The one sensor of a robot, as rows name it.
pub const DETECTION: &str = "detection";

/// Rows in order, of which the first that matches state and detection counts: a table of a file, with all
/// numbers in it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StateMachine {
    /// The first one's state is the start.
    pub rows: Vec<Row>,
    /// The named numbers that are in the rows, for what reads them off: the axes of a sweep.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub numbers: BTreeMap<String, f64>,
}

/// What a robot does in a state for what it detects.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Row {
    /// The state.
    pub state: String,
    /// Sensors and what they must report; none for whatever they do.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub when: BTreeMap<String, bool>,
    /// The command of this period.
    pub command: Command,
    /// Where it goes after this period, the first that happens; none for staying.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub next: Vec<Transition>,
}

/// A way out of a state.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Transition {
    /// Where to.
    pub state: String,
    /// How likely it happens in a period in which none before it did.
    pub probability: f64,
    /// It cannot happen before so many periods in the state, this one included.
    pub after_periods: u32,
}

impl Row {
    /// Whether it is for this reading of the sensor.
    pub fn is_for(&self, is_detected: bool) -> bool {
        self.when.get(DETECTION).is_none_or(|wanted| *wanted == is_detected)
    }
}

impl StateMachine {
    /// As one line of JSON, as records and the parameters of a controller node have it.
    pub fn to_json(&self) -> String {
        serde_json::to_string(self).expect("a machine is plain data")
    }

    /// Reads what [`Self::to_json`] writes, and checks that it can run.
    ///
    /// # Errors
    ///
    /// What is wrong, in words.
    pub fn from_json(text: &str) -> Result<Self, String> {
        let machine: Self = serde_json::from_str(text).map_err(|error| error.to_string())?;
        let flaw = structure::check(&machine);
        flaw.map_err(|(row, flaw)| format!("row {}: {flaw}", row + 1)).map(|()| machine)
    }

    /// The states in the order of their first rows; the first is the start.
    pub fn states(&self) -> Vec<&str> {
        let mut states: Vec<&str> = Vec::new();
        for row in &self.rows {
            if !states.contains(&row.state.as_str()) {
                states.push(&row.state);
            }
        }
        states
    }

    /// The two constant commands that it comes to, if it has one state; `None` for a machine with several.
    ///
    /// This is what decides whether a table is the controller of the paper, and runs where that does.
    pub fn as_parameters(&self) -> Option<ControllerParameters> {
        if self.states().len() != 1 {
            return None;
        }
        let command = |is_detected| Some(self.row(0, is_detected)?.command);
        Some(ControllerParameters::of(command(true)?, command(false)?))
    }

    /// The row for a state, by its place among [`Self::states`], and a reading.
    fn row(&self, state: usize, is_detected: bool) -> Option<&Row> {
        let state = *self.states().get(state)?;
        self.rows.iter().find(|row| row.state == state && row.is_for(is_detected))
    }
}

/// A machine ready to run: what follows from each state and reading, looked up.
#[derive(Clone, Debug, PartialEq)]
pub struct Answers {
    /// For each state, where nothing and where something is detected.
    by_state: Vec<[Answer; 2]>,
}

#[derive(Clone, Debug, PartialEq)]
struct Answer {
    command: Command,
    next: Vec<Next>,
}

/// A [`Transition`] to a state by its place.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Next {
    state: usize,
    probability: f64,
    after_periods: u32,
}

/// Where a robot's machine is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Memory {
    /// Its state, by its place among [`StateMachine::states`].
    pub state: usize,
    /// Periods that it has spent in it.
    pub periods: u32,
    /// Detections that it has answered.
    pub count: u32,
}

/// The key of one robot's transitions in a run of a controller with this digest.
pub fn transition_key(seed: Seed, digest: u64, robot: usize) -> Key {
    RunKey::new(seed, digest).key(robot, Purpose::Transition)
}

impl Answers {
    /// Looks up what a machine does.
    ///
    /// # Panics
    ///
    /// If it leaves a case without a row, or goes to a state that it does not have: conditions that were
    /// checked have no such machine.
    pub fn new(machine: &StateMachine) -> Self {
        let states = machine.states();
        let next = |transition: &Transition| Next {
            state: (states.iter().position(|state| *state == transition.state))
                .expect("the states of transitions were checked"),
            probability: transition.probability,
            after_periods: transition.after_periods,
        };
        let answer = |state, is_detected| {
            let row = machine.row(state, is_detected).expect("cases without a row were refused");
            Answer { command: row.command, next: row.next.iter().map(next).collect() }
        };
        let of_state = |state| [false, true].map(|is_detected| answer(state, is_detected));
        Self { by_state: (0..states.len()).map(of_state).collect() }
    }

    /// The command for a reading, after which the robot may be in another state.
    pub fn decide(&self, is_detected: bool, memory: &mut Memory, key: Key) -> Command {
        let answer = &self.by_state[memory.state][usize::from(is_detected)];
        memory.periods = memory.periods.saturating_add(1);
        if let Some(state) = drawn(&answer.next, *memory, key) {
            (memory.state, memory.periods) = (state, 0);
        }
        memory.count = memory.count.wrapping_add(1);
        answer.command
    }
}

/// The first transition that happens: one draw decides between all.
fn drawn(next: &[Next], memory: Memory, key: Key) -> Option<usize> {
    let mut due = next.iter().filter(|next| memory.periods >= next.after_periods).peekable();
    due.peek()?;
    let draw = key.uniform24(memory.count);
    let mut none_happened = 1.0;
    due.find(|next| {
        none_happened *= 1.0 - next.probability;
        draw < threshold(1.0 - none_happened)
    })
    .map(|next| next.state)
}

/// A controller at work, on one robot or on each of many.
#[derive(Clone, Debug, PartialEq)]
pub enum Program {
    /// Two commands over one detection.
    Parameters(ControllerParameters),
    /// A machine.
    Answers(Answers),
}

impl Program {
    /// The command for a reading; only a machine has something to remember.
    pub fn decide(&self, is_detected: bool, memory: &mut Memory, key: Key) -> Command {
        match self {
            Self::Parameters(parameters) => decide(is_detected, *parameters),
            Self::Answers(answers) => answers.decide(is_detected, memory, key),
        }
    }
}
