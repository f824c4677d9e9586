//! The sums that order parameters are made of, gathered sample by sample: for one world or, with
//! vectors, for a world in each lane.

use super::asked::measured;
use super::cluster::clustered;
use super::geometry::{
    Vector, angle_between, centroid, cross, distance_m2, dot, nearest_neighbours,
};
use super::samples::{Commanded, Samples};
use super::{
    BLOCKED_SHARE, CONTACT_TOLERANCE, LOST_SHARE, OrderParameters, Parameter, STUCK_SHARE,
    look_back, rounded, rounds_surely,
};
use crate::judge::number::{Mask, Number};
use crate::judge::trajectory::Bodies;

/// Sums over the samples of a window, from its first sample on.
#[derive(Clone)]
pub struct Sums<N> {
    start: usize,
    n_samples: usize,
    rotation: N,
    tangentness: N,
    fatness: N,
    radius_m: N,
    orbited_m: N,
    /// How many came into contact.
    onsets: N,
    /// Shape `[n_robots]`.
    robots: Vec<RobotSums<N>>,
}

#[derive(Clone, Copy)]
struct RobotSums<N> {
    /// Samples in which no other robot was within reach.
    alone: N,
    /// Looks at which it was blocked.
    blocked: N,
}

impl<N: Number<Scalar = f64>> Sums<N> {
    /// Of no sample yet; the first one will be `start`.
    #[inline(always)]
    fn new(zero: N, start: usize, n_robots: usize) -> Self {
        let robot = RobotSums { alone: zero, blocked: zero };
        Self {
            start,
            n_samples: 0,
            rotation: zero,
            tangentness: zero,
            fatness: zero,
            radius_m: zero,
            orbited_m: zero,
            onsets: zero,
            robots: vec![robot; n_robots],
        }
    }

    fn n_poses(&self) -> f64 {
        self.n_samples as f64 * self.robots.len() as f64
    }

    /// The order parameters of one lane; samples and bodies are those that the sums are of, and
    /// `asked` names what is measured only where it is asked for.
    pub fn evidence<S>(
        &self,
        (samples, bodies): (&S, &Bodies),
        lane: usize,
        asked: &[Parameter],
    ) -> OrderParameters
    where
        S: Samples<Number = N>,
    {
        let window = self.start..self.start + self.n_samples;
        if !self.is_certain(lane)
            && let Some(trajectory) = samples.trajectory(lane, window.clone())
        {
            return OrderParameters::with(&trajectory, 0..self.n_samples, bodies, asked);
        }
        let period_s = samples.period_s();
        let Commanded { way_m, mean_turn_rad } = samples.commanded(window.clone(), lane);
        let (n_samples, n_poses) = (self.n_samples as f64, self.n_poses());
        let n_robots = self.robots.len() as f64;
        let n_looks = self.n_samples.saturating_sub(look_back(period_s)) as f64;
        let share = |limit: f64, count: fn(&RobotSums<N>) -> N| {
            let is_above = |robot: &&RobotSums<N>| count(robot).lane(lane) > limit;
            self.robots.iter().filter(is_above).count() as f64 / n_robots
        };
        let n_blocked: f64 = self.robots.iter().map(|robot| robot.blocked.lane(lane)).sum();
        let orbited_m = self.orbited_m.lane(lane);
        let fatness = self.fatness.lane(lane) / n_samples;
        let tangentness = rounded(self.tangentness.lane(lane) / n_poses);
        // A single robot has lost all others, at any reach.
        let is_decided = bodies.reach_m.is_some() || self.robots.len() == 1;
        let robot_seconds = n_samples * period_s * n_robots;
        OrderParameters {
            lost: is_decided.then(|| share(LOST_SHARE * n_samples, |robot| robot.alone)),
            blocked: if n_looks > 0.0 { n_blocked / (n_looks * n_robots) } else { 0.0 },
            stuck: share(STUCK_SHARE * n_looks, |robot| robot.blocked),
            rotation: rounded((self.rotation.lane(lane) / n_poses).abs()),
            orbit: if way_m > 0.0 { (orbited_m / way_m).abs() } else { 0.0 },
            fatness,
            tangentness,
            circliness: 1.0 - fatness.max(tangentness),
            mean_radius_m: self.radius_m.lane(lane) / n_poses,
            contact_onsets_per_s: bodies.radius_m.map(|_| self.onsets.lane(lane) / robot_seconds),
            circliness_ceiling: 1.0 - mean_turn_rad / 2.0,
            asked: measured((samples, bodies), &window, lane, asked),
            clustered: bodies.radius_m.map(|radius_m| clustered(samples, window, lane, radius_m)),
        }
    }

    /// Whether the means over headings are rounded to the same numbers however sines and cosines came
    /// about: by how much these may differ in a mean is a constant for the terms, which are at most
    /// 1 and whose headings may be longer or shorter than 1 by so little, and for each addition.
    fn is_certain(&self, lane: usize) -> bool {
        let n_poses = self.n_poses();
        let margin = 2e-13 + 2.3e-16 * n_poses;
        [self.rotation, self.tangentness]
            .iter()
            .all(|sum| rounds_surely((sum.lane(lane) / n_poses).abs(), margin))
    }
}

/// The motion of one robot around the centroid.
#[derive(Clone, Copy)]
struct Motion<N> {
    radius_m: N,
    around: N,
    outward: N,
    orbited_m: N,
}

/// A way through samples in their order, with what has to be remembered of the one before.
pub(super) struct OrderAccumulator<'a, S: Samples> {
    samples: &'a S,
    /// Beyond this a robot is alone, in square metres.
    reach_m2: S::Number,
    /// Nearer than this bodies touch, in square metres.
    contact_m2: S::Number,
    back: usize,
    places: Vec<Vector<S::Number>>,
    /// From the centroid, in the sample before.
    arms: Vec<Vector<S::Number>>,
    motions: Vec<Motion<S::Number>>,
    nearest_m2: Vec<S::Number>,
    touched: Vec<<S::Number as Number>::Mask>,
}

impl<'a, S: Samples> OrderAccumulator<'a, S> {
    #[inline(always)]
    pub fn new(samples: &'a S, bodies: &Bodies, n_robots: usize) -> Self {
        let zero = samples.zero();
        let squared = |length_m: f64| zero.all(length_m * length_m);
        let motion = Motion { radius_m: zero, around: zero, outward: zero, orbited_m: zero };
        let contact_m = |radius_m: f64| 2.0 * radius_m * (1.0 + CONTACT_TOLERANCE);
        Self {
            samples,
            reach_m2: bodies.reach_m.map_or(zero.all(f64::MAX), squared),
            contact_m2: bodies.radius_m.map_or(zero, |radius_m| squared(contact_m(radius_m))),
            back: look_back(samples.period_s()),
            places: vec![(zero, zero); n_robots],
            arms: vec![(zero, zero); n_robots],
            motions: vec![motion; n_robots],
            nearest_m2: vec![zero; n_robots],
            touched: vec![zero.lt(zero); n_robots],
        }
    }

    /// Of no sample yet; the first one will be `start`.
    #[inline(always)]
    pub fn sums(&self, start: usize) -> Sums<S::Number> {
        Sums::new(self.samples.zero(), start, self.places.len())
    }

    /// Adds the next sample to sums: those of a window, and those of one of its blocks.
    #[inline(always)]
    pub fn add<const N_SUMS: usize>(
        &mut self,
        sample: usize,
        mut sums: [&mut Sums<S::Number>; N_SUMS],
    ) {
        for (place, pose) in self.places.iter_mut().zip(self.samples.poses_at(sample)) {
            *place = self.samples.place(pose);
        }
        self.add_motion(sample, &mut sums);
        self.add_neighbours(&mut sums);
        self.add_blocking(sample, &mut sums);
        for sums in sums {
            sums.n_samples += 1;
        }
    }

    /// The motion around the centroid.
    #[inline(always)]
    fn add_motion<const N_SUMS: usize>(
        &mut self,
        sample: usize,
        sums: &mut [&mut Sums<S::Number>; N_SUMS],
    ) {
        let (least_m2, most_m2) = self.find_motion(sample);
        let zero = self.samples.zero();
        let one = zero.all(1.0);
        // On the centroid there is no direction around it: such a robot faces outward.
        if least_m2.le(zero).any() {
            for motion in &mut self.motions {
                let is_central = motion.radius_m.le(zero);
                motion.outward = S::Number::select(is_central, one, motion.outward);
            }
        }
        let fatness = (one - least_m2 / most_m2).unless(most_m2.le(zero));
        for sums in sums {
            sums.fatness = sums.fatness + fatness;
            for motion in &self.motions {
                sums.radius_m = sums.radius_m + motion.radius_m;
                sums.rotation = sums.rotation + motion.around;
                sums.tangentness = sums.tangentness + motion.outward;
            }
            if sums.n_samples > 0 {
                for motion in &self.motions {
                    sums.orbited_m = sums.orbited_m + motion.orbited_m;
                }
            }
        }
    }

    /// Finds out how every robot moves, and the least and the greatest squared distance from the
    /// centroid, in square metres.
    #[inline(always)]
    fn find_motion(&mut self, sample: usize) -> (S::Number, S::Number) {
        let (samples, zero) = (self.samples, self.samples.zero());
        let centroid = centroid(zero, &self.places);
        let (mut least_m2, mut most_m2) = (zero.all(f64::INFINITY), zero);
        let robots = samples.poses_at(sample).iter().zip(&self.places);
        for ((pose, place), (arm_before, motion)) in
            robots.zip(self.arms.iter_mut().zip(&mut self.motions))
        {
            let arm = (place.0 - centroid.0, place.1 - centroid.1);
            let arm_m2 = dot(arm, arm);
            let arm_m = arm_m2.sqrt();
            least_m2 = least_m2.least(arm_m2);
            most_m2 = most_m2.most(arm_m2);
            let (heading, inverse) = samples.heading(pose);
            // Nothing to divide is nothing, whatever it is divided by.
            let inverse = inverse / arm_m.most(zero.all(f64::MIN_POSITIVE));
            *motion = Motion {
                radius_m: arm_m,
                around: cross(arm, heading) * inverse,
                outward: (dot(arm, heading) * inverse).abs(),
                orbited_m: angle_between(*arm_before, arm) * arm_m,
            };
            *arm_before = arm;
        }
        (least_m2, most_m2)
    }

    /// Who is alone and who comes into contact.
    #[inline(always)]
    fn add_neighbours<const N_SUMS: usize>(&mut self, sums: &mut [&mut Sums<S::Number>; N_SUMS]) {
        let zero = self.samples.zero();
        let one = zero.all(1.0);
        nearest_neighbours(zero, &self.places, &mut self.nearest_m2);
        let (mut least_m2, mut most_m2) = (zero.all(f64::INFINITY), zero);
        for nearest_m2 in &self.nearest_m2 {
            least_m2 = least_m2.least(*nearest_m2);
            most_m2 = most_m2.most(*nearest_m2);
        }
        let touches = least_m2.lt(self.contact_m2).any();
        if !touches && !most_m2.gt(self.reach_m2).any() {
            self.touched.fill(zero.lt(zero));
            return;
        }
        let robots = self.nearest_m2.iter().zip(&mut self.touched).enumerate();
        for (robot, (nearest_m2, touched)) in robots {
            let is_near = nearest_m2.le(self.reach_m2);
            let is_free = self.contact_m2.le(*nearest_m2);
            let onsets = one.unless(is_free).unless(*touched);
            *touched = nearest_m2.lt(self.contact_m2);
            for sums in &mut *sums {
                let alone = &mut sums.robots[robot].alone;
                *alone = *alone + one.unless(is_near);
                if sums.n_samples > 0 {
                    sums.onsets = sums.onsets + onsets;
                }
            }
        }
    }

    /// Who has hardly moved since a second ago.
    #[inline(always)]
    fn add_blocking<const N_SUMS: usize>(
        &self,
        sample: usize,
        sums: &mut [&mut Sums<S::Number>; N_SUMS],
    ) {
        if sums.iter().all(|sums| sums.n_samples < self.back) {
            return;
        }
        let (samples, start) = (self.samples, sample - self.back);
        let one = samples.zero().all(1.0);
        let before = samples.poses_at(start).iter().map(|pose| samples.place(pose));
        for (robot, (place, before)) in self.places.iter().zip(before).enumerate() {
            let speeds_m_s = samples.speeds_m_s(start..sample, robot).abs();
            let limit_m = one.all(BLOCKED_SHARE) * speeds_m_s * one.all(samples.period_s());
            let limit_m2 = limit_m * limit_m;
            let moved_m2 = distance_m2(*place, before);
            if !moved_m2.lt(limit_m2).any() {
                continue;
            }
            let blocked = one.unless(limit_m2.le(moved_m2));
            for sums in sums.iter_mut().filter(|sums| sums.n_samples >= self.back) {
                let count = &mut sums.robots[robot].blocked;
                *count = *count + blocked;
            }
        }
    }
}
