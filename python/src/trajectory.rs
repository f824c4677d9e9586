//! What a swarm did: simulated, or out of a bag.

use numpy::{PyArray2, PyArray3};
use pyo3::prelude::*;
use rsrs_core::judge::behaviour::Behaviour;
use rsrs_core::judge::trajectory::{Bodies, Trajectory};

use crate::arrays;
use crate::verdict::{self, Verdict};
use crate::waiting::work_to_end;

/// What a swarm did, sample by sample: poses, commands and, of simulated robots, detections.
///
/// Arrays cannot be written to; `array.copy()` can.
#[pyclass(name = "Trajectory", module = "rsrs", frozen)]
pub struct PyTrajectory {
    poses: Py<PyArray3<f64>>,
    commands: Py<PyArray3<f64>>,
    detections: Option<Py<PyArray2<bool>>>,
    n_objects: usize,
    objects_m: Vec<[f64; 2]>,
    robots: Vec<String>,
    period_s: f64,
    n_samples: usize,
    bodies: Bodies,
    behaviour: Behaviour,
}

impl PyTrajectory {
    /// A trajectory of robots of these names, with what is known of them; `detections` in the order of the
    /// poses.
    pub fn new(
        py: Python<'_>,
        trajectory: &Trajectory,
        detections: Option<Vec<bool>>,
        robots: Vec<String>,
        (bodies, behaviour): (Bodies, Behaviour),
    ) -> PyResult<Self> {
        let (n_samples, n_robots) = (trajectory.n_samples(), trajectory.n_robots);
        let poses = trajectory.poses.iter().flat_map(|it| [it.x_m, it.y_m, it.heading_rad]);
        let commands = trajectory.commands.iter().flat_map(|it| [it.speed_m_s, it.turn_rate_rad_s]);
        let detections = detections.map(|flat| arrays::array2(py, (n_samples, n_robots), flat));
        Ok(Self {
            poses: arrays::array3(py, (n_samples, n_robots, 3), poses.collect())?,
            commands: arrays::array3(py, (n_samples, n_robots, 2), commands.collect())?,
            detections: detections.transpose()?,
            n_objects: trajectory.n_objects,
            objects_m: trajectory.objects_m.clone(),
            robots,
            period_s: trajectory.period_s,
            n_samples,
            bodies,
            behaviour,
        })
    }

    /// The verdict, with other bodies or another behaviour where they are given.
    pub fn verdict(
        &self,
        py: Python<'_>,
        bodies: Bodies,
        behaviour: Option<Behaviour>,
    ) -> PyResult<Verdict> {
        let (poses, commands) = (self.poses.bind(py), self.commands.bind(py));
        let mut trajectory = arrays::trajectory(poses, Some(commands), self.period_s)?;
        (trajectory.n_objects, trajectory.objects_m) = (self.n_objects, self.objects_m.clone());
        let bodies = Bodies {
            radius_m: bodies.radius_m.or(self.bodies.radius_m),
            reach_m: bodies.reach_m.or(self.bodies.reach_m),
            arena_m: bodies.arena_m.or(self.bodies.arena_m),
            world: self.bodies.world.clone(),
            classes: self.bodies.classes.clone(),
        };
        let (behaviour, robots) = (behaviour.unwrap_or(self.behaviour), self.robots.clone());
        work_to_end(py, move || Verdict::new(&trajectory, &bodies, (behaviour, true), &robots))
    }
}

#[pymethods]
impl PyTrajectory {
    /// Array of shape (T, N, 3): x and y in metres, and the heading in radians.
    #[getter]
    fn poses<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray3<f64>> {
        self.poses.bind(py).clone()
    }
    /// Array of shape (T, N, 2): speed in metres per second and turning rate in radians per second.
    /// Command k answers pose k.
    #[getter]
    fn commands<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray3<f64>> {
        self.commands.bind(py).clone()
    }
    /// Array of shape (T, N): whether a robot detected something; None of a bag.
    #[getter]
    fn detections<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray2<bool>>> {
        self.detections.as_ref().map(|detections| detections.bind(py).clone())
    }
    /// Array of shape (T, O, 2): where the objects of the world are, x and y in metres; O is 0 where there are none.
    #[getter]
    fn objects<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray3<f64>>> {
        let flat = self.objects_m.as_flattened().to_vec();
        Ok(arrays::array3(py, (self.n_samples, self.n_objects, 2), flat)?.into_bound(py))
    }
    /// The robots' names, in the order of the arrays.
    #[getter]
    fn robots(&self) -> Vec<String> {
        self.robots.clone()
    }
    /// Time from one sample to the next, in seconds.
    #[getter]
    fn period_s(&self) -> f64 {
        self.period_s
    }
    /// Recorded time, in seconds.
    #[getter]
    fn duration_s(&self) -> f64 {
        self.n_samples as f64 * self.period_s
    }
    /// Radius of a robot's body, in metres, if it is known.
    #[getter]
    fn radius_m(&self) -> Option<f64> {
        self.bodies.radius_m
    }
    /// How far from its centre a robot senses the centre of another, in metres, if it is known.
    #[getter]
    fn reach_m(&self) -> Option<f64> {
        self.bodies.reach_m
    }
    /// What the swarm is judged for.
    #[getter]
    fn behaviour(&self) -> &'static str {
        self.behaviour.key()
    }
    /// Judges what the swarm settled into; what is given stands in for what is known of the robots, as for
    /// `rsrs.judge`.
    #[pyo3(signature = (*, radius_m=None, reach_m=None, behaviour=None))]
    fn judge(
        &self,
        py: Python<'_>,
        radius_m: Option<f64>,
        reach_m: Option<f64>,
        behaviour: Option<&str>,
    ) -> PyResult<Verdict> {
        let bodies = verdict::bodies(radius_m, reach_m, None)?;
        self.verdict(py, bodies, behaviour.map(verdict::behaviour).transpose()?)
    }
    fn __len__(&self) -> usize {
        self.n_samples
    }
    fn __repr__(&self) -> String {
        format!(
            "Trajectory({} samples of {} robots, {:.0} s at {} s)",
            self.n_samples,
            self.robots.len(),
            self.duration_s(),
            self.period_s
        )
    }
}
