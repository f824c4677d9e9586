//! The laws of objects, which robots push, and of goals.

use rsrs_core::conditions::{Arena, Conditions, Placement, Sides, Walls};
use rsrs_core::judge::behaviour::Behaviour;
use rsrs_core::robot::contact::ContactModel;
use rsrs_core::robot::controller::Command;
use rsrs_core::robot::region::Region;
use rsrs_core::robot::sensor::{Detects, SensorDetails};
use rsrs_core::robot::unicycle::Pose;
use rsrs_core::world::{Goal, ObjectGroup, WorldFile};
use rsrs_sim::batch::runs_in_lanes;
use rsrs_sim::draw::Seed;
use rsrs_sim::episode::{episode_digests, run_episode};
use rsrs_sim::pushing::SLACK;
use rsrs_sim::world::World;
use rsrs_testing::conditions::{exact_reading, objects_anywhere};
use rsrs_testing::draw::Draw;

use crate::support::{self, Crowd, HARSHER, SEED, assert_judged_alike, at, drive, flockbots};

const ROBOT_M: f64 = 0.075;
const OBJECT_M: f64 = 0.05;
/// What a robot drives in a step, in metres.
const STEP_M: f64 = 0.02;
/// What single precision may do to a place, in metres.
const ROUNDING_M: f64 = 1e-6;

/// Objects of one size at these places.
fn objects(places_m: Vec<[f64; 2]>, friction: f64) -> WorldFile {
    WorldFile { objects: vec![placed(places_m, OBJECT_M, friction)], ..WorldFile::NOTHING }
}

fn placed(places_m: Vec<[f64; 2]>, radius_m: f64, friction: f64) -> ObjectGroup {
    ObjectGroup { count: None, places_m: Some(places_m), ..objects_anywhere(0, radius_m, friction) }
}

/// Robots that follow commands exactly, at given poses in a square of 4 m.
fn exact(contact: ContactModel, poses: Vec<Pose>, world: WorldFile) -> Conditions {
    let arena = Arena { side_m: 4.0, walls: Walls::Clamp };
    Conditions { arena, world, ..support::exact(contact, poses) }
}

/// Where robots and objects are after steps of these commands.
fn driven(
    conditions: &Conditions,
    commands: &[Command],
    n_steps: usize,
) -> (Vec<Pose>, Vec<[f64; 2]>) {
    let world = support::driven(conditions, commands, n_steps);
    (world.poses().collect(), world.objects_m().collect())
}

fn apart_m(one: [f64; 2], other: [f64; 2]) -> f64 {
    libm::hypot(one[0] - other[0], one[1] - other[1])
}

fn bits(places_m: &[[f64; 2]]) -> Vec<[u64; 2]> {
    places_m.iter().map(|place_m| place_m.map(f64::to_bits)).collect()
}

#[test]
fn robots_push_rows_of_objects_each_as_its_kind_of_contact_does() {
    for n_objects in [1_u32, 3, 8, 16] {
        let first_m = ROBOT_M + OBJECT_M + 1e-5;
        let place_m =
            |object: u32| [first_m + f64::from(object) * (2.0 * OBJECT_M + 1e-5) - 1.8, 0.0];
        let row: Vec<[f64; 2]> = (0..n_objects).map(place_m).collect();
        let way_m = |contact| {
            let world = objects(row.clone(), 0.0);
            let conditions = exact(contact, vec![at(-1.8, 0.0, 0.0)], world);
            let (robots, pushed) = driven(&conditions, &[drive(STEP_M)], 50);
            let ways_m = pushed.iter().zip(&row).map(|(to, from)| to[0] - from[0]);
            let way_m = robots[0].x_m + 1.8;
            let slack_m = f64::from(n_objects) * (SLACK * 2.0 * ROBOT_M + 1e-5);
            for of_object in ways_m {
                assert!((of_object - way_m).abs() < slack_m, "{n_objects}: {of_object} {way_m}");
            }
            assert!(pushed.iter().all(|place_m| place_m[1].abs() < ROUNDING_M));
            (way_m, slack_m)
        };

        let (alone_m, _) = way_m(ContactModel::Stop);
        assert!((alone_m - 1.0).abs() < 1e-4, "it is not held back: {alone_m}");
        let (shared_m, slack_m) = way_m(ContactModel::Push);
        let share = 1.0 / f64::from(1 + n_objects);
        assert!((shared_m - share).abs() < slack_m, "as robots would be pushed: {shared_m}");
    }
}

#[test]
fn the_heavier_an_object_is_the_more_slowly_robots_push_it() {
    for (weight, n_robots) in [(0.5, 1_u32), (1.0, 1), (5.0, 1), (5.0, 4), (100.0, 4)] {
        let place_m = |robot: u32| -1.0 - f64::from(robot) * (2.0 * ROBOT_M + 1e-5);
        let robots: Vec<Pose> = (0..n_robots).map(|robot| at(place_m(robot), 0.0, 0.0)).collect();
        let first_m = -1.0 + ROBOT_M + OBJECT_M + 1e-5;
        let mut world = objects(vec![[first_m, 0.0]], 0.0);
        world.objects[0].weight = weight;
        let conditions = exact(ContactModel::Push, robots, world);

        let commands = vec![drive(STEP_M); n_robots as usize];
        let (_, pushed) = driven(&conditions, &commands, 50);

        let share = f64::from(n_robots) / (f64::from(n_robots) + weight);
        let way_m = pushed[0][0] - first_m;
        assert!((way_m - share).abs() < 2e-3, "{weight} {n_robots}: {way_m} {share}");
    }
}

#[test]
fn several_robots_push_together_faster_than_one() {
    // Three in a row behind two objects.
    let robots: Vec<Pose> = (0..3)
        .map(|robot| at(-1.0 - f64::from(robot) * (2.0 * ROBOT_M + 1e-5), 0.0, 0.0))
        .collect();
    let first_m = -1.0 + ROBOT_M + OBJECT_M + 1e-5;
    let world = objects(vec![[first_m, 0.0], [first_m + 2.0 * OBJECT_M + 1e-5, 0.0]], 0.0);
    let way_m = |n_driving: usize| {
        let conditions = exact(ContactModel::Push, robots.clone(), world.clone());
        let commands: Vec<Command> = (0..3)
            .map(|robot| if robot < n_driving { drive(STEP_M) } else { Command::STOP })
            .collect();
        let (_, pushed) = driven(&conditions, &commands, 50);
        pushed[0][0] - first_m
    };

    let (one_m, three_m) = (way_m(1), way_m(3));

    assert!((one_m - 1.0 / 3.0).abs() < 2e-3, "{one_m}");
    assert!((three_m - 3.0 / 5.0).abs() < 2e-3, "{three_m}");
}

#[test]
fn robots_that_stop_at_robots_still_push_objects_and_those_that_pass_push_none() {
    let world = objects(vec![[0.2, 0.0]], 0.0);
    let pushed_m = |contact| {
        let conditions = exact(contact, vec![at(0.0, 0.0, 0.0), at(0.5, 0.0, 0.0)], world.clone());
        let (robots, pushed) = driven(&conditions, &[drive(STEP_M), Command::STOP], 30);
        (robots[0].x_m, pushed[0][0], robots[1].x_m)
    };

    let (pusher_m, object_m, other_m) = pushed_m(ContactModel::Stop);
    assert_eq!(other_m.to_bits(), 0.5_f64.to_bits(), "nobody moves who stops");
    let touching_m = other_m - ROBOT_M - OBJECT_M;
    assert!((object_m - touching_m).abs() < 2.0 * SLACK * 0.15 + STEP_M, "{object_m}");
    assert!(object_m - pusher_m > (1.0 - SLACK) * (ROBOT_M + OBJECT_M) - ROUNDING_M, "{pusher_m}");
    let (_, object_m, other_m) = pushed_m(ContactModel::Push);
    assert!(other_m > 0.51 && object_m > 0.38, "all go on together: {object_m} {other_m}");
    let (through_m, object_m, _) = pushed_m(ContactModel::None);
    assert!(
        (through_m - 0.6).abs() < ROUNDING_M && object_m.to_bits() == f64::from(0.2_f32).to_bits()
    );
}

#[test]
fn what_nobody_pushes_stays_and_has_no_momentum() {
    let world = objects(vec![[0.2, 0.0], [0.2, 0.2], [0.3, 0.2], [-1.0, 1.0]], 0.3);
    let conditions = exact(ContactModel::Push, vec![at(0.0, 0.0, 0.0)], world);
    let mut world = World::new(&conditions, SEED).expect("they fit");
    let places = |world: &World| world.objects_m().collect::<Vec<_>>();
    let step = |world: &mut World, command| {
        world.sense();
        world.advance(&[command]);
    };

    for _ in 0..20 {
        step(&mut world, drive(STEP_M));
    }
    let pushed = places(&world);
    for _ in 0..20 {
        step(&mut world, Command::STOP);
    }

    assert!(pushed[0][0] > 0.25, "{pushed:?}");
    assert_eq!(bits(&places(&world)), bits(&pushed), "once nobody pushes it stays");
    let (_, untouched) = driven(&conditions, &[Command::STOP], 1);
    assert_eq!(bits(&pushed[1..]), bits(&untouched[1..]), "who was not touched was never moved");
}

#[test]
fn a_wall_holds_objects_and_whoever_pushes_them() {
    let world = objects(vec![[1.8, 0.0]], 0.0);
    for contact in [ContactModel::Stop, ContactModel::Push] {
        let conditions = exact(contact, vec![at(1.5, 0.0, 0.0)], world.clone());
        let (robots, pushed) = driven(&conditions, &[drive(STEP_M)], 60);

        assert!((pushed[0][0] - (2.0 - OBJECT_M)).abs() < STEP_M, "{contact:?} {pushed:?}");
        assert!(pushed[0][0] <= 2.0 - OBJECT_M + ROUNDING_M, "{contact:?} {pushed:?}");
        let between_m = apart_m(pushed[0], [robots[0].x_m, robots[0].y_m]);
        assert!(between_m >= (1.0 - SLACK) * (ROBOT_M + OBJECT_M) - ROUNDING_M, "{contact:?}");
    }
}

/// A crowd of robots and objects.
fn crowd(contact: ContactModel, way_m: f64, friction: f64) -> Crowd {
    let mut conditions = flockbots(way_m / 0.13, 2.0, &HARSHER);
    conditions.robots = 8;
    conditions.robot.contact = contact;
    conditions.placement = Placement::DiscFacingOut { radius_m: 0.5 };
    conditions.arena = Arena { side_m: 1.4, walls: Walls::Clamp };
    let groups =
        vec![objects_anywhere(15, OBJECT_M, friction), objects_anywhere(3, 0.08, friction)];
    conditions.world = WorldFile { objects: groups, ..WorldFile::NOTHING };
    conditions.check().expect("it makes a world");
    Crowd::new(conditions)
}

#[test]
fn objects_overlap_with_nothing_however_robots_drive() {
    for contact in [ContactModel::Stop, ContactModel::Push] {
        for (way_m, friction) in [(0.01, 0.0), (0.03, 0.5), (0.1, 0.0), (0.2, 2.0)] {
            let mut crowd = crowd(contact, way_m, friction);
            let mut world = World::new(&crowd.conditions, SEED).expect("they fit");
            let radii_m: Vec<f64> =
                crowd.conditions.world.each_object().map(|object| object.radius_m).collect();
            let start: Vec<[f64; 2]> = world.objects_m().collect();
            for step in 0..200 {
                world.sense();
                world.advance(&crowd.commands());

                let discs: Vec<(f64, [f64; 2])> =
                    radii_m.iter().copied().zip(world.objects_m()).collect();
                let robots: Vec<(f64, [f64; 2])> =
                    world.poses().map(|pose| (ROBOT_M, [pose.x_m, pose.y_m])).collect();
                for (number, (radius_m, place_m)) in discs.iter().enumerate() {
                    for (other_m, other) in discs[..number].iter().chain(&robots) {
                        let least_m = (1.0 - SLACK) * (radius_m + other_m) - ROUNDING_M;
                        let found_m = apart_m(*place_m, *other);
                        assert!(
                            found_m >= least_m,
                            "{contact:?} {way_m} {step}: {found_m} {least_m}"
                        );
                    }
                    let limit_m = 0.7 - radius_m + ROUNDING_M;
                    assert!(place_m.iter().all(|at_m| at_m.abs() <= limit_m), "{place_m:?}");
                }
            }
            let end: Vec<[f64; 2]> = world.objects_m().collect();
            let moved = start.iter().zip(&end).filter(|(from, to)| apart_m(**from, **to) > 0.02);
            assert!(moved.count() > 5, "{contact:?} {way_m}: they were pushed about");
        }
    }
}

/// Robots and objects in a heap, with commands that drive the robots into it.
fn heap() -> (Vec<Pose>, Vec<[f64; 2]>, Vec<Command>) {
    let mut draw = Draw::new(5);
    let mut between = |least: f64, most: f64| least + (most - least) * draw.uniform();
    let objects = (0..9).map(|object| {
        let (column, row) = (f64::from(object % 3) - 1.0, f64::from(object / 3) - 1.0);
        [0.115 * column + between(0.0, 0.01), 0.115 * row + between(0.0, 0.01)]
    });
    let objects: Vec<[f64; 2]> = objects.collect();
    let around = (0..5).map(|robot| {
        let angle_rad = 1.2 * f64::from(robot) + 0.4;
        let (x_m, y_m) = (0.36 * libm::cos(angle_rad), 0.36 * libm::sin(angle_rad));
        at(x_m, y_m, libm::atan2(-y_m, -x_m))
    });
    let robots: Vec<Pose> = around.collect();
    let mut command = |_| Command { speed_m_s: 0.1, turn_rate_rad_s: draw.uniform() - 0.5 };
    (robots, objects, (0..5).map(&mut command).collect())
}

#[test]
fn neither_the_order_nor_the_side_of_robots_and_objects_matters() {
    let (start, places, commands) = heap();
    for contact in [ContactModel::Stop, ContactModel::Push] {
        let pushed = |poses: Vec<Pose>, places: Vec<[f64; 2]>, commands: &[Command]| {
            driven(&exact(contact, poses, objects(places, 0.3)), commands, 40)
        };
        let (robots, objects) = pushed(start.clone(), places.clone(), &commands);
        assert!(objects.iter().zip(&places).any(|(to, from)| apart_m(*to, *from) > 0.03));

        let (mut poses, mut others, mut of_others) =
            (start.clone(), places.clone(), commands.clone());
        poses.reverse();
        others.reverse();
        of_others.reverse();
        let (mut robots_back, mut objects_back) = pushed(poses, others, &of_others);
        robots_back.reverse();
        objects_back.reverse();
        assert_eq!(robots_back, robots, "{contact:?}");
        assert_eq!(bits(&objects_back), bits(&objects), "{contact:?}");

        let mirror = |pose: &Pose| Pose { y_m: -pose.y_m, heading_rad: -pose.heading_rad, ..*pose };
        let mirrored = |places: &[[f64; 2]]| -> Vec<[f64; 2]> {
            places.iter().map(|[x_m, y_m]| [*x_m, -*y_m]).collect()
        };
        let turned: Vec<Command> = commands
            .iter()
            .map(|command| Command { turn_rate_rad_s: -command.turn_rate_rad_s, ..*command })
            .collect();
        let (robots_other, objects_other) =
            pushed(start.iter().map(mirror).collect(), mirrored(&places), &turned);
        assert_eq!(robots_other.iter().map(mirror).collect::<Vec<_>>(), robots, "{contact:?}");
        assert_eq!(bits(&mirrored(&objects_other)), bits(&objects), "{contact:?}");
    }
}

#[test]
fn friction_takes_an_object_along() {
    // A robot that drives past an object, obliquely into it.
    let y_m = |friction| {
        let world = objects(vec![[0.126, 0.0]], friction);
        let conditions = exact(ContactModel::Push, vec![at(0.0, 0.0, 0.8)], world);
        driven(&conditions, &[drive(STEP_M)], 2).1[0][1]
    };

    assert!(y_m(0.0) < 0.0, "it slides off");
    assert!(y_m(0.5) > 0.0 && y_m(2.0) > y_m(0.5), "it is taken along: {} {}", y_m(0.5), y_m(2.0));
}

#[test]
fn objects_are_placed_anywhere_in_the_arena_clear_of_all_and_of_each_replicate_elsewhere() {
    let mut conditions = flockbots(0.15, 0.75, &HARSHER);
    conditions.arena = Arena { side_m: 2.0, walls: Walls::Stop };
    conditions.placement = Placement::BoxFacingAnyWay(Sides { width_m: 1.8, height_m: 1.8 });
    let fixed = placed(vec![[0.0, 0.0], [0.9, -0.9]], 0.1, 0.0);
    let groups = vec![objects_anywhere(10, OBJECT_M, 0.0), fixed];
    conditions.world = WorldFile { objects: groups, ..WorldFile::NOTHING };
    conditions.check().expect("it makes a world");
    let mut n_inner = 0;
    let n_replicates = 400;
    for replicate in 0..n_replicates {
        let world = World::new(&conditions, Seed { seed: 1, replicate }).expect("they fit");
        let places: Vec<[f64; 2]> = world.objects_m().collect();
        assert_eq!(places[10..], [[0.0, 0.0], [f64::from(0.9_f32), f64::from(-0.9_f32)]]);
        let radii_m: Vec<f64> =
            conditions.world.each_object().map(|object| object.radius_m).collect();
        let mut discs: Vec<(f64, [f64; 2])> = radii_m.into_iter().zip(places).collect();
        n_inner += discs[..10].iter().filter(|(_, at)| at[0].abs().max(at[1].abs()) < 0.6).count();
        discs.extend(world.poses().map(|pose| (ROBOT_M, [pose.x_m, pose.y_m])));
        for (number, (radius_m, place_m)) in discs.iter().enumerate() {
            for (other_m, other) in &discs[..number] {
                assert!(apart_m(*place_m, *other) > radius_m + other_m, "{replicate}");
            }
            assert!(place_m.iter().all(|at_m| at_m.abs() <= 1.0 - radius_m), "{replicate}");
        }
    }
    // 0.36 of the area around the middle is (1.2 / 1.9)² of where centres may be, less what others take.
    let share = n_inner as f64 / (10.0 * n_replicates as f64);
    assert!((0.3..0.45).contains(&share), "{share}");
    let first = |replicate| {
        let world = World::new(&conditions, Seed { seed: 1, replicate }).expect("they fit");
        bits(&world.objects_m().collect::<Vec<_>>())
    };
    assert_eq!(first(3), first(3));
    assert_ne!(first(3), first(4));
}

#[test]
fn objects_that_do_not_fit_are_counted() {
    let mut conditions = flockbots(0.15, 0.75, &HARSHER);
    conditions.arena = Arena { side_m: 2.0, walls: Walls::Stop };
    conditions.world =
        WorldFile { objects: vec![objects_anywhere(300, OBJECT_M, 0.0)], ..WorldFile::NOTHING };
    conditions.check().expect("the area would be enough");

    let error = World::new(&conditions, SEED).err().expect("there is no room").to_string();

    assert!(
        error.starts_with("300 objects do not fit into a box of 1.900 m by 1.900 m"),
        "{error}"
    );
    assert!(error.contains("clear of robots and within the walls"), "{error}");
}

/// What the first robot reports at the start, by name.
fn reported(conditions: &Conditions) -> Vec<String> {
    support::reported(conditions).swap_remove(0)
}

/// One robot at the origin that looks along x, with these kinds to tell apart.
fn looking(hidden_by: Vec<Detects>, world: WorldFile) -> Conditions {
    let robots = vec![at(0.0, 0.0, 0.0), at(0.0, -1.5, 0.0)];
    let mut conditions = exact(ContactModel::Stop, robots, world);
    conditions.robot.region = Region::Cone { half_angle_rad: 0.1, range_m: 1.5 };
    conditions.robot.details = SensorDetails {
        hidden_by,
        or: vec![
            exact_reading("object", Detects::Object),
            exact_reading("goal", Detects::Goal),
            exact_reading("wall", Detects::Wall),
        ],
        ..SensorDetails::default()
    };
    conditions
}

#[test]
fn of_robots_objects_goals_and_walls_the_nearest_is_reported() {
    let goal = |x_m: f64, radius_m| Goal { place_m: [x_m, 0.0], radius_m };
    let mut world = objects(vec![[1.0, 0.0]], 0.0);
    world.goals = vec![goal(1.4, 0.2)];
    let mut conditions = looking(Vec::new(), world);
    assert_eq!(reported(&conditions), ["object"], "its edge is 0.95 m away, the goal's 1.2 m");

    conditions.world.goals[0] = goal(1.4, 0.5);
    assert_eq!(reported(&conditions), ["goal"], "its edge is 0.9 m away");
    conditions.world.goals[0] = goal(0.1, 0.3);
    assert_eq!(reported(&conditions), ["goal"], "who is in a goal has it nearest");
    conditions.world.goals[0] = goal(0.0, 0.3);
    assert_eq!(reported(&conditions), ["goal"], "and so has who is in the middle of it");
    conditions.world.goals[0] = goal(-1.0, 0.3);
    assert_eq!(reported(&conditions), ["object"], "it is behind");

    let Placement::Given { starts } = &mut conditions.placement else { unreachable!() };
    starts[0][1] = at(0.8, 0.1, 0.0);
    assert_eq!(reported(&conditions), ["detection"], "a robot in front of it");
    conditions.arena.side_m = 2.2;
    conditions.world.goals[0] = goal(-0.8, 0.2);
    let Placement::Given { starts } = &mut conditions.placement else { unreachable!() };
    starts[0][1] = at(-0.8, 0.1, 0.0);
    assert_eq!(reported(&conditions), ["object"]);
    conditions.world.objects[0].places_m = Some(vec![[-0.5, 0.0]]);
    assert_eq!(reported(&conditions), ["wall"], "nothing else is ahead");
}

#[test]
fn objects_and_goals_hide_what_is_behind_them_if_they_do() {
    let mut world = objects(vec![[0.6, 0.0]], 0.0);
    world.goals = vec![Goal { place_m: [1.2, 0.0], radius_m: 0.3 }];
    let line = Region::Cone { half_angle_rad: 0.0, range_m: 2.0 };
    let sees = |detects, hidden_by: Vec<Detects>, world: &WorldFile| {
        let robots = vec![at(0.0, 0.0, 0.0), at(1.9, 0.0, 3.0)];
        let mut conditions = exact(ContactModel::Stop, robots, world.clone());
        conditions.robot.region = line.clone();
        conditions.robot.details = SensorDetails { detects, hidden_by, ..SensorDetails::default() };
        !reported(&conditions).is_empty()
    };

    for (detects, hidden_by, expected) in [
        (Detects::Robot, vec![], true),
        (Detects::Robot, vec![Detects::Object], false),
        (Detects::Robot, vec![Detects::Goal], false),
        (Detects::Goal, vec![], true),
        (Detects::Goal, vec![Detects::Object], false),
        (Detects::Goal, vec![Detects::Robot], true),
        (Detects::Object, vec![Detects::Object, Detects::Goal, Detects::Robot], true),
        (Detects::Wall, vec![], true),
        (Detects::Wall, vec![Detects::Object], false),
    ] {
        assert_eq!(sees(detects, hidden_by.clone(), &world), expected, "{detects} {hidden_by:?}");
    }
    let aside = objects(vec![[0.6, 0.06]], 0.0);
    assert!(sees(Detects::Robot, vec![Detects::Object], &aside), "past it there is a way");
    assert!(!sees(Detects::Object, vec![], &aside), "which does not touch it");
}

/// Object clustering in small: a ternary sensor and 12 objects.
fn clustering() -> Conditions {
    let world = WorldFile {
        objects: vec![objects_anywhere(12, OBJECT_M, 0.2)],
        goals: vec![Goal { place_m: [0.5, 0.5], radius_m: 0.3 }],
        ..WorldFile::NOTHING
    };
    let mut conditions = flockbots(0.15, 0.75, &HARSHER);
    conditions.robots = 4;
    conditions.arena = Arena { side_m: 3.0, walls: Walls::Stop };
    conditions.world = world;
    conditions.robot.region = Region::Cone { half_angle_rad: 0.0, range_m: 3.0 };
    conditions.robot.details = SensorDetails {
        or: vec![exact_reading("object", Detects::Object)],
        hidden_by: vec![Detects::Robot, Detects::Object],
        ..SensorDetails::default()
    };
    conditions.behaviour = Behaviour::parse("heap.yaml", HEAP).expect("it is one");
    conditions.check().expect("it makes a world");
    conditions
}

const HEAP: &str = "
name: heap
words: {noun: a heap, swarm: a swarm that heaps, verb: [heap, heaps, heaped]}
phases: [{key: heaped}, {key: strewn}]
rules:
  - phase: heaped
    when: {objects_clustered: {at_least: 0.4}, objects_at_goal: {below: 0.9}, at_goal: {below: 0.9}, goal_distance_m: {below: 9}, consensus: {below: 0.95}}
otherwise: strewn
";

#[test]
fn worlds_with_objects_are_swept_in_the_reference_world_and_judged_alike() {
    let conditions = clustering();
    assert!(!runs_in_lanes(&conditions, 120.0));
    let mut plain = flockbots(0.15, 0.75, &HARSHER);
    assert!(runs_in_lanes(&plain, 120.0));
    plain.world.goals = conditions.world.goals.clone();
    assert!(runs_in_lanes(&plain, 120.0), "goals collide with nothing");
    plain.world = conditions.world.clone();
    assert!(!runs_in_lanes(&plain, 120.0));

    assert_judged_alike(&conditions, 3);
    let run = run_episode(&conditions, SEED, 10.0).expect("they fit");
    assert_eq!(run.objects_m.len(), 12 * run.n_samples());
    let digests = episode_digests(&conditions, SEED, 10.0).expect("they fit");
    assert_eq!(digests, episode_digests(&conditions, SEED, 10.0).expect("they fit"));
}

#[test]
fn goals_are_judged_in_lanes_as_by_the_definition() {
    let mut conditions = flockbots(0.15, 0.75, &HARSHER);
    conditions.world.goals = vec![
        Goal { place_m: [0.4, 0.1], radius_m: 0.5 },
        Goal { place_m: [-0.6, -0.2], radius_m: 0.2 },
    ];
    let text =
        HEAP.replace("objects_clustered: {at_least: 0.4}, objects_at_goal: {below: 0.9}, ", "");
    conditions.behaviour =
        Behaviour::parse("there.yaml", &text.replace("heap", "there")).expect("it is one");

    assert_judged_alike(&conditions, 20);
}

/// The state of robots and objects in a crowd after 200 steps: it changes only when the world does.
const GOLDEN: [(ContactModel, u64); 2] =
    [(ContactModel::Stop, 0xf766_082e_64b3_506c), (ContactModel::Push, 0xed50_3113_528b_c6f4)];

#[test]
fn a_crowd_among_objects_has_the_bits_that_it_always_had() {
    let found = GOLDEN.map(|(contact, _)| {
        let mut crowd = crowd(contact, 0.03, 0.2);
        let mut world = World::new(&crowd.conditions, SEED).expect("they fit");
        for _ in 0..200 {
            world.sense();
            world.advance(&crowd.commands());
        }
        (contact, world.digest())
    });

    assert_eq!(found, GOLDEN, "found {found:#018x?}");
}
