//! Robots that a sweep was not made from.

use serde::Serialize;

/// What to do where a sweep meets robots of another profile than its own.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum OtherProfile {
    /// They are refused: what was simulated are not these robots made worse.
    #[default]
    Refused,
    /// Somebody insists; the result states it.
    Insisted,
}

/// A sweep and robots of different profiles, by their digests.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, thiserror::Error)]
#[error("the sweep is of robots with profile {swept}, and these have profile {found}")]
pub struct ProfilesDiffer {
    /// Digest of the profile that was swept.
    pub swept: String,
    /// That of the robots.
    pub found: String,
}

/// Whether somebody insists.
impl From<bool> for OtherProfile {
    fn from(insists: bool) -> Self {
        if insists { Self::Insisted } else { Self::Refused }
    }
}

impl OtherProfile {
    /// Holds the profile of a sweep against that of robots. A difference is an error, unless
    /// somebody insists on it: then it is returned.
    pub fn admit(
        self,
        swept: &str,
        found: &str,
    ) -> Result<Option<ProfilesDiffer>, Box<ProfilesDiffer>> {
        if swept == found {
            return Ok(None);
        }
        let difference = ProfilesDiffer { swept: swept.to_owned(), found: found.to_owned() };
        match self {
            Self::Refused => Err(Box::new(difference)),
            Self::Insisted => Ok(Some(difference)),
        }
    }
}

impl ProfilesDiffer {
    /// What to do instead; `profile` is the path of the robots' profile, as a word of a command.
    pub fn help(profile: &str) -> String {
        format!(
            "sweep these robots: `rsrs sweep SWEEP.yaml -o NEW_DIR`, with `profile: {profile}` in \
             SWEEP.yaml; or insist with `--other-profile`"
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn robots_of_another_profile_are_refused_unless_somebody_insists() {
        let differ = ProfilesDiffer { swept: "1".to_owned(), found: "2".to_owned() };

        assert_eq!(OtherProfile::Refused.admit("1", "1"), Ok(None));
        assert_eq!(OtherProfile::Refused.admit("1", "2"), Err(Box::new(differ.clone())));
        assert_eq!(OtherProfile::Insisted.admit("1", "1"), Ok(None));
        assert_eq!(OtherProfile::Insisted.admit("1", "2"), Ok(Some(differ)));
    }
}
