//! The judge: what a swarm settled into, and why.

use pyo3::exceptions::PyKeyError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rsrs_core::judge::behaviour::Behaviour;
use rsrs_core::judge::certainty::Certainty;
use rsrs_core::judge::order::{OrderParameters, Parameter};
use rsrs_core::judge::phase::{Phase, label_with, label_without_commands};
use rsrs_core::judge::reason::Reason;
use rsrs_core::judge::trajectory::{Bodies, Trajectory};
use rsrs_core::quantity::Bounds;
use rsrs_pipeline::label::Labelled;
use rsrs_pipeline::sweep::source;
use rsrs_render::label::{text, warning};
use serde::Serialize;

use crate::error::{raised, refused};
use crate::json::to_python;

/// Order parameters of the last 60 s: numbers that describe how a swarm moves, each a mean.
///
/// What is not known, because no reach, radius or commands were given, is None. Those that only some behaviours
/// ask for (`polarisation`, `coverage`) have no attribute: `order["coverage"]`.
#[pyclass(name = "OrderParameters", module = "rsrs", frozen, eq)]
#[derive(Clone, PartialEq)]
pub struct PyOrderParameters {
    evidence: OrderParameters,
    has_commands: bool,
}

impl PyOrderParameters {
    pub fn new(evidence: &OrderParameters, has_commands: bool) -> Self {
        Self { evidence: *evidence, has_commands }
    }

    fn known(&self, value: f64) -> Option<f64> {
        self.has_commands.then_some(value)
    }

    /// Every window's, and those that were asked for.
    fn named(&self) -> impl Iterator<Item = (&'static str, Option<f64>)> + '_ {
        let is_there = |it: &Parameter| !it.is_asked() || it.value(&self.evidence).is_some();
        let value = |it: Parameter| {
            let is_known = self.has_commands || !it.needs_commands();
            it.value(&self.evidence).filter(|_| is_known)
        };
        Parameter::all().filter(is_there).map(move |it| (it.key(), value(it)))
    }
}

#[pymethods]
impl PyOrderParameters {
    /// Share of robots that had no neighbour within reach for more than half of the time.
    #[getter]
    fn lost(&self) -> Option<f64> {
        self.evidence.lost
    }
    /// Share of time in which robots came less than 20 % as far as they were commanded to drive.
    #[getter]
    fn blocked(&self) -> Option<f64> {
        self.known(self.evidence.blocked)
    }
    /// Share of robots that were blocked for more than 90 % of the time.
    #[getter]
    fn stuck(&self) -> Option<f64> {
        self.known(self.evidence.stuck)
    }
    /// Normalised angular momentum about the centroid, from 0 to 1: 1 where all circle one way.
    #[getter]
    fn rotation(&self) -> f64 {
        self.evidence.rotation
    }
    /// Way around the centroid over the way that was commanded; about 1 for a ring that runs freely.
    #[getter]
    fn orbit(&self) -> Option<f64> {
        self.known(self.evidence.orbit)
    }
    /// `1 - (r_min / r_max)²` of the distances from the centroid; 0 for a ring.
    #[getter]
    fn fatness(&self) -> f64 {
        self.evidence.fatness
    }
    /// Mean `|cos|` of the angle between heading and bearing from the centroid; 0 for a ring.
    #[getter]
    fn tangentness(&self) -> f64 {
        self.evidence.tangentness
    }
    /// `1 - max(fatness, tangentness)`: 1 for a thin ring, 0 for a filled disc.
    #[getter]
    fn circliness(&self) -> f64 {
        self.evidence.circliness
    }
    /// Mean distance from the centroid, in metres.
    #[getter]
    fn mean_radius_m(&self) -> f64 {
        self.evidence.mean_radius_m
    }
    /// How often a robot comes into contact, per robot and second.
    #[getter]
    fn contact_onsets_per_s(&self) -> Option<f64> {
        self.evidence.contact_onsets_per_s
    }
    /// The greatest circliness of a mill that steers once per period: `1 - ωΔt/2`.
    #[getter]
    fn circliness_ceiling(&self) -> Option<f64> {
        self.known(self.evidence.circliness_ceiling)
    }
    /// Share of the robots in the largest cluster.
    #[getter]
    fn clustered(&self) -> Option<f64> {
        self.evidence.clustered
    }
    /// One of them by name; KeyError for one that the behaviour does not ask for.
    fn __getitem__(&self, name: &str) -> PyResult<Option<f64>> {
        let found = self.named().find(|(key, _)| *key == name);
        found.map(|(_, value)| value).ok_or_else(|| PyKeyError::new_err(name.to_owned()))
    }
    /// All of them by name.
    fn as_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        for (key, value) in self.named() {
            dict.set_item(key, value)?;
        }
        Ok(dict)
    }
    fn __repr__(&self) -> String {
        let numbers = self.named().map(|(key, value)| match value {
            Some(value) => format!("{key}={value:.3}"),
            None => format!("{key}=None"),
        });
        format!("OrderParameters({})", numbers.collect::<Vec<_>>().join(", "))
    }
}

/// What a swarm settled into, by the judge: that of `rsrs label`, to the bit.
#[pyclass(name = "Verdict", module = "rsrs", frozen)]
pub struct Verdict {
    phase: Phase,
    evidence: OrderParameters,
    /// Not there where a phase is given without commands, of which its distance from others depends.
    certainty: Option<Certainty>,
    why: Vec<String>,
    n_robots: usize,
    duration_s: f64,
    has_commands: bool,
    /// What else a bag has.
    label: Option<Box<Labelled>>,
}

/// What of it a dictionary has where there is no bag; the names are those of `rsrs label --format json`.
#[derive(Serialize)]
struct Written<'a> {
    phase: Phase,
    #[serde(flatten)]
    certainty: &'a Option<Certainty>,
    why: &'a [String],
    n_robots: usize,
    duration_s: f64,
}

impl Verdict {
    /// The verdict on a trajectory; `robots` has the robots' names, shape `[n_robots]`.
    pub fn new(
        trajectory: &Trajectory,
        bodies: &Bodies,
        (behaviour, has_commands): (Behaviour, bool),
        robots: &[String],
    ) -> anyhow::Result<Self> {
        let rules = behaviour.rules();
        let verdict = if has_commands {
            label_with(trajectory, bodies, &rules)
        } else {
            label_without_commands(trajectory, bodies, &rules)
        }?;
        let is_all_known = has_commands || !rules.need_commands();
        Ok(Self {
            phase: verdict.phase,
            evidence: verdict.evidence,
            certainty: is_all_known.then(|| Certainty::new(&verdict, &rules)),
            why: Reason::new(trajectory, bodies, &verdict, &rules).sentences(rules.wanted, robots),
            n_robots: verdict.n_robots,
            duration_s: verdict.duration_s,
            has_commands,
            label: None,
        })
    }

    pub fn of_bag(label: Labelled) -> Option<Self> {
        Some(Self {
            phase: label.phase,
            evidence: label.evidence?,
            certainty: label.certainty.clone(),
            why: label.why.clone(),
            n_robots: label.n_robots?,
            duration_s: label.duration_s?,
            has_commands: true,
            label: Some(Box::new(label)),
        })
    }
}

#[pymethods]
impl Verdict {
    /// The phase, by its name in files: "stable_milling".
    #[getter]
    fn phase(&self) -> &'static str {
        self.phase.key()
    }
    /// What the swarm was judged for: "milling".
    #[getter]
    fn behaviour(&self) -> &'static str {
        self.phase.behaviour().key()
    }
    /// Whether the phase is the one that the behaviour is named for.
    #[getter]
    fn is_wanted(&self) -> bool {
        self.phase == self.phase.behaviour().wanted()
    }
    /// The order parameters of the last 60 s.
    #[getter]
    fn order(&self) -> PyOrderParameters {
        PyOrderParameters::new(&self.evidence, self.has_commands)
    }
    /// Why it is this phase, a sentence each; empty for the wanted phase.
    #[getter]
    fn why(&self) -> Vec<String> {
        self.why.clone()
    }
    /// Whether the phase withstands a change of each order parameter by 0.05; None where commands that
    /// nobody knows would decide.
    #[getter]
    fn is_settled(&self) -> Option<bool> {
        self.certainty.as_ref().map(|certainty| certainty.is_settled)
    }
    /// Share of the 10 s blocks of the last 60 s that by themselves show the same phase, from 0 to 1.
    #[getter]
    fn confidence(&self) -> Option<f64> {
        self.certainty.as_ref().map(|certainty| certainty.confidence)
    }
    /// Number of robots.
    #[getter]
    fn n_robots(&self) -> usize {
        self.n_robots
    }
    /// Time that was recorded, in seconds.
    #[getter]
    fn duration_s(&self) -> f64 {
        self.duration_s
    }
    /// All of it, under the names of `rsrs label --format json`.
    fn as_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        if let Some(label) = &self.label {
            return to_python(py, label);
        }
        let Self { phase, certainty, why, n_robots, duration_s, .. } = self;
        let written =
            Written { phase: *phase, certainty, why, n_robots: *n_robots, duration_s: *duration_s };
        let dict = to_python(py, &written)?;
        dict.set_item("evidence", self.order().as_dict(py)?)?;
        Ok(dict)
    }
    fn __repr__(&self) -> String {
        let mut text =
            format!("{}: {} robots, {:.0} s", self.phase, self.n_robots, self.duration_s);
        let asked = self.phase.behaviour().rules().parameters();
        for (key, value) in self.order().named() {
            let is_shown = ["lost", "blocked", "rotation", "orbit", "circliness"].contains(&key)
                || asked.iter().any(|it| it.key() == key && *it != Parameter::STUCK);
            if let Some(value) = value.filter(|_| is_shown) {
                text += &format!(", {key} {value:.2}");
            }
        }
        match self.is_settled() {
            Some(false) => text += "; not settled: look again",
            Some(true) => text += "; settled",
            None => text += "; judged without commands",
        }
        let warning = self.label.as_ref().and_then(|label| warning(label.settledness()));
        if let Some(warning) = warning.filter(|_| self.is_settled() != Some(false)) {
            text += &format!("; {warning}");
        }
        format!("Verdict({text})")
    }
    fn __str__(&self) -> String {
        if let Some(label) = &self.label {
            return text(label).to_string();
        }
        let why = self.why.iter().map(|why| format!("\n  {why}"));
        why.fold(self.__repr__(), |text, why| text + &why)
    }
}

/// The behaviour of a name, or in a file.
pub fn behaviour(text: &str) -> PyResult<Behaviour> {
    source::behaviour(text).map_err(raised)
}

/// A length that is known and must be positive, in metres.
fn length(value: Option<f64>, name: &str) -> PyResult<Option<f64>> {
    match value {
        Some(length) if !(length > 0.0 && Bounds::SIZE.contains(length)) => {
            Err(refused(format!("{name} is {length}, expected metres {}", Bounds::SIZE)))
        }
        value => Ok(value),
    }
}

/// What is known of the robots and their arena; checked.
pub fn bodies(
    radius_m: Option<f64>,
    reach_m: Option<f64>,
    arena_m: Option<f64>,
) -> PyResult<Bodies> {
    Ok(Bodies {
        radius_m: length(radius_m, "radius_m")?,
        reach_m: length(reach_m, "reach_m")?,
        arena_m: length(arena_m, "arena_m")?,
        ..Bodies::UNKNOWN
    })
}
