//! Why a process that was to be secured does not start.

use std::path::PathBuf;

use rsrs_core::help::Help;
use rsrs_keystore::check::EnclaveProblem;
use rsrs_keystore::governance::Weakness;
use rsrs_keystore::layout::KEY;

/// Why a process that was to be secured does not start.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SecurityError {
    /// A value of `ROS_SECURITY_ENABLE` of which it is not clear what it means.
    #[error("ROS_SECURITY_ENABLE is `{found}`, expected true or false")]
    Enable {
        /// Its value.
        found: String,
    },
    /// A value of `ROS_SECURITY_STRATEGY` that ROS 2 does not have.
    #[error("ROS_SECURITY_STRATEGY is `{found}`, expected Enforce or Permissive")]
    Strategy {
        /// Its value.
        found: String,
    },
    /// This program cannot take part in a secured fleet.
    #[error("ROS_SECURITY_ENABLE is true, and this program was built without DDS Security")]
    NotBuiltIn,
    /// No keystore is named.
    #[error("ROS_SECURITY_ENABLE is true, and ROS_SECURITY_KEYSTORE names no keystore")]
    NoKeystore,
    /// A robot that would run plain if its enclave were missing.
    #[error(
        "ROS_SECURITY_STRATEGY is not Enforce: where the enclave of a robot is missing, it would \
         obey everybody on the network"
    )]
    Permissive,
    /// A name of an enclave that ROS 2 does not allow.
    #[error("enclave `{found}`, expected an absolute name such as /robot_3")]
    Name {
        /// The name.
        found: String,
    },
    /// The keystore has no such enclave.
    #[error("the keystore has no enclave `{name}`: {} is missing", folder.display())]
    NoEnclave {
        /// Its name.
        name: String,
        /// Where it should be.
        folder: PathBuf,
    },
    /// The enclave cannot be used.
    #[error("enclave `{name}` cannot be used: {}", listed(problems))]
    Enclave {
        /// Its name.
        name: String,
        /// Everything that is wrong with it.
        problems: Vec<EnclaveProblem>,
    },
}

fn listed(problems: &[EnclaveProblem]) -> String {
    let texts: Vec<String> = problems.iter().map(ToString::to_string).collect();
    texts.join("; ")
}

/// The cure for a governance that is too weak or not carried, and for keys that others can read.
const HARDEN: &str = "`rsrs keystore harden DIR` on the machine that has the keystore writes and \
                      signs another governance and makes keys private; then copy the enclave again";

impl Help for SecurityError {
    fn help(&self) -> Option<String> {
        let help = match self {
            Self::Enable { .. } => "unset it to run without protection",
            Self::NotBuiltIn => {
                "use the Debian package, or build with `cargo build --features security` \
                 (`security_vendored` brings its own OpenSSL); unset ROS_SECURITY_ENABLE to run \
                 without protection"
            }
            Self::NoKeystore => "make one with `rsrs keystore create DIR --fleet FLEET.yaml`",
            Self::Permissive => {
                "set ROS_SECURITY_STRATEGY=Enforce, or start it with `--permissive-security`"
            }
            Self::NoEnclave { .. } => {
                "name one of the keystore's with `--ros-args --enclave NAME` or \
                 ROS_SECURITY_ENCLAVE_OVERRIDE"
            }
            Self::Enclave { problems, .. } => return help_of(problems),
            Self::Strategy { .. } | Self::Name { .. } => return None,
        };
        Some(help.to_owned())
    }
}

/// The cure for a keystore of another domain.
const ANOTHER_DOMAIN: &str = "a keystore holds in the domain that it was made for: set ROS_DOMAIN_ID \
                              to it, or make one with `rsrs keystore create DIR --fleet FLEET.yaml \
                              --domain ID`";

fn help_of(problems: &[EnclaveProblem]) -> Option<String> {
    let is_elsewhere = |problem: &EnclaveProblem| {
        matches!(
            problem,
            EnclaveProblem::Governance(Weakness::NoRule { .. })
                | EnclaveProblem::WrongDomain { .. }
        )
    };
    let is_hardened_away = |problem: &EnclaveProblem| {
        matches!(problem, EnclaveProblem::Governance(_) | EnclaveProblem::KeyIsReadable { .. })
    };
    if problems.iter().any(is_elsewhere) {
        return Some(ANOTHER_DOMAIN.to_owned());
    }
    if problems.iter().any(is_hardened_away) {
        return Some(HARDEN.to_owned());
    }
    let is_missing = problems
        .iter()
        .any(|it| matches!(it, EnclaveProblem::File { .. } | EnclaveProblem::Content { .. }));
    let copy = format!(
        "copy the whole folder of the enclave from the keystore, with what its links lead to \
         (`cp -rL`), and keep {KEY} readable for the user of this program alone"
    );
    is_missing.then_some(copy)
}
