//! Moving in lanes: what [`crate::world`] defines under "advance", for many worlds at once.

use rsrs_core::conditions::Walls;
use rsrs_core::judge::number::Number;
use rsrs_core::robot::controller::{Command, ControllerParameters, decide};

use super::noise::{LaneKey, turn};
use super::sense::Body;
use crate::contact::{Border, SquareBorder};
use crate::draw::Key;
use crate::robots::{NoiseKeys, Robots, WorldParameters};
use crate::turn;
use crate::vector::simd::Simd;

/// What is the same for all robots at all times, in all lanes.
#[derive(Clone, Copy)]
pub struct LaneRules<S: Simd> {
    true_positive: S::U,
    false_positive: S::U,
    walls: Walls,
    limit_m: S::F,
    minus_limit_m: S::F,
    rotates_while_blocked: bool,
    period_s: S::F,
    /// Speed and turning rate where something is detected, and where nothing is.
    detected: (S::F, S::F),
    undetected: (S::F, S::F),
    /// Whether robots drive backward where something is detected, and where nothing is.
    reverses: (bool, bool),
    speed_gain_step_sd: Option<S::F>,
    turn_gain_step_sd: Option<S::F>,
    heading_noise_sd_rad: Option<S::F>,
    /// Decay and kick.
    gusts: Option<(S::F, S::F)>,
    yaw_share: Option<S::F>,
}

impl<S: Simd> LaneRules<S> {
    /// The rules of a world whose robots have this controller.
    pub fn new(simd: S, rules: &WorldParameters, controller: ControllerParameters) -> Self {
        let one = |number| simd.single(number);
        let noise = |sd: f32| (sd != 0.0).then(|| one(sd));
        let decided = |detected: bool| {
            let Command { speed_m_s, turn_rate_rad_s } = decide(detected, controller);
            (one(speed_m_s as f32), one(turn_rate_rad_s as f32))
        };
        let reverses = |detected: bool| (decide(detected, controller).speed_m_s as f32) < 0.0;
        let Border::Square(SquareBorder { walls, limit_m }) = rules.border else {
            unreachable!("the lanes have no arenas of other shapes, and no obstacles")
        };
        Self {
            true_positive: simd.word(rules.true_positive),
            false_positive: simd.word(rules.false_positive),
            walls,
            limit_m: one(limit_m),
            minus_limit_m: one(-limit_m),
            rotates_while_blocked: rules.rotates_while_blocked,
            period_s: one(rules.period_s),
            detected: decided(true),
            undetected: decided(false),
            reverses: (reverses(true), reverses(false)),
            speed_gain_step_sd: noise(rules.speed_gain_step_sd),
            turn_gain_step_sd: noise(rules.turn_gain_step_sd),
            heading_noise_sd_rad: noise(rules.heading_noise_sd_rad),
            gusts: rules.gusts.map(|gusts| (one(gusts.decay), one(gusts.kick_m_s))),
            yaw_share: rules.yaw_share.map(one),
        }
    }

    /// Whether a robot's step follows from what it detects alone, so that it can be tabulated.
    pub fn is_plain(&self) -> bool {
        let is_turn_plain = !self.turn_varies() && self.rotates_while_blocked;
        is_turn_plain && self.speed_gain_step_sd.is_none() && self.gusts.is_none()
    }

    fn turn_varies(&self) -> bool {
        self.turn_gain_step_sd.is_some()
            || self.heading_noise_sd_rad.is_some()
            || self.yaw_share.is_some()
    }

    /// Which robots cannot drive on, of those with another ahead and of those with one behind.
    #[inline(always)]
    pub fn is_blocked(&self, simd: S, detected: S::M, (ahead, behind): (S::M, S::M)) -> S::M {
        match self.reverses {
            (false, false) => ahead,
            (true, true) => behind,
            (when_detected, _) => {
                let (one, zero) = (simd.single(1.0), simd.single(0.0));
                let ahead = S::F::select(ahead, one, zero);
                let behind = S::F::select(behind, one, zero);
                let (yes, no) = if when_detected { (behind, ahead) } else { (ahead, behind) };
                S::F::select(detected, yes, no).gt(zero)
            }
        }
    }

    /// Whether any robot drifts: has a state that its pose does not show.
    pub fn has_drift(&self) -> (bool, bool) {
        (self.gusts.is_some(), self.yaw_share.is_some())
    }
}

/// One robot's step in every world, as far as it is known before the run: what the controller
/// decides depends on one bit, so both answers are tabulated.
#[derive(Clone, Copy)]
pub struct NominalStep<S: Simd> {
    detection: LaneKey<S::U>,
    detected: PeriodMotion<S::F>,
    undetected: PeriodMotion<S::F>,
}

/// What a command comes to in one period.
#[derive(Clone, Copy)]
struct PeriodMotion<F> {
    travel_m: F,
    /// Cosine and sine of the turn.
    turned: (F, F),
}

/// The rest of one robot's character, for worlds in which steps vary.
#[derive(Clone, Copy)]
pub struct NoisyTraits<S: Simd> {
    speed_gain: S::F,
    turn_gain: S::F,
    turn_bias_rad_s: S::F,
    speed_gain_noise: LaneKey<S::U>,
    turn_gain_noise: LaneKey<S::U>,
    heading_noise: LaneKey<S::U>,
    gust_x: LaneKey<S::U>,
    gust_y: LaneKey<S::U>,
}

/// What a pose does not show of one robot's state.
#[derive(Clone, Copy)]
pub struct Drift<F> {
    pub gust_m_s: (F, F),
    pub yaw_rate_rad_s: F,
}

impl<S: Simd> NominalStep<S> {
    /// The step of a robot in worlds where it has these traits, one for each lane.
    pub fn new<'a>(
        simd: S,
        rules: &WorldParameters,
        controller: ControllerParameters,
        robot: usize,
        world: impl Fn(usize) -> &'a Robots,
    ) -> Self {
        let traits = |lane| world(lane).traits[robot];
        let answer = |detected: bool| {
            let command = decide(detected, controller);
            let (speed_m_s, rate_rad_s) =
                (command.speed_m_s as f32, command.turn_rate_rad_s as f32);
            let turned = |lane| {
                let traits = traits(lane);
                let rate_rad_s = rate_rad_s * traits.turn_gain + traits.turn_bias_rad_s;
                turn::turn(rate_rad_s * rules.period_s)
            };
            let travel_m = |lane| speed_m_s * traits(lane).speed_gain * rules.period_s;
            PeriodMotion {
                travel_m: simd.singles(travel_m),
                turned: (simd.singles(|lane| turned(lane).0), simd.singles(|lane| turned(lane).1)),
            }
        };
        Self {
            detection: LaneKey::new(simd, |lane| world(lane).detection_keys[robot]),
            detected: answer(true),
            undetected: answer(false),
        }
    }

    /// Whether each sensor reports a detection.
    #[inline(always)]
    pub fn detects(&self, simd: S, rules: &LaneRules<S>, seen: S::M, step: S::U) -> S::M {
        let limit = simd.select(seen, rules.true_positive, rules.false_positive);
        simd.less(self.detection.uniform24(simd, step), limit)
    }

    /// One step of a robot, in worlds where it does not vary.
    #[inline(always)]
    pub fn step(
        &self,
        simd: S,
        rules: &LaneRules<S>,
        from: &Body<S::F>,
        (detected, blocked): (S::M, S::M),
    ) -> Body<S::F> {
        let (yes, no) = (&self.detected, &self.undetected);
        let travel_m = S::F::select(detected, yes.travel_m, no.travel_m).unless(blocked);
        let to_m = (from.x_m + travel_m * from.cosine, from.y_m + travel_m * from.sine);
        let (x_m, y_m) = rules.border((from.x_m, from.y_m), to_m);
        let turned = select(detected, yes.turned, no.turned);
        let (cosine, sine) = rotate(simd, (from.cosine, from.sine), turned);
        Body { x_m, y_m, cosine, sine }
    }

    /// One step of a robot, in worlds where it may vary.
    #[inline(always)]
    pub fn step_of_trait(
        &self,
        (simd, rules, step): (S, &LaneRules<S>, S::U),
        (traits, drift): (&NoisyTraits<S>, &mut Drift<S::F>),
        from: &Body<S::F>,
        (detected, blocked): (S::M, S::M),
    ) -> Body<S::F> {
        let command = select(detected, rules.detected, rules.undetected);
        let tabulated = if rules.turn_varies() {
            None
        } else {
            Some(select(detected, self.detected.turned, self.undetected.turned))
        };
        traits.step((simd, rules, step), drift, from, (command, tabulated, blocked))
    }
}

/// What moves one robot in one step: its command of speed and turning rate, cosine and sine of its turn
/// where that is known before, and whether it cannot drive on.
type Motion<S> =
    ((<S as Simd>::F, <S as Simd>::F), Option<(<S as Simd>::F, <S as Simd>::F)>, <S as Simd>::M);

impl<S: Simd> NoisyTraits<S> {
    /// One step of a robot by a command.
    #[inline(always)]
    pub fn step(
        &self,
        (simd, rules, step): (S, &LaneRules<S>, S::U),
        drift: &mut Drift<S::F>,
        from: &Body<S::F>,
        ((speed_m_s, rate_rad_s), tabulated, blocked): Motion<S>,
    ) -> Body<S::F> {
        let traits = self;
        // No closures: one that is not inlined is not vectorized.
        let sd = rules.speed_gain_step_sd;
        let gain = traits.speed_gain_noise.with_noise(simd, step, traits.speed_gain, sd);
        let travel_m = (speed_m_s * gain * rules.period_s).unless(blocked);
        let mut to_m = (from.x_m + travel_m * from.cosine, from.y_m + travel_m * from.sine);
        if let Some((decay, kick_m_s)) = rules.gusts {
            let (x_m_s, y_m_s) = drift.gust_m_s;
            drift.gust_m_s = (
                decay * x_m_s + kick_m_s * traits.gust_x.normal(simd, step),
                decay * y_m_s + kick_m_s * traits.gust_y.normal(simd, step),
            );
            to_m.0 = to_m.0 + drift.gust_m_s.0 * rules.period_s;
            to_m.1 = to_m.1 + drift.gust_m_s.1 * rules.period_s;
        }
        let (x_m, y_m) = rules.border((from.x_m, from.y_m), to_m);
        let turned = if let Some(turned) = tabulated {
            turned
        } else {
            let sd = rules.turn_gain_step_sd;
            let gain = traits.turn_gain_noise.with_noise(simd, step, traits.turn_gain, sd);
            let mut rate_rad_s = rate_rad_s * gain + traits.turn_bias_rad_s;
            if let Some(share) = rules.yaw_share {
                rate_rad_s = drift.yaw_rate_rad_s + (rate_rad_s - drift.yaw_rate_rad_s) * share;
                drift.yaw_rate_rad_s = rate_rad_s;
            }
            let sd = rules.heading_noise_sd_rad;
            let turned_rad = rate_rad_s * rules.period_s;
            turn(simd, traits.heading_noise.with_noise(simd, step, turned_rad, sd))
        };
        let (mut cosine, mut sine) = rotate(simd, (from.cosine, from.sine), turned);
        if !rules.rotates_while_blocked {
            cosine = S::F::select(blocked, from.cosine, cosine);
            sine = S::F::select(blocked, from.sine, sine);
        }
        Body { x_m, y_m, cosine, sine }
    }
}

impl<S: Simd> NoisyTraits<S> {
    /// The character of a robot in these worlds, one for each lane.
    pub fn new<'a>(simd: S, robot: usize, world: impl Fn(usize) -> &'a Robots) -> Self {
        let traits = |lane| world(lane).traits[robot];
        let keys = |key: fn(&NoiseKeys) -> Key| {
            LaneKey::new(simd, |lane| key(&world(lane).noise_keys[robot]))
        };
        Self {
            speed_gain: simd.singles(|lane| traits(lane).speed_gain),
            turn_gain: simd.singles(|lane| traits(lane).turn_gain),
            turn_bias_rad_s: simd.singles(|lane| traits(lane).turn_bias_rad_s),
            speed_gain_noise: keys(|keys| keys.speed_gain_noise),
            turn_gain_noise: keys(|keys| keys.turn_gain_noise),
            heading_noise: keys(|keys| keys.heading_noise),
            gust_x: keys(|keys| keys.gust_x),
            gust_y: keys(|keys| keys.gust_y),
        }
    }
}

impl<S: Simd> LaneRules<S> {
    #[inline(always)]
    fn border(&self, from: (S::F, S::F), to: (S::F, S::F)) -> (S::F, S::F) {
        match self.walls {
            Walls::None => to,
            Walls::Stop => {
                let is_inside = to.0.abs().le(self.limit_m) & to.1.abs().le(self.limit_m);
                (S::F::select(is_inside, to.0, from.0), S::F::select(is_inside, to.1, from.1))
            }
            Walls::Clamp => (self.clamp(to.0), self.clamp(to.1)),
        }
    }

    #[inline(always)]
    fn clamp(&self, coordinate_m: S::F) -> S::F {
        let least_m = self.minus_limit_m;
        let above = S::F::select(coordinate_m.lt(least_m), least_m, coordinate_m);
        S::F::select(above.gt(self.limit_m), self.limit_m, above)
    }
}

/// One pair of numbers or the other.
#[inline(always)]
fn select<F: Number>(mask: F::Mask, yes: (F, F), no: (F, F)) -> (F, F) {
    (F::select(mask, yes.0, no.0), F::select(mask, yes.1, no.1))
}

#[inline(always)]
fn rotate<S: Simd>(simd: S, heading: (S::F, S::F), turned: (S::F, S::F)) -> (S::F, S::F) {
    let cosine = heading.0 * turned.0 - heading.1 * turned.1;
    let sine = heading.1 * turned.0 + heading.0 * turned.1;
    let newton = simd.single(1.5) - simd.single(0.5) * (cosine * cosine + sine * sine);
    (cosine * newton, sine * newton)
}
