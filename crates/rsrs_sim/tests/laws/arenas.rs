//! The laws of arenas that are no squares, and of obstacles.

use rsrs_core::conditions::{Arena, Conditions, Placement, Sides, Walls};
use rsrs_core::robot::contact::ContactModel;
use rsrs_core::robot::controller::Command;
use rsrs_core::robot::region::Region;
use rsrs_core::robot::sensor::{Detects, SensorDetails};
use rsrs_core::robot::unicycle::Pose;
use rsrs_core::world::{ArenaShape, Obstacle, WorldFile};
use rsrs_sim::batch::runs_in_lanes;
use rsrs_sim::draw::Seed;
use rsrs_sim::world::World;
use rsrs_testing::conditions::{exact_reading, objects_anywhere};
use rsrs_testing::draw::Draw;

use crate::support::{self, Crowd, HARSHER, PERFECT, SEED, at, flockbots, steered_digest};

const ROBOT_M: f64 = 0.075;
/// What single precision may do to a place in these arenas, in metres.
const ROUNDING_M: f64 = 5e-6;

fn rectangle(width_m: f64, height_m: f64) -> ArenaShape {
    ArenaShape { rectangle_m: Some([width_m, height_m]), ..ArenaShape::default() }
}

fn disc(radius_m: f64) -> ArenaShape {
    ArenaShape { disc_m: Some(radius_m), ..ArenaShape::default() }
}

fn polygon(corners_m: &[[f64; 2]]) -> ArenaShape {
    ArenaShape { polygon_m: Some(corners_m.to_vec()), ..ArenaShape::default() }
}

fn pillar(place_m: [f64; 2], radius_m: f64) -> Obstacle {
    Obstacle { place_m: Some(place_m), radius_m: Some(radius_m), polygon_m: None }
}

fn block(corners_m: &[[f64; 2]]) -> Obstacle {
    Obstacle { polygon_m: Some(corners_m.to_vec()), ..Obstacle::default() }
}

/// An L of two rooms, whose inner corner points at the origin.
const L: [[f64; 2]; 6] =
    [[-1.2, -1.2], [1.2, -1.2], [1.2, 0.2], [0.2, 0.2], [0.2, 1.2], [-1.2, 1.2]];
/// A triangle with a corner of 30°.
const SHARP: [[f64; 2]; 3] = [[-1.6, -0.8], [1.6, -0.8], [1.6, 1.05]];

/// Whether a place is in a polygon, by how often one turns around it.
fn winds(corners_m: &[[f64; 2]], [x, y]: [f64; 2]) -> bool {
    let n = corners_m.len();
    let turn = |side: usize| {
        let ([ax, ay], [bx, by]) = (corners_m[side], corners_m[(side + 1) % n]);
        let (from, to) = (libm::atan2(ay - y, ax - x), libm::atan2(by - y, bx - x));
        libm::remainder(to - from, std::f64::consts::TAU)
    };
    (0..n).map(turn).sum::<f64>().abs() > 3.0
}

/// How far a place is from the border of a polygon: by many points of it.
fn from_border_m(corners_m: &[[f64; 2]], [x, y]: [f64; 2]) -> f64 {
    let n = corners_m.len();
    let away_m = |side: usize| {
        let ([ax, ay], [bx, by]) = (corners_m[side], corners_m[(side + 1) % n]);
        let length_m = libm::hypot(bx - ax, by - ay);
        let (along_x, along_y) = ((bx - ax) / length_m, (by - ay) / length_m);
        let along_m = ((x - ax) * along_x + (y - ay) * along_y).clamp(0.0, length_m);
        libm::hypot(x - ax - along_m * along_x, y - ay - along_m * along_y)
    };
    (0..n).map(away_m).fold(f64::INFINITY, f64::min)
}

/// By how much a disc is clear of all walls of a world, in metres, by definition.
fn clear_m(world: &WorldFile, side_m: f64, place_m: [f64; 2], radius_m: f64) -> f64 {
    let [x, y] = place_m;
    let within = |corners_m: &[[f64; 2]], is_around: bool| {
        let away_m = from_border_m(corners_m, place_m);
        if winds(corners_m, place_m) == is_around { away_m } else { -away_m }
    };
    let arena = world.arena.clone().unwrap_or_else(|| rectangle(side_m, side_m));
    let of_border_m = match (arena.rectangle_m, arena.disc_m, arena.polygon_m) {
        (Some([width_m, height_m]), ..) => (width_m / 2.0 - x.abs()).min(height_m / 2.0 - y.abs()),
        (_, Some(around_m), _) => around_m - libm::hypot(x, y),
        (.., corners_m) => within(&corners_m.expect("it is one of three"), true),
    };
    let of_obstacle_m = |obstacle: &Obstacle| match (obstacle.place_m, obstacle.radius_m) {
        (Some([at_x, at_y]), Some(around_m)) => libm::hypot(x - at_x, y - at_y) - around_m,
        _ => within(obstacle.polygon_m.as_ref().expect("it is a polygon"), false),
    };
    let obstacles = world.obstacles.iter().map(of_obstacle_m);
    obstacles.fold(of_border_m, f64::min) - radius_m
}

/// Worlds of all shapes, and how wide the square around each is.
fn worlds() -> Vec<(WorldFile, f64)> {
    let shaped = |arena: ArenaShape| WorldFile { arena: Some(arena), ..WorldFile::NOTHING };
    let square = WorldFile {
        obstacles: vec![
            pillar([0.6, 0.6], 0.2),
            block(&[[-0.9, -0.8], [-0.4, -0.8], [-0.6, -0.4]]),
        ],
        ..WorldFile::NOTHING
    };
    let courtyard = WorldFile {
        arena: Some(disc(1.3)),
        // A U that opens towards the middle, and a pillar that sticks out of the wall.
        obstacles: vec![
            block(&[
                [0.5, -0.5],
                [1.0, -0.5],
                [1.0, 0.5],
                [0.5, 0.5],
                [0.5, 0.3],
                [0.8, 0.3],
                [0.8, -0.3],
                [0.5, -0.3],
            ]),
            pillar([-1.2, 0.0], 0.3),
        ],
        ..WorldFile::NOTHING
    };
    vec![
        (shaped(rectangle(3.0, 1.4)), 3.0),
        (shaped(disc(1.0)), 2.0),
        (shaped(polygon(&L)), 2.4),
        (shaped(polygon(&SHARP)), 3.2),
        (square, 2.4),
        (courtyard, 2.6),
    ]
}

fn conditions(world: WorldFile, side_m: f64, walls: Walls) -> Conditions {
    let mut conditions = flockbots(0.15, 0.75, &PERFECT);
    conditions.placement = Placement::BoxFacingAnyWay(Sides { width_m: side_m, height_m: side_m });
    conditions.arena = Arena { side_m, walls };
    conditions.world = world;
    conditions
}

#[test]
fn no_body_is_ever_in_a_wall_whatever_shape_it_has_and_however_robots_drive() {
    for ((world, side_m), walls) in worlds()
        .into_iter()
        .flat_map(|world| [Walls::Clamp, Walls::Stop].map(|it| (world.clone(), it)))
    {
        for (contact, way_m) in [
            (ContactModel::Stop, 0.02),
            (ContactModel::Push, 0.02),
            (ContactModel::None, 0.05),
            (ContactModel::Push, 0.2),
            // Farther than the arena is wide.
            (ContactModel::None, 7.0),
        ] {
            let count = if contact == ContactModel::None { 1 } else { 6 };
            let world =
                WorldFile { objects: vec![objects_anywhere(count, 0.05, 0.2)], ..world.clone() };
            let mut conditions = conditions(world, side_m, walls);
            conditions.controller = flockbots(way_m / 0.13, 2.0, &PERFECT).controller;
            conditions.robots = 6;
            conditions.robot.contact = contact;
            conditions.robot.gust_sd_m_s = 0.05;
            conditions.check().expect("it makes a world");
            assert!(!runs_in_lanes(&conditions, 60.0));
            let mut crowd = Crowd::new(conditions);
            let mut world = World::new(&crowd.conditions, SEED).expect("they fit");
            let mut n_touching = 0;
            for step in 0..150 {
                world.sense();
                world.advance(&crowd.commands());

                let file = &crowd.conditions.world;
                let robots = world.poses().map(|pose| (ROBOT_M, [pose.x_m, pose.y_m]));
                let objects = world.objects_m().map(|place_m| (0.05, place_m));
                for (radius_m, place_m) in robots.chain(objects) {
                    let clear_m = clear_m(file, side_m, place_m, radius_m);
                    assert!(
                        clear_m >= -ROUNDING_M,
                        "{file:?} {walls:?} {contact:?} {way_m} {step}: {place_m:?} {clear_m}"
                    );
                    n_touching += u32::from(clear_m < ROUNDING_M);
                }
            }
            let may_stop_before = walls == Walls::Stop;
            assert!(
                may_stop_before || n_touching > 10,
                "{walls:?} {contact:?} {way_m}: {n_touching}"
            );
        }
    }
}

/// Nine robots that start somewhere in a square of 2 m and see walls and each other.
fn in_square(world: WorldFile, (contact, walls): (ContactModel, Walls)) -> Conditions {
    let mut conditions = conditions(world, 2.0, walls);
    let mut draw = Draw::new(11);
    let start = |robot: u32| Pose {
        x_m: 0.46 * f64::from(robot % 3) - 0.46,
        y_m: 0.46 * f64::from(robot / 3) - 0.46,
        heading_rad: 6.0 * draw.uniform(),
    };
    conditions.placement = Placement::Given { starts: vec![(0..9).map(start).collect()] };
    conditions.robot.contact = contact;
    conditions.robot.region = Region::Cone { half_angle_rad: 0.3, range_m: 0.5 };
    conditions.robot.details = SensorDetails {
        hidden_by: vec![Detects::Robot, Detects::Wall],
        or: if walls == Walls::None {
            Vec::new()
        } else {
            vec![exact_reading("wall", Detects::Wall)]
        },
        ..SensorDetails::default()
    };
    conditions.check().expect("it makes a world");
    conditions
}

#[test]
fn a_square_that_is_given_as_a_rectangle_or_a_polygon_is_the_square_within_rounding() {
    let corners = [[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]];
    // With a corner in the middle of a side.
    let five = [[-1.0, -1.0], [0.1, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
    let mut n_seen = 0;
    for (contact, walls) in [
        (ContactModel::Stop, Walls::Clamp),
        (ContactModel::Stop, Walls::Stop),
        (ContactModel::Push, Walls::Clamp),
        (ContactModel::None, Walls::Clamp),
        (ContactModel::None, Walls::None),
    ] {
        let run = |arena: Option<ArenaShape>| {
            let file = WorldFile { arena, ..WorldFile::NOTHING };
            let conditions = in_square(file, (contact, walls));
            let mut world = World::new(&conditions, SEED).expect("they are there");
            let mut draw = Draw::new(2);
            let mut all = Vec::new();
            for _ in 0..200 {
                let readings = world.sense_all().to_vec();
                all.push((readings, world.poses().collect::<Vec<Pose>>()));
                let mut command = |_| Command {
                    speed_m_s: 0.3 * draw.uniform(),
                    turn_rate_rad_s: draw.uniform() - 0.5,
                };
                world.advance(&(0..9).map(&mut command).collect::<Vec<Command>>());
            }
            all
        };
        let square = run(None);
        for arena in [rectangle(2.0, 2.0), polygon(&corners), polygon(&five)] {
            for (step, (found, expected)) in
                run(Some(arena.clone())).iter().zip(&square).enumerate()
            {
                assert_eq!(found.0, expected.0, "{arena:?} {contact:?} {walls:?} {step}");
                n_seen += found.0.iter().filter(|readings| readings.has(1)).count();
                for (one, other) in found.1.iter().zip(&expected.1) {
                    let apart_m = libm::hypot(one.x_m - other.x_m, one.y_m - other.y_m);
                    assert!(apart_m < 1e-4, "{arena:?} {contact:?} {walls:?} {step}: {apart_m}");
                }
            }
        }
    }
    assert!(n_seen > 1000, "walls were seen: {n_seen}");
}

/// Drives one robot straight ahead.
fn driven(world: WorldFile, side_m: f64, start: Pose, n_steps: usize) -> Pose {
    let mut conditions = conditions(world, side_m, Walls::Clamp);
    conditions.robots = 1;
    conditions.robot.speed_gain.mean = 1.0;
    conditions.placement = Placement::Given { starts: vec![vec![start]] };
    let ahead = [Command { speed_m_s: 0.1, turn_rate_rad_s: 0.0 }];
    support::driven(&conditions, &ahead, n_steps).poses().next().expect("one")
}

#[test]
fn a_robot_slides_along_a_round_wall_and_around_a_pillar_to_where_it_is_held() {
    let room = WorldFile { arena: Some(disc(1.0)), ..WorldFile::NOTHING };
    let start = Pose { x_m: 0.0, y_m: 0.3, heading_rad: 0.0 };

    // Straight ahead is the outermost point of the wall.
    let end = driven(room, 2.0, start, 2000);
    assert!((end.x_m - 0.925).abs() < 1e-4 && end.y_m.abs() < 2e-2, "{end:?}");

    let pillar = WorldFile { obstacles: vec![pillar([0.0, 0.0], 0.3)], ..WorldFile::NOTHING };
    let start = Pose { x_m: -1.0, y_m: 0.05, heading_rad: 0.0 };
    let end = driven(pillar, 4.0, start, 200);
    assert!(end.x_m > 0.5, "it came past: {end:?}");
    assert!((end.y_m - 0.375).abs() < 1e-3, "beside the pillar: {end:?}");
}

#[test]
fn robots_start_anywhere_in_the_arena_clear_of_walls_and_so_do_objects() {
    for (world, side_m) in worlds() {
        let world = WorldFile { objects: vec![objects_anywhere(3, 0.1, 0.0)], ..world };
        let mut conditions = conditions(world, side_m, Walls::Stop);
        conditions.robots = 4;
        conditions.check().expect("it makes a world");
        let [mut left, mut upper] = [0, 0];
        for replicate in 0..100 {
            let world = World::new(&conditions, Seed { seed: 1, replicate }).expect("they fit");
            let robots = world.poses().map(|pose| (ROBOT_M, [pose.x_m, pose.y_m]));
            for (radius_m, place_m) in robots.chain(world.objects_m().map(|it| (0.1, it))) {
                let clear_m = clear_m(&conditions.world, side_m, place_m, radius_m);
                assert!(clear_m >= -ROUNDING_M, "{:?}: {place_m:?}", conditions.world);
                left += u32::from(place_m[0] < -0.3);
                upper += u32::from(place_m[1] > 0.0);
            }
        }
        assert!(left > 70 && upper > 70, "{:?}: {left} {upper}", conditions.world);
    }
}

/// What the first robot reports, which is at the origin and looks along x; others are where they are.
fn reported(world: WorldFile, hidden_by: Vec<Detects>, others: &[[f64; 2]]) -> Option<String> {
    let mut conditions = conditions(world, 6.0, Walls::Stop);
    let or = vec![exact_reading("wall", Detects::Wall)];
    conditions.robot.region = Region::Cone { half_angle_rad: 0.1, range_m: 1.5 };
    conditions.robot.details = SensorDetails { hidden_by, or, ..SensorDetails::default() };
    let mut starts = vec![at(0.0, 0.0, 0.0)];
    starts.extend(others.iter().map(|[x_m, y_m]| at(*x_m, *y_m, 0.0)));
    conditions.robots = starts.len();
    conditions.placement = Placement::Given { starts: vec![starts] };
    support::reported(&conditions).swap_remove(0).into_iter().next()
}

#[test]
fn obstacles_are_walls_to_sensors_and_hide_what_is_behind_them_if_walls_do() {
    let with = |obstacles: Vec<Obstacle>| WorldFile { obstacles, ..WorldFile::NOTHING };
    let reports = |obstacles, hidden_by: &[Detects], others: &[[f64; 2]]| {
        reported(with(obstacles), hidden_by.to_vec(), others)
    };
    let far = || vec![pillar([0.0, -2.0], 0.1)];
    let between = || vec![pillar([0.6, 0.0], 0.1)];
    let beam = || vec![block(&[[0.5, -0.5], [0.6, -0.5], [0.6, 0.5], [0.5, 0.5]])];

    assert_eq!(reports(far(), &[], &[]), None);
    assert_eq!(reports(far(), &[], &[[1.0, 0.0]]).as_deref(), Some("detection"));
    for obstacles in [between(), beam()] {
        assert_eq!(reports(obstacles.clone(), &[], &[]).as_deref(), Some("wall"));
        // The nearest is reported.
        assert_eq!(reports(obstacles.clone(), &[], &[[0.3, 0.0]]).as_deref(), Some("detection"));
        let nearest = reports(obstacles.clone(), &[Detects::Wall], &[[1.0, 0.0]]);
        assert_eq!(nearest.as_deref(), Some("wall"));
    }
    // A robot beyond a pillar beside the way: the way to its centre is what counts.
    let beside = || vec![pillar([0.6, 0.25], 0.12)];
    assert_eq!(reports(beside(), &[Detects::Wall], &[[1.0, 0.0]]).as_deref(), Some("detection"));
}

#[test]
fn walls_hide_robots_from_sensors_that_see_robots_alone_and_around_a_corner() {
    let detects = |world: &WorldFile, hidden_by: Vec<Detects>, from: [f64; 3], to: [f64; 2]| {
        let mut conditions = conditions(world.clone(), 3.0, Walls::Clamp);
        conditions.robot.region = Region::Cone { half_angle_rad: 0.2, range_m: 3.0 };
        conditions.robot.details = SensorDetails { hidden_by, ..SensorDetails::default() };
        let starts = vec![at(from[0], from[1], from[2]), at(to[0], to[1], 0.0)];
        conditions.robots = 2;
        conditions.placement = Placement::Given { starts: vec![starts] };
        conditions.check().expect("it makes a world");
        World::new(&conditions, SEED).expect("they are there").sense()[0]
    };
    let l_shaped = WorldFile { arena: Some(polygon(&L)), ..WorldFile::NOTHING };
    let towards = |from: [f64; 2], to: [f64; 2]| {
        [from[0], from[1], libm::atan2(to[1] - from[1], to[0] - from[0])]
    };
    let (upper, right, corner) = ([-0.2, 1.0], [1.0, -0.2], [-1.0, -1.0]);

    for (from, to, is_around_the_corner) in
        [(upper, right, true), (upper, corner, false), (right, corner, false), (right, upper, true)]
    {
        let look = towards(from, to);
        assert!(detects(&l_shaped, Vec::new(), look, to), "{from:?} {to:?}");
        let sees = detects(&l_shaped, vec![Detects::Wall], look, to);
        assert_eq!(sees, !is_around_the_corner, "{from:?} {to:?}");
    }
}

#[test]
fn where_there_are_no_walls_nothing_holds_and_obstacles_are_refused() {
    let world = WorldFile { arena: Some(disc(0.5)), ..WorldFile::NOTHING };
    let mut conditions = conditions(world, 1.0, Walls::None);
    conditions.robots = 1;
    conditions.robot.speed_gain.mean = 1.0;
    conditions.placement = Placement::Given { starts: vec![vec![at(0.0, 0.0, 0.0)]] };
    let ahead = [Command { speed_m_s: 0.1, turn_rate_rad_s: 0.0 }];
    let end = support::driven(&conditions, &ahead, 100).poses().next().expect("one");
    assert!((end.x_m - 1.3).abs() < 1e-4, "{end:?}");

    conditions.world.obstacles = vec![pillar([0.2, 0.0], 0.1)];
    let error = conditions.check().expect_err("obstacles are walls").to_string();
    assert_eq!(error, "the world has obstacles, which are walls, and `walls` is none");
}

#[test]
fn arenas_of_all_shapes_have_the_bits_that_they_always_had() {
    let found = worlds().into_iter().map(|(world, side_m)| {
        let mut conditions = flockbots(0.15, 0.75, &HARSHER);
        conditions.placement =
            Placement::BoxFacingAnyWay(Sides { width_m: side_m, height_m: side_m });
        conditions.arena = Arena { side_m, walls: Walls::Clamp };
        conditions.robot.details.hidden_by = vec![Detects::Wall];
        conditions.robot.contact = ContactModel::Push;
        conditions.world = WorldFile { objects: vec![objects_anywhere(3, 0.06, 0.1)], ..world };
        conditions.robots = 5;
        steered_digest(&conditions)
    });
    let found: Vec<String> = found.collect();

    assert_eq!(found, GOLDEN);
}

/// Of the worlds above, in their order.
const GOLDEN: [&str; 6] = [
    "2b0ef59edbd08028",
    "0291e1caab99e77b",
    "f15c74692fe2fb26",
    "eadba17a27fabc68",
    "aaa351d9f055d3c9",
    "bb1c18ab109ebbd8",
];
