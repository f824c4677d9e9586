//! The files that a newcomer starts from; they travel in the binary.

use std::path::{Path, PathBuf};

use anyhow::Context;

use rsrs_pipeline::error::with_help;
use rsrs_pipeline::files::write_file;

/// The sweep, below the folder of the files.
const SWEEP: &str = "sweeps/flockbot_speed_turn.yaml";
/// The experiment, below the folder of the files.
const EXPERIMENT: &str = "experiments/flockbot_milling.yaml";

/// Every file with its text; they name each other by these relative paths.
const FILES: [(&str, &str); 4] = [
    ("profiles/flockbot.yaml", include_str!("../../../launch_configs/profiles/flockbot.yaml")),
    (SWEEP, include_str!("../../../launch_configs/sweeps/flockbot_speed_turn.yaml")),
    ("fleets/nine_virtual.yaml", include_str!("../../../launch_configs/fleets/nine_virtual.yaml")),
    (EXPERIMENT, include_str!("../../../launch_configs/experiments/flockbot_milling.yaml")),
];

/// Where the files are.
#[derive(Clone, Debug)]
pub struct StarterFiles {
    pub sweep: PathBuf,
    /// One experiment with the fleet.
    pub experiment: PathBuf,
}

impl StarterFiles {
    /// Those of a folder that `rsrs init` has made.
    pub fn in_folder(folder: &Path) -> anyhow::Result<Self> {
        let file = |name: &str| {
            let path = folder.join(name);
            if path.is_file() {
                return Ok(path);
            }
            Err(with_help(
                format!("{} is missing", path.display()),
                "name a folder as `rsrs init` makes it, or none, for nine Flockbots",
            ))
        };
        Ok(Self { sweep: file("sweep.yaml")?, experiment: file("experiment.yaml")? })
    }

    pub fn write(folder: &Path) -> anyhow::Result<Self> {
        for (name, text) in FILES {
            let path = folder.join(name);
            let parent = path.parent().expect("every file is in a folder");
            std::fs::create_dir_all(parent)
                .with_context(|| format!("cannot make {}", parent.display()))?;
            write_file(&path, text.as_bytes())?;
        }
        Ok(Self { sweep: folder.join(SWEEP), experiment: folder.join(EXPERIMENT) })
    }
}
