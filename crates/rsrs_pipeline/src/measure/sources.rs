//! What a profile is fitted to: tables, trajectories and bags.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::Context;
use rsrs_core::trials::fit::Tables;
use rsrs_core::trials::trial::{
    ArcTrial, DetectionTrial, DrivenTrial, MovedBy, PeriodTrial, SpeedTrial, TrialKind, Trials,
    TurnTrial, arc_trials, detection_trials, period_trials, reduced, speed_trials, turn_trials,
};

use crate::error::with_help;
use crate::files::names;
use crate::measure::bag_trials::{self, BagTrials};
use crate::measure::trial_files::{Trajectories, table, trajectories};

/// All trials of a fit.
pub struct Sources {
    speed: Trials<SpeedTrial>,
    turn: Trials<TurnTrial>,
    arc: Option<Trials<ArcTrial>>,
    detection: Trials<DetectionTrial>,
    period: Option<Trials<PeriodTrial>>,
    driven: Vec<DrivenTrial>,
    from_rest: Vec<DrivenTrial>,
    moved_by: MovedBy,
    /// Robots and trials whose trajectories are neither straight runs nor turns.
    left_out: Vec<(String, String)>,
}

/// The files of a fit, wherever they are. A table goes before trajectories and bags, which stand in for
/// those that are not there.
#[derive(Clone, Debug, Default)]
pub struct Paths {
    /// Table of straight runs.
    pub speed: Option<PathBuf>,
    /// Table of turns in place.
    pub turn: Option<PathBuf>,
    /// Table of turns while driving.
    pub arcs: Option<PathBuf>,
    /// Table of detections.
    pub detection: Option<PathBuf>,
    /// Table of control periods.
    pub period: Option<PathBuf>,
    /// Tables of trajectories.
    pub trajectories: Vec<PathBuf>,
    /// Bags of trials.
    pub bags: Vec<PathBuf>,
}

impl Paths {
    /// Those in the folder of a plan, filled in.
    pub fn of_plan(folder: &Path) -> anyhow::Result<Self> {
        let all = |kind: TrialKind| Some(folder.join(kind.file()));
        // Who needs no arcs or periods deletes those tables.
        let some = |kind: TrialKind| all(kind).filter(|path| path.exists());
        Ok(Self {
            speed: all(TrialKind::Speed),
            turn: all(TrialKind::Turn),
            arcs: some(TrialKind::Arc),
            detection: all(TrialKind::Detection),
            period: some(TrialKind::Period),
            trajectories: Vec::new(),
            bags: drives_in(&folder.join("bags"))?,
        })
    }
}

/// The bags of drives that a plan has recorded: of each row the last, because those before it broke off
/// or paused. What robots that stood have detected is in the table.
fn drives_in(folder: &Path) -> anyhow::Result<Vec<PathBuf>> {
    if !folder.exists() {
        return Ok(Vec::new());
    }
    let mut last: BTreeMap<(String, u64), (u64, PathBuf)> = BTreeMap::new();
    let entries = std::fs::read_dir(folder);
    for entry in entries.with_context(|| format!("cannot read {}", folder.display()))? {
        let path = entry.with_context(|| format!("cannot read {}", folder.display()))?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let mut parts = name.split('_');
        let (kind, line) = (parts.next().unwrap_or_default(), parts.next());
        let Some(line) = line.and_then(|line| line.parse().ok()) else { continue };
        let attempt = parts.next().and_then(|attempt| attempt.parse().ok()).unwrap_or(1);
        if !TrialKind::MADE.iter().any(|it| it.is_drive() && it.name() == kind) {
            continue;
        }
        let place = last.entry((kind.to_owned(), line)).or_default();
        if attempt > place.0 {
            *place = (attempt, path);
        }
    }
    Ok(last.into_values().map(|(_, path)| path).collect())
}

impl Sources {
    /// Reads all files; one measurement of detections has to be among them.
    pub fn read(paths: &Paths) -> anyhow::Result<Self> {
        let bags = read_bags(&paths.bags)?;
        let Trajectories { mut driven, mut from_rest, mut moved_by, .. } =
            trajectories(&paths.trajectories, None)?;
        for (_, trials) in &bags {
            moved_by = moved_by + MovedBy::all(trials.backend, trials.driven.len());
            driven.extend(trials.driven.iter().cloned());
            from_rest.extend(trials.from_rest.iter().cloned());
        }
        if let Some(pushes) = driven.iter().find(|trial| trial.moves_object()) {
            return Err(with_help(
                format!(
                    "trial `{}` of {} pushes an object: a robot that does is not as fast as one that drives freely",
                    pushes.trial, pushes.robot
                ),
                "leave it out here, and give it to `rsrs validate`",
            ));
        }
        let all: Vec<&PathBuf> = paths.trajectories.iter().chain(&paths.bags).collect();
        let from_driven = reduced(&names(&all), &driven);
        let sources = Self {
            speed: match &paths.speed {
                Some(path) => table(path, speed_trials)?,
                None => from_driven.speed,
            },
            turn: match &paths.turn {
                Some(path) => table(path, turn_trials)?,
                None => from_driven.turn,
            },
            arc: match &paths.arcs {
                Some(path) => Some(table(path, arc_trials)?),
                None => Some(from_driven.arc).filter(|arc| !arc.rows.is_empty()),
            },
            detection: detections(paths.detection.as_deref(), &bags)?,
            period: match &paths.period {
                Some(path) => Some(table(path, period_trials)?),
                None => bag_trials::period_table(&bags),
            },
            driven,
            from_rest,
            moved_by,
            left_out: from_driven.left_out,
        };
        Ok(Self { moved_by: sources.all_moved_by(paths), ..sources })
    }

    /// What moved the robots in tables that were given, and in all trajectories and bags. What
    /// trajectories stand in for is not counted twice.
    fn all_moved_by(&self, paths: &Paths) -> MovedBy {
        let given = |path: &Option<PathBuf>, moved_by: MovedBy| path.as_ref().map(|_| moved_by);
        let arc = self.arc.as_ref().and_then(|arc| given(&paths.arcs, arc.moved_by));
        let tables = [
            given(&paths.speed, self.speed.moved_by),
            given(&paths.turn, self.turn.moved_by),
            arc,
            Some(self.detection.moved_by),
            self.period.as_ref().map(|period| period.moved_by),
        ];
        self.moved_by + tables.into_iter().flatten().sum()
    }

    /// The tables of the fit.
    pub fn tables(&self) -> Tables<'_> {
        Tables {
            speed: &self.speed,
            turn: &self.turn,
            arc: self.arc.as_ref(),
            detection: &self.detection,
            period: self.period.as_ref(),
            driven: &self.driven,
            from_rest: &self.from_rest,
            moved_by: self.moved_by,
        }
    }

    /// What does not count, in words.
    pub fn notes(&self) -> Vec<String> {
        let paused = [(&self.speed.file, &self.speed.paused), (&self.turn.file, &self.turn.paused)];
        let arc = self.arc.iter().map(|arc| (&arc.file, &arc.paused));
        let mut notes: Vec<String> = paused
            .into_iter()
            .chain(arc)
            .flat_map(|(file, lines)| lines.iter().map(move |line| (file, line)))
            .map(|(file, line)| {
                format!(
                    "{file}:{line}: commands paused in this trial (`paused_s`), so it does not \
                     count; `rsrs measure drive --plan` makes it again"
                )
            })
            .collect();
        notes.extend(self.left_out.iter().map(|(robot, trial)| {
            format!(
                "trial `{trial}` of {robot} is neither a straight run nor a turn; only its noise \
                 from step to step and its lag count"
            )
        }));
        notes
    }
}

fn detections(
    path: Option<&Path>,
    bags: &[(PathBuf, BagTrials)],
) -> anyhow::Result<Trials<DetectionTrial>> {
    match path {
        Some(path) => table(path, detection_trials),
        None => bag_trials::detection_table(bags).ok_or_else(|| {
            with_help(
                "in none of the bags does a robot stand and sense",
                "give a table with `--detection`, or bags of `rsrs measure drive --distance M \
                 --bearing RAD` and `rsrs measure drive --alone`",
            )
        }),
    }
}

fn read_bags(paths: &[PathBuf]) -> anyhow::Result<Vec<(PathBuf, BagTrials)>> {
    paths
        .iter()
        .map(|path| {
            if !bag_trials::is_bag(path) {
                return Err(with_help(
                    format!("{} is not a bag: neither a folder nor an .mcap file", path.display()),
                    "tables of trajectories go to `--trajectories`",
                ));
            }
            Ok((path.clone(), bag_trials::read(path, None)?))
        })
        .collect()
}
