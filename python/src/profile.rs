//! Profiles: what was measured of a kind of robot.

use std::path::PathBuf;

use pyo3::prelude::*;
use rsrs_core::robot::harsher::{Harsher, HarsherFactors};
use rsrs_core::robot::profile::{ProfileError, RobotProfile};
use rsrs_pipeline::files::write_file;
use rsrs_pipeline::sweep::source::read_profile;

use crate::error::{helped, raised, refused};
use crate::json::{keys_as_text, to_python};

/// A robot as it was measured: `rsrs.Profile.load("flockbot.yaml")`, or from the text of such a file.
#[pyclass(name = "Profile", module = "rsrs", frozen, eq)]
#[derive(Clone, PartialEq)]
pub struct Profile(pub RobotProfile);

#[pymethods]
impl Profile {
    /// Reads the text of a profile, YAML or JSON.
    #[new]
    pub fn new(text: &str) -> PyResult<Self> {
        RobotProfile::parse("Profile", text).map(Self).map_err(|error| match error {
            error @ (ProfileError::Document(_) | ProfileError::SensorAt { .. }) => helped(&error),
            error => refused(format!("this does not describe a robot: {error}")),
        })
    }
    /// Reads the file of a profile.
    #[staticmethod]
    fn load(path: PathBuf) -> PyResult<Self> {
        read_profile(&path).map(Self).map_err(raised)
    }
    /// Writes the profile into a file, as YAML.
    fn save(&self, path: PathBuf) -> PyResult<()> {
        write_file(&path, self.to_yaml().as_bytes()).map_err(raised)
    }
    /// The profile as YAML.
    pub fn to_yaml(&self) -> String {
        self.0.to_yaml()
    }
    /// The name of the kind of robot.
    #[getter]
    fn name(&self) -> &str {
        &self.0.name
    }
    /// Radius of the body, in metres.
    #[getter]
    fn radius_m(&self) -> f64 {
        self.0.body.radius_m
    }
    /// How far from its centre a robot senses the centre of another, in metres.
    #[getter]
    fn reach_m(&self) -> f64 {
        self.0.reach_m()
    }
    /// Control period, in seconds.
    #[getter]
    fn period_s(&self) -> f64 {
        self.0.computation.period_s
    }
    /// Names the profile: equal ones have equal digests.
    #[getter]
    fn digest(&self) -> String {
        self.0.digest()
    }
    /// The robot made worse, as a sweep simulates it: by the factors that follow from it, but for those that
    /// are given (`miss_factor=5`; see `harsher` in `docs/reference.md`).
    #[pyo3(signature = (**factors))]
    fn harsher(&self, factors: Option<&Bound<'_, pyo3::types::PyDict>>) -> PyResult<Self> {
        let harsher: Harsher = match factors {
            Some(factors) => serde_json::from_str(&keys_as_text(factors)?).map_err(refused)?,
            None => Harsher::default(),
        };
        let factors: HarsherFactors = harsher.factors(&self.0);
        factors.apply(&self.0).map(Self).map_err(refused)
    }
    /// All numbers, under the names of the file.
    fn as_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        to_python(py, &self.0)
    }
    fn __getnewargs__(&self) -> (String,) {
        (self.to_yaml(),)
    }
    fn __repr__(&self) -> String {
        let RobotProfile { name, body, actuation, .. } = &self.0;
        let [_, most_m_s] = actuation.speed.limits_m_s;
        let [_, most_rad_s] = actuation.turn.limits_rad_s;
        format!(
            "Profile({name}: radius {} m, reach {:.3} m, up to {most_m_s} m/s and {most_rad_s} rad/s, period \
             {} s)",
            body.radius_m,
            self.reach_m(),
            self.period_s()
        )
    }
}
