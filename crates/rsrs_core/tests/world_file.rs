//! Worlds in files, and order parameters of what is in them.

use rsrs_core::conditions::{Arena, Conditions, Placement, Settings, Walls};
use rsrs_core::diagram::sweep_file::SweepFile;
use rsrs_core::help::Help;
use rsrs_core::judge::behaviour::Behaviour;
use rsrs_core::judge::order::{OrderParameters, Parameter};
use rsrs_core::judge::phase::{JudgeError, label_with};
use rsrs_core::judge::plausibility::{Known, implausible};
use rsrs_core::judge::trajectory::{Bodies, Trajectory};
use rsrs_core::judge::window::samples_in;
use rsrs_core::quantity::Axis;
use rsrs_core::robot::controller::Command;
use rsrs_core::robot::profile::RobotProfile;
use rsrs_core::robot::unicycle::Pose;
use rsrs_core::world::{Goal, WorldFile};

use crate::order::behaviour;

use rsrs_testing::conditions::{FLOCKBOT, flockbot};
const WORLD: &str = "\
objects:
  - {count: 12, radius_m: 0.05, friction: 0.2}
  - {places_m: [[0.5, 0], [0.5, 0.3]], radius_m: 0.1}
goals:
  - {place_m: [-1, -1], radius_m: 0.4}
";

fn world() -> WorldFile {
    WorldFile::parse("world.yaml", WORLD, &[3.0], &[3]).expect("it is one")
}

fn settings(world: WorldFile) -> Settings {
    let values =
        vec![(Axis::Speed, 0.15), (Axis::TurnRate, 0.75), (Axis::Robots, 3.0), (Axis::Arena, 3.0)];
    Settings { values, world, ..Settings::default() }
}

#[test]
fn a_world_is_part_of_the_conditions_and_nothing_is_where_none_is_named() {
    let with = Conditions::resolve(&flockbot(), &settings(world())).unwrap();
    let without = Conditions::resolve(&flockbot(), &settings(WorldFile::NOTHING)).unwrap();

    assert_eq!(with.world.n_objects(), 14);
    assert_eq!(with.world.in_words(), "14 objects and 1 goal");
    assert_ne!(with.digest(), without.digest());
    let text = serde_json::to_string(&with).unwrap();
    assert_eq!(serde_json::from_str::<Conditions>(&text).unwrap(), with);
    let nothing = serde_json::to_string(&without).unwrap();
    assert!(!nothing.contains("world"), "digests are of what was always there: {nothing}");
}

#[test]
fn a_sweep_file_has_the_path_of_its_world_and_a_folder_all_of_it() {
    let text = "\
profile: p.yaml
axes: {speed_m_s: [0.1, 0.2], arena_m: [2, 3]}
fixed: {turn_rate_rad_s: 0.75, robots: 3}
world: world.yaml
duration_s: 60
seed: 1
";
    let mut sweep = SweepFile::parse("sweep.yaml", text).unwrap();
    assert_eq!(sweep.arenas_m(), [2.0, 3.0]);
    let error = sweep.resolve("sweep.yaml", &flockbot()).unwrap_err().to_string();
    assert_eq!(error, "sweep.yaml: the world is in world.yaml, which was not read");

    sweep.world = Some(rsrs_core::world::WorldSource::Read(world()));
    let digest = sweep.digest(&flockbot());
    let written = serde_json::to_string(&sweep).unwrap();
    let again: SweepFile = serde_json::from_str(&written).unwrap();
    assert_eq!(again, sweep);
    assert_eq!(again.world(), Some(&world()));
    let other = WorldFile { goals: Vec::new(), ..world() };
    sweep.world = Some(rsrs_core::world::WorldSource::Read(other));
    assert_ne!(sweep.digest(&flockbot()), digest);
    let error = again.resolve("sweep.yaml", &flockbot()).unwrap_err();
    let expected = "goals[0] of the world: a goal of radius 0.4 m at (-1, -1) m is not within the \
                    arena of 2 m";
    assert!(error.to_string().ends_with(expected), "{error}");
    assert!(error.help().is_some_and(|help| help.starts_with("move it, or widen `arena_m`")));
}

#[test]
fn a_world_that_cannot_be_is_refused_with_line_reason_and_cure() {
    for (from, to, expected, cure) in [
        ("count: 12", "number: 12", "world.yaml:2:6: unknown key `number`", "the keys here are: "),
        (WORLD, "objects: []\n", "world.yaml:1: there is nothing in it", "give "),
        (WORLD, "# nothing\n", "world.yaml:1: there is nothing in it", "give "),
        (WORLD, "body: {}\nactuation: {}\n", "world.yaml:1:1: this is a robot profile", "sweep"),
        (
            "0.05",
            "0",
            "world.yaml:2: `radius_m` is 0, expected a number from 0.001",
            "give a length",
        ),
        ("0.05", ".nan", "world.yaml:2: `radius_m` is NaN, expected", "give a length in metres"),
        ("0.2}", "-1}", "world.yaml:2: `friction` is -1, expected a number from 0 to 2", ""),
        (
            "count: 12",
            "count: 0",
            "world.yaml:2: `count` is 0, expected",
            "leave out what there is none of",
        ),
        ("count: 12, ", "", "world.yaml:2: objects need exactly one of `count` and", "give `count"),
        (
            "count: 12",
            "count: 12, places_m: [[0, 0]]",
            "world.yaml:2: objects need exactly one of `count` and `places_m`",
            "give `count: 20` to have them placed at random",
        ),
        (
            "count: 12",
            "count: 2000",
            "world.yaml:2: 2,000 objects of radius 0.05 m do not fit into the arena of 3 m: at most \
             1039 ever do",
            "take fewer or smaller ones, or widen `arena_m`",
        ),
        (
            "[0.5, 0.3]",
            "[0.5, 0.1]",
            "world.yaml:3: objects at (0.5, 0) m and (0.5, 0.1) m overlap: they are 0.100 m apart, \
             expected 0.200 m or more",
            "move one of them",
        ),
        (
            "[0.5, 0.3]",
            "[1.45, 0.3]",
            "world.yaml:3: an object of radius 0.1 m at (1.45, 0.3) m is not within the arena of 3 m",
            "move it, or widen `arena_m`, or the world's `arena`; the origin is the middle of the arena",
        ),
        ("[0.5, 0.3]", "[.inf, 0]", "world.yaml:3: `places_m` is inf, expected a number from", ""),
        (
            "[-1, -1]",
            "[-1.2, -1]",
            "world.yaml:5: a goal of radius 0.4 m at (-1.2, -1) m is not within the arena of 3 m",
            "move it",
        ),
        (
            "0.4}",
            "0}",
            "world.yaml:5: `radius_m` is 0, expected a number",
            "give a length in metres",
        ),
    ] {
        assert_refused(&edited(WORLD, from, to), (&[3.0], &[3]), expected, cure);
    }
}

fn edited(text: &str, from: &str, to: &str) -> String {
    assert!(text.contains(from), "{from}");
    text.replacen(from, to, 1)
}

/// Holds how a file is refused where the sides of the arenas, in metres, and the numbers of robots are these.
fn assert_refused(text: &str, (arenas_m, robots): (&[f64], &[usize]), expected: &str, cure: &str) {
    let error = WorldFile::parse("world.yaml", text, arenas_m, robots).expect_err("it is refused");

    assert!(error.to_string().starts_with(expected), "{error}");
    assert!(error.help().unwrap_or_default().starts_with(cure), "{:?}", error.help());
}

#[test]
fn a_sensor_of_what_is_not_there_is_refused_by_name() {
    let sensing = FLOCKBOT.find("sensing:").unwrap();
    let end = FLOCKBOT.find("computation:").unwrap();
    let of = |kind: &str| {
        let sensors = format!(
            "sensors:\n  - {{name: detection, cone: {{half_angle_rad: 0.2, range_m: 0.5}}, \
             true_positive: 1, false_positive: 0}}\n  - {{name: thing, detects: {kind}, hidden_by: \
             [object, goal], cone: {{half_angle_rad: 0, range_m: 1}}, true_positive: 1, \
             false_positive: 0}}\n"
        );
        let text = FLOCKBOT.replace(&FLOCKBOT[sensing..end], &sensors);
        RobotProfile::parse("robots.yaml", &text).expect("it is a robot")
    };
    for kind in ["object", "goal"] {
        let error = Conditions::resolve(&of(kind), &settings(WorldFile::NOTHING)).unwrap_err();

        let expected = format!("sensor `thing` detects {kind}s, and there are none");
        assert_eq!(error.to_string(), expected);
        let help = error.help().expect("there is a cure");
        assert!(help.starts_with(&format!("name a world with `{kind}s`")), "{help}");
        assert!(Conditions::resolve(&of(kind), &settings(world())).is_ok());
    }
    for (kind, all) in [("kin", "robots of its own class"), ("other", "robots of other classes")] {
        let error = Conditions::resolve(&of(kind), &settings(world())).unwrap_err();

        let expected = format!("sensor `thing` detects {all}, and there are none");
        assert_eq!(error.to_string(), expected);
        let help = error.help().expect("there is a cure");
        assert!(help.starts_with("name a world with `classes: [{name: a}, {name: b}]`"), "{help}");
        let world = WorldFile::parse("world.yaml", CLASSES, &[3.0], &[3]).expect("it is one");
        assert!(Conditions::resolve(&of(kind), &settings(world)).is_ok());
    }
}

#[test]
fn robots_start_in_no_object_and_trials_are_without_them() {
    let mut conditions = Conditions::resolve(&flockbot(), &settings(world())).unwrap();
    let at = |x_m: f64| Pose { x_m, y_m: 0.0, heading_rad: 0.0 };
    conditions.placement = Placement::Given { starts: vec![vec![at(-1.0), at(0.0), at(0.35)]] };
    let error = conditions.check().unwrap_err();
    assert_eq!(
        error.to_string(),
        "replicate 0: robot 3 starts at (0.35, 0) m, where an object is at (0.5, 0) m"
    );
    assert_eq!(error.help().as_deref(), Some("move the robot, or the object"));
    conditions.placement = Placement::Given { starts: vec![vec![at(-1.0), at(0.0), at(0.3)]] };
    assert_eq!(conditions.check(), Ok(()));
    conditions.placement = Placement::Pair { distance_m: 0.5, bearing_rad: 0.0 };
    conditions.robots = 2;
    let error = conditions.check().unwrap_err().to_string();
    assert_eq!(error, "the placement is a pair, for a trial, and there are objects");
}

/// One robot that stands at a place, beside three objects, of which one goes to the goal after half of the time.
fn run(robot_m: f64, duration_s: f64) -> Trajectory {
    let n_samples = samples_in(duration_s, 0.1);
    let pose = Pose { x_m: robot_m, y_m: 0.0, heading_rad: 0.0 };
    let mut run = Trajectory::of_poses(0.1, 1, vec![pose; n_samples]);
    run.n_objects = 3;
    run.objects_m = (0..n_samples)
        .flat_map(|sample| {
            let third = if 2 * sample < n_samples { [3.0, 0.0] } else { [0.21, 0.0] };
            [[0.0, 0.0], [0.15, 0.0], third]
        })
        .collect();
    run
}

fn bodies() -> Bodies {
    let text = "
objects: [{count: 3, radius_m: 0.05}]
goals: [{place_m: [1, 0], radius_m: 0.25}, {place_m: [0.3, 0], radius_m: 0.1}]
";
    let world = WorldFile::parse("world.yaml", text, &[9.0], &[]).expect("it is one");
    Bodies { radius_m: Some(0.1), world, ..Bodies::UNKNOWN }
}

fn measured(run: &Trajectory, key: &str) -> f64 {
    let parameter = Parameter::from_key(key).expect("it is in the table");
    let window = 0..run.n_samples();
    parameter.of(&OrderParameters::with(run, window, &bodies(), &[parameter]))
}

#[test]
fn shares_of_objects_and_distances_to_goals_are_what_they_are_called() {
    let run = run(2.0, 20.0);

    assert!((measured(&run, "objects_clustered") - f64::midpoint(1.0, 2.0 / 3.0)).abs() < 1e-12);
    assert!((measured(&run, "objects_at_goal") - 1.0 / 6.0).abs() < 1e-12);
    assert_eq!(measured(&run, "at_goal").to_bits(), 0.0_f64.to_bits());
    assert!((measured(&run, "goal_distance_m") - 0.75).abs() < 1e-12, "to the rim of the nearest");
    let inside = self::run(1.2, 20.0);
    assert_eq!(measured(&inside, "at_goal").to_bits(), 1.0_f64.to_bits());
    assert_eq!(measured(&inside, "goal_distance_m").to_bits(), 0.0_f64.to_bits());
    assert_eq!(measured(&inside, "consensus").to_bits(), 1.0_f64.to_bits());
    // Another robot would fit between this one, of 0.1 m radius, and the nearest rim, 0.75 m from its centre.
    assert_eq!(measured(&run, "consensus").to_bits(), 0.0_f64.to_bits());
    let goal = Goal { place_m: [1.0, 0.0], radius_m: 0.25 };
    assert_eq!(bodies().world.goals[0], goal);
}

#[test]
fn a_behaviour_over_objects_is_judged_where_their_places_are_known_and_else_refused_by_name() {
    let heap = behaviour("heap", "objects_clustered: {at_least: 0.9}");
    let there = behaviour("there", "at_goal: {at_least: 0.9}");
    let run = run(2.0, 200.0);
    let label = |run: &Trajectory, bodies: &Bodies, behaviour: Behaviour| {
        label_with(run, bodies, &behaviour.rules()).map(|verdict| verdict.phase)
    };

    assert_eq!(label(&run, &bodies(), heap), Ok(heap.wanted()));
    let mut without = run.clone();
    (without.n_objects, without.objects_m) = (0, Vec::new());
    let error = label(&without, &bodies(), heap).unwrap_err();
    assert!(matches!(error, JudgeError::UnknownObjects { .. }));
    assert_eq!(
        error.to_string(),
        "where the 3 objects were is known of 0, and objects_clustered depends on it"
    );
    assert!(label(&without, &bodies(), there).is_ok(), "which asks for no object");
    let error = label(&run, &Bodies::UNKNOWN, heap).unwrap_err();
    assert_eq!(
        error.to_string(),
        "objects_clustered is of objects, and there are none, or none is known"
    );
    let error = label(&run, &Bodies::UNKNOWN, there).unwrap_err();
    assert_eq!(error.to_string(), "at_goal is of goals, and there are none, or none is known");
    let mut nowhere = run;
    nowhere.objects_m[3 * 77 + 1] = [f64::NAN, 0.0];
    let error = label(&nowhere, &bodies(), heap).unwrap_err().to_string();
    assert!(error.starts_with("object 1 is nowhere, or beyond 1e9 m, 7.70 s after"), "{error}");
}

#[test]
fn who_pushes_an_object_is_not_accused_of_standing() {
    let drives = |robot_m: f64| {
        let mut run = run(robot_m, 60.0);
        run.commands.fill(Command { speed_m_s: 0.1, turn_rate_rad_s: 0.0 });
        run
    };
    let known = Known { bodies: bodies(), walls_m: None, left_out: &[], unseen: &[] };

    let alone = implausible(&drives(-2.0), &known, 10.0);
    let beside = implausible(&drives(-0.16), &known, 10.0);
    let mut unseen = drives(-2.0);
    (unseen.n_objects, unseen.objects_m) = (0, Vec::new());

    assert_eq!(alone.len(), 1, "{alone:?}");
    assert_eq!(beside, []);
    assert_eq!(implausible(&unseen, &known, 10.0), [], "an object may be anywhere");
}

#[test]
fn arenas_of_a_world_need_no_walls() {
    let mut conditions = Conditions::resolve(&flockbot(), &settings(world())).unwrap();
    conditions.arena = Arena { side_m: 3.0, walls: Walls::None };
    assert_eq!(conditions.check(), Ok(()));
}

const CLASSES: &str = "\
classes:
  - {name: shepherd, count: 2}
  - {name: sheep}
";

#[test]
fn classes_are_part_of_a_world_and_dealt_in_turn() {
    let world = WorldFile::parse("world.yaml", CLASSES, &[3.0], &[3, 5]).expect("it is one");
    assert_eq!(world.in_words(), "2 classes of robots");
    assert_eq!(world.classes_of(5), [0, 1, 0, 1, 1]);
    let all = WorldFile { classes: world.classes.clone(), ..self::world() };
    assert_eq!(all.in_words(), "14 objects, 1 goal and 2 classes of robots");

    let conditions = Conditions::resolve(&flockbot(), &settings(world.clone())).unwrap();

    assert_eq!(conditions.bodies().classes, [0, 1, 0]);
    let text = serde_json::to_string(&conditions).unwrap();
    assert_eq!(serde_json::from_str::<Conditions>(&text).unwrap(), conditions);
    let mut more = settings(world);
    more.values.push((Axis::Robots, 2.0));
    let error = Conditions::resolve(&flockbot(), &more).unwrap_err();
    assert_eq!(
        error.to_string(),
        "classes[0] of the world: classes with a `count` have 2 of the 2 robots, which leaves too few for 1 without one"
    );
    assert!(error.help().is_some_and(|help| help.starts_with("lower a `count`, or take more")));
}

#[test]
fn classes_that_cannot_be_are_refused_with_line_reason_and_cure() {
    for (from, to, expected, cure) in [
        ("name: sheep", "nam: sheep", "world.yaml:3:6: unknown key `nam`", "the keys here are: "),
        ("name: sheep", "name: Sheep", "world.yaml:3: `Sheep` is no name of a class", "call it"),
        ("sheep}", "shepherd}", "world.yaml:3: `shepherd` is the name of two classes", "give one"),
        (
            "count: 2",
            "count: 0",
            "world.yaml:2: `count` is 0, expected a number from 1",
            "leave out",
        ),
        (
            "count: 2",
            "count: 4",
            "world.yaml:2: classes with a `count` have 4 of the 4 robots, which leaves too few for 1 without one",
            "lower a `count`, or take more `robots`: each class has one or more",
        ),
        (
            "sheep}",
            "sheep, count: 1}",
            "world.yaml:3: the classes have 3 robots together, and there are 5",
            "leave `count` out of one class, which then has the others",
        ),
        (
            CLASSES,
            "classes:\n  - {name: a}\n  - {name: b}\n  - {name: c}\n  - {name: d}\n  - {name: e}\n",
            "world.yaml:6: 5 classes of robots are more than the 4 robots",
            "take fewer classes, or more `robots`",
        ),
    ] {
        assert_refused(&edited(CLASSES, from, to), (&[3.0], &[5, 4]), expected, cure);
    }
}

#[test]
fn segregation_is_judged_where_classes_are_known_and_else_refused_by_name() {
    let sorted =
        behaviour("sorted", "segregated: {at_least: 0.9}, least_segregated: {at_least: 0.7}");
    // Two classes by turns, of which the first is together and the second has one robot apart.
    let poses = [0.0, 5.0, 0.2, 5.2, 0.4, 9.0].map(|x_m| Pose { x_m, y_m: 0.0, heading_rad: 0.0 });
    let n_samples = samples_in(60.0, 0.1);
    let run = Trajectory::of_poses(0.1, 6, poses.repeat(n_samples));
    let bodies = Bodies { radius_m: Some(0.1), classes: vec![0, 1, 0, 1, 0, 1], ..Bodies::UNKNOWN };
    let label = |bodies: &Bodies| label_with(&run, bodies, &sorted.rules());

    let evidence = label(&bodies).expect("all is known").evidence;
    let value = |key| Parameter::from_key(key).expect("it is in the table").of(&evidence);
    assert!((value("segregated") - 5.0 / 6.0).abs() < 1e-12);
    assert!((value("least_segregated") - 2.0 / 3.0).abs() < 1e-12);
    let error = label(&Bodies { classes: Vec::new(), ..bodies.clone() }).unwrap_err().to_string();
    assert_eq!(error, "segregated is of classes of robots, and there are none, or none is known");
    let error = label(&Bodies { classes: vec![0, 1], ..bodies.clone() }).unwrap_err().to_string();
    assert_eq!(error, "the classes of 2 robots are known, of 6, and segregated depends on them");
    let error = label(&Bodies { radius_m: None, ..bodies }).unwrap_err();
    assert!(matches!(error, JudgeError::UnknownRadius { .. }), "{error}");
}

#[test]
fn the_share_of_the_last_class_at_a_goal_is_counted_where_goals_and_classes_are_known() {
    let brought = behaviour("brought", "last_class_at_goal: {at_least: 0.5}");
    // A shepherd in the goal and one outside, and between them three sheep, of which one leaves it halfway.
    let places = |leaving_m: f64| [0.0, 0.1, 2.0, leaving_m, 3.0];
    let samples = |leaving_m| {
        places(leaving_m)
            .map(|x_m| Pose { x_m, y_m: 0.0, heading_rad: 0.0 })
            .repeat(samples_in(30.0, 0.1))
    };
    let poses = [samples(0.2), samples(2.5)].concat();
    let run = Trajectory::of_poses(0.1, 5, poses);
    let world = WorldFile {
        goals: vec![Goal { place_m: [0.0, 0.0], radius_m: 0.3 }],
        ..WorldFile::NOTHING
    };
    let bodies = Bodies { world, classes: vec![0, 1, 0, 1, 1], ..Bodies::UNKNOWN };
    let label = |bodies: &Bodies| label_with(&run, bodies, &brought.rules());

    let evidence = label(&bodies).expect("all is known").evidence;
    let share = Parameter::from_key("last_class_at_goal").expect("it is in the table");
    let half = samples_in(30.0, 0.1) as f64 / run.n_samples() as f64;
    assert!((share.of(&evidence) - (1.0 + half) / 3.0).abs() < 1e-2, "{}", share.of(&evidence));
    let error = label(&Bodies { classes: Vec::new(), ..bodies.clone() }).unwrap_err().to_string();
    assert_eq!(
        error,
        "last_class_at_goal is of classes of robots, and there are none, or none is known"
    );
    let error = label(&Bodies { world: WorldFile::NOTHING, ..bodies }).unwrap_err().to_string();
    assert!(error.starts_with("last_class_at_goal is of goals"), "{error}");
}

/// A room like an L, with a pillar and a triangle in it.
const ROOM: &str = "\
arena: {polygon_m: [[-2, -2], [2, -2], [2, 0], [0, 0], [0, 2], [-2, 2]]}
obstacles:
  - {place_m: [-1, -1], radius_m: 0.3}
  - {polygon_m: [[1, -1.5], [1.5, -1.5], [1, -1]]}
objects: [{places_m: [[-1, 1]], radius_m: 0.1}]
goals: [{place_m: [1, -1], radius_m: 0.4}]
";

fn room() -> WorldFile {
    WorldFile::parse("world.yaml", ROOM, &[], &[]).expect("it is one")
}

#[test]
fn an_arena_of_a_world_is_a_part_of_it_and_none_beside_it() {
    let without_arena = |world| {
        let mut settings = settings(world);
        settings.values.retain(|(axis, _)| *axis != Axis::Arena);
        settings
    };
    let conditions = Conditions::resolve(&flockbot(), &without_arena(room())).unwrap();

    assert_eq!(conditions.arena.side_m.to_bits(), 4.0_f64.to_bits(), "of the square around it");
    let expected = "a polygon of 6 corners, 2 obstacles, 1 object and 1 goal";
    assert_eq!(conditions.world.in_words(), expected);
    let text = serde_json::to_string(&conditions).unwrap();
    assert_eq!(serde_json::from_str::<Conditions>(&text).unwrap(), conditions);
    for (place_m, is_within) in [
        ([-1.0, 1.0], true),
        ([1.0, 1.0], false),
        ([-1.0, -1.37], false),
        ([-1.0, -1.38], true),
        // Beside the corner that points inward.
        ([-0.05, 0.05], false),
        ([-0.06, -0.06], true),
    ] {
        assert_eq!(conditions.is_within_walls(place_m, 0.075), is_within, "{place_m:?}");
    }
    let error = Conditions::resolve(&flockbot(), &settings(room())).unwrap_err();
    assert_eq!(
        error.to_string(),
        "`arena_m` is 3 m, and the world has an arena of its own, a polygon of 6 corners"
    );
    assert_eq!(error.help().as_deref(), Some("leave `arena_m` out, or `arena` out of the world"));
    let obstacles = WorldFile { arena: None, objects: Vec::new(), ..room() };
    let square = Conditions::resolve(&flockbot(), &settings(obstacles)).unwrap();
    assert_eq!(square.arena.side_m.to_bits(), 3.0_f64.to_bits());
}

#[test]
fn arenas_and_obstacles_that_cannot_be_are_refused_with_line_reason_and_cure() {
    let arena = "polygon_m: [[-2, -2], [2, -2], [2, 0], [0, 0], [0, 2], [-2, 2]]";
    for (from, to, expected, cure) in [
        (
            arena,
            "disc_m: 2, rectangle_m: [4, 4]",
            "world.yaml:1: an arena needs exactly one of `rectangle_m`, `disc_m` and `polygon_m`",
            "give `rectangle_m: [4, 2]`, `disc_m: 2`, or `polygon_m: [[x, y], …]`",
        ),
        (arena, "", "world.yaml:1: an arena needs exactly one of", "give `rectangle_m"),
        (
            arena,
            "disc_m: 0",
            "world.yaml:1: `disc_m` is 0, expected a number from",
            "give a length",
        ),
        (arena, "rectangle_m: [4, -2]", "world.yaml:1: `rectangle_m` is -2, expected", "give a"),
        (arena, "radius_m: 2", "world.yaml:1:9: unknown key `radius_m`", "the keys here are: "),
        (
            arena,
            "polygon_m: [[0, 0], [1, 0]]",
            "world.yaml:1: `polygon_m` has 2 corners, expected 3 to 1000",
            "give the corners in order, each once",
        ),
        (
            "[2, 0], [0, 0], [0, 2]",
            "[0, 2], [0, 0], [2, 0]",
            "world.yaml:1: the sides of `polygon_m` from (2, -2) m and from (0, 0) m meet",
            "give the corners in order, one way round",
        ),
        (
            "[2, 0], [0, 0]",
            "[2, 0], [2, 0]",
            "world.yaml:1: the sides of `polygon_m` from (2, 0) m and from (2, 0) m meet",
            "give the corners in order, one way round",
        ),
        (
            "[2, 0], [0, 0]",
            "[2, 0], [0, -2]",
            "world.yaml:1: the sides of `polygon_m` from (-2, -2) m and from (2, 0) m meet",
            "give the corners in order",
        ),
        (
            "[-1, -1], radius_m: 0.3",
            "[-1, -1]",
            "world.yaml:3: an obstacle needs both `place_m` and `radius_m`, or `polygon_m` alone",
            "give `place_m: [1, 0], radius_m: 0.3` of a disc",
        ),
        (
            "{polygon_m: [[1, -1.5]",
            "{place_m: [0, 0], polygon_m: [[1, -1.5]",
            "world.yaml:4: an obstacle needs both",
            "give `place_m",
        ),
        (
            "[-1, -1], radius_m: 0.3",
            "[1, 1], radius_m: 0.3",
            "world.yaml:3: an obstacle at (1, 1) m is beyond the arena, a polygon of 6 corners",
            "move it, or leave it out; the origin is the middle of the arena",
        ),
        (
            "[[-1, 1]]",
            "[[-1, -0.7]]",
            "world.yaml:5: an object of radius 0.1 m at (-1, -0.7) m overlaps with an obstacle",
            "move the object, or the obstacle",
        ),
        (
            "[[-1, 1]]",
            "[[0.2, 1]]",
            "world.yaml:5: an object of radius 0.1 m at (0.2, 1) m is not within the arena, a polygon",
            "move it, or widen `arena_m`, or the world's `arena`",
        ),
        (
            "places_m: [[-1, 1]]",
            "count: 400",
            "world.yaml:5: 400 objects of radius 0.1 m do not fit into the arena, a polygon of 6 \
             corners: at most 346 ever do",
            "take fewer or smaller ones",
        ),
        (
            "[1, -1], radius_m: 0.4",
            "[1, -0.3], radius_m: 0.4",
            "world.yaml:6: a goal of radius 0.4 m at (1, -0.3) m is not within the arena, a polygon",
            "move it",
        ),
    ] {
        assert_refused(&edited(ROOM, from, to), (&[], &[]), expected, cure);
    }
}

#[test]
fn robots_start_within_the_walls_of_whatever_shape_and_trials_are_without_them() {
    let mut conditions = Conditions::resolve(
        &flockbot(),
        &Settings {
            values: vec![(Axis::Speed, 0.15), (Axis::TurnRate, 0.75), (Axis::Robots, 2.0)],
            world: WorldFile { objects: Vec::new(), ..room() },
            ..Settings::default()
        },
    )
    .unwrap();
    let at = |x_m: f64, y_m: f64| Pose { x_m, y_m, heading_rad: 0.0 };
    let given = |second| Placement::Given { starts: vec![vec![at(-1.0, 1.0), second]] };
    conditions.placement = given(at(1.0, -0.5));
    assert_eq!(conditions.check(), Ok(()));
    for outside in [at(1.0, 1.0), at(1.1, -1.4), at(-1.0, -1.0), at(0.0, 0.0)] {
        conditions.placement = given(outside);
        let Pose { x_m, y_m, .. } = outside;
        let expected = format!(
            "replicate 0: robot 2 starts at ({x_m}, {y_m}) m, which is not within the walls of the \
             arena, a polygon of 6 corners with obstacles"
        );
        assert_eq!(conditions.check().unwrap_err().to_string(), expected);
    }
    conditions.placement = Placement::Pair { distance_m: 0.5, bearing_rad: 0.0 };
    let error = conditions.check().unwrap_err().to_string();
    assert_eq!(
        error,
        "the placement is a pair, for a trial, and the world has an arena or obstacles"
    );
}

#[test]
fn what_hangs_on_the_arena_is_measured_in_its_own_shape() {
    let disc = "{arena: {disc_m: 1}, obstacles: [{place_m: [0.5, 0], radius_m: 0.1}]}";
    let bodies = |text: &str, radius_m: f64| {
        let world = WorldFile::parse("world.yaml", text, &[2.0], &[]).expect("it is one");
        Bodies { radius_m: Some(radius_m), arena_m: Some(2.0), world, ..Bodies::UNKNOWN }
    };
    let measured = |places_m: &[[f64; 2]], key: &str, bodies: &Bodies| {
        let poses =
            places_m.iter().map(|[x_m, y_m]| Pose { x_m: *x_m, y_m: *y_m, heading_rad: 0.0 });
        let run = Trajectory::of_poses(0.1, places_m.len(), poses.collect());
        let parameter = Parameter::from_key(key).expect("it is in the table");
        parameter.of(&OrderParameters::with(&run, 0..1, bodies, &[parameter]))
    };
    let is = |found: f64, expected: f64| assert!((found - expected).abs() < 1e-12, "{found}");

    is(measured(&[[-0.6, 0.0], [0.0, 0.8]], "wall_distance_m", &bodies(disc, 0.1)), 0.3);
    // To the obstacle, and in it.
    is(measured(&[[0.2, 0.0], [0.5, 0.05]], "wall_distance_m", &bodies(disc, 0.1)), 0.1);
    // Of 20 by 20 cells those whose middle is free: by area, about as many as pi less 1 % of it.
    let all: Vec<[f64; 2]> = (0..400)
        .map(|cell| {
            [0, 1].map(|axis| {
                let along = if axis == 0 { cell / 20 } else { cell % 20 };
                0.1 * f64::from(along) - 0.95
            })
        })
        .collect();
    is(measured(&all, "visited", &bodies(disc, 0.05)), 1.0);
    let one = measured(&all[190..191], "visited", &bodies(disc, 0.05));
    let area = std::f64::consts::PI * (1.0 - 0.01) / 0.01;
    assert!((1.0 / one - area).abs() < 8.0, "{one}");
    // Four robots in an L of three quarters: of 2 by 2 cells three are free.
    let l_shape = "{arena: {polygon_m: [[-1, -1], [1, -1], [1, 0], [0, 0], [0, 1], [-1, 1]]}}";
    let quarters = [[-0.5, -0.5], [-0.4, -0.5], [0.5, -0.5], [-0.4, -0.4]];
    is(measured(&quarters, "coverage", &bodies(l_shape, 0.1)), 2.0 / 3.0);
    // A square is what it is without a shape.
    let square = "{arena: {rectangle_m: [2, 2]}}";
    for key in ["wall_distance_m", "coverage", "visited"] {
        let plain = Bodies { world: WorldFile::NOTHING, ..bodies(square, 0.1) };
        let found = measured(&quarters, key, &bodies(square, 0.1));
        is(found, measured(&quarters, key, &plain));
    }
}

#[test]
fn who_is_at_an_obstacle_is_not_accused_of_standing() {
    let drives = |robot_m: f64| {
        let n_samples = samples_in(60.0, 0.1);
        let pose = Pose { x_m: robot_m, y_m: 0.0, heading_rad: 0.0 };
        let mut run = Trajectory::of_poses(0.1, 1, vec![pose; n_samples]);
        run.commands.fill(Command { speed_m_s: 0.1, turn_rate_rad_s: 0.0 });
        run
    };
    let text = "obstacles: [{place_m: [0.5, 0], radius_m: 0.3}]";
    let world = WorldFile::parse("world.yaml", text, &[6.0], &[]).expect("it is one");
    let bodies = Bodies { radius_m: Some(0.1), arena_m: Some(6.0), world, ..Bodies::UNKNOWN };
    let known = Known { bodies, walls_m: Some(3.0), left_out: &[], unseen: &[] };

    assert_eq!(implausible(&drives(-1.0), &known, 10.0).len(), 1);
    assert_eq!(implausible(&drives(0.1), &known, 10.0), []);
}

const FAILURES: &str = "\
failures:
  - {robot: 3, at_s: 60, stops: true}
  - {count: 2, at_s: 30.5, stops: true, sensors_stick: true}
";

#[test]
fn failures_that_cannot_be_are_refused_with_line_reason_and_cure() {
    let world = WorldFile::parse("world.yaml", FAILURES, &[], &[3]).expect("it is one");
    assert_eq!(world.in_words(), "2 failures");
    let failing = Conditions::resolve(&flockbot(), &settings(world)).unwrap();
    let text = serde_json::to_string(&failing).unwrap();
    assert!(text.contains("{\"robot\":3,\"at_s\":60.0,\"stops\":true}"), "{text}");

    for (from, to, robots, expected, cure) in [
        (
            "robot: 3, ",
            "",
            5,
            "world.yaml:2: a failure needs exactly one of `robot` and `count`",
            "give `robot: 3`, or",
        ),
        (
            "count: 2",
            "count: 2, robot: 1",
            5,
            "world.yaml:3: a failure needs exactly one of",
            "give",
        ),
        (
            ", stops: true}",
            "}",
            5,
            "world.yaml:2: a failure needs `stops: true` or",
            "have the robot stop",
        ),
        ("robot: 3", "robot: 0", 5, "world.yaml:2: `robot` is 0, expected", ""),
        ("at_s: 60", "at_s: -1", 5, "world.yaml:2: `at_s` is -1, expected a number from 0", ""),
        ("at_s: 60", "at_s: .inf", 5, "world.yaml:2: `at_s` is inf, expected a number from 0", ""),
        ("at_s: 60, ", "", 5, "world.yaml:2:", ""),
        ("stops", "stop", 5, "world.yaml:2:26: unknown key `stop`", "the keys here are: "),
        (
            "",
            "",
            2,
            "world.yaml:2: robot 3 fails, and there are 2 robots, counted from 1",
            "lower it, or take more `robots`",
        ),
        ("robot: 3", "robot: 1", 1, "world.yaml:3: 2 robots fail, and there are 1", "lower it"),
    ] {
        assert_refused(&edited(FAILURES, from, to), (&[], &[robots]), expected, cure);
    }
}
