//! Whether swarms were stable mills in a block of time: an answer in single precision, with the
//! error that it may have.
//!
//! When a swarm became a mill is asked of every block of its past, and only yes or no matters. So
//! the order parameters are taken in single precision and in two stages, motion and shape first;
//! and where a threshold is nearer than the error, the answer is left to the exact evidence.

use rsrs_core::order::LOST_SHARE;
use rsrs_core::phase::Thresholds;

use super::evidence::Window;
use super::nearest::nearest_neighbours;
use super::sense::Body;
use crate::vector::simd::{Mask, Number, Simd, Work};

/// What single precision may be off by in a number up to 1, ten times over; and in a sum, for each
/// addition.
const MARGIN: f32 = 2e-4;
const ADDITION_MARGIN: f32 = 1.2e-7;

/// What it may be off by in a place, relative to the greatest distance from the centroid.
const PLACE_MARGIN: f32 = 2e-6;

/// What it may be off by in a squared distance, relative to it.
const DISTANCE_MARGIN: f64 = 1e-5;

/// Squared distances from the centroid are told apart down to this share of the greatest one;
/// nearer to it, a direction is uncertain.
const CENTRAL: f32 = 1e-4;

/// Samples after which it is asked whether the rest of the block still matters.
const LOOK_EVERY: u64 = 8;

/// An answer for one lane.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Answer {
    /// A stable mill.
    Yes,
    /// Not one.
    No,
    /// Too near to a threshold.
    Unclear,
}

/// Asks all lanes of a block; `open` are those whose answer matters, as bits.
pub struct ApproximateJudge<'a, S: Simd> {
    pub simd: S,
    pub window: Window<'a, S::F>,
    pub open: u32,
    pub memory: &'a mut Memory<S>,
}

/// Memory for one block, used again.
pub struct Memory<S: Simd> {
    /// Places relative to the centroid, sample by sample.
    arms: Vec<(S::F, S::F)>,
    nearest_m2: Vec<S::F>,
    near: Vec<S::F>,
}

impl<S: Simd> Memory<S> {
    pub fn new() -> Self {
        Self { arms: Vec::new(), nearest_m2: Vec::new(), near: Vec::new() }
    }
}

/// Lanes for which something is certain, as bits.
#[derive(Clone, Copy)]
struct Certain {
    yes: u32,
    no: u32,
}

impl<S: Simd> Work for ApproximateJudge<'_, S> {
    type Output = Vec<Answer>;

    #[inline(always)]
    fn run(mut self) -> Vec<Answer> {
        let thresholds = Thresholds::default();
        let (shape, reach_m) = self.shape(&thresholds);
        let mut certain = shape;
        if self.open & !shape.no != 0 {
            let orbit = self.orbit(&thresholds, reach_m);
            let free = self.free(&thresholds);
            let together = self.together();
            certain = Certain {
                yes: shape.yes & orbit.yes & free.yes & together,
                no: shape.no | orbit.no | free.no,
            };
        }
        let answer = |lane: usize| match (certain.yes >> lane & 1, certain.no >> lane & 1) {
            (_, 1) => Answer::No,
            (1, _) => Answer::Yes,
            _ => Answer::Unclear,
        };
        (0..S::LANES).map(answer).collect()
    }
}

/// Sums over samples and robots.
struct ShapeSums<F> {
    rotation: F,
    tangentness: F,
    fatness: F,
    /// Samples in which a direction is uncertain.
    n_uncertain: F,
    /// Greatest squared distance from the centroid, in square metres.
    reach_m2: F,
}

impl<F: Number<Scalar = f32>> ShapeSums<F> {
    #[inline(always)]
    fn new<S: Simd<F = F>>(simd: S) -> Self {
        let zero = simd.single(0.0);
        Self { rotation: zero, tangentness: zero, fatness: zero, n_uncertain: zero, reach_m2: zero }
    }

    /// Adds a sample, and keeps the places from the centroid.
    #[inline(always)]
    fn add<S: Simd<F = F>>(&mut self, simd: S, row: &[Body<F>], arms: &mut Vec<(F, F)>) {
        let one = |number| simd.single(number);
        let n_robots = one(row.len() as f32);
        let first = (row[0].x_m, row[0].y_m);
        let sum = row.iter().fold((one(0.0), one(0.0)), |sum, body| {
            (sum.0 + (body.x_m - first.0), sum.1 + (body.y_m - first.1))
        });
        let centroid = (sum.0 / n_robots, sum.1 / n_robots);
        let (mut least_m2, mut most_m2) = (one(f32::INFINITY), one(0.0));
        for body in row {
            let arm = ((body.x_m - first.0) - centroid.0, (body.y_m - first.1) - centroid.1);
            let arm_m2 = arm.0 * arm.0 + arm.1 * arm.1;
            least_m2 = least_m2.least(arm_m2);
            most_m2 = most_m2.most(arm_m2);
            let inverse = one(1.0) / arm_m2.sqrt();
            let is_central = arm_m2.le(one(0.0));
            let around = (arm.0 * body.sine - arm.1 * body.cosine) * inverse;
            let outward = (arm.0 * body.cosine + arm.1 * body.sine) * inverse;
            self.rotation = self.rotation + around.unless(is_central);
            self.tangentness = self.tangentness + outward.abs().unless(is_central);
            arms.push(arm);
        }
        let fat = one(1.0) - least_m2 / most_m2;
        self.fatness = self.fatness + fat.unless(most_m2.le(one(0.0)));
        self.reach_m2 = self.reach_m2.most(most_m2);
        let is_clear = least_m2.gt(one(CENTRAL) * most_m2);
        self.n_uncertain = self.n_uncertain + one(1.0).unless(is_clear);
    }
}

impl<S: Simd> ApproximateJudge<'_, S> {
    fn n_robots(&self) -> usize {
        self.window.rows.at(self.window.start).len()
    }

    /// Rotation, fatness and tangentness against their thresholds; and the greatest distance from
    /// the centroid. The places from the centroid are kept for later.
    ///
    /// It ends as soon as no open lane can become a stable mill, whatever the rest of the block is:
    /// which is early where there is no mill.
    #[inline(always)]
    fn shape(&mut self, thresholds: &Thresholds) -> (Certain, S::F) {
        let (simd, window) = (self.simd, self.window);
        let mut sums = ShapeSums::new(simd);
        self.memory.arms.clear();
        for sample in window.start..window.end {
            sums.add(simd, window.rows.at(sample), &mut self.memory.arms);
            let n_done = sample + 1 - window.start;
            if n_done % LOOK_EVERY == 0 && sample + 1 < window.end {
                let certain = self.certain_shape(&sums, n_done, thresholds);
                if self.open & !certain.no == 0 {
                    return (Certain { yes: 0, ..certain }, sums.reach_m2);
                }
            }
        }
        let certain = self.certain_shape(&sums, window.end - window.start, thresholds);
        (certain, sums.reach_m2.sqrt())
    }

    /// What is certain about the whole block after so many of its samples.
    #[inline(always)]
    fn certain_shape(
        &self,
        sums: &ShapeSums<S::F>,
        n_done: u64,
        thresholds: &Thresholds,
    ) -> Certain {
        let one = |number| self.simd.single(number);
        let n_samples = self.window.end - self.window.start;
        let rest = one((n_samples - n_done) as f32 / n_samples as f32);
        let n_poses = n_samples as f32 * self.n_robots() as f32;
        let (n_samples, n_poses) = (one(n_samples as f32), one(n_poses));
        // A direction that is not known changes a mean by 2 in so many samples at most.
        let margin = one(MARGIN) + one(ADDITION_MARGIN) * n_poses;
        let slack = margin + one(2.0) * sums.n_uncertain / n_samples;
        let rotation = (sums.rotation / n_poses).abs();
        let worst = (sums.fatness / n_samples).most(sums.tangentness / n_poses);
        let least_rotation = one(thresholds.stable_rotation as f32);
        let most_worst = one(1.0 - thresholds.stable_circliness as f32);
        // In the rest of the block, rotation is at most 1, and the others are at least 0.
        let yes = (rotation - slack).gt(least_rotation) & (worst + slack).lt(most_worst);
        let no = (rotation + rest + slack).lt(least_rotation) | (worst - slack).gt(most_worst);
        Certain { yes: yes.bits(), no: no.bits() }
    }

    /// The orbit against its threshold.
    #[inline(always)]
    fn orbit(&self, thresholds: &Thresholds, reach_m: S::F) -> Certain {
        let simd = self.simd;
        let one = |number| simd.single(number);
        let (mut orbited_m, mut is_unclear) = (one(0.0), simd.no());
        let arms = &self.memory.arms;
        let n_ways = (arms.len() - self.n_robots()) as f32;
        for (to, from) in arms[self.n_robots()..].iter().zip(arms) {
            let across = from.0 * to.1 - from.1 * to.0;
            let along = from.0 * to.0 + from.1 * to.1;
            let tangent = across / along;
            let square = tangent * tangent;
            let series = one(1.0 / 3.0) - square * one(0.2);
            let angle = tangent * (one(1.0) - square * series);
            is_unclear = is_unclear | along.le(one(0.0)) | square.gt(one(0.01));
            orbited_m = orbited_m + angle * (to.0 * to.0 + to.1 * to.1).sqrt();
        }
        let way_m = self.window.commanded.way_m as f32;
        if way_m <= 0.0 {
            return Certain { yes: 0, no: 0 };
        }
        // Each arm is off by so much, on each of the ways.
        let places = one(PLACE_MARGIN * n_ways / way_m) * reach_m;
        let margin = one(MARGIN + ADDITION_MARGIN * n_ways) + places;
        let orbit = (orbited_m / one(way_m)).abs();
        let least = one(thresholds.stable_orbit as f32);
        let yes = (orbit - margin).gt(least).bits();
        let no = (orbit + margin).lt(least).bits();
        Certain { yes: yes & !is_unclear.bits(), no: no & !is_unclear.bits() }
    }

    /// The share of time blocked against its threshold.
    #[inline(always)]
    fn free(&self, thresholds: &Thresholds) -> Certain {
        let (simd, window) = (self.simd, self.window);
        let one = |number| simd.single(number);
        let commanded = window.commanded;
        let n_looks = (window.end - window.start).saturating_sub(commanded.back);
        let below = |margin: f64| one((commanded.blocked_below_m2 * (1.0 + margin)) as f32);
        let (surely_m2, maybe_m2) = (below(-DISTANCE_MARGIN), below(DISTANCE_MARGIN));
        let (mut surely, mut maybe) = (one(0.0), one(0.0));
        for sample in window.start + commanded.back..window.end {
            let before = window.rows.at(sample - commanded.back);
            for (now, before) in window.rows.at(sample).iter().zip(before) {
                let (dx_m, dy_m) = (now.x_m - before.x_m, now.y_m - before.y_m);
                let moved_m2 = dx_m * dx_m + dy_m * dy_m;
                surely = surely + one(1.0).unless(surely_m2.le(moved_m2));
                maybe = maybe + one(1.0).unless(maybe_m2.le(moved_m2));
            }
        }
        let limit = thresholds.stable_blocked * n_looks as f64 * self.n_robots() as f64;
        // A whole number is compared: half of one is more than any rounding.
        let yes = maybe.lt(one((limit - 0.5) as f32));
        let no = surely.gt(one((limit + 0.5) as f32));
        if n_looks == 0 {
            return Certain { yes: u32::MAX, no: 0 };
        }
        Certain { yes: (yes | maybe.le(one(0.0))).bits(), no: no.bits() }
    }

    /// Lanes in which surely no robot is lost. It ends as soon as all are seen to be near another
    /// for long enough, which is early in a mill.
    #[inline(always)]
    fn together(&mut self) -> u32 {
        let (simd, window, n_robots) = (self.simd, self.window, self.n_robots());
        let one = |number| simd.single(number);
        let Some(reach_m) = window.bodies.reach_m else {
            return u32::MAX;
        };
        let reach_m2 = one((reach_m * reach_m * (1.0 - DISTANCE_MARGIN)) as f32);
        let n_samples = (window.end - window.start) as f64;
        // A robot is lost if it is alone for more than this share: so many samples near are enough.
        let enough = (n_samples - (LOST_SHARE * n_samples).floor()) as u64;
        let Memory { nearest_m2, near, .. } = &mut *self.memory;
        near.clear();
        near.resize(n_robots, one(0.0));
        nearest_m2.clear();
        nearest_m2.resize(n_robots, one(0.0));
        let mut together = 0;
        for sample in window.start..window.end {
            let row = window.rows.at(sample);
            nearest_neighbours(simd, row, nearest_m2);
            for (near, nearest_m2) in near.iter_mut().zip(&*nearest_m2) {
                *near = *near + one(1.0).unless(reach_m2.lt(*nearest_m2));
            }
            if sample + 1 - window.start >= enough {
                let limit = one(enough as f32 - 0.5);
                let all_near = near.iter().fold(limit.le(limit), |all, near| all & limit.lt(*near));
                together = all_near.bits();
                if self.open & !together == 0 {
                    break;
                }
            }
        }
        together
    }
}

#[cfg(test)]
mod tests {
    use rsrs_core::order::Evidence;
    use rsrs_core::phase::Phase;
    use rsrs_core::trajectory::Bodies;

    use super::*;
    use crate::batch::evidence::{Commanded, Scratch, gather};
    use crate::batch::rows::Rows;
    use crate::draw::{Purpose, RunKey, Seed};
    use crate::vector::portable::Portable;

    const N_SAMPLES: usize = 76;
    const N_ROBOTS: usize = 5;

    /// A ring of robots that may be wide, slow, crooked or held up for a while.
    #[derive(Clone, Copy)]
    struct Mill {
        radius_m: f64,
        speed_m_s: f64,
        crookedness: f64,
        held_samples: f64,
        phase_rad: f64,
    }

    impl Mill {
        fn body(&self, robot: usize, sample: usize) -> [f32; 4] {
            let held = if robot == 0 { self.held_samples } else { 0.0 };
            let steps = (sample as f64 - held).max(0.0);
            let turned_rad = self.speed_m_s * 0.13 / self.radius_m * steps;
            let place_rad = self.phase_rad + std::f64::consts::TAU * robot as f64 / N_ROBOTS as f64;
            let (sine, cosine) = libm::sincos(place_rad + turned_rad);
            let radius_m =
                self.radius_m * (1.0 + self.crookedness * libm::sin(3.0 * place_rad + 1.0));
            [radius_m * cosine, radius_m * sine, -sine, cosine].map(|number| number as f32)
        }
    }

    /// The quick answers and the exact ones for four mills.
    fn answers(mills: [Mill; 4]) -> Vec<(Answer, Evidence)> {
        let simd = Portable;
        let mut rows = Rows::new();
        rows.resize(N_ROBOTS, N_SAMPLES, simd.single(0.0));
        for sample in 0..N_SAMPLES {
            for (robot, body) in rows.at_mut(sample as u64).iter_mut().enumerate() {
                let number =
                    |index: usize| simd.singles(|lane| mills[lane].body(robot, sample)[index]);
                let [x_m, y_m, cosine, sine] = std::array::from_fn(number);
                *body = Body { x_m, y_m, cosine, sine };
            }
        }
        let commanded = Commanded::new((0.15, 0.75), 0.13, (N_SAMPLES, N_ROBOTS));
        let window = Window {
            rows: &rows,
            start: 0,
            end: N_SAMPLES as u64,
            commanded: &commanded,
            bodies: Bodies { radius_m: Some(0.075), reach_m: Some(0.75) },
        };
        let memory = &mut Memory::new();
        let approximate_judge = ApproximateJudge { simd, window, open: 0b1111, memory }.run();
        let exact = gather(simd, window, &mut Scratch::new(simd), 0..4);
        approximate_judge.into_iter().zip(exact).collect()
    }

    #[test]
    fn an_answer_that_is_given_is_right_whatever_it_depends_on() {
        let run = RunKey::new(Seed { seed: 1, replicate: 0 }, 0);
        let mut stream = run.stream(0, Purpose::Placement);
        let mut between = |least: f64, most: f64| least + (most - least) * stream.uniform();
        let thresholds = Thresholds::default();
        let (mut n_unclear, mut n_stable) = (0, 0);
        // Mills that only being lost, the orbit or being blocked keeps from being stable.
        let mut by_cause = [0; 3];

        for _ in 0..500 {
            let mills = std::array::from_fn(|_| Mill {
                radius_m: between(0.3, 0.9),
                speed_m_s: between(0.10, 0.16),
                crookedness: between(0.0, 0.2),
                held_samples: between(0.0, 20.0),
                phase_rad: between(-3.0, 3.0),
            });
            for (approximate_judge, exact) in answers(mills) {
                let is_stable = thresholds.phase(&exact) == Phase::StableMilling;
                assert_ne!((approximate_judge, is_stable), (Answer::Yes, false), "{exact:?}");
                assert_ne!((approximate_judge, is_stable), (Answer::No, true), "{exact:?}");
                n_unclear += usize::from(approximate_judge == Answer::Unclear);
                n_stable += usize::from(is_stable);
                let healed = [
                    Evidence { lost: Some(0.0), ..exact },
                    Evidence { orbit: 1.0, ..exact },
                    Evidence { blocked: 0.0, ..exact },
                ];
                for (n, healed) in by_cause.iter_mut().zip(healed) {
                    let is_cured = thresholds.phase(&healed) == Phase::StableMilling;
                    *n += usize::from(is_cured && !is_stable);
                }
            }
        }

        assert!(n_stable > 100 && by_cause.iter().all(|n| *n > 20), "{n_stable} {by_cause:?}");
        // Who is lost is left to the exact evidence.
        assert!(n_unclear < 20 + 2 * by_cause[0], "{n_unclear} {by_cause:?}");
    }
}
