//! What can be an axis, as a table for a terminal and as one for the reference.

use std::fmt::Write;

use rsrs_core::quantity::Axis;

use crate::columns::columns;

/// What can be an axis: key, unit, what it is, and whether a fleet can be set to it.
pub fn table() -> String {
    let row = |axis: Axis| {
        let unit = match axis.unit() {
            "" => "share or factor",
            unit => unit,
        };
        let kind = if axis.is_capability() { "capability of the robots" } else { "setting" };
        [axis.key(), unit, axis.name(), kind].map(str::to_owned)
    };
    columns(&Axis::ALL.map(row))
}

/// A section of the reference: the axes, which are the same wherever a file names some.
pub(crate) fn section(page: &mut String) {
    page.push_str(
        "\n## Axes\n\nThe keys of `axes`, `fixed` and `cell`, also on the command line \
         (`--cell speed_m_s=0.15,turn_rate_rad_s=0.75`); settings can be set on a real fleet, \
         capabilities are what robots are.\n\
         In `fixed` and `cell` an axis has one number, in `axes` a list (`[0.1, 0.2]`) or values at \
         equal distances, both ends included (`{from: 0.05, to: 0.3, steps: 6}`).\n\n| key | meaning | |\n|---|---|---|\n",
    );
    for axis in Axis::ALL {
        let kind = if axis.is_capability() { "capability" } else { "setting" };
        writeln!(page, "| `{}` | {} | {kind} |", axis.key(), axis.label())
            .expect("a text takes whatever is written to it");
    }
    page.push_str(
        "| `controller.NAME` | number `NAME` of the controller's table ([controllers.md](controllers.md)) | setting |\n",
    );
}
