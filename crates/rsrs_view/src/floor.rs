//! The floor from above, in metres: what pictures of runs and of starts share.

use rsrs_core::judge::trajectory::Trajectory;
use rsrs_core::robot::unicycle::Pose;

use crate::palette::INK;
use crate::scale::label;
use crate::svg::{Element, line_of_text, number};
use crate::track::Point;

/// Width of the page, in pixels.
pub const PAGE_PX: f64 = 480.0;
/// Margin of the page, in pixels.
pub const MARGIN_PX: f64 = 24.0;
/// Height of small letters, in pixels.
pub const CAPTION_PX: f64 = 11.0;
/// The way that a robot came.
pub const TAIL: &str = "#0072b2";
/// A robot that was lost.
pub const LOST: &str = "#c1121f";
const FIELD_PX: f64 = PAGE_PX - 2.0 * MARGIN_PX;

/// From metres on the floor to pixels on the page.
pub struct Field {
    left_m: f64,
    upper_m: f64,
    /// Where it begins on the page, in pixels from the top.
    pub top_px: f64,
    /// Its height, in pixels.
    pub height_px: f64,
    /// Pixels for each metre.
    pub px_per_m: f64,
}

impl Field {
    /// Everything that is driven over, in the middle of the page.
    ///
    /// # Arguments
    ///
    /// * `places_m` — centres of robots and what else is drawn, in metres; at least one.
    /// * `radius_m` — of a body, in metres.
    pub fn around(places_m: impl Iterator<Item = Point>, radius_m: f64, top_px: f64) -> Self {
        let nothing = (f64::INFINITY, f64::NEG_INFINITY);
        let wider = |(low, high): Point, number: f64| (low.min(number), high.max(number));
        let (x_m, y_m) = places_m.fold((nothing, nothing), |(x_m, y_m), place_m| {
            (wider(x_m, place_m.0), wider(y_m, place_m.1))
        });
        let [(left_m, right_m), (lower_m, upper_m)] =
            [x_m, y_m].map(|(low, high)| (low - 1.5 * radius_m, high + 1.5 * radius_m));
        let px_per_m = FIELD_PX / (right_m - left_m).max(upper_m - lower_m);
        let spare_m = FIELD_PX / px_per_m - (right_m - left_m);
        let height_px = px_per_m * (upper_m - lower_m);
        Self { left_m: left_m - spare_m / 2.0, upper_m, top_px, height_px, px_per_m }
    }

    /// Where a place on the floor is on the page, in pixels.
    pub fn point(&self, x_m: f64, y_m: f64) -> Point {
        (
            MARGIN_PX + (x_m - self.left_m) * self.px_per_m,
            self.top_px + (self.upper_m - y_m) * self.px_per_m,
        )
    }
}

/// Where robots are, in metres.
pub fn places(poses: &[Pose]) -> impl Iterator<Item = Point> {
    poses.iter().map(|pose| (pose.x_m, pose.y_m))
}

/// The first pose that is nowhere: its sample, its robot, and the pose.
pub fn not_finite(trajectory: &Trajectory) -> Option<(usize, usize, Pose)> {
    let is_nowhere = |pose: &Pose| {
        ![pose.x_m, pose.y_m, pose.heading_rad].iter().all(|number| number.is_finite())
    };
    let index = trajectory.poses.iter().position(is_nowhere)?;
    let n_robots = trajectory.n_robots;
    Some((index / n_robots, index % n_robots, trajectory.poses[index]))
}

/// A robot from above, with a line towards where it heads.
pub fn robot(field: &Field, pose: Pose, radius_m: f64, stroke: &str) -> Element {
    let (x_px, y_px) = field.point(pose.x_m, pose.y_m);
    // A robot on a wide floor would vanish.
    let radius_px = (radius_m * field.px_per_m).max(3.0);
    let (sine, cosine) = libm::sincos(pose.heading_rad);
    let body = Element::new("circle")
        .at("cx", x_px)
        .at("cy", y_px)
        .at("r", radius_px)
        .with("fill", "#ffffff")
        .with("fill-opacity", "0.92");
    let heading = Element::new("line")
        .at("x1", x_px + radius_px * cosine)
        .at("y1", y_px - radius_px * sine)
        .at("x2", x_px + 1.6 * radius_px * cosine)
        .at("y2", y_px - 1.6 * radius_px * sine)
        .with("stroke-linecap", "round");
    Element::new("g")
        .fixed()
        .with("stroke", stroke)
        .at("stroke-width", (radius_px / 8.0).clamp(1.2, 2.0))
        .child(body)
        .child(heading)
}

/// A bar of a round length of at most a quarter of the field.
pub fn scale_bar(field: &Field, y_px: f64) -> [Element; 2] {
    let length_m = round_length(FIELD_PX / field.px_per_m / 4.0);
    let length_px = length_m * field.px_per_m;
    let left_px = PAGE_PX - MARGIN_PX - length_px;
    let (left, right) = (number(left_px), number(left_px + length_px));
    let bar = Element::new("path")
        .with("d", &format!("M{left} {}v4H{right}v-4", number(y_px - 4.0)))
        .with("fill", "none")
        .with("stroke", INK)
        .at("stroke-width", 1.6);
    let text =
        line_of_text(left_px + length_px / 2.0, y_px - 6.0, &format!("{} m", label(length_m)))
            .with("text-anchor", "middle")
            .at("font-size", CAPTION_PX)
            .with("fill", INK);
    [bar, text]
}

/// The largest of 1, 2, 5 times a power of ten that is not above a length.
fn round_length(most: f64) -> f64 {
    let decade = libm::pow(10.0, libm::floor(libm::log10(most)));
    [5.0, 2.0, 1.0]
        .into_iter()
        .map(|step| step * decade)
        .find(|step| *step <= most)
        .unwrap_or(decade)
}
