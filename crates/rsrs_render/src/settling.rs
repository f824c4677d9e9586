//! Whether cells are settled, in words.

use std::path::Path;

use rsrs_core::diagram::folder::SWEEP;
use rsrs_core::diagram::settling::Settling;
use rsrs_core::judge::behaviour::Behaviour;
use rsrs_pipeline::sweep::settling::Unsettled;

/// Whether a cell is settled, in words.
pub fn text(settling: &Settling) -> String {
    let Settling { n_replicates, n_changed, from_s } = settling;
    let changes = format!(
        "{n_changed} of {n_replicates} runs change their phase in the last third, after {from_s:.0} s"
    );
    if settling.is_settled() {
        return format!("settled: {changes}");
    }
    format!("not settled: {changes}; with a longer `duration_s`, B_s may be another")
}

/// The note on a sweep of whose cells [`at_edge`](rsrs_pipeline::sweep::settling::at_edge) found
/// some that are not settled.
pub fn warning(
    (folder, behaviour): (&Path, Behaviour),
    n_edge: usize,
    unsettled: &[Unsettled],
) -> Option<String> {
    let wanted = behaviour.key().replace('_', " ");
    let worst = unsettled.iter().max_by_key(|cell| cell.settling.n_changed)?;
    let Settling { n_replicates, n_changed, from_s } = worst.settling;
    Some(format!(
        "{} of {n_edge} cells at the edge of the {wanted} region are not settled: of {}, {n_changed} of \
         {n_replicates} runs change their phase after {from_s:.0} s; before you rely on the edge, sweep \
         {} with a longer `duration_s`",
        unsettled.len(),
        worst.cell,
        folder.join(SWEEP).display()
    ))
}
