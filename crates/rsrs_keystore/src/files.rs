//! Files of a keystore: keys that only their owner reads, and links that stay valid in a copy.

use std::collections::BTreeMap;
use std::fs::{self, File, Permissions};
use std::io::{self, Write};
use std::os::unix::fs::{DirBuilderExt, PermissionsExt, symlink};
use std::path::{Path, PathBuf};

use tempfile::{NamedTempFile, TempDir};

use crate::error::KeystoreError;
use crate::layout::{GOVERNANCE, IDENTITY_CA, PERMISSIONS_CA, PUBLIC};

/// Read and written by their owner alone.
pub(crate) const PRIVATE_MODE: u32 = 0o600;
/// Read by everybody, and written by its owner alone.
const PUBLIC_MODE: u32 = 0o644;
const PUBLIC_FOLDER_MODE: u32 = 0o755;
const PRIVATE_FOLDER_MODE: u32 = 0o700;
/// Permissions name every topic of a fleet, in a hundred bytes each.
const MOST_BYTES: u64 = 1 << 20;

/// Makes a folder and those above it.
pub(crate) fn make_folder(folder: &Path) -> Result<(), KeystoreError> {
    let made = fs::DirBuilder::new().recursive(true).mode(PUBLIC_FOLDER_MODE).create(folder);
    made.map_err(KeystoreError::file("make", folder))
}

/// Makes a folder beside another one, of a name that nobody else chooses; gone when dropped.
pub(crate) fn folder_beside(other: &Path) -> Result<TempDir, KeystoreError> {
    let parent = folder_of(other);
    let public = Permissions::from_mode(PUBLIC_FOLDER_MODE);
    tempfile::Builder::new()
        .prefix("keystore.")
        .permissions(public)
        .tempdir_in(parent)
        .map_err(KeystoreError::file("make a folder in", parent))
}

/// A name that nothing has yet: `keystore.old`, or `keystore.old_2`, `keystore.old_3`, …
pub(crate) fn free_name(folder: &Path, ending: &str) -> PathBuf {
    let with = |ending: &str| {
        let mut name = folder.as_os_str().to_owned();
        name.push(ending);
        PathBuf::from(name)
    };
    let mut name = with(ending);
    let mut number = 2;
    while name.symlink_metadata().is_ok() {
        name = with(&format!("{ending}_{number}"));
        number += 1;
    }
    name
}

/// Moves a folder.
pub(crate) fn rename(from: &Path, to: &Path) -> Result<(), KeystoreError> {
    fs::rename(from, to).map_err(KeystoreError::file("move the keystore to", to))
}

/// The folders in one.
///
/// # Errors
///
/// [`KeystoreError::LinkedFolder`], because what is elsewhere is not this keystore's alone.
pub(crate) fn folders_in(folder: &Path) -> Result<Vec<PathBuf>, KeystoreError> {
    let mut found = Vec::new();
    for path in entries_of(folder)? {
        if path.is_dir() {
            if path.is_symlink() {
                return Err(KeystoreError::LinkedFolder { path });
            }
            found.push(path);
        }
    }
    Ok(found)
}

fn entries_of(folder: &Path) -> Result<Vec<PathBuf>, KeystoreError> {
    let paths = |entries: fs::ReadDir| entries.map(|entry| Ok(entry?.path())).collect();
    fs::read_dir(folder).and_then(paths).map_err(KeystoreError::file("list", folder))
}

/// Makes a folder that only its owner enters.
pub(crate) fn make_private_folder(folder: &Path) -> Result<(), KeystoreError> {
    let made = fs::DirBuilder::new().recursive(true).mode(PRIVATE_FOLDER_MODE).create(folder);
    made.map_err(KeystoreError::file("make", folder))
}

/// Writes a private key, whole or not at all; one that is there stays.
pub(crate) fn write_key(path: &Path, pem: &str) -> Result<(), KeystoreError> {
    let written = || {
        let file = draft_of(path, PRIVATE_MODE, pem)?;
        file.as_file().sync_all()?;
        file.persist_noclobber(path)?;
        File::open(folder_of(path))?.sync_all()
    };
    written().map_err(KeystoreError::file("write", path))
}

/// Writes what everybody may read: the old file or the new one, whole.
pub(crate) fn write_public(path: &Path, text: &str) -> Result<(), KeystoreError> {
    let written = || {
        draft_of(path, PUBLIC_MODE, text)?.persist(path)?;
        Ok(())
    };
    written().map_err(KeystoreError::file("write", path))
}

/// A file beside another one, of a name that nobody else chooses, to take its place.
fn draft_of(path: &Path, mode: u32, text: &str) -> io::Result<NamedTempFile> {
    let permissions = Permissions::from_mode(mode);
    let mut file =
        tempfile::Builder::new().permissions(permissions).tempfile_in(folder_of(path))?;
    file.write_all(text.as_bytes())?;
    Ok(file)
}

fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Reads a text.
pub(crate) fn read(path: &Path) -> Result<String, KeystoreError> {
    text(path).map_err(KeystoreError::file("read", path))
}

/// Reads a text of a keystore, none of which is long.
pub(crate) fn text(path: &Path) -> io::Result<String> {
    rsrs_files::read_text_of_at_most(MOST_BYTES, path)
}

/// Makes a link, unless there is one already.
pub(crate) fn link(to: &Path, path: &Path) -> Result<(), KeystoreError> {
    if path.symlink_metadata().is_ok() {
        return Ok(());
    }
    symlink(to, path).map_err(KeystoreError::file("link", path))
}

/// Links what all enclaves share into one.
pub(crate) fn link_shared(folder: &Path, name: &str) -> Result<(), KeystoreError> {
    // Up to the folder of all enclaves, through those of a namespace.
    let up: PathBuf = name.trim_start_matches('/').split('/').map(|_| "..").collect();
    for file in [IDENTITY_CA, PERMISSIONS_CA] {
        link(&up.join("..").join(PUBLIC).join(file), &folder.join(file))?;
    }
    link(&up.join(GOVERNANCE), &folder.join(GOVERNANCE))
}

/// All private keys of a keystore, also behind links and in copies of other names; each once.
pub(crate) fn keys_in(keystore: &Path) -> Result<Vec<PathBuf>, KeystoreError> {
    let mut found = BTreeMap::new();
    let mut folders = vec![keystore.to_owned()];
    while let Some(folder) = folders.pop() {
        for path in entries_of(&folder)? {
            // A link that leads nowhere.
            let Ok(real) = path.canonicalize() else { continue };
            if real.is_dir() {
                // Its own folders may be elsewhere, such as `private` on a disk that is locked away.
                if !path.is_symlink() || folder == keystore {
                    folders.push(path);
                }
            } else if is_key(&path) && (!path.is_symlink() || !found.contains_key(&real)) {
                found.insert(real, path);
            }
        }
    }
    let mut keys: Vec<PathBuf> = found.into_values().collect();
    keys.sort();
    Ok(keys)
}

/// By its name, as `ca.key.pem.bak`, or by what it says of itself.
fn is_key(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    name.contains("key.pem") || text(path).is_ok_and(|text| text.contains("PRIVATE KEY-----"))
}

/// The mode of a key that others than its owner can read or change, as in `chmod`; `None` of one that is
/// private. Whoever reads it can be this member; whoever is of its group can be anybody, too.
pub(crate) fn mode_for_others(key: &Path) -> io::Result<Option<u32>> {
    let mode = fs::metadata(key)?.permissions().mode() & 0o777;
    Ok((mode & 0o077 != 0).then_some(mode))
}

/// Lets only the owner read a key.
///
/// # Returns
///
/// Whether others could before.
pub(crate) fn make_private(key: &Path) -> Result<bool, KeystoreError> {
    let cannot = |source| KeystoreError::file("make private", key)(source);
    if mode_for_others(key).map_err(cannot)?.is_none() {
        return Ok(false);
    }
    fs::set_permissions(key, Permissions::from_mode(PRIVATE_MODE)).map_err(cannot)?;
    Ok(true)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_key_is_private_stays_and_leaves_nothing_beside_it() {
        let folder = tempfile::tempdir().unwrap();
        let key = folder.path().join("key.pem");

        write_key(&key, "first").unwrap();
        let second = write_key(&key, "second");

        assert!(second.is_err());
        assert_eq!(fs::read_to_string(&key).unwrap(), "first");
        assert_eq!(fs::metadata(&key).unwrap().permissions().mode() & 0o777, PRIVATE_MODE);
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }
}
