//! Where simulated robots can be under one command, with real trajectories over it.

use rsrs_core::trials::trial::DrivenTrial;
use rsrs_core::trials::validation::{Exit, Horizon, Tube};

use crate::chart::{BELOW_PX, Chart, LEFT_PX, legend, stroke_mark};
use crate::header::{MARGIN_PX, header};
use crate::palette::{BLUE, INK, QUIET_INK, RED};
use crate::scale::ends;
use crate::svg::{Element, centred_text, rectangle, through};
use crate::text::{Weight, width_px};
use crate::theme::Theme;
use crate::track;

const PAGE_PX: f64 = 640.0;
const HIGHEST_PX: f64 = 460.0;
/// Colours of regions, by their times.
const REGIONS: [&str; 4] = ["#fbe3ab", "#f3c04f", "#d98e00", "#f3c04f"];
const OUTLINE: &str = "#8a5a00";
const INSIDE: &str = BLUE;
const OUTSIDE: &str = RED;
/// Samples along a real trajectory: more would not be seen.
const SAMPLES: u32 = 200;

/// A tube, real trajectories, and the text about them.
#[derive(Clone, Debug)]
pub struct ReachPicture<'a> {
    /// The simulated reach.
    pub tube: &'a Tube,
    /// Real trajectories under its commands, and whether each left it.
    pub trials: &'a [(&'a DrivenTrial, TubeMembership)],
    /// Where it is looked at.
    pub theme: Theme,
    /// The title; any text.
    pub title: String,
    /// Under the title; any text.
    pub subtitle: String,
}

/// Whether a trajectory stayed in the tube.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TubeMembership {
    /// It was inside at every horizon.
    Inside,
    /// It was outside at some horizon.
    Outside,
}

impl TubeMembership {
    /// Of what was outside at these times.
    pub fn new(exits: &[Exit]) -> Self {
        if exits.is_empty() { Self::Inside } else { Self::Outside }
    }
}

/// Why there is no picture of a tube.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ReachPictureError {
    /// There is nothing to draw.
    #[error("the tube has no horizons, expected 1 or more")]
    Empty,
    /// A region reaches to nowhere.
    #[error("the region at {time_s} s is not finite")]
    NotFinite {
        /// The time, in seconds.
        time_s: f64,
    },
}

/// Draws the region at each horizon in the frame of the start, and the trajectories.
///
/// # Source
///
/// `eq:simulatorreq`, `fig:gap`.
pub fn svg(picture: &ReachPicture) -> Result<String, ReachPictureError> {
    check(picture.tube)?;
    let room_px = PAGE_PX - 2.0 * MARGIN_PX;
    let (texts, header_px) =
        header(picture.theme, &picture.title, &[&picture.subtitle], MARGIN_PX, room_px);
    let paths: Vec<(Vec<[f64; 2]>, TubeMembership)> =
        picture.trials.iter().map(|(trial, place)| (places_m(trial), *place)).collect();
    let [x, y] = bounds(picture.tube, &paths);
    let chart = Chart::to_scale(
        (MARGIN_PX + LEFT_PX, header_px + 12.0),
        (room_px - LEFT_PX, HIGHEST_PX),
        x,
        y,
    );
    let (legend, bottom_px) =
        legend(&entries(picture), (chart.left_px, chart.bottom_px() + BELOW_PX), room_px - LEFT_PX);
    let regions = picture
        .tube
        .horizons
        .iter()
        .enumerate()
        .map(|(index, horizon)| region(&chart, horizon, shade(index)));
    let page = Element::picture(PAGE_PX, bottom_px + 10.0, &picture.title)
        .described(&picture.theme.description([picture.subtitle.as_str()], ""))
        .children(texts)
        .child(Element::new("g").children(regions))
        .children(paths.iter().map(|(places_m, place)| path(&chart, places_m, *place)))
        .children(dots(&chart, picture))
        .child(chart.frame("ahead of the start (m)"))
        .child(chart.y_axis("left of the start (m)"))
        .children(last_time(&chart, picture.tube))
        .children(legend);
    Ok(format!("{page}\n"))
}

fn check(tube: &Tube) -> Result<(), ReachPictureError> {
    if tube.horizons.is_empty() {
        return Err(ReachPictureError::Empty);
    }
    for horizon in &tube.horizons {
        let mut corners_m = horizon.region.loops_m.iter().flatten();
        if !corners_m.all(|corner_m| corner_m.iter().all(|number| number.is_finite())) {
            return Err(ReachPictureError::NotFinite { time_s: horizon.time_s });
        }
    }
    Ok(())
}

fn places_m(trial: &DrivenTrial) -> Vec<[f64; 2]> {
    let duration_s = trial.duration_s();
    (0..=SAMPLES)
        .map(|sample| {
            let after_s = duration_s * f64::from(sample) / f64::from(SAMPLES);
            let pose = trial.displacement_at(after_s);
            [pose.x_m, pose.y_m]
        })
        .collect()
}

/// Everything that is drawn, the start included, with a margin; at least a quarter as high as wide.
fn bounds(tube: &Tube, paths: &[(Vec<[f64; 2]>, TubeMembership)]) -> [[f64; 2]; 2] {
    let corners = tube.horizons.iter().flat_map(|horizon| horizon.region.loops_m.iter().flatten());
    let points: Vec<[f64; 2]> = corners
        .copied()
        .chain(paths.iter().flat_map(|(places_m, _)| places_m.iter().copied()))
        .chain([[0.0, 0.0]])
        .collect();
    let spans = [0, 1].map(|axis| ends(points.iter().map(|point| point[axis])));
    let widest = spans.iter().map(|[low, high]| high - low).fold(1e-6, f64::max);
    spans.map(|[low, high]| {
        let spare = 0.03 * widest + (0.25 * widest - (high - low)).max(0.0) / 2.0;
        [low - spare, high + spare]
    })
}

/// The colour of one time, from light to dark and again, so that regions of times that follow on each other
/// differ, and the places at a time have the colour of its region.
fn shade(index: usize) -> &'static str {
    REGIONS[index % REGIONS.len()]
}

/// Where each trial was at the time of each region: in that region's colour, with a rim in that of the trial.
fn dots(chart: &Chart, picture: &ReachPicture) -> Vec<Element> {
    let of_trial = |(trial, place): &(&DrivenTrial, TubeMembership)| {
        let horizons = picture.tube.horizons.iter().enumerate();
        let reached = horizons.filter(|(_, horizon)| horizon.time_s <= trial.duration_s() + 1e-9);
        let dot = |(index, horizon): (usize, &Horizon)| {
            let pose = trial.displacement_at(horizon.time_s);
            let words =
                format!("{}, trial {}, after {:.1} s", trial.robot, trial.trial, horizon.time_s);
            Element::circle((chart.x_px(pose.x_m), chart.y_px(pose.y_m)), 2.6)
                .with("fill", shade(index))
                .stroked(colour(*place), 1.2)
                .titled(&words)
        };
        reached.map(dot).collect::<Vec<Element>>()
    };
    picture.trials.iter().flat_map(of_trial).collect()
}

fn colour(place: TubeMembership) -> &'static str {
    match place {
        TubeMembership::Inside => INSIDE,
        TubeMembership::Outside => OUTSIDE,
    }
}

/// A region as its outline.
fn region(chart: &Chart, horizon: &Horizon, fill: &str) -> Element {
    let corner = |[ahead_m, left_m]: &[f64; 2]| (chart.x_px(*ahead_m), chart.y_px(*left_m));
    let loops = horizon.region.loops_m.iter();
    let path: String = loops.map(|corners_m| through(corners_m.iter().map(corner)) + "z").collect();
    let tooltip = format!(
        "after {:.1} s: {:.4} m², {} of {} trials inside",
        horizon.time_s, horizon.area_m2, horizon.n_inside, horizon.n_trials
    );
    Element::path(&path)
        .with("fill", fill)
        .with("fill-rule", "evenodd")
        .with("fill-opacity", "0.55")
        .stroked(OUTLINE, 0.7)
        .titled(&tooltip)
}

fn path(chart: &Chart, places_m: &[[f64; 2]], place: TubeMembership) -> Element {
    let points: Vec<track::Point> =
        places_m.iter().map(|[x, y]| (chart.x_px(*x), chart.y_px(*y))).collect();
    Element::path(&track::path(&track::simplified(&points, 0.2))).outlined(colour(place), 1.4)
}

/// Writes beside the last region when it is.
fn last_time(chart: &Chart, tube: &Tube) -> Option<Element> {
    let last = tube.horizons.last()?;
    let [ahead_m, left_m] = last.mean_m;
    let text = format!("{:.0} s", last.time_s);
    let half_px = width_px(&text, 11.0, Weight::Regular) / 1.3 + 2.0;
    let (x_px, y_px) = (chart.x_px(ahead_m), chart.y_px(left_m) - 14.0);
    let ground = rectangle(x_px - half_px, y_px - 9.0, 2.0 * half_px, 18.0)
        .at("rx", 4.0)
        .with("fill", "#ffffff");
    let words = centred_text(x_px, y_px + 4.0, &text).lettered(11.0, INK);
    Some(Element::new("g").fixed().child(ground).child(words))
}

fn entries(picture: &ReachPicture) -> Vec<(Element, String)> {
    let n_outside =
        picture.trials.iter().filter(|(_, place)| *place == TubeMembership::Outside).count();
    let n_inside = picture.trials.len() - n_outside;
    let last = &picture.tube.horizons[picture.tube.horizons.len() - 1];
    let area = format!(
        "simulated reach at {} times; {:.3} m² at the last, after {:.0} s",
        picture.tube.horizons.len(),
        last.area_m2,
        last.time_s
    );
    let mut entries = vec![
        (stroke_mark(REGIONS[1], 9.0), area),
        (
            Element::circle((11.0, 0.0), 2.6).with("fill", REGIONS[2]).stroked(INSIDE, 1.2),
            "where a trial was at one of these times, in the colour of that region".to_owned(),
        ),
        (stroke_mark(INSIDE, 1.8), format!("{} inside at every time", trials(n_inside))),
    ];
    if n_outside > 0 {
        entries.push((
            stroke_mark(OUTSIDE, 1.8),
            format!("{} outside at some time", trials(n_outside)),
        ));
    }
    if picture.trials.is_empty() {
        entries.truncate(1);
        entries.push((stroke_mark(QUIET_INK, 0.0), "no real trials".to_owned()));
    }
    entries
}

fn trials(n: usize) -> String {
    if n == 1 { "1 trial".to_owned() } else { format!("{n} trials") }
}
