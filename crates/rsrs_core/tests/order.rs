//! Order parameters that are measured only where a behaviour asks for them: on swarms whose numbers are known by
//! construction.

use rsrs_core::judge::behaviour::Behaviour;
use rsrs_core::judge::certainty::Certainty;
use rsrs_core::judge::order::{OrderParameters, Parameter};
use rsrs_core::judge::phase::{JudgeError, label, label_with};
use rsrs_core::judge::reason::Reason;
use rsrs_core::judge::trajectory::{Bodies, Trajectory};
use rsrs_core::judge::window::samples_in;
use rsrs_core::robot::unicycle::Pose;
use rsrs_core::world::WorldFile;

const PERIOD_S: f64 = 0.1;
const ARENA_M: f64 = 3.0;
const BODIES: Bodies = Bodies {
    radius_m: Some(0.1),
    reach_m: Some(1.0),
    arena_m: Some(ARENA_M),
    world: WorldFile::NOTHING,
    classes: Vec::new(),
};

/// Robots whose poses are a function of robot and time.
fn run(n_robots: usize, duration_s: f64, pose: impl Fn(usize, f64) -> Pose) -> Trajectory {
    let n_samples = samples_in(duration_s, PERIOD_S);
    let poses = (0..n_samples).flat_map(|sample| {
        let time_s = sample as f64 * PERIOD_S;
        (0..n_robots).map(|robot| pose(robot, time_s)).collect::<Vec<_>>()
    });
    Trajectory::of_poses(PERIOD_S, n_robots, poses.collect())
}

/// Nine robots that stand, one in the middle of each ninth of the arena.
fn spread(robot: usize, _: f64) -> Pose {
    let [column, row] = [robot % 3, robot / 3].map(|place| place as f64 - 1.0);
    Pose { x_m: column, y_m: row, heading_rad: 0.7 }
}

fn measured(trajectory: &Trajectory, key: &str) -> f64 {
    let parameter = Parameter::from_key(key).expect("it is in the table");
    let window = 0..trajectory.n_samples();
    parameter.of(&OrderParameters::with(trajectory, window, &BODIES, &[parameter]))
}

fn assert_near(found: f64, expected: f64) {
    assert!((found - expected).abs() < 1e-9, "found {found}, expected {expected}");
}

/// A behaviour of two phases, of which this is wanted.
pub fn behaviour(name: &str, wanted: &str) -> Behaviour {
    let text = format!(
        "name: {name}\nwords: {{noun: doing, swarm: a swarm, verb: [do, does, did]}}\n\
         phases: [{{key: {name}_yes}}, {{key: {name}_no}}]\n\
         rules: [{{phase: {name}_yes, when: {{{wanted}}}}}]\notherwise: {name}_no\n"
    );
    Behaviour::parse("behaviour.yaml", &text).expect("it is one")
}

#[test]
fn headings_that_agree_are_polarised_and_those_of_a_ring_are_not() {
    let one_way = run(9, 20.0, |robot, time_s| Pose { x_m: time_s, ..spread(robot, 0.0) });
    let ring = run(9, 20.0, |robot, time_s| {
        let heading_rad = std::f64::consts::TAU * robot as f64 / 9.0 + time_s;
        Pose { heading_rad, ..spread(robot, 0.0) }
    });
    let halves = run(2, 20.0, |robot, _| Pose {
        heading_rad: std::f64::consts::FRAC_PI_2 * robot as f64,
        ..spread(robot, 0.0)
    });

    assert_near(measured(&one_way, "polarisation"), 1.0);
    assert_near(measured(&ring, "polarisation"), 0.0);
    assert_near(measured(&halves, "polarisation"), 0.5_f64.sqrt());
}

#[test]
fn the_spread_is_the_root_of_the_mean_squared_distance_from_the_centroid() {
    let apart =
        run(2, 20.0, |robot, _| Pose { x_m: 7.0 + robot as f64, y_m: -3.0, heading_rad: 0.0 });

    assert_near(measured(&apart, "spread_m"), 0.5);
    assert_near(measured(&run(9, 20.0, spread), "spread_m"), (12.0_f64 / 9.0).sqrt());
}

#[test]
fn walls_are_as_far_as_the_nearest_one() {
    assert_near(measured(&run(9, 20.0, spread), "wall_distance_m"), (8.0 * 0.5 + 1.5) / 9.0);
    let beyond = run(1, 20.0, |_, _| Pose { x_m: 1.7, y_m: 0.0, heading_rad: 0.0 });
    assert_near(measured(&beyond, "wall_distance_m"), 0.0);
}

#[test]
fn a_swarm_with_a_robot_in_each_cell_covers_its_arena() {
    let gathered = run(9, 20.0, |_, _| Pose { x_m: 0.1, y_m: 0.1, heading_rad: 0.0 });
    let half_of_the_time =
        run(
            9,
            20.0,
            |robot, time_s| {
                if time_s < 9.95 { spread(robot, 0.0) } else { spread(4, 0.0) }
            },
        );
    // Of ten robots, too, nine cells are covered.
    let ten = run(10, 20.0, |robot, _| spread(robot.min(8), 0.0));

    assert_near(measured(&run(9, 20.0, spread), "coverage"), 1.0);
    assert_near(measured(&gathered, "coverage"), 1.0 / 9.0);
    assert_near(measured(&half_of_the_time, "coverage"), f64::midpoint(1.0, 1.0 / 9.0));
    assert_near(measured(&ten, "coverage"), 1.0);
}

#[test]
fn what_was_visited_grows_with_the_window_and_is_the_same_in_each_of_its_blocks() {
    // Along one row of 15 cells of 0.2 m in a minute.
    let along = |_: usize, time_s: f64| Pose {
        x_m: -1.5 + 3.0 * time_s / 60.0,
        y_m: 0.05,
        heading_rad: 0.0,
    };
    let trajectory = run(1, 60.0, along);
    let mopping = behaviour("mopping", "visited: {at_least: 0.06}");

    let verdict = label_with(&trajectory, &BODIES, &mopping.rules()).expect("it is long enough");

    assert_near(measured(&trajectory, "visited"), 15.0 / 225.0);
    assert_near(measured(&run(1, 20.0, along), "visited"), 5.0 / 225.0);
    assert_eq!(verdict.phase, mopping.wanted());
}

#[test]
fn a_behaviour_about_an_arena_is_not_judged_where_there_is_none() {
    let covering = behaviour("covering", "coverage: {at_least: 0.7}");
    let visiting = behaviour("visiting", "visited: {at_least: 0.7}");
    let nowhere = Bodies { arena_m: None, ..BODIES };
    let of_no_size = Bodies { radius_m: None, ..BODIES };
    let trajectory = run(9, 70.0, spread);
    let judged = |bodies: &Bodies, behaviour: Behaviour| {
        label_with(&trajectory, bodies, &behaviour.rules()).map(|verdict| verdict.phase)
    };

    assert_eq!(judged(&BODIES, covering), Ok(covering.wanted()));
    let error = judged(&nowhere, covering).expect_err("there is no arena");
    assert!(matches!(error, JudgeError::NoArena { .. }));
    assert!(error.to_string().starts_with("coverage is of an arena with walls"), "{error}");
    let error = judged(&of_no_size, visiting).expect_err("a body has no size");
    assert!(matches!(error, JudgeError::UnknownRadius { .. }));
    assert_eq!(judged(&of_no_size, covering), Ok(covering.wanted()));
}

#[test]
fn reasons_and_margins_are_in_the_unit_of_the_order_parameter() {
    let behaviour = behaviour("gathering_up", "spread_m: {below: 1.0}");
    let rules = behaviour.rules();
    let trajectory = run(9, 70.0, spread);

    let verdict = label_with(&trajectory, &BODIES, &rules).expect("it is long enough");
    let reason = Reason::new(&trajectory, &BODIES, &verdict, &rules);
    let certainty = Certainty::new(&verdict, &rules);

    assert_eq!(
        reason.rules[0].to_string(),
        "spread_m 1.15 m, and less than 1.00 m is gathering up yes"
    );
    assert_near(certainty.margins[0].distance, 1.0 - (12.0_f64 / 9.0).sqrt());
    assert_eq!(certainty.nearest.map(|it| it.becomes), Some(behaviour.wanted()));
}

#[test]
fn who_does_not_ask_does_not_get_and_files_have_names_and_values_alone() {
    let trajectory = run(9, 70.0, spread);
    let usual = label(&trajectory, &BODIES).expect("it is long enough").evidence;
    let polarisation = Parameter::from_key("polarisation").expect("it is in the table");
    let asked = OrderParameters::with(&trajectory, 0..700, &BODIES, &[polarisation]);

    let text = serde_json::to_string(&asked).expect("they are plain data");

    assert_eq!(polarisation.value(&usual), None);
    assert!(!format!("{usual:?}").contains("asked"), "{usual:?}");
    assert!(text.ends_with(r#","polarisation":1.0}"#), "{text}");
    assert_eq!(serde_json::from_str::<OrderParameters>(&text).expect("it was written"), asked);
    assert_eq!(Parameter::of_behaviour(Behaviour::MILLING).len(), 12);
}
