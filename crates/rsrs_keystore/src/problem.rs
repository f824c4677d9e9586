//! What can be wrong with an enclave, and what mends it.

use std::collections::BTreeSet;
use std::io;
use std::path::{Path, PathBuf};
use std::time::Duration;

use rsrs_files::quoted;

use crate::dates::date;
use crate::governance::Weakness;
use crate::layout::{CERTIFICATE, GOVERNANCE, KEY, PERMISSIONS, PRIVATE, SHARED};

/// Something that is wrong with an enclave.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum EnclaveProblem {
    /// A file is not there or cannot be read.
    #[error("{} {}", path.display(), not_read(*kind))]
    File {
        /// Its name.
        file: &'static str,
        /// Where it should be.
        path: PathBuf,
        /// Why not.
        kind: io::ErrorKind,
    },
    /// A file does not contain what it should.
    #[error("{file}: {reason}")]
    Content {
        /// Its name.
        file: &'static str,
        /// Where it is.
        path: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
    /// A certificate or a grant does not hold yet.
    #[error("{file} holds from {} only: is the clock right?", date(*begins))]
    NotYet {
        /// The file.
        file: &'static str,
        /// Since 1970: when it begins.
        begins: Duration,
    },
    /// A certificate or a grant does not hold any more.
    #[error("{file} has expired at {}", date(*ended))]
    Ended {
        /// The file.
        file: &'static str,
        /// Since 1970: when it ended.
        ended: Duration,
    },
    /// Other users of this machine can read the private key.
    #[error(
        "{} is a private key, and its mode {mode:03o} lets others read it, expected 600",
        path.display()
    )]
    KeyIsReadable {
        /// The file.
        path: PathBuf,
        /// Its mode, as in `chmod`.
        mode: u32,
    },
    /// The governance is too weak, or the middleware cannot carry it.
    #[error("{GOVERNANCE} {0}")]
    Governance(Weakness),
    /// The certificate is that of another member.
    #[error("{CERTIFICATE} is that of another member, `{subject}`")]
    OtherMember {
        /// Whom it names.
        subject: String,
    },
    /// The permissions are those of another certificate.
    #[error("{PERMISSIONS} has no grant for `{subject}`, so it is of another member")]
    NoGrant {
        /// Whom the certificate names.
        subject: String,
    },
    /// The permissions allow nothing in the domain.
    #[error("{PERMISSIONS} allows nothing in domain {domain_id} (ROS_DOMAIN_ID)")]
    WrongDomain {
        /// The domain.
        domain_id: u16,
    },
}

/// Why there is no text of a file.
fn not_read(kind: io::ErrorKind) -> String {
    match kind {
        io::ErrorKind::NotFound => "is missing".to_owned(),
        io::ErrorKind::InvalidInput => "is not a regular file".to_owned(),
        io::ErrorKind::InvalidData => "is no text".to_owned(),
        kind => format!("cannot be read: {kind}"),
    }
}

/// What mends a problem.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Cure {
    /// What is missing in the enclave is made.
    Create,
    /// Its key is made anew, which is never written over.
    NewKey(PathBuf),
    /// Nobody else can read its key any more.
    Private(PathBuf),
    /// What all enclaves share is put right.
    Harden,
    /// More time.
    Renew,
    /// The clock of this machine.
    Clock,
    /// The domain of the keystore.
    Domain,
}

impl EnclaveProblem {
    /// Whether the enclave can be used in spite of it.
    pub fn is_warning(&self) -> bool {
        matches!(self, Self::Governance(weakness) if weakness.is_of_members())
    }

    /// Which file it is about.
    pub(crate) fn file(&self) -> &'static str {
        match self {
            Self::File { file, .. }
            | Self::Content { file, .. }
            | Self::NotYet { file, .. }
            | Self::Ended { file, .. } => file,
            Self::KeyIsReadable { .. } => KEY,
            Self::Governance(_) => GOVERNANCE,
            Self::OtherMember { .. } => CERTIFICATE,
            Self::NoGrant { .. } | Self::WrongDomain { .. } => PERMISSIONS,
        }
    }

    /// Whether a file is not what it should be, whatever the time, the domain and other users are.
    pub(crate) fn is_damage(&self) -> bool {
        matches!(
            self,
            Self::File { .. }
                | Self::Content { .. }
                | Self::OtherMember { .. }
                | Self::NoGrant { .. }
        )
    }

    fn cure(&self) -> Cure {
        match self {
            Self::NotYet { .. } => Cure::Clock,
            Self::Ended { .. } => Cure::Renew,
            Self::Governance(Weakness::NoRule { .. }) | Self::WrongDomain { .. } => Cure::Domain,
            Self::Governance(_) => Cure::Harden,
            Self::KeyIsReadable { path, .. } => Cure::Private(path.clone()),
            Self::Content { file: KEY, path, .. } => Cure::NewKey(path.clone()),
            of_file if SHARED.contains(&of_file.file()) => Cure::Harden,
            _ => Cure::Create,
        }
    }
}

/// What mends these problems, each once: what to type where the keystore is (with its fleet file,
/// where that is known), and what to copy where only a part of it is.
pub fn cures(keystore: &Path, fleet: Option<&Path>, problems: &[EnclaveProblem]) -> Vec<String> {
    let is_here = keystore.join(PRIVATE).symlink_metadata().is_ok();
    let folder = if is_here { quoted(keystore) } else { "KEYSTORE".to_owned() };
    let fleet = fleet.map_or_else(|| "FLEET.yaml".to_owned(), quoted);
    let create = format!("rsrs keystore create {folder} --fleet {fleet}");
    let there = |command: String| {
        if is_here {
            command
        } else {
            format!("`{command}` on the machine that has the keystore, and copy the enclave again")
        }
    };
    let text = |cure: Cure| {
        match cure {
        Cure::Create | Cure::NewKey(_) if !is_here => format!(
            "copy the whole folder of the enclave from the keystore, with what its links lead to \
             (`cp -rL`), and keep {KEY} readable for the user of this program alone"
        ),
        Cure::Create => create.clone(),
        Cure::NewKey(path) => format!("rm {} && {create}", quoted(path)),
        Cure::Private(path) => format!("chmod 600 {}", quoted(path)),
        Cure::Harden => there(format!("rsrs keystore harden {folder}")),
        Cure::Renew => there(format!("rsrs keystore renew {folder}")),
        Cure::Clock => "timedatectl   # is the clock of this machine right?".to_owned(),
        Cure::Domain => "a keystore holds in the domain that it was made for: set ROS_DOMAIN_ID to it, or \
                         make another one with `rsrs keystore create OTHER --fleet FLEET.yaml --domain ID`"
            .to_owned(),
    }
    };
    let cures: BTreeSet<Cure> = problems.iter().map(EnclaveProblem::cure).collect();
    let mut texts: Vec<String> = cures.into_iter().map(text).collect();
    texts.dedup();
    texts
}
