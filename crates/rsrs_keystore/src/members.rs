//! The members of a keystore that is there: until when they hold, more time for all, and one fewer.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::Duration;

use rsrs_core::document::nearest;

use crate::authority::{self, Authority};
use crate::certificate;
use crate::dates::{moment, xml_date};
use crate::error::KeystoreError;
use crate::files;
use crate::governance::Domains;
use crate::issue::{NewMember, from};
use crate::layout::{CERTIFICATE, ENCLAVES, KEY, PERMISSIONS, PERMISSIONS_TEXT};
use crate::permissions::Permissions;
use crate::revocations::{enclave_of, revoked, write_revoked};

/// A keystore, as it is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ShownKeystore {
    /// The domains in which it holds.
    pub domains: Vec<Domains>,
    /// Since 1970: when its authority ends.
    pub authority_ends: Duration,
    /// By name.
    pub members: Vec<ShownMember>,
    /// The enclaves that were revoked, by name.
    pub revoked: Vec<String>,
    /// The private keys that others than their owner can read or change.
    pub open_keys: Vec<PathBuf>,
}

/// A member of a keystore.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ShownMember {
    /// Its enclave, such as `/robot_3`.
    pub enclave: String,
    /// Since 1970: when its certificate ends.
    pub certificate_ends: Duration,
    /// Since 1970: when its permissions end; `None` where they are not what the authority has signed.
    pub permissions_end: Option<Duration>,
}

impl ShownMember {
    /// When it can no longer take part, since 1970.
    pub fn ends(&self, authority_ends: Duration) -> Duration {
        let permissions_end = self.permissions_end.unwrap_or(Duration::ZERO);
        self.certificate_ends.min(permissions_end).min(authority_ends)
    }
}

/// Whether a folder is a keystore, with what makes its members.
pub fn is_keystore(folder: &Path) -> bool {
    Authority::is_in(folder)
}

/// Who belongs to a keystore, until when, and whether its keys are private.
///
/// # Errors
///
/// [`KeystoreError`] if the folder is no keystore, or something in it does not read.
pub fn show(keystore: &Path) -> Result<ShownKeystore, KeystoreError> {
    let authority = authority_of(keystore)?;
    let members = enclaves_of(keystore)?.into_iter().map(|(enclave, folder)| {
        let path = folder.join(CERTIFICATE);
        let facts = certificate::read(&files::read(&path)?)
            .map_err(|error| KeystoreError::Certificate { path, reason: error.to_string() })?;
        let text = authority.signed_text(&folder.join(PERMISSIONS)).ok();
        let grants = text.and_then(|xml| Permissions::parse(&xml).ok());
        let own = grants.as_ref().and_then(|grants| grants.grant_of(&facts.subject));
        let permissions_end = own.and_then(|grant| moment(&grant.validity.1));
        Ok(ShownMember { enclave, certificate_ends: facts.not_after, permissions_end })
    });
    let mut open_keys = Vec::new();
    for key in files::keys_in(keystore)? {
        let mode = files::mode_for_others(&key).map_err(KeystoreError::file("find", &key))?;
        open_keys.extend(mode.map(|_| key));
    }
    Ok(ShownKeystore {
        domains: authority.governance(keystore)?.domains().collect(),
        authority_ends: authority.ends(),
        members: members.collect::<Result<_, KeystoreError>>()?,
        revoked: revoked(keystore)?.into_iter().collect(),
        open_keys,
    })
}

/// Gives a keystore more time: its authority and all of its members get certificates anew, for the keys
/// that they have, and permissions that hold as long. What was copied takes part with it until it ends.
///
/// # Arguments
///
/// * `now` — since 1970.
/// * `validity` — for how long.
///
/// # Errors
///
/// [`KeystoreError`] if the folder is no keystore, or cannot be written; or if a member has no key or
/// permissions that read, and then nothing is changed.
pub fn renew(keystore: &Path, now: Duration, validity: Duration) -> Result<(), KeystoreError> {
    let holds = (from(now), now.saturating_add(validity));
    let authority = authority_of(keystore)?;
    // What somebody has changed would be copied to every robot.
    authority.governance(keystore)?;
    let member = |(enclave, folder): (String, PathBuf)| {
        let key = authority::key_in(&folder.join(KEY))?;
        let text = authority.signed_text(&folder.join(PERMISSIONS))?;
        Ok((enclave, folder, key, text))
    };
    // All of it before anything is written.
    let members: Vec<_> =
        enclaves_of(keystore)?.into_iter().map(member).collect::<Result<_, _>>()?;
    let authority = authority.renewed(keystore, holds)?;
    for (enclave, folder, key, text) in members {
        authority.certify(&folder, NewMember::with_key(&enclave, holds, key)?)?;
        write_permissions(&authority, &folder, &text, holds)?;
    }
    Ok(())
}

/// Makes a keystore without one of its members, in which nothing is left that this one could use: a new
/// authority, and new keys for all others, with the permissions that they had.
///
/// # Arguments
///
/// * `name` — of the enclave that goes, such as `robot_3`.
/// * `now`, `validity` — since 1970, and for how long.
///
/// # Returns
///
/// Where the old one is now.
///
/// # Errors
///
/// [`KeystoreError`] if there is no such enclave, or something cannot be written; the old keystore is then
/// where it was.
pub fn revoke(
    keystore: &Path,
    name: &str,
    now: Duration,
    validity: Duration,
) -> Result<PathBuf, KeystoreError> {
    // Not a link to it, and whatever it ends with.
    let keystore = &keystore.canonicalize().map_err(KeystoreError::file("find", keystore))?;
    let before = authority_of(keystore)?;
    let governance = before.governance(keystore)?;
    let enclaves = enclaves_of(keystore)?;
    let gone = enclave_of(name);
    if !enclaves.contains_key(&gone) {
        if revoked(keystore)?.contains(&gone) {
            return Err(KeystoreError::Revoked { name: gone });
        }
        let meant = nearest(&gone, enclaves.keys().map(String::as_str)).map(str::to_owned);
        return Err(KeystoreError::NoEnclave { name: gone, meant });
    }
    let holds = (from(now), now.saturating_add(validity));
    // Gone again where something fails.
    let new = files::folder_beside(keystore)?;
    let authority = Authority::create(new.path(), holds)?;
    let folders = new.path().join(ENCLAVES);
    files::make_folder(&folders)?;
    authority.write_governance(new.path(), &governance)?;
    for (enclave, folder) in enclaves.iter().filter(|(enclave, _)| **enclave != gone) {
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
    files::rename(keystore, &old)?;
    files::rename(&new.keep(), keystore)?;
    Ok(old)
}

fn authority_of(keystore: &Path) -> Result<Authority, KeystoreError> {
    if Authority::is_in(keystore) {
        Authority::read(keystore)
    } else {
        Err(KeystoreError::NoKeystore { folder: keystore.to_owned() })
    }
}

/// All enclaves by name, with their folders.
fn enclaves_of(keystore: &Path) -> Result<BTreeMap<String, PathBuf>, KeystoreError> {
    let top = keystore.join(ENCLAVES);
    let mut found = BTreeMap::new();
    let mut folders = vec![top.clone()];
    while let Some(folder) = folders.pop() {
        if folder.join(CERTIFICATE).exists()
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
    (from, to): (Duration, Duration),
) -> Result<(), KeystoreError> {
    let validity = xml_date(from)
        .zip(xml_date(to))
        .ok_or(KeystoreError::Validity { from_s: from.as_secs(), to_s: to.as_secs() });
    let (not_before, not_after) = validity?;
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
