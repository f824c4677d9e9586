//! The floor from above, in metres: what pictures of runs and of starts share.

use rsrs_core::judge::trajectory::Trajectory;
use rsrs_core::robot::unicycle::Pose;
use rsrs_core::world::{Outline, WorldFile};

use crate::header::MARGIN_PX;
use crate::palette::{BLUE, GREEN, INK, ORANGE, RED, lid};
use crate::scale::{ends, label};
use crate::svg::{Element, centred_text, number, rectangle, through};
use crate::text::{Weight, width_px};
use crate::track::Point;

/// Width of the page, in pixels.
pub const PAGE_PX: f64 = 480.0;
/// Height of small letters, in pixels.
pub const CAPTION_PX: f64 = 11.0;
/// The way that a robot came.
pub const TAIL: &str = BLUE;
/// A robot that was lost.
pub const LOST: &str = RED;
/// Walls.
pub const WALL: &str = "#8a6d4b";
/// What stands in the arena.
const OBSTACLE: &str = "#d3c4b1";
/// Objects that robots push.
const OBJECT: &str = ORANGE;
/// Goals on the floor.
const GOAL: &str = GREEN;
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
    /// Everything that is driven over, in the middle of the page: all places in metres, of which
    /// there is one at least, and room for a body of `radius_m` around each.
    pub fn around(places_m: impl Iterator<Item = Point>, radius_m: f64, top_px: f64) -> Self {
        let (x_m, y_m): (Vec<f64>, Vec<f64>) = places_m.unzip();
        let [[left_m, right_m], [lower_m, upper_m]] =
            [ends(x_m), ends(y_m)].map(|[low, high]| [low - 1.5 * radius_m, high + 1.5 * radius_m]);
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

/// A robot that is nowhere.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("robot {robot} is at ({x_m}, {y_m}) m in sample {sample}; expected finite numbers")]
pub struct PoseNotFinite {
    /// The sample, from 0.
    pub sample: usize,
    /// The robot, from 0.
    pub robot: usize,
    /// Where it is to the right, in metres.
    pub x_m: f64,
    /// Where it is upwards, in metres.
    pub y_m: f64,
}

/// Whether all robots are somewhere.
///
/// # Errors
///
/// The first one that is not.
pub fn check_poses(trajectory: &Trajectory) -> Result<(), PoseNotFinite> {
    let is_nowhere = |pose: &Pose| {
        ![pose.x_m, pose.y_m, pose.heading_rad].iter().all(|number| number.is_finite())
    };
    let Some(index) = trajectory.poses.iter().position(is_nowhere) else { return Ok(()) };
    let Pose { x_m, y_m, .. } = trajectory.poses[index];
    let (sample, robot) = (index / trajectory.n_robots, index % trajectory.n_robots);
    Err(PoseNotFinite { sample, robot, x_m, y_m })
}

/// A robot from above, with a line towards where it heads. Its lid has the colour of its class, and
/// is white where there are none.
pub fn robot(
    field: &Field,
    pose: Pose,
    radius_m: f64,
    (stroke, class): (&str, Option<usize>),
) -> Element {
    let (x_px, y_px) = field.point(pose.x_m, pose.y_m);
    // A robot on a wide floor would vanish.
    let radius_px = (radius_m * field.px_per_m).max(3.0);
    let (sine, cosine) = libm::sincos(pose.heading_rad);
    let body = Element::circle((x_px, y_px), radius_px)
        .filled(&class.map_or_else(|| "#ffffff".to_owned(), |class| lid(class).hex()), "0.92");
    let heading = Element::new("line")
        .at("x1", x_px + radius_px * cosine)
        .at("y1", y_px - radius_px * sine)
        .at("x2", x_px + 1.6 * radius_px * cosine)
        .at("y2", y_px - 1.6 * radius_px * sine)
        .with("stroke-linecap", "round");
    Element::new("g")
        .fixed()
        .stroked(stroke, (radius_px / 8.0).clamp(1.2, 2.0))
        .child(body)
        .child(heading)
}

/// `3` of `robot_3`: what is written on a robot's lid. Names without a number stay whole.
pub fn short(name: &str) -> &str {
    match name.rsplit_once('_') {
        Some((_, number)) if number.bytes().all(|byte| byte.is_ascii_digit()) => number,
        _ => name,
    }
}

/// Size of the letters in a tag, in pixels.
const TAG_PX: f64 = 9.0;

/// Short names, in the order of the poses, on robots that are large enough, or beside them where
/// they lie on no other name and on no robot; one for which there is no such place is left out.
pub fn tags(field: &Field, poses: &[Pose], names: &[String], radius_m: f64) -> Vec<Element> {
    let radius_px = (radius_m * field.px_per_m).max(3.0);
    let centres: Vec<Point> = places(poses).map(|(x_m, y_m)| field.point(x_m, y_m)).collect();
    let mut taken: Vec<[f64; 4]> = centres
        .iter()
        .map(|(x, y)| {
            let reach_px = 1.6 * radius_px + 1.0;
            [x - reach_px, y - reach_px, x + reach_px, y + reach_px]
        })
        .collect();
    let page = [2.0, field.top_px - 8.0, PAGE_PX - 2.0, field.top_px + field.height_px + 8.0];
    let mut tags = Vec::new();
    for (centre, name) in centres.iter().zip(names) {
        // The ground around the letters is larger than they are, so that no track touches them.
        let half_px = (width_px(name, TAG_PX, Weight::Bold) / 1.3 + 2.0, 0.72 * TAG_PX);
        let beside = |(dx, dy): (f64, f64)| {
            let away_px = 1.6 * radius_px + 2.0;
            let x = centre.0 + dx * (away_px + half_px.0);
            let y = centre.1 + dy * (away_px + half_px.1);
            [x - half_px.0, y - half_px.1, x + half_px.0, y + half_px.1]
        };
        let slant = std::f64::consts::FRAC_1_SQRT_2;
        let around = [
            (1.0, 0.0),
            (0.0, -1.0),
            (-1.0, 0.0),
            (0.0, 1.0),
            (slant, -slant),
            (-slant, -slant),
            (-slant, slant),
            (slant, slant),
        ];
        let on_it = beside((0.0, 0.0));
        let fits = libm::hypot(half_px.0, half_px.1) <= radius_px;
        let is_apart = |other: &&Point| {
            libm::hypot(other.0 - centre.0, other.1 - centre.1) > radius_px + half_px.0
        };
        if fits && centres.iter().filter(is_apart).count() + 1 == centres.len() {
            tags.push(tag(name, on_it));
            continue;
        }
        let is_free = |room: &[f64; 4]| {
            let is_inside = room[0] >= page[0]
                && room[1] >= page[1]
                && room[2] <= page[2]
                && room[3] <= page[3];
            is_inside && taken.iter().all(|other| !overlap(room, other))
        };
        let Some(room) = around.map(beside).into_iter().find(is_free) else { continue };
        taken.push(room);
        tags.push(tag(name, room));
    }
    tags
}

fn overlap(one: &[f64; 4], other: &[f64; 4]) -> bool {
    one[0] < other[2] && other[0] < one[2] && one[1] < other[3] && other[1] < one[3]
}

fn tag(name: &str, [left, top, right, bottom]: [f64; 4]) -> Element {
    let ground =
        rectangle(left, top, right - left, bottom - top).at("rx", 4.0).with("fill", "#ffffff");
    let y_px = f64::midpoint(top, bottom) + 0.36 * TAG_PX;
    let text = centred_text(f64::midpoint(left, right), y_px, name).bold(TAG_PX, INK);
    Element::new("g").fixed().child(ground).child(text)
}

/// The walls of an arena and its obstacles, as far as they lie in the field; `None` where none is
/// in sight.
///
/// Walls of a square are `walls_m` from the origin; an arena of another shape is in `world`.
pub fn walls(field: &Field, walls_m: Option<f64>, world: Option<&WorldFile>) -> Option<Element> {
    let walls_m = walls_m?;
    let space = world.and_then(|world| world.free_space(2.0 * walls_m));
    let is_square = world.is_none_or(|world| world.arena.is_none());
    let square = is_square.then(|| square_walls(field, walls_m)).flatten();
    let Some(space) = space else { return square };
    let outline = |outline: &Outline, fill: &str| {
        let corners = outline.drawn_m().into_iter().map(|[x_m, y_m]| field.point(x_m, y_m));
        let path = format!("{}Z", through(corners));
        let drawn = Element::path(&path).with("stroke", WALL);
        drawn.with("fill", fill).with("stroke-linejoin", "round")
    };
    let border = (!is_square).then(|| outline(space.border(), "none").at("stroke-width", 3.0));
    let obstacles = space.obstacles().iter();
    let obstacles = obstacles.map(|it| outline(it, OBSTACLE).at("stroke-width", 1.2));
    Some(Element::new("g").children(square).children(border).children(obstacles))
}

/// Those of a square.
fn square_walls(field: &Field, walls_m: f64) -> Option<Element> {
    let (left, upper) = field.point(-walls_m, walls_m);
    let (right, lower) = field.point(walls_m, -walls_m);
    let (top, bottom) = (field.top_px - 6.0, field.top_px + field.height_px + 6.0);
    let sides = (MARGIN_PX - 6.0, PAGE_PX - MARGIN_PX + 6.0);
    let span =
        |from: f64, to: f64, (low, high): Point| (from.clamp(low, high), to.clamp(low, high));
    let (x_from, x_to) = span(left, right, sides);
    let (y_from, y_to) = span(upper, lower, (top, bottom));
    let mut path: Vec<String> = Vec::new();
    for y in [upper, lower].into_iter().filter(|y| (top..=bottom).contains(y)) {
        path.push(format!("M{} {}H{}", number(x_from), number(y), number(x_to)));
    }
    for x in [left, right].into_iter().filter(|x| (sides.0..=sides.1).contains(x)) {
        path.push(format!("M{} {}V{}", number(x), number(y_from), number(y_to)));
    }
    let drawn = Element::path(&path.concat()).stroked(WALL, 3.0);
    (!path.is_empty()).then(|| drawn.with("fill", "none").with("stroke-linecap", "square"))
}

/// The objects and goals of a world, which lie below robots. Where objects are, in metres, has
/// shape `[n_objects][2]`, and is empty if nobody knows.
pub fn things(field: &Field, world: &WorldFile, objects_m: &[[f64; 2]]) -> Vec<Element> {
    let disc = |[x_m, y_m]: [f64; 2], radius_m: f64| {
        let (x_px, y_px) = field.point(x_m, y_m);
        Element::circle((x_px, y_px), radius_m * field.px_per_m)
    };
    let goals = world.goals.iter().map(|goal| {
        disc(goal.place_m, goal.radius_m)
            .filled(GOAL, "0.12")
            .stroked(GOAL, 1.2)
            .with("stroke-dasharray", "5 3")
    });
    let objects = world.each_object().zip(objects_m).map(|(object, place_m)| {
        disc(*place_m, object.radius_m).with("fill", OBJECT).stroked(INK, 0.8)
    });
    goals.chain(objects).collect()
}

/// What the discs of [`things`] are: a mark and a word for each kind that there is. Of `n_objects`
/// it is known where they are.
pub fn things_in_words(world: &WorldFile, n_objects: usize) -> Vec<(Element, String)> {
    let mark = || Element::circle((11.0, 0.0), 4.0);
    let object = mark().with("fill", OBJECT).stroked(INK, 0.8).fixed();
    let goal = mark().outlined(GOAL, 1.2).with("stroke-dasharray", "3 2");
    let objects = (n_objects > 0).then(|| (object, "objects".to_owned()));
    let goals = (!world.goals.is_empty()).then(|| (goal, "goals".to_owned()));
    objects.into_iter().chain(goals).collect()
}

/// What of objects and goals lies outermost, in metres, so that a field has room for them.
pub fn around_things<'a>(
    world: Option<&'a WorldFile>,
    trajectory: &'a Trajectory,
) -> impl Iterator<Item = Point> + 'a {
    let goals = world.into_iter().flat_map(|world| &world.goals).flat_map(|goal| {
        let ([x_m, y_m], r_m) = (goal.place_m, goal.radius_m);
        [(x_m - r_m, y_m - r_m), (x_m + r_m, y_m + r_m)]
    });
    let objects = world.and(Some(&trajectory.objects_m)).into_iter().flatten();
    objects.map(|[x_m, y_m]| (*x_m, *y_m)).chain(goals)
}

/// In an arena at most so many times as wide as what is drawn in it, all of its walls are shown.
const WIDE: f64 = 2.0;

/// The corners of walls, as in [`walls`], that are in sight, so that a field has room for them:
/// those of a square that is not much wider than what else is drawn in it (`drawn_m`), all of an
/// arena of another shape, and obstacles.
pub fn around_walls(
    (walls_m, world): (Option<f64>, Option<&WorldFile>),
    drawn_m: &[Point],
) -> impl Iterator<Item = Point> + use<> {
    let is_square = world.is_none_or(|world| world.arena.is_none());
    let space = walls_m.and_then(|walls_m| world?.free_space(2.0 * walls_m));
    let shaped = space.into_iter().flat_map(move |space| {
        let border = (!is_square).then(|| space.border().bounds_m());
        let obstacles = space.obstacles().iter().map(Outline::bounds_m);
        border.into_iter().chain(obstacles).flatten().collect::<Vec<_>>()
    });
    let shaped = shaped.map(|[x_m, y_m]| (x_m, y_m));
    let walls_m = walls_m.filter(|_| is_square);
    let extent_m = |number: fn(&Point) -> f64| {
        let [low, high] = ends(drawn_m.iter().map(number));
        high - low
    };
    let extent_m = extent_m(|place| place.0).max(extent_m(|place| place.1));
    let in_sight = walls_m.filter(|walls_m| 2.0 * walls_m <= WIDE * extent_m);
    let square = in_sight.into_iter();
    square.flat_map(|walls_m| [(-walls_m, -walls_m), (walls_m, walls_m)]).chain(shaped)
}

/// A bar of a round length of at most a quarter of the field.
pub fn scale_bar(field: &Field, y_px: f64) -> [Element; 2] {
    let length_m = round_length(FIELD_PX / field.px_per_m / 4.0);
    let length_px = length_m * field.px_per_m;
    let left_px = PAGE_PX - MARGIN_PX - length_px;
    let (left, right) = (number(left_px), number(left_px + length_px));
    let bar =
        Element::path(&format!("M{left} {}v4H{right}v-4", number(y_px - 4.0))).outlined(INK, 1.6);
    let text =
        centred_text(left_px + length_px / 2.0, y_px - 6.0, &format!("{} m", label(length_m)))
            .lettered(CAPTION_PX, INK);
    [bar, text]
}

/// The largest of 1, 2, 5 times a power of ten that is not above a length.
pub fn round_length(most: f64) -> f64 {
    let decade = libm::pow(10.0, libm::floor(libm::log10(most)));
    [5.0, 2.0, 1.0]
        .into_iter()
        .map(|step| step * decade)
        .find(|step| *step <= most)
        .unwrap_or(decade)
}
