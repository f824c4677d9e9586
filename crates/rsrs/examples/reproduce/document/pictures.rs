//! The pictures of the document.

use std::path::Path;

use anyhow::Context;
use rsrs_core::diagram::axis::{Axis, Cell};
use rsrs_core::judge::phase::Phase;
use rsrs_view::diagram::{DiagramPicture, ExperimentMark};
use rsrs_view::raster::png;
use rsrs_view::trajectory::TrajectoryPicture;

use crate::experiments::{DURATION_S, cell};
use crate::findings::Findings;
use crate::swept::REPLICATES;

/// Sharp in print across a column.
const WIDTH_PX: u32 = 1600;

/// Draws all pictures.
///
/// # Errors
///
/// If one cannot be drawn or written.
pub fn draw(findings: &Findings, folder: &Path) -> anyhow::Result<()> {
    write(&folder.join("diagram.png"), &diagram(findings)?)?;
    write(&folder.join("mill.png"), &mill(findings)?)
}

fn write(path: &Path, svg: &str) -> anyhow::Result<()> {
    std::fs::write(path, png(svg, WIDTH_PX)?).with_context(|| path.display().to_string())
}

fn diagram(findings: &Findings) -> anyhow::Result<String> {
    let value = |name: &str| findings.choice["cell"][name].as_f64();
    let chosen = value("speed_m_s")
        .zip(value("turn_rate_rad_s"))
        .map(|(speed, rate)| Cell::new([(Axis::Speed, speed), (Axis::TurnRate, rate)]))
        .transpose()?;
    let mark = |experiment: &crate::findings::Experiment| ExperimentMark {
        cell: cell(experiment.setting),
        phase: experiment.phase,
        n: 1,
    };
    let experiments: Vec<ExperimentMark> = findings.experiments.iter().map(mark).collect();
    Ok(rsrs_view::diagram::svg(&DiagramPicture {
        diagram: &findings.plane,
        x: Axis::Speed,
        y: Some(Axis::TurnRate),
        at: &[],
        title: "Nine simulated Flockbots, and nine experiments".to_owned(),
        subtitle: format!("N = 9, {DURATION_S} s, {REPLICATES} replicates per cell, sees bodies"),
        chosen: chosen.as_ref(),
        boundaries: &[],
        experiments: &experiments,
        note: Some("the experiments ran on a stand-in for the real floor".to_owned()),
    })?)
}

fn mill(findings: &Findings) -> anyhow::Result<String> {
    let (trajectory, _) = &findings.mill;
    Ok(rsrs_view::trajectory::svg(&TrajectoryPicture {
        trajectory,
        radius_m: findings.measured.body.radius_m,
        tail_s: 60.0,
        phase: Some(Phase::StableMilling),
        title: "0.15 m/s, 0.75 rad/s on the stand-in's floor".to_owned(),
        subtitle: "the last 60 s drawn strongly".to_owned(),
    })?)
}
