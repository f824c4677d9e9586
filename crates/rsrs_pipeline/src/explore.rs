//! What a swarm of these robots can do: controllers beyond the given one, found and laid out.
//!
//! Two searches go through the same simulations: one for a behaviour, one for all that differ. Whatever
//! is tried is judged, written into a journal, and offered to the archive, from which the gallery is
//! made. A search follows from its settings alone, so it goes on where it was interrupted.

mod file_names;
mod folder;
mod gallery;
mod journal;
pub mod judge;
mod search;
mod settings;
mod space;
mod trial;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use rsrs_core::conditions::controller_table::ControllerTable;
use rsrs_core::conditions::start_file::read_starts;
use rsrs_core::conditions::{Placement, Walls};
use rsrs_core::judge::behaviour::Behaviour;
use rsrs_core::judge::phase::Phase;
use rsrs_core::judge::trajectory::Trajectory;
use rsrs_core::robot::contact::ContactModel;
use rsrs_core::robot::controller::Controller;
use rsrs_core::world::WorldFile;
use rsrs_sim::exploration::niche::Niche;
use rsrs_sim::exploration::space::Directions;
use serde::Serialize;

use crate::error::helped;
use crate::execution::Execution;
use crate::files::read_text;
use crate::sweep::source::{read_controller, read_profile, read_world, robots_beside};
use folder::Folder;
use settings::settings;
use trial::TestBed;

/// What is searched for, with which robots.
#[derive(Clone, Copy)]
pub struct ExploreOptions<'a> {
    /// A behaviour, or all that differ.
    pub wanted: Option<Behaviour>,
    /// The table whose numbers are searched, checked for these robots; `None` for two commands.
    pub controller: Option<&'a ControllerTable>,
    /// What is in the arena besides the robots; `None` is nothing.
    pub world: Option<&'a WorldFile>,
    /// Where robots start; `None` is a disc, facing away from its centre.
    pub starts: Option<&'a StartTable>,
    /// Number of robots; at least 1.
    pub robots: usize,
    /// Side of the square arena, in metres; `None` is that of the world's own arena, or of 500 squares of a body's radius
    /// for each robot.
    pub arena_m: Option<f64>,
    /// What happens at its border.
    pub walls: Walls,
    /// In which directions robots may drive.
    pub directions: Directions,
    /// Controllers that are tried; at least 1.
    pub controllers: usize,
    /// Runs of each of them; at least 1.
    pub replicates: u64,
    /// Simulated time of each run, in seconds.
    pub duration_s: f64,
    /// Seed of the search and of its runs.
    pub seed: u64,
    /// On how many threads, watched by whom.
    pub execution: Execution<'a>,
}

/// Files of a search besides the profile.
#[derive(Clone, Copy, Debug, Default)]
pub struct Files<'a> {
    /// Of a controller's table.
    pub controller: Option<&'a Path>,
    /// Of a world.
    pub world: Option<&'a Path>,
    /// Of a table of start poses.
    pub starts: Option<&'a Path>,
}

/// What is read of them.
#[derive(Clone, Debug)]
pub struct Read {
    /// Number of robots.
    pub robots: usize,
    /// The table whose numbers are searched.
    pub controller: Option<ControllerTable>,
    /// What is in the arena besides the robots.
    pub world: Option<WorldFile>,
    /// Where robots start.
    pub starts: Option<StartTable>,
}

impl Files<'_> {
    /// Reads the files of a search for robots with this profile, in a square arena with sides of
    /// `arena_m` metres.
    ///
    /// Without a number of robots it is that of `fleet.yaml` beside the profile, or [`ROBOTS`].
    pub fn read(
        &self,
        profile: &Path,
        robots: Option<usize>,
        arena_m: Option<f64>,
    ) -> anyhow::Result<Read> {
        let robots = match robots {
            Some(robots) => robots,
            None => robots_beside(profile)?.unwrap_or(ROBOTS),
        };
        let controller = match self.controller {
            Some(file) => Some(read_controller(file, &read_profile(profile)?)?),
            None => None,
        };
        let sides_m: Vec<f64> = arena_m.into_iter().collect();
        let world = self.world.map(|file| read_world(file, &sides_m, &[robots])).transpose()?;
        let starts = self.starts.map(StartTable::read).transpose()?;
        Ok(Read { robots, controller, world, starts })
    }
}

impl Read {
    /// Whether there is a world without an arena of its own, whose places are those of a square that somebody must
    /// give.
    pub fn needs_arena(&self) -> bool {
        self.world.as_ref().is_some_and(|world| world.arena.is_none())
    }
}

/// Robots where nothing else is asked for, and no fleet is known.
pub const ROBOTS: usize = 9;
/// Controllers that are tried where nothing else is asked for.
pub const CONTROLLERS: usize = 2000;
/// Runs of each of them where nothing else is asked for.
pub const REPLICATES: u64 = 16;
/// Simulated time of a run where nothing else is asked for, in seconds.
pub const DURATION_S: f64 = 300.0;
/// Fresh runs that confirm what the gallery shows.
pub const CONFIRM: u64 = 200;

/// What was found.
#[derive(Clone, Debug, Serialize)]
pub struct Explored {
    /// The folder with the gallery.
    pub folder: PathBuf,
    /// Name of the kind of robot, or of each class with its kind.
    pub robot: String,
    /// The behaviour that was searched for; `None` for all that differ.
    pub wanted: Option<Behaviour>,
    /// Controllers that were tried.
    pub n_controllers: usize,
    /// The controllers that lead to the behaviour, or to a niche of their own, most surely; those with
    /// a named behaviour first.
    pub found: Vec<FoundController>,
    /// One run of each of them, to be drawn.
    #[serde(skip)]
    pub runs: Vec<ShownRun>,
    /// Number of robots.
    #[serde(skip)]
    pub robots: usize,
    /// Radius of a robot's body, in metres.
    #[serde(skip)]
    pub radius_m: f64,
    /// Side of the square arena, in metres.
    #[serde(skip)]
    pub arena_m: f64,
    /// What happens at its border.
    #[serde(skip)]
    pub walls: Walls,
    /// What is in it besides the robots.
    #[serde(skip)]
    pub world: WorldFile,
}

/// A fresh run that shows what a controller does.
#[derive(Clone, Debug)]
pub struct ShownRun {
    /// What the robots did.
    pub trajectory: Trajectory,
    /// The phase that the controller was found for; `None` for what has no name.
    pub phase: Option<Phase>,
}

/// A controller, and what a swarm that has it does.
#[derive(Clone, Debug, Serialize)]
pub struct FoundController {
    /// What it is called: a behaviour, `wall_following`, `rotating_crowd`, `no_order`, or `other`.
    pub name: String,
    /// The class of D. S. Brown et al. (DARS 2018) that it is, under their name; `None` for `other`.
    pub brown_class: Option<&'static str>,
    /// What it looks like, in words.
    pub words: String,
    /// The mean of each order parameter over the fresh runs that show it.
    pub order_parameters: BTreeMap<&'static str, f64>,
    /// In fewer words.
    pub niche: Niche,
    /// The controller.
    pub controller: Controller,
    /// Its number among those that were tried.
    pub number: usize,
    /// Share of fresh runs that show the behaviour, or end in the niche.
    pub share: f64,
    /// Lower bound of its 95 % interval.
    pub share_low: f64,
    /// Upper bound.
    pub share_high: f64,
    /// Fresh runs.
    pub n_replicates: u64,
    /// Share of as many fresh runs of the robots as measured that show the same.
    pub share_as_measured: f64,
    /// What the robots do when they touch in the world of the next share.
    pub other_contact: ContactModel,
    /// Share of fresh runs that show the same where robots do that when they touch.
    pub share_with_other_contact: f64,
    /// Whether it needs the robots' own contact: with the other one surely fewer runs show it, by 95 %
    /// intervals that do not overlap.
    pub needs_contact: bool,
    /// The sweep around it, ready to be run, relative to the folder; `None` if it shows no behaviour that
    /// runs can be judged for.
    pub sweep: Option<PathBuf>,
}

impl Explored {
    /// Whether the behaviour that was searched for was found: surely in more than half of the runs.
    pub fn is_found(&self) -> bool {
        let is_wanted = |found: &FoundController| {
            self.wanted.is_none_or(|wanted| found.name == wanted.key() && found.share_low > 0.5)
        };
        self.found.iter().any(is_wanted)
    }
}

/// Searches for controllers, confirms what was found on fresh seeds, and writes sweeps around it.
///
/// The robots of the profile are made worse by the usual factors. Results go into `folder`; what an
/// interrupted search has left in it is gone on with.
pub fn explore(
    profile: &Path,
    folder: &Path,
    options: &ExploreOptions,
) -> anyhow::Result<Explored> {
    let measured = read_profile(profile)?;
    let test_bed = TestBed::new(&measured, options)?;
    let settings = settings(options, &test_bed);
    let mut open_folder = Folder::open(folder, &measured, &settings, options.starts)?;
    let finds = search::search(&test_bed, &mut open_folder.journal, options)?;
    gallery::write(&test_bed, &open_folder, finds, options)
}

/// A table of start poses, checked, and as it was read.
#[derive(Clone, Debug, PartialEq)]
pub struct StartTable {
    /// The table's text.
    pub text: String,
    /// Replicate k of a search takes set k, and after the last one the first again.
    pub placement: Placement,
}

impl StartTable {
    /// Reads a table, which must have headings.
    pub fn read(path: &Path) -> anyhow::Result<Self> {
        let text = read_text(path)?;
        let starts = read_starts(&path.display().to_string(), &text, None).map_err(helped)?;
        Ok(Self { text, placement: Placement::Given { starts: starts.starts } })
    }
}
