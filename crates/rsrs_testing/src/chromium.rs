//! A browser, for tests of pages.

use std::path::PathBuf;
use std::process::Command;

/// The system's Chromium, installed if this machine lacks it and may.
///
/// # Panics
///
/// If there is none and it cannot be installed.
pub fn chromium() -> PathBuf {
    let find = || {
        let path = std::env::var_os("PATH").unwrap_or_default();
        let names = ["chromium", "chromium-browser", "google-chrome"];
        std::env::split_paths(&path)
            .flat_map(|folder| names.map(|name| folder.join(name)))
            .find(|file| file.is_file())
    };
    find().unwrap_or_else(|| {
        // Others may be installing something.
        let install = [
            "-o",
            "DPkg::Lock::Timeout=600",
            "install",
            "-y",
            "-qq",
            "--no-install-recommends",
            "chromium",
        ];
        let mut apt = Command::new("apt-get");
        let installed = apt.args(install).env("DEBIAN_FRONTEND", "noninteractive").output();
        find().unwrap_or_else(|| {
            panic!(
                "this test needs Chromium, and could not install it: `apt-get install chromium`: \
                 {installed:?}"
            )
        })
    })
}
