//! The enclaves that were revoked, which a keystore that is completed leaves out.

use std::collections::BTreeSet;
use std::path::Path;

use crate::error::KeystoreError;
use crate::files;
use crate::layout::{PRIVATE, REVOKED};

/// The enclaves that were revoked.
pub(crate) fn revoked(keystore: &Path) -> Result<BTreeSet<String>, KeystoreError> {
    let path = keystore.join(PRIVATE).join(REVOKED);
    if !path.exists() {
        return Ok(BTreeSet::new());
    }
    Ok(files::read(&path)?.lines().map(str::to_owned).collect())
}

/// Writes them.
pub(crate) fn write_revoked(
    keystore: &Path,
    enclaves: &BTreeSet<String>,
) -> Result<(), KeystoreError> {
    let lines: String = enclaves.iter().flat_map(|enclave| [enclave.as_str(), "\n"]).collect();
    files::write_public(&keystore.join(PRIVATE).join(REVOKED), &lines)
}

/// The enclave that a person names with or without the stroke before it.
pub(crate) fn enclave_of(name: &str) -> String {
    format!("/{}", name.trim_start_matches('/'))
}
