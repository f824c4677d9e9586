//! A controller with states: a probabilistic finite-state machine over what is detected.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::{Command, ControllerParameters, decide};
use crate::draw::{Key, Purpose, RunKey, Seed, threshold};
use crate::robot::sensor::{DETECTION, ReadingNames, Readings};

/// Rows in order, of which the first that matches state and readings counts: a table of a file, with all
/// numbers in it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StateMachine {
    /// The first one's state is the start, but of robots of a class that has its own.
    pub rows: Vec<Row>,
    /// The named numbers that are in the rows, for what reads them off: the axes of a sweep.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub numbers: BTreeMap<String, f64>,
    /// The states in which robots of classes start, by class; others start in that of the first row.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub starts: BTreeMap<String, String>,
    /// What its robots report; left out where `detection` is all.
    #[serde(default, skip_serializing_if = "ReadingNames::is_detection")]
    pub sensors: ReadingNames,
}

/// What a robot does in a state for what it detects.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Row {
    /// The state.
    pub state: String,
    /// Readings and what they must be; none for whatever they are.
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
    /// Whether it is for these readings of robots that have those with these names.
    pub fn is_for(&self, found: Readings, names: &ReadingNames) -> bool {
        let is = |(name, wanted): (&String, &bool)| {
            names.place(name).is_some_and(|reading| found.has(reading) == *wanted)
        };
        self.when.iter().all(is)
    }
}

impl StateMachine {
    /// As one line of JSON, as records and the parameters of a controller node have it.
    pub fn to_json(&self) -> String {
        serde_json::to_string(self).expect("a machine is plain data")
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

    /// The two constant commands that it comes to, if it has one state and decides by `detection` alone; `None` for
    /// any other machine.
    ///
    /// This is what decides whether a table is the controller of the paper, and runs where that does.
    pub fn as_parameters(&self) -> Option<ControllerParameters> {
        let mut readings = self.rows.iter().flat_map(|row| row.when.keys());
        if self.states().len() != 1
            || !self.starts.is_empty()
            || readings.any(|name| name != DETECTION)
        {
            return None;
        }
        let command = |is_detected: bool| Some(self.row(0, is_detected.into())?.command);
        Some(ControllerParameters::new(command(true)?, command(false)?))
    }

    /// Where a robot of a class starts, or one of none.
    ///
    /// # Panics
    ///
    /// If a class starts in a state that there is not: conditions that were checked have no such machine.
    pub fn start(&self, class: Option<&str>) -> Memory {
        let Some(start) = class.and_then(|class| self.starts.get(class)) else {
            return Memory::default();
        };
        let state = self.states().iter().position(|state| state == start);
        Memory { state: state.expect("the states of starts were checked"), ..Memory::default() }
    }

    /// The row for a state, by its place among [`Self::states`], and what is reported.
    fn row(&self, state: usize, found: Readings) -> Option<&Row> {
        let state = *self.states().get(state)?;
        self.rows.iter().find(|row| row.state == state && row.is_for(found, &self.sensors))
    }
}

/// A machine ready to run: what follows from each state and case, looked up.
#[derive(Clone, Debug, PartialEq)]
pub struct TransitionTable {
    /// For each state, by [`Readings::case`].
    by_state: Vec<Vec<Entry>>,
}

#[derive(Clone, Debug, PartialEq)]
struct Entry {
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

impl TransitionTable {
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
        let entry = |state, case| {
            let found = machine.sensors.possible(Readings::of_case(case));
            let row = machine.row(state, found).expect("cases without a row were refused");
            Entry { command: row.command, next: row.next.iter().map(next).collect() }
        };
        let n_cases = 1_usize << machine.sensors.n_readings();
        let of_state = |state| (0..n_cases).map(|case| entry(state, case)).collect();
        Self { by_state: (0..states.len()).map(of_state).collect() }
    }

    /// The command for what is reported, after which the robot may be in another state.
    pub fn decide(&self, found: Readings, memory: &mut Memory, key: Key) -> Command {
        let entry = &self.by_state[memory.state][found.case()];
        memory.periods = memory.periods.saturating_add(1);
        if let Some(state) = drawn(&entry.next, *memory, key) {
            (memory.state, memory.periods) = (state, 0);
        }
        memory.count = memory.count.wrapping_add(1);
        entry.command
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
    Machine(TransitionTable),
}

impl Program {
    /// The command for what is reported; only a machine has something to remember.
    ///
    /// # Panics
    ///
    /// If a machine is given readings that its robots do not have.
    pub fn decide(&self, found: Readings, memory: &mut Memory, key: Key) -> Command {
        match self {
            Self::Parameters(parameters) => decide(found.detection(), *parameters),
            Self::Machine(table) => table.decide(found, memory, key),
        }
    }
}
