//! A lab's own keystore, made such that this middleware carries what it demands.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use crate::authority::Authority;
use crate::error::KeystoreError;
use crate::files;

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
/// [`KeystoreError`] if the folder is no keystore, or cannot be written; or if its governance is not what
/// its authority has signed, because what somebody has changed must not be signed again.
pub fn harden(folder: &Path) -> Result<Hardened, KeystoreError> {
    if !Authority::is_in(folder) {
        return Err(KeystoreError::NoKeystore { folder: folder.to_owned() });
    }
    let authority = Authority::read(folder)?;
    let governance = authority.governance(folder)?;
    let cured: BTreeSet<String> =
        governance.all_weaknesses().iter().map(ToString::to_string).collect();
    if !cured.is_empty() {
        authority.write_governance(folder, &governance.hardened())?;
    }
    let mut keys_made_private = Vec::new();
    for key in files::keys_in(folder)? {
        if files::make_private(&key)? {
            keys_made_private.push(key);
        }
    }
    Ok(Hardened { cured: cured.into_iter().collect(), keys_made_private })
}
