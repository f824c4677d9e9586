//! Classes of robots: which robot is of which.
//!
//! By its number alone, so that everybody who knows the file and how many robots there are knows it: they are dealt to
//! the classes in turn, in the order of their numbers, as in P. Mitrano et al., MRS 2019.

use serde::{Deserialize, Serialize};

use super::WorldFile;
use crate::document::source::Source;
use crate::robot::profile::RobotProfile;

/// Robots of one class: they tell each other from all others by sensors of `kin` and `other`.
#[derive(Clone, Debug, Default, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RobotClass {
    /// What people call it: small letters, digits and `_`, a letter first.
    pub name: String,
    /// How many robots it has; classes without it share the others equally, the first ones having one more where that
    /// is not possible.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub count: Option<usize>,
    /// Path of its measured profile, relative to this file; without it, its robots have the profile of the sweep or of
    /// the fleet.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub profile: Option<Source<RobotProfile>>,
    /// Path of the profile that was read, as the file of the world names it, for errors; no part of what the class is.
    #[serde(skip)]
    pub read_from: Option<String>,
}

impl PartialEq for RobotClass {
    fn eq(&self, other: &Self) -> bool {
        let Self { name, count, profile, read_from: _ } = self;
        (name, count, profile) == (&other.name, &other.count, &other.profile)
    }
}

impl RobotClass {
    /// Its own profile, if it has one that was read.
    pub fn own_profile(&self) -> Option<&RobotProfile> {
        self.profile.as_ref()?.read()
    }

    /// The profile of its robots: its own, if it has one that was read, or that of all others.
    pub fn profile_or<'a>(&'a self, of_others: &'a RobotProfile) -> &'a RobotProfile {
        self.own_profile().unwrap_or(of_others)
    }
}

impl WorldFile {
    /// How many robots each class has; shape `[n_classes]`.
    pub fn class_sizes(&self, n_robots: usize) -> Vec<usize> {
        let counted = self.counted_robots();
        let n_sharing = self.n_sharing_classes();
        let rest = n_robots.saturating_sub(counted);
        let mut sharing = 0..n_sharing;
        let mut share = || {
            let place = sharing.next().expect("one for each class without a count");
            rest / n_sharing + usize::from(place < rest % n_sharing)
        };
        self.classes.iter().map(|class| class.count.unwrap_or_else(&mut share)).collect()
    }

    /// The name of the class of each robot, by place; `None` where there are no classes. Shape `[n_robots]`.
    pub fn class_names_of(&self, n_robots: usize) -> Vec<Option<&str>> {
        let classes = self.classes_of(n_robots);
        let name = |robot: usize| Some(self.classes[*classes.get(robot)?].name.as_str());
        (0..n_robots).map(name).collect()
    }

    /// Reads the profiles of classes that have one of their own; `read` gives the one at a path
    /// relative to the file of the world.
    pub fn read_profiles<E>(
        &mut self,
        mut read: impl FnMut(&str) -> Result<RobotProfile, E>,
    ) -> Result<(), E> {
        for class in &mut self.classes {
            if let Some(Source::File(path)) = &class.profile {
                let profile = read(path)?;
                class.read_from = Some(path.clone());
                class.profile = Some(Source::Read(profile));
            }
        }
        Ok(())
    }

    /// The profile of each robot whose class has one of its own, with its place and the name of its class; none of those
    /// that were not read yet.
    pub fn robots_with_profiles(
        &self,
        n_robots: usize,
    ) -> impl Iterator<Item = (usize, &str, &RobotProfile)> {
        self.classes_of(n_robots).into_iter().enumerate().filter_map(|(robot, class)| {
            let class = &self.classes[class];
            Some((robot, class.name.as_str(), class.own_profile()?))
        })
    }

    /// The names and the profiles of classes that have one of their own, as far as they were read.
    pub fn profiles(&self) -> impl Iterator<Item = (&str, &RobotProfile)> {
        self.classes.iter().filter_map(|class| Some((class.name.as_str(), class.own_profile()?)))
    }

    /// The robots by the names of their profiles: `flockbot`, or `flockbot (class a), foot_bot (class b)` where a class
    /// has one of its own; `of_others` is that of the rest.
    pub fn robot_names(&self, of_others: &RobotProfile) -> String {
        if self.profiles().next().is_none() {
            return of_others.name.clone();
        }
        let named = |class: &RobotClass| {
            format!("{} (class {})", class.profile_or(of_others).name, class.name)
        };
        self.classes.iter().map(named).collect::<Vec<_>>().join(", ")
    }

    /// The same world without the profiles of its classes.
    #[must_use]
    pub fn without_profiles(&self) -> Self {
        let mut world = self.clone();
        world.classes.iter_mut().for_each(|class| class.profile = None);
        world
    }

    /// How many robots classes with a count have together.
    pub(super) fn counted_robots(&self) -> usize {
        self.classes.iter().filter_map(|class| class.count).fold(0, usize::saturating_add)
    }

    /// How many classes share the others.
    pub(super) fn n_sharing_classes(&self) -> usize {
        self.classes.iter().filter(|class| class.count.is_none()).count()
    }

    /// The class of each robot, by place; shape `[n_robots]`, or empty where there are no classes.
    ///
    /// Robots are dealt to the classes in turn, and a class that has all of its robots is passed over. The world was
    /// checked for as many robots ([`Self::check_classes_of`]).
    ///
    /// # Example
    ///
    /// ```
    /// use rsrs_core::world::{RobotClass, WorldFile};
    ///
    /// let class = |name: &str, count| RobotClass { name: name.to_owned(), count, ..RobotClass::default() };
    /// let classes = vec![class("shepherd", Some(1)), class("sheep", None)];
    /// let world = WorldFile { classes, ..WorldFile::NOTHING };
    /// assert_eq!(world.classes_of(4), [0, 1, 1, 1]);
    /// ```
    pub fn classes_of(&self, n_robots: usize) -> Vec<usize> {
        let mut left = self.class_sizes(n_robots);
        let mut classes = Vec::with_capacity(n_robots);
        while left.iter().any(|left| *left > 0) {
            for (class, left) in left.iter_mut().enumerate().filter(|(_, left)| **left > 0) {
                *left -= 1;
                classes.push(class);
            }
        }
        classes.truncate(n_robots);
        classes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn world(counts: &[Option<usize>]) -> WorldFile {
        let class = |count: &Option<usize>| RobotClass {
            name: "red".to_owned(),
            count: *count,
            ..RobotClass::default()
        };
        WorldFile { classes: counts.iter().map(class).collect(), ..WorldFile::NOTHING }
    }

    #[test]
    fn classes_without_a_count_share_the_robots_and_are_dealt_in_turn() {
        assert_eq!(world(&[None, None, None]).class_sizes(10), [4, 3, 3]);
        assert_eq!(world(&[None, None, None]).classes_of(10), [0, 1, 2, 0, 1, 2, 0, 1, 2, 0]);
        assert_eq!(world(&[Some(5), None, None]).classes_of(8), [0, 1, 2, 0, 1, 0, 0, 0]);
        assert_eq!(world(&[Some(1), Some(3)]).classes_of(4), [0, 1, 1, 1]);
        assert_eq!(world(&[]).classes_of(4), [0; 0]);
    }
}
