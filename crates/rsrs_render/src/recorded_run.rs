//! A recorded run as a picture and as a film.

use std::path::{Path, PathBuf};

use anyhow::Context;
use rsrs_bags::trajectory::RecordedTrajectory;
use rsrs_core::judge::behaviour::Behaviour;
use rsrs_core::judge::behaviour::rule::Rules;
use rsrs_core::judge::order::OrderParameters;
use rsrs_core::judge::phase::judged_samples;
use rsrs_core::judge::window::{BLOCK_S, Window, samples_in};
use rsrs_core::numerals::counted;
use rsrs_core::robot::controller::Controller;
use rsrs_core::robot::pose_source::PoseSource;
use rsrs_fleet::observation::order_of;
use rsrs_fleet::record::Backend;
use rsrs_pipeline::error::with_help;
use rsrs_pipeline::label::{LabelOptions, Labelled, NoLabel, ReadRun, read_run};
use rsrs_view::film::{Film, Kind, film as encode};
use rsrs_view::order_over_time::{OrderPicture, RunPicture, svg as run_svg};
use rsrs_view::theme::Theme;
use rsrs_view::trajectory::TrajectoryPicture;

use crate::label::{human, none, phase_of};

/// Radius of robots whose radius is not in the bag, in metres.
const SOME_RADIUS_M: f64 = 0.05;
/// How often the phase of a film is looked at, in seconds.
const PHASE_PERIOD_S: f64 = 2.0;
/// For how long the way that a robot came is shown in a film, in seconds.
const TAIL_S: f64 = 20.0;

/// A recorded run, judged if it can be, and what pictures of it share.
pub(crate) struct DrawnRun {
    bag: PathBuf,
    run: ReadRun,
}

impl DrawnRun {
    /// Reads a bag, and judges it if it can be.
    pub fn read(bag: &Path, options: LabelOptions) -> anyhow::Result<Self> {
        Ok(Self { bag: bag.to_path_buf(), run: read_run(bag, options)? })
    }

    /// What the robots did.
    pub fn recorded(&self) -> &RecordedTrajectory {
        &self.run.recorded
    }

    /// Its label, if it has one.
    pub fn labelled(&self) -> Option<&Labelled> {
        self.run.label.as_ref().ok()
    }

    /// Its label in words, or why it has none.
    pub fn label_in_words(&self) -> String {
        match &self.run.label {
            Ok(labelled) => phase_of(labelled).to_string(),
            Err(why) => none(why),
        }
    }

    /// The run from above, with the rows of robots that were lost.
    pub fn above<'a>(&'a self, lost: &'a [usize], theme: Theme) -> TrajectoryPicture<'a> {
        let trajectory = &self.run.recorded.trajectory;
        let (n_robots, duration_s) = (trajectory.n_robots, trajectory.duration_s());
        let robots = counted(n_robots as u64, "robot");
        let simulated = self.simulated().map_or_else(String::new, |mark| format!(", {mark}"));
        let label = self.label_in_words();
        let judged = self.run.behaviour.window().at_the_moment();
        TrajectoryPicture {
            trajectory,
            radius_m: self.radius_m(),
            tail_s: judged.reaches_back_s().min(duration_s),
            phase: self.labelled().map(|labelled| labelled.phase),
            lost,
            names: &self.run.recorded.robots,
            walls_m: self.run.walls_m,
            world: Some(&self.run.bodies.world),
            classes: &self.run.bodies.classes,
            title: title(&self.bag),
            subtitle: format!(
                "{robots}, {duration_s:.0} s{simulated}; {label}{}",
                self.judged_and_controlled()
            ),
            theme,
        }
    }

    /// What the run is judged for, if that is not milling, and what the robots decided by, if that is not the
    /// controller of the paper.
    fn judged_and_controlled(&self) -> String {
        let ReadRun { behaviour, controller, .. } = &self.run;
        let judged = (*behaviour != Behaviour::MILLING)
            .then(|| format!("; judged for {}", behaviour.noun()));
        let is_mirrored =
            |it: &Controller| it.parameters().is_some_and(|it| it.undetected.is_none());
        let controlled = (controller.as_ref().filter(|it| !is_mirrored(it)))
            .map(|controller| format!("; controller: {controller}"));
        judged.into_iter().chain(controlled).collect()
    }

    /// That the robots were simulated, if any was.
    fn simulated(&self) -> Option<&'static str> {
        self.run.backend.and_then(Backend::mark)
    }

    /// Its order parameters, with its [`Self::blocks`] and [`Self::rules`].
    pub fn order<'a>(
        &self,
        blocks: &'a [(f64, OrderParameters)],
        rules: &'a Rules,
        notes: &'a [String],
    ) -> OrderPicture<'a> {
        let duration_s = self.run.recorded.trajectory.duration_s();
        OrderPicture {
            blocks,
            block_s: BLOCK_S,
            duration_s,
            judged_s: self.judged_s(rules),
            rules,
            notes,
        }
    }

    /// The time that decided; nothing without a label.
    fn judged_s(&self, rules: &Rules) -> [f64; 2] {
        let trajectory = &self.run.recorded.trajectory;
        if self.run.label.is_err() {
            return [trajectory.duration_s(); 2];
        }
        let duration_s = trajectory.duration_s();
        if rules.window != Window::Ever {
            return [(duration_s - rules.window.reaches_back_s()).max(0.0), duration_s];
        }
        let samples = judged_samples(trajectory, &self.run.bodies, rules);
        [samples.start, samples.end].map(|sample| sample as f64 * trajectory.period_s)
    }

    /// The order parameters of every block.
    pub fn blocks(&self) -> Vec<(f64, OrderParameters)> {
        let trajectory = &self.run.recorded.trajectory;
        let n_block = samples_in(BLOCK_S, trajectory.period_s);
        let asked = self.rules().asked();
        let block = |number: usize| {
            let samples = number * n_block..(number + 1) * n_block;
            let start_s = samples.start as f64 * trajectory.period_s;
            (start_s, OrderParameters::with(trajectory, samples, &self.run.bodies, &asked))
        };
        (0..trajectory.n_samples() / n_block).map(block).collect()
    }

    /// The rules of its behaviour.
    pub fn rules(&self) -> Rules {
        self.run.behaviour.rules()
    }

    /// The rows of robots that did not take part to the end.
    pub fn lost_rows(&self) -> Vec<usize> {
        self.run.lost_rows()
    }

    /// From when on the swarm is in which phase: what the judge would find then, looked at
    /// every few seconds.
    fn phases(&self) -> Vec<(f64, String)> {
        let ReadRun { recorded, bodies, behaviour, .. } = &self.run;
        let trajectory = &recorded.trajectory;
        if bodies.reach_m.is_none() {
            return vec![(0.0, "no phase: how far a robot senses another is not known".to_owned())];
        }
        if let Err(why @ (NoLabel::Judge(_) | NoLabel::Objects(_))) = &self.run.label
            && behaviour.rules().asked().iter().any(|it| it.lacks(bodies).is_some())
        {
            return vec![(0.0, none(why))];
        }
        let n_period = samples_in(PHASE_PERIOD_S, trajectory.period_s);
        let n_periods = trajectory.n_samples() / n_period;
        let phase = |n_samples: usize| {
            let order = order_of(trajectory, n_samples, bodies, *behaviour)?;
            let words = if order.is_whole() {
                order.phase.to_string()
            } else {
                let least_s = behaviour.window().least_s();
                format!("so far: {} ({:.0} s of {least_s:.0})", order.phase, order.over_s)
            };
            Some((n_samples as f64 * trajectory.period_s, words))
        };
        (1..=n_periods).filter_map(|periods| phase(periods * n_period)).collect()
    }

    fn radius_m(&self) -> f64 {
        self.run.bodies.radius_m.unwrap_or(SOME_RADIUS_M)
    }
}

/// Draws a run from above as SVG, with its order parameters over time and why it has its phase, or
/// none.
pub fn svg(bag: &Path, options: LabelOptions, theme: Theme) -> anyhow::Result<String> {
    let run = DrawnRun::read(bag, options)?;
    // The label itself is above the run.
    let mut notes: Vec<String> =
        run.labelled().into_iter().flat_map(|labelled| labelled.why.iter().cloned()).collect();
    notes.extend(run.run.labels.iter().map(|label| format!("label: {}", human(label))));
    notes.extend(run.run.lost_robots.iter().map(ToString::to_string));
    let paused = run.labelled().into_iter().flat_map(|labelled| &labelled.paused_robots);
    notes.extend(paused.map(ToString::to_string));
    let (lost, blocks, rules) = (run.lost_rows(), run.blocks(), run.rules());
    let run_order = run.order(&blocks, &rules, &notes);
    let picture = RunPicture { run: run.above(&lost, theme), order: run_order };
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
    /// What to judge it for; `None` takes what the bag's own record has, or milling.
    pub behaviour: Option<Behaviour>,
}

/// Makes a film of a run, and returns the bytes of its file.
///
/// `show` is called with the number of frames that are done, and that of all; the film is called
/// off, with an error, once it returns false.
pub fn film(
    bag: &Path,
    kind: Kind,
    options: FilmOptions,
    show: &dyn Fn(usize, usize) -> bool,
) -> anyhow::Result<Vec<u8>> {
    let FilmOptions { poses, behaviour, .. } = options;
    let run = DrawnRun::read(bag, LabelOptions { poses, behaviour, ..LabelOptions::default() })?;
    let film = Film {
        trajectory: &run.recorded().trajectory,
        radius_m: run.radius_m(),
        names: &run.recorded().robots,
        walls_m: run.run.walls_m,
        world: Some(&run.run.bodies.world),
        classes: &run.run.bodies.classes,
        title: run.simulated().map_or_else(|| title(bag), |mark| format!("{}, {mark}", title(bag))),
        captions: &run.phases(),
        speed: options.speed,
        frames_per_s: options.frames_per_s,
        tail_s: TAIL_S,
        width_px: options.width_px,
        lost: &run.lost_rows(),
    };
    let n_frames = film.n_frames();
    let bytes = encode(&film, kind, &|done| show(done, n_frames))?;
    bytes.ok_or_else(|| with_help("interrupted; nothing was written", "run the same command again"))
}

/// The format of a film, by the extension of its file: `gif`, or `png` and `apng` for an animated PNG.
pub fn kind(path: &Path) -> anyhow::Result<Kind> {
    match path.extension().and_then(|ending| ending.to_str()) {
        Some("gif") => Ok(Kind::Gif),
        Some("png" | "apng") => Ok(Kind::Apng),
        _ => Err(with_help(
            format!("{} ends in none of .gif, .png and .apng", path.display()),
            "name the film `-o run.gif`, or `-o run.png` for an animated PNG",
        )),
    }
}
