//! Which sweep something follows from.

use super::SweepFile;
use crate::digest::Digest;
use crate::robot::profile::RobotProfile;

/// A choice that does not follow from the sweep beside which it lies.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum OtherSweep {
    /// It was made by a version that did not write it down.
    #[error("does not state from which sweep it was chosen, expected `sweep_digest: {expected}`")]
    Unnamed {
        /// Digest of the sweep.
        expected: String,
    },
    /// It names another one.
    #[error("was chosen from another sweep: sweep_digest is {found}, expected {expected}")]
    Other {
        /// Digest in the choice.
        found: String,
        /// Digest of the sweep.
        expected: String,
    },
}

impl SweepFile {
    /// Names the results of this sweep of the robot that `profile` names: 16 hexadecimal digits.
    ///
    /// Two sweeps with one digest have equal results; where their files lie does not count.
    pub fn digest(&self, measured: &RobotProfile) -> String {
        let anywhere = Self { profile: String::new(), ..self.clone() };
        let mut digest = Digest::new("sweep");
        digest.text(&serde_json::to_string(&anywhere).expect("a sweep is plain data"));
        digest.text(&measured.digest());
        format!("{:016x}", digest.value())
    }

    /// Refuses a choice that was made from another sweep, even if that has the same cells, or that
    /// does not say by a digest from which.
    pub fn check_choice(
        &self,
        measured: &RobotProfile,
        found: Option<&str>,
    ) -> Result<(), OtherSweep> {
        let expected = self.digest(measured);
        match found {
            Some(found) if found == expected => Ok(()),
            Some(found) => Err(OtherSweep::Other { found: found.to_owned(), expected }),
            None => Err(OtherSweep::Unnamed { expected }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    use rsrs_testing::conditions::FLOCKBOT;
    const SWEEP: &str =
        include_str!("../../../../../launch_configs/sweeps/flockbot_speed_turn.yaml");

    #[test]
    fn whatever_results_rest_on_makes_another_digest() {
        let profile = RobotProfile::parse("flockbot.yaml", FLOCKBOT).unwrap();
        let sweep = SweepFile::parse("sweep.yaml", SWEEP).unwrap();
        let expected = sweep.digest(&profile);
        let elsewhere = SweepFile { profile: "other/flockbot.yaml".to_owned(), ..sweep.clone() };
        assert_eq!(elsewhere.digest(&profile), expected);

        let seed = SweepFile { seed: sweep.seed + 1, ..sweep.clone() };
        let longer = SweepFile { duration_s: 2.0 * sweep.duration_s, ..sweep.clone() };
        let mut fixed = sweep.clone();
        fixed.fixed.values[0].1 += 1.0;
        let mut robot = profile.clone();
        robot.sensing.true_positive /= 2.0;
        for other in [seed, longer, fixed] {
            assert_ne!(other.digest(&profile), expected);
        }
        assert_ne!(sweep.digest(&robot), expected);
    }
}
