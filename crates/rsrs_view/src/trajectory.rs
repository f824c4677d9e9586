//! One run from above: where every robot went, where it is now, and the ring if there is one.

use rsrs_core::judge::phase::Phase;
use rsrs_core::judge::trajectory::Trajectory;
use rsrs_core::robot::unicycle::Pose;

use crate::floor::{
    CAPTION_PX, Field, LOST, MARGIN_PX, PAGE_PX, TAIL, not_finite, places, robot, scale_bar,
};
use crate::header::header;
use crate::palette::{INK, QUIET_INK, hue};
use crate::scale::label;
use crate::svg::{Element, line_of_text};
use crate::track::{self, Point};

/// One run and the text about it.
#[derive(Clone, Debug)]
pub struct TrajectoryPicture<'a> {
    /// What every robot did.
    pub trajectory: &'a Trajectory,
    /// Radius of a robot's body, in metres; positive.
    pub radius_m: f64,
    /// How much of the end is drawn strongly, and what a ring is fitted to, in seconds; positive.
    pub tail_s: f64,
    /// What the judge found; milling phases get a ring.
    pub phase: Option<Phase>,
    /// Robots that did not take part to the end, by their index, to be drawn in red.
    pub lost: &'a [usize],
    /// The title; any text.
    pub title: String,
    /// Under the title; any text.
    pub subtitle: String,
}

/// Why there is no picture of a run.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TrajectoryPictureError {
    /// There is no robot or no sample.
    #[error("the trajectory has {n_samples} samples of {n_robots} robots; expected 1 of each")]
    Empty {
        /// Samples found.
        n_samples: usize,
        /// Robots found.
        n_robots: usize,
    },
    /// A pose is nowhere.
    #[error("robot {robot} is at ({x_m}, {y_m}) m in sample {sample}; expected finite numbers")]
    PoseNotFinite {
        /// The sample, from 0.
        sample: usize,
        /// The robot, from 0.
        robot: usize,
        /// Where it is to the right, in metres.
        x_m: f64,
        /// Where it is upwards, in metres.
        y_m: f64,
    },
    /// A length or a time of the picture makes no sense.
    #[error("{name} is {found}; expected a positive number")]
    NotPositive {
        /// Which one.
        name: &'static str,
        /// What it is.
        found: f64,
    },
}

/// Draws one run.
///
/// The earlier tracks are pale, the last `tail_s` seconds strong; a dot is where a robot started, and
/// robots stand where they ended, with a line towards where they head. A milling run also gets the circle about the centroid of
/// the tail with the mean distance from it as radius.
///
/// # Returns
///
/// A self-contained SVG document of about 1 kB per robot and turn; the same text on every machine.
///
/// # Errors
///
/// [`TrajectoryPictureError`], each variant as its name states.
pub fn svg(picture: &TrajectoryPicture) -> Result<String, TrajectoryPictureError> {
    let (elements, height_px) = elements(picture)?;
    let page = Element::picture(PAGE_PX, height_px, &picture.title).children(elements);
    Ok(format!("{page}\n"))
}

/// What is drawn of a run on a page of [`PAGE_PX`], and its height in pixels.
///
/// # Errors
///
/// As [`svg`].
pub(crate) fn elements(
    picture: &TrajectoryPicture,
) -> Result<(Vec<Element>, f64), TrajectoryPictureError> {
    check(picture)?;
    let trajectory = picture.trajectory;
    let (header, header_px) = header(
        &picture.title,
        std::slice::from_ref(&picture.subtitle),
        MARGIN_PX,
        PAGE_PX - 2.0 * MARGIN_PX,
    );
    let first_of_tail = first_of_tail(picture);
    let ring = picture.phase.and_then(|phase| ring_of(phase, trajectory, first_of_tail));
    let drawn_m = places(&trajectory.poses).chain(ring.into_iter().flat_map(Ring::corners_m));
    let field = Field::around(drawn_m, picture.radius_m, header_px + 10.0);

    let last = trajectory.poses_at(trajectory.n_samples() - 1);
    let robots = last.iter().enumerate().map(|(index, pose)| {
        let stroke = if picture.lost.contains(&index) { LOST } else { INK };
        robot(&field, *pose, picture.radius_m, stroke)
    });
    let (caption, bottom_px) = caption(picture, ring, field.top_px + field.height_px + 12.0);
    let mut elements = header;
    elements.push(tracks(&field, trajectory, 0..first_of_tail + 1, "#b9c3cc", 0.8));
    elements.push(tracks(&field, trajectory, first_of_tail..trajectory.n_samples(), TAIL, 1.5));
    elements.extend(trajectory.poses_at(0).iter().map(|pose| start(&field, *pose)));
    elements.extend(ring.map(|ring| ring_circle(&field, ring)));
    elements.extend(robots);
    elements.extend(scale_bar(&field, bottom_px));
    elements.extend(caption);
    Ok((elements, bottom_px + 16.0))
}

/// Where a robot started.
fn start(field: &Field, pose: Pose) -> Element {
    let (x_px, y_px) = field.point(pose.x_m, pose.y_m);
    Element::new("circle").at("cx", x_px).at("cy", y_px).at("r", 2.2).with("fill", "#7d8b96")
}

fn check(picture: &TrajectoryPicture) -> Result<(), TrajectoryPictureError> {
    let trajectory = picture.trajectory;
    for (name, found) in [
        ("the body's radius in m", picture.radius_m),
        ("the tail in s", picture.tail_s),
        ("the period in s", trajectory.period_s),
    ] {
        if !(found.is_finite() && found > 0.0) {
            return Err(TrajectoryPictureError::NotPositive { name, found });
        }
    }
    let (n_samples, n_robots) = (trajectory.n_samples(), trajectory.n_robots);
    if n_samples == 0 {
        return Err(TrajectoryPictureError::Empty { n_samples, n_robots });
    }
    match not_finite(trajectory) {
        Some((sample, robot, Pose { x_m, y_m, .. })) => {
            Err(TrajectoryPictureError::PoseNotFinite { sample, robot, x_m, y_m })
        }
        None => Ok(()),
    }
}

/// The sample at which the tail begins.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "positive, and casts from floats saturate"
)]
fn first_of_tail(picture: &TrajectoryPicture) -> usize {
    let n_tail = (picture.tail_s / picture.trajectory.period_s).ceil() as usize;
    (picture.trajectory.n_samples() - 1).saturating_sub(n_tail)
}

fn tracks(
    field: &Field,
    trajectory: &Trajectory,
    samples: std::ops::Range<usize>,
    stroke: &str,
    width_px: f64,
) -> Element {
    let paths = (0..trajectory.n_robots).map(|robot| {
        let points: Vec<Point> = samples
            .clone()
            .map(|sample| trajectory.poses_at(sample)[robot])
            .map(|pose| field.point(pose.x_m, pose.y_m))
            .collect();
        Element::new("path").with("d", &track::path(&track::simplified(&points, 0.3)))
    });
    Element::new("g")
        .with("fill", "none")
        .with("stroke", stroke)
        .at("stroke-width", width_px)
        .with("stroke-linecap", "round")
        .with("stroke-linejoin", "round")
        .children(paths)
}

/// A circle on the floor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ring {
    /// Its centre, in metres.
    pub centre_m: (f64, f64),
    /// Its radius, in metres.
    pub radius_m: f64,
}

impl Ring {
    /// Two corners of the square around it, in metres.
    fn corners_m(self) -> [Point; 2] {
        let Self { centre_m: (x_m, y_m), radius_m } = self;
        [(x_m - radius_m, y_m - radius_m), (x_m + radius_m, y_m + radius_m)]
    }
}

/// Centroid and mean radius of a run from a sample on, if its phase has a ring.
///
/// # Arguments
///
/// * `first_sample` — one of the trajectory.
pub fn ring_of(phase: Phase, trajectory: &Trajectory, first_sample: usize) -> Option<Ring> {
    match phase {
        Phase::StableMilling | Phase::SemiStableMilling => {}
        _ => return None,
    }
    let poses = &trajectory.poses[first_sample * trajectory.n_robots..];
    let mean =
        |number: &dyn Fn(&Pose) -> f64| poses.iter().map(number).sum::<f64>() / poses.len() as f64;
    let (x_m, y_m) = (mean(&|pose| pose.x_m), mean(&|pose| pose.y_m));
    let radius_m = mean(&|pose| libm::hypot(pose.x_m - x_m, pose.y_m - y_m));
    Some(Ring { centre_m: (x_m, y_m), radius_m })
}

fn ring_circle(field: &Field, ring: Ring) -> Element {
    let (x_px, y_px) = field.point(ring.centre_m.0, ring.centre_m.1);
    Element::new("circle")
        .at("cx", x_px)
        .at("cy", y_px)
        .at("r", ring.radius_m * field.px_per_m)
        .with("fill", "none")
        .with("stroke", &hue(Phase::CollidingUnstable).hex())
        .at("stroke-width", 1.8)
        .with("stroke-dasharray", "7 4")
}

/// What the strokes mean, a line each, beside the scale bar.
fn caption(picture: &TrajectoryPicture, ring: Option<Ring>, top_px: f64) -> (Vec<Element>, f64) {
    let shown_s = picture.tail_s.min(picture.trajectory.duration_s());
    let mut lines: Vec<String> =
        picture.phase.map(|phase| format!("phase: {phase}")).into_iter().collect();
    lines.push(format!("blue: the last {} s; dots: starts", label(shown_s)));
    if !picture.lost.is_empty() {
        lines.push("red: robots that did not take part to the end".to_owned());
    }
    lines.extend(ring.map(|ring| format!("dashed: mean radius {:.2} m", ring.radius_m)));
    let mut y_px = top_px;
    let mut texts = Vec::new();
    for line in lines {
        y_px += CAPTION_PX * 1.45;
        let text = line_of_text(MARGIN_PX, y_px, &line)
            .at("font-size", CAPTION_PX)
            .with("fill", QUIET_INK);
        texts.push(text);
    }
    (texts, y_px)
}
