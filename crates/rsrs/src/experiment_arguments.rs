//! An experiment and the cell of a sweep, given on the command line.

use std::path::PathBuf;

use rsrs_core::quantity::Cell;

/// What is run, or where its robots are placed.
#[derive(clap::Args)]
pub struct ExperimentArguments {
    /// Experiment file (YAML).
    pub experiment: PathBuf,
    /// Folder of a sweep: take its chosen cell, or the one of it that `--cell` names.
    #[arg(long, value_name = "DIR")]
    pub from: Option<PathBuf>,
    /// Cell to take, as AXIS=VALUE,…; where the experiment file has `from`, only with `--from`.
    #[arg(long)]
    pub cell: Option<Cell>,
}
