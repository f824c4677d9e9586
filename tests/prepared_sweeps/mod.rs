//! A folder with a small sweep: of its four cells one always mills, at (0.15 m/s, 0.75 rad/s), and
//! one never does, at (0.30 m/s, 0.25 rad/s).

use std::path::Path;

use crate::command::{bring, done};

/// Two speeds, one of them far too fast to mill.
pub const SPEEDS: &str = "speed_m_s: [0.15, 0.30]";

/// A folder with the Flockbot's profile and a sweep of it, not yet run.
pub fn workplace(axis: &str, fixed: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    bring("profiles/flockbot.yaml", &folder.path().join("flockbot.yaml"));
    write_sweep(folder.path(), "sweep.yaml", axis, fixed);
    folder
}

/// A sweep over one axis and two turning rates, with something fixed.
pub fn write_sweep(folder: &Path, name: &str, axis: &str, fixed: &str) {
    let sweep = format!(
        "profile: flockbot.yaml\n\
         axes:\n  {axis}\n  turn_rate_rad_s: [0.25, 0.75]\n\
         fixed: {{robots: 9, placement_radius_m: 0.60, arena_m: 15, {fixed}}}\n\
         replicates: 16\nduration_s: 120\nseed: 7\n"
    );
    std::fs::write(folder.join(name), sweep).expect("the folder is writable");
}

/// The folder with the sweep run into `out`.
pub fn swept(axis: &str, fixed: &str) -> tempfile::TempDir {
    let folder = workplace(axis, fixed);
    done(folder.path(), &["sweep", "sweep.yaml", "-o", "out"]);
    folder
}

/// The folder with the cell that mills chosen and confirmed.
pub fn chosen() -> tempfile::TempDir {
    let folder = swept(SPEEDS, "true_positive: 0.8");
    done(folder.path(), &["choose", "out", "--confirm", "200", "-o", "out/choice.json"]);
    folder
}
