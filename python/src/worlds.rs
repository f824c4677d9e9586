//! Worlds that take commands from Python, step by step.

use std::collections::VecDeque;
use std::sync::{Mutex, PoisonError};

use numpy::ndarray::{Array2, Array3};
use numpy::{IntoPyArray, PyArray1, PyArray2, PyArray3};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rsrs_core::conditions::Conditions;
use rsrs_core::conditions::limits::CommandRange;
use rsrs_core::judge::order::{OrderParameters, Parameter};
use rsrs_core::judge::trajectory::Trajectory;
use rsrs_core::judge::window::{BLOCK_S, samples_in};
use rsrs_core::quantity::Bounds;
use rsrs_core::robot::controller::Command;
use rsrs_core::robot::unicycle::Pose;
use rsrs_sim::worlds::Worlds;

use crate::arrays;
use crate::conditions::PyConditions;
use crate::error::{helped, our_mistake, refused};
use crate::runs::check_seed;

/// The most poses of all worlds together that are kept at once.
const MOST_POSES: usize = 50_000_000;

/// Worlds of the same conditions side by side, which take commands from outside, step by step.
///
/// Each passes through the states of `rsrs.episode` with its replicate, if its commands are those of that.
///
/// Parameters
/// ----------
/// conditions
///     What runs depend on; their controller does not count.
/// n_worlds
///     How many worlds; the first one is replicate `replicate` of the seed.
/// seed, replicate
///     As for `rsrs.episode`.
/// speed_m_s, turn_rate_rad_s
///     Least and greatest speed in metres per second, and turning rate in radians per second; those of the
///     robots' profile if not given. Commands are moved between them.
/// keep_s
///     How much of the past `order` and `margin` look at, in seconds: 10, as the judge's blocks; 0 keeps
///     nothing, and steps are several times quicker.
#[pyclass(name = "Worlds", module = "rsrs", frozen)]
pub struct PyWorlds {
    conditions: Conditions,
    n_worlds: usize,
    range: CommandRange,
    /// Samples that are kept.
    n_kept: usize,
    state: Mutex<State>,
}

/// Where the worlds are.
struct State {
    worlds: Worlds,
    step: u64,
    detections: Vec<bool>,
    commands: Vec<Command>,
    /// Poses and commands of all worlds, the oldest first.
    past: VecDeque<(Vec<Pose>, Vec<Command>)>,
}

impl State {
    /// The worlds at their start, sensed.
    fn new(of: &Worlded<'_>, seed: u64, replicate: u64) -> PyResult<Self> {
        let Worlded { conditions, n_worlds, range } = *of;
        let end = u64::try_from(n_worlds).ok().and_then(|n| replicate.checked_add(n));
        let end = end.ok_or_else(|| refused("replicate is beyond 2^64"))?;
        check_seed(seed)?;
        let worlds = Worlds::new(conditions, seed, replicate..end, range.most());
        let mut worlds = worlds.map_err(|error| helped(&error))?;
        let mut detections = vec![false; n_worlds * conditions.robots];
        worlds.sense(&mut detections);
        Ok(Self { worlds, step: 0, detections, commands: Vec::new(), past: VecDeque::new() })
    }

    fn advance(&mut self, n_kept: usize) {
        let Self { worlds, step, detections, commands, past } = self;
        if n_kept > 0 {
            if past.len() == n_kept {
                past.pop_front();
            }
            past.push_back((worlds.poses(), commands.clone()));
        }
        worlds.advance(commands);
        worlds.sense(detections);
        *step += 1;
    }
}

/// What worlds are made of.
#[derive(Clone, Copy)]
struct Worlded<'a> {
    conditions: &'a Conditions,
    n_worlds: usize,
    range: CommandRange,
}

impl PyWorlds {
    fn worlded(&self) -> Worlded<'_> {
        let Self { conditions, n_worlds, range, .. } = self;
        Worlded { conditions, n_worlds: *n_worlds, range: *range }
    }

    /// Looks at the worlds without the interpreter's lock.
    fn with<T: Send>(&self, py: Python<'_>, look: impl FnOnce(&mut State) -> T + Send) -> T {
        py.detach(|| look(&mut self.state.lock().unwrap_or_else(PoisonError::into_inner)))
    }

    fn detections<'py>(
        &self,
        py: Python<'py>,
        flat: Vec<bool>,
    ) -> PyResult<Bound<'py, PyArray2<bool>>> {
        let shape = (self.n_worlds, self.conditions.robots);
        Ok(Array2::from_shape_vec(shape, flat).map_err(our_mistake)?.into_pyarray(py))
    }

    /// The order parameters of what is kept, of every world.
    fn evidence(&self, py: Python<'_>) -> PyResult<Vec<OrderParameters>> {
        if self.n_kept == 0 {
            return Err(refused(
                "nothing is kept of the past: make the worlds with keep_s above 0",
            ));
        }
        let (n_robots, bodies) = (self.conditions.robots, self.conditions.bodies());
        let period_s = self.conditions.period_s;
        let n_worlds = self.n_worlds;
        let asked = self.conditions.behaviour.rules().parameters();
        let evidence = self.with(py, move |state| {
            let of_world = |world: usize| {
                let robots = world * n_robots..(world + 1) * n_robots;
                let mut trajectory = Trajectory::new(period_s, n_robots);
                for (poses, commands) in &state.past {
                    trajectory.poses.extend_from_slice(&poses[robots.clone()]);
                    trajectory.commands.extend_from_slice(&commands[robots.clone()]);
                }
                OrderParameters::with(&trajectory, 0..trajectory.n_samples(), &bodies, &asked)
            };
            (!state.past.is_empty()).then(|| (0..n_worlds).map(of_world).collect())
        });
        evidence.ok_or_else(|| refused("no step was made yet, so there is nothing to look at"))
    }
}

/// A range of commands; checked.
fn checked(range: Option<(f64, f64)>, usual: Option<[f64; 2]>, name: &str) -> PyResult<[f64; 2]> {
    let [least, most] = match (range, usual) {
        (Some((least, most)), _) => [least, most],
        (None, Some(usual)) => usual,
        (None, None) => {
            return Err(refused(format!(
                "no {name}: the least and the greatest, as no profile is known"
            )));
        }
    };
    if Bounds::SIGNED.contains(least) && Bounds::SIGNED.contains(most) && least <= most {
        Ok([least, most])
    } else {
        let expected = Bounds::SIGNED;
        Err(refused(format!(
            "{name} is from {least} to {most}, expected a range of numbers {expected}"
        )))
    }
}

#[pymethods]
impl PyWorlds {
    #[new]
    #[pyo3(signature = (conditions, n_worlds, *, seed=1, replicate=0, speed_m_s=None, turn_rate_rad_s=None,
                        keep_s=10.0))]
    fn new(
        py: Python<'_>,
        conditions: &PyConditions,
        n_worlds: usize,
        seed: u64,
        replicate: u64,
        speed_m_s: Option<(f64, f64)>,
        turn_rate_rad_s: Option<(f64, f64)>,
        keep_s: f64,
    ) -> PyResult<Self> {
        let PyConditions { conditions, range: usual } = conditions.clone();
        let one = conditions.robot.reading_names().refuse_further("worlds that are commanded give");
        one.map_err(|error| refused(error.to_string()))?;
        if n_worlds == 0 || conditions.robots == 0 {
            return Err(refused("no worlds or no robots, expected at least 1 of both"));
        }
        if !(0.0..=BLOCK_S).contains(&keep_s) {
            return Err(refused(format!(
                "keep_s is {keep_s}, expected seconds from 0 to {BLOCK_S}"
            )));
        }
        let n_kept = if keep_s > 0.0 { samples_in(keep_s, conditions.period_s) } else { 0 };
        let n_poses =
            n_worlds.checked_mul(conditions.robots).and_then(|n| n.checked_mul(n_kept + 1));
        if n_poses.is_none_or(|n| n > MOST_POSES) {
            return Err(refused(format!(
                "{n_worlds} worlds of {} robots, of which {n_kept} samples are kept, are too many: expected \
                 at most {MOST_POSES} poses; keep less with keep_s",
                conditions.robots
            )));
        }
        let range = CommandRange {
            speed_m_s: checked(speed_m_s, usual.map(|it| it.speed_m_s), "speed_m_s")?,
            turn_rate_rad_s: checked(
                turn_rate_rad_s,
                usual.map(|it| it.turn_rate_rad_s),
                "turn_rate_rad_s",
            )?,
            wheels: usual.and_then(|usual| usual.wheels),
        };
        let of = Worlded { conditions: &conditions, n_worlds, range };
        let state = Mutex::new(py.detach(|| State::new(&of, seed, replicate))?);
        Ok(Self { conditions, n_worlds, range, n_kept, state })
    }
    /// Places all robots anew, and returns what they detect, of shape (W, N): as new worlds would.
    #[pyo3(signature = (*, seed=1, replicate=0))]
    fn reset<'py>(
        &self,
        py: Python<'py>,
        seed: u64,
        replicate: u64,
    ) -> PyResult<Bound<'py, PyArray2<bool>>> {
        let new = py.detach(|| State::new(&self.worlded(), seed, replicate))?;
        let detections = self.with(py, |state| {
            *state = new;
            state.detections.clone()
        });
        self.detections(py, detections)
    }
    /// What the robots detect now: array of bool of shape (W, N).
    #[getter(detections)]
    fn detected<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<bool>>> {
        let detections = self.with(py, |state| state.detections.clone());
        self.detections(py, detections)
    }
    /// Moves all robots by one control period, and returns what they detect then, of shape (W, N).
    ///
    /// `commands` has shape (W, N, 2) or one that broadcasts to it: speed in metres per second and turning
    /// rate in radians per second. They are moved into their ranges; of wheels that would be too fast, the
    /// same circle is driven slower.
    fn step<'py>(
        &self,
        py: Python<'py>,
        commands: &Bound<'_, PyAny>,
    ) -> PyResult<Bound<'py, PyArray2<bool>>> {
        let shape = [self.n_worlds, self.conditions.robots, 2];
        let mut given = Vec::with_capacity(self.n_worlds * self.conditions.robots);
        arrays::commands_of_worlds(commands, shape, self.range, &mut given)?;
        let n_kept = self.n_kept;
        let detections = self.with(py, move |state| {
            state.commands = given;
            state.advance(n_kept);
            state.detections.clone()
        });
        self.detections(py, detections)
    }
    /// Where the robots are: array of shape (W, N, 3), x and y in metres and the heading in radians.
    #[getter]
    fn poses<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray3<f64>>> {
        let poses = self.with(py, |state| state.worlds.poses());
        let flat = poses.iter().flat_map(|it| [it.x_m, it.y_m, it.heading_rad]).collect();
        let shape = (self.n_worlds, self.conditions.robots, 3);
        Ok(Array3::from_shape_vec(shape, flat).map_err(our_mistake)?.into_pyarray(py))
    }
    /// The order parameters of what is kept of the past, by name, with those that the behaviour asks for:
    /// arrays of shape (W,); what is not known is NaN.
    fn order<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let evidence = self.evidence(py)?;
        let dict = PyDict::new(py);
        for parameter in Parameter::of_behaviour(self.conditions.behaviour) {
            let value = |it: &OrderParameters| parameter.value(it).unwrap_or(f64::NAN);
            let values: Vec<f64> = evidence.iter().map(value).collect();
            dict.set_item(parameter.key(), values.into_pyarray(py))?;
        }
        Ok(dict)
    }
    /// How far every world is from the wanted phase, by what is kept of its past: the least distance of an
    /// order parameter to its bound, negative where it is not kept; array of shape (W,).
    fn margin<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let rules = self.conditions.behaviour.rules();
        let evidence = self.evidence(py)?;
        let margins: Vec<f64> = evidence.iter().map(|it| rules.wanted_margin(it)).collect();
        Ok(margins.into_pyarray(py))
    }
    /// Number of worlds.
    #[getter]
    fn n_worlds(&self) -> usize {
        self.n_worlds
    }
    /// Number of robots in each.
    #[getter]
    fn n_robots(&self) -> usize {
        self.conditions.robots
    }
    /// Steps that were made since the start.
    #[getter]
    fn step_index(&self, py: Python<'_>) -> u64 {
        self.with(py, |state| state.step)
    }
    /// Time from one step to the next, in seconds.
    #[getter]
    fn period_s(&self) -> f64 {
        self.conditions.period_s
    }
    /// Least and greatest speed, in metres per second, and least and greatest turning rate, in radians per
    /// second.
    #[getter]
    fn command_range(&self) -> [[f64; 2]; 2] {
        [self.range.speed_m_s, self.range.turn_rate_rad_s]
    }
    fn __len__(&self) -> usize {
        self.n_worlds
    }
    fn __repr__(&self, py: Python<'_>) -> String {
        let step = self.with(py, |state| state.step);
        format!(
            "Worlds({} worlds of {} robots, after {step} steps)",
            self.n_worlds, self.conditions.robots
        )
    }
}
