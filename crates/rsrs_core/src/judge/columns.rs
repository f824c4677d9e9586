//! Columns that a table of cells has beside those of its phases and axes.

/// The column of the number of runs, before those of phases.
pub const N_COLUMN: &str = "n";

/// The columns behind those of phases: the most frequent one, and the share of the wanted one with its interval.
pub const SHARE_COLUMNS: [&str; 4] = ["phase", "b_s", "b_s_low", "b_s_high"];

/// What the columns of robots as measured begin with.
pub const AS_MEASURED: &str = "as_measured_";

/// The column of the kind of the interval, which is the last.
pub const INTERVAL_COLUMN: &str = "interval";

/// Whether a table of cells has a column of this name beside those of its phases and axes.
pub(crate) fn is_column(name: &str) -> bool {
    let mut names = [N_COLUMN, INTERVAL_COLUMN].into_iter().chain(SHARE_COLUMNS);
    name.starts_with(AS_MEASURED) || names.any(|column| column == name)
}
