//! Whether the rows of a machine answer every case, and every row some case.

use super::state_machine::{Row, StateMachine, Transition};
use crate::document::{did_you_mean, nearest};
use crate::robot::sensor::{ReadingNames, Readings};

/// Most rows of a machine; more are a mistake.
pub const MOST_ROWS: usize = 1000;

/// What is wrong with rows, as a fragment behind the place of the row.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Flaw {
    /// None, or more than anybody writes.
    #[error("there are {0} rows, expected 1 to {MOST_ROWS}")]
    Rows(usize),
    /// A case that no row is for.
    #[error("state `{state}` has no row for `{case}`")]
    NoRow {
        /// The state.
        state: String,
        /// The readings, in words.
        case: String,
    },
    /// Robots that cannot report this.
    #[error("`sensors`: {0}")]
    Sensors(String),
    /// A row whose cases all belong to rows before it.
    #[error("this row never matches: rows of state `{0}` before it take all that it is for")]
    NeverMatches(String),
    /// A state in which no robot comes.
    #[error(
        "state `{0}` is never reached: no `next` leads to it from the first row's state, or from one of `starts`"
    )]
    Unreachable(String),
    /// A transition to nowhere.
    #[error("unknown state `{found}`{}", did_you_mean(nearest.as_deref()))]
    UnknownState {
        /// The name.
        found: String,
        /// The state closest in spelling.
        nearest: Option<String>,
    },
    /// A reading of no sensor.
    #[error("unknown sensor `{found}`{}", did_you_mean(nearest.as_deref()))]
    UnknownSensor {
        /// The name.
        found: String,
        /// The sensor closest in spelling.
        nearest: Option<String>,
        /// What these robots report, in words.
        known: String,
    },
    /// A transition of probability 0.
    #[error("`next` to `{0}` never happens: its probability is 0")]
    NoChance(String),
    /// A transition behind one that happens in every period.
    #[error("`next` to `{0}` never happens: one before it always does")]
    NeverHappens(String),
}

impl StateMachine {
    /// Reads what [`Self::to_json`] writes, and checks that it can run; errors are in words.
    pub fn from_json(text: &str) -> Result<Self, String> {
        let machine: Self = serde_json::from_str(text).map_err(|error| error.to_string())?;
        let flaw = check(&machine);
        flaw.map_err(|(row, flaw)| format!("row {}: {flaw}", row + 1)).map(|()| machine)
    }
}

/// Whether a machine can run: it knows what to do in every state, and each state that it goes to.
/// The error is the first flaw, with the place of its row.
pub fn check(machine: &StateMachine) -> Result<(), (usize, Flaw)> {
    let rows = &machine.rows;
    if !(1..=MOST_ROWS).contains(&rows.len()) {
        return Err((0, Flaw::Rows(rows.len())));
    }
    let (states, names) = (machine.states(), &machine.sensors);
    names.check().map_err(|problem| (0, Flaw::Sensors(problem)))?;
    for (place, row) in rows.iter().enumerate() {
        check_names(row, &states, names).map_err(|flaw| (place, flaw))?;
    }
    for state in &states {
        let is_of_it = |row: &&Row| row.state == *state;
        let first = rows.iter().position(|row| row.state == *state).expect("a state of the rows");
        for case in names.cases() {
            if !rows.iter().filter(is_of_it).any(|row| row.is_for(case, names)) {
                let (state, case) = ((*state).to_owned(), names.described(case));
                return Err((first, Flaw::NoRow { state, case }));
            }
        }
    }
    let unknown = machine.starts.values().find(|start| !states.contains(&start.as_str()));
    unknown.map_or(Ok(()), |found| Err((0, unknown_state(found, &states))))
}

/// A state that there is not.
pub(crate) fn unknown_state(found: &str, states: &[&str]) -> Flaw {
    let nearest = nearest(found, states.iter().copied()).map(str::to_owned);
    Flaw::UnknownState { found: found.to_owned(), nearest }
}

/// As [`check`], whose flaws come first, and whether all that a machine has can happen: what cannot
/// is a slip of who wrote it.
pub fn check_thoroughly(machine: &StateMachine) -> Result<(), (usize, Flaw)> {
    check(machine)?;
    let rows = &machine.rows;
    for (place, row) in rows.iter().enumerate() {
        if !matches_some(machine, place) {
            return Err((place, Flaw::NeverMatches(row.state.clone())));
        }
        if let Some(next) = row.next.iter().find(|next| next.probability <= 0.0) {
            return Err((place, Flaw::NoChance(next.state.clone())));
        }
        if let Some(state) = never_happens(&row.next) {
            return Err((place, Flaw::NeverHappens(state.to_owned())));
        }
    }
    let starts = machine.starts.values().chain([&rows[0].state]);
    let reached = reached(rows, starts.map(String::as_str).collect());
    match rows.iter().position(|row| !reached.contains(&row.state.as_str())) {
        Some(place) => Err((place, Flaw::Unreachable(rows[place].state.clone()))),
        None => Ok(()),
    }
}

fn check_names(row: &Row, states: &[&str], names: &ReadingNames) -> Result<(), Flaw> {
    if let Some(found) = row.when.keys().find(|name| names.place(name).is_none()) {
        let nearest = nearest(found, names.iter()).map(str::to_owned);
        let known: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
        let known = known.join(", ");
        return Err(Flaw::UnknownSensor { found: found.clone(), nearest, known });
    }
    let unknown = row.next.iter().find(|next| !states.contains(&next.state.as_str()));
    unknown.map_or(Ok(()), |Transition { state: found, .. }| Err(unknown_state(found, states)))
}

/// Where a transition leads that comes behind one that always happens.
fn never_happens(next: &[Transition]) -> Option<&str> {
    let always = |next: &Transition| next.probability >= 1.0 && next.after_periods <= 1;
    let first = next.iter().position(always)?;
    next.get(first + 1).map(|next| next.state.as_str())
}

/// Whether a row is for a case that no row before it takes.
fn matches_some(machine: &StateMachine, place: usize) -> bool {
    let (row, names) = (&machine.rows[place], &machine.sensors);
    let is_taken = |case: Readings| {
        let mut before = machine.rows[..place].iter().filter(|other| other.state == row.state);
        before.any(|other| other.is_for(case, names))
    };
    names.cases().any(|case| row.is_for(case, names) && !is_taken(case))
}

/// The states to which transitions lead, step by step, from the starts.
fn reached<'a>(rows: &'a [Row], mut reached: Vec<&'a str>) -> Vec<&'a str> {
    let mut looked_at = 0;
    while let Some(state) = reached.get(looked_at).copied() {
        looked_at += 1;
        let happens = |transition: &&Transition| transition.probability > 0.0;
        let next = rows.iter().filter(|row| row.state == state);
        for transition in next.flat_map(|row| row.next.iter().filter(happens)) {
            if !reached.contains(&transition.state.as_str()) {
                reached.push(&transition.state);
            }
        }
    }
    reached
}
