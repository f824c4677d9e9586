//! Sweeps a file into a folder and chooses its most robust cell.
//!
//! `cargo run --release -p rsrs_pipeline --example sweep_and_choose -- SWEEP.yaml FOLDER`

#![expect(clippy::print_stdout, reason = "prints its result")]

use std::path::Path;

use rsrs_pipeline::choose::{CONFIRM, Chosen, SearchOptions, choose};
use rsrs_pipeline::execution::Execution;
use rsrs_pipeline::sweep;
use rsrs_pipeline::sweep::source::ResolvedSweep;

fn main() -> anyhow::Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [file, folder] = &arguments[..] else { anyhow::bail!("SWEEP.yaml FOLDER") };
    let (folder, execution) = (Path::new(folder), Execution::unobserved());

    let source = ResolvedSweep::read(Path::new(file))?;
    // `rsrs_render::picture::into_folder` in this place draws the diagram.
    sweep::sweep_into(folder, file, source, execution, |_, _| Ok(()))?;
    let options = SearchOptions { robots: None, wanted: 0.8, confirm: CONFIRM, execution };
    match choose(folder, options)? {
        Chosen::Viable(choice) => println!("{}: {:.2} of fresh runs", choice.cell, choice.b_s),
        Chosen::NoViableCell(none) => println!("no viable cell; the best is {}", none.best.cell),
    }
    Ok(())
}
