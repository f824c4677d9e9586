//! The judge: which phase of a behaviour a run settled into.

#![expect(
    clippy::inline_always,
    reason = "what is not inlined into the function of a vector unit does without its instructions"
)]

mod by_reach;

use std::ops::Range;

use crate::judge::behaviour::Behaviour;
use crate::judge::behaviour::rule::Rules;
use crate::judge::number::Number;
use crate::judge::order::{
    OrderParameters, Parameter, Prerequisite, Samples, Sums, sums_with_blocks,
};
use crate::judge::trajectory::{Bodies, Trajectory};
use crate::judge::window::{BLOCK_S, Window, samples_in};
use crate::robot::controller::Command;
use crate::robot::unicycle::Pose;

pub use crate::judge::behaviour::phase::{MOST_PHASES, Phase, unknown};

/// The verdict of the judge on one run.
#[derive(Clone, Debug, PartialEq)]
pub struct Verdict {
    /// What the swarm settled into.
    pub phase: Phase,
    /// The order parameters of the window that decides.
    pub evidence: OrderParameters,
    /// Those of each of its blocks of [`BLOCK_S`] by itself.
    pub blocks: Vec<OrderParameters>,
    /// Number of robots.
    pub n_robots: usize,
    /// Time that was recorded, in seconds.
    pub duration_s: f64,
}

/// Why a trajectory cannot be judged.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum JudgeError {
    /// There is no robot to judge.
    #[error("no robots, expected at least 1")]
    NoRobots,
    /// The recorded time is shorter than the window.
    #[error("{duration_s:.1} s recorded, expected at least {} s", window.least_s())]
    TooShort {
        /// Recorded time, in seconds.
        duration_s: f64,
        /// Which time is judged.
        window: Window,
    },
    /// A pose or a command that is not a finite number.
    #[error(
        "robot {robot} has a pose or command that is not finite, {time_s:.2} s after the start"
    )]
    NotFinite {
        /// Index of the robot.
        robot: usize,
        /// When, in seconds from the start.
        time_s: f64,
    },
    /// The time between samples is none.
    #[error("the period is {period_s} s, expected more than 0")]
    Period {
        /// Time between samples, in seconds.
        period_s: f64,
    },
    /// A pose or a command that can be none of a robot's, however it is measured.
    #[error(
        "robot {robot} has a pose or command beyond {MOST:e}, {time_s:.2} s after the start; poses are in \
         metres and radians"
    )]
    TooLarge {
        /// Index of the robot.
        robot: usize,
        /// When, in seconds from the start.
        time_s: f64,
    },
    /// What was commanded is unknown, and with it who is blocked and how far robots were to drive; with the phases that
    /// are possible, in the order in which the judge looks.
    #[error(
        "what the robots were commanded is not known, and decides between {}",
        alternatives(.0)
    )]
    UnknownCommands(Vec<Phase>),
    /// So is the reach.
    #[error(
        "neither what the robots were commanded nor their reach is known, and they decide between {}",
        alternatives(.0)
    )]
    UnknownCommandsAndReach(Vec<Phase>),
    /// The radius of the bodies is unknown.
    #[error("the radius of the robots' bodies is not known, and {0} depends on it")]
    UnknownRadius(Parameter),
    /// There is no arena.
    #[error("{0} is of an arena with walls, and there is none, or it is not known")]
    NoArena(Parameter),
    /// An object is nowhere.
    #[error("object {object} is nowhere, or beyond {MOST:e} m, {time_s:.2} s after the start")]
    ObjectNotFinite {
        /// Index of the object.
        object: usize,
        /// When, in seconds from the start.
        time_s: f64,
    },
    /// There are no objects.
    #[error("{0} is of objects, and there are none, or none is known")]
    NoObjects(Parameter),
    /// There are no goals.
    #[error("{0} is of goals, and there are none, or none is known")]
    NoGoals(Parameter),
    /// Robots are of no classes.
    #[error("{0} is of classes of robots, and there are none, or none is known")]
    NoClasses(Parameter),
    /// Classes of other robots than these.
    #[error(
        "the classes of {found} robots are known, of {expected}, and {parameter} depends on them"
    )]
    UnknownClasses {
        /// The order parameter that a rule asks for.
        parameter: Parameter,
        /// Robots whose class is known.
        found: usize,
        /// Robots that there are.
        expected: usize,
    },
    /// Nobody wrote down where the objects were.
    #[error("where the {expected} objects were is known of {found}, and {parameter} depends on it")]
    UnknownObjects {
        /// The order parameter that a rule asks for.
        parameter: Parameter,
        /// Objects whose poses are known.
        found: usize,
        /// Objects that there are.
        expected: usize,
    },
    /// The reach is unknown, and with it who has lost whom: another reach is another phase.
    #[error("the robots' reach is not known, and decides: {}", by_reach::in_words(phases))]
    UnknownReach {
        /// The phase from each reach on, in metres, ascending; the first one from 0.
        phases: Vec<(f64, Phase)>,
    },
}

/// `stable milling, semi-stable milling and unformed`.
fn alternatives(phases: &[Phase]) -> String {
    let titles: Vec<&str> = phases.iter().map(|phase| phase.title()).collect();
    match titles.split_last() {
        Some((last, others)) if !others.is_empty() => format!("{} and {last}", others.join(", ")),
        _ => titles.concat(),
    }
}

/// No coordinate, heading, speed or turning rate of a robot is greater, in metres, radians and seconds:
/// the squares of such numbers are still finite, and millimetres are told apart at such a distance.
const MOST: f64 = 1e9;

/// As many good blocks in a row are a mill that has formed.
pub const GOOD_BLOCKS: usize = 3;

/// Labels a run as milling or what it came to instead: simulated or real, by what a bag can contain.
///
/// Motion comes before shape: a jammed ring is round, too. And a mill lasts: at most one of the
/// window's six blocks may break the rule of stable milling ([`Rules::lasting`]). Only the last
/// [`WINDOW_S`](crate::judge::window::WINDOW_S) of a trajectory are judged, and no shorter one is.
///
/// # Source
///
/// The phases of §IV step 3; the paper labelled by eye, the bounds are ours ([`Behaviour::rules`]).
pub fn label(trajectory: &Trajectory, bodies: &Bodies) -> Result<Verdict, JudgeError> {
    label_with(trajectory, bodies, &Behaviour::MILLING.rules())
}

/// As [`label`], by the rules of another behaviour or with other bounds. Where they look at what
/// needs a radius or an arena, that has to be known.
pub fn label_with(
    trajectory: &Trajectory,
    bodies: &Bodies,
    rules: &Rules,
) -> Result<Verdict, JudgeError> {
    let verdict = at_any_reach(trajectory, bodies, rules)?;
    if verdict.evidence.lost.is_none() && rules.ask_for(Parameter::LOST) {
        let phases = by_reach::phases(trajectory, bodies, rules);
        return Err(JudgeError::UnknownReach { phases });
    }
    Ok(verdict)
}

/// As [`label_with`], of a run of which the poses alone are known ([`Trajectory::of_poses`]).
///
/// Of the verdict's evidence nothing that [needs commands](Parameter::needs_commands) means
/// anything. A run whose phase depends on what was commanded is refused: a jammed ring and one that
/// runs have one shape.
pub fn label_without_commands(
    trajectory: &Trajectory,
    bodies: &Bodies,
    rules: &Rules,
) -> Result<Verdict, JudgeError> {
    let verdict = at_any_reach(trajectory, bodies, rules)?;
    let reach_is_known = verdict.evidence.lost.is_some();
    let is_known = |parameter: Parameter| {
        if parameter == Parameter::LOST { reach_is_known } else { !parameter.needs_commands() }
    };
    let phases = rules.possible(&verdict.evidence, is_known);
    match phases[..] {
        [_] => Ok(verdict),
        _ if !rules.need_commands() => label_with(trajectory, bodies, rules),
        _ if reach_is_known => Err(JudgeError::UnknownCommands(phases)),
        _ => Err(JudgeError::UnknownCommandsAndReach(phases)),
    }
}

/// The verdict where an unknown reach is taken to be enough.
fn at_any_reach(
    trajectory: &Trajectory,
    bodies: &Bodies,
    rules: &Rules,
) -> Result<Verdict, JudgeError> {
    check(trajectory, rules.window)?;
    rules.check_known(bodies)?;
    check_numbers(trajectory, bodies, rules)?;
    let window = JudgedWindow::new(trajectory, trajectory.n_samples(), bodies, rules).remove(0);
    Ok(Verdict {
        phase: window.phase,
        evidence: window.whole,
        blocks: window.blocks,
        n_robots: trajectory.n_robots,
        duration_s: trajectory.duration_s(),
    })
}

/// The order parameters of the window that decides on a run.
#[derive(Clone, Debug)]
pub struct JudgedWindow {
    /// Which samples it has.
    pub samples: Range<usize>,
    /// Of all of it.
    pub whole: OrderParameters,
    /// Of each of its blocks of [`BLOCK_S`] by itself.
    pub blocks: Vec<OrderParameters>,
    /// What the run settled into.
    pub phase: Phase,
}

impl JudgedWindow {
    /// The window of each world that decides by these rules: of several the first one in the wanted phase, and if
    /// there is none the last. There are samples for at least one.
    #[inline(always)]
    pub fn new<S: Samples>(
        samples: &S,
        n_samples: usize,
        bodies: &Bodies,
        rules: &Rules,
    ) -> Vec<Self> {
        let asked = rules.asked();
        let mut decided: Vec<Option<Self>> = vec![None; S::Number::LANES];
        for window in rules.window.samples(n_samples, samples.period_s()) {
            let is_last = window.end == n_samples;
            let looked_at = Self::in_window(samples, &window, bodies, (rules, &asked));
            for (decided, found) in decided.iter_mut().zip(looked_at) {
                if decided.is_none() && (is_last || found.phase == rules.wanted) {
                    *decided = Some(found);
                }
            }
            if decided.iter().all(Option::is_some) {
                break;
            }
        }
        decided.into_iter().flatten().collect()
    }

    /// What one window of each world shows.
    #[inline(always)]
    fn in_window<S: Samples>(
        samples: &S,
        window: &Range<usize>,
        bodies: &Bodies,
        (rules, asked): (&Rules, &[Parameter]),
    ) -> Vec<Self> {
        let n_block = samples_in(BLOCK_S, samples.period_s()).min(window.len());
        let (whole, blocks) = sums_with_blocks(samples, window.clone(), bodies, n_block);
        let evidence = |sums: &Sums<S::Number>, lane| sums.evidence((samples, bodies), lane, asked);
        let of_lane = |lane| {
            let whole = evidence(&whole, lane);
            let in_block = |sums| of_whole_where_it_adds_up(evidence(sums, lane), &whole, asked);
            let blocks: Vec<OrderParameters> = blocks.iter().map(in_block).collect();
            let phase = rules.lasting(rules.phase(&whole), n_good(&blocks, rules), blocks.len());
            Self { samples: window.clone(), whole, blocks, phase }
        };
        (0..S::Number::LANES).map(of_lane).collect()
    }
}

/// A block with what the whole window came to, of all that grows with the window: a part of it shows less.
fn of_whole_where_it_adds_up(
    mut block: OrderParameters,
    whole: &OrderParameters,
    asked: &[Parameter],
) -> OrderParameters {
    for parameter in asked.iter().filter(|it| it.adds_up()) {
        if let Some(value) = parameter.value(whole) {
            parameter.set(&mut block, value);
        }
    }
    block
}

/// How many blocks satisfy the rule of the wanted phase by themselves.
pub(crate) fn n_good(blocks: &[OrderParameters], rules: &Rules) -> usize {
    blocks.iter().filter(|evidence| rules.is_wanted(evidence)).count()
}

/// When a run that ended in the wanted phase of its behaviour began to, in seconds from the start:
/// the start of the first three consecutive blocks of 10 s that satisfy that phase's rule. `phase`
/// is that of [`label`]; `None` if it is not the wanted one, or if the run never stayed in it for
/// three blocks.
pub fn converged_s(trajectory: &Trajectory, bodies: &Bodies, phase: Phase) -> Option<f64> {
    let behaviour = phase.behaviour();
    if phase != behaviour.wanted() {
        return None;
    }
    let rules = behaviour.rules();
    let asked = rules.asked();
    let n_block = samples_in(BLOCK_S, trajectory.period_s);
    let mut good_blocks = 0;
    for block in 0..trajectory.n_samples() / n_block {
        let samples = block * n_block..(block + 1) * n_block;
        let is_good = rules.is_wanted(&OrderParameters::with(trajectory, samples, bodies, &asked));
        good_blocks = if is_good { good_blocks + 1 } else { 0 };
        if good_blocks == GOOD_BLOCKS {
            let first = block + 1 - GOOD_BLOCKS;
            return Some((first * n_block) as f64 * trajectory.period_s);
        }
    }
    None
}

/// The samples that decide on the phase of a run, which is finite throughout and long enough for
/// the window of the rules.
pub fn judged_samples(trajectory: &Trajectory, bodies: &Bodies, rules: &Rules) -> Range<usize> {
    let n_samples = trajectory.n_samples();
    match rules.window {
        Window::Ever => JudgedWindow::new(trajectory, n_samples, bodies, rules).remove(0).samples,
        window => n_samples - window.n_samples(n_samples, trajectory.period_s)..n_samples,
    }
}

impl Rules {
    /// Refuses rules that look at what cannot be known of these robots: their radius, an arena, or what
    /// is in it.
    pub fn check_known(&self, bodies: &Bodies) -> Result<(), JudgeError> {
        for parameter in self.parameters() {
            match parameter.lacks(bodies) {
                Some(Prerequisite::Arena) => return Err(JudgeError::NoArena(parameter)),
                Some(Prerequisite::Objects) => return Err(JudgeError::NoObjects(parameter)),
                Some(Prerequisite::Goals) => return Err(JudgeError::NoGoals(parameter)),
                Some(Prerequisite::Classes) => return Err(JudgeError::NoClasses(parameter)),
                Some(_) => return Err(JudgeError::UnknownRadius(parameter)),
                None => {}
            }
        }
        Ok(())
    }
}

/// Refuses rules that look at objects whose places are not known, or at classes of robots which are
/// those of others.
fn check_numbers(
    trajectory: &Trajectory,
    bodies: &Bodies,
    rules: &Rules,
) -> Result<(), JudgeError> {
    let parameters = rules.parameters();
    let first = |need| parameters.iter().copied().find(|parameter| parameter.needs(need));
    let (found, expected) = (trajectory.n_objects, bodies.world.n_objects());
    if let Some(parameter) = first(Prerequisite::Objects).filter(|_| found != expected) {
        return Err(JudgeError::UnknownObjects { parameter, found, expected });
    }
    let (found, expected) = (bodies.classes.len(), trajectory.n_robots);
    match first(Prerequisite::Classes).filter(|_| found != expected) {
        Some(parameter) => Err(JudgeError::UnknownClasses { parameter, found, expected }),
        None => Ok(()),
    }
}

fn check(trajectory: &Trajectory, window: Window) -> Result<(), JudgeError> {
    if trajectory.n_robots == 0 {
        return Err(JudgeError::NoRobots);
    }
    assert_eq!(trajectory.poses.len(), trajectory.commands.len(), "one command for each pose");
    let period_s = trajectory.period_s;
    if !(period_s.is_finite() && period_s > 0.0) {
        return Err(JudgeError::Period { period_s });
    }
    let numbers = |(pose, command): (&Pose, &Command)| {
        let Command { speed_m_s, turn_rate_rad_s } = *command;
        [pose.x_m, pose.y_m, pose.heading_rad, speed_m_s, turn_rate_rad_s]
    };
    // What is not a number is not within either.
    let is_within = |numbers: &[f64; 5]| numbers.iter().all(|number| number.abs() <= MOST);
    let mut rows = trajectory.poses.iter().zip(&trajectory.commands).map(numbers).enumerate();
    if let Some((row, numbers)) = rows.find(|(_, numbers)| !is_within(numbers)) {
        let robot = row % trajectory.n_robots;
        let time_s = (row / trajectory.n_robots) as f64 * period_s;
        return Err(if numbers.into_iter().all(f64::is_finite) {
            JudgeError::TooLarge { robot, time_s }
        } else {
            JudgeError::NotFinite { robot, time_s }
        });
    }
    let objects = trajectory.n_samples() * trajectory.n_objects;
    assert_eq!(trajectory.objects_m.len(), objects, "one place for each object in each sample");
    let is_known = |place_m: &[f64; 2]| place_m.iter().all(|at_m| at_m.abs() <= MOST);
    if let Some(row) = trajectory.objects_m.iter().position(|place_m| !is_known(place_m)) {
        let object = row % trajectory.n_objects;
        let time_s = (row / trajectory.n_objects) as f64 * period_s;
        return Err(JudgeError::ObjectNotFinite { object, time_s });
    }
    if trajectory.n_samples() < samples_in(window.least_s(), trajectory.period_s) {
        return Err(JudgeError::TooShort { duration_s: trajectory.duration_s(), window });
    }
    Ok(())
}
