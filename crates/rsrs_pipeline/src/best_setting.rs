//! The best setting of a robot: which speed and turning rate, and how many robots. `choose`, `answer` and
//! `diagnose` look for it by one search with one criterion.

mod alternatives;
pub mod grid;
pub mod search;

use std::path::Path;

use anyhow::Context;
use rsrs_core::conditions::Conditions;
use rsrs_core::diagram::choice::{
    AsMeasured, AtCircliness, Candidate, Choice, DenserStart, OtherNumber, most_frequent, rank,
};
use rsrs_core::diagram::sweep_file::SweepFile;
use rsrs_core::judge::behaviour::Behaviour;
use rsrs_core::judge::order::OrderParameters;
use rsrs_core::judge::phase::Phase;
use rsrs_core::quantity::Cell;
use rsrs_core::robot::other_profile::{OtherProfile, ProfilesDiffer};
use rsrs_files::quoted;
use rsrs_sim::sweep::{Swept, confirmation_seed};
use serde::Serialize;

use crate::error::with_help;
use crate::execution::Execution;
use crate::provenance::ResultProvenance;
use crate::sweep::folder;
use crate::sweep::result::SweepResult;
use crate::sweep::source::{ResolvedSweep, read_profile, robots_beside};
use crate::sweep::sweep_in_memory;

/// Fresh runs that confirm a setting, in each world, where nothing else is asked for.
pub const CONFIRM: u64 = 1000;

/// How the best setting is looked for.
#[derive(Clone, Copy)]
pub struct SearchOptions<'a> {
    /// How many robots there are; else as many as `fleet.yaml` beside a profile has, and any number that
    /// is tried if there is none.
    pub robots: Option<usize>,
    /// The share of runs in the wanted phase that is wanted in both worlds, from 0 to 1.
    pub wanted: f64,
    /// Fresh runs that confirm a setting, in each world; at least 1.
    pub confirm: u64,
    /// On how many threads, watched by whom.
    pub execution: Execution<'a>,
}

/// The best setting of a sweep.
#[derive(Clone, Debug)]
pub struct Best {
    /// The setting, confirmed.
    pub choice: Choice,
    /// Its index among the cells.
    pub index: usize,
    /// Settings that might have been viable.
    pub n_candidates: usize,
}

/// What `answer` and `diagnose` state of the best setting of some robots.
#[derive(Clone, Debug, Serialize)]
pub struct BestSetting {
    /// Name of the kind of robot.
    pub robot: String,
    /// What the swarm is to do, if not milling.
    #[serde(skip_serializing_if = "Behaviour::is_usual")]
    pub behaviour: Behaviour,
    /// The share of mills that was wanted.
    pub wanted: f64,
    /// Whether the robots mill so often in it, made worse and as measured.
    pub viable: bool,
    /// The setting; if it is not viable, where they mill most often.
    pub cell: Cell,
    /// Share of mills there in fresh runs, in the world in which they are rarer.
    pub b_s: f64,
    /// Its lower bound.
    pub b_s_low: f64,
    /// Fresh runs in each world.
    pub n_replicates: u64,
    /// What a denser start would give.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub denser_start: Option<DenserStart>,
    /// What other numbers of robots would.
    pub other_numbers: Vec<OtherNumber>,
    /// All of it.
    #[serde(skip)]
    pub choice: Choice,
}

impl BestSetting {
    /// Looks for it among the settings of a sweep.
    pub fn new(result: &SweepResult, options: SearchOptions<'_>) -> anyhow::Result<Self> {
        let Best { choice, .. } = best(result, options)?;
        let (b_s, b_s_low) = choice.least();
        Ok(Self {
            robot: result.source.profile.name.clone(),
            behaviour: result.source.sweep.behaviour.known(),
            wanted: options.wanted,
            viable: choice.is_viable(options.wanted),
            cell: choice.cell.clone(),
            b_s,
            b_s_low,
            n_replicates: choice.n_replicates,
            denser_start: choice.denser_start,
            other_numbers: choice.other_numbers.clone(),
            choice,
        })
    }
}

/// Looks for the best setting of a sweep: from the most robust on, candidates are confirmed on
/// fresh seeds in both worlds, until one holds. If none does, it is the best of them; if no setting
/// may be viable, the one in which most runs came to the wanted phase.
///
/// What else is worth knowing of it is run, too: a denser start, and other numbers of robots.
pub fn best(result: &SweepResult, options: SearchOptions<'_>) -> anyhow::Result<Best> {
    let (worlds, kind) = (result.worlds()?, result.source.sweep.interval_kind());
    let mut candidates = rank(worlds, kind, options.wanted);
    let n_candidates = candidates.len();
    if candidates.is_empty() {
        candidates.push(most_frequent(worlds, kind, options.wanted));
    }
    let mut best: Option<Best> = None;
    for (candidate, n_tried) in candidates.iter().zip(1..) {
        let choice = confirmed(&result.source, (candidate, n_tried), options)?;
        let holds = choice.is_viable(options.wanted);
        if best.as_ref().is_none_or(|best| choice.least().1 > best.choice.least().1) {
            best = Some(Best { choice, index: candidate.index, n_candidates });
        }
        if holds {
            break;
        }
    }
    let mut best = best.expect("there is a candidate");
    alternatives::add(&result.source, &mut best, options)?;
    Ok(best)
}

/// Confirms a candidate on fresh seeds, in both worlds.
fn confirmed(
    source: &ResolvedSweep,
    (candidate, n_tried): (&Candidate, u64),
    options: SearchOptions<'_>,
) -> anyhow::Result<Choice> {
    let fresh = |source: &ResolvedSweep| {
        confirm(&[source.conditions_of(candidate.index)?], source, (options.confirm, options))
    };
    let made_worse = fresh(source)?;
    let mut choice = Choice::new(candidate, made_worse.counts(1)[0], n_tried);
    choice.sweep_digest = Some(source.digest());
    let judged: Vec<(Phase, OrderParameters)> =
        made_worse.outcomes.iter().map(|outcome| (outcome.phase, outcome.evidence)).collect();
    choice.by_circliness = AtCircliness::new(&judged);
    if let Some(measured) = source.as_measured() {
        choice.as_measured = Some(AsMeasured::new(&fresh(&measured)?.counts(1)[0], n_tried));
    }
    Ok(choice)
}

/// Runs conditions on fresh seeds, so many times.
pub fn confirm(
    conditions: &[Conditions],
    source: &ResolvedSweep,
    (replicates, options): (u64, SearchOptions<'_>),
) -> anyhow::Result<Swept> {
    let runs = (confirmation_seed(source.sweep.seed), replicates);
    options.execution.simulate("confirming", conditions, runs, source.sweep.duration_s)
}

/// A robot, and the settings in which it is given its chance.
pub struct Subject {
    /// The robot as measured, how it is made worse, and the settings; no capabilities among them.
    source: ResolvedSweep,
    /// What came of just that, if it was swept before.
    swept: Option<SweepResult>,
    /// That these are of a sweep of robots with another profile, on which somebody insists.
    pub other_profile: Option<ProfilesDiffer>,
}

impl Subject {
    /// Reads a robot from a profile, a sweep file or the folder of a sweep.
    ///
    /// If `sweep` is given, a sweep file or folder, its settings are tried instead; `other_profile`
    /// decides what to do if that is of robots with another profile.
    ///
    /// # Errors
    ///
    /// Beside wrong files, if a setting is beyond the robot's limits, or classes have profiles of
    /// their own.
    pub fn read(
        path: &Path,
        (sweep, other_profile): (Option<&Path>, OtherProfile),
        robots: Option<usize>,
    ) -> anyhow::Result<Self> {
        let of_path = read_sweep(path)?;
        let of_option = sweep.map(|sweep| {
            let found = read_sweep(sweep)?;
            found.with_context(|| format!("{} is no sweep", sweep.display()))
        });
        let (source, swept, profile) = match (of_path, of_option.transpose()?) {
            (Some((source, _)), Some((settings, swept))) => (settings, swept, source.profile),
            (Some((source, swept)), None) => (source.clone(), swept, source.profile),
            (None, Some((settings, swept))) => (settings, swept, read_profile(path)?),
            (None, None) => {
                let profile = read_profile(path)?;
                let robots = robots.map_or_else(|| robots_beside(path), |n| Ok(Some(n)))?;
                let sweep = grid::of_robot(&profile, robots);
                let provenance = ResultProvenance::new(&profile);
                (ResolvedSweep { sweep, profile: profile.clone(), provenance }, None, profile)
            }
        };
        let other_profile =
            other_profile.admit(&source.profile.digest(), &profile.digest()).map_err(|differ| {
                let help = ProfilesDiffer::help(&quoted(path));
                with_help(format!("{}: {differ}", sweep.unwrap_or(path).display()), help)
            })?;
        let (sweep, capabilities) = grid::without_capabilities(&source.sweep);
        let profile = profile.with_capabilities(&capabilities)?;
        let is_swept = sweep == source.sweep && profile == source.profile;
        // Factors that nobody has decided follow from whatever robot is tried, as for a profile alone.
        let sweep = SweepFile { harsher: sweep.harsher.decided(&source.profile), ..sweep };
        let source = ResolvedSweep { sweep, profile, ..source };
        source
            .refuse_profiles_of_classes("what robots would have to be is asked of one profile")?;
        Ok(Self { source, swept: swept.filter(|_| is_swept), other_profile })
    }

    /// What comes of its settings, those left out in which its robots do not find a place; of a
    /// folder what was swept.
    pub fn swept(self, path: &Path, options: SearchOptions<'_>) -> anyhow::Result<SweepResult> {
        let result = match self.swept {
            Some(result) => SweepResult { source: self.source, ..result },
            None => sweep_in_memory(&path.display().to_string(), self.source, options.execution)?,
        };
        result.of_robots(options.robots)
    }
}

/// A sweep, and what came of it if it is a folder; `None` of a file that is none, as a profile is.
fn read_sweep(path: &Path) -> anyhow::Result<Option<(ResolvedSweep, Option<SweepResult>)>> {
    if path.is_dir() {
        let result = folder::read(path)?;
        return Ok(Some((result.source.clone(), Some(result))));
    }
    let text = crate::files::read_text(path)?;
    let is_sweep = |line: &str| line.starts_with("profile:") || line.starts_with("sweep:");
    if !text.lines().any(is_sweep) {
        return Ok(None);
    }
    Ok(Some((ResolvedSweep::read_either(path)?, None)))
}
