//! One run from above: where every robot went, where it is now, and the ring if there is one.

use rsrs_core::judge::behaviour::Behaviour;
use rsrs_core::judge::phase::Phase;
use rsrs_core::judge::trajectory::Trajectory;
use rsrs_core::robot::unicycle::Pose;
use rsrs_core::world::WorldFile;

pub use crate::floor::PoseNotFinite;

use crate::chart::{legend, stroke_mark};
use crate::floor::{
    Field, LOST, PAGE_PX, TAIL, WALL, around_things, around_walls, check_poses, places, robot,
    scale_bar, short, tags, things, things_in_words, walls,
};
use crate::header::{MARGIN_PX, header};
use crate::palette::{INK, lid};
use crate::scale::label;
use crate::svg::Element;
use crate::theme::Theme;
use crate::track::{self, Point};

/// Ways before the end that is strong.
const BEFORE: &str = "#b9c3cc";
/// Where robots started.
const START: &str = "#7d8b96";
/// The dashes of a ring.
const RING_DASHES: &str = "7 4";
/// Width of the texts left of the scale bar, in pixels.
const CAPTION_ROOM_PX: f64 = 300.0;

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
    /// Names of the robots, in the order of their indices; none if they are not shown.
    pub names: &'a [String],
    /// Distance of the walls from the origin, in metres, where there are some.
    pub walls_m: Option<f64>,
    /// What is there besides robots, where that is known.
    pub world: Option<&'a WorldFile>,
    /// The class of each robot; none if there are none.
    pub classes: &'a [usize],
    /// Where it is looked at.
    pub theme: Theme,
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
    #[error(transparent)]
    PoseNotFinite(#[from] PoseNotFinite),
    /// A length or a time of the picture makes no sense.
    #[error("{name} is {found}; expected a positive number")]
    NotPositive {
        /// Which one.
        name: &'static str,
        /// What it is.
        found: f64,
    },
}

/// Draws one run as a self-contained SVG document of about 1 kB per robot and turn: the same text
/// on every machine.
///
/// The earlier tracks are pale, the last `tail_s` seconds strong; a dot is where a robot started,
/// and robots stand and objects lie where they ended, with a line towards where they head and their
/// names. A milling run also gets the circle about the centroid of the tail with the mean distance
/// from it as radius, and so does each of several mills.
pub fn svg(picture: &TrajectoryPicture) -> Result<String, TrajectoryPictureError> {
    let (elements, height_px) = elements(picture)?;
    let page = Element::picture(PAGE_PX, height_px, &picture.title)
        .described(&picture.theme.description([picture.subtitle.as_str()], ""))
        .children(elements);
    Ok(format!("{page}\n"))
}

/// What is drawn of a run on a page of [`PAGE_PX`], and its height in pixels.
pub(crate) fn elements(
    picture: &TrajectoryPicture,
) -> Result<(Vec<Element>, f64), TrajectoryPictureError> {
    check(picture)?;
    let trajectory = picture.trajectory;
    let (header, header_px) = header(
        picture.theme,
        &picture.title,
        &[&picture.subtitle],
        MARGIN_PX,
        PAGE_PX - 2.0 * MARGIN_PX,
    );
    let first_of_tail = first_of_tail(picture);
    let rings = rings(picture, first_of_tail);
    let corners_m = rings.iter().flat_map(|(ring, _)| ring.corners_m());
    let drawn_m = places(&trajectory.poses).chain(corners_m);
    let mut drawn_m: Vec<Point> = drawn_m.chain(around_things(picture.world, trajectory)).collect();
    drawn_m.extend(around_walls((picture.walls_m, picture.world), &drawn_m));
    let field = Field::around(drawn_m.into_iter(), picture.radius_m, header_px + 10.0);

    let last = trajectory.poses_at(trajectory.n_samples() - 1);
    let robots = last.iter().enumerate().map(|(index, pose)| {
        let stroke = if picture.lost.contains(&index) { LOST } else { INK };
        let class = picture.classes.get(index).copied();
        robot(&field, *pose, picture.radius_m, (stroke, class))
    });
    let names: Vec<String> = picture.names.iter().map(|name| short(name).to_owned()).collect();
    let (caption, bottom_px) = caption(picture, &rings, &field);
    let mut elements = header;
    elements.extend(walls(&field, picture.walls_m, picture.world));
    let last_sample = trajectory.n_samples() - 1;
    elements.extend(
        picture
            .world
            .into_iter()
            .flat_map(|world| things(&field, world, trajectory.objects_at(last_sample))),
    );
    elements.push(tracks(&field, trajectory, 0..first_of_tail + 1, BEFORE, 0.8));
    elements.push(tracks(&field, trajectory, first_of_tail..trajectory.n_samples(), TAIL, 1.5));
    elements.extend(trajectory.poses_at(0).iter().map(|pose| start(&field, *pose)));
    elements.extend(rings.iter().map(|(ring, _)| ring_circle(&field, *ring)));
    elements.extend(robots);
    elements.extend(tags(&field, last, &names, picture.radius_m));
    elements.extend(scale_bar(&field, bottom_px));
    elements.extend(caption);
    Ok((elements, bottom_px + 16.0))
}

/// Where a robot started.
fn start(field: &Field, pose: Pose) -> Element {
    let (x_px, y_px) = field.point(pose.x_m, pose.y_m);
    Element::circle((x_px, y_px), 2.2).with("fill", START)
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
    Ok(check_poses(trajectory)?)
}

/// The sample at which the tail begins.
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
        Element::path(&track::path(&track::simplified(&points, 0.3)))
    });
    Element::new("g")
        .outlined(stroke, width_px)
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
pub fn ring_of(phase: Phase, trajectory: &Trajectory, first_sample: usize) -> Option<Ring> {
    match phase {
        Phase::STABLE_MILLING | Phase::SEMI_STABLE_MILLING => {}
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
    Element::circle((x_px, y_px), ring.radius_m * field.px_per_m)
        .outlined(INK, 1.6)
        .with("stroke-dasharray", RING_DASHES)
}

/// The rings of a run with the number of robots on each: that of its phase, or those of several mills.
fn rings(picture: &TrajectoryPicture, first_sample: usize) -> Vec<(Ring, usize)> {
    let Some(phase) = picture.phase.filter(|phase| phase.behaviour() == Behaviour::MILLING) else {
        return Vec::new();
    };
    let mills = mills(picture.trajectory, first_sample);
    if mills.len() > 1 {
        return mills;
    }
    let ring = ring_of(phase, picture.trajectory, first_sample);
    ring.into_iter().map(|ring| (ring, picture.trajectory.n_robots)).collect()
}

/// Robots whose own circles have one centre belong to one mill: within this share of its radius.
const ONE_CENTRE: f64 = 0.5;

/// The mills of a run from a sample on: robots that went around one centre at least once, two or more of
/// them, with how many they are; the largest first.
fn mills(trajectory: &Trajectory, first_sample: usize) -> Vec<(Ring, usize)> {
    let n_robots = trajectory.n_robots;
    let mut mills: Vec<Vec<Ring>> = Vec::new();
    for robot in 0..n_robots {
        let places_m: Vec<Point> = trajectory.poses[first_sample * n_robots..]
            .iter()
            .skip(robot)
            .step_by(n_robots)
            .map(|pose| (pose.x_m, pose.y_m))
            .collect();
        let Some(circle) = circle_of(&places_m) else { continue };
        let is_its = |mill: &&mut Vec<Ring>| {
            let (centre_m, radius_m) = (mill[0].centre_m, mill[0].radius_m.max(circle.radius_m));
            let away_m =
                libm::hypot(centre_m.0 - circle.centre_m.0, centre_m.1 - circle.centre_m.1);
            away_m <= ONE_CENTRE * radius_m
        };
        match mills.iter_mut().find(is_its) {
            Some(mill) => mill.push(circle),
            None => mills.push(vec![circle]),
        }
    }
    mills.retain(|mill| mill.len() > 1);
    mills.sort_by_key(|mill| std::cmp::Reverse(mill.len()));
    let mean = |mill: &[Ring], number: fn(&Ring) -> f64| {
        mill.iter().map(number).sum::<f64>() / mill.len() as f64
    };
    let ring = |mill: Vec<Ring>| {
        let centre_m = (mean(&mill, |ring| ring.centre_m.0), mean(&mill, |ring| ring.centre_m.1));
        (Ring { centre_m, radius_m: mean(&mill, |ring| ring.radius_m) }, mill.len())
    };
    mills.into_iter().map(ring).collect()
}

/// The circle of one robot; `None` where it did not go around its own centre.
fn circle_of(places_m: &[Point]) -> Option<Ring> {
    let mean = |number: fn(&Point) -> f64| {
        places_m.iter().map(number).sum::<f64>() / places_m.len() as f64
    };
    let centre_m = (mean(|place| place.0), mean(|place| place.1));
    let from_centre = |place: &Point| (place.0 - centre_m.0, place.1 - centre_m.1);
    let turned_rad: f64 = places_m
        .windows(2)
        .map(|pair| (from_centre(&pair[0]), from_centre(&pair[1])))
        .map(|(one, other)| {
            libm::atan2(one.0 * other.1 - one.1 * other.0, one.0 * other.0 + one.1 * other.1)
        })
        .sum();
    let away_m = places_m.iter().map(from_centre).map(|(x_m, y_m)| libm::hypot(x_m, y_m));
    let radius_m = away_m.sum::<f64>() / places_m.len() as f64;
    (turned_rad.abs() >= std::f64::consts::TAU).then_some(Ring { centre_m, radius_m })
}

/// What the strokes mean, a line each, beside the scale bar.
fn caption(
    picture: &TrajectoryPicture,
    rings: &[(Ring, usize)],
    field: &Field,
) -> (Vec<Element>, f64) {
    let shown_s = picture.tail_s.min(picture.trajectory.duration_s());
    let dot = Element::circle((11.0, 0.0), 2.2).with("fill", START);
    let mut entries = vec![
        (stroke_mark(TAIL, 1.8), format!("the last {} s", label(shown_s))),
        (dot, "where robots started".to_owned()),
    ];
    if shown_s < picture.trajectory.duration_s() {
        entries.insert(1, (stroke_mark(BEFORE, 1.2), "before".to_owned()));
    }
    if !picture.lost.is_empty() {
        let text = "robots that did not take part to the end";
        entries.push((stroke_mark(LOST, 1.8), text.to_owned()));
    }
    if walls(field, picture.walls_m, picture.world).is_some() {
        let has_obstacles = picture.world.is_some_and(|world| !world.obstacles.is_empty());
        let text = if has_obstacles { "walls and obstacles" } else { "walls" };
        entries.push((stroke_mark(WALL, 3.0), text.to_owned()));
    }
    if let Some(world) = picture.world {
        entries.extend(things_in_words(world, picture.trajectory.n_objects));
    }
    entries.extend(lids(picture));
    let dashed = || stroke_mark(INK, 1.6).with("stroke-dasharray", RING_DASHES);
    match rings {
        [] => {}
        [(ring, _)] => {
            entries.push((dashed(), format!("ring: mean radius {:.2} m", ring.radius_m)));
        }
        several => {
            let numbers: Vec<String> = several.iter().map(|(_, n)| n.to_string()).collect();
            let radii: Vec<String> =
                several.iter().map(|(ring, _)| format!("{:.2}", ring.radius_m)).collect();
            let text = format!(
                "{} mills of {} robots: mean radii {} m",
                in_words(several.len()),
                and(&numbers),
                and(&radii)
            );
            entries.push((dashed(), text));
        }
    }
    let top_px = field.top_px + field.height_px + 2.0;
    let (elements, bottom_px) = legend(&entries, (MARGIN_PX, top_px), CAPTION_ROOM_PX);
    (elements, bottom_px - 6.0)
}

/// The colours of classes with their names; of more classes than colours several share one.
fn lids(picture: &TrajectoryPicture) -> Vec<(Element, String)> {
    let classes = picture.world.filter(|_| !picture.classes.is_empty()).map(|it| &it.classes);
    let mut entries: Vec<(String, Vec<String>)> = Vec::new();
    for (place, class) in classes.into_iter().flatten().enumerate() {
        let colour = lid(place).hex();
        match entries.iter_mut().find(|(other, _)| *other == colour) {
            Some((_, names)) => names.push(class.name.clone()),
            None => entries.push((colour, vec![class.name.clone()])),
        }
    }
    let entry = |(colour, names): (String, Vec<String>)| {
        let mark = Element::circle((11.0, 0.0), 5.0);
        let mark = mark.with("fill", &colour).stroked(INK, 1.2);
        (mark, format!("robots of class {}", and(&names)))
    };
    entries.into_iter().map(entry).collect()
}

fn in_words(n: usize) -> String {
    match n {
        2 => "two".to_owned(),
        3 => "three".to_owned(),
        n => n.to_string(),
    }
}

/// `5, 3 and 2`.
fn and(texts: &[String]) -> String {
    match texts {
        [] => String::new(),
        [one] => one.clone(),
        [first @ .., last] => format!("{} and {last}", first.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use rsrs_core::robot::controller::Command;

    use super::*;

    /// Two mills of 5 and 4 robots, three metres apart, and one robot that circles alone.
    fn two_mills() -> Trajectory {
        let mut trajectory = Trajectory::new(0.5, 10);
        for sample in 0..200 {
            for robot in 0..10 {
                let angle_rad = f64::from(robot) + 0.1 * f64::from(sample);
                let (sine, cosine) = libm::sincos(angle_rad);
                let x_m = match robot {
                    0..5 => 0.0,
                    5..9 => 3.0,
                    _ => 9.0,
                };
                trajectory.poses.push(Pose {
                    x_m: x_m + 0.6 * cosine,
                    y_m: 0.6 * sine,
                    heading_rad: angle_rad,
                });
                trajectory.commands.push(Command { speed_m_s: 0.1, turn_rate_rad_s: 0.2 });
            }
        }
        trajectory
    }

    #[test]
    fn two_mills_are_named_as_two_and_who_circles_alone_is_none() {
        let found = mills(&two_mills(), 0);
        assert_eq!(found.iter().map(|(_, n)| *n).collect::<Vec<_>>(), [5, 4]);
        assert!((found[1].0.centre_m.0 - 3.0).abs() < 0.1);
        assert!((found[0].0.radius_m - 0.6).abs() < 0.1);

        let svg = svg(&TrajectoryPicture {
            trajectory: &two_mills(),
            radius_m: 0.05,
            tail_s: 100.0,
            phase: Some(Phase::UNFORMED),
            lost: &[],
            names: &[],
            walls_m: None,
            world: None,
            classes: &[],
            title: "run".to_owned(),
            subtitle: String::new(),
            theme: Theme::Screen,
        })
        .unwrap();

        assert!(svg.contains("two mills of 5 and 4 robots: mean radii 0.60 and"), "{svg}");
        assert_eq!(svg.matches("stroke-dasharray").count(), 3, "two rings and the legend");
    }
}
