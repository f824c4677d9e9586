//! Files, named where they cannot be read or written.

pub mod lock_file;

use std::fs::{File, Permissions};
use std::io::{ErrorKind, Write};
use std::os::unix::fs::PermissionsExt as _;
use std::path::{Path, PathBuf};

use anyhow::Context;
use rsrs_core::numerals::size;
use rsrs_files::quoted;
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::error::with_help;

/// What to do about a folder that is in the way.
pub const ANOTHER_FOLDER: &str = "give another folder with `-o`, or remove this one";

/// Files as one source: all names of a few, the first of many.
pub fn names(paths: &[&PathBuf]) -> String {
    let names: Vec<String> = paths.iter().map(|path| path.display().to_string()).collect();
    match &names[..] {
        [first, .., last] if names.len() > 3 => {
            format!("{first} to {last} ({} files)", names.len())
        }
        _ => names.join(", "),
    }
}

/// The experiment file that lies here or beside the folder of a sweep, as `rsrs init` leaves it.
pub fn experiment_file_beside(sweep: &Path) -> Option<PathBuf> {
    let name = "experiment.yaml";
    let parent = sweep.parent().map(|parent| parent.join(name));
    [Some(PathBuf::from(name)), parent].into_iter().flatten().find(|it| it.is_file())
}

/// Writes one file: a reader finds the old one or the new one, whole, and the old one if it cannot
/// be written. A link is replaced, and what it points to stays as it is; a pipe or a device is
/// written to.
pub fn write_file(path: &Path, bytes: &[u8]) -> anyhow::Result<()> {
    let is_stream = path.metadata().is_ok_and(|metadata| !metadata.is_file());
    let written = if is_stream {
        std::fs::write(path, bytes)
    } else {
        draft_of(path, bytes).and_then(|draft| draft.persist(path).map(drop).map_err(Into::into))
    };
    written.map_err(|error| not_written(path, error))?;
    wrote(path);
    Ok(())
}

/// Writes one file as [`write_file`] does, unless one is there with other contents, which is not lost:
/// that is an error, whose help is `instead`.
pub fn write_once(path: &Path, bytes: &[u8], instead: &str) -> anyhow::Result<()> {
    let is_file = path.metadata().is_ok_and(|metadata| metadata.is_file());
    if is_file && read_if_there(path)?.is_some_and(|there| there.as_bytes() != bytes) {
        let message = format!("{} exists, with other contents", path.display());
        return Err(with_help(message, instead));
    }
    write_file(path, bytes)
}

/// Writes one file of JSON as [`write_file`] does.
pub fn write_json(path: &Path, value: &impl Serialize) -> anyhow::Result<()> {
    let json = serde_json::to_string_pretty(value).context("plain data as JSON")?;
    write_file(path, format!("{json}\n").as_bytes())
}

/// Makes a folder, with those around it, where there is none.
pub fn make_folder(path: &Path) -> anyhow::Result<()> {
    std::fs::create_dir_all(path).with_context(|| format!("cannot make {}", path.display()))
}

/// Writes one file as [`write_file`] does, on the disk at once: the old or the new one is there,
/// whenever this program or the machine is killed, or the disk is full.
pub fn write_durably(path: &Path, bytes: &[u8]) -> std::io::Result<()> {
    let draft = draft_of(path, bytes)?;
    draft.as_file().sync_all()?;
    draft.persist(path)?;
    // The name, too.
    File::open(folder_of(path))?.sync_all()
}

/// Writes one file into a folder that is still to take its place, so that it is not logged. What was
/// there, a link included, is removed.
pub fn write_draft(path: &Path, bytes: &[u8]) -> anyhow::Result<()> {
    let write = || {
        match std::fs::remove_file(path) {
            Err(error) if error.kind() != ErrorKind::NotFound => return Err(error),
            _ => {}
        }
        File::create_new(path)?.write_all(bytes)
    };
    write().with_context(|| cannot_write(path))
}

/// A file beside another one, of a name that nobody else chooses, to take its place.
fn draft_of(path: &Path, bytes: &[u8]) -> std::io::Result<tempfile::NamedTempFile> {
    let mut draft = tempfile::Builder::new()
        .prefix(".rsrs.")
        .permissions(Permissions::from_mode(0o666))
        .tempfile_in(folder_of(path))
        // Without the draft's name, which nobody knows.
        .map_err(|error| std::io::Error::from(error.kind()))?;
    draft.write_all(bytes)?;
    Ok(draft)
}

/// The folder that a path lies in.
pub fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

fn cannot_read(path: &Path) -> String {
    format!("cannot read {}", path.display())
}

/// What to call it where a file cannot be written.
pub fn cannot_write(path: &Path) -> String {
    format!("cannot write {}", path.display())
}

fn not_written(path: &Path, error: std::io::Error) -> anyhow::Error {
    let folder = folder_of(path);
    if folder.exists() {
        return anyhow::Error::new(error).context(cannot_write(path));
    }
    with_help(
        format!("{}: there is no folder {}", cannot_write(path), folder.display()),
        format!("make it: `mkdir -p {}`", quoted(folder)),
    )
}

/// Reads one file of text.
pub fn read_text(path: &Path) -> anyhow::Result<String> {
    let text = rsrs_files::read_text(path).with_context(|| cannot_read(path))?;
    log::info!("read {}: {}", path.display(), size(text.len() as u64));
    Ok(text)
}

/// Reads one file of JSON; `None` where there is none. An error says what it is not, as in `no label`.
pub fn read_json_if_there<T: DeserializeOwned>(path: &Path, is: &str) -> anyhow::Result<Option<T>> {
    if !path.exists() {
        return Ok(None);
    }
    let value = serde_json::from_str(&read_text(path)?);
    value.map(Some).with_context(|| format!("{} is {is}", path.display()))
}

/// Reads one file of text; `None` where there is none.
pub fn read_if_there(path: &Path) -> anyhow::Result<Option<String>> {
    match rsrs_files::read_text(path) {
        Ok(text) => Ok(Some(text)),
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(None),
        Err(error) => Err(error).with_context(|| cannot_read(path)),
    }
}

/// Logs that a file was written, with its size.
pub fn wrote(path: &Path) {
    let n_bytes = path.metadata().map_or(0, |metadata| metadata.len());
    log::info!("wrote {}: {}", path.display(), size(n_bytes));
}

#[cfg(test)]
mod tests {
    use std::os::unix::fs::symlink;

    use super::*;

    #[test]
    fn no_link_leads_a_result_into_another_file() {
        let folder = tempfile::tempdir().unwrap();
        let (theirs, mine) = (folder.path().join("keys"), folder.path().join("label.json"));
        let durably = |path: &Path, bytes: &[u8]| write_durably(path, bytes).context("a disk");
        for write in [write_file, write_draft, durably] {
            std::fs::write(&theirs, "theirs").unwrap();
            drop(std::fs::remove_file(&mine));
            symlink(&theirs, &mine).unwrap();

            write(&mine, b"mine").unwrap();

            assert_eq!(std::fs::read_to_string(&theirs).unwrap(), "theirs");
            assert_eq!(std::fs::read_to_string(&mine).unwrap(), "mine");
            assert!(mine.symlink_metadata().unwrap().is_file());
        }
        let n_files = std::fs::read_dir(folder.path()).unwrap().count();
        assert_eq!(n_files, 2, "nothing stays beside them");
    }

    #[test]
    fn what_is_written_once_is_not_lost() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("floor.yaml");

        write_once(&path, b"fixed", "name another").unwrap();
        write_once(&path, b"fixed", "name another").expect("the same again is the same file");
        let other = write_once(&path, b"other", "name another").unwrap_err();

        assert!(other.to_string().ends_with("floor.yaml exists, with other contents"), "{other}");
        assert_eq!(crate::error::help_of(&other).unwrap(), "name another");
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "fixed");
        write_once(Path::new("/dev/null"), b"anything", "").expect("a device keeps nothing");
    }

    #[test]
    fn what_cannot_be_replaced_is_written_to() {
        write_file(Path::new("/dev/null"), b"anything").unwrap();

        assert!(!Path::new("/dev/null").metadata().unwrap().is_file());
    }
}
