//! A folder to begin with, in words.

use rsrs_files::quoted;
use rsrs_pipeline::init::Begun;

/// What was written, and what comes next; `given_arena_m` is the side of the floor, if it was given.
pub fn text(begun: &Begun, given_arena_m: Option<f64>) -> String {
    let arena = match given_arena_m {
        Some(_) => "",
        None => ", so large that no robot comes to its walls; give yours with `--arena`",
    };
    format!(
        "{}: {}\narena of {} m{arena}; robots start in a disc of {} m radius\nnext: cd {} && rsrs sweep sweep.yaml -o results\nthen: rsrs choose results -o \
         results/choice.json && rsrs run experiment.yaml --from results -o run_1",
        begun.folder.display(),
        begun.files.join(", "),
        begun.arena_m,
        begun.placement_radius_m,
        quoted(&begun.folder)
    )
}
