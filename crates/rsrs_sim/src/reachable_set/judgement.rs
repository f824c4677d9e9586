//! Where real trials were, and how surprising that is.

use std::collections::BTreeMap;

use rsrs_core::robot::unicycle::Pose;
use rsrs_core::statistics::interval::Interval;
use rsrs_core::trials::trial::DrivenTrial;
use rsrs_core::trials::validation::{
    Exit, Horizon, LEVEL, ObjectPlace, RobotCoverage, TrialPlace, Tube, Validation,
    at_least_outside,
};

use super::regions::Regions;
use super::{Drives, Kind, Moved};

/// Where every trial was, and its object if it has one: the tubes of objects follow those of robots.
/// Regions are those of the robot of each kind, and of its object; shape `[n_kinds][n_bodies]`.
pub(super) fn places(
    trials: &[DrivenTrial],
    kinds: &[Kind],
    kind_of: &[usize],
    regions: &[Vec<Regions>],
) -> Vec<TrialPlace> {
    let mut object_tubes = kinds.len()..;
    let place = |(trial, kind): (&DrivenTrial, &usize)| {
        let exits = |moved: &DrivenTrial, body: usize| {
            let regions = &regions[*kind][body];
            let left =
                |(horizon, time_s)| exit(regions, horizon, time_s, moved.displacement_at(time_s));
            reached(&kinds[*kind], trial).filter_map(left).collect()
        };
        let object = trial.of_object().and_then(|object| {
            Some(ObjectPlace { tube: object_tubes.next()?, exits: exits(&object, 1) })
        });
        TrialPlace {
            robot: trial.robot.clone(),
            trial: trial.trial.clone(),
            tube: *kind,
            exits: exits(trial, 0),
            object,
        }
    };
    trials.iter().zip(kind_of).map(place).collect()
}

/// The tubes of all kinds, and those of the objects of all trials.
pub(super) fn tubes(
    trials: &[DrivenTrial],
    kinds: &[Kind],
    regions: &[Vec<Regions>],
    places: &[TrialPlace],
) -> Vec<Tube> {
    let made = |kind: usize, body: usize, index: usize| {
        let member = |(trial, place)| Some((trial, TrialPlace::exits_of(place, index)?));
        let members: Vec<_> = trials.iter().zip(places).filter_map(member).collect();
        let of_object = body > 0;
        Tube { of_object, ..tube(&kinds[kind], &regions[kind][body], &members) }
    };
    let of_robots = (0..kinds.len()).map(|kind| made(kind, 0, kind));
    let of_objects =
        places.iter().filter_map(|place| Some(made(place.tube, 1, place.object.as_ref()?.tube)));
    of_robots.chain(of_objects).collect()
}

/// The horizons that a trial lasts to.
fn reached<'a>(
    kind: &'a Kind,
    trial: &DrivenTrial,
) -> impl Iterator<Item = (usize, f64)> + use<'a> {
    let duration_s = trial.duration_s() + 1e-9;
    let horizons = kind.horizons_s.iter().copied().enumerate();
    horizons.take_while(move |(_, time_s)| *time_s <= duration_s)
}

fn exit(regions: &Regions, horizon: usize, time_s: f64, pose: Pose) -> Option<Exit> {
    let region = &regions.positions[horizon];
    let by_position = !region.contains([pose.x_m, pose.y_m]);
    let by_heading = !regions.heading_is_inside(horizon, pose.heading_rad);
    if !by_position && !by_heading {
        return None;
    }
    let [least_rad, most_rad] = regions.headings_rad[horizon];
    let [x_m, y_m] = region.mean_m;
    let middle = Pose { x_m, y_m, heading_rad: f64::midpoint(least_rad, most_rad) };
    let off = pose.relative_to(middle);
    Some(Exit {
        time_s,
        by_position,
        by_heading,
        ahead_m: off.x_m,
        left_m: off.y_m,
        turned_rad: off.heading_rad,
    })
}

/// The regions of one body of a kind, with the trials inside.
fn tube(kind: &Kind, regions: &Regions, members: &[(&DrivenTrial, &[Exit])]) -> Tube {
    let horizon = |(index, time_s): (usize, &f64)| {
        let lasting: Vec<_> = members
            .iter()
            .filter(|(trial, _)| reached(kind, trial).any(|(reached, _)| reached == index))
            .collect();
        let is_inside =
            |exits: &[Exit]| exits.iter().all(|exit| exit.time_s.to_bits() != time_s.to_bits());
        let n_inside = lasting.iter().filter(|(_, exits)| is_inside(exits)).count();
        let position = &regions.positions[index];
        let (region, area_m2) = position.outline();
        Horizon {
            time_s: *time_s,
            area_m2,
            mean_m: position.mean_m,
            heading_rad: regions.headings_rad[index],
            n_trials: lasting.len(),
            n_inside,
            coverage: Interval::clopper_pearson(n_inside as u64, lasting.len() as u64),
            region,
        }
    };
    Tube {
        command: kind.longest.constant_command(),
        of_object: false,
        duration_s: kind.longest.duration_s(),
        horizons: kind.horizons_s.iter().enumerate().map(horizon).collect(),
    }
}

/// For each real robot: how probable it is that 0, 1, 2 … of its trials would be outside if it were
/// a simulated one.
///
/// Besides the simulated robots one is counted that leaves in every trial, as the real robot might
/// be: so that few of them never make it surprising to leave (A. C. Davison, D. V. Hinkley,
/// "Bootstrap Methods and their Application", 1997, §4.2).
///
/// No region was made from the `simulated` robots: those that one was made from are inside more
/// often.
pub(super) fn chances(
    trials: &[DrivenTrial],
    kind_of: &[usize],
    simulated: &[Drives],
    contains: impl Fn(&Moved, usize) -> bool,
) -> Vec<Vec<f64>> {
    // Whether each simulated robot's drive of a kind is outside; shape [robot][kind][repeat].
    let is_outside: Vec<Vec<Vec<bool>>> = simulated
        .iter()
        .map(|drives| {
            let of_kind = |(kind, repeats): (usize, &Vec<Moved>)| {
                repeats.iter().map(|moved| !contains(moved, kind)).collect()
            };
            drives.iter().enumerate().map(of_kind).collect()
        })
        .collect();
    let mut robots: BTreeMap<&str, BTreeMap<usize, usize>> = BTreeMap::new();
    for (trial, kind) in trials.iter().zip(kind_of) {
        *robots.entry(&trial.robot).or_default().entry(*kind).or_default() += 1;
    }
    let chance = |driven: &BTreeMap<usize, usize>| {
        let n_trials: usize = driven.values().sum();
        let one = 1.0 / (is_outside.len() + 1) as f64;
        let mut chances = vec![0.0; n_trials + 1];
        chances[n_trials] = one;
        for drives in &is_outside {
            let outside = driven.iter().flat_map(|(kind, n)| &drives[*kind][..*n]);
            chances[outside.filter(|is_outside| **is_outside).count()] += one;
        }
        chances
    };
    robots.values().map(chance).collect()
}

pub(super) fn summary(
    trials: Vec<TrialPlace>,
    tubes: Vec<Tube>,
    chances: &[Vec<f64>],
    share: f64,
) -> Validation {
    let n_inside_of =
        |places: &[&TrialPlace]| places.iter().filter(|place| place.is_inside()).count();
    let mut by_robot: BTreeMap<&str, Vec<&TrialPlace>> = BTreeMap::new();
    for place in &trials {
        by_robot.entry(&place.robot).or_default().push(place);
    }
    let robots = by_robot
        .iter()
        .map(|(robot, places)| {
            let n_inside = n_inside_of(places);
            let coverage = Interval::clopper_pearson(n_inside as u64, places.len() as u64);
            let robot = (*robot).to_owned();
            RobotCoverage { robot, n_trials: places.len(), n_inside, coverage }
        })
        .collect();
    let n_trials = trials.len();
    let n_inside = n_inside_of(&trials.iter().collect::<Vec<_>>());
    let p_value = at_least_outside(chances, n_trials - n_inside);
    Validation {
        share,
        is_contained: p_value >= LEVEL,
        p_value,
        n_trials,
        n_inside,
        coverage: Interval::clopper_pearson(n_inside as u64, n_trials as u64),
        robots,
        tubes,
        trials,
    }
}
