//! The members of a keystore that is there: until when they hold, more time for all, and one fewer.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::Duration;

use rsrs_core::document::nearest;
use tempfile::TempDir;

use crate::authority::{self, Authority};
use crate::check::{ends_at, problems_of_member};
use crate::error::KeystoreError;
use crate::files;
use crate::governance::{Domains, Weakness};
use crate::grant::validity;
use crate::issue::{NewMember, from};
use crate::layout::{CERTIFICATE, ENCLAVES, KEY, PERMISSIONS, PERMISSIONS_TEXT, PRIVATE};
use crate::problem::EnclaveProblem;
use crate::revocations::{enclave_of, revoked, write_revoked};

/// A keystore, as it is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ShownKeystore {
    /// The domains in which it holds.
    pub domains: Vec<Domains>,
    /// Since 1970: when its authority ends.
    pub authority_ends: Duration,
    /// What is wrong with its governance.
    pub weaknesses: Vec<Weakness>,
    /// By name.
    pub members: Vec<ShownMember>,
    /// The enclaves that were revoked, by name.
    pub revoked: Vec<String>,
    /// The private keys that others than their owner can read or change.
    pub open_keys: Vec<PathBuf>,
    /// Folders beside it with private keys, of commands that were interrupted.
    pub leftovers: Vec<PathBuf>,
}

/// A member of a keystore.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ShownMember {
    /// Its enclave, such as `/robot_3`.
    pub enclave: String,
    /// Since 1970: when it can no longer take part; `None` where its files do not say.
    pub ends: Option<Duration>,
    /// What keeps it from taking part now, but for the governance and keys that others can read.
    pub problems: Vec<EnclaveProblem>,
}

/// Whether a folder is a keystore, with what makes its members.
pub fn is_keystore(folder: &Path) -> bool {
    Authority::is_in(folder).unwrap_or(false)
}

/// Who belongs to a keystore, until when, and what is wrong with it `now`, a time since 1970.
pub fn show(keystore: &Path, now: Duration) -> Result<ShownKeystore, KeystoreError> {
    let authority = authority_of(keystore)?;
    let governance = authority.governance(keystore)?;
    let domains: Vec<Domains> = governance.domains().collect();
    let members = enclaves_of(keystore)?.into_iter().map(|(enclave, folder)| {
        let mut problems = problems_of_one(keystore, (&enclave, &folder), &domains, now);
        problems.retain(|problem| {
            // Of the keystore, and of all keys.
            !matches!(problem, EnclaveProblem::Governance(_) | EnclaveProblem::KeyIsReadable { .. })
        });
        ShownMember { ends: ends_at(&folder), enclave, problems }
    });
    let members = members.collect();
    let mut open_keys = Vec::new();
    for key in files::keys_in(keystore)? {
        let mode = files::mode_for_others(&key).map_err(KeystoreError::file("find", &key))?;
        open_keys.extend(mode.map(|_| key));
    }
    Ok(ShownKeystore {
        domains,
        authority_ends: authority.ends(),
        weaknesses: governance.all_weaknesses(),
        members,
        revoked: revoked(keystore)?.into_iter().collect(),
        open_keys,
        leftovers: files::leftovers(keystore),
    })
}

/// What is wrong with an enclave in the domains of its keystore, of which it may be in one.
fn problems_of_one(
    keystore: &Path,
    enclave: (&str, &Path),
    domains: &[Domains],
    now: Duration,
) -> Vec<EnclaveProblem> {
    let first = domains.first().map_or(0, |domains| domains.first);
    let mut problems = problems_of_member(keystore, enclave, first, now);
    if !matches!(domains, [only] if only.first == only.last) {
        problems.retain(|problem| !matches!(problem, EnclaveProblem::WrongDomain { .. }));
    }
    problems
}

/// That nothing is wrong with some files of these enclaves, which what is made anew is made from.
fn check_files(
    keystore: &Path,
    enclaves: &BTreeMap<String, PathBuf>,
    files: &[&str],
) -> Result<(), KeystoreError> {
    let members = enclaves.iter().map(|(enclave, folder)| {
        let mut problems = problems_of_one(keystore, (enclave, folder), &[], Duration::ZERO);
        problems.retain(|it| it.is_damage() && files.contains(&it.file()));
        (enclave.clone(), problems)
    });
    let members: Vec<_> = members.filter(|(_, problems)| !problems.is_empty()).collect();
    if members.is_empty() { Ok(()) } else { Err(KeystoreError::Damaged { members }) }
}

/// Links what all enclaves share into each of them, and names what was no such link before.
pub(crate) fn link_all(
    enclaves: &BTreeMap<String, PathBuf>,
) -> Result<Vec<PathBuf>, KeystoreError> {
    let mut made = Vec::new();
    for (enclave, folder) in enclaves {
        made.extend(files::link_shared(folder, enclave)?);
    }
    Ok(made)
}

/// Gives a keystore more time, from `now` for as long as `validity`, and returns its new end; both
/// times are since 1970.
///
/// Its authority and all of its members get certificates anew, for the keys that they have, and
/// permissions that hold as long. What was copied takes part with it until it ends.
///
/// # Errors
///
/// If a member has no key or permissions that can be used, nothing is changed.
pub fn renew(
    keystore: &Path,
    now: Duration,
    validity: Duration,
) -> Result<Duration, KeystoreError> {
    let holds = (from(now), now.saturating_add(validity));
    let authority = authority_of(keystore)?;
    let _lock = files::lock(keystore)?;
    // What somebody has changed would be copied to every robot.
    let governance = authority.governance(keystore)?;
    let enclaves = enclaves_of(keystore)?;
    check_files(keystore, &enclaves, &[KEY, PERMISSIONS])?;
    let member = |(enclave, folder): (&String, &PathBuf)| {
        let key = authority::key_in(&folder.join(KEY))?;
        let text = authority.signed_text(&folder.join(PERMISSIONS))?;
        Ok((NewMember::with_key(enclave, holds, key)?, folder.clone(), text))
    };
    // All of it before anything is written.
    let members: Vec<_> = enclaves.iter().map(member).collect::<Result<_, _>>()?;
    link_all(&enclaves)?;
    let authority = authority.renewed(keystore, holds)?;
    authority.write_governance(keystore, &governance)?;
    for (member, folder, text) in members {
        authority.certify(&folder, member)?;
        write_permissions(&authority, &folder, &text, holds)?;
    }
    Ok(holds.1)
}

/// A keystore that was made anew.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Revoked {
    /// Where the old one is now.
    pub old: PathBuf,
    /// Since 1970: until when the new one holds.
    pub ends: Duration,
    /// Where its private part is, if that of the old one was elsewhere.
    pub private: Option<PathBuf>,
}

/// Makes a keystore without one of its members, such as `robot_3`, in which nothing is left that
/// this one could use: a new authority, and new keys for all others, with the permissions that they
/// had, from `now` (since 1970) for as long as `validity`.
///
/// # Errors
///
/// After every error the old keystore is where it was.
pub fn revoke(
    keystore: &Path,
    name: &str,
    now: Duration,
    validity: Duration,
) -> Result<Revoked, KeystoreError> {
    authority_of(keystore)?;
    // Not a link to it, and whatever it ends with.
    let keystore = &keystore.canonicalize().map_err(KeystoreError::file("find", keystore))?;
    let _lock = files::lock(keystore)?;
    let before = authority_of(keystore)?;
    let governance = before.governance(keystore)?;
    let mut enclaves = enclaves_of(keystore)?;
    let gone = enclave_of(name);
    if enclaves.remove(&gone).is_none() {
        if revoked(keystore)?.contains(&gone) {
            return Err(KeystoreError::Revoked { name: gone });
        }
        let meant = nearest(&gone, enclaves.keys().map(String::as_str)).map(str::to_owned);
        let meant = meant.filter(|_| gone != "/");
        return Err(KeystoreError::NoEnclave { name: gone, meant });
    }
    check_files(keystore, &enclaves, &[PERMISSIONS])?;
    let holds = (from(now), now.saturating_add(validity));
    // Both gone again where something fails before they take their places.
    let new = files::folder_beside(keystore)?;
    let private = files::private_beside(&keystore.join(PRIVATE))?;
    if let Some(private) = &private {
        files::link(private.path(), &new.path().join(PRIVATE))?;
    }
    let authority = Authority::create(new.path(), holds)?;
    let folders = new.path().join(ENCLAVES);
    files::make_folder(&folders)?;
    authority.write_governance(new.path(), &governance)?;
    for (enclave, folder) in &enclaves {
        let made = folders.join(enclave.trim_start_matches('/'));
        files::make_folder(&made)?;
        authority.issue(&made, enclave, holds)?;
        files::link_shared(&made, enclave)?;
        let text = before.signed_text(&folder.join(PERMISSIONS))?;
        write_permissions(&authority, &made, &text, holds)?;
    }
    let mut all_gone = revoked(keystore)?;
    all_gone.insert(gone);
    write_revoked(new.path(), &all_gone)?;
    let old = files::free_name(keystore, ".old");
    files::exchange(&new.keep(), keystore, &old)?;
    Ok(Revoked { old, ends: holds.1, private: private.map(TempDir::keep) })
}

pub(crate) fn authority_of(keystore: &Path) -> Result<Authority, KeystoreError> {
    if Authority::is_in(keystore)? {
        Authority::read(keystore)
    } else {
        Err(KeystoreError::NoKeystore { folder: keystore.to_owned() })
    }
}

/// All enclaves by name, with their folders; also those that lack something.
pub(crate) fn enclaves_of(keystore: &Path) -> Result<BTreeMap<String, PathBuf>, KeystoreError> {
    let top = keystore.join(ENCLAVES);
    let mut found = BTreeMap::new();
    let mut folders = vec![top.clone()];
    while let Some(folder) = folders.pop() {
        let has = |file: &&str| folder.join(file).symlink_metadata().is_ok();
        if [CERTIFICATE, KEY, PERMISSIONS].iter().any(has)
            && let Some(name) = folder.strip_prefix(&top).ok().and_then(Path::to_str)
        {
            found.insert(format!("/{name}"), folder.clone());
        }
        folders.extend(files::folders_in(&folder)?);
    }
    Ok(found)
}

/// Writes what a member may do, signed, to hold from one moment to another.
fn write_permissions(
    authority: &Authority,
    folder: &Path,
    text: &str,
    holds: (Duration, Duration),
) -> Result<(), KeystoreError> {
    let (not_before, not_after) = validity(holds)?;
    let text = with_content(text, "not_before", &not_before);
    let text = with_content(&text, "not_after", &not_after);
    files::write_public(&folder.join(PERMISSIONS_TEXT), &text)?;
    files::write_public(&folder.join(PERMISSIONS), &authority.sign(&text)?)
}

/// A document of XML with another text in each element of a name.
fn with_content(xml: &str, element: &str, text: &str) -> String {
    let (open, close) = (format!("<{element}>"), format!("</{element}>"));
    let mut pieces = xml.split(open.as_str());
    let mut changed = pieces.next().unwrap_or_default().to_owned();
    for piece in pieces {
        let behind = piece.split_once(close.as_str()).map_or("", |(_, behind)| behind);
        changed.extend([open.as_str(), text, close.as_str(), behind]);
    }
    changed
}
