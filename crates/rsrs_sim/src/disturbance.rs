//! What the world does to a robot besides its command: the paper's `w`.

use rsrs_core::conditions::SimulatedRobot;

/// Gusts: on each axis of the plane a velocity that forgets itself with a time constant.
///
/// An Ornstein-Uhlenbeck process, discretised exactly: from one step to the next the velocity
/// decays by `exp(-Δt/τ)` and is refreshed so that its standard deviation stays what it is. The air
/// is calm at the start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gusts {
    /// What remains of the velocity after one step; dimensionless.
    pub decay: f32,
    /// Standard deviation of what is added in one step, in metres per second.
    pub kick_m_s: f32,
}

impl Gusts {
    /// The gusts upon a robot; `None` if there are none.
    pub fn new(robot: &SimulatedRobot, period_s: f64) -> Option<Self> {
        if robot.gust_sd_m_s == 0.0 {
            return None;
        }
        let decay = libm::exp(-period_s / robot.gust_time_constant_s);
        let kick_m_s = robot.gust_sd_m_s * (1.0 - decay * decay).sqrt();
        Some(Self { decay: decay as f32, kick_m_s: kick_m_s as f32 })
    }
}

/// Share of the way that a lagging turning rate goes towards its target in one step; `None` if it
/// follows at once.
pub fn yaw_share(robot: &SimulatedRobot, period_s: f64) -> Option<f32> {
    (robot.yaw_lag_s > 0.0).then(|| (period_s / robot.yaw_lag_s).min(1.0) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draw::{Purpose, RunKey, Seed, normal};
    use rsrs_testing::conditions::flockbot_conditions;

    #[test]
    fn gusts_keep_their_standard_deviation() {
        let robot = SimulatedRobot {
            gust_sd_m_s: 0.03,
            gust_time_constant_s: 2.0,
            ..flockbot_conditions().robot
        };
        let gusts = Gusts::new(&robot, 0.13).unwrap();
        let run = RunKey::new(Seed { seed: 1, replicate: 0 }, 0);

        let n_steps = 20_000_u32;
        let mut sum = 0.0;
        for robot in 0..10 {
            let key = run.key(robot, Purpose::GustX);
            let mut gust = 0.0_f32;
            for step in 0..n_steps {
                gust = gusts.decay * gust + gusts.kick_m_s * normal(key, step);
                sum += f64::from(gust * gust);
            }
        }

        // 200,000 steps of 0.13 s are 26,000 s, about 13,000 correlation times: 1 % standard error.
        let sd = (sum / f64::from(10 * n_steps)).sqrt();
        assert!((sd / 0.03 - 1.0).abs() < 0.03, "{sd}");
    }

    #[test]
    fn no_gusts_and_no_lag_are_none() {
        let robot = flockbot_conditions().robot;

        assert_eq!(Gusts::new(&robot, 0.13), None);
        assert_eq!(yaw_share(&robot, 0.13), None);
    }
}
