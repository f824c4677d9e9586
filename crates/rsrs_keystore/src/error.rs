//! Why a keystore is not made or changed.

use std::error::Error;
use std::fmt;
use std::io;
use std::path::{Path, PathBuf};
use std::time::Duration;

use rsrs_core::help::Help;
use rsrs_files::quoted;

use crate::dates::date;
use crate::governance::{Domains, GovernanceError};
use crate::layout::{KEY, PUBLIC, UNFINISHED};
use crate::problem::{EnclaveProblem, cures};
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
    /// What is private is on a disk that is not there.
    #[error("{} leads to {}, which is not there", path.display(), target.display())]
    PrivateElsewhere {
        /// The link.
        path: PathBuf,
        /// Where it leads.
        target: PathBuf,
    },
    /// Members of which something is missing or was changed, from which others would be made.
    #[error("{}", of_members(members))]
    Damaged {
        /// Their enclaves, and what is wrong.
        members: Vec<(String, Vec<EnclaveProblem>)>,
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
    /// A file that is not the certificate of the authority.
    #[error("{} is not the authority's certificate: {reason}", path.display())]
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
    #[error("the keystore has no enclave {name}{}", suggestion(meant.as_deref()))]
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
    #[error("{name} was not revoked{}", suggestion(meant.as_deref()))]
    NotRevoked {
        /// Its name, such as `/robot_3`.
        name: String,
        /// The one that was meant, as far as spelling shows it.
        meant: Option<String>,
    },
    /// An enclave that nobody asks for but to readmit it.
    #[error("{name} cannot be readmitted: it is not in the fleet file")]
    NotInFleet {
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

fn suggestion(meant: Option<&str>) -> String {
    meant.map_or_else(String::new, |meant| format!("; did you mean {meant}?"))
}

fn of_members(members: &[(String, Vec<EnclaveProblem>)]) -> String {
    let text = |(enclave, problems): &(String, Vec<EnclaveProblem>)| {
        let problems: Vec<String> = problems.iter().map(ToString::to_string).collect();
        format!("{enclave}: {}", problems.join(", "))
    };
    members.iter().map(text).collect::<Vec<_>>().join("; ")
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

impl KeystoreError {
    /// The error of a command on a keystore, with what to type there.
    pub fn of(self, keystore: &Path) -> KeystoreFailure {
        KeystoreFailure { keystore: keystore.to_owned(), error: self }
    }

    /// What to do about it in this keystore.
    fn help(&self, keystore: &Path) -> Option<String> {
        let folder = quoted(keystore);
        Some(match self {
            Self::HasFiles { .. } => {
                "name a folder that does not exist yet, or a keystore to complete".to_owned()
            }
            Self::NoKeystore { folder } => no_keystore(folder),
            Self::PrivateElsewhere { .. } => "plug the disk in, or mend the link".to_owned(),
            Self::Damaged { members } => {
                let problems: Vec<_> =
                    members.iter().flat_map(|(_, problems)| problems.clone()).collect();
                let cures = cures(keystore, None, &problems).join("`, `");
                format!("`{cures}`, then the same command again")
            }
            Self::Forged { .. } => "somebody has changed it, or put another one in its place: look at it, \
                                    and make a new keystore if nobody knows why"
                .to_owned(),
            Self::OtherDomain { .. } => {
                "leave `--domain` out, or make a keystore of its own for the other domain".to_owned()
            }
            Self::AuthorityEnds { .. } => format!("`rsrs keystore renew {folder}` gives it more time"),
            Self::NoEnclave { .. } => format!("`rsrs keystore show {folder}` lists those that it has"),
            Self::Revoked { .. } => "copy the other enclaves to their machines, if that was not done: those \
                                     that are there still trust it"
                .to_owned(),
            Self::LinkedFolder { .. } => {
                "move the folder itself there, or remove the link".to_owned()
            }
            Self::NotRevoked { .. } => format!("`rsrs keystore show {folder}` lists who was"),
            Self::NotInFleet { .. } => "add it to the fleet file, or leave `--readmit` out".to_owned(),
            Self::NoGovernance { .. } => format!(
                "`rsrs keystore create {folder} --fleet FLEET.yaml --domain ID` makes another one for the \
                 domain of the fleet; then copy it into every enclave that was copied"
            ),
            Self::RobotName { .. } => "give it another name in the fleet file".to_owned(),
            Self::Key { path } if path.ends_with(KEY) => format!(
                "`rm {}`, and `rsrs keystore create {folder} --fleet FLEET.yaml` makes another one",
                quoted(path)
            ),
            Self::Key { .. } => "it takes keys as `ros2 security create_keystore` makes them: prime256v1 in \
                                 PKCS #8, not encrypted"
                .to_owned(),
            Self::File { path, .. } | Self::Certificate { path, .. }
                if path.starts_with(keystore.join(PUBLIC)) =>
            {
                "it is the authority's certificate, and every enclave that was copied has it under the same \
                 name: copy it from there"
                    .to_owned()
            }
            Self::File { doing: "write" | "link" | "make", .. } => {
                "when that is mended, the same command again finishes what this one began".to_owned()
            }
            _ => return None,
        })
    }
}

fn no_keystore(folder: &Path) -> String {
    let old = {
        let mut old = folder.as_os_str().to_owned();
        old.push(".old");
        PathBuf::from(old)
    };
    if folder.join(UNFINISHED).exists() {
        return "`rsrs keystore create` was interrupted there: type it again".to_owned();
    }
    if !folder.exists() && old.exists() {
        return format!(
            "`mv {} {}` puts the old one back, from before a revocation that was interrupted",
            quoted(old),
            quoted(folder)
        );
    }
    "this takes the keystore itself, and not the enclaves that were copied from it".to_owned()
}

/// An error of a command on a keystore.
#[derive(Debug)]
pub struct KeystoreFailure {
    keystore: PathBuf,
    error: KeystoreError,
}

impl fmt::Display for KeystoreFailure {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.error.fmt(out)
    }
}

impl Error for KeystoreFailure {
    fn source(&self) -> Option<&(dyn Error + 'static)> {
        self.error.source()
    }
}

impl Help for KeystoreFailure {
    fn help(&self) -> Option<String> {
        self.error.help(&self.keystore)
    }
}
