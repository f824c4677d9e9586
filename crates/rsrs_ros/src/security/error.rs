//! Why a process that was to be secured does not start.

use std::path::PathBuf;

use rsrs_core::help::Help;
use rsrs_keystore::problem::{EnclaveProblem, cures};

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
        /// The keystore, or the part of it that was copied.
        keystore: PathBuf,
        /// Everything that is wrong with it.
        problems: Vec<EnclaveProblem>,
    },
}

fn listed(problems: &[EnclaveProblem]) -> String {
    let texts: Vec<String> = problems.iter().map(ToString::to_string).collect();
    texts.join("; ")
}

impl Help for SecurityError {
    fn help(&self) -> Option<String> {
        let help = match self {
            Self::Enable { .. } => "set it to `true`; `false`, or none, is without protection",
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
            Self::Enclave { keystore, problems, .. } => {
                let cures = cures(keystore, None, problems);
                return (!cures.is_empty()).then(|| cures.join("; "));
            }
            Self::Strategy { .. } | Self::Name { .. } => return None,
        };
        Some(help.to_owned())
    }
}
