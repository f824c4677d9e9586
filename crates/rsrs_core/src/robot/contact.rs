//! What happens when two bodies touch: a property of the robots, and no two kinds do the same.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

/// What a robot and its neighbour do when their bodies touch.
///
/// Walls are another matter: they are the arena's.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum ContactModel {
    /// A robot stops in place while another one is in front of it, and nobody can push it away: the paper's
    /// Flockbots.
    ///
    /// # Source
    ///
    /// §IV step 2: "the robots would stop in place if the other robot was in front and would be
    /// generally unaffected if it was pushed from another angle".
    #[default]
    Stop,
    /// Robots push each other, and their bodies do not overlap.
    Push,
    /// Robots pass through each other.
    None,
}

/// A word that names no contact.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{found}` is no contact, expected `stop`, `push` or `none`")]
pub struct UnknownContact {
    /// The word.
    pub found: String,
}

impl FromStr for ContactModel {
    type Err = UnknownContact;

    fn from_str(word: &str) -> Result<Self, UnknownContact> {
        let all = [Self::Stop, Self::Push, Self::None];
        let named = all.into_iter().find(|contact| contact.name() == word);
        named.ok_or_else(|| UnknownContact { found: word.to_owned() })
    }
}

impl ContactModel {
    /// Whether it is what a file means that does not name it.
    pub fn is_usual(&self) -> bool {
        *self == Self::default()
    }

    /// What files call it, and a command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Stop => "stop",
            Self::Push => "push",
            Self::None => "none",
        }
    }
}

impl fmt::Display for ContactModel {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::conditions::{Conditions, Settings};
    use crate::quantity::Axis;
    use crate::robot::profile::RobotProfile;

    use rsrs_testing::conditions::FLOCKBOT;

    fn parse(contact: &str) -> Result<RobotProfile, String> {
        let text = FLOCKBOT.replace("rotates_while_blocked: true", contact);
        RobotProfile::parse("robot.yaml", &text).map_err(|error| error.to_string())
    }

    fn conditions(profile: &RobotProfile) -> Conditions {
        let values = vec![(Axis::Speed, 0.15), (Axis::TurnRate, 0.75), (Axis::Robots, 9.0)];
        Conditions::resolve(profile, &Settings { values, ..Settings::default() }).unwrap()
    }

    #[test]
    fn a_profile_without_the_key_stops_and_keeps_its_digests() {
        let without = parse("rotates_while_blocked: true").unwrap();
        let stopping = parse("rotates_while_blocked: true, contact: stop").unwrap();

        assert_eq!(without, stopping);
        assert_eq!(without.digest(), "89be7a3fd895e8b8");
        assert_eq!(conditions(&without).digest(), 8_340_143_765_457_423_176);
    }

    #[test]
    fn another_contact_is_another_robot_and_another_world() {
        let contacts = ["stop", "push", "push, contact_friction: 0.2", "none"];
        let profiles = contacts.map(|contact| {
            parse(&format!("rotates_while_blocked: true, contact: {contact}")).unwrap()
        });

        for (index, profile) in profiles.iter().enumerate() {
            let conditions = conditions(profile);
            let text = serde_json::to_string(&conditions).unwrap();
            assert_eq!(serde_json::from_str::<Conditions>(&text).unwrap(), conditions);
            for other in &profiles[..index] {
                assert_ne!(profile.digest(), other.digest());
                assert_ne!(conditions.digest(), self::conditions(other).digest());
            }
        }
    }

    #[test]
    fn what_is_no_contact_is_refused_with_what_is_one() {
        let refusal = |contact: &str| {
            parse(&format!("rotates_while_blocked: true, {contact}")).expect_err("it is wrong")
        };

        let unknown = refusal("contact: shove");
        assert!(unknown.contains("shove") && unknown.contains("push"), "{unknown}");
        let of_nobody = refusal("contact_friction: 0.3");
        assert!(
            of_nobody.contains("body.contact_friction is 0.3, and body.contact is stop"),
            "{of_nobody}"
        );
        for friction in ["-0.1", "2.5", ".nan"] {
            let refused = refusal(&format!("contact: push, contact_friction: {friction}"));
            assert!(refused.contains("expected a coefficient from 0 to 2"), "{refused}");
        }
        let error = "shove".parse::<ContactModel>().unwrap_err().to_string();
        assert_eq!(error, "`shove` is no contact, expected `stop`, `push` or `none`");
    }
}
