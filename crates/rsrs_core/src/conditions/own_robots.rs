//! Swarms whose robots are not all alike.

use super::{Conditions, ConditionsError, Settings, SimulatedRobot};
use crate::robot::profile::RobotProfile;

impl Conditions {
    /// What one robot is, by its place among all, from 0.
    pub fn robot_at(&self, robot: usize) -> &SimulatedRobot {
        self.own_robots.get(&robot).unwrap_or(&self.robot)
    }

    /// Whether each robot is like the next.
    pub fn are_robots_alike(&self) -> bool {
        self.own_robots.is_empty()
    }

    /// Radius of the largest body, in metres.
    pub fn largest_radius_m(&self) -> f64 {
        let own = self.own_robots.values().map(|robot| robot.radius_m);
        own.fold(self.robot.radius_m, f64::max)
    }

    /// Radius of the smallest body, in metres.
    pub fn smallest_radius_m(&self) -> f64 {
        let own = self.own_robots.values().map(|robot| robot.radius_m);
        own.fold(self.robot.radius_m, f64::min)
    }

    /// Puts a robot with a profile of its own in the place of one that is like the others. Where it
    /// starts, and what it is commanded, stays; so does the control period, which the swarm has one of.
    ///
    /// # Errors
    ///
    /// [`ConditionsError`] if this robot and these settings make no conditions.
    pub fn put_own_robot(
        &mut self,
        place: usize,
        robot: &RobotProfile,
        settings: &Settings,
    ) -> Result<(), ConditionsError> {
        // Where robots start has been checked, or is once all are there.
        let settings = Settings { placement: None, ..settings.clone() };
        let Self { controller, robot: own, .. } = Self::resolve(robot, &settings)?;
        let [found, expected] = [&own, &self.robot].map(SimulatedRobot::reading_names);
        if found != expected {
            let [found, expected] = [found, expected].map(|names| names.to_string());
            return Err(ConditionsError::OtherReadings { found, expected });
        }
        // The wheels of a table's rows are those of each robot.
        if controller != self.controller {
            return Err(ConditionsError::OtherWheels);
        }
        self.own_robots.insert(place, own);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quantity::Axis;

    const FLOCKBOT: &str = include_str!("../../../../launch_configs/profiles/flockbot.yaml");

    fn settings() -> Settings {
        let values = vec![(Axis::Speed, 0.15), (Axis::TurnRate, 0.75), (Axis::Robots, 3.0)];
        Settings { values, ..Settings::default() }
    }

    fn mixed() -> Conditions {
        let profile = RobotProfile::parse("flockbot.yaml", FLOCKBOT).unwrap();
        let mut own = profile.clone();
        own.body.radius_m = 0.1;
        own.sensing.latency_steps = 4;
        own.computation.period_s = 0.05;
        let mut conditions = Conditions::resolve(&profile, &settings()).unwrap();
        conditions.put_own_robot(1, &own, &settings()).unwrap();
        conditions
    }

    #[test]
    fn a_robot_of_its_own_profile_differs_from_the_others_and_they_stay_as_they_were() {
        let profile = RobotProfile::parse("flockbot.yaml", FLOCKBOT).unwrap();
        let alike = Conditions::resolve(&profile, &settings()).unwrap();

        let mixed = mixed();

        assert_eq!(mixed.robot_at(0), &alike.robot);
        assert_eq!(mixed.robot_at(1).latency_steps, 4);
        let radii_m = [mixed.largest_radius_m(), mixed.smallest_radius_m()];
        assert_eq!(radii_m.map(f64::to_bits), [0.1, 0.075].map(f64::to_bits));
        assert_eq!(mixed.period_s.to_bits(), alike.period_s.to_bits());
        assert_ne!(mixed.digest(), alike.digest(), "it is another world");
        assert!(!mixed.are_robots_alike());
        assert_eq!(mixed.check(), Ok(()));
    }

    #[test]
    fn conditions_of_robots_that_differ_read_back_and_those_of_others_are_written_as_ever() {
        let mixed = mixed();
        let text = serde_json::to_string(&mixed).unwrap();
        let alike = Conditions { own_robots: std::collections::BTreeMap::new(), ..mixed.clone() };

        assert_eq!(serde_json::from_str::<Conditions>(&text).unwrap(), mixed);
        assert!(!serde_json::to_string(&alike).unwrap().contains("own_robots"));
    }

    #[test]
    fn a_robot_of_its_own_that_cannot_be_is_named() {
        let mut impossible = mixed();
        impossible.own_robots.get_mut(&1).unwrap().true_positive = 1.5;
        let mut nobody = mixed();
        let robot = nobody.own_robots[&1].clone();
        nobody.own_robots.insert(3, robot);

        let text = impossible.check().unwrap_err().to_string();
        assert_eq!(text, "own_robots.1: robot.true_positive is 1.5, expected a number from 0 to 1");
        let text = nobody.check().unwrap_err().to_string();
        assert_eq!(text, "own_robots has one at 3, and there are 3 robots, counted from 0");
    }
}
