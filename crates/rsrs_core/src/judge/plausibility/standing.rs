//! A robot that stands although it is commanded to move.

use super::motion::Motion;
use super::{Implausibility, MOST_LAG_S};

/// A robot is looked at for at least so long, in seconds.
const LEAST_OBSERVED_S: f64 = 3.0;

/// Commands that lead so far, in metres, show whether a robot obeys: a gust holds a slow one back for
/// some seconds.
const MIN_WAY_M: f64 = 0.15;

/// So do commands that turn so much, in radians, if they turn one way by this share of all turning: a robot
/// that leans to one side and keeps looking at another one is commanded against that all the time, and
/// stands.
const MIN_TURN_RAD: f64 = 1.0;
const ONE_WAY: f64 = 0.9;

/// One that stands moves less than this share of it ...
const STANDS: f64 = 0.1;
/// ... or less than a tracker's noise.
const NOISE_M: f64 = 0.02;
const NOISE_RAD: f64 = 0.15;

/// A robot that has something in its way for more than this share of a look is not asked to move: in the
/// rest of it, it would have moved further than one that stands.
const EXCUSED: f64 = 0.25;

/// Poses are averaged over this time, in seconds.
const MEAN_S: f64 = 0.5;

/// What a robot did in one look.
enum Seen {
    /// It moved.
    Obeys,
    /// It did neither move nor turn.
    Stands { moved_m: f64 },
    /// It was hardly commanded, or something was in its way.
    Nothing,
}

/// The first time through which a robot stood for so long although it was commanded, and nothing was in its
/// way; what it did while something was is left open.
pub fn stands(motion: &Motion, stood_s: f64) -> Option<Implausibility> {
    let mut stood = Stood::default();
    let mut start = 0;
    while let Some(end) = look_from(motion, start) {
        match seen(motion, start, end) {
            Seen::Stands { moved_m } => {
                stood.looks.push((start, end));
                stood.moved_m = stood.moved_m.max(moved_m);
                if stood.time_s(motion) >= stood_s {
                    return Some(stood.cause(motion));
                }
            }
            Seen::Obeys => stood = Stood::default(),
            Seen::Nothing => {}
        }
        start = end;
    }
    None
}

/// Looks in which a robot stood.
#[derive(Default)]
struct Stood {
    /// First and last sample of each.
    looks: Vec<(usize, usize)>,
    moved_m: f64,
}

impl Stood {
    fn time_s(&self, motion: &Motion) -> f64 {
        let n_samples: usize = self.looks.iter().map(|(start, end)| end - start).sum();
        n_samples as f64 * motion.period_s
    }

    fn cause(&self, motion: &Motion) -> Implausibility {
        let commands = || self.looks.iter().flat_map(|(start, end)| &motion.commands[*start..*end]);
        let n = commands().count() as f64;
        let speeds_m_s: f64 = commands().map(|command| command.speed_m_s).sum();
        let rates_rad_s: f64 = commands().map(|command| command.turn_rate_rad_s.abs()).sum();
        Implausibility::Stands {
            time_s: self.looks[0].0 as f64 * motion.period_s,
            for_s: self.time_s(motion),
            speed_m_s: speeds_m_s / n,
            turn_rate_rad_s: rates_rad_s / n,
            moved_m: self.moved_m,
        }
    }
}

/// The end of a look that begins there: 3 s later, or as soon as commands have led far enough.
fn look_from(motion: &Motion, start: usize) -> Option<usize> {
    let least = start + motion.samples_in(LEAST_OBSERVED_S);
    let most = start + 10 * motion.samples_in(LEAST_OBSERVED_S);
    let n_lag = motion.samples_in(MOST_LAG_S);
    let last = motion.len().checked_sub(1).filter(|last| least <= *last)?;
    let is_enough = |end: &usize| {
        let (way_m, turn_rad) = commanded(motion, start, end.saturating_sub(n_lag).max(start));
        way_m >= MIN_WAY_M || is_to_turn(motion, start, *end, turn_rad)
    };
    let step = motion.samples_in(1.0);
    let mut ends = (least..=last.min(most)).step_by(step);
    match ends.find(is_enough) {
        Some(end) => Some(end),
        None if last >= most => Some(most),
        None => None,
    }
}

/// Whether a robot is to turn so far in a look that its turning shows something.
fn is_to_turn(motion: &Motion, start: usize, end: usize, turn_rad: f64) -> bool {
    let rates = motion.commands[start..end].iter().map(|command| command.turn_rate_rad_s);
    let (sum, all) = rates.fold((0.0, 0.0), |(sum, all), rate| (sum + rate, all + f64::abs(rate)));
    turn_rad >= MIN_TURN_RAD && f64::abs(sum) >= ONE_WAY * all
}

/// How far commands lead from the start, and how far they turn either way.
fn commanded(motion: &Motion, start: usize, end: usize) -> (f64, f64) {
    let places = motion.commanded_places(start, end);
    let ways_m = places.iter().map(|(x_m, y_m)| libm::hypot(*x_m, *y_m));
    let turns_rad =
        motion.to_turn_rad[start..=end].iter().map(|turn| (turn - motion.to_turn_rad[start]).abs());
    (ways_m.fold(0.0, f64::max), turns_rad.fold(0.0, f64::max))
}

fn seen(motion: &Motion, start: usize, end: usize) -> Seen {
    // What moved a moment before or moves a moment later may be late, or stamped by another clock.
    let n_lag = motion.samples_in(MOST_LAG_S);
    let (way_m, turn_rad) = commanded(motion, start, end.saturating_sub(n_lag).max(start));
    if way_m < MIN_WAY_M && !is_to_turn(motion, start, end, turn_rad) {
        return Seen::Nothing;
    }
    let from = start.saturating_sub(n_lag);
    let n_mean = motion.samples_in(MEAN_S);
    let poses = &motion.poses[from..=end];
    let turned = &motion.turned_rad[from..=end];
    let places: Vec<(f64, f64)> = poses
        .chunks(n_mean)
        .map(|chunk| {
            let n = chunk.len() as f64;
            let sum = |number: fn(&_) -> f64| chunk.iter().map(number).sum::<f64>() / n;
            (sum(|pose: &crate::robot::unicycle::Pose| pose.x_m), sum(|pose| pose.y_m))
        })
        .collect();
    let headings: Vec<f64> =
        turned.chunks(n_mean).map(|chunk| chunk.iter().sum::<f64>() / chunk.len() as f64).collect();
    let moved_m = places
        .iter()
        .map(|place| libm::hypot(place.0 - places[0].0, place.1 - places[0].1))
        .fold(0.0, f64::max);
    let turned_rad =
        headings.iter().map(|heading| (heading - headings[0]).abs()).fold(0.0, f64::max);
    let goes = moved_m > NOISE_M.max(STANDS * way_m);
    let turns = turned_rad > NOISE_RAD.max(STANDS * turn_rad);
    match goes || turns {
        true => Seen::Obeys,
        false if motion.blocked_share(start, end) > EXCUSED => Seen::Nothing,
        false => Seen::Stands { moved_m },
    }
}
