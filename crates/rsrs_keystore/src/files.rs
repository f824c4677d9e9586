//! Files of a keystore: keys that only their owner reads, and links that stay valid in a copy.

use std::collections::BTreeMap;
use std::fs::{self, File, Permissions};
use std::io::{self, ErrorKind, Write};
use std::os::unix::fs::{DirBuilderExt, MetadataExt, PermissionsExt, symlink};
use std::path::{Path, PathBuf};

use rustix::fs::{CWD, RenameFlags, renameat_with};
use tempfile::{NamedTempFile, TempDir};

use crate::error::KeystoreError;
use crate::layout::{ENCLAVES, GOVERNANCE, LOCK, PUBLIC, SHARED};

/// Read and written by their owner alone.
pub(crate) const PRIVATE_MODE: u32 = 0o600;
/// Read by everybody, and written by its owner alone.
const PUBLIC_MODE: u32 = 0o644;
const PUBLIC_FOLDER_MODE: u32 = 0o755;
const PRIVATE_FOLDER_MODE: u32 = 0o700;
/// Permissions name every topic of a fleet, in a hundred bytes each.
const MOST_BYTES: u64 = 1 << 20;

/// Makes a folder and those above it, which everybody may enter whatever the umask is: who copies an
/// enclave copies their modes.
pub(crate) fn make_folder(folder: &Path) -> Result<(), KeystoreError> {
    make_folders(folder, PUBLIC_FOLDER_MODE).map_err(KeystoreError::file("make", folder))
}

fn make_folders(folder: &Path, mode: u32) -> io::Result<()> {
    if folder.is_dir() {
        return Ok(());
    }
    make_folders(folder_of(folder), PUBLIC_FOLDER_MODE)?;
    match fs::DirBuilder::new().mode(mode).create(folder) {
        Err(error) if error.kind() == ErrorKind::AlreadyExists && folder.is_dir() => Ok(()),
        made => made.and_then(|()| fs::set_permissions(folder, Permissions::from_mode(mode))),
    }
}

/// Waits until no other command changes a keystore, and keeps others waiting until what is returned is
/// dropped, or its process has ended.
pub(crate) fn lock(keystore: &Path) -> Result<File, KeystoreError> {
    let path = keystore.join(LOCK);
    let locked = || loop {
        let file = File::options().create(true).truncate(false).write(true).open(&path)?;
        file.lock()?;
        // Another keystore may have taken the place of the one that was waited for.
        if fs::metadata(&path)
            .is_ok_and(|now| file.metadata().is_ok_and(|it| it.ino() == now.ino()))
        {
            return Ok(file);
        }
    };
    locked().map_err(KeystoreError::file("lock", &path))
}

/// What folders beside a keystore begin with that a command makes and that are gone when it ends.
fn unfinished(keystore: &Path) -> String {
    let name = keystore.file_name().unwrap_or_default().to_string_lossy();
    format!("{name}.unfinished.")
}

/// Folders beside a keystore that a command left that was interrupted, with private keys.
pub(crate) fn leftovers(keystore: &Path) -> Vec<PathBuf> {
    let keystore = keystore.canonicalize().unwrap_or_else(|_| keystore.to_owned());
    let begins = unfinished(&keystore);
    // Where nobody can look, nobody can have left anything.
    let mut found = entries_of(folder_of(&keystore)).unwrap_or_default();
    found.retain(|path| {
        path.file_name().is_some_and(|it| it.to_string_lossy().starts_with(&begins))
    });
    found.sort();
    found
}

/// Makes a folder beside another one, of its mode and a name that nobody else chooses; gone when dropped.
pub(crate) fn folder_beside(other: &Path) -> Result<TempDir, KeystoreError> {
    let parent = folder_of(other);
    let made = || {
        let mode = fs::metadata(other)?.permissions();
        let made = tempfile::Builder::new().prefix(&unfinished(other)).tempdir_in(parent);
        let made = made.map_err(without_path)?;
        fs::set_permissions(made.path(), mode)?;
        Ok(made)
    };
    made().map_err(KeystoreError::file("make a folder in", parent))
}

/// Where the private part of a keystore is a link, a folder beside where it leads, of a name that nobody
/// else chooses; gone when dropped.
pub(crate) fn private_beside(private: &Path) -> Result<Option<TempDir>, KeystoreError> {
    if !private.is_symlink() {
        return Ok(None);
    }
    let made = || {
        let real = private.canonicalize()?;
        tempfile::Builder::new()
            .prefix("private.")
            .tempdir_in(folder_of(&real))
            .map_err(without_path)
    };
    made().map(Some).map_err(KeystoreError::file("make a folder where it leads,", private))
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

/// Puts a folder in the place of another one, at once where the file system can do that, and moves that
/// one aside.
pub(crate) fn exchange(new: &Path, folder: &Path, aside: &Path) -> Result<(), KeystoreError> {
    let moved = || {
        let swap = || renameat_with(CWD, new, CWD, folder, RenameFlags::EXCHANGE);
        if swap().is_ok() {
            return fs::rename(new, aside).inspect_err(|_| _ = swap());
        }
        fs::rename(folder, aside)?;
        fs::rename(new, folder).inspect_err(|_| drop(fs::rename(aside, folder)))
    };
    moved().map_err(KeystoreError::file("move the keystore to", aside))
}

/// The folders in one.
///
/// # Errors
///
/// [`KeystoreError::LinkedFolder`], because what is elsewhere is not this keystore's alone.
pub(crate) fn folders_in(folder: &Path) -> Result<Vec<PathBuf>, KeystoreError> {
    let mut found = Vec::new();
    for path in entries_of(folder)? {
        // A link to nothing is one to a folder by its name: enclaves have no ending, and files have.
        if path.is_symlink() && (path.is_dir() || !path.exists() && path.extension().is_none()) {
            return Err(KeystoreError::LinkedFolder { path });
        }
        if path.is_dir() {
            found.push(path);
        }
    }
    Ok(found)
}

pub(crate) fn entries_of(folder: &Path) -> Result<Vec<PathBuf>, KeystoreError> {
    let paths = |entries: fs::ReadDir| entries.map(|entry| Ok(entry?.path())).collect();
    fs::read_dir(folder).and_then(paths).map_err(KeystoreError::file("list", folder))
}

/// Removes a file or a folder, if it is there; of a link the link.
pub(crate) fn remove(path: &Path) -> Result<(), KeystoreError> {
    let removed = match fs::symlink_metadata(path) {
        Ok(it) if it.is_dir() => fs::remove_dir_all(path),
        Ok(_) => fs::remove_file(path),
        Err(_) => Ok(()),
    };
    removed.map_err(KeystoreError::file("remove", path))
}

/// Makes a folder that only its owner enters.
pub(crate) fn make_private_folder(folder: &Path) -> Result<(), KeystoreError> {
    make_folders(folder, PRIVATE_FOLDER_MODE).map_err(KeystoreError::file("make", folder))
}

/// Writes a private key, whole or not at all; one that is there stays.
pub(crate) fn write_key(path: &Path, pem: &str) -> Result<(), KeystoreError> {
    let written = || {
        let file = draft_of(path, PRIVATE_MODE, pem)?;
        file.as_file().sync_all()?;
        file.persist_noclobber(path).map_err(|error| error.error)?;
        File::open(folder_of(path))?.sync_all()
    };
    written().map_err(KeystoreError::file("write", path))
}

/// Writes what everybody may read: the old file or the new one, whole.
pub(crate) fn write_public(path: &Path, text: &str) -> Result<(), KeystoreError> {
    let written = || {
        draft_of(path, PUBLIC_MODE, text)?.persist(path).map_err(|error| error.error)?;
        Ok(())
    };
    written().map_err(KeystoreError::file("write", path))
}

/// Makes an empty file, if it is not there, and at no time anything beside it.
pub(crate) fn note(path: &Path) -> Result<(), KeystoreError> {
    match File::options().write(true).create_new(true).open(path) {
        Err(error) if error.kind() != ErrorKind::AlreadyExists => {
            Err(KeystoreError::file("write", path)(error))
        }
        _ => Ok(()),
    }
}

/// A file beside another one, of a name that nobody else chooses, to take its place.
fn draft_of(path: &Path, mode: u32, text: &str) -> io::Result<NamedTempFile> {
    let mut file = NamedTempFile::new_in(folder_of(path)).map_err(without_path)?;
    // Whatever the umask is; until here it is private.
    file.as_file().set_permissions(Permissions::from_mode(mode))?;
    file.write_all(text.as_bytes()).map_err(without_path)?;
    Ok(file)
}

/// An error of a file of another name than the one that is written.
fn without_path(error: io::Error) -> io::Error {
    if error.raw_os_error().is_some() { error } else { error.kind().into() }
}

fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

pub(crate) fn read(path: &Path) -> Result<String, KeystoreError> {
    text(path).map_err(KeystoreError::file("read", path))
}

/// Reads a text of a keystore, none of which is long.
pub(crate) fn text(path: &Path) -> io::Result<String> {
    rsrs_files::read_text_of_at_most(MOST_BYTES, path)
}

/// Makes a link, also in the place of a copy or of a link to something else; `false` if it was
/// there.
pub(crate) fn link(to: &Path, path: &Path) -> Result<bool, KeystoreError> {
    let linked = || {
        let wanted = folder_of(path).join(to).canonicalize();
        if path.is_symlink() && wanted.is_ok_and(|it| path.canonicalize().is_ok_and(|is| is == it))
        {
            return Ok(false);
        }
        let draft = tempfile::Builder::new().make_in(folder_of(path), |draft| symlink(to, draft));
        draft.map_err(without_path)?.persist(path).map_err(|error| error.error)?;
        Ok(true)
    };
    linked().map_err(KeystoreError::file("link", path))
}

/// Where a keystore has what all enclaves share.
pub(crate) fn shared(keystore: &Path, file: &str) -> PathBuf {
    keystore.join(if file == GOVERNANCE { ENCLAVES } else { PUBLIC }).join(file)
}

/// Links what all enclaves share into one, and names what was no such link before.
pub(crate) fn link_shared(folder: &Path, name: &str) -> Result<Vec<PathBuf>, KeystoreError> {
    // Up to the folder of all enclaves, through those of a namespace.
    let up: PathBuf = name.split('/').filter(|part| !part.is_empty()).map(|_| "..").collect();
    let mut made = Vec::new();
    for file in SHARED {
        let to = match file {
            GOVERNANCE => up.join(file),
            file => shared(&up.join(".."), file),
        };
        let path = folder.join(file);
        // The enclave `/` is the folder of all enclaves.
        if to != Path::new(file) && link(&to, &path)? {
            made.push(path);
        }
    }
    Ok(made)
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

/// Lets only the owner read a key; `true` if others could before.
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
