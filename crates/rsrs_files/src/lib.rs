#![doc = include_str!("../README.md")]

use std::fs::{File, OpenOptions};
use std::io::{self, ErrorKind, Read};
use std::os::unix::fs::OpenOptionsExt;
use std::path::Path;

use rustix::fs::OFlags;

/// A pipe, a socket or a device where a file should be.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("it is not a regular file")]
pub struct NotRegular;

/// A folder where a file should be.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("it is a folder{}", contents(yaml_files))]
pub struct Folder {
    /// Its YAML files, by name, in their order.
    pub yaml_files: Vec<String>,
}

impl Folder {
    fn at(path: &Path) -> Self {
        let names = std::fs::read_dir(path).into_iter().flatten().flatten();
        let names = names.map(|entry| entry.file_name().to_string_lossy().into_owned());
        let is_yaml = |name: &String| Path::new(name).extension().is_some_and(|it| it == "yaml");
        let mut yaml_files: Vec<String> = names.filter(is_yaml).collect();
        yaml_files.sort();
        Self { yaml_files }
    }
}

fn contents(yaml_files: &[String]) -> String {
    if yaml_files.is_empty() {
        return String::new();
    }
    format!("; name a file in it: {}", yaml_files.join(", "))
}

/// Opens a file to be read.
///
/// # Errors
///
/// Besides those of the system: [`Folder`] as one of the kind [`ErrorKind::IsADirectory`], and
/// [`NotRegular`] as one of the kind [`ErrorKind::InvalidInput`].
pub fn open(path: &Path) -> io::Result<File> {
    if was_given(path) {
        return File::open(path);
    }
    // Asked of what was opened, so that nothing else can take its place in between; without waiting for
    // whoever may write into it.
    let flags = OFlags::NONBLOCK.bits().cast_signed();
    let file = OpenOptions::new().read(true).custom_flags(flags).open(path)?;
    let kind = file.metadata()?.file_type();
    if kind.is_dir() {
        return Err(io::Error::new(ErrorKind::IsADirectory, Folder::at(path)));
    }
    if kind.is_file() {
        return Ok(file);
    }
    Err(io::Error::new(ErrorKind::InvalidInput, NotRegular))
}

/// Reads one file of text.
pub fn read_text(path: &Path) -> io::Result<String> {
    let mut text = String::new();
    open(path)?.read_to_string(&mut text)?;
    Ok(text)
}

/// Reads one file of text that has an end soon, such as a certificate.
///
/// # Errors
///
/// [`ErrorKind::FileTooLarge`] if it has more bytes than `most`.
pub fn read_text_of_at_most(most: u64, path: &Path) -> io::Result<String> {
    let mut text = String::new();
    let file = open(path)?;
    if file.take(most + 1).read_to_string(&mut text)? as u64 > most {
        return Err(ErrorKind::FileTooLarge.into());
    }
    Ok(text)
}

/// Whether a path names what this program was started with.
fn was_given(path: &Path) -> bool {
    path == Path::new("/dev/stdin") || path.parent() == Some(Path::new("/dev/fd"))
}

/// Characters that no shell takes for anything else.
const PLAIN: &str = "/._-+=,:@%";

/// A word of a command, in quotes where a shell would take it for something else.
///
/// # Example
///
/// ```
/// use rsrs_files::quoted;
///
/// assert_eq!(quoted("runs/monday_1"), "runs/monday_1");
/// assert_eq!(quoted("runs/first try"), "'runs/first try'");
/// ```
pub fn quoted(word: impl AsRef<Path>) -> String {
    let word = word.as_ref().display().to_string();
    let is_plain = |it: char| it.is_alphanumeric() || PLAIN.contains(it);
    // What begins with a dash would be taken for a flag.
    let word = if word.starts_with('-') { format!("./{word}") } else { word };
    if !word.is_empty() && word.chars().all(is_plain) {
        return word;
    }
    format!("'{}'", word.replace('\'', r"'\''"))
}

#[cfg(test)]
mod tests {
    use std::process::{Command, Stdio};

    use super::*;

    fn refused(path: &Path) -> String {
        let error = read_text(path).expect_err("it is no file");
        assert_eq!(error.kind(), ErrorKind::InvalidInput, "{error}");
        error.to_string()
    }

    #[test]
    fn a_pipe_or_a_device_is_refused_at_once_also_behind_a_link() {
        let folder = tempfile::tempdir().unwrap();
        let (pipe, link) = (folder.path().join("fleet.yaml"), folder.path().join("link.yaml"));
        rustix::fs::mkfifoat(rustix::fs::CWD, &pipe, rustix::fs::Mode::RUSR).unwrap();
        std::os::unix::fs::symlink(&pipe, &link).unwrap();

        for path in [&pipe, &link, Path::new("/dev/zero")] {
            assert_eq!(refused(path), "it is not a regular file", "{}", path.display());
        }
    }

    #[test]
    fn a_file_is_read_and_of_a_folder_the_system_reports_what_it_is() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("fleet.yaml");
        std::fs::write(&file, "robots: []\n").unwrap();

        assert_eq!(read_text(&file).unwrap(), "robots: []\n");
        assert_eq!(read_text(folder.path()).unwrap_err().kind(), ErrorKind::IsADirectory);
        assert_eq!(read_text(&folder.path().join("none")).unwrap_err().kind(), ErrorKind::NotFound);
    }

    #[test]
    fn of_a_file_that_is_larger_than_allowed_no_more_is_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("cert.pem");
        std::fs::write(&path, "1234").unwrap();
        let sparse = folder.path().join("governance.p7s");
        File::create(&sparse).unwrap().set_len(1 << 40).unwrap();

        assert_eq!(read_text_of_at_most(4, &path).unwrap(), "1234");
        for (most, path) in [(3, &path), (1000, &sparse)] {
            let error = read_text_of_at_most(most, path).unwrap_err();
            assert_eq!(error.kind(), ErrorKind::FileTooLarge, "{}", path.display());
        }
    }

    #[test]
    fn a_pipe_that_somebody_writes_into_is_read() {
        let mut child =
            Command::new("echo").arg("robots: []").stdout(Stdio::piped()).spawn().unwrap();
        let pipe = child.stdout.take().unwrap();
        let given = format!("/dev/fd/{}", std::os::fd::AsRawFd::as_raw_fd(&pipe));

        assert_eq!(read_text(Path::new(&given)).unwrap(), "robots: []\n");
        child.wait().unwrap();
    }
}
