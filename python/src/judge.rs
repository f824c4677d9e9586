//! The judge, over arrays, a trajectory or a bag.

use std::path::PathBuf;

use pyo3::prelude::*;
use rsrs_core::quantity::Bounds;
use rsrs_pipeline::label::{GivenBodies, LabelOptions, label_bag};

use crate::arrays;
use crate::error::refused;
use crate::trajectory::PyTrajectory;
use crate::verdict::{self, Verdict};
use crate::waiting::work_to_end;

/// Judges what a swarm settled into, from its poses or from a bag.
///
/// The last 60 s are judged, by the rules of `rsrs label`: the same code, the same bits.
///
/// Parameters
/// ----------
/// poses
///     Array of shape (T, N, 3): T samples of N robots, each with x and y in metres and the heading in
///     radians (counterclockwise from x). Or a Trajectory, a Bag, or the path of a bag
///     (a rosbag2 folder or an .mcap file), which has all of what follows itself.
/// commands
///     What the robots were commanded, of shape (T, N, 2) or one that broadcasts to it: speed in metres and
///     turning rate in radians per second; (0.15, 0.75) is one command for all. Command k answers pose k.
///     Without commands only what does not depend on them is judged: that a swarm disperses, aggregates or
///     spreads out, but not whether a ring runs or is jammed.
/// period_s
///     Time from one sample to the next, in seconds, from 0.001 to 2.
/// radius_m
///     Radius of a robot's body, in metres; needed for aggregation.
/// reach_m
///     How far from its centre a robot senses the centre of another, in metres; needed for milling and
///     dispersal.
/// arena_m
///     Side of the square arena around the origin that walls enclose, in metres; needed by a behaviour that asks
///     for coverage.
/// behaviour
///     What to judge it for: "milling" (default), "aggregation" or "dispersal", or the path of a behaviour's file.
///
/// Raises
/// ------
/// RsrsError
///     If the arrays are of another shape or not finite, if less than 60 s were recorded, or if something
///     that decides is not known; the phases between which it decides are named.
#[pyfunction]
#[pyo3(signature = (poses, *, commands=None, period_s=None, radius_m=None, reach_m=None, arena_m=None, behaviour=None))]
#[expect(clippy::too_many_arguments, reason = "in Python they have names")]
pub fn judge(
    py: Python<'_>,
    poses: &Bound<'_, PyAny>,
    commands: Option<&Bound<'_, PyAny>>,
    period_s: Option<f64>,
    radius_m: Option<f64>,
    reach_m: Option<f64>,
    arena_m: Option<f64>,
    behaviour: Option<&str>,
) -> PyResult<Verdict> {
    let wanted = behaviour.map(verdict::behaviour).transpose()?;
    let bodies = verdict::bodies(radius_m, reach_m, arena_m)?;
    if let Ok(trajectory) = poses.cast::<PyTrajectory>() {
        if commands.is_some() || period_s.is_some() {
            return Err(refused("a trajectory has its own commands and period; give neither"));
        }
        return trajectory.get().verdict(py, bodies, wanted);
    }
    let is_path = poses.is_instance_of::<pyo3::types::PyString>() || poses.hasattr("__fspath__")?;
    if is_path {
        if commands.is_some() || period_s.is_some() {
            return Err(refused("a bag has its own commands and period; give neither"));
        }
        let path: PathBuf = poses.extract()?;
        let is_given = radius_m.is_some() || reach_m.is_some();
        let options = LabelOptions {
            bodies: is_given.then_some(GivenBodies { radius_m, reach_m, arena_m }),
            behaviour: wanted,
            ..LabelOptions::default()
        };
        let label = work_to_end(py, move || label_bag(&path, options))?;
        return Verdict::of_bag(label).ok_or_else(|| refused("the bag has a person's label only"));
    }
    let Some(period_s) = period_s else {
        return Err(refused("no period_s: the time from one sample to the next, in seconds"));
    };
    if !Bounds::PERIOD.contains(period_s) {
        return Err(refused(format!(
            "period_s is {period_s}, expected seconds {}",
            Bounds::PERIOD
        )));
    }
    let trajectory = arrays::trajectory(poses, commands, period_s)?;
    let has_commands = commands.is_some();
    let behaviour = wanted.unwrap_or_default();
    work_to_end(py, move || {
        let robots: Vec<String> =
            (0..trajectory.n_robots).map(|robot| format!("robot {robot}")).collect();
        Verdict::new(&trajectory, &bodies, (behaviour, has_commands), &robots)
    })
}
