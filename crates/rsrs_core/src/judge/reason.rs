//! Why a run has its phase: the rules that decide it, and which robot left the others when.

use std::cmp::Ordering;
use std::fmt;

use crate::judge::behaviour::Behaviour;
use crate::judge::behaviour::condition::Condition;
use crate::judge::behaviour::rule::Rules;
use crate::judge::order::{OrderParameters, centre};
use crate::judge::phase::{Phase, Verdict, judged_samples, n_good};
use crate::judge::trajectory::{Bodies, Trajectory};
use crate::judge::window::{BLOCK_S, samples_in};
use crate::statistics::median;

/// Why a run has its phase.
#[derive(Clone, Debug, PartialEq)]
pub struct Reason {
    /// Bounds that give the phase: those of dispersion or collision that hold, or those of a mill that
    /// do not. Empty for the wanted phase, which keeps all of them.
    pub rules: Vec<Decisive>,
    /// Of a mill that is stable on the whole and does not last: blocks of the window that break the
    /// rule of stable milling by themselves, and all of them.
    pub broken_blocks: Option<(usize, usize)>,
    /// Robots that left the others and stayed away, the first one first.
    pub departures: Vec<Departure>,
}

/// An order parameter beside the bound that decides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Decisive {
    /// The phase whose rule it is.
    pub phase: Phase,
    /// The order parameter and its bound.
    pub condition: Condition,
    /// What was found.
    pub found: f64,
}

/// A robot that left.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Departure {
    /// Its index.
    pub robot: usize,
    /// When it was seen to be away first, in seconds from the start, to a block of 10 s.
    pub time_s: f64,
    /// From what.
    pub from: Left,
}

/// What a robot left.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Left {
    /// The ring of the others, which goes on.
    Ring,
    /// Everybody's reach.
    Others,
}

/// A robot is off the ring if its distance from the centre is this much of the ring's radius, or less
/// than its inverse.
const OFF_RING: f64 = 1.5;

impl Reason {
    /// The reason of a verdict of [`crate::judge::phase::label_with`] on this trajectory by these
    /// rules.
    pub fn new(trajectory: &Trajectory, bodies: &Bodies, verdict: &Verdict, rules: &Rules) -> Self {
        let (n_good, n_blocks) = (n_good(&verdict.blocks, rules), verdict.blocks.len());
        let does_not_last = verdict.phase != rules.phase(&verdict.evidence);
        Self {
            rules: decisive(rules, verdict.phase, &verdict.evidence),
            broken_blocks: does_not_last.then_some((n_blocks - n_good, n_blocks)),
            departures: departures(trajectory, bodies, verdict.phase),
        }
    }
}

impl Reason {
    /// The reason in words, a sentence each.
    ///
    /// `wanted` is the wanted phase of the rules, `robots` has the robots' names, shape `[n_robots]`.
    pub fn sentences(&self, wanted: Phase, robots: &[String]) -> Vec<String> {
        let rules = self.rules.iter().map(Decisive::to_string);
        let broken = self.broken_blocks.map(|(n_broken, n_blocks)| {
            format!("{n_broken} of {n_blocks} blocks of 10 s break the rule of {wanted}")
        });
        let departed = |departure: &Departure| {
            let Departure { robot, time_s, from } = departure;
            let from = match from {
                Left::Ring => "left the ring",
                Left::Others => "left everybody's reach",
            };
            format!("{} {from} at {time_s:.0} s", robots[*robot])
        };
        rules.chain(broken).chain(self.departures.iter().map(departed)).collect()
    }
}

/// The bounds that decide on a phase, by [`Rules::phase`].
///
/// A phase that comes before the wanted one is there by what holds of its rules, one that comes after
/// it by what does not hold of the last rule before its own.
fn decisive(rules: &Rules, phase: Phase, evidence: &OrderParameters) -> Vec<Decisive> {
    let place = |phase: Phase| rules.rules.iter().position(|rule| rule.phase == phase);
    let (own, wanted) = (place(phase).unwrap_or(rules.rules.len()), place(rules.wanted));
    match Some(own).cmp(&wanted) {
        Ordering::Less => of_rules(rules, phase, |condition| condition.holds(evidence), evidence),
        Ordering::Equal => Vec::new(),
        Ordering::Greater => {
            let broken = rules.rules[own - 1].phase;
            of_rules(rules, broken, |condition| !condition.holds(evidence), evidence)
        }
    }
}

fn of_rules(
    rules: &Rules,
    phase: Phase,
    decides: impl Fn(&Condition) -> bool,
    evidence: &OrderParameters,
) -> Vec<Decisive> {
    let conditions = rules.of(phase).flat_map(|rule| &rule.conditions);
    let decisive = |condition: &Condition| {
        let (condition, found) = (*condition, condition.parameter.of(evidence));
        Decisive { phase, condition, found }
    };
    conditions.filter(|condition| decides(condition)).map(decisive).collect()
}

/// `circliness 0.41, and 0.50 or more is stable milling`.
impl fmt::Display for Decisive {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { phase, condition, found } = self;
        let parameter = condition.parameter;
        let found = parameter.with_unit(*found);
        write!(formatter, "{parameter} {found}, and {condition} is {phase}")
    }
}

/// Robots that are away at the end, since the block of 10 s from which on they always were.
fn departures(trajectory: &Trajectory, bodies: &Bodies, phase: Phase) -> Vec<Departure> {
    let from = match phase {
        Phase::SEMI_STABLE_MILLING | Phase::UNFORMED => Left::Ring,
        Phase::DISPERSION => Left::Others,
        _ => return Vec::new(),
    };
    let n_block = samples_in(BLOCK_S, trajectory.period_s);
    let n_blocks = trajectory.n_samples() / n_block;
    let away = |block: usize| away(trajectory, (block * n_block, n_block), (from, bodies.reach_m));
    let Some(at_end) = n_blocks.checked_sub(1).map(away) else { return Vec::new() };
    if from == Left::Ring && !others_mill(trajectory, bodies, &at_end) {
        return Vec::new();
    }
    let mut since: Vec<Option<usize>> =
        at_end.iter().map(|is_away| is_away.then_some(n_blocks - 1)).collect();
    for block in (0..n_blocks - 1).rev() {
        let is_away = away(block);
        for (since, is_away) in since.iter_mut().zip(is_away) {
            if is_away && *since == Some(block + 1) {
                *since = Some(block);
            }
        }
    }
    let departure = |(robot, since): (usize, Option<usize>)| {
        let time_s = (since? * n_block) as f64 * trajectory.period_s;
        Some(Departure { robot, time_s, from })
    };
    let mut departures: Vec<Departure> =
        since.into_iter().enumerate().filter_map(departure).collect();
    departures.sort_by(|one, other| one.time_s.total_cmp(&other.time_s));
    departures
}

/// Whether robots that are not away mill, at least semi-stably: else there is no ring that one could
/// leave.
fn others_mill(trajectory: &Trajectory, bodies: &Bodies, is_away: &[bool]) -> bool {
    let stayed: Vec<usize> = (0..is_away.len()).filter(|robot| !is_away[*robot]).collect();
    if stayed.len() < 2 {
        return false;
    }
    let mut others = Trajectory::new(trajectory.period_s, stayed.len());
    let rules = Behaviour::MILLING.rules();
    for sample in judged_samples(trajectory, bodies, &rules) {
        let (poses, commands) = (trajectory.poses_at(sample), trajectory.commands_at(sample));
        others.poses.extend(stayed.iter().map(|robot| poses[*robot]));
        others.commands.extend(stayed.iter().map(|robot| commands[*robot]));
    }
    let order = OrderParameters::new(&others, 0..others.n_samples(), bodies);
    rules.of(rules.not_lasting).any(|rule| rule.holds(&order))
}

/// Which robots are away for most of a block.
fn away(
    trajectory: &Trajectory,
    (start, n_samples): (usize, usize),
    (from, reach_m): (Left, Option<f64>),
) -> Vec<bool> {
    let mut n_away = vec![0; trajectory.n_robots];
    for sample in start..start + n_samples {
        let poses = trajectory.poses_at(sample);
        let places: Vec<(f64, f64)> = poses.iter().map(|pose| (pose.x_m, pose.y_m)).collect();
        let is_away: Vec<bool> = match from {
            Left::Ring => off_ring(&places),
            Left::Others => alone(&places, reach_m.unwrap_or(f64::INFINITY)),
        };
        for (n_away, is_away) in n_away.iter_mut().zip(is_away) {
            *n_away += usize::from(is_away);
        }
    }
    n_away.into_iter().map(|n_away| 2 * n_away > n_samples).collect()
}

fn distance_m(one: (f64, f64), other: (f64, f64)) -> f64 {
    libm::hypot(one.0 - other.0, one.1 - other.1)
}

/// Who is not on the ring of most of the robots: its centre is the median of the places, which one
/// that left does not move by much.
fn off_ring(places: &[(f64, f64)]) -> Vec<bool> {
    let median_of = |number: fn(&(f64, f64)) -> f64| median(places.iter().map(number).collect());
    let middle = (median_of(|place| place.0), median_of(|place| place.1));
    let far_m = OFF_RING * median(places.iter().map(|place| distance_m(*place, middle)).collect());
    // Those who stayed have a better centre.
    let stayed: Vec<(f64, f64)> =
        places.iter().copied().filter(|place| distance_m(*place, middle) <= far_m).collect();
    let centre = centre(&stayed);
    let radii_m: Vec<f64> = places.iter().map(|place| distance_m(*place, centre)).collect();
    let ring_m = median(radii_m.clone());
    let is_off = |radius_m: &f64| *radius_m > OFF_RING * ring_m || *radius_m < ring_m / OFF_RING;
    radii_m.iter().map(is_off).collect()
}

/// Who has nobody within reach.
fn alone(places: &[(f64, f64)], reach_m: f64) -> Vec<bool> {
    let is_alone = |me: usize| {
        let others = places.iter().enumerate().filter(|(other, _)| *other != me);
        others.into_iter().all(|(_, place)| distance_m(*place, places[me]) > reach_m)
    };
    (0..places.len()).map(is_alone).collect()
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;
    use crate::judge::phase::label;
    use crate::robot::controller::Command;
    use crate::robot::unicycle::Pose;
    use crate::world::WorldFile;

    const PERIOD_S: f64 = 0.1;
    const BODIES: Bodies = Bodies {
        radius_m: Some(0.075),
        reach_m: Some(0.9),
        arena_m: None,
        world: WorldFile::NOTHING,
        classes: Vec::new(),
    };

    /// Nine robots on a ring, of which some leave along a line at a time.
    fn ring(leaving: &[(usize, f64)], duration_s: f64) -> Trajectory {
        let (radius_m, speed_m_s) = (0.7, 0.15);
        let mut trajectory = Trajectory::new(PERIOD_S, 9);
        let n_samples = (duration_s / PERIOD_S).round() as usize;
        for sample in 0..n_samples {
            let time_s = sample as f64 * PERIOD_S;
            for robot in 0..9 {
                let left_s = leaving.iter().find(|(who, _)| *who == robot).map(|(_, when)| *when);
                let on_ring_s = left_s.map_or(time_s, |left_s| time_s.min(left_s));
                let angle_rad = TAU * robot as f64 / 9.0 + speed_m_s / radius_m * on_ring_s;
                let (sine, cosine) = libm::sincos(angle_rad);
                let gone_m = speed_m_s * (time_s - on_ring_s);
                trajectory.poses.push(Pose {
                    x_m: radius_m * cosine - gone_m * sine,
                    y_m: radius_m * sine + gone_m * cosine,
                    heading_rad: angle_rad + TAU / 4.0,
                });
                trajectory.commands.push(Command { speed_m_s, turn_rate_rad_s: 0.2 });
            }
        }
        trajectory
    }

    fn reason(trajectory: &Trajectory) -> (Phase, Reason) {
        let verdict = label(trajectory, &BODIES).unwrap();
        (verdict.phase, Reason::new(trajectory, &BODIES, &verdict, &Behaviour::MILLING.rules()))
    }

    #[test]
    fn a_stable_mill_breaks_no_rule() {
        let (phase, reason) = reason(&ring(&[], 120.0));

        assert_eq!(phase, Phase::STABLE_MILLING);
        assert_eq!(reason, Reason { rules: vec![], broken_blocks: None, departures: vec![] });
    }

    #[test]
    fn a_robot_that_leaves_the_ring_is_named_with_its_time() {
        let (phase, reason) = reason(&ring(&[(5, 61.0)], 120.0));

        assert_ne!(phase, Phase::STABLE_MILLING);
        let [departure] = reason.departures[..] else { panic!("{reason:?}") };
        assert_eq!(departure.robot, 5);
        // It is off the ring when it is half a radius away.
        assert!((60.0..=80.0).contains(&departure.time_s), "{departure:?}");
        assert!(!reason.rules.is_empty());
    }

    #[test]
    fn of_a_dispersed_swarm_all_who_are_alone_are_named() {
        let leaving = [(0, 20.0), (3, 30.0), (6, 40.0)];
        let (phase, reason) = reason(&ring(&leaving, 120.0));

        assert_eq!(phase, Phase::DISPERSION, "{reason:?}");
        let robots: Vec<usize> = reason.departures.iter().map(|gone| gone.robot).collect();
        assert_eq!(robots, [0, 3, 6]);
        let rule = reason.rules[0].to_string();
        assert_eq!(rule, "lost 0.33, and 0.25 or more is dispersion");
    }
}
