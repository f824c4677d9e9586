//! Where ROS 2 keeps the files of a package.

use std::io;
use std::path::{Path, PathBuf};

use super::TypeName;

/// How deep packages lie below a workspace, at most; repositories of repositories are rare.
const MAX_DEPTH: usize = 6;

/// Folders without sources, which may be large.
const SKIPPED: [&str; 3] = ["build", "log", "target"];

/// The file with a type's definition, if it is in the folder. What lies below the folder and is
/// closed to us is passed over.
pub fn file_of(folder: &Path, type_name: &TypeName) -> io::Result<Option<PathBuf>> {
    let file = type_name.file();
    let installed = Path::new(&type_name.package).join("share").join(&file);
    let direct = [
        folder.join(&file),
        folder.join("share").join(&file),
        folder.join(&installed),
        folder.join("install").join(&installed),
        folder.join("install/share").join(&file),
    ];
    if let Some(found) = direct.into_iter().find(|path| path.is_file()) {
        return Ok(Some(found));
    }
    // The package itself.
    let own = folder.join("msg").join(format!("{}.msg", type_name.name));
    let is_package = folder.file_name().is_some_and(|name| *name == *type_name.package);
    if is_package && own.is_file() {
        return Ok(Some(own));
    }
    below(folder, &file, MAX_DEPTH)
}

/// Looks for the package in the folders of a folder, in order of their names.
fn below(folder: &Path, file: &str, depth: usize) -> io::Result<Option<PathBuf>> {
    if depth == 0 {
        return Ok(None);
    }
    let mut folders = Vec::new();
    for entry in folder.read_dir()? {
        let entry = entry?;
        let name = entry.file_name();
        let skipped =
            name.to_str().is_some_and(|name| SKIPPED.contains(&name) || name.starts_with('.'));
        // Not through links, which may lead in circles.
        if entry.file_type()?.is_dir() && !skipped {
            folders.push(entry.path());
        }
    }
    folders.sort();
    for folder in folders {
        let path = folder.join(file);
        if path.is_file() {
            return Ok(Some(path));
        }
        match below(&folder, file, depth - 1) {
            Ok(None) => {}
            Err(error) if error.kind() == io::ErrorKind::PermissionDenied => {}
            found => return found,
        }
    }
    Ok(None)
}
