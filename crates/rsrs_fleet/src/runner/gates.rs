//! What the gates of a run's robots are set to: read once, before anything moves.

use std::collections::{BTreeMap, BTreeSet};

use crate::parameters::{self, GateSettings, Value, gate};
use crate::preflight::Problem;

/// The gates of a run, by robot.
#[derive(Clone, Debug, Default)]
pub(super) struct Gates {
    expected: BTreeMap<String, GateSettings>,
    waiting: BTreeSet<String>,
    found: BTreeMap<String, GateSettings>,
}

impl Gates {
    /// Gates of which nothing is read yet.
    pub(super) fn new(expected: &BTreeMap<String, GateSettings>) -> Self {
        Self {
            expected: expected.clone(),
            waiting: expected.keys().cloned().collect(),
            found: BTreeMap::new(),
        }
    }

    /// Robots whose gates are to be read.
    pub(super) fn robots(&self) -> impl Iterator<Item = &String> {
        self.expected.keys()
    }

    /// Takes what was read of a gate; `None` if nothing of ours answered.
    pub(super) fn receive(&mut self, robot: &str, found: Option<GateSettings>) {
        if self.waiting.remove(robot) {
            self.found.extend(found.map(|found| (robot.to_owned(), found)));
        }
    }

    /// Whether each gate was read, or is known not to be ours.
    pub(super) fn is_done(&self) -> bool {
        self.waiting.is_empty()
    }

    /// What was read, by robot.
    pub(super) fn found(&self) -> &BTreeMap<String, GateSettings> {
        &self.found
    }

    /// Gates that are not set as the fleet file and the profile determine.
    pub(super) fn problems(&self) -> Vec<Problem> {
        let deviations = self.found.iter().flat_map(|(robot, found)| {
            let deviations = parameters::deviations(&self.expected[robot], found).into_iter();
            deviations.map(move |deviation| (robot, deviation))
        });
        // Another profile with the same limits, period and range is the same gate.
        let deviations = deviations.filter(|(_, found)| found.parameter != gate::PROFILE_DIGEST);
        let problem =
            |(robot, deviation): (&String, _)| Problem::Setting { robot: robot.clone(), deviation };
        deviations.map(problem).collect()
    }

    /// What the operator should know, where it is no reason not to start.
    pub(super) fn notes(&self) -> Vec<String> {
        let all = self.expected.keys().map(String::as_str);
        let unknown: Vec<&str> = all.filter(|robot| !self.found.contains_key(*robot)).collect();
        let unknown = (!unknown.is_empty()).then(|| {
            format!(
                "settings of the gates of {} are not known: their nodes are not `rsrs node robot`",
                unknown.join(", ")
            )
        });
        unknown.into_iter().chain(self.other_profiles()).chain(self.odd_ones()).collect()
    }

    fn other_profiles(&self) -> impl Iterator<Item = String> {
        self.found.iter().filter_map(|(robot, found)| {
            let deviations = parameters::deviations(&self.expected[robot], found);
            let of_profile =
                deviations.iter().find(|found| found.parameter == gate::PROFILE_DIGEST)?;
            Some(format!(
                "{robot}: {of_profile}: its gate was started with another profile of the same limits, \
                 period and range; copy the files to it"
            ))
        })
    }

    /// Settings that nothing determines, and that one robot does not have like the others.
    fn odd_ones(&self) -> Vec<String> {
        let undetermined = [
            gate::DEBOUNCE,
            gate::SENSOR_TIMEOUT,
            gate::ACCELERATION_MAX,
            gate::TURN_ACCELERATION_MAX,
            gate::SPEED_MAX,
            gate::TURN_RATE_MAX,
            gate::PERIOD,
            gate::DETECTION_THRESHOLD,
        ];
        let is_determined =
            |name: &str| self.expected.values().any(|expected| expected.contains_key(name));
        let mut notes = Vec::new();
        for name in undetermined.into_iter().filter(|name| !is_determined(name)) {
            let mut by_value: BTreeMap<String, Vec<&str>> = BTreeMap::new();
            for (robot, found) in &self.found {
                if let Some(value) = found.get(name).map(Value::to_string) {
                    by_value.entry(value).or_default().push(robot);
                }
            }
            if by_value.len() > 1 {
                let of_each = by_value.iter();
                let of_each: Vec<_> = of_each
                    .map(|(value, robots)| format!("{value} on {}", robots.join(", ")))
                    .collect();
                notes.push(format!("`{name}` differs between robots: {}", of_each.join("; ")));
            }
        }
        notes
    }
}
