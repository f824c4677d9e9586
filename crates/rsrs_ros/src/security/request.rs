//! Whether a process is to be secured, as `ROS_SECURITY_*` and `--enclave` have it in ROS 2.

use std::path::{Path, PathBuf};
use std::time::Duration;

use rsrs_keystore::check::{ENDS_SOON, ends_at, problems_of};
use rsrs_keystore::layout::ENCLAVES;
use rsrs_keystore::problem::{EnclaveProblem, cures};
use rsrs_keystore::roles::{Kind, Role};
use rsrs_msgs::topics::is_token;

use super::{Enclave, IS_BUILT_IN, SecurityError};
use crate::environment::Environment;

/// What to do where there is no enclave.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Strategy {
    /// Not to start.
    Enforce,
    /// To run without protection.
    Permissive,
}

/// Whether a robot may have [`Strategy::Permissive`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PermissiveStrategy {
    /// It does not start then.
    #[default]
    Refused,
    /// A person wants it so.
    Allowed,
}

/// Who joins a fleet: what its enclave is called where nothing else is named.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Member<'a> {
    /// The gates and controllers of these robots, which move wheels.
    Robots(&'a [String], PermissiveStrategy),
    /// The simulator.
    Simulator,
    /// Who conducts runs and trials, and replays them.
    Runner,
    /// Who stops all robots.
    Stop,
    /// Who watches.
    Viewer,
}

impl Member<'_> {
    /// The enclave that `rsrs keystore create` makes for it.
    fn enclave(self) -> String {
        let kind = match self {
            Self::Robots([robot], _) => return Role::of_robot(robot).enclave(),
            Self::Robots(..) => Kind::Controllers,
            Self::Simulator => Kind::Simulator,
            Self::Runner => Kind::Runner,
            Self::Stop => Kind::Stop,
            Self::Viewer => Kind::Viewer,
        };
        Role::on_no_robot(kind).enclave()
    }
}

const DAY_S: u64 = 24 * 3600;

/// What environment and arguments want.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SecurityRequest {
    /// Folder of the keystore.
    pub keystore: PathBuf,
    /// What to do where there is no enclave.
    pub strategy: Strategy,
    /// The enclave that is named; `None` for that of the [`Member`].
    pub enclave: Option<String>,
}

impl SecurityRequest {
    /// Reads `--enclave` (`flag`), `ROS_SECURITY_ENABLE`, `ROS_SECURITY_KEYSTORE`,
    /// `ROS_SECURITY_STRATEGY` and `ROS_SECURITY_ENCLAVE_OVERRIDE`; `None` if protection is not
    /// asked for.
    ///
    /// # Errors
    ///
    /// ROS 2 takes every value of `ROS_SECURITY_ENABLE` but `true` for `false`; here a value that
    /// is neither is an error, because who wrote `True` wants to be protected.
    pub fn read(
        environment: &Environment,
        flag: Option<&str>,
    ) -> Result<Option<Self>, SecurityError> {
        if !Self::is_made(environment)? {
            return Ok(None);
        }
        let variable = |name| environment.variable(name).filter(|value| !value.is_empty());
        let strategy = match variable("ROS_SECURITY_STRATEGY") {
            None | Some("Permissive") => Strategy::Permissive,
            Some("Enforce") => Strategy::Enforce,
            Some(found) => return Err(SecurityError::Strategy { found: found.to_owned() }),
        };
        let keystore = variable("ROS_SECURITY_KEYSTORE").ok_or(SecurityError::NoKeystore)?;
        let enclave = variable("ROS_SECURITY_ENCLAVE_OVERRIDE").or(flag).map(str::to_owned);
        Ok(Some(Self { keystore: PathBuf::from(keystore), strategy, enclave }))
    }

    /// Whether protection is asked for.
    pub fn is_made(environment: &Environment) -> Result<bool, SecurityError> {
        match environment.variable("ROS_SECURITY_ENABLE").unwrap_or_default() {
            "" | "false" => Ok(false),
            "true" => Ok(true),
            found => Err(SecurityError::Enable { found: found.to_owned() }),
        }
    }

    /// The enclave of a process, after a look at its files; `None` if there is none and the
    /// strategy allows it. The time `now` is since 1970.
    ///
    /// If this program cannot be secured at all, that is an error as well.
    pub fn enclave(
        &self,
        member: Member<'_>,
        domain_id: u16,
        now: Duration,
    ) -> Result<Option<Enclave>, SecurityError> {
        if !IS_BUILT_IN {
            return Err(SecurityError::NotBuiltIn);
        }
        self.checked(member, domain_id, now)
    }

    fn checked(
        &self,
        member: Member<'_>,
        domain_id: u16,
        now: Duration,
    ) -> Result<Option<Enclave>, SecurityError> {
        let is_permissive = self.strategy == Strategy::Permissive;
        if is_permissive && matches!(member, Member::Robots(_, PermissiveStrategy::Refused)) {
            return Err(SecurityError::Permissive);
        }
        let name = self.enclave.clone().unwrap_or_else(|| member.enclave());
        let folder = folder_of(&self.keystore, &name)?;
        if !folder.is_dir() {
            let error = SecurityError::NoEnclave { name, folder };
            return if is_permissive { Ok(None) } else { Err(error) };
        }
        let problems = problems_of(&name, &folder, domain_id, now);
        if problems.iter().all(EnclaveProblem::is_warning) {
            for problem in problems {
                let cure = cures(&self.keystore, None, std::slice::from_ref(&problem)).join("; ");
                log::warn!("{problem}; {cure}, and copy the governance");
            }
            let left = ends_at(&folder).map(|ends| ends.saturating_sub(now));
            if let Some(left) = left.filter(|left| *left < ENDS_SOON) {
                log::warn!(
                    "{name} can take part for {} more days: `rsrs keystore renew KEYSTORE` where the keystore \
                     is, and copy the enclave again",
                    left.as_secs() / DAY_S
                );
            }
            Ok(Some(Enclave::new(name, folder)))
        } else {
            Err(SecurityError::Enclave { name, keystore: self.keystore.clone(), problems })
        }
    }
}

/// Names of enclaves are those of nodes: nothing outside the keystore can be named.
fn folder_of(keystore: &Path, name: &str) -> Result<PathBuf, SecurityError> {
    let relative =
        name.strip_prefix('/').filter(|rest| rest.is_empty() || rest.split('/').all(is_token));
    let relative = relative.ok_or_else(|| SecurityError::Name { found: name.to_owned() })?;
    Ok(keystore.join(ENCLAVES).join(relative))
}

#[cfg(test)]
mod tests {
    use std::io;

    use rsrs_core::help::Help;

    use super::*;

    fn read(
        variables: &[(&str, &str)],
        flag: Option<&str>,
    ) -> Result<Option<SecurityRequest>, SecurityError> {
        let no_file = |_: &Path| Err(io::ErrorKind::NotFound.into());
        SecurityRequest::read(&Environment::new(variables, no_file), flag)
    }

    const ENABLED: (&str, &str) = ("ROS_SECURITY_ENABLE", "true");
    const KEYSTORE: (&str, &str) = ("ROS_SECURITY_KEYSTORE", "keys");
    const ENFORCED: (&str, &str) = ("ROS_SECURITY_STRATEGY", "Enforce");

    fn robots() -> Vec<String> {
        vec!["robot_3".to_owned()]
    }

    #[test]
    fn variables_mean_what_they_mean_in_ros() {
        assert_eq!(read(&[KEYSTORE, ENFORCED], None), Ok(None));
        assert_eq!(read(&[("ROS_SECURITY_ENABLE", "false"), KEYSTORE], None), Ok(None));

        let request = read(&[ENABLED, KEYSTORE], None).unwrap().unwrap();
        assert_eq!((request.strategy, request.enclave), (Strategy::Permissive, None));
        let request = read(&[ENABLED, KEYSTORE, ENFORCED], Some("/a")).unwrap().unwrap();
        assert_eq!((request.strategy, request.enclave.as_deref()), (Strategy::Enforce, Some("/a")));
        let over = ("ROS_SECURITY_ENCLAVE_OVERRIDE", "/b");
        let request = read(&[ENABLED, KEYSTORE, ENFORCED, over], Some("/a")).unwrap().unwrap();
        assert_eq!(request.enclave.as_deref(), Some("/b"));
    }

    #[test]
    fn what_is_not_clear_is_an_error_and_never_plain() {
        let error = read(&[("ROS_SECURITY_ENABLE", "True"), KEYSTORE], None).unwrap_err();
        assert_eq!(error.to_string(), "ROS_SECURITY_ENABLE is `True`, expected true or false");
        assert!(error.help().is_some_and(|help| help.starts_with("set it to `true`")));
        assert_eq!(read(&[ENABLED], None), Err(SecurityError::NoKeystore));
        let strategy = ("ROS_SECURITY_STRATEGY", "enforce");
        let error = read(&[ENABLED, KEYSTORE, strategy], None).unwrap_err();
        assert!(matches!(error, SecurityError::Strategy { .. }), "{error}");
    }

    #[test]
    fn without_the_feature_nothing_runs_that_was_to_be_secured() {
        let request = read(&[ENABLED, KEYSTORE], None).unwrap().unwrap();

        let enclave = request.enclave(Member::Runner, 0, Duration::ZERO);

        // The keystore does not exist, and the strategy is permissive.
        let expected = if IS_BUILT_IN { Ok(None) } else { Err(SecurityError::NotBuiltIn) };
        assert_eq!(enclave, expected);
    }

    #[test]
    fn a_robot_is_not_permissive_unless_a_person_asks_for_it() {
        let request = read(&[ENABLED, KEYSTORE], None).unwrap().unwrap();
        let robots = robots();
        let checked =
            |allowed| request.checked(Member::Robots(&robots, allowed), 0, Duration::ZERO);

        let error = checked(PermissiveStrategy::Refused).unwrap_err();

        assert_eq!(error, SecurityError::Permissive);
        assert!(error.help().is_some_and(|help| help.contains("--permissive-security")));
        assert_eq!(checked(PermissiveStrategy::Allowed), Ok(None));
    }

    #[test]
    fn an_enclave_that_is_missing_or_incomplete_is_named_with_what_it_lacks() {
        let keystore = tempfile::tempdir().unwrap();
        let path = keystore.path().to_str().unwrap();
        let variables = [ENABLED, ("ROS_SECURITY_KEYSTORE", path), ENFORCED];
        let request = read(&variables, None).unwrap().unwrap();
        let robots = robots();
        let member = Member::Robots(&robots, PermissiveStrategy::Refused);
        let checked = || request.checked(member, 0, Duration::ZERO).unwrap_err();

        let missing = checked();
        std::fs::create_dir_all(keystore.path().join("enclaves/robot_3")).unwrap();
        let incomplete = checked();

        assert!(matches!(&missing, SecurityError::NoEnclave { name, .. } if name == "/robot_3"));
        assert!(incomplete.to_string().contains("enclaves/robot_3/key.pem is missing"));
        assert!(incomplete.help().is_some_and(|help| help.contains("cp -rL")));
    }

    #[test]
    fn members_have_the_enclaves_that_are_made_for_them() {
        let refused = PermissiveStrategy::Refused;
        let several = ["robot_1".to_owned(), "robot_2".to_owned()];

        assert_eq!(Member::Robots(&robots(), refused).enclave(), "/robot_3");
        assert_eq!(Member::Robots(&several, refused).enclave(), "/controllers");
        assert_eq!(Member::Stop.enclave(), "/stop");
    }

    #[test]
    fn no_name_leads_out_of_the_keystore() {
        let keystore = Path::new("keys");
        for name in ["robot_3", "/../../x", "/a//b", "/a b", "", "/a/.."] {
            assert!(matches!(folder_of(keystore, name), Err(SecurityError::Name { .. })), "{name}");
        }
        assert_eq!(
            folder_of(keystore, "/lab/robot_3").unwrap(),
            keystore.join("enclaves/lab/robot_3")
        );
    }
}
