//! The profile of a fleet, and those of robots that have their own.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use rsrs_core::conditions::{ClassChanges, Conditions, Settings};
use rsrs_core::help::Helpful;
use rsrs_core::robot::controller::Controller;
use rsrs_core::robot::harsher::HarsherFactors;
use rsrs_core::robot::profile::RobotProfile;
use rsrs_core::world::WorldFile;
use rsrs_fleet::fleet_file::{FleetFile, FleetRobot};
use rsrs_fleet::record::OwnProfile;

use super::{limits, read, read_named};

/// A measured profile, as it was read.
#[derive(Clone, Debug)]
pub(super) struct Measured {
    pub(super) path: PathBuf,
    pub(super) text: String,
    pub(super) profile: RobotProfile,
}

impl Measured {
    fn read(path: PathBuf) -> anyhow::Result<Self> {
        let text = read(&path)?;
        Self::of_text(path, text)
    }

    fn of_text(path: PathBuf, (name, text): (String, String)) -> anyhow::Result<Self> {
        let profile = RobotProfile::parse(&name, &text)
            .map_err(Helpful::from)
            .with_context(|| format!("{name} does not describe a robot"))?;
        Ok(Self { path, text, profile })
    }

    /// That which the fleet file gives one robot.
    pub(super) fn of_robot(robot: &FleetRobot, fleet: &Path) -> anyhow::Result<Self> {
        let file = fleet.display().to_string();
        let profile = FleetFile::profile_of(&file, robot).map_err(Helpful::from)?;
        Self::read(beside(fleet, profile))
            .with_context(|| format!("the profile of {} in {file}", robot.name))
    }

    /// That which the file of a world gives a class.
    pub(super) fn of_class(path: &Path, world: &str) -> anyhow::Result<Self> {
        Self::of_text(path.to_owned(), read_named("profile", path, world)?)
    }

    /// That of the whole fleet.
    pub(super) fn of_fleet(fleet: &FleetFile, path: &Path) -> anyhow::Result<Self> {
        let first = fleet.first(1).with_context(|| path.display().to_string())?;
        let Some(profile) = &fleet.profile else {
            let [first] = first[..] else { bail!("a cell has at least one robot") };
            return Self::of_robot(first, path);
        };
        Self::read(beside(path, profile))
    }
}

/// A path that stands in a fleet file is relative to it.
fn beside(fleet: &Path, profile: &str) -> PathBuf {
    fleet.parent().unwrap_or(Path::new("")).join(profile)
}

/// What the robots of a run are.
#[derive(Clone, Debug)]
pub(super) struct Profiles {
    pub(super) fleet: Measured,
    /// By robot, where a profile is another one than the fleet's.
    own: BTreeMap<String, Measured>,
}

impl Profiles {
    /// Reads the profiles of the robots that have another one than the fleet.
    pub(super) fn read(
        fleet: Measured,
        robots: &[FleetRobot],
        path: &Path,
    ) -> anyhow::Result<Self> {
        let digest = fleet.profile.digest();
        let mut own = BTreeMap::new();
        for robot in robots {
            let measured = Measured::of_robot(robot, path)?;
            if measured.profile.digest() != digest {
                own.insert(robot.name.clone(), measured);
            }
        }
        Ok(Self { fleet, own })
    }

    pub(super) fn of(&self, robot: &str) -> &RobotProfile {
        self.own.get(robot).map_or(&self.fleet.profile, |own| &own.profile)
    }

    /// Refuses robots that have another profile than their class.
    pub(super) fn check_classes(
        &self,
        robots: &[FleetRobot],
        world: &WorldFile,
    ) -> anyhow::Result<()> {
        for (place, class, profile) in world.robots_with_profiles(robots.len()) {
            let robot = &robots[place].name;
            let differences = self.of(robot).differences(profile, "its class");
            if !differences.is_empty() {
                let keys = differences.iter().filter_map(|differs| differs.split(' ').next());
                let keys = keys.collect::<Vec<_>>().join(" and ");
                let other = format!(
                    "{robot} is of class {class}, and has another profile than that class in the \
                     world: {keys} differ"
                );
                let help = format!(
                    "give {robot} `profile: FILE` in the fleet, the file that class {class} has in \
                     the world"
                );
                return Err(Helpful::new(other, help).into());
            }
        }
        Ok(())
    }

    /// What is recorded of the robots that have their own.
    pub(super) fn recorded(&self) -> BTreeMap<String, OwnProfile> {
        let recorded = |(robot, own): (&String, &Measured)| {
            let differs = own.profile.differences(&self.fleet.profile, "fleet");
            (robot.clone(), OwnProfile { digest: own.profile.digest(), differs })
        };
        self.own.iter().map(recorded).collect()
    }

    /// Greatest commands of the robots that have their own, in m/s and rad/s.
    pub(super) fn own_limits(&self) -> BTreeMap<String, [f64; 2]> {
        let own = self.own.iter();
        own.map(|(robot, own)| (robot.clone(), limits(&own.profile))).collect()
    }

    /// All files of a run, by the names that they have beside its record.
    pub(super) fn with_files(
        &self,
        [experiment, fleet]: [String; 2],
        more: [(&'static str, Option<String>); 3],
    ) -> Vec<(String, String)> {
        let of_run = [
            ("experiment.yaml", experiment),
            (FleetFile::NAME, fleet),
            ("profile.yaml", self.fleet.text.clone()),
        ];
        let more = more.into_iter().filter_map(|(name, text)| Some((name, text?)));
        let of_run = of_run.into_iter().chain(more).map(|(name, text)| (name.to_owned(), text));
        let own = self.own.iter().map(|(robot, own)| (file_of(robot), own.text.clone()));
        of_run.chain(own).collect()
    }

    /// Refuses a cell that is beyond the limits of the fleet's profile, or of a robot's own.
    pub(super) fn check_limits(&self, controller: &Controller) -> anyhow::Result<()> {
        self.fleet.profile.check_limits(controller).map_err(Helpful::from)?;
        self.own.iter().try_for_each(|(robot, own)| {
            own.profile.check_limits(controller).map_err(Helpful::from).with_context(|| {
                format!("{robot} has a profile of its own, {}", own.path.display())
            })
        })
    }

    /// The conditions of a run of these robots, in the order of the world's rows; with `factors`,
    /// the simulator makes each of them worse than its own profile.
    pub(super) fn conditions(
        &self,
        robots: &[FleetRobot],
        factors: Option<HarsherFactors>,
        settings: &Settings,
    ) -> anyhow::Result<Conditions> {
        let moved = |profile: &RobotProfile| match factors {
            None => Ok(profile.clone()),
            Some(factors) => factors.apply(profile),
        };
        let as_of_fleet = |factors| ClassChanges::as_of(&self.fleet.profile, factors);
        let class_changes = factors.map_or_else(ClassChanges::default, as_of_fleet);
        let settings = &Settings { class_changes, ..settings.clone() };
        let mut conditions = Conditions::resolve(&moved(&self.fleet.profile)?, settings)?;
        let of_classes = settings.world.robots_with_profiles(robots.len());
        let of_classes: Vec<usize> = of_classes.map(|(place, _, _)| place).collect();
        for (place, robot) in robots.iter().enumerate() {
            let Some(own) = self.own.get(&robot.name) else { continue };
            // That of its class, which is made worse as it needs.
            if of_classes.contains(&place) {
                continue;
            }
            let of_robot = || format!("{}, by its own profile {}", robot.name, own.path.display());
            let profile = moved(&own.profile).with_context(of_robot)?;
            conditions.put_own_robot(place, &profile, settings).with_context(of_robot)?;
        }
        conditions.check()?;
        Ok(conditions)
    }
}

/// The file of a robot's own profile, beside the record; a name with a namespace is no folder.
fn file_of(robot: &str) -> String {
    format!("profile.{}.yaml", robot.replace('/', "."))
}

#[cfg(test)]
mod tests {
    use rsrs_core::quantity::Axis;

    use super::*;

    use rsrs_testing::conditions::{FLOCKBOT, flockbot};

    fn measured(change: impl FnOnce(&mut RobotProfile)) -> Measured {
        let mut profile = flockbot();
        change(&mut profile);
        Measured { path: PathBuf::from("flockbot.yaml"), text: FLOCKBOT.to_owned(), profile }
    }

    #[test]
    fn what_makes_a_world_harsher_makes_each_robot_worse_from_its_own_profile() {
        let own = measured(|profile| {
            profile.sensing.true_positive = 0.5;
            profile.computation.period_s = 0.05;
        });
        let profiles = Profiles {
            fleet: measured(|_| {}),
            own: BTreeMap::from([("lab/two".to_owned(), own.clone())]),
        };
        let fleet = "fileversion: 1\nall: {driver: {kind: virtual}}\n\
                     robots: {one: {enabled: true}, lab/two: {enabled: true}}\n";
        let robots = FleetFile::parse("fleet.yaml", fleet).unwrap().robots;
        let values = vec![(Axis::Speed, 0.15), (Axis::TurnRate, 0.75), (Axis::Robots, 2.0)];
        let settings = Settings { values, ..Settings::default() };
        let factors = HarsherFactors::for_robot(&profiles.fleet.profile);
        let conditions = |factors| profiles.conditions(&robots, factors, &settings).unwrap();

        let (measured, harsher) = (conditions(None), conditions(Some(factors)));

        let true_positive = |profile: &RobotProfile| {
            factors.apply(profile).unwrap().sensing.true_positive.to_bits()
        };
        let found = |robot: usize| harsher.robot_at(robot).true_positive.to_bits();
        assert_eq!(found(0), true_positive(&profiles.fleet.profile));
        assert_eq!(found(1), true_positive(&own.profile));
        assert!(harsher.robot_at(1).true_positive < measured.robot_at(1).true_positive);
        assert_eq!(measured.robot_at(1).true_positive.to_bits(), 0.5_f64.to_bits());
        assert_eq!(measured.period_s.to_bits(), 0.13_f64.to_bits(), "a world has one period");
        let names: Vec<String> = profiles
            .with_files(
                ["e", "f"].map(str::to_owned),
                [("starts.csv", None), ("controller.yaml", None), ("world.yaml", None)],
            )
            .into_iter()
            .map(|it| it.0)
            .collect();
        let expected = ["experiment.yaml", "fleet.yaml", "profile.yaml", "profile.lab.two.yaml"];
        assert_eq!(names, expected);
    }
}
