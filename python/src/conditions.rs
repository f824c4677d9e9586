//! Conditions: everything that an outcome depends on.

use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};
use rsrs_core::conditions::Conditions;
use rsrs_core::conditions::limits::CommandRange;
use rsrs_core::robot::controller::decide;
use rsrs_core::robot::profile::RobotProfile;

use crate::error::{our_mistake, raised, refused};
use crate::json::to_python;
use crate::keys::of_keys;

/// Everything that a run depends on, the paper's `E`, as numbers: robots, controller, start, arena.
///
/// Parameters
/// ----------
/// profile
///     The measured robots: a Profile, or a path.
/// harsher
///     Whether they are made worse, as a sweep simulates them; or the factors, as in a sweep file.
/// behaviour
///     What the swarm is judged for.
/// placement
///     Where robots start, as in a sweep file: {"kind": "box_facing_out", "width_m": 2, "height_m": 2}.
/// walls
///     What happens at the border of the arena: "none", "clamp" or "stop".
/// **axes
///     Values by axis, as in a sweep file: at least `robots`, `speed_m_s` and `turn_rate_rad_s`.
#[pyclass(name = "Conditions", module = "rsrs", frozen, eq)]
#[derive(Clone)]
pub struct PyConditions {
    pub conditions: Conditions,
    /// What the robots may be commanded; not there where their profile is not.
    pub range: Option<CommandRange>,
}

impl PyConditions {
    /// Conditions of robots with a profile.
    pub fn new(conditions: Conditions, profile: &RobotProfile) -> Self {
        Self { conditions, range: Some(CommandRange::new(profile)) }
    }
}

/// What robots may be commanded is no part of the conditions, as they are compared.
impl PartialEq for PyConditions {
    fn eq(&self, other: &Self) -> bool {
        self.conditions == other.conditions
    }
}

#[pymethods]
impl PyConditions {
    #[new]
    #[pyo3(signature = (profile, *, harsher=None, behaviour=None, placement=None, walls=None, **axes))]
    fn from_axes(
        py: Python<'_>,
        profile: &Bound<'_, PyAny>,
        harsher: Option<&Bound<'_, PyAny>>,
        behaviour: Option<&str>,
        placement: Option<&Bound<'_, PyAny>>,
        walls: Option<&str>,
        axes: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        // A sweep of a single cell: what a file may have is checked where that of a file is.
        let keys = PyDict::new(py);
        let cell = axes.cloned().unwrap_or_else(|| PyDict::new(py));
        keys.set_item("profile", profile)?;
        keys.set_item("cells", [cell])?;
        keys.set_item("duration_s", 60)?;
        keys.set_item("seed", 0)?;
        let is_made_worse = harsher.and_then(|it| it.extract::<bool>().ok());
        if let (Some(factors), None) = (harsher, is_made_worse) {
            keys.set_item("harsher", factors)?;
        }
        if let Some(behaviour) = behaviour {
            keys.set_item("behaviour", behaviour)?;
        }
        if let Some(placement) = placement {
            keys.set_item("placement", placement)?;
        }
        if let Some(walls) = walls {
            let fixed = PyDict::new(py);
            fixed.set_item("walls", walls)?;
            keys.set_item("fixed", fixed)?;
        }
        let source = of_keys("Conditions", &keys)?.map_err(raised)?;
        let measured = (is_made_worse == Some(false)).then(|| source.as_measured()).flatten();
        let source = measured.unwrap_or(source);
        let cells = source.cells("Conditions");
        let (_, conditions) = cells.map_err(raised)?.swap_remove(0);
        Ok(Self::new(conditions, &source.profile))
    }
    /// Conditions that were written by `to_json`.
    #[staticmethod]
    fn from_json(text: &str) -> PyResult<Self> {
        let conditions: Conditions = serde_json::from_str(text).map_err(refused)?;
        conditions.check().map_err(refused)?;
        Ok(Self { conditions, range: None })
    }
    /// All numbers as text, to the bit.
    fn to_json(&self) -> PyResult<String> {
        serde_json::to_string(&self.conditions).map_err(our_mistake)
    }
    /// All numbers.
    fn as_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        to_python(py, &self.conditions)
    }
    /// Number of robots.
    #[getter]
    fn n_robots(&self) -> usize {
        self.conditions.robots
    }
    /// Control period, in seconds.
    #[getter]
    fn period_s(&self) -> f64 {
        self.conditions.period_s
    }
    /// Radius of a robot's body, in metres.
    #[getter]
    fn radius_m(&self) -> f64 {
        self.conditions.robot.radius_m
    }
    /// How far from its centre a robot senses the centre of another, in metres.
    #[getter]
    fn reach_m(&self) -> Option<f64> {
        self.conditions.bodies().reach_m
    }
    /// What the swarm is judged for.
    #[getter]
    fn behaviour(&self) -> &'static str {
        self.conditions.behaviour.key()
    }
    /// Names the conditions, by 16 hexadecimal digits: equal ones have equal runs.
    #[getter]
    fn digest(&self) -> String {
        format!("{:016x}", self.conditions.digest())
    }
    /// Least and greatest speed, in metres per second, and least and greatest turning rate, in radians per
    /// second, that the robots may be commanded from outside; None where their profile is not known.
    #[getter]
    fn command_range(&self) -> Option<[[f64; 2]; 2]> {
        self.range.map(|range| [range.speed_m_s, range.turn_rate_rad_s])
    }
    fn __reduce__<'py>(
        slf: &Bound<'py, Self>,
    ) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyTuple>)> {
        let text = slf.get().to_json()?;
        Ok((slf.getattr("from_json")?, PyTuple::new(slf.py(), [text])?))
    }
    fn __repr__(&self) -> String {
        let Conditions { robots, controller, period_s, behaviour, .. } = &self.conditions;
        let decides = match controller.parameters() {
            Some(parameters) => {
                let (seen, not) = (decide(true, parameters), decide(false, parameters));
                format!(
                    "{} m/s and {} rad/s where something is detected, {} m/s and {} rad/s where nothing is",
                    seen.speed_m_s, seen.turn_rate_rad_s, not.speed_m_s, not.turn_rate_rad_s
                )
            }
            None => "a controller with states".to_owned(),
        };
        format!("Conditions({robots} robots, {behaviour}; {decides}; period {period_s} s)")
    }
}
