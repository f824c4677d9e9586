//! What is wrong with the files of an enclave, before the middleware gets them.

use std::collections::BTreeMap;
use std::fmt;
use std::io;
use std::path::{Path, PathBuf};
use std::time::Duration;

use crate::certificate::{self, CertificateFacts};
use crate::dates::{date, moment};
use crate::files::{self, mode_for_others};
use crate::governance::{Governance, Weakness};
use crate::layout::{
    CERTIFICATE, FILES, GOVERNANCE, IDENTITY_CA, KEY, PERMISSIONS, PERMISSIONS_CA,
};
use crate::permissions::Permissions;
use crate::signed_document::signed_text;

/// Something that is wrong with an enclave.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum EnclaveProblem {
    /// A file is not there or cannot be read.
    File {
        /// Which one.
        path: PathBuf,
        /// Why not.
        kind: io::ErrorKind,
    },
    /// A file does not contain what it should.
    Content {
        /// Its name.
        file: &'static str,
        /// What is wrong with it.
        reason: String,
    },
    /// A certificate or a grant does not hold now.
    Validity {
        /// The file.
        file: &'static str,
        /// From when to when it holds.
        holds: String,
    },
    /// Other users of this machine can read the private key.
    KeyIsReadable {
        /// The file.
        path: PathBuf,
        /// Its mode, as in `chmod`.
        mode: u32,
    },
    /// The governance is too weak, or the middleware cannot carry it.
    Governance(Weakness),
    /// The permissions are those of another certificate.
    NoGrant {
        /// Whom the certificate names.
        subject: String,
    },
    /// The permissions allow nothing in the domain.
    WrongDomain {
        /// The domain.
        domain_id: u16,
    },
}

impl fmt::Display for EnclaveProblem {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File { path, kind: io::ErrorKind::NotFound } => {
                write!(out, "{} is missing", path.display())
            }
            Self::File { path, kind: io::ErrorKind::InvalidInput } => {
                write!(out, "{} is not a regular file", path.display())
            }
            Self::File { path, kind } => write!(out, "{} cannot be read: {kind}", path.display()),
            Self::Content { file, reason } => write!(out, "{file}: {reason}"),
            Self::Validity { file, holds } => write!(out, "{file} {holds}"),
            Self::KeyIsReadable { path, mode } => write!(
                out,
                "{} is a private key, and its mode {mode:03o} lets others read it, expected 600",
                path.display()
            ),
            Self::Governance(weakness) => write!(out, "{GOVERNANCE} {weakness}"),
            Self::NoGrant { subject } => {
                write!(out, "{PERMISSIONS} has no grant for `{subject}`, whom {CERTIFICATE} names")
            }
            Self::WrongDomain { domain_id } => {
                write!(out, "{PERMISSIONS} allows nothing in domain {domain_id} (ROS_DOMAIN_ID)")
            }
        }
    }
}

impl EnclaveProblem {
    /// Whether the enclave can be used in spite of it.
    pub fn is_warning(&self) -> bool {
        matches!(self, Self::Governance(weakness) if weakness.is_of_members())
    }
}

/// Everything that is wrong with an enclave; it can be used if all of it is warnings.
///
/// Signatures of documents are left to the middleware, which verifies them when it starts.
///
/// # Arguments
///
/// * `folder` — of the enclave.
/// * `domain_id` — the domain that it is for.
/// * `now` — since 1970.
pub fn problems_of(folder: &Path, domain_id: u16, now: Duration) -> Vec<EnclaveProblem> {
    let mut problems = Vec::new();
    let mut texts = BTreeMap::new();
    for file in FILES {
        let path = folder.join(file);
        match files::text(&path) {
            Ok(text) => drop(texts.insert(file, text)),
            Err(error) => problems.push(EnclaveProblem::File { path, kind: error.kind() }),
        }
    }
    let mut subject = None;
    for file in [IDENTITY_CA, PERMISSIONS_CA, CERTIFICATE] {
        let Some(pem) = texts.get(file) else { continue };
        match certificate::read(pem) {
            Ok(facts) => {
                problems.extend(expired(file, &facts, now));
                subject = (file == CERTIFICATE).then_some(facts.subject);
            }
            Err(error) => {
                problems.push(EnclaveProblem::Content { file, reason: error.to_string() });
            }
        }
    }
    if texts.contains_key(KEY) {
        problems.extend(readable_by_others(&folder.join(KEY)));
    }
    problems.extend(strangers(&texts));
    if let Some(document) = texts.get(GOVERNANCE) {
        problems.extend(of_governance(document, domain_id));
    }
    if let (Some(document), Some(subject)) = (texts.get(PERMISSIONS), subject) {
        problems.extend(of_permissions(document, &subject, domain_id, now));
    }
    problems
}

/// How long before it ends a keystore is to be renewed.
pub const ENDS_SOON: Duration = Duration::from_secs(90 * 24 * 3600);

/// Since 1970: when an enclave that can be used now no longer can.
pub fn ends_at(folder: &Path) -> Option<Duration> {
    let text = |file| files::text(&folder.join(file)).ok();
    let ends = |file| certificate::read(&text(file)?).ok();
    let own = ends(CERTIFICATE)?;
    let permissions = Permissions::parse(signed_text(&text(PERMISSIONS)?).ok()?).ok()?;
    let granted = moment(&permissions.grant_of(&own.subject)?.validity.1)?;
    let of_authorities = ends(IDENTITY_CA)?.not_after.min(ends(PERMISSIONS_CA)?.not_after);
    Some(own.not_after.min(granted).min(of_authorities))
}

fn expired(file: &'static str, facts: &CertificateFacts, now: Duration) -> Option<EnclaveProblem> {
    if now < facts.not_before {
        let holds = format!("holds from {} only: is the clock right?", date(facts.not_before));
        return Some(EnclaveProblem::Validity { file, holds });
    }
    let holds = || format!("has expired at {}", date(facts.not_after));
    (now > facts.not_after).then(|| EnclaveProblem::Validity { file, holds: holds() })
}

/// Files that do not belong together: nobody would authenticate who has them.
fn strangers(texts: &BTreeMap<&'static str, String>) -> Vec<EnclaveProblem> {
    let asked = |check: fn(&str, &str) -> Option<bool>, other| {
        let is_its = check(texts.get(CERTIFICATE)?, texts.get(other)?)?;
        let reason = format!("it does not belong to {CERTIFICATE}");
        (!is_its).then_some(EnclaveProblem::Content { file: other, reason })
    };
    let key = asked(certificate::has_key, KEY);
    key.into_iter().chain(asked(certificate::is_signed_by, IDENTITY_CA)).collect()
}

fn readable_by_others(key: &Path) -> Option<EnclaveProblem> {
    let mode = mode_for_others(key).ok()??;
    Some(EnclaveProblem::KeyIsReadable { path: key.to_owned(), mode })
}

fn of_governance(document: &str, domain_id: u16) -> Vec<EnclaveProblem> {
    let governance = signed_text(document)
        .map_err(|error| error.to_string())
        .and_then(|xml| Governance::parse(xml).map_err(|error| error.to_string()));
    match governance {
        Ok(governance) => {
            let weaknesses = governance.weaknesses(domain_id).into_iter();
            weaknesses.map(EnclaveProblem::Governance).collect()
        }
        Err(reason) => vec![EnclaveProblem::Content { file: GOVERNANCE, reason }],
    }
}

fn of_permissions(
    document: &str,
    subject: &str,
    domain_id: u16,
    now: Duration,
) -> Option<EnclaveProblem> {
    let file = PERMISSIONS;
    let permissions = signed_text(document)
        .map_err(|error| error.to_string())
        .and_then(|xml| Permissions::parse(xml).map_err(|error| error.to_string()));
    let permissions = match permissions {
        Ok(permissions) => permissions,
        Err(reason) => return Some(EnclaveProblem::Content { file, reason }),
    };
    let Some(grant) = permissions.grant_of(subject) else {
        return Some(EnclaveProblem::NoGrant { subject: subject.to_owned() });
    };
    let (first, last) = &grant.validity;
    let (Some(not_before), Some(not_after)) = (moment(first), moment(last)) else {
        let reason = format!("validity from `{first}` to `{last}`, expected dates as in XML");
        return Some(EnclaveProblem::Content { file, reason });
    };
    let facts = CertificateFacts { subject: String::new(), not_before, not_after };
    let is_there = grant.domains.iter().any(|domains| domains.contain(domain_id));
    expired(file, &facts, now)
        .or_else(|| (!is_there).then_some(EnclaveProblem::WrongDomain { domain_id }))
}

#[cfg(test)]
mod tests {
    use std::os::unix::fs::PermissionsExt;

    use super::*;

    #[test]
    fn every_file_that_is_missing_is_named() {
        let folder = tempfile::tempdir().unwrap();

        let problems = problems_of(folder.path(), 0, Duration::ZERO);

        let texts: Vec<String> = problems.iter().map(ToString::to_string).collect();
        assert_eq!(texts.len(), FILES.len());
        for file in FILES {
            let expected = format!("{} is missing", folder.path().join(file).display());
            assert!(texts.contains(&expected), "{texts:?}");
        }
    }

    #[test]
    fn a_key_that_others_can_read_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let key = folder.path().join(KEY);
        std::fs::write(&key, "a key").unwrap();
        let with_mode = |mode| {
            std::fs::set_permissions(&key, std::fs::Permissions::from_mode(mode)).unwrap();
            readable_by_others(&key).map(|problem| problem.to_string())
        };

        assert_eq!(with_mode(0o600), None);
        assert_eq!(with_mode(0o400), None);
        assert!(with_mode(0o640).is_some_and(|text| text.contains("its mode 640 lets others")));
        assert!(with_mode(0o644).is_some());
    }

    #[test]
    fn what_does_not_hold_now_is_reported_with_the_date() {
        let seconds = Duration::from_secs;
        let facts = CertificateFacts {
            subject: "CN=/robot_3".to_owned(),
            not_before: seconds(1_767_268_800),
            not_after: seconds(1_767_268_900),
        };
        let problem = |now| expired(CERTIFICATE, &facts, seconds(now)).map(|it| it.to_string());

        assert_eq!(problem(1_767_268_850), None);
        let ended = problem(1_767_268_901);
        assert_eq!(ended.as_deref(), Some("cert.pem has expired at 2026-01-01T12:01:40Z"));
        let early = problem(0).unwrap();
        assert!(early.contains("holds from 2026-01-01T12:00:00Z only"), "{early}");
    }

    #[test]
    fn documents_that_are_none_are_named() {
        let unsigned = of_governance("<dds/>", 0);

        assert_eq!(unsigned.len(), 1);
        assert!(unsigned[0].to_string().starts_with("governance.p7s: it is no document"));
    }
}
