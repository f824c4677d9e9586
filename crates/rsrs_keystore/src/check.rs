//! What is wrong with the files of an enclave: the same for a program that starts, for who looks at a
//! keystore, and before one is changed.

use std::collections::BTreeMap;
use std::path::Path;
use std::time::Duration;

use crate::certificate;
use crate::dates::moment;
use crate::files::{self, mode_for_others};
use crate::governance::Governance;
use crate::layout::{
    CERTIFICATE, FILES, GOVERNANCE, IDENTITY_CA, KEY, PERMISSIONS, PERMISSIONS_CA, SHARED,
};
use crate::permissions::Permissions;
use crate::problem::EnclaveProblem;
use crate::signed_document::signed_text;

type Texts = BTreeMap<&'static str, String>;

/// Everything that is wrong with an enclave (such as `/robot_3`) and its folder, for a domain; it
/// can be used if all of it is warnings. The time `now` is since 1970.
pub fn problems_of(
    name: &str,
    folder: &Path,
    domain_id: u16,
    now: Duration,
) -> Vec<EnclaveProblem> {
    let (texts, mut problems) = read(folder);
    problems.extend(problems_in(name, folder, &texts, domain_id, now));
    problems
}

/// As [`problems_of`], of an enclave in its keystore: it has to have what the keystore has for all.
pub(crate) fn problems_of_member(
    keystore: &Path,
    (name, folder): (&str, &Path),
    domain_id: u16,
    now: Duration,
) -> Vec<EnclaveProblem> {
    let (mut texts, mut problems) = read(folder);
    for file in SHARED {
        let Ok(shared) = files::text(&files::shared(keystore, file)) else { continue };
        if let Some(own) = texts.insert(file, shared.clone())
            && own != shared
        {
            let reason = "it is not that of the keystore".to_owned();
            problems.push(EnclaveProblem::Content { file, path: folder.join(file), reason });
        }
    }
    problems.extend(problems_in(name, folder, &texts, domain_id, now));
    problems
}

fn read(folder: &Path) -> (Texts, Vec<EnclaveProblem>) {
    let (mut texts, mut problems) = (Texts::new(), Vec::new());
    for file in FILES {
        let path = folder.join(file);
        match files::text(&path) {
            Ok(text) => drop(texts.insert(file, text)),
            Err(error) => problems.push(EnclaveProblem::File { file, path, kind: error.kind() }),
        }
    }
    (texts, problems)
}

/// What is wrong with texts, those of files that could be read.
fn problems_in(
    name: &str,
    folder: &Path,
    texts: &Texts,
    domain_id: u16,
    now: Duration,
) -> Vec<EnclaveProblem> {
    let mut problems = Vec::new();
    let content = |(file, reason): (&'static str, String)| EnclaveProblem::Content {
        file,
        path: folder.join(file),
        reason,
    };
    let own = format!("CN={name}");
    let mut subject = own.clone();
    for file in [IDENTITY_CA, PERMISSIONS_CA, CERTIFICATE] {
        let Some(pem) = texts.get(file) else { continue };
        match certificate::read(pem) {
            Ok(facts) => {
                problems.extend(out_of_time(file, (facts.not_before, facts.not_after), now));
                if file == CERTIFICATE && facts.subject != own {
                    // A lab's own authority may name its members as it likes.
                    if facts.subject.starts_with("CN=/") {
                        problems.push(EnclaveProblem::OtherMember { subject: facts.subject });
                    } else {
                        subject = facts.subject;
                    }
                }
            }
            Err(error) => problems.push(content((file, error.to_string()))),
        }
    }
    if texts.contains_key(KEY) {
        problems.extend(readable_by_others(&folder.join(KEY)));
    }
    problems.extend(mismatches(texts).into_iter().map(content));
    if let Some(document) = texts.get(GOVERNANCE) {
        match governance(document) {
            Ok(governance) => {
                let weaknesses = governance.weaknesses(domain_id).into_iter();
                problems.extend(weaknesses.map(EnclaveProblem::Governance));
            }
            Err(reason) => problems.push(content((GOVERNANCE, reason))),
        }
    }
    if let Some(document) = texts.get(PERMISSIONS) {
        let found = permissions(document)
            .and_then(|permissions| of_permissions(&permissions, &subject, domain_id, now));
        match found {
            Ok(problem) => problems.extend(problem),
            Err(reason) => problems.push(content((PERMISSIONS, reason))),
        }
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

fn out_of_time(
    file: &'static str,
    (begins, ended): (Duration, Duration),
    now: Duration,
) -> Option<EnclaveProblem> {
    if now < begins {
        return Some(EnclaveProblem::NotYet { file, begins });
    }
    (now > ended).then_some(EnclaveProblem::Ended { file, ended })
}

/// Files that do not belong together: nobody would authenticate who has them, or let them in.
fn mismatches(texts: &Texts) -> Vec<(&'static str, String)> {
    let mut found = Vec::new();
    let both = |one, other| texts.get(one).zip(texts.get(other));
    if texts.get(KEY).is_some_and(|key| !certificate::is_key(key)) {
        found.push((KEY, "it is no private key".to_owned()));
    } else if let Some((certificate, key)) = both(CERTIFICATE, KEY)
        && certificate::has_key(certificate, key) == Some(false)
    {
        found.push((CERTIFICATE, format!("it does not belong to {KEY}")));
    }
    if let Some((certificate, authority)) = both(CERTIFICATE, IDENTITY_CA)
        && certificate::is_signed_by(certificate, authority) == Some(false)
    {
        found.push((CERTIFICATE, format!("{IDENTITY_CA} has not signed it")));
    }
    for file in [GOVERNANCE, PERMISSIONS] {
        // What is no signed document at all is reported where its text is read.
        if let Some((document, authority)) = both(file, PERMISSIONS_CA)
            && signed_text(document).is_ok()
            && let Some(forgery) = certificate::forgery_of(document, authority)
        {
            found.push((file, format!("it is not what {PERMISSIONS_CA} has signed: {forgery}")));
        }
    }
    found
}

fn readable_by_others(key: &Path) -> Option<EnclaveProblem> {
    let mode = mode_for_others(key).ok()??;
    Some(EnclaveProblem::KeyIsReadable { path: key.to_owned(), mode })
}

fn governance(document: &str) -> Result<Governance, String> {
    let xml = signed_text(document).map_err(|error| error.to_string())?;
    Governance::parse(xml).map_err(|error| error.to_string())
}

fn permissions(document: &str) -> Result<Permissions, String> {
    let xml = signed_text(document).map_err(|error| error.to_string())?;
    Permissions::parse(xml).map_err(|error| error.to_string())
}

fn of_permissions(
    permissions: &Permissions,
    subject: &str,
    domain_id: u16,
    now: Duration,
) -> Result<Option<EnclaveProblem>, String> {
    let Some(grant) = permissions.grant_of(subject) else {
        return Ok(Some(EnclaveProblem::NoGrant { subject: subject.to_owned() }));
    };
    let (first, last) = &grant.validity;
    let holds = moment(first)
        .zip(moment(last))
        .ok_or_else(|| format!("validity from `{first}` to `{last}`, expected dates as in XML"))?;
    let is_there = grant.domains.iter().any(|domains| domains.contain(domain_id));
    Ok(out_of_time(PERMISSIONS, holds, now)
        .or_else(|| (!is_there).then_some(EnclaveProblem::WrongDomain { domain_id })))
}

#[cfg(test)]
mod tests {
    use std::os::unix::fs::PermissionsExt;

    use super::*;

    #[test]
    fn every_file_that_is_missing_is_named() {
        let folder = tempfile::tempdir().unwrap();

        let problems = problems_of("/robot_3", folder.path(), 0, Duration::ZERO);

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
        let holds = (seconds(1_767_268_800), seconds(1_767_268_900));
        let problem = |now| out_of_time(CERTIFICATE, holds, seconds(now)).map(|it| it.to_string());

        assert_eq!(problem(1_767_268_850), None);
        let ended = problem(1_767_268_901);
        assert_eq!(ended.as_deref(), Some("cert.pem has expired at 2026-01-01T12:01:40Z"));
        let early = problem(0).unwrap();
        assert!(early.contains("holds from 2026-01-01T12:00:00Z only"), "{early}");
    }

    #[test]
    fn documents_that_are_none_are_named() {
        let unsigned = governance("<dds/>").unwrap_err();

        assert!(unsigned.starts_with("it is no document"), "{unsigned}");
    }
}
