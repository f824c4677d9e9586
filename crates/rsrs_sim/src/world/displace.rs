//! Robots that something else than the world moves.

use rsrs_core::robot::unicycle::Pose;

use super::World;

impl World {
    /// Puts a robot somewhere, as a hand or a tracker does.
    ///
    /// The world is then none that any seed leads to: its digest shows it. A gust and a turning
    /// rate that lags end with the displacement; what the robot is stays.
    ///
    /// The pose is rounded to single precision.
    ///
    /// # Panics
    ///
    /// If there is no such robot, or the pose is not finite in single precision.
    pub fn displace(&mut self, robot: usize, pose: Pose) {
        let Pose { x_m, y_m, heading_rad } = pose;
        let (x_m, y_m) = (x_m as f32, y_m as f32);
        assert!(
            x_m.is_finite() && y_m.is_finite() && heading_rad.is_finite(),
            "no robot can be at {pose:?}"
        );
        let (sine, cosine) = libm::sincos(heading_rad);
        let robots = &mut self.robots;
        (robots.x_m[robot], robots.y_m[robot]) = (x_m, y_m);
        (robots.cosine[robot], robots.sine[robot]) = (cosine as f32, sine as f32);
        (robots.gust_x_m_s[robot], robots.gust_y_m_s[robot]) = (0.0, 0.0);
        robots.yaw_rate_rad_s[robot] = 0.0;
        self.is_sensed = false;
    }
}

#[cfg(test)]
mod tests {
    use crate::draw::Seed;
    use rsrs_testing::conditions::flockbot_conditions;

    use super::*;

    #[test]
    fn a_robot_that_is_displaced_is_there_and_the_others_see_it_there() {
        let mut conditions = flockbot_conditions();
        conditions.robot.true_positive = 1.0;
        conditions.robot.false_positive = 0.0;
        conditions.robots = 2;
        let mut world = World::new(&conditions, Seed { seed: 1, replicate: 0 }).unwrap();
        let before = world.digest();
        let ahead = Pose { x_m: 0.4, y_m: 0.0, heading_rad: 0.0 };

        world.displace(0, Pose { x_m: 0.0, y_m: 0.0, heading_rad: 0.0 });
        world.displace(1, ahead);

        assert_eq!(world.sense(), [true, false]);
        let there = world.poses().nth(1).unwrap();
        assert!((there.x_m - ahead.x_m).abs() < 1e-6, "{there:?}");
        assert_ne!(world.digest(), before);
    }
}
