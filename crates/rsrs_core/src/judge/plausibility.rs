//! Whether poses can be those of the robots that were commanded, and whether these moved at all.
//!
//! Every robot is held against its own commands: how far it went and how much it turned in windows
//! of a second or two, and whether it goes where it heads. Thresholds lie far from what robots do that are
//! as they should be: gains of 0.5 to 2, late trackers and gusts accuse nobody. A robot that is near
//! another one, or at a wall, may be blocked; what it does then is no evidence. Poses that are late,
//! or stamped by another clock, are looked for up to [`MOST_LAG_S`] away from the commands.

mod motion;
mod standing;
mod turning;

use std::f64::consts::PI;
use std::fmt;

use serde::Serialize;

use crate::judge::trajectory::{Bodies, Trajectory};
use crate::numerals::count;
use motion::{Distances, Motion, Surroundings, Way};
use turning::{MIN_FOLLOWED, Turning, follow};

/// Poses may be so much later than the commands that moved the robot, or earlier where clocks differ,
/// in seconds: preflight refuses clocks that are a second apart, and trackers are late by a part of one.
pub const MOST_LAG_S: f64 = 1.5;

/// A commanded robot that stands for so long is noted while it does, in seconds.
pub const NOTED_S: f64 = 3.0;

/// A run in which one stands for so long is no evidence, in seconds: it is a tenth of the shortest run,
/// and a hand that holds a robot back has let it go by then.
pub const STOOD_S: f64 = 9.0;

/// Poses that move so many times as far as commanded are none of the robot's: gains are within 0.5 and
/// 2, and the smallest wrong unit, feet, makes 3.3.
const TOO_FAR: f64 = 3.0;

/// And so much further, in metres per window of 1 s: a tracker's noise of 3 cm looks like motion.
const NOISE_M: f64 = 0.10;

/// Share of the robots that show a fault of the frame: it has all of them, and one may stand.
const MOST: f64 = 0.75;

/// The way and the heading belong together if the angle between them is this concentrated (0 is any
/// angle, 1 always the same): a heading that is off by 0.5 rad gives 0.88, gusts as strong as the
/// drive 0.57.
const TOGETHER: f64 = 0.7;

/// And have nothing to do with each other below this.
const APART: f64 = 0.3;

/// An angle that is the same all the time is as concentrated as this, or more.
const CONSTANT: f64 = 0.95;

/// A heading stands that turns less than this share of what is commanded: gains are 0.5 or more.
const STANDS: f64 = 0.3;

/// Windows of way that show where a robot heads; they overlap by half, so that 5 s have nine.
const MIN_WINDOWS: usize = 7;

/// Windows that show it of a robot alone: gusts push one or another aside for some seconds.
const MIN_WINDOWS_ALONE: usize = 40;

/// A body may be fixed askew in the tracker by so much before it counts as turned, in radians ...
const MOST_ASKEW_RAD: f64 = PI / 3.0;
/// ... and the angle is then the same all the time: gusts push from any side.
const ASKEW: f64 = 0.85;

/// Poses on a line: one axis has less than this share of the other's extent.
const LINE: f64 = 0.05;

/// Where a robot's poses are extended by less than this, in metres, they show no line.
const MIN_EXTENT_M: f64 = 0.2;

/// What the poses or motions of some robots show that cannot be.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Implausible {
    /// What.
    #[serde(flatten)]
    pub cause: Implausibility,
    /// Rows of the trajectory, ascending; not empty.
    #[serde(skip)]
    pub robots: Vec<usize>,
}

/// What is wrong, and so what to look for.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(tag = "cause", rename_all = "snake_case")]
pub enum Implausibility {
    /// Poses move too far for the commands: another unit. Those of too small a unit are on one spot.
    Scale {
        /// How many times as far as commanded.
        factor: f64,
    },
    /// All poses lie on a line along one axis: another axis is up.
    Line {
        /// The axis along which they move.
        axis: FloorAxis,
    },
    /// Headings stay while the way turns.
    HeadingStands,
    /// Turning is reversed against the commands.
    Mirrored,
    /// Headings turn one way and the way the other.
    HeadingMirrored,
    /// Headings turn by degrees where radians are meant, or the other way round.
    Degrees {
        /// How many times as fast as commanded.
        factor: f64,
    },
    /// Headings have nothing to do with the way.
    HeadingUnrelated,
    /// Robots drive askew of their heading.
    Askew {
        /// The way, against the heading, in degrees; counterclockwise.
        by_deg: f64,
    },
    /// Robots follow each other's commands.
    Swapped,
    /// A robot that is commanded does not move.
    Stands {
        /// When it was found, in seconds from the start.
        time_s: f64,
        /// For how long it stood then, in seconds.
        for_s: f64,
        /// Mean speed that was commanded, in metres per second.
        speed_m_s: f64,
        /// Mean turning rate that was commanded, either way, in radians per second.
        turn_rate_rad_s: f64,
        /// How far it moved, in metres.
        moved_m: f64,
    },
}

/// An axis of the floor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum FloorAxis {
    /// The first one.
    X,
    /// The second one.
    Y,
}

impl Implausibility {
    /// Whether it is one of poses; else it is one of the robot.
    pub fn is_of_poses(&self) -> bool {
        !matches!(self, Self::Stands { .. })
    }

    /// Whether it is one that several robots have together.
    pub fn is_of_several(&self) -> bool {
        matches!(self, Self::Swapped)
    }

    /// Its kind, as it is written in JSON.
    pub fn key(&self) -> &'static str {
        match self {
            Self::Scale { .. } => "scale",
            Self::Line { .. } => "line",
            Self::HeadingStands => "heading_stands",
            Self::Mirrored => "mirrored",
            Self::HeadingMirrored => "heading_mirrored",
            Self::Degrees { .. } => "degrees",
            Self::HeadingUnrelated => "heading_unrelated",
            Self::Askew { .. } => "askew",
            Self::Swapped => "swapped",
            Self::Stands { .. } => "stands",
        }
    }

    /// Whether two are of one kind, whatever their numbers.
    pub fn is_like(&self, other: &Self) -> bool {
        std::mem::discriminant(self) == std::mem::discriminant(other)
    }
}

impl Implausible {
    /// The finding as a sentence.
    ///
    /// # Panics
    ///
    /// If a robot has no name.
    pub fn in_words(&self, names: &[String]) -> String {
        let robots: Vec<&str> = self.robots.iter().map(|robot| names[*robot].as_str()).collect();
        let all = match robots.len() {
            n if n > 2 && n == names.len() => format!("all {n} robots"),
            _ => robots.join(", "),
        };
        match (self.cause, &robots[..]) {
            (Implausibility::Swapped, [one, other]) => {
                format!("{one} and {other} follow each other's commands: swapped?")
            }
            (Implausibility::Swapped, [first @ .., last]) => {
                let first = first.join(", ");
                format!("{first} and {last} follow the commands of others among them: exchanged?")
            }
            (cause @ Implausibility::Stands { .. }, _) => format!("{all} {cause}"),
            (cause, _) => format!("{all}: {cause}"),
        }
    }
}

impl fmt::Display for Implausibility {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Scale { factor } => {
                let unit = unit(factor).unwrap_or("another unit?");
                write!(out, "poses move {} times too far: {unit}", rounded(factor))
            }
            Self::Line { axis } => {
                let (along, constant) = match axis {
                    FloorAxis::X => ("x", "y"),
                    FloorAxis::Y => ("y", "x"),
                };
                write!(
                    out,
                    "poses move along {along} only, whatever is commanded: is {constant} the axis that \
                     points up?"
                )
            }
            Self::HeadingStands => write!(
                out,
                "headings do not turn, while the way does: does the tracker give orientations, and \
                 about the vertical axis?"
            ),
            Self::Mirrored => write!(
                out,
                "poses turn the other way than is commanded: is an axis mirrored, or are motors \
                 exchanged?"
            ),
            Self::HeadingMirrored => write!(
                out,
                "headings turn one way and the way the other: is an axis mirrored in one of them?"
            ),
            Self::Degrees { factor: factor @ 1.0.. } => write!(
                out,
                "headings turn {factor:.0} times too fast: degrees in place of radians?"
            ),
            Self::Degrees { factor } => write!(
                out,
                "headings turn {:.0} times too little: radians taken for degrees?",
                1.0 / factor
            ),
            Self::HeadingUnrelated => write!(
                out,
                "headings have nothing to do with the way: degrees in place of radians, or an angle \
                 about another axis?"
            ),
            Self::Askew { by_deg } => write!(
                out,
                "the way is {by_deg:.0}° off the heading: is the body turned in the tracker?"
            ),
            Self::Swapped => write!(out, "follow each other's commands: swapped?"),
            Self::Stands { for_s, speed_m_s, turn_rate_rad_s, moved_m, .. } => {
                let commanded = if speed_m_s.abs() < 0.005 {
                    format!("{turn_rate_rad_s:.2} rad/s")
                } else {
                    format!("{speed_m_s:.2} m/s")
                };
                write!(out, "is commanded {commanded} and has moved {moved_m:.2} m in {for_s:.0} s")
            }
        }
    }
}

/// The unit that poses may be in, if one is near.
fn unit(factor: f64) -> Option<&'static str> {
    let units =
        [(1000.0, "millimetres?"), (100.0, "centimetres?"), (39.37, "inches?"), (3.281, "feet?")];
    let is_near = |unit: f64| (0.7..1.4).contains(&(factor / unit));
    units.into_iter().find(|(unit, _)| is_near(*unit)).map(|(_, name)| name)
}

/// Two digits of it, and thousands apart.
fn rounded(factor: f64) -> String {
    let digits = libm::floor(libm::log10(factor)) - 1.0;
    let step = libm::pow(10.0, digits);
    let whole = (factor / step).round() * step;
    if whole < 10.0 { format!("{whole:.1}") } else { count(whole.round() as u64) }
}

/// What is known beside the trajectory.
#[derive(Clone, Debug)]
pub struct Known<'a> {
    /// The robots' bodies, and what is there besides: who is beside an object may push it, and be held back.
    pub bodies: Bodies,
    /// Distance of the arena's walls from the origin, in metres; `None` where there are none.
    pub walls_m: Option<f64>,
    /// Rows of robots about which nothing is asked: they were lost, or were not seen.
    pub left_out: &'a [usize],
    /// Times in which a robot was not seen, and its poses are made up.
    pub unseen: &'a [Unseen],
}

/// A time in which a robot was not seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unseen {
    /// Its row.
    pub row: usize,
    /// From when, in seconds from the start.
    pub from_s: f64,
    /// Until when, likewise.
    pub to_s: f64,
}

/// What of a trajectory cannot be; of each robot the first thing that explains it. A commanded
/// robot may stand for `stood_s`, in seconds.
pub fn implausible(trajectory: &Trajectory, known: &Known, stood_s: f64) -> Vec<Implausible> {
    if trajectory.n_samples() < 2 || trajectory.period_s <= 0.0 {
        return Vec::new();
    }
    let (bodies, walls_m) = (&known.bodies, known.walls_m);
    let space = walls_m.and_then(|walls_m| bodies.world.free_space(2.0 * walls_m));
    let surroundings = Surroundings { bodies, walls_m, space: space.as_ref() };
    let robots: Vec<Robot> = (0..trajectory.n_robots)
        .filter(|row| !known.left_out.contains(row))
        .map(|row| {
            Robot::new(
                Motion::new(row, trajectory, surroundings).without(row, known.unseen),
                row,
                stood_s,
            )
        })
        .collect();
    let mut found = Findings::default();
    on_a_line(&robots, &mut found);
    for robot in &robots {
        found.add(robot.row, robot.too_far());
    }
    for robot in &robots {
        found.add(robot.row, robot.stands);
    }
    headings(&robots, &mut found);
    mirrored(&robots, &mut found);
    swapped(&robots, &mut found);
    found.0
}

/// Findings, each robot in one of them.
#[derive(Default)]
struct Findings(Vec<Implausible>);

impl Findings {
    fn has(&self, row: usize) -> bool {
        self.0.iter().any(|found| found.robots.contains(&row))
    }

    fn add(&mut self, row: usize, cause: Option<Implausibility>) {
        let Some(cause) = cause.filter(|_| !self.has(row)) else { return };
        // Each robot that stands has numbers of its own, and so does each pair.
        let is_shared = cause.is_of_poses() && cause != Implausibility::Swapped;
        match self.0.iter_mut().find(|found| is_shared && found.cause.is_like(&cause)) {
            Some(found) => found.robots.push(row),
            None => self.0.push(Implausible { cause, robots: vec![row] }),
        }
    }
}

/// One robot with what its motion shows.
struct Robot {
    row: usize,
    motion: Motion,
    way: Way,
    turning: Turning,
    stands: Option<Implausibility>,
}

impl Robot {
    fn new(motion: Motion, row: usize, stood_s: f64) -> Self {
        let (way, turning) = (Way::new(&motion), Turning::new(&motion));
        let stands = standing::stands(&motion, stood_s);
        Self { row, motion, way, turning, stands }
    }

    fn too_far(&self) -> Option<Implausibility> {
        let Distances { moved_m, commanded_m, along_m } = self.way.distances?;
        let is_too_far = moved_m > TOO_FAR * along_m + NOISE_M;
        is_too_far.then(|| Implausibility::Scale { factor: moved_m / commanded_m })
    }

    /// A heading that does not belong to the way that the robot drove.
    fn of_heading(&self) -> Option<Implausibility> {
        let way = &self.way;
        if way.n_driven < MIN_WINDOWS {
            return None;
        }
        // A heading that jumps by half a turn is one about a horizontal axis.
        // Gusts turn the way of a robot that is commanded to turn to and fro, and heads one way.
        let is_to_turn = self.turning.factor().is_some_and(|factor| factor < STANDS);
        let heading_stands = way.heading.concentration > CONSTANT && is_to_turn;
        let way_turns = way.direction.concentration < TOGETHER;
        if heading_stands && way_turns {
            let degrees =
                self.turning.factor().filter(|factor| *factor < 1.0 && is_degrees(1.0 / factor));
            return Some(degrees.map_or(Implausibility::HeadingStands, |factor| {
                Implausibility::Degrees { factor }
            }));
        }
        if way.together() < APART {
            if way.mirrored.concentration > TOGETHER {
                return Some(Implausibility::HeadingMirrored);
            }
            let is_degrees = turning::turns_by_degrees(&self.motion);
            let degrees = Implausibility::Degrees { factor: 180.0 / PI };
            return Some(if is_degrees { degrees } else { Implausibility::HeadingUnrelated });
        }
        // Only a way that turns with its heading shows that the angle between them stays.
        let offset_rad = way.against_heading.mean_rad;
        let is_askew = way.together() > ASKEW && offset_rad.abs() > MOST_ASKEW_RAD;
        (is_askew && way_turns && self.turning.follows())
            .then(|| Implausibility::Askew { by_deg: offset_rad.to_degrees() })
    }

    /// A robot that drives as it heads, and turns far less than it is commanded.
    fn of_turning(&self) -> Option<Implausibility> {
        let is_together = self.way.n_driven >= MIN_WINDOWS && self.way.together() > TOGETHER;
        let factor = self.turning.factor().filter(|_| is_together)?;
        (self.turning.is_shown() && factor < 0.1 && is_degrees(1.0 / factor))
            .then_some(Implausibility::Degrees { factor })
    }
}

/// Within a factor of two of a radian in degrees.
fn is_degrees(factor: f64) -> bool {
    (0.5..2.0).contains(&(factor * PI / 180.0))
}

/// Headings that do not belong to the way: a fault of the frame shows on most robots at once, that of one
/// robot after a while.
fn headings(robots: &[Robot], found: &mut Findings) {
    let drive = || robots.iter().filter(|robot| robot.way.n_driven >= MIN_WINDOWS);
    let wrong: Vec<(&Robot, Implausibility)> = drive()
        .filter_map(|robot| Some((robot, robot.of_heading().or_else(|| robot.of_turning())?)))
        .collect();
    let are_most = wrong.len() >= 2 && 2 * wrong.len() >= drive().count();
    for (robot, cause) in wrong {
        let is_shown = robot.way.n_driven >= MIN_WINDOWS_ALONE && !is_excused(robot, cause);
        if are_most || is_shown {
            found.add(robot.row, Some(cause));
        }
    }
}

/// Whether gusts explain it: they drive a slow robot where it does not head, and one that leans against its
/// commands hardly turns. Its heading follows them from moment to moment, which one that stands or is in
/// another unit does not.
fn is_excused(robot: &Robot, cause: Implausibility) -> bool {
    let is_of_heading = matches!(
        cause,
        Implausibility::HeadingStands
            | Implausibility::HeadingUnrelated
            | Implausibility::Degrees { factor: 1.0.. }
    );
    is_of_heading && robot.turning.steers()
}

/// Another axis is up: all poses lie on a line, and headings are 0° or 180°.
fn on_a_line(robots: &[Robot], found: &mut Findings) {
    let axis = |robot: &Robot| {
        let [x_m, y_m] = robot.motion.extents_m();
        let turns = robot.turning.commanded_turns();
        let long_m = x_m.max(y_m);
        let is_line = x_m.min(y_m) < LINE * long_m && long_m > MIN_EXTENT_M;
        let heads_along = robot.way.all_headings.concentration > CONSTANT;
        (turns && is_line && heads_along).then_some(if x_m > y_m {
            FloorAxis::X
        } else {
            FloorAxis::Y
        })
    };
    let on_line: Vec<(usize, FloorAxis)> =
        robots.iter().filter_map(|robot| Some((robot.row, axis(robot)?))).collect();
    for axis in [FloorAxis::X, FloorAxis::Y] {
        let rows = on_line.iter().filter(|(_, along)| *along == axis);
        if rows.clone().count() as f64 >= MOST * robots.len() as f64 {
            rows.for_each(|(row, _)| found.add(*row, Some(Implausibility::Line { axis })));
        }
    }
}

/// Turning that is reversed against the commands.
///
/// A robot that leans to one side steers against it, and so may turn the other way than it is commanded
/// on the whole; it follows its commands from moment to moment, unless all of them show the same.
fn mirrored(robots: &[Robot], found: &mut Findings) {
    // A heading that is mirrored by itself does not go with the way.
    let is_reversed = |robot: &&Robot| {
        let is_alone = robot.way.n_driven >= MIN_WINDOWS && robot.way.together() < TOGETHER;
        robot.turning.is_reversed() && !is_alone && !found.has(robot.row)
    };
    let reversed: Vec<&Robot> = robots.iter().filter(is_reversed).collect();
    let n_shown = robots.iter().filter(|robot| robot.turning.is_shown()).count();
    let are_most = reversed.len() >= 2 && reversed.len() as f64 >= MOST * n_shown as f64;
    for robot in reversed {
        if are_most || robot.turning.is_reversed_by_itself() {
            found.add(robot.row, Some(Implausibility::Mirrored));
        }
    }
}

/// Robots that follow the commands of others, and these those of them in turn.
fn swapped(robots: &[Robot], found: &mut Findings) {
    let suspects: Vec<&Robot> = robots
        .iter()
        .filter(|robot| !found.has(robot.row) && robot.turning.own.correlation < MIN_FOLLOWED)
        .take(MOST_SUSPECTS)
        .collect();
    let leader = |robot: &&Robot| {
        let followed = |other: &&Robot| follow(&robot.motion, &other.motion);
        let others = suspects.iter().filter(|other| other.row != robot.row);
        let (best, other) = others
            .map(|other| (followed(other), other.row))
            .max_by(|one, other| one.0.correlation.total_cmp(&other.0.correlation))?;
        let is_clear = best.is_sure() && best.correlation > robot.turning.own.correlation + 0.3;
        is_clear.then_some((robot.row, other))
    };
    let leaders: Vec<(usize, usize)> = suspects.iter().filter_map(leader).collect();
    let leader_of = |row: usize| leaders.iter().find(|(robot, _)| *robot == row).map(|pair| pair.1);
    for (first, _) in &leaders {
        let mut circle = vec![*first];
        while let Some(next) = leader_of(circle[circle.len() - 1]) {
            if next == *first || circle.len() > leaders.len() {
                break;
            }
            circle.push(next);
        }
        let is_closed = leader_of(circle[circle.len() - 1]) == Some(*first);
        if is_closed && circle.len() <= leaders.len() && !found.has(*first) {
            circle.sort_unstable();
            found.0.push(Implausible { cause: Implausibility::Swapped, robots: circle });
        }
    }
}

/// Robots that are held against each other, at most: their number squared is worked through.
const MOST_SUSPECTS: usize = 30;
