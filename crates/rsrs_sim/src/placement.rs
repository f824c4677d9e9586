//! Where the robots start, and where objects are then.

use std::fmt;

use rsrs_core::conditions::{Conditions, Placement, Sides};
use rsrs_core::help::Help;
use rsrs_core::robot::unicycle::Pose;
use rsrs_core::world::{FreeSpace, Object};

use crate::contact::Borders;
use crate::draw::{Purpose, RunKey, Stream};

/// Robots or objects that do not find room where they are to start.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error(
    "{count} {things} do not fit into {area}, {spacing_m:.3} m apart{} within the walls: {}at most \
     {at_most} ever fit",
    if *things == Things::Objects { ", clear of robots and" } else { " and" },
    placed.map_or_else(String::new, |placed| format!("{placed} were placed at random, and "))
)]
pub struct PlacementError {
    /// What they are.
    pub things: Things,
    /// How many were asked for.
    pub count: usize,
    /// Where their centres were to be.
    pub area: Area,
    /// Least distance between two centres, in metres.
    pub spacing_m: f64,
    /// Those that were placed before the tries ran out; `None` if more were asked for than ever fit.
    pub placed: Option<usize>,
    /// An upper bound on how many fit, by the density of the closest packing.
    pub at_most: usize,
}

/// What is placed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Things {
    /// Robots.
    Robots,
    /// Objects of the world.
    Objects,
}

impl fmt::Display for Things {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(match self {
            Self::Robots => "robots",
            Self::Objects => "objects",
        })
    }
}

/// Where the centres lie at the start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Area {
    /// A disc around the origin.
    Disc {
        /// Its radius, in metres.
        radius_m: f64,
    },
    /// A box around the origin.
    Box(Sides),
}

impl fmt::Display for Area {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Disc { radius_m } => write!(out, "a disc of radius {radius_m:.3} m"),
            Self::Box(Sides { width_m, height_m }) => {
                write!(out, "a box of {width_m:.3} m by {height_m:.3} m")
            }
        }
    }
}

impl Area {
    /// Half of the side of the square around it, in metres.
    fn half_m(self) -> f64 {
        match self {
            Self::Disc { radius_m } => radius_m,
            Self::Box(Sides { width_m, height_m }) => width_m.max(height_m) / 2.0,
        }
    }

    /// A pose in it that faces away from the origin; uniform for uniform numbers.
    fn facing_out(self, first: f64, second: f64) -> Pose {
        match self {
            Self::Disc { radius_m } => {
                let distance_m = radius_m * first.sqrt();
                let bearing_rad = std::f64::consts::TAU * second;
                let (sine, cosine) = libm::sincos(bearing_rad);
                Pose { x_m: distance_m * cosine, y_m: distance_m * sine, heading_rad: bearing_rad }
            }
            Self::Box(Sides { width_m, height_m }) => {
                let (x_m, y_m) = (width_m * (first - 0.5), height_m * (second - 0.5));
                Pose { x_m, y_m, heading_rad: libm::atan2(y_m, x_m) }
            }
        }
    }

    /// Centres at least `spacing_m` apart are discs of half that radius in an area that is wider by
    /// it; no packing is denser than the hexagonal one.
    fn most_that_fit(self, spacing_m: f64) -> usize {
        match self {
            Self::Disc { radius_m } => {
                let hexagonal = std::f64::consts::PI / 12_f64.sqrt();
                let ratio = (radius_m + spacing_m / 2.0) / (spacing_m / 2.0);
                (hexagonal * ratio * ratio).floor().max(1.0) as usize
            }
            Self::Box(Sides { width_m, height_m }) => {
                let area_m2 = (width_m + spacing_m) * (height_m + spacing_m);
                let each_m2 = spacing_m * spacing_m * 12_f64.sqrt() / 4.0;
                (area_m2 / each_m2).floor().max(1.0) as usize
            }
        }
    }
}

impl Help for PlacementError {
    fn help(&self) -> Option<String> {
        if self.things == Things::Objects {
            return Some("widen the arena, or take fewer or smaller `objects`".to_owned());
        }
        let area = match self.area {
            Area::Disc { .. } => "`placement_radius_m`",
            Area::Box(_) => "the box of `placement`",
        };
        Some(format!("widen {area} (and the arena), or take fewer `robots`"))
    }
}

/// Where robots head at the start.
#[derive(Clone, Copy)]
enum Headings {
    /// Away from the origin.
    Out,
    /// Anywhere, uniformly.
    AnyWay,
}

impl Headings {
    /// A pose anywhere in an area.
    fn pose(self, area: Area, stream: &mut Stream) -> Pose {
        let pose = area.facing_out(stream.uniform(), stream.uniform());
        match self {
            Self::Out => pose,
            Self::AnyWay => {
                let heading_rad = std::f64::consts::TAU * (stream.uniform() - 0.5);
                Pose { heading_rad, ..pose }
            }
        }
    }
}

/// Least distance between two centres at the start, in robot radii: a tenth more than touching.
const SPACING_RADII: f64 = 2.2;

/// The same over both radii; dimensionless.
const SPACING: f64 = SPACING_RADII / 2.0;

/// Places tried for one robot or object before giving up.
const MAX_TRIES: usize = 20_000;

/// Places every robot, each from its own stream of draws; shape `[n_robots]`.
pub fn place(conditions: &Conditions, run: RunKey) -> Result<Vec<Pose>, PlacementError> {
    let (area, headings) = match conditions.placement {
        Placement::DiscFacingOut { radius_m } => (Area::Disc { radius_m }, Headings::Out),
        Placement::BoxFacingOut(sides) => (Area::Box(sides), Headings::Out),
        Placement::BoxFacingAnyWay(sides) => (Area::Box(sides), Headings::AnyWay),
        // Checked conditions have at least one set, with a pose for each robot.
        Placement::Given { ref starts } => {
            let set = run.replicate() % starts.len() as u64;
            return Ok(starts[set as usize].clone());
        }
        Placement::Pair { distance_m, bearing_rad } => {
            let pair = pair(distance_m, bearing_rad);
            return Ok(pair.into_iter().take(conditions.robots).collect());
        }
    };
    let radius_m = conditions.largest_radius_m();
    let spacing_m = SPACING_RADII * radius_m;
    let at_most = area.most_that_fit(spacing_m);
    let count = conditions.robots;
    let refuse = |placed| {
        let things = Things::Robots;
        PlacementError { things, count, area, spacing_m, placed, at_most }
    };
    let standing: Vec<(f64, [f64; 2])> = (conditions.world.each_object())
        .filter_map(|object| Some((object.radius_m, object.place_m?)))
        .collect();
    let is_clear = |pose: &Pose| {
        standing.iter().all(|(object_m, place_m)| {
            let apart_m = libm::hypot(pose.x_m - place_m[0], pose.y_m - place_m[1]);
            apart_m >= SPACING * (radius_m + object_m)
        })
    };
    if conditions.robots > at_most {
        return Err(refuse(None));
    }
    let border = Borders::new(conditions).for_radius(radius_m);
    let mut poses: Vec<Pose> = Vec::with_capacity(conditions.robots);
    let mut taken = Taken::new(area.half_m(), spacing_m, conditions.robots);
    for robot in 0..conditions.robots {
        let mut stream = Stream::new(run, robot, Purpose::Placement);
        let place = (0..MAX_TRIES).map(|_| headings.pose(area, &mut stream)).find(|pose| {
            border.admits(pose.x_m as f32, pose.y_m as f32)
                && is_clear(pose)
                && taken.near(pose).all(|other| {
                    let other = &poses[other];
                    libm::hypot(pose.x_m - other.x_m, pose.y_m - other.y_m) >= spacing_m
                })
        });
        let pose = place.ok_or_else(|| refuse(Some(poses.len())))?;
        taken.add(&pose);
        poses.push(pose);
    }
    Ok(poses)
}

/// Places every object that has no place of its own anywhere in the arena, clear of robots, of other objects and of
/// walls, each from its own stream of draws. Centres are in metres, shape `[n_objects][2]`.
pub fn place_objects(
    conditions: &Conditions,
    run: RunKey,
    poses: &[Pose],
) -> Result<Vec<[f64; 2]>, PlacementError> {
    let side_m = conditions.arena.side_m;
    let space = conditions.free_space();
    let objects: Vec<Object> = conditions.world.each_object().collect();
    let robot =
        |(robot, pose): (usize, &Pose)| (conditions.robot_at(robot).radius_m, [pose.x_m, pose.y_m]);
    let mut taken: Vec<(f64, [f64; 2])> = poses.iter().enumerate().map(robot).collect();
    taken.extend(objects.iter().filter_map(|object| Some((object.radius_m, object.place_m?))));
    let mut places_m = Vec::with_capacity(objects.len());
    for (number, Object { radius_m, place_m, .. }) in objects.iter().copied().enumerate() {
        if let Some(place_m) = place_m {
            places_m.push(place_m);
            continue;
        }
        // The middle and the sides of the box that holds its centre.
        let (middle_m, inner_m) = match &space {
            None => ([0.0; 2], [side_m - 2.0 * radius_m; 2]),
            Some(space) => box_within(space, radius_m),
        };
        let area = Area::Box(Sides { width_m: inner_m[0], height_m: inner_m[1] });
        let mut stream = Stream::new(run, number, Purpose::Object);
        let mut anywhere =
            |_| [0, 1].map(|axis| middle_m[axis] + inner_m[axis] * (stream.uniform() - 0.5));
        let is_clear = |place_m: &[f64; 2]| {
            let is_free = |space: &FreeSpace| space.clearance_m(*place_m) >= radius_m;
            space.as_ref().is_none_or(is_free)
                && taken.iter().all(|(other_radius_m, other_m)| {
                    let apart_m = libm::hypot(place_m[0] - other_m[0], place_m[1] - other_m[1]);
                    apart_m >= SPACING * (radius_m + other_radius_m)
                })
        };
        let found = (0..MAX_TRIES).map(&mut anywhere).find(is_clear);
        let place_m = found.ok_or_else(|| {
            let spacing_m = SPACING_RADII * radius_m;
            PlacementError {
                things: Things::Objects,
                count: objects.len(),
                area,
                spacing_m,
                placed: Some(number),
                at_most: area.most_that_fit(spacing_m),
            }
        })?;
        taken.push((radius_m, place_m));
        places_m.push(place_m);
    }
    Ok(places_m)
}

/// The middle, and width and height, of the box that holds all centres of discs of a radius in an arena, in metres.
fn box_within(space: &FreeSpace, radius_m: f64) -> ([f64; 2], [f64; 2]) {
    let [low_m, high_m] = space.border().bounds_m();
    let middle_m = [0, 1].map(|axis| f64::midpoint(low_m[axis], high_m[axis]));
    (middle_m, [0, 1].map(|axis| (high_m[axis] - low_m[axis] - 2.0 * radius_m).max(0.0)))
}

/// Which places are taken: a uniform grid over the area, so that a candidate is compared only with
/// the robots in adjacent cells.
struct Taken {
    corner_m: f64,
    cell_m: f64,
    per_side: usize,
    /// The last robot in each cell, and for each robot the one before it in its cell.
    last: Vec<Option<usize>>,
    before: Vec<Option<usize>>,
}

impl Taken {
    fn new(radius_m: f64, spacing_m: f64, robots: usize) -> Self {
        // A little wider, for rounding; and no more cells than a few for each robot.
        let per_side_at_most = 2.0 * (robots as f64).sqrt() + 1.0;
        let cell_m = (spacing_m * (1.0 + 1e-9)).max(2.0 * radius_m / per_side_at_most);
        let per_side = (2.0 * radius_m / cell_m).ceil() as usize + 1;
        Self {
            corner_m: -radius_m,
            cell_m,
            per_side,
            last: vec![None; per_side * per_side],
            before: Vec::with_capacity(robots),
        }
    }

    fn add(&mut self, pose: &Pose) {
        let cell = self.index(pose.y_m) * self.per_side + self.index(pose.x_m);
        self.before.push(self.last[cell]);
        self.last[cell] = Some(self.before.len() - 1);
    }

    /// All robots within the spacing, and some more.
    fn near(&self, pose: &Pose) -> impl Iterator<Item = usize> + '_ {
        let around = |coordinate_m| {
            let index = self.index(coordinate_m);
            index.saturating_sub(1)..=(index + 1).min(self.per_side - 1)
        };
        let columns = around(pose.x_m);
        let cells = around(pose.y_m)
            .flat_map(move |row| columns.clone().map(move |column| row * self.per_side + column));
        cells.flat_map(|cell| std::iter::successors(self.last[cell], |robot| self.before[*robot]))
    }

    fn index(&self, coordinate_m: f64) -> usize {
        (((coordinate_m - self.corner_m) / self.cell_m) as usize).min(self.per_side - 1)
    }
}

/// A robot, and another beside it that faces away.
fn pair(distance_m: f64, bearing_rad: f64) -> [Pose; 2] {
    let (sine, cosine) = libm::sincos(bearing_rad);
    let first = Pose { x_m: 0.0, y_m: 0.0, heading_rad: 0.0 };
    [first, Pose { x_m: distance_m * cosine, y_m: distance_m * sine, heading_rad: bearing_rad }]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draw::Seed;
    use rsrs_testing::conditions::flockbot_conditions;

    fn run(replicate: u64) -> RunKey {
        RunKey::new(Seed { seed: 1, replicate }, 0)
    }

    #[test]
    fn robots_start_apart_in_the_disc_and_face_away_from_its_centre() {
        for replicate in 0..100 {
            let poses = place(&flockbot_conditions(), run(replicate)).unwrap();

            assert_eq!(poses.len(), 9);
            for (robot, pose) in poses.iter().enumerate() {
                assert!(libm::hypot(pose.x_m, pose.y_m) <= 0.825);
                let away = libm::atan2(pose.y_m, pose.x_m) - pose.heading_rad;
                assert!(libm::sin(away).abs() < 1e-9 && libm::cos(away) > 0.0);
                for other in &poses[..robot] {
                    assert!(libm::hypot(pose.x_m - other.x_m, pose.y_m - other.y_m) >= 0.165);
                }
            }
        }
    }

    #[test]
    fn a_start_in_the_disc_is_uniform() {
        let conditions = Conditions { robots: 1, ..flockbot_conditions() };

        let inner = (0..10_000)
            .filter(|replicate| {
                let pose = place(&conditions, run(*replicate)).unwrap()[0];
                libm::hypot(pose.x_m, pose.y_m) < 0.825 / 2.0
            })
            .count();

        // A quarter of the area, within four standard errors.
        assert!((inner as f64 / 10_000.0 - 0.25).abs() < 0.018, "{inner}");
    }

    #[test]
    fn a_start_in_a_box_is_uniform_and_faces_out_or_heads_anywhere_uniformly() {
        let (width_m, height_m) = (2.0, 0.5);
        for placement in [
            Placement::BoxFacingOut(Sides { width_m, height_m }),
            Placement::BoxFacingAnyWay(Sides { width_m, height_m }),
        ] {
            let faces_out = matches!(placement, Placement::BoxFacingOut { .. });
            let conditions = Conditions { robots: 1, placement, ..flockbot_conditions() };
            let (mut right, mut upper, mut backward, mut out) = (0, 0, 0, 0);
            for replicate in 0..10_000 {
                let pose = place(&conditions, run(replicate)).unwrap()[0];
                assert!(pose.x_m.abs() <= 1.0 && pose.y_m.abs() <= 0.25, "{pose:?}");
                let away_rad = libm::atan2(pose.y_m, pose.x_m) - pose.heading_rad;
                assert!(!faces_out || away_rad.abs() < 1e-9, "{pose:?}");
                right += u32::from(pose.x_m > 0.5);
                upper += u32::from(pose.y_m > 0.125);
                backward += u32::from(libm::cos(pose.heading_rad) < -0.5_f64.sqrt());
                out += u32::from(libm::cos(away_rad) > 0.5_f64.sqrt());
            }

            let headings = if faces_out { vec![] } else { vec![backward, out] };
            // A quarter of each, within four standard errors.
            for share in [right, upper].into_iter().chain(headings).map(f64::from) {
                assert!((share / 10_000.0 - 0.25).abs() < 0.018, "{faces_out}: {share}");
            }
        }
    }

    #[test]
    fn too_many_robots_are_refused_with_how_many_fit() {
        let refused = |placement| {
            let conditions = Conditions { robots: 200, placement, ..flockbot_conditions() };
            place(&conditions, run(0)).unwrap_err()
        };

        assert_eq!(
            refused(flockbot_conditions().placement).to_string(),
            "200 robots do not fit into a disc of radius 0.825 m, 0.165 m apart and within the \
             walls: at most 109 ever fit"
        );
        let error = refused(Placement::BoxFacingOut(Sides { width_m: 1.0, height_m: 0.5 }));
        let text = error.to_string();
        assert!(text.contains("do not fit into a box of 1.000 m by 0.500 m"), "{text}");
        let help = error.help().unwrap();
        assert!(help.contains("widen the box of `placement`"), "{help}");
    }

    #[test]
    fn robots_that_could_only_fit_by_design_are_refused_after_bounded_tries() {
        let conditions = Conditions { robots: 90, ..flockbot_conditions() };

        let error = place(&conditions, run(0)).unwrap_err();

        assert!(error.placed.is_some_and(|placed| (40..90).contains(&placed)), "{error}");
    }

    #[test]
    fn robots_start_within_the_walls() {
        let mut conditions = flockbot_conditions();
        conditions.arena.side_m = 1.2;

        let poses = place(&conditions, run(0)).unwrap();

        assert!(poses.iter().all(|pose| pose.x_m.abs() <= 0.525 && pose.y_m.abs() <= 0.525));
    }

    #[test]
    fn a_neighbour_stands_at_its_distance_and_bearing_from_the_first_robot() {
        let placement = Placement::Pair { distance_m: 0.5, bearing_rad: -0.2 };
        let mut conditions = Conditions { robots: 2, placement, ..flockbot_conditions() };
        conditions.check().unwrap();

        let poses = place(&conditions, run(0)).unwrap();

        assert_eq!(poses[0], Pose { x_m: 0.0, y_m: 0.0, heading_rad: 0.0 });
        assert!((libm::hypot(poses[1].x_m, poses[1].y_m) - 0.5).abs() < 1e-12);
        assert!((libm::atan2(poses[1].y_m, poses[1].x_m) + 0.2).abs() < 1e-12);
        conditions.robots = 3;
        let error = conditions.check().unwrap_err().to_string();
        assert_eq!(error, "robots is 3, expected a number from 0 to 2");
    }

    #[test]
    fn the_grid_changes_no_place() {
        let conditions = Conditions { robots: 60, ..flockbot_conditions() };
        let area = Area::Disc { radius_m: 0.825 };
        let poses = place(&conditions, run(0)).unwrap();

        for (robot, pose) in poses.iter().enumerate() {
            let mut stream = Stream::new(run(0), robot, Purpose::Placement);
            let first_free = (0..MAX_TRIES)
                .map(|_| area.facing_out(stream.uniform(), stream.uniform()))
                .find(|place| {
                    poses[..robot].iter().all(|other| {
                        libm::hypot(place.x_m - other.x_m, place.y_m - other.y_m) >= 0.165
                    })
                });
            assert_eq!(first_free, Some(*pose));
        }
    }

    #[test]
    fn many_robots_find_their_places_soon() {
        let mut conditions = Conditions { robots: 20_000, ..flockbot_conditions() };
        conditions.placement = Placement::DiscFacingOut { radius_m: 39.0 };
        conditions.arena.side_m = 100.0;

        assert_eq!(place(&conditions, run(0)).unwrap().len(), 20_000);
    }
}
