//! Trials on the floor: what was commanded, and what a tape, a stopwatch or a tracker saw.
//!
//! Each kind of trial is a CSV table with its header first; columns may stand in any order, rows
//! too. A table from a spreadsheet is read as it comes: with a byte order mark, `CRLF`, semicolons
//! or quotes. What cannot be true is refused with file, line and column, and numbers that look like
//! millimetres or degrees with that guess: a gain that is a thousand times too large would
//! otherwise go into a profile unseen.

use std::collections::BTreeMap;

use crate::quantity::{Bounds, MAX_SENSING_M, MAX_SPEED_M_S, MAX_TURN_RATE_RAD_S};
use crate::robot::controller::ControllerParameters;

pub use driven::{DrivenSample, DrivenTrial, driven_trials, has_moved};
pub use error::{TrialError, TrialProblem};
pub use kind::TrialKind;
pub use lines::TableLines;
pub use moved_by::{MovedBy, TrialBackend};
pub use reduced::{Reduced, reduced};
use table::{Row, Table};

mod driven;
mod error;
mod kind;
mod lines;
mod moved_by;
mod reduced;
pub(crate) mod table;

/// Time in which a robot's motion or its sensor settles, and nothing is measured, in seconds.
///
/// A command is on its way for about a control period, and the robot's own watchdog and wheels take
/// another; what a tape measures begins behind that.
pub const SETTLING_TIME_S: f64 = 0.5;

/// All trials of one table.
#[derive(Clone, Debug, PartialEq)]
pub struct Trials<T> {
    /// Name of the table, for errors and reports.
    pub file: String,
    /// Names of the robots; trials refer to them by position.
    pub robots: Vec<String>,
    /// The trials, in the order of the table.
    pub rows: Vec<T>,
    /// Lines of trials in which commands paused, so that they give no gain: they are in the
    /// table with a number in `paused_s`, and not among the trials.
    pub paused: Vec<u64>,
    /// What moved the robots of the trials.
    pub moved_by: MovedBy,
}

/// One straight run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpeedTrial {
    /// Position of the robot's name.
    pub robot: usize,
    /// Line of the table, from 1.
    pub line: u64,
    /// Commanded speed, in metres per second; positive.
    pub commanded_m_s: f64,
    /// Distance driven along the commanded line, in metres; not negative.
    pub distance_m: f64,
    /// Time taken, in seconds; positive.
    pub duration_s: f64,
    /// Where it ended beside the line, in metres; left is positive.
    pub lateral_m: Option<f64>,
    /// How much the heading changed, in radians; counterclockwise is positive.
    pub heading_change_rad: Option<f64>,
}

/// One turn in place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TurnTrial {
    /// Position of the robot's name.
    pub robot: usize,
    /// Line of the table, from 1.
    pub line: u64,
    /// Commanded turning rate, in radians per second; counterclockwise is positive, not zero.
    pub commanded_rad_s: f64,
    /// Angle turned, in radians, with the command's sign; a full circle is 2π.
    pub angle_rad: f64,
    /// Time taken, in seconds; positive.
    pub duration_s: f64,
}

/// One turn while driving forward.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ArcTrial {
    /// Position of the robot's name.
    pub robot: usize,
    /// Line of the table, from 1.
    pub line: u64,
    /// Commanded speed, in metres per second; positive.
    pub commanded_m_s: f64,
    /// The turn: commanded rate, angle and time.
    pub turn: TurnTrial,
}

/// A neighbour's place in the robot's frame, centre to centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Neighbour {
    /// Distance of the centres, in metres; positive.
    pub distance_m: f64,
    /// Bearing of its centre, in radians from -π to π; left is positive.
    pub bearing_rad: f64,
}

/// What a robot does in a trial.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Trial {
    /// It drives.
    Drive {
        /// Forward speed, and turning rate counterclockwise.
        command: ControllerParameters,
        /// How long, in seconds.
        duration_s: f64,
    },
    /// It stands and senses.
    Stand {
        /// Where another robot stands, centre to centre; `None` if the robot is alone.
        neighbour: Option<Neighbour>,
        /// Readings to take; 1 or more.
        samples: u64,
    },
}

/// More readings are waited for than are taken by this share: a robot may be slower than its profile.
const SPARE: f64 = 0.1;

impl Trial {
    /// The command.
    pub fn command(&self) -> ControllerParameters {
        match self {
            Self::Drive { command, .. } => *command,
            Self::Stand { .. } => ControllerParameters::mirrored(0.0, 0.0),
        }
    }

    /// How long it takes with detections so often, in seconds.
    pub fn duration_s(&self, period_s: f64) -> f64 {
        match self {
            Self::Drive { duration_s, .. } => *duration_s,
            Self::Stand { samples, .. } => {
                SETTLING_TIME_S + ((*samples as f64 * (1.0 + SPARE)).ceil() + 1.0) * period_s
            }
        }
    }

    /// Where another robot stands, if one is to be sensed.
    pub fn neighbour(&self) -> Option<Neighbour> {
        match self {
            Self::Drive { .. } => None,
            Self::Stand { neighbour, .. } => *neighbour,
        }
    }
}

/// How often a sensor reported something while a neighbour stood at one place, or while none did.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DetectionTrial {
    /// Position of the robot's name.
    pub robot: usize,
    /// Line of the table, from 1.
    pub line: u64,
    /// Where the neighbour stood; `None` if there was none, so that detections are false.
    pub neighbour: Option<Neighbour>,
    /// Readings taken; 1 or more.
    pub samples: u64,
    /// Readings that were detections; at most `samples`.
    pub detections: u64,
}

/// One measured control period.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PeriodTrial {
    /// Position of the robot's name.
    pub robot: usize,
    /// Line of the table, from 1.
    pub line: u64,
    /// Time from one decision to the next, in seconds; positive.
    pub period_s: f64,
}

/// Reads straight runs:
/// `robot,commanded_m_s,distance_m,duration_s[,lateral_m,heading_change_rad,paused_s,backend]`.
pub fn speed_trials(file: &str, text: &str) -> Result<Trials<SpeedTrial>, TrialError> {
    let mut table = Table::open_kind(file, text, TrialKind::Speed)?;
    table.read(|row, robot| {
        let commanded_m_s = row.positive(1)?;
        row.below(1, commanded_m_s, MAX_SPEED_M_S, "mm/s")?;
        let distance_m = row.not_negative(2)?;
        let duration_s = row.positive(3)?;
        let ratio = distance_m / duration_s / commanded_m_s;
        if ratio > 20.0 {
            return Err(row.unit(2, distance_m, "mm"));
        }
        // Half to twice a hundredth: 2.5 cm/s that was driven as 0.025 m/s.
        if commanded_m_s >= 1.0 && (0.005..=0.02).contains(&ratio) {
            return Err(row.unit(1, commanded_m_s, "cm/s"));
        }
        let lateral_m = row.optional(4)?;
        // No robot ends further beside a line than it drove.
        if let Some(lateral_m) = lateral_m.filter(|lateral_m| lateral_m.abs() > distance_m + 1.0) {
            return Err(row.unit(4, lateral_m, "mm"));
        }
        let heading_change_rad = row.optional(5)?;
        if let Some(change) = heading_change_rad {
            row.below(5, change, std::f64::consts::TAU, "degrees")?;
        }
        let line = row.line;
        Ok(SpeedTrial {
            robot,
            line,
            commanded_m_s,
            distance_m,
            duration_s,
            lateral_m,
            heading_change_rad,
        })
    })
}

/// Reads turns in place: `robot,commanded_rad_s,angle_rad,duration_s[,paused_s,backend]`.
pub fn turn_trials(file: &str, text: &str) -> Result<Trials<TurnTrial>, TrialError> {
    let mut table = Table::open_kind(file, text, TrialKind::Turn)?;
    table.read(|row, robot| turn(row, robot, 1))
}

/// Reads turns while driving forward:
/// `robot,commanded_m_s,commanded_rad_s,angle_rad,duration_s[,paused_s,backend]`.
pub fn arc_trials(file: &str, text: &str) -> Result<Trials<ArcTrial>, TrialError> {
    let mut table = Table::open_kind(file, text, TrialKind::Arc)?;
    table.read(|row, robot| {
        let commanded_m_s = row.positive(1)?;
        row.below(1, commanded_m_s, MAX_SPEED_M_S, "mm/s")?;
        Ok(ArcTrial { robot, line: row.line, commanded_m_s, turn: turn(row, robot, 2)? })
    })
}

/// A turn whose commanded rate, angle and time stand in three columns from one on.
fn turn(row: &Row, robot: usize, from: usize) -> Result<TurnTrial, TrialError> {
    let commanded_rad_s = row.number(from)?;
    if commanded_rad_s == 0.0 {
        return Err(row.out_of_range(from, commanded_rad_s, "a turning rate that is not 0"));
    }
    row.below(from, commanded_rad_s, MAX_TURN_RATE_RAD_S, "degrees per second")?;
    let angle_rad = row.number(from + 1)?;
    let duration_s = row.positive(from + 2)?;
    let ratio = angle_rad / duration_s / commanded_rad_s;
    if ratio < 0.0 {
        return Err(row.out_of_range(
            from + 1,
            angle_rad,
            "an angle with the sign of commanded_rad_s (counterclockwise is positive)",
        ));
    }
    let degrees = 180.0 / std::f64::consts::PI;
    let is_round = angle_rad.abs() >= 90.0 && angle_rad % 90.0 == 0.0;
    if is_round || (degrees / 2.0..=degrees * 2.0).contains(&ratio) {
        return Err(row.unit(from + 1, angle_rad, "degrees"));
    }
    if (0.5 / degrees..=2.0 / degrees).contains(&ratio) {
        return Err(row.unit(from, commanded_rad_s, "degrees per second"));
    }
    Ok(TurnTrial { robot, line: row.line, commanded_rad_s, angle_rad, duration_s })
}

/// Reads detections: `robot,distance_m,bearing_rad,samples,detections[,backend]`, centre to centre; an empty
/// distance means that there was no neighbour.
pub fn detection_trials(file: &str, text: &str) -> Result<Trials<DetectionTrial>, TrialError> {
    let mut table = Table::open_kind(file, text, TrialKind::Detection)?;
    table.read(|row, robot| {
        let neighbour = if row.optional(1)?.is_some() {
            let distance_m = row.positive(1)?;
            row.below(1, distance_m, MAX_SENSING_M, "mm or cm")?;
            let bearing_rad = row.number(2)?;
            row.below(2, bearing_rad, Bounds::BEARING.most, "degrees")?;
            Some(Neighbour { distance_m, bearing_rad })
        } else {
            if let Some(bearing_rad) = row.optional(2)? {
                return Err(row.out_of_range(
                    2,
                    bearing_rad,
                    "no bearing where distance_m is empty (no neighbour)",
                ));
            }
            None
        };
        let samples = row.count(3)?;
        let detections = row.count(4)?;
        if samples == 0 {
            return Err(row.out_of_range(3, 0.0, "1 or more"));
        }
        if detections > samples {
            return Err(row.out_of_range(4, detections as f64, "at most samples"));
        }
        Ok(DetectionTrial { robot, line: row.line, neighbour, samples, detections })
    })
}

/// Reads control periods: `robot,period_s[,backend]`, one measured period in each row.
pub fn period_trials(file: &str, text: &str) -> Result<Trials<PeriodTrial>, TrialError> {
    let mut table = Table::open_kind(file, text, TrialKind::Period)?;
    table.read(|row, robot| {
        let period_s = row.positive(1)?;
        row.below(1, period_s, Bounds::PERIOD.most, "ms")?;
        Ok(PeriodTrial { robot, line: row.line, period_s })
    })
}

impl Table<'_> {
    /// Reads every row in which commands did not pause; the first column is the robot's name.
    fn read<T>(
        &mut self,
        mut trial: impl FnMut(&Row, usize) -> Result<T, TrialError>,
    ) -> Result<Trials<T>, TrialError> {
        let pauses = self.paused();
        let mut robots = Names::default();
        let (mut rows, mut paused) = (Vec::new(), Vec::new());
        let mut moved_by = MovedBy::default();
        while let Some(row) = self.next_row()? {
            let robot = robots.position(row.name(0)?);
            if pauses.map(|column| row.optional(column)).transpose()?.flatten().is_some() {
                paused.push(row.line);
                continue;
            }
            let trial = trial(&row, robot)?;
            moved_by = moved_by + MovedBy::all(row.backend()?, 1);
            rows.push(trial);
        }
        if rows.is_empty() {
            return Err(self.refuse(TrialProblem::NoRows));
        }
        Ok(Trials { file: self.file().to_owned(), robots: robots.names, rows, paused, moved_by })
    }
}

/// Names by position, each held once.
#[derive(Default)]
struct Names {
    names: Vec<String>,
    positions: BTreeMap<String, usize>,
}

impl Names {
    const EMPTY: Self = Self { names: Vec::new(), positions: BTreeMap::new() };

    fn position(&mut self, name: &str) -> usize {
        if let Some(position) = self.positions.get(name) {
            return *position;
        }
        let position = self.names.len();
        self.names.push(name.to_owned());
        self.positions.insert(name.to_owned(), position);
        position
    }
}
