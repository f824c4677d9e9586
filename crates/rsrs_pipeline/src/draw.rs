//! A recorded run as a picture and as a film.

use std::path::Path;

use anyhow::Context;
use rsrs_core::judge::order::OrderParameters;
use rsrs_core::judge::phase::{BLOCK_S, WINDOW_S, samples_in};
use rsrs_core::judge::trajectory::{Bodies, Trajectory};
use rsrs_view::film::{Film, Kind, film as encode};
use rsrs_view::order_over_time::{RunPicture, svg as run_svg};
use rsrs_view::trajectory::TrajectoryPicture;

use crate::error::with_help;
use crate::label::{LabelOptions, Labelled, judge};

/// Radius of robots that a bag tells nothing of, in metres.
const SOME_RADIUS_M: f64 = 0.05;
/// For how long the way that a robot came is shown in a film, in seconds.
const TAIL_S: f64 = 20.0;

/// Draws a run from above, with its order parameters over time and why it has its phase.
///
/// # Returns
///
/// The picture as SVG.
///
/// # Errors
///
/// As [`judge`].
pub fn svg(bag: &Path, options: LabelOptions) -> anyhow::Result<String> {
    let (labelled, recorded, bodies) = judge(bag, options)?;
    let trajectory = &recorded.trajectory;
    let mut notes = vec![format!("label: {}", labelled.phase_in_words())];
    notes.extend(labelled.why.iter().cloned());
    notes.extend(labelled.lost_robots.iter().map(ToString::to_string));
    let run = TrajectoryPicture {
        trajectory,
        radius_m: bodies.radius_m.unwrap_or(SOME_RADIUS_M),
        tail_s: WINDOW_S,
        phase: Some(labelled.phase),
        lost: &labelled.lost_rows(&recorded.robots),
        title: title(bag),
        subtitle: subtitle(&labelled, trajectory),
    };
    let picture = RunPicture {
        run,
        blocks: &blocks(trajectory, &bodies),
        block_s: BLOCK_S,
        window_start_s: trajectory.duration_s() - WINDOW_S,
        rules: &labelled.phase.behaviour().rules(),
        notes: &notes,
    };
    run_svg(&picture).with_context(|| bag.display().to_string())
}

fn title(bag: &Path) -> String {
    bag.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

fn subtitle(labelled: &Labelled, trajectory: &Trajectory) -> String {
    format!("{} robots, {:.0} s; {}", trajectory.n_robots, trajectory.duration_s(), labelled.phase)
}

/// The order parameters of every block of a run.
fn blocks(trajectory: &Trajectory, bodies: &Bodies) -> Vec<(f64, OrderParameters)> {
    let n_block = samples_in(BLOCK_S, trajectory.period_s);
    let block = |number: usize| {
        let samples = number * n_block..(number + 1) * n_block;
        let start_s = samples.start as f64 * trajectory.period_s;
        (start_s, OrderParameters::of(trajectory, samples, bodies))
    };
    (0..trajectory.n_samples() / n_block).map(block).collect()
}

/// How a film shows a run.
#[derive(Clone, Copy, Debug)]
pub struct FilmOptions {
    /// How many seconds of the run pass in one of the film.
    pub speed: f64,
    /// Frames in a second.
    pub frames_per_s: u32,
    /// Width of the film, in pixels.
    pub width_px: u32,
}

/// Makes a film of a run.
///
/// # Arguments
///
/// * `path` — of the film; its extension selects the format: `gif`, or `png` and `apng` for an
///   animated PNG.
/// * `show` — called with the number of frames that are done, and that of all; the film is called off
///   once it returns false.
///
/// # Returns
///
/// The bytes of the film.
///
/// # Errors
///
/// As [`judge`], and if a number is out of range, the extension is another, or it is called off.
pub fn film(
    bag: &Path,
    path: &Path,
    options: FilmOptions,
    show: &dyn Fn(usize, usize) -> bool,
) -> anyhow::Result<Vec<u8>> {
    let kind = kind(path)?;
    let (labelled, recorded, bodies) = judge(bag, LabelOptions::default())?;
    let film = Film {
        trajectory: &recorded.trajectory,
        radius_m: bodies.radius_m.unwrap_or(SOME_RADIUS_M),
        title: format!("{}: {}", title(bag), labelled.phase),
        speed: options.speed,
        frames_per_s: options.frames_per_s,
        tail_s: TAIL_S,
        width_px: options.width_px,
        lost: &labelled.lost_rows(&recorded.robots),
    };
    let n_frames = film.n_frames();
    let bytes = encode(&film, kind, &|done| show(done, n_frames))?;
    bytes.ok_or_else(|| with_help("called off; nothing was written", "run the same command again"))
}

fn kind(path: &Path) -> anyhow::Result<Kind> {
    match path.extension().and_then(|ending| ending.to_str()) {
        Some("gif") => Ok(Kind::Gif),
        Some("png" | "apng") => Ok(Kind::Apng),
        _ => Err(with_help(
            format!("{} ends in none of .gif, .png and .apng", path.display()),
            "name the film `-o run.gif`, or `-o run.png` for an animated PNG",
        )),
    }
}
