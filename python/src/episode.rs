//! One simulated run.

use numpy::PyArray1;
use pyo3::prelude::*;
use rsrs_core::conditions::{Conditions, MOST_DURATION_S};
use rsrs_sim::controllers::Controllers;
use rsrs_sim::draw::Seed;
use rsrs_sim::episode::{Observed, run_controlled};
use rsrs_sim::world::World;

use crate::arrays;
use crate::conditions::PyConditions;
use crate::error::{helped, refused};
use crate::runs::check_seed;
use crate::trajectory::PyTrajectory;
use crate::waiting::{Progress, work};

/// The most poses of one run: what is more fills the memory of many a machine.
const MOST_POSES: f64 = 5e7;

/// Simulates one run: the replicate of a sweep with this cell, seed and number, to the bit.
///
/// Parameters
/// ----------
/// conditions
///     What the run depends on: `rsrs.Conditions(...)`, or `sweep.conditions(cell)`.
/// seed
///     Seed of the draws, below 2^63.
/// replicate
///     Which of the runs with this seed, from 0.
/// duration_s
///     Simulated time, in seconds; at most a week, and 5e7 poses.
/// controller
///     A function in place of the conditions' controller. In each period it is called with the detections of
///     all robots, an array of bool of shape (N,), and returns their commands, of shape (N, 2) or one that
///     broadcasts to it: speed in metres per second and turning rate in radians per second.
#[pyfunction]
#[pyo3(signature = (conditions, *, seed=1, replicate=0, duration_s=300.0, controller=None))]
pub fn episode(
    py: Python<'_>,
    conditions: &PyConditions,
    seed: u64,
    replicate: u64,
    duration_s: f64,
    controller: Option<&Bound<'_, PyAny>>,
) -> PyResult<PyTrajectory> {
    simulated(py, conditions, Seed { seed, replicate }, duration_s, controller)
}

/// One run, under the conditions' controller or a function.
pub fn simulated(
    py: Python<'_>,
    conditions: &PyConditions,
    seed: Seed,
    duration_s: f64,
    controller: Option<&Bound<'_, PyAny>>,
) -> PyResult<PyTrajectory> {
    let conditions = &conditions.conditions;
    check(conditions, seed, duration_s)?;
    let world = World::new(conditions, seed).map_err(|error| helped(&error))?;
    let observed = match controller {
        None => work(py, Some(1), &Progress::None, |execution| {
            let cancel = execution.observer.cancel();
            let mut controllers = Controllers::new(conditions, seed);
            run_controlled(world, conditions, duration_s, |readings, commands| {
                controllers.decide(readings, commands);
                let is_over = cancel.load(std::sync::atomic::Ordering::Relaxed);
                if is_over { Err(anyhow::anyhow!("interrupted")) } else { Ok(()) }
            })
        })?,
        Some(controller) => {
            let names = conditions.robot.reading_names();
            let one = names.refuse_further("a function in place of their controller is given");
            one.map_err(|error| refused(error.to_string()))?;
            run_controlled(world, conditions, duration_s, |readings, commands| {
                py.check_signals()?;
                let detected: Vec<bool> = readings.iter().map(|it| it.detection()).collect();
                let answer = controller.call1((PyArray1::from_vec(py, detected),))?;
                arrays::commands(&answer, readings.len(), commands)
            })?
        }
    };
    let Observed { trajectory, detections } = observed;
    let robots = (1..=conditions.robots).map(|robot| format!("robot_{robot}")).collect();
    let known = (conditions.bodies(), conditions.behaviour);
    PyTrajectory::new(py, &trajectory, Some(detections), robots, known)
}

/// Checks what would fill the memory before anything is allocated.
fn check(conditions: &Conditions, seed: Seed, duration_s: f64) -> PyResult<()> {
    if !(0.0..=MOST_DURATION_S).contains(&duration_s) {
        return Err(refused(format!(
            "duration_s is {duration_s}, expected seconds from 0 to {MOST_DURATION_S}"
        )));
    }
    if conditions.robots == 0 {
        return Err(refused("robots is 0, expected at least 1"));
    }
    let n_poses = conditions.steps(duration_s) as f64 * conditions.robots as f64;
    if n_poses > MOST_POSES {
        return Err(refused(format!(
            "{duration_s} s of {} robots are {n_poses:e} poses, expected at most {MOST_POSES:e}",
            conditions.robots
        )));
    }
    check_seed(seed.seed)
}
