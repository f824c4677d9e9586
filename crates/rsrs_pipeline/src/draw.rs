//! A recorded run as a picture and as a film.

use std::path::Path;

use anyhow::Context;
use rsrs_bags::trajectory::RecordedTrajectory;
use rsrs_core::judge::order::OrderParameters;
use rsrs_core::judge::phase::{BLOCK_S, WINDOW_S, samples_in};
use rsrs_core::judge::rule::Rules;
use rsrs_core::judge::trajectory::Bodies;
use rsrs_core::robot::pose_source::PoseSource;
use rsrs_view::film::{Film, Kind, film as encode};
use rsrs_view::order_over_time::{OrderPicture, RunPicture, svg as run_svg};
use rsrs_view::trajectory::TrajectoryPicture;

use crate::error::with_help;
use crate::label::{LabelOptions, Labelled, judge};

/// Radius of robots whose radius is not in the bag, in metres.
const SOME_RADIUS_M: f64 = 0.05;
/// For how long the way that a robot came is shown in a film, in seconds.
const TAIL_S: f64 = 20.0;

/// A recorded run that was judged, and what pictures of it share.
pub(crate) struct JudgedRun {
    /// Its label.
    pub labelled: Labelled,
    /// What the robots did.
    pub recorded: RecordedTrajectory,
    bodies: Bodies,
}

impl JudgedRun {
    /// Reads and judges a bag.
    ///
    /// # Errors
    ///
    /// As [`judge`].
    pub fn read(bag: &Path, options: LabelOptions) -> anyhow::Result<Self> {
        let (labelled, recorded, bodies) = judge(bag, options)?;
        Ok(Self { labelled, recorded, bodies })
    }

    /// The run from above, with the rows of robots that were lost.
    pub fn above<'a>(&'a self, lost: &'a [usize]) -> TrajectoryPicture<'a> {
        let trajectory = &self.recorded.trajectory;
        let phase = self.labelled.phase;
        let (n_robots, duration_s) = (trajectory.n_robots, trajectory.duration_s());
        TrajectoryPicture {
            trajectory,
            radius_m: self.radius_m(),
            tail_s: WINDOW_S,
            phase: Some(phase),
            lost,
            title: title(&self.labelled.bag),
            subtitle: format!(
                "{n_robots} robots, {duration_s:.0} s; {}",
                self.labelled.phase_in_words()
            ),
        }
    }

    /// Its order parameters.
    ///
    /// # Arguments
    ///
    /// * `blocks` — those of [`Self::blocks`].
    /// * `rules` — those of [`Self::rules`].
    pub fn order<'a>(
        &self,
        blocks: &'a [(f64, OrderParameters)],
        rules: &'a Rules,
        notes: &'a [String],
    ) -> OrderPicture<'a> {
        let duration_s = self.recorded.trajectory.duration_s();
        OrderPicture {
            blocks,
            block_s: BLOCK_S,
            duration_s,
            window_start_s: duration_s - WINDOW_S,
            rules,
            notes,
        }
    }

    /// The order parameters of every block.
    pub fn blocks(&self) -> Vec<(f64, OrderParameters)> {
        let trajectory = &self.recorded.trajectory;
        let n_block = samples_in(BLOCK_S, trajectory.period_s);
        let block = |number: usize| {
            let samples = number * n_block..(number + 1) * n_block;
            let start_s = samples.start as f64 * trajectory.period_s;
            (start_s, OrderParameters::of(trajectory, samples, &self.bodies))
        };
        (0..trajectory.n_samples() / n_block).map(block).collect()
    }

    /// The rules of its behaviour.
    pub fn rules(&self) -> Rules {
        self.labelled.phase.behaviour().rules()
    }

    /// The rows of robots that did not take part to the end.
    pub fn lost_rows(&self) -> Vec<usize> {
        self.labelled.lost_rows(&self.recorded.robots)
    }

    fn radius_m(&self) -> f64 {
        self.bodies.radius_m.unwrap_or(SOME_RADIUS_M)
    }
}

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
    let run = JudgedRun::read(bag, options)?;
    let labelled = &run.labelled;
    let mut notes = vec![format!("label: {}", labelled.phase_in_words())];
    notes.extend(labelled.why.iter().cloned());
    notes.extend(labelled.lost_robots.iter().map(ToString::to_string));
    notes.extend(labelled.paused_robots.iter().map(ToString::to_string));
    let (lost, blocks, rules) = (run.lost_rows(), run.blocks(), run.rules());
    let run_order = run.order(&blocks, &rules, &notes);
    let picture = RunPicture { run: run.above(&lost), order: run_order };
    run_svg(&picture).with_context(|| bag.display().to_string())
}

fn title(bag: &Path) -> String {
    bag.file_stem().unwrap_or_default().to_string_lossy().into_owned()
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
    /// Where poses come from; `None` takes the source by which the run went.
    pub poses: Option<PoseSource>,
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
    let judged = LabelOptions { poses: options.poses, ..LabelOptions::default() };
    let run = JudgedRun::read(bag, judged)?;
    let film = Film {
        trajectory: &run.recorded.trajectory,
        radius_m: run.radius_m(),
        title: format!("{}: {}", title(bag), run.labelled.phase_in_words()),
        speed: options.speed,
        frames_per_s: options.frames_per_s,
        tail_s: TAIL_S,
        width_px: options.width_px,
        lost: &run.lost_rows(),
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
