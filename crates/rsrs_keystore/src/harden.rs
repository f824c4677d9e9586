//! A lab's own keystore, made such that this middleware carries what it demands.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use crate::error::KeystoreError;
use crate::files;
use crate::members::{authority_of, enclaves_of, link_all};

/// What was changed in a keystore.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Hardened {
    /// What was wrong with its governance.
    pub cured: Vec<String>,
    /// Private keys that others could read.
    pub keys_made_private: Vec<PathBuf>,
    /// What the enclaves share and was no link to it in one, such as a copy.
    pub linked: Vec<PathBuf>,
}

/// Signs another governance where that of a keystore is too weak or is not carried, for the same
/// domains and topics, links it and the authority's certificates into every enclave, and makes its
/// keys private. Certificates and permissions stay.
///
/// A governance that is not what the authority has signed is refused, because what somebody has
/// changed must not be signed again.
pub fn harden(folder: &Path) -> Result<Hardened, KeystoreError> {
    let authority = authority_of(folder)?;
    let _lock = files::lock(folder)?;
    let linked = link_all(&enclaves_of(folder)?)?;
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
    Ok(Hardened { cured: cured.into_iter().collect(), keys_made_private, linked })
}
