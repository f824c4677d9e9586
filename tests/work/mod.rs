//! A folder in which sweeps are run, interrupted and compared.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use crate::command::{bring, done, rsrs};

/// The program.
pub const RSRS: &str = env!("CARGO_BIN_EXE_rsrs");

/// A folder with the Flockbot's profile and a sweep of it.
pub struct SweepFolder {
    folder: tempfile::TempDir,
}

impl SweepFolder {
    /// Four cells in two worlds with so many replicates of 60 s: 2,048 are a block.
    pub fn with_sweep(replicates: u64) -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder");
        bring("profiles/flockbot.yaml", &folder.path().join("flockbot.yaml"));
        let sweep = format!(
            "profile: flockbot.yaml\n\
             axes:\n  speed_m_s: [0.15, 0.30]\n  turn_rate_rad_s: [0.25, 0.75]\n\
             fixed: {{robots: 9, placement_radius_m: 0.60, arena_m: 15}}\n\
             replicates: {replicates}\nduration_s: 60\nseed: 7\n"
        );
        std::fs::write(folder.path().join("sweep.yaml"), sweep).expect("the folder is writable");
        Self { folder }
    }

    /// The folder.
    pub fn folder(&self) -> &Path {
        self.folder.path()
    }

    /// Something in the folder.
    pub fn path(&self, name: &str) -> PathBuf {
        self.folder().join(name)
    }

    /// The names of all that is in the folder, sorted.
    pub fn entries(&self) -> Vec<String> {
        let entries = std::fs::read_dir(self.folder()).expect("the folder is there");
        let name = |entry: std::io::Result<std::fs::DirEntry>| {
            entry.expect("the folder is readable").file_name().to_string_lossy().into_owned()
        };
        let mut names: Vec<String> = entries.map(name).collect();
        names.sort();
        names
    }

    /// Runs the program to its end.
    pub fn rsrs(&self, arguments: &[&str]) -> Output {
        rsrs(self.folder(), arguments)
    }

    /// Starts the program.
    pub fn spawn(&self, arguments: &[&str]) -> Child {
        Command::new(RSRS)
            .args(arguments)
            .current_dir(self.folder())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the binary was built for this test")
    }

    /// Runs the sweep to its end.
    pub fn sweep_into(&self, folder: &str) {
        done(self.folder(), &["sweep", "sweep.yaml", "-o", folder]);
    }

    /// Starts the sweep and kills it as soon as it has kept so many blocks.
    pub fn interrupt(&self, folder: &str, n_blocks: usize) {
        let mut child = self.spawn(&["sweep", "sweep.yaml", "-o", folder, "--threads", "1"]);
        self.wait_for_blocks(folder, n_blocks);
        child.kill().expect("the child can be killed");
        child.wait().expect("the child ends");
    }

    /// Waits until a sweep has kept so many blocks.
    pub fn wait_for_blocks(&self, folder: &str, n_blocks: usize) {
        let begun = Instant::now();
        while self.blocks(folder).len() < n_blocks {
            assert!(begun.elapsed() < Duration::from_secs(120), "no block after two minutes");
            std::thread::sleep(Duration::from_millis(1));
        }
    }

    /// The files of the blocks that a sweep has kept, in their order.
    pub fn blocks(&self, folder: &str) -> Vec<PathBuf> {
        let Ok(entries) = std::fs::read_dir(self.path(folder).join("unfinished")) else {
            return Vec::new();
        };
        let paths = entries.map(|entry| entry.expect("the folder is readable").path());
        let is_block = |path: &PathBuf| {
            let name = path.file_name().expect("an entry has a name").to_string_lossy();
            name.starts_with("block_") && path.extension().is_none()
        };
        let mut blocks: Vec<PathBuf> = paths.filter(is_block).collect();
        blocks.sort();
        blocks
    }

    /// Copies a sweep file with something else in it.
    pub fn change(&self, from: &str, to: &str, old: &str, new: &str) {
        let text = std::fs::read_to_string(self.path(from)).expect("the sweep was written");
        assert!(text.contains(old), "no `{old}` in {text}");
        std::fs::write(self.path(to), text.replace(old, new)).expect("the folder is writable");
    }
}

/// Every file of a folder, with its bytes.
pub fn contents(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let entries = std::fs::read_dir(folder).expect("the folder is there");
    let file = |entry: std::io::Result<std::fs::DirEntry>| {
        let entry = entry.expect("the folder is readable");
        (entry.file_name().to_string_lossy().into_owned(), bytes(&entry.path()))
    };
    entries.map(file).collect()
}

/// The bytes of a file.
pub fn bytes(path: &Path) -> Vec<u8> {
    std::fs::read(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}
