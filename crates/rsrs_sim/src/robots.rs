//! The robots of a world: one entry for each in every column.

use rsrs_core::conditions::{Conditions, GainDistribution, SimulatedRobot};
use rsrs_core::robot::contact::ContactModel;
use rsrs_core::robot::unicycle::Pose;

use crate::contact::{Blocked, Border, Borders, Contact};
use crate::disturbance::{Gusts, yaw_share};
use crate::draw::{Key, Purpose, RunKey, Stream, normal, threshold};
use crate::field_of_view::FieldOfView;
use crate::numbering::reorder;
use crate::turn::turn;

/// What is the same for all robots at all times, in single precision.
pub struct WorldParameters {
    pub period_s: f32,
    pub view: FieldOfView,
    pub contact: Contact,
    pub border: Border,
    /// Along walls; dimensionless.
    pub friction: f64,
    /// Threshold of a draw, as [`threshold`] gives it.
    pub true_positive: u32,
    /// Threshold of a draw, as [`threshold`] gives it.
    pub false_positive: u32,
    pub rotates_while_blocked: bool,
    pub speed_gain_step_sd: f32,
    pub turn_gain_step_sd: f32,
    pub heading_noise_sd_rad: f32,
    pub gusts: Option<Gusts>,
    pub yaw_share: Option<f32>,
}

impl WorldParameters {
    /// The rules of a world under these conditions, for the robots that are alike.
    pub fn new(conditions: &Conditions) -> Self {
        Self::of_robot(conditions, &conditions.robot)
    }

    /// The rules for robots of one kind.
    pub fn of_robot(conditions: &Conditions, robot: &SimulatedRobot) -> Self {
        Self {
            period_s: conditions.period_s as f32,
            view: FieldOfView::new(robot),
            contact: Contact::new(robot),
            border: Borders::new(conditions).for_radius(robot.radius_m),
            friction: match robot.contact {
                ContactModel::Push => robot.contact_friction,
                ContactModel::Stop | ContactModel::None => 0.0,
            },
            true_positive: threshold(robot.true_positive),
            false_positive: threshold(robot.false_positive),
            rotates_while_blocked: robot.rotates_while_blocked,
            speed_gain_step_sd: robot.speed_gain.step_sd as f32,
            turn_gain_step_sd: robot.turn_gain.step_sd as f32,
            heading_noise_sd_rad: robot.heading_noise_sd_rad as f32,
            gusts: Gusts::new(robot, conditions.period_s),
            yaw_share: yaw_share(robot, conditions.period_s),
        }
    }
}

/// The state and the character of every robot; all columns have the same length.
pub struct Robots {
    pub x_m: Vec<f32>,
    pub y_m: Vec<f32>,
    pub cosine: Vec<f32>,
    pub sine: Vec<f32>,
    pub gust_x_m_s: Vec<f32>,
    pub gust_y_m_s: Vec<f32>,
    pub yaw_rate_rad_s: Vec<f32>,
    pub traits: Vec<RobotVariation>,
    pub detection_keys: Vec<Key>,
    pub noise_keys: Vec<NoiseKeys>,
}

/// What makes one robot differ from the next: its idiosyncrasy `θᵃ`.
#[derive(Clone, Copy)]
pub struct RobotVariation {
    pub speed_gain: f32,
    pub turn_gain: f32,
    pub turn_bias_rad_s: f32,
}

/// One robot's draws of what varies from step to step. They are a column of their own, which stays
/// out of the cache in worlds without such noise.
#[derive(Clone, Copy)]
pub struct NoiseKeys {
    pub speed_gain_noise: Key,
    pub turn_gain_noise: Key,
    pub heading_noise: Key,
    pub gust_x: Key,
    pub gust_y: Key,
}

/// One robot's command in one step, and whether contact keeps it from driving.
#[derive(Clone, Copy)]
pub struct Drive {
    pub speed_m_s: f32,
    pub turn_rate_rad_s: f32,
    pub is_blocked: bool,
    pub step: u32,
}

impl Robots {
    /// The robots at their starting poses.
    pub fn new(conditions: &Conditions, run: RunKey, poses: &[Pose]) -> Self {
        let n_robots = poses.len();
        let column =
            |value: fn(&Pose) -> f64| poses.iter().map(|pose| value(pose) as f32).collect();
        Self {
            x_m: column(|pose| pose.x_m),
            y_m: column(|pose| pose.y_m),
            cosine: column(|pose| libm::cos(pose.heading_rad)),
            sine: column(|pose| libm::sin(pose.heading_rad)),
            gust_x_m_s: vec![0.0; n_robots],
            gust_y_m_s: vec![0.0; n_robots],
            yaw_rate_rad_s: vec![0.0; n_robots],
            traits: (0..n_robots)
                .map(|robot| RobotVariation::draw(conditions, run, robot))
                .collect(),
            detection_keys: (0..n_robots).map(|robot| run.key(robot, Purpose::Detection)).collect(),
            noise_keys: (0..n_robots).map(|robot| NoiseKeys::new(run, robot)).collect(),
        }
    }

    /// Finds out for every robot whether its view contains another, and whether one is in its way.
    /// Both are written for every robot, shape `[n_robots]`.
    ///
    /// `sees` takes the forward, the lateral and the squared distance of a neighbour; it is false for
    /// the robot itself, at distance zero.
    #[inline]
    pub fn sense_pairs(
        &self,
        contact: Contact,
        found: (&mut [bool], &mut [Blocked]),
        sees: impl Fn(f32, f32, f32) -> bool,
    ) {
        let (seen, blocked) = found;
        let n_robots = self.x_m.len();
        for robot in 0..n_robots {
            let (x_m, y_m) = (self.x_m[robot], self.y_m[robot]);
            let (cosine, sine) = (self.cosine[robot], self.sine[robot]);
            // Numbers and not flags: so the compiler takes four neighbours at a time.
            let (mut n_seen, mut n_ahead, mut n_behind) = (0_u32, 0_u32, 0_u32);
            for (other_x_m, other_y_m) in self.x_m.iter().zip(&self.y_m) {
                let (dx_m, dy_m) = (other_x_m - x_m, other_y_m - y_m);
                let d2_m2 = dx_m * dx_m + dy_m * dy_m;
                let forward_m = dx_m * cosine + dy_m * sine;
                let lateral_m = dy_m * cosine - dx_m * sine;
                n_seen |= u32::from(sees(forward_m, lateral_m, d2_m2));
                n_ahead |= u32::from(contact.blocks_ahead(forward_m, d2_m2));
                n_behind |= u32::from(contact.blocks_behind(forward_m, d2_m2));
            }
            seen[robot] = n_seen != 0;
            blocked[robot] = Blocked { ahead: n_ahead != 0, behind: n_behind != 0 };
        }
    }

    /// Moves one robot by one control period, in the order that [`crate::world`] defines.
    #[inline]
    pub fn advance(&mut self, rules: &WorldParameters, robot: usize, drive: Drive) {
        let traits = self.traits[robot];
        self.translate(rules, robot, drive, traits);
        let noise: Noise = (rules.turn_gain_step_sd, |keys| keys.turn_gain_noise);
        let gain = self.with_noise(traits.turn_gain, noise, robot, drive.step);
        let mut rate_rad_s = drive.turn_rate_rad_s * gain + traits.turn_bias_rad_s;
        if let Some(share) = rules.yaw_share {
            let yaw_rate_rad_s = self.yaw_rate_rad_s[robot];
            rate_rad_s = yaw_rate_rad_s + (rate_rad_s - yaw_rate_rad_s) * share;
            self.yaw_rate_rad_s[robot] = rate_rad_s;
        }
        if rules.rotates_while_blocked || !drive.is_blocked {
            let noise: Noise = (rules.heading_noise_sd_rad, |keys| keys.heading_noise);
            let angle_rad = rate_rad_s * rules.period_s;
            self.rotate(robot, self.with_noise(angle_rad, noise, robot, drive.step));
        }
    }

    fn translate(
        &mut self,
        rules: &WorldParameters,
        robot: usize,
        drive: Drive,
        traits: RobotVariation,
    ) {
        let travel_m = if drive.is_blocked {
            0.0
        } else {
            let noise: Noise = (rules.speed_gain_step_sd, |keys| keys.speed_gain_noise);
            let gain = self.with_noise(traits.speed_gain, noise, robot, drive.step);
            drive.speed_m_s * gain * rules.period_s
        };
        let from_m = (self.x_m[robot], self.y_m[robot]);
        let mut to_m =
            (from_m.0 + travel_m * self.cosine[robot], from_m.1 + travel_m * self.sine[robot]);
        if let Some(Gusts { decay, kick_m_s }) = rules.gusts {
            let keys = self.noise_keys[robot];
            let x_m_s = decay * self.gust_x_m_s[robot] + kick_m_s * normal(keys.gust_x, drive.step);
            let y_m_s = decay * self.gust_y_m_s[robot] + kick_m_s * normal(keys.gust_y, drive.step);
            to_m = (to_m.0 + x_m_s * rules.period_s, to_m.1 + y_m_s * rules.period_s);
            (self.gust_x_m_s[robot], self.gust_y_m_s[robot]) = (x_m_s, y_m_s);
        }
        (self.x_m[robot], self.y_m[robot]) =
            rules.border.drive_with_friction(from_m, to_m, rules.friction);
    }

    /// A number with noise of a standard deviation; without one, nothing is drawn or added.
    #[inline]
    fn with_noise(&self, number: f32, (sd, key): Noise, robot: usize, step: u32) -> f32 {
        if sd == 0.0 { number } else { number + sd * normal(key(&self.noise_keys[robot]), step) }
    }

    fn rotate(&mut self, robot: usize, angle_rad: f32) {
        let (turned_cosine, turned_sine) = turn(angle_rad);
        let (cosine, sine) = (self.cosine[robot], self.sine[robot]);
        let new_cosine = cosine * turned_cosine - sine * turned_sine;
        let new_sine = sine * turned_cosine + cosine * turned_sine;
        let newton = 1.5 - 0.5 * (new_cosine * new_cosine + new_sine * new_sine);
        self.cosine[robot] = new_cosine * newton;
        self.sine[robot] = new_sine * newton;
    }

    /// Changes the order of the robots, and nothing else; `order` is where each is now.
    pub fn reorder(&mut self, order: &[u32]) {
        for column in [
            &mut self.x_m,
            &mut self.y_m,
            &mut self.cosine,
            &mut self.sine,
            &mut self.gust_x_m_s,
            &mut self.gust_y_m_s,
            &mut self.yaw_rate_rad_s,
        ] {
            reorder(column, order);
        }
        reorder(&mut self.traits, order);
        reorder(&mut self.detection_keys, order);
        reorder(&mut self.noise_keys, order);
    }
}

/// A standard deviation, and whose draws it scales.
type Noise = (f32, fn(&NoiseKeys) -> Key);

impl NoiseKeys {
    fn new(run: RunKey, robot: usize) -> Self {
        let key = |purpose| run.key(robot, purpose);
        Self {
            speed_gain_noise: key(Purpose::SpeedGainNoise),
            turn_gain_noise: key(Purpose::TurnGainNoise),
            heading_noise: key(Purpose::HeadingNoise),
            gust_x: key(Purpose::GustX),
            gust_y: key(Purpose::GustY),
        }
    }
}

impl RobotVariation {
    fn draw(conditions: &Conditions, run: RunKey, robot: usize) -> Self {
        let simulated = conditions.robot_at(robot);
        let normal = |purpose| Stream::new(run, robot, purpose).truncated_normal();
        // A robot may be weak, but it does not drive backward when commanded forward.
        let gain = |distribution: GainDistribution, purpose| {
            let spread = if distribution.robot_sd == 0.0 {
                0.0
            } else {
                distribution.robot_sd * normal(purpose)
            };
            (distribution.mean + spread).max(0.0) as f32
        };
        let turn_bias_rad_s = if simulated.turn_bias_sd_rad_s == 0.0 {
            0.0
        } else {
            simulated.turn_bias_sd_rad_s * normal(Purpose::TurnBias)
        };
        Self {
            speed_gain: gain(simulated.speed_gain, Purpose::SpeedGain),
            turn_gain: gain(simulated.turn_gain, Purpose::TurnGain),
            turn_bias_rad_s: turn_bias_rad_s as f32,
        }
    }
}
