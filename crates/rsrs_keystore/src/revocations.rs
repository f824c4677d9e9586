//! The enclaves that were revoked, which a keystore that is completed leaves out.

use std::collections::BTreeSet;
use std::io::ErrorKind;
use std::path::Path;

use crate::error::KeystoreError;
use crate::files;
use crate::layout::{PRIVATE, REVOKED};

/// The enclaves that were revoked.
pub(crate) fn revoked(keystore: &Path) -> Result<BTreeSet<String>, KeystoreError> {
    let path = keystore.join(PRIVATE).join(REVOKED);
    match files::text(&path) {
        Ok(text) => Ok(text.lines().map(str::to_owned).collect()),
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(BTreeSet::new()),
        Err(error) => Err(KeystoreError::file("read", &path)(error)),
    }
}

pub(crate) fn write_revoked(
    keystore: &Path,
    enclaves: &BTreeSet<String>,
) -> Result<(), KeystoreError> {
    let lines: String = enclaves.iter().flat_map(|enclave| [enclave.as_str(), "\n"]).collect();
    files::write_public(&keystore.join(PRIVATE).join(REVOKED), &lines)
}

/// The enclave that a person names with or without strokes around it.
pub(crate) fn enclave_of(name: &str) -> String {
    format!("/{}", name.trim_matches('/'))
}
