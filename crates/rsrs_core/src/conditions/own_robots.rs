//! Swarms whose robots are not all alike.

use super::{Conditions, ConditionsError, Settings, SimulatedRobot};
use crate::document::source::Source;
use crate::robot::controller::Controller;
use crate::robot::profile::RobotProfile;
use crate::world::{RobotClass, WorldFile};

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
    /// starts, what it is commanded, and the control period of the swarm stay.
    pub fn put_own_robot(
        &mut self,
        place: usize,
        robot: &RobotProfile,
        settings: &Settings,
    ) -> Result<(), ConditionsError> {
        let (own, _) = self.own_robot(robot, settings)?;
        self.own_robots.insert(place, own);
        Ok(())
    }

    /// Gives each robot of a class with a profile of its own that profile.
    pub(super) fn put_classes(&mut self, settings: &Settings) -> Result<(), ConditionsError> {
        let mut of_classes: Vec<Option<SimulatedRobot>> = Vec::new();
        for class in &settings.world.classes {
            let measured = match &class.profile {
                None => None,
                Some(Source::Read(measured)) => Some(measured),
                Some(Source::File(path)) => {
                    let (class, path) = (class.name.clone(), path.clone());
                    return Err(ConditionsError::ProfileNotRead { class, path });
                }
            };
            let robot = measured.map(|measured| self.robot_of_class(measured, settings));
            of_classes.push(robot.transpose().map_err(|source| of_class(class, source))?);
        }
        for (place, class) in settings.world.classes_of(self.robots).into_iter().enumerate() {
            if let Some(robot) = &of_classes[class] {
                self.own_robots.insert(place, robot.clone());
            }
        }
        Ok(())
    }

    fn robot_of_class(
        &self,
        measured: &RobotProfile,
        settings: &Settings,
    ) -> Result<SimulatedRobot, ConditionsError> {
        let simulated = settings.class_changes.simulated(measured)?;
        let (robot, period_s) = self.own_robot(&simulated, settings)?;
        // Contact, clusters and pictures have one radius, and a world one period.
        if robot.radius_m.to_bits() != self.robot.radius_m.to_bits() {
            let (found_m, expected_m) = (robot.radius_m, self.robot.radius_m);
            return Err(ConditionsError::OtherRadius { found_m, expected_m });
        }
        if period_s.to_bits() != self.period_s.to_bits() {
            let (found_s, expected_s) = (period_s, self.period_s);
            return Err(ConditionsError::OtherPeriod { found_s, expected_s });
        }
        Ok(robot)
    }

    /// A robot by a profile of its own, and the control period of that, in seconds.
    fn own_robot(
        &self,
        robot: &RobotProfile,
        settings: &Settings,
    ) -> Result<(SimulatedRobot, f64), ConditionsError> {
        // Where robots start has been checked, or is once all are there.
        let world = settings.world.without_profiles();
        let settings = Settings { placement: None, world, ..settings.clone() };
        let Self { controller, robot: own, period_s, .. } = Self::resolve(robot, &settings)?;
        let [found, expected] = [&own, &self.robot].map(SimulatedRobot::reading_names);
        if found != expected {
            let [found, expected] = [found, expected].map(|names| names.to_string());
            return Err(ConditionsError::OtherReadings { found, expected });
        }
        // The wheels of a table's rows are those of each robot.
        if controller != self.controller {
            return Err(ConditionsError::OtherWheels);
        }
        Ok((own, period_s))
    }
}

impl Conditions {
    /// Whether no robot is commanded what its profile forbids: that of `measured`, or its class's own.
    pub fn is_within_limits(&self, measured: &RobotProfile) -> bool {
        measured.check_limits(&self.controller).is_ok()
            && self.world.check_limits(&self.controller).is_ok()
    }
}

impl WorldFile {
    /// Refuses commands that the profile of a class forbids.
    pub fn check_limits(&self, controller: &Controller) -> Result<(), ConditionsError> {
        self.classes.iter().try_for_each(|class| {
            let limits = class.own_profile().map(|profile| profile.check_limits(controller));
            limits.unwrap_or(Ok(())).map_err(|beyond| of_class(class, beyond.into()))
        })
    }
}

/// Why a class with a profile of its own is not for a swarm.
fn of_class(class: &RobotClass, source: ConditionsError) -> ConditionsError {
    let (class, path) = (class.name.clone(), class.read_from.clone());
    ConditionsError::OfClass { class, path, source: Box::new(source) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::conditions::ClassChanges;
    use crate::quantity::Axis;
    use crate::robot::harsher::HarsherFactors;

    use rsrs_testing::conditions::FLOCKBOT;

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
    fn a_class_has_a_profile_of_its_own_that_is_made_worse_as_the_others_were() {
        let profile = RobotProfile::parse("flockbot.yaml", FLOCKBOT).unwrap();
        let mut own = profile.clone();
        own.sensing.true_positive = 0.9;
        let class = |name: &str, profile| RobotClass {
            name: name.to_owned(),
            profile,
            ..RobotClass::default()
        };
        let classes = vec![class("a", None), class("b", Some(Source::Read(own.clone())))];
        let world = WorldFile { classes, ..WorldFile::NOTHING };
        let factors = HarsherFactors::for_robot(&profile);
        let robots = |factors: Option<HarsherFactors>| {
            let class_changes = factors.map_or_else(ClassChanges::default, |factors| {
                ClassChanges::as_of(&profile, factors)
            });
            Conditions::resolve(
                &profile,
                &Settings { world: world.clone(), class_changes, ..settings() },
            )
        };
        let classes_of = |conditions: &Conditions| {
            (0..3).map(|robot| conditions.robot_at(robot).true_positive).collect::<Vec<_>>()
        };

        let (measured, harsher) = (robots(None).unwrap(), robots(Some(factors)).unwrap());

        assert_eq!(classes_of(&measured), [0.98, 0.9, 0.98]);
        // What the sweep leaves out is as this profile needs it.
        let worse = HarsherFactors::for_robot(&own).apply(&own).unwrap().sensing.true_positive;
        assert_eq!(classes_of(&harsher), [0.98, worse, 0.98], "that of the others is the caller's");
        assert!(worse < 0.9);
        let text = serde_json::to_string(&measured).unwrap();
        assert_eq!(serde_json::from_str::<Conditions>(&text).unwrap(), measured);
        assert_ne!(measured.digest(), Conditions::resolve(&profile, &settings()).unwrap().digest());
        let unread = vec![class("a", Some(Source::File("a.yaml".to_owned())))];
        let world = WorldFile { classes: unread, ..WorldFile::NOTHING };
        let error = Conditions::resolve(&profile, &Settings { world, ..settings() }).unwrap_err();
        assert_eq!(error.to_string(), "the profile of class a, a.yaml, was not read");
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
