//! What a swarm can do beyond a given controller.

use std::path::{Path, PathBuf};

use pyo3::prelude::*;
use rsrs_core::conditions::Walls;
use rsrs_pipeline::explore::{self, CONTROLLERS, DURATION_S, ExploreOptions, Files, REPLICATES};
use rsrs_render::explored;
use rsrs_sim::exploration::space::Directions;

use crate::answers::source;
use crate::error::{raised, refused};
use crate::json::to_python;
use crate::runs::{check_seed, runs};
use crate::verdict;
use crate::waiting::{Progress, work};

// Python's help shows numbers in signatures, and no names of constants.
const _: () = assert!(CONTROLLERS == 2000 && REPLICATES == 16);
const _: () = assert!(DURATION_S.to_bits() == 300_f64.to_bits());

/// What a search for controllers found, in a folder with a gallery of it.
#[pyclass(name = "Explored", module = "rsrs", frozen)]
pub struct Explored(explore::Explored);

#[pymethods]
impl Explored {
    /// The folder, with `gallery.html`.
    #[getter]
    fn folder(&self) -> &Path {
        &self.0.folder
    }
    /// Whether the behaviour that was searched for was found: surely in more than half of the runs.
    #[getter]
    fn is_found(&self) -> bool {
        self.0.is_found()
    }
    /// The controllers, each with what it is called, its commands, and the share of fresh runs that show it.
    #[getter]
    fn found<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        to_python(py, &self.0.found)
    }
    /// All of it, under the names of `rsrs explore --format json`.
    fn as_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        to_python(py, &self.0)
    }
    fn __repr__(&self) -> String {
        let explore::Explored { robot, n_controllers, found, folder, .. } = &self.0;
        let names: Vec<&str> = found.iter().map(|found| found.name.as_str()).collect();
        let found = if names.is_empty() { "nothing".to_owned() } else { names.join(", ") };
        format!(
            "Explored({robot}: {found} among {n_controllers} controllers, in {})",
            folder.display()
        )
    }
    fn __str__(&self) -> String {
        explored::text(&self.0).to_string()
    }
}

/// What happens at the border of the arena.
fn walls(key: &str) -> PyResult<Walls> {
    match key {
        "none" => Ok(Walls::None),
        "clamp" => Ok(Walls::Clamp),
        "stop" => Ok(Walls::Stop),
        _ => Err(refused(format!("unknown walls `{key}`, expected none, clamp or stop"))),
    }
}

/// Most controllers of one search.
const MOST_CONTROLLERS: usize = 1_000_000;

/// Searches for controllers, for a behaviour or for all that differ, and writes a gallery of what was found.
///
/// A search that was interrupted goes on in its folder with the same call.
///
/// Parameters
/// ----------
/// profile
///     Of the robots, by path or as a Profile; they are made worse by the usual factors.
/// output
///     Folder for what is found.
/// behaviour
///     What to search for; all that differ if not given.
/// controller
///     File of a controller's table, whose numbers are searched within their bounds in place of two commands.
/// world_file
///     File of a world: what is in the arena besides robots; beside `arena_m`, unless it has an arena of its own.
/// starts
///     Table of poses where robots start, of which replicate k takes set k; in a disc, facing away from its centre, if
///     not given.
/// robots
///     Number of robots; that of `fleet.yaml` beside the profile, or 9, if not given.
/// arena_m
///     Side of the square arena, in metres; 22 radii of a robot's body times the root of their number if not given.
/// walls
///     What happens at its border: "none", "clamp" (robots slide along it) or "stop".
/// forward
///     Whether controllers never drive backward.
/// controllers, replicates
///     How many controllers are tried, up to 1,000,000, in how many runs each, up to 100,000.
/// duration_s
///     Simulated time of each run, in seconds.
/// seed
///     Seed of the search and of its runs, below 2^63.
#[pyfunction]
#[pyo3(name = "explore")]
#[pyo3(signature = (profile, output, *, behaviour=None, controller=None, world_file=None, starts=None,
                    robots=None, arena_m=None, walls="stop", forward=false, controllers=2000, replicates=16, duration_s=300.0,
                    seed=1, threads=None, progress=None))]
pub fn explore_all(
    py: Python<'_>,
    profile: &Bound<'_, PyAny>,
    output: PathBuf,
    behaviour: Option<&str>,
    controller: Option<PathBuf>,
    world_file: Option<PathBuf>,
    starts: Option<PathBuf>,
    robots: Option<usize>,
    arena_m: Option<f64>,
    walls: &str,
    forward: bool,
    controllers: usize,
    replicates: u64,
    duration_s: f64,
    seed: u64,
    threads: Option<usize>,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<Explored> {
    let profile = source(profile)?;
    let wanted = behaviour.map(verdict::behaviour).transpose()?;
    let walls = self::walls(walls)?;
    if !(1..=MOST_CONTROLLERS).contains(&controllers) {
        return Err(refused(format!(
            "controllers is {controllers}, expected from 1 to {MOST_CONTROLLERS}"
        )));
    }
    if runs("replicates", replicates)? > 100_000 {
        return Err(refused(format!("replicates is {replicates}, expected from 1 to 100000")));
    }
    check_seed(seed)?;
    if forward && controller.is_some() {
        return Err(refused(
            "`forward` is of two commands, and the controller's table has its own",
        ));
    }
    let files = Files {
        controller: controller.as_deref(),
        world: world_file.as_deref(),
        starts: starts.as_deref(),
    };
    let read = files.read(&profile.path, robots, arena_m).map_err(raised)?;
    if read.needs_arena() && arena_m.is_none() {
        return Err(refused(
            "the world has no arena of its own, and there is no `arena_m`: give the side of a square in metres",
        ));
    }
    let progress = Progress::new(progress)?;
    work(py, threads, &progress, |execution| {
        let options = ExploreOptions {
            wanted,
            controller: read.controller.as_ref(),
            world: read.world.as_ref(),
            starts: read.starts.as_ref(),
            robots: read.robots,
            arena_m,
            walls,
            directions: if forward { Directions::Forward } else { Directions::Both },
            controllers,
            replicates,
            duration_s,
            seed,
            execution,
        };
        let found = explore::explore(&profile.path, &output, &options)?;
        explored::draw(&found)?;
        Ok(found)
    })
    .map(Explored)
}
