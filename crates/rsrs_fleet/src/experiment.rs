//! The experiment file: what a person wants to run.

mod recording;

use rsrs_core::conditions::controller_table::ControllerSource;
use rsrs_core::conditions::start_file::StartPlacement;
use rsrs_core::conditions::{Settings, Sides};
use rsrs_core::diagram::sweep_file::check_run;
use rsrs_core::document::{self, DocumentError};
use rsrs_core::help::Help;
use rsrs_core::judge::behaviour::named::NamedBehaviour;
use rsrs_core::judge::window::Window;
use rsrs_core::out_of_range::OutOfRange;
use rsrs_core::quantity::{Axis, Cell};
use rsrs_core::world::WorldSource;
use serde::{Deserialize, Serialize};

pub use recording::{BagCompression, RecordOptions, RecordRefused, bytes};

/// An experiment as written by a person: what to run, with which robots, for how long.
#[derive(Clone, Debug, PartialEq, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ExperimentFile {
    /// Path of the fleet file, relative to this file.
    pub fleet: String,
    /// Path of the robots' controller, relative to this file (default: that of the sweep that its cell is from, else two
    /// commands over one detection).
    #[serde(default)]
    pub controller: Option<ControllerSource>,
    /// Path of what is in the arena besides the robots, and of which classes these are, relative to this file (default:
    /// what is there in the sweep that its cell is from, else nothing).
    #[serde(default)]
    pub world: Option<WorldSource>,
    /// The cell to run; the command line may give another.
    pub cell: Option<Cell>,
    /// In place of `cell`: the folder of a sweep whose `choice.json` has it, relative to this file.
    pub from: Option<String>,
    /// Where the robots start.
    pub placement: StartPlacement,
    /// How long the robots move, in seconds.
    pub duration_s: f64,
    /// Seed of the simulated world, below 2^63.
    pub seed: u64,
    /// What to do when a robot is lost during the run: end it, go on without it, or end it only before
    /// the time that is judged has begun.
    #[serde(default)]
    pub robot_lost: RobotLost,
    /// What is recorded besides the topics of every run.
    #[serde(default)]
    pub record: RecordOptions,
    /// How the simulated backend runs it.
    #[serde(default)]
    pub simulator: SimulatorOptions,
    /// What the run is judged for, by name or by the path of a file relative to this one (default: that of the
    /// sweep that its cell is from, else milling).
    #[serde(default)]
    pub behaviour: Option<NamedBehaviour>,
}

/// What to do when a robot falls silent or stops during a run.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum RobotLost {
    /// Stop all robots and end the run.
    #[default]
    Abort,
    /// Report it and go on with the others; what the others do is compared only where that is asked
    /// for.
    Note,
    /// End the run if the time that is judged, mostly its last minute, has not begun; then report it, go on
    /// with the others, and the run counts.
    AbortUntilJudged,
}

impl RobotLost {
    /// Whether a run of `duration_s` ends when a robot is lost `after_s` seconds after the robots
    /// began to move.
    pub fn ends_run(self, after_s: f64, duration_s: f64, window: Window) -> bool {
        match self {
            Self::Abort => true,
            Self::Note => false,
            Self::AbortUntilJudged => after_s < judged_from_s(duration_s, window),
        }
    }
}

/// When the time of a run begins that is judged, in seconds from the start of the movement.
pub fn judged_from_s(duration_s: f64, window: Window) -> f64 {
    (duration_s - window.reaches_back_s()).max(0.0)
}

/// How the simulated backend runs an experiment.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct SimulatorOptions {
    /// The world's pace.
    pub time: Time,
    /// Which robots it moves.
    pub profile: SimulatedProfile,
}

/// The pace of a run.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum Time {
    /// The world steps when every controller has answered; nothing sleeps.
    #[default]
    Lockstep,
    /// The world, or reality, goes by the wall clock.
    RealTime,
}

impl Time {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Lockstep, Self::RealTime];

    /// What files and parameters call it.
    pub fn key(self) -> &'static str {
        match self {
            Self::Lockstep => "lockstep",
            Self::RealTime => "real_time",
        }
    }

    /// The one that files and parameters call so; `None` if there is none.
    pub fn from_key(key: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|it| it.key() == key)
    }
}

/// Which robots the simulated backend moves.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum SimulatedProfile {
    /// The robots as measured.
    #[default]
    Measured,
    /// The robots as swept: worse than measured.
    Harsher,
}

/// Why an experiment cannot be run.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ExperimentError {
    /// The text is not an experiment file.
    #[error(transparent)]
    Document(#[from] DocumentError),
    /// Both `cell` and `from`.
    #[error("{file}: both `cell` and `from` are given, expected one")]
    CellTwice {
        /// The file.
        file: String,
    },
    /// A placement that is a trial's.
    #[error("{file}: `placement` is a pair, expected `disc_facing_out`")]
    NoSwarm {
        /// The file.
        file: String,
    },
    /// A number outside what it can mean.
    #[error("{file}: {source}")]
    OutOfRange {
        /// The file.
        file: String,
        /// Which one.
        source: OutOfRange,
    },
    /// Something that cannot be recorded so.
    #[error("{file}: {source}")]
    Record {
        /// The file.
        file: String,
        /// Why.
        source: RecordRefused,
    },
    /// The cell cannot be run.
    #[error("{file}: cell `{cell}`: {source}")]
    Cell {
        /// The file.
        file: String,
        /// The cell.
        cell: Cell,
        /// Why.
        source: CellRefused,
    },
}

/// Why a swept cell is not an experiment.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum CellRefused {
    /// A property of the robots, which cannot be set on a fleet.
    #[error("{axis} is a capability of the robots, not a setting")]
    Capability {
        /// The axis.
        axis: Axis,
    },
    /// A setting without which there is no experiment.
    #[error("no value for {axis}")]
    Missing {
        /// The axis.
        axis: Axis,
    },
    /// The experiment's `placement` is no disc, and the cell has the radius of one.
    #[error("placement_radius_m is {found_m} m, and `placement` is no disc")]
    NoDisc {
        /// In the cell, in metres.
        found_m: f64,
    },
    /// The experiment's `placement` and the cell place the robots differently.
    #[error("placement_radius_m is {found_m} m, expected {expected_m} m as in `placement`")]
    OtherPlacement {
        /// In the cell, in metres.
        found_m: f64,
        /// In the experiment, in metres.
        expected_m: f64,
    },
}

impl Help for ExperimentError {
    fn help(&self) -> Option<String> {
        match self {
            Self::Document(error) => error.help(),
            Self::NoSwarm { .. } => {
                Some("trials of two robots are driven by `rsrs measure drive`".to_owned())
            }
            Self::CellTwice { .. } => Some("remove `cell:` or `from:`".to_owned()),
            Self::Cell { source: CellRefused::Capability { .. }, .. } => {
                Some("put capabilities into the robots' profile and sweep them there".to_owned())
            }
            Self::Cell { source: CellRefused::Missing { axis }, .. } => {
                Some(format!("give it in `cell`, as `{axis}: …`, or have the cell `from:` a sweep"))
            }
            Self::Cell { .. } | Self::OutOfRange { .. } | Self::Record { .. } => None,
        }
    }
}

impl ExperimentFile {
    /// Reads an experiment file, up to the first problem; `file` names it in errors, and nothing is
    /// opened.
    pub fn parse(file: &str, text: &str) -> Result<Self, ExperimentError> {
        let required = ["fleet", "placement", "duration_s", "seed"];
        let experiment: Self = document::parse_with(file, text, &required)?;
        experiment.check(file)?;
        Ok(experiment)
    }

    fn check(&self, file: &str) -> Result<(), ExperimentError> {
        let out_of_range = |source| ExperimentError::OutOfRange { file: file.to_owned(), source };
        let lengths = match &self.placement {
            StartPlacement::DiscFacingOut { radius_m } => vec![("placement.radius_m", *radius_m)],
            StartPlacement::BoxFacingOut(Sides { width_m, height_m })
            | StartPlacement::BoxFacingAnyWay(Sides { width_m, height_m }) => {
                vec![("placement.width_m", *width_m), ("placement.height_m", *height_m)]
            }
            StartPlacement::Pair { .. } => {
                return Err(ExperimentError::NoSwarm { file: file.to_owned() });
            }
            StartPlacement::File { .. } | StartPlacement::Given { .. } => Vec::new(),
        };
        for (name, found) in lengths {
            if !(found > 0.0 && found.is_finite()) {
                let expected = "a finite length above 0 m".into();
                return Err(out_of_range(OutOfRange { name, found, expected }));
            }
        }
        check_run(self.duration_s, self.seed).map_err(out_of_range)?;
        self.record
            .check()
            .map_err(|source| ExperimentError::Record { file: file.to_owned(), source })?;
        match (&self.cell, &self.from) {
            (Some(_), Some(_)) => Err(ExperimentError::CellTwice { file: file.to_owned() }),
            (Some(cell), None) => self.settings(cell).map(drop).map_err(|source| {
                ExperimentError::Cell { file: file.to_owned(), cell: cell.clone(), source }
            }),
            (None, _) => Ok(()),
        }
    }

    /// The settings of one cell under this experiment's placement, ready to be resolved.
    ///
    /// # Errors
    ///
    /// If the cell holds a capability or another placement, or lacks the number of robots or,
    /// without a table, speed or turning rate.
    pub fn settings(&self, cell: &Cell) -> Result<Settings, CellRefused> {
        if let Some(axis) = cell.axes().into_iter().find(|axis| axis.is_capability()) {
            return Err(CellRefused::Capability { axis });
        }
        // A table has commands, and its numbers have values.
        let required: &[Axis] = match self.controller {
            Some(_) => &[Axis::Robots],
            None => &[Axis::Speed, Axis::TurnRate, Axis::Robots],
        };
        if let Some(axis) = required.iter().copied().find(|axis| cell.get(*axis).is_none()) {
            return Err(CellRefused::Missing { axis });
        }
        let controller = self.controller.as_ref().and_then(ControllerSource::read).cloned();
        let world = self.world.as_ref().and_then(WorldSource::read).cloned().unwrap_or_default();
        let mut settings = Settings { controller, world, ..Settings::default() }.with_cell(cell);
        let StartPlacement::DiscFacingOut { radius_m: expected_m } = self.placement else {
            settings.placement = self.placement.placement();
            return match cell.get(Axis::PlacementRadius) {
                Some(found_m) => Err(CellRefused::NoDisc { found_m }),
                None => Ok(settings),
            };
        };
        match cell.get(Axis::PlacementRadius) {
            Some(found_m) if (found_m - expected_m).abs() > SAME * expected_m => {
                return Err(CellRefused::OtherPlacement { found_m, expected_m });
            }
            _ => {}
        }
        settings.values.push((Axis::PlacementRadius, expected_m));
        Ok(settings)
    }
}

/// Numbers that differ by less than this share were the same number before they were written.
const SAME: f64 = 1e-9;

#[cfg(test)]
mod tests {
    use super::*;

    const SHIPPED: &str = include_str!("../../../launch_configs/experiments/flockbot_milling.yaml");

    #[test]
    fn what_cannot_be_run_is_refused() {
        for (from, to, expected) in [
            ("robots: 9}", "robots: 9, range_m: 0.5}", "range_m is a capability"),
            (", robots: 9}", "}", "no value for robots"),
            ("robots: 9}", "robots: 9, placement_radius_m: 0.6}", "is 0.6 m, expected 0.825 m"),
            ("seed: 1", "seed: 9223372036854775808", "expected a whole number below 2^63"),
            ("duration_s: 300", "duration_s: 0", "duration_s is 0"),
            ("seed: 1", "seed: 1\nfrom: sweep", "both `cell` and `from`"),
            ("robot_lost: abort", "robot_lost: pause", "pause"),
            ("seed: 1", "seed: 1\nrecord: {split_gib: 0}", "record.split_gib is 0 GiB"),
            ("seed: 1", "seed: 1\nrecord: {topics: [a b]}", "\"a b\" is no topic"),
            ("seed: 1", "seed: 1\nrecord: {topic: [a]}", "did you mean `topics`?"),
        ] {
            let error =
                ExperimentFile::parse("experiment.yaml", &SHIPPED.replace(from, to)).unwrap_err();

            assert!(error.to_string().contains(expected), "{error}");
        }
    }
}
