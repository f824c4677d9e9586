//! Why a keystore is not made or changed.

use std::io;
use std::path::{Path, PathBuf};
use std::time::Duration;

use rsrs_core::help::Help;

use crate::dates::date;
use crate::governance::{Domains, GovernanceError};
use crate::signature::ForgedDocument;
use crate::signed_document::NotSigned;

/// Why a keystore is not made or changed.
#[derive(Debug, thiserror::Error)]
pub enum KeystoreError {
    /// A file or folder cannot be read, made or changed.
    #[error("cannot {doing} {}", path.display())]
    File {
        /// What was tried.
        doing: &'static str,
        /// With which one.
        path: PathBuf,
        /// Why not.
        #[source]
        source: io::Error,
    },
    /// The folder is used for something else.
    #[error("{} has files, and is no keystore", folder.display())]
    HasFiles {
        /// The folder.
        folder: PathBuf,
    },
    /// The folder lacks what signs.
    #[error("{} is no keystore: it has no private key of an authority", folder.display())]
    NoKeystore {
        /// The folder.
        folder: PathBuf,
    },
    /// An enclave that is elsewhere: it would be certified there, and gone in a keystore that is made anew.
    #[error("{} is a link, and an enclave is a folder of its own", path.display())]
    LinkedFolder {
        /// The link.
        path: PathBuf,
    },
    /// A robot that would have the rights of another member.
    #[error("robot `{robot}` has the name of another member, or of its topics or services")]
    RobotName {
        /// Its name.
        robot: String,
    },
    /// A certificate that is none.
    #[error("{} is no certificate: {reason}", path.display())]
    Certificate {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
    /// A key that is none. What is wrong with it is not printed, for that might be a part of it.
    #[error("{} is no key that this program signs with", path.display())]
    Key {
        /// The file.
        path: PathBuf,
    },
    /// A governance that was not signed.
    #[error("{}", path.display())]
    NotSigned {
        /// The file.
        path: PathBuf,
        /// What it is instead.
        #[source]
        source: NotSigned,
    },
    /// A governance that its authority has not signed.
    #[error("{} is not what the keystore's authority has signed", path.display())]
    Forged {
        /// The file.
        path: PathBuf,
        /// In which way.
        #[source]
        source: ForgedDocument,
    },
    /// The keystore is of another domain.
    #[error("the keystore holds in domain {}, and not in {asked}", listed(holds))]
    OtherDomain {
        /// The domain that was asked for.
        asked: u16,
        /// Those of its governance.
        holds: Vec<Domains>,
    },
    /// What would be signed would hold longer than the authority that signs it.
    #[error("the authority ends on {}, {}", date(*ends), match asked {
        Some(asked) => format!("before {}, until when certificates were to hold", date(*asked)),
        None => "and signs nothing any more".to_owned(),
    })]
    AuthorityEnds {
        /// Since 1970: when it ends.
        ends: Duration,
        /// Since 1970: until when certificates were to hold, if that was asked.
        asked: Option<Duration>,
    },
    /// There is no such enclave.
    #[error("the keystore has no enclave {name}{}", match meant {
        Some(meant) => format!("; did you mean {meant}?"),
        None => String::new(),
    })]
    NoEnclave {
        /// Its name, such as `/robot_3`.
        name: String,
        /// The one that was meant, as far as spelling shows it.
        meant: Option<String>,
    },
    /// An enclave that is gone already.
    #[error("{name} was revoked already")]
    Revoked {
        /// Its name, such as `/robot_3`.
        name: String,
    },
    /// An enclave that nobody has revoked.
    #[error("{name} was not revoked")]
    NotRevoked {
        /// Its name, such as `/robot_3`.
        name: String,
    },
    /// The keystore protects nothing, because it has no governance.
    #[error("the keystore has no governance: {} is missing", path.display())]
    NoGovernance {
        /// The file.
        path: PathBuf,
    },
    /// A governance that is none.
    #[error("{}", path.display())]
    Governance {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        #[source]
        source: GovernanceError,
    },
    /// Certificates cannot hold so long.
    #[error("no certificate holds from {from_s} to {to_s} seconds after 1970")]
    Validity {
        /// The beginning.
        from_s: u64,
        /// The end.
        to_s: u64,
    },
    /// A certificate or a signature cannot be made.
    #[error("cannot make {what}: {reason}")]
    Cryptography {
        /// A certificate, a key or a signature.
        what: &'static str,
        /// The library's error.
        reason: String,
    },
}

fn listed(domains: &[Domains]) -> String {
    domains.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ")
}

impl KeystoreError {
    pub(crate) fn file<'a>(
        doing: &'static str,
        path: &'a Path,
    ) -> impl FnOnce(io::Error) -> Self + 'a {
        move |source| Self::File { doing, path: path.to_owned(), source }
    }

    pub(crate) fn cryptography<E: ToString>(what: &'static str) -> impl Fn(E) -> Self {
        move |error| Self::Cryptography { what, reason: error.to_string() }
    }
}

impl Help for KeystoreError {
    fn help(&self) -> Option<String> {
        let help = match self {
            Self::HasFiles { .. } => {
                "name a folder that does not exist yet, or a keystore to complete"
            }
            Self::NoKeystore { .. } => {
                "this takes the keystore itself, and not the enclaves that were copied from it"
            }
            Self::Forged { .. } => {
                "somebody has changed it, or put another one in its place: look at it, and make a new \
                 keystore if nobody knows why"
            }
            Self::OtherDomain { .. } => {
                "leave `--domain` out, or make a keystore of its own for the other domain"
            }
            Self::AuthorityEnds { .. } => "`rsrs keystore renew` gives it more time",
            Self::NoEnclave { .. } => "`rsrs keystore show` lists those that it has",
            Self::Revoked { .. } => {
                "copy the other enclaves to their machines, if that was not done: those that are there \
                 still trust it"
            }
            Self::LinkedFolder { .. } => "move the folder itself there, or remove the link",
            Self::NotRevoked { .. } => "`rsrs keystore show` lists who was",
            Self::NoGovernance { .. } => {
                "`rsrs keystore create DIR --fleet FLEET.yaml --domain ID` makes another one for the \
                 domain of the fleet; then copy it into every enclave that was copied"
            }
            Self::RobotName { .. } => "give it another name in the fleet file",
            Self::Key { .. } => {
                "it takes keys as `ros2 security create_keystore` makes them: prime256v1 in PKCS #8, \
                 not encrypted"
            }
            _ => return None,
        };
        Some(help.to_owned())
    }
}
