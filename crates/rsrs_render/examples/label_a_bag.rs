//! Names the phase of a recorded swarm with the reasons for it, and draws the run.
//!
//! `cargo run --release -p rsrs_render --example label_a_bag -- BAG PICTURE.svg`

#![expect(clippy::print_stdout, reason = "prints its result")]

use std::path::Path;

use rsrs_pipeline::label::{LabelOptions, label_bag};
use rsrs_render::{label::text, recorded_run::svg};
use rsrs_view::theme::Theme;

fn main() -> anyhow::Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [bag, picture] = &arguments[..] else { anyhow::bail!("BAG PICTURE.svg") };
    let (bag, options) = (Path::new(bag), LabelOptions::default());

    println!("{}", text(&label_bag(bag, options)?));
    std::fs::write(picture, svg(bag, options, Theme::Screen)?)?;
    Ok(())
}
