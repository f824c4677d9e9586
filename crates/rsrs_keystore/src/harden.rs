//! A lab's own keystore, made such that this middleware carries what it demands.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use crate::KeystoreError;
use crate::authority::Authority;
use crate::create::write_governance;
use crate::files;
use crate::governance::Governance;
use crate::layout::{ENCLAVES, GOVERNANCE};
use crate::signed_document::signed_text;

/// What was changed in a keystore.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Hardened {
    /// What was wrong with its governance.
    pub cured: Vec<String>,
    /// Private keys that others could read.
    pub keys_made_private: Vec<PathBuf>,
}

/// Signs another governance where that of a keystore is too weak or is not carried, for the same
/// domains and topics, and makes its keys private. Certificates and permissions stay.
///
/// # Errors
///
/// [`KeystoreError`] if the folder is no keystore, or cannot be written.
pub fn harden(folder: &Path) -> Result<Hardened, KeystoreError> {
    if !Authority::is_in(folder) {
        return Err(KeystoreError::NoKeystore { folder: folder.to_owned() });
    }
    let authority = Authority::read(folder)?;
    let path = folder.join(ENCLAVES).join(GOVERNANCE);
    let document = files::read(&path)?;
    let text = signed_text(&document)
        .map_err(|source| KeystoreError::NotSigned { path: path.clone(), source })?;
    let governance = Governance::parse(text)
        .map_err(|source| KeystoreError::Governance { path: path.clone(), source })?;
    let cured: BTreeSet<String> = governance
        .rules
        .iter()
        .flat_map(|rule| rule.domains.iter().flat_map(|those| governance.weaknesses(those.first)))
        .map(|weakness| weakness.to_string())
        .collect();
    if !cured.is_empty() {
        write_governance(&authority, folder, &governance.hardened())?;
    }
    let mut keys_made_private = Vec::new();
    for key in files::keys_below(folder)? {
        if files::make_private(&key)? {
            keys_made_private.push(key);
        }
    }
    Ok(Hardened { cured: cured.into_iter().collect(), keys_made_private })
}
