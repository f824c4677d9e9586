//! Step 2: which real trajectories a simulated robot's reach contains.

use rsrs_core::conditions::{Conditions, Settings, Walls};
use rsrs_core::quantity::Axis;
use rsrs_core::robot::contact::ContactModel;
use rsrs_core::robot::controller::Command;
use rsrs_core::robot::harsher::HarsherFactors;
use rsrs_core::robot::profile::RobotProfile;
use rsrs_core::robot::unicycle::{ActuationGain, Pose, step};
use rsrs_core::trials::trial::{DrivenSample, DrivenTrial};
use rsrs_core::trials::validation::{TrialPlace, Validation};
use rsrs_core::world::{ObjectGroup, WorldFile};
use rsrs_sim::draw::Seed;
use rsrs_sim::reachable_set::{ReachError, ReachOptions, smallest_factors, validate};
use rsrs_sim::world::World;
use rsrs_testing::conditions::objects_anywhere;
use rsrs_testing::environment::or_if_long;

use rsrs_testing::conditions::flockbot;

const STRAIGHT: Command = Command { speed_m_s: 0.05, turn_rate_rad_s: 0.0 };
const CURVE: Command = Command { speed_m_s: 0.05, turn_rate_rad_s: 0.2 };

/// A Flockbot that also strays: bias and heading noise make its reach two-dimensional.
fn measured() -> RobotProfile {
    let mut profile = flockbot();
    profile.actuation.turn.bias_sd_rad_s = 0.004;
    profile.actuation.turn.heading_noise_sd_rad = 0.01;
    profile
}

fn harsher() -> RobotProfile {
    HarsherFactors::default().apply(&measured()).expect("the default factors are harsher")
}

fn options() -> ReachOptions {
    ReachOptions { n_robots: 1000, n_horizons: 5, ..ReachOptions::default() }
}

fn held_against(robot: &RobotProfile, trials: &[DrivenTrial]) -> Validation {
    validate(robot, &Settings::default(), trials, &options()).expect("it can be simulated")
}

/// One robot of a profile under a command, without walls.
fn alone(profile: &RobotProfile, command: Command) -> Conditions {
    let values = vec![
        (Axis::Speed, command.speed_m_s),
        (Axis::TurnRate, command.turn_rate_rad_s),
        (Axis::Robots, 1.0),
    ];
    let settings = Settings { values, walls: Walls::None, ..Settings::default() };
    Conditions::resolve(profile, &settings).expect("it can be simulated")
}

fn advance(world: &mut World, command: Command) {
    world.sense();
    world.advance(&[command]);
}

/// Samples of the robot of a world under a command, whose heading goes on from one to the next.
fn followed(world: &mut World, command: Command, period_s: f64) -> Vec<DrivenSample> {
    driven(command, period_s, |pose: &mut Pose| {
        let now = world.poses().next().expect("one robot");
        let turns = (now.heading_rad - pose.heading_rad) / std::f64::consts::TAU;
        *pose = now;
        pose.heading_rad -= turns.round() * std::f64::consts::TAU;
        advance(world, command);
    })
}

/// Trials of robots that are drawn from a profile: each drives straight and a curve, twice each.
fn drawn(profile: &RobotProfile, n_robots: u64, seed: u64) -> Vec<DrivenTrial> {
    let conditions = alone(profile, CURVE);
    let mut trials = Vec::new();
    for replicate in 0..n_robots {
        // Far from the seed with which reach is simulated.
        let seed = Seed { seed: 1_000_000 + seed, replicate };
        let mut world = World::new(&conditions, seed).expect("one robot has room");
        for (trial, command) in [STRAIGHT, CURVE, STRAIGHT, CURVE].into_iter().enumerate() {
            trials.push(DrivenTrial {
                robot: format!("robot_{replicate}"),
                trial: trial.to_string(),
                going_s: 0.0,
                samples: followed(&mut world, command, conditions.period_s),
            });
        }
    }
    trials
}

/// Robots whose turning rate lags, on a curve, seen from some steps after they began on; one trial each.
fn going(profile: &RobotProfile, n_steps_before: u32, n_robots: u64) -> Vec<DrivenTrial> {
    let command = Command { speed_m_s: 0.05, turn_rate_rad_s: 0.75 };
    let conditions = alone(profile, command);
    let trial = |replicate| {
        let seed = Seed { seed: 1_000_000, replicate };
        let mut world = World::new(&conditions, seed).expect("one robot has room");
        (0..n_steps_before).for_each(|_| advance(&mut world, command));
        let mut samples = followed(&mut world, command, conditions.period_s);
        samples.truncate(41);
        DrivenTrial {
            robot: format!("robot_{replicate}"),
            trial: "1".to_owned(),
            going_s: f64::from(n_steps_before) * conditions.period_s,
            samples,
        }
    };
    (0..n_robots).map(trial).collect()
}

#[test]
fn robots_that_lag_and_were_going_already_are_not_held_against_robots_from_a_standstill() {
    let mut profile = measured();
    profile.actuation.yaw_lag_s = 0.5;
    let simulated = HarsherFactors::default().apply(&profile).expect("it is harsher");
    let seen_late = going(&profile, 12, 4);
    let as_if_from_rest: Vec<DrivenTrial> =
        seen_late.iter().map(|trial| DrivenTrial { going_s: 0.0, ..trial.clone() }).collect();

    let from_rest = held_against(&simulated, &going(&profile, 0, 4));
    let late = held_against(&simulated, &seen_late);
    let mistaken = held_against(&simulated, &as_if_from_rest);

    assert!(from_rest.is_contained, "{}", from_rest.p_value);
    assert!(late.is_contained, "{}", late.p_value);
    assert!(!mistaken.is_contained, "the lag is not seen at all");
}

/// 154 control periods: 20 seconds, a metre.
fn driven(command: Command, period_s: f64, mut next: impl FnMut(&mut Pose)) -> Vec<DrivenSample> {
    let mut pose = Pose::default();
    (0..155)
        .map(|sample| {
            next(&mut pose);
            DrivenSample { time_s: f64::from(sample) * period_s, pose, command, object_m: None }
        })
        .collect()
}

/// Trials of robots without noise that all have the same gain, and turn on their own.
fn exact(n_robots: usize, gain: ActuationGain, bias_rad_s: f64) -> Vec<DrivenTrial> {
    let trial = |(robot, (trial, command)): (usize, (usize, Command))| {
        let with_bias =
            Command { turn_rate_rad_s: command.turn_rate_rad_s + bias_rad_s, ..command };
        let mut next_pose = Pose::default();
        DrivenTrial {
            robot: format!("robot_{robot}"),
            trial: trial.to_string(),
            going_s: 0.0,
            samples: driven(command, 0.13, |pose| {
                *pose = next_pose;
                next_pose = step(next_pose, with_bias, gain, 0.13);
            }),
        }
    };
    let robots = (0..n_robots).flat_map(|robot| {
        [STRAIGHT, CURVE].into_iter().enumerate().map(move |drive| (robot, drive))
    });
    robots.map(trial).collect()
}

const MEAN: ActuationGain = ActuationGain { speed: 0.971, turn: 0.97 };

#[test]
fn robots_within_the_measured_profile_are_contained_at_every_sample_size() {
    for (n_robots, seed) in [(1, 1), (1, 2), (3, 3), (3, 4), (10, 5), (10, 6), (30, 7)] {
        let found = held_against(&harsher(), &drawn(&measured(), n_robots, seed));

        assert!(found.is_contained, "{n_robots} robots, seed {seed}: {}", found.p_value);
        assert_eq!(found.n_trials as u64, 4 * n_robots);
    }
}

/// How many of some cases are refused; regions are drawn anew in each, as they would be by other
/// people.
fn n_refused(n_cases: u64, population: &RobotProfile, n_robots: u64) -> u64 {
    let robot = harsher();
    let is_refused = |seed: &u64| {
        let options = ReachOptions {
            n_robots: 400,
            n_horizons: 5,
            seed: 1 + seed,
            ..ReachOptions::default()
        };
        let trials = drawn(population, n_robots, *seed);
        let found = validate(&robot, &Settings::default(), &trials, &options);
        !found.expect("it can be simulated").is_contained
    };
    (0..n_cases).filter(is_refused).count() as u64
}

#[test]
fn robots_of_the_simulated_population_are_refused_in_at_most_five_of_a_hundred_cases() {
    let n_cases = or_if_long(20, 1000);
    for n_robots in [1, 4, 16] {
        let n_refused = n_refused(n_cases, &harsher(), n_robots);

        // If 5 % are refused, more than this are with a probability below 2 %.
        let sd = (0.05 * 0.95 * n_cases as f64).sqrt();
        let most = 0.05 * n_cases as f64 + 2.6 * sd;
        assert!(n_refused as f64 <= most, "{n_robots} robots: {n_refused} of {n_cases}");
    }
}

#[test]
fn noisy_robots_beyond_the_edge_by_a_tenth_are_refused_in_nineteen_of_twenty_cases() {
    let n_cases = or_if_long(10, 100);
    // The 99 % edges of the mean gain, times 1.1 and 0.9; robots differ as the measured ones do.
    for gain in [1.1 * (0.971 + 2.58 * 0.05), 0.9 * (0.971 - 2.58 * 0.05)] {
        let mut beyond = measured();
        for at in &mut beyond.actuation.speed.gain_by_command {
            at.mean = gain;
        }
        for n_robots in [1, 8] {
            let n_refused = n_refused(n_cases, &beyond, n_robots);

            let found = format!("gain {gain}, {n_robots} robots: {n_refused} of {n_cases}");
            assert!(20 * n_refused >= 19 * n_cases, "{found}");
        }
    }
}

#[test]
fn robots_beyond_the_edge_by_a_tenth_are_refused_at_every_sample_size() {
    // The 99 % edges of the gain: 2.58 standard deviations of 0.05 about the mean.
    let (fastest, slowest) = (0.971 + 2.58 * 0.05, 0.971 - 2.58 * 0.05);
    // The same edge of the heading after 20 s on a curve: bias, heading noise and turn gain.
    let bias_rad = 0.004 * 20.0;
    let noise_rad = 0.01 * (20.0_f64 / 0.13).sqrt();
    let gain_rad = 0.05 * CURVE.turn_rate_rad_s * 20.0;
    let sd_rad = libm::hypot(libm::hypot(bias_rad, noise_rad), gain_rad);
    let curving_rad_s = 1.1 * (2.58 * sd_rad + options().tolerance_rad) / 20.0;
    for n_robots in [1, 2, 5, 20] {
        let faster = exact(n_robots, ActuationGain { speed: fastest * 1.1, ..MEAN }, 0.0);
        let slower = exact(n_robots, ActuationGain { speed: slowest * 0.9, ..MEAN }, 0.0);
        let curving = exact(n_robots, MEAN, curving_rad_s);
        for (how, trials) in [("faster", faster), ("slower", slower), ("curving", curving)] {
            let found = held_against(&harsher(), &trials);

            assert!(!found.is_contained, "{n_robots} {how}: {}", found.p_value);
            assert_eq!(found.outside().count(), trials.len(), "{n_robots} {how}");
            let exit = found.trials[0].exits.last().expect("the trial is outside");
            match how {
                "faster" => assert!(exit.by_position && exit.ahead_m > 0.1, "{exit:?}"),
                "slower" => assert!(exit.by_position && exit.ahead_m < -0.1, "{exit:?}"),
                _ => assert!(exit.by_heading && exit.turned_rad > 0.1, "{exit:?}"),
            }
        }
    }
}

/// Robots that drive straight for 9 s at an object 30 cm ahead, which is where `then_m` has it once the robot is so
/// far, in metres. Round things that push round things lose them to a side before long.
fn at_an_object(n_robots: usize, then_m: impl Fn(f64) -> f64) -> Vec<DrivenTrial> {
    let with_object = |mut trial: DrivenTrial| {
        trial.samples.truncate(70);
        for sample in &mut trial.samples {
            sample.object_m = Some([then_m(sample.pose.x_m), 0.0]);
        }
        trial
    };
    let straight = |trial: &DrivenTrial| trial.samples[0].command == STRAIGHT;
    exact(n_robots, MEAN, 0.0).into_iter().filter(straight).map(with_object).collect()
}

/// A world with some objects of this weight.
fn with_objects(weight: f64) -> Settings {
    let group = ObjectGroup { weight, ..objects_anywhere(3, 0.05, 0.0) };
    Settings {
        world: WorldFile { objects: vec![group], ..WorldFile::NOTHING },
        ..Settings::default()
    }
}

#[test]
fn an_object_is_held_against_one_that_simulated_robots_push() {
    let robot = harsher();
    let touching_m = robot.body.radius_m + 0.05;
    let pushed = |robot_m: f64| (robot_m + touching_m).max(0.3);
    let held = |trials: &[DrivenTrial]| {
        validate(&robot, &with_objects(1.0), trials, &options()).expect("it can be simulated")
    };

    let found = held(&at_an_object(4, pushed));
    let passed = held(&at_an_object(4, |_| 0.3));
    let kicked = held(&at_an_object(4, |robot_m| pushed(robot_m) + 0.1 * f64::from(robot_m > 0.3)));

    assert!(found.is_contained && found.n_inside == 4, "{:?}", found.trials);
    assert_eq!(
        found.tubes.iter().map(|tube| tube.of_object).collect::<Vec<_>>(),
        [[false; 4], [true; 4]].concat()
    );
    for not_so in [passed, kicked] {
        assert!(!not_so.is_contained, "{}", not_so.p_value);
        assert_eq!(not_so.outside().count(), 4);
        let left = |place: &TrialPlace| {
            place.object.as_ref().is_some_and(|object| !object.exits.is_empty())
        };
        assert!(not_so.trials.iter().all(|place| place.exits.is_empty() && left(place)));
    }
}

#[test]
fn a_heavy_object_slows_the_simulated_robots_that_share_its_way() {
    let mut robot = harsher();
    robot.body.contact = ContactModel::Push;
    let touching_m = robot.body.radius_m + 0.05;
    let trials = at_an_object(4, |robot_m| (robot_m + touching_m).max(0.3));
    let held = |weight: f64| {
        validate(&robot, &with_objects(weight), &trials, &options()).expect("it can be simulated")
    };

    assert!(held(0.1).is_contained, "these robots were hardly slowed down");
    let heavy = held(4.0);
    assert!(!heavy.is_contained);
    let exit = heavy.trials[0].exits.last().expect("the real robot is further");
    assert!(exit.ahead_m > 0.05, "{exit:?}");
}

#[test]
fn objects_that_the_world_does_not_have_are_refused() {
    let refusal = |robot: &RobotProfile, settings: &Settings| {
        let trials = at_an_object(1, |_| 0.3);
        validate(robot, settings, &trials, &options()).expect_err("it is refused")
    };
    let mut ghost = harsher();
    ghost.body.contact = ContactModel::None;
    let mut mixed = with_objects(1.0);
    mixed.world.objects.extend(with_objects(2.0).world.objects);

    let none = refusal(&harsher(), &Settings::default());

    assert_eq!(none.to_string(), "trial `0` of robot_0 has an object, and the world has none");
    assert_eq!(refusal(&harsher(), &mixed), ReachError::ObjectsDiffer);
    assert_eq!(refusal(&ghost, &with_objects(1.0)), ReachError::PassesThrough);
    let mut large = with_objects(1.0);
    large.world.objects[0].radius_m = 0.3;
    let inside = refusal(&harsher(), &large);
    assert_eq!(
        inside.to_string(),
        "trial `0` of robot_0 begins with its object 0.300 m from the robot, expected the radii of both, 0.375 m, or more"
    );
    let in_millimetres = at_an_object(1, |robot_m| 0.3 + 1000.0 * robot_m);
    let found = validate(&harsher(), &with_objects(1.0), &in_millimetres, &options());
    assert!(matches!(found, Err(ReachError::NotPushed { .. })), "{found:?}");
}

#[test]
fn the_area_of_the_reach_grows_and_is_two_dimensional_also_when_driving_straight() {
    let found = held_against(&harsher(), &exact(2, MEAN, 0.0));

    let straight = found.tubes.iter().find(|tube| tube.command == Some(STRAIGHT)).unwrap();
    let areas_m2: Vec<f64> = straight.horizons.iter().map(|horizon| horizon.area_m2).collect();
    assert!(areas_m2.windows(2).all(|pair| pair[0] < pair[1]), "{areas_m2:?}");
    // Ahead, ±0.13 of a metre; beside, ±2.58 of what bias (4 cm) and noise (7 cm) add up to.
    let last = straight.horizons.last().unwrap();
    assert!((0.05..0.25).contains(&last.area_m2), "{areas_m2:?}");
    assert!((last.time_s - 20.02).abs() < 1e-6 && (last.mean_m[0] - 0.97).abs() < 0.02);
    assert_eq!((last.n_trials, last.n_inside), (2, 2));
}

#[test]
fn a_robot_without_noise_reaches_a_line_and_its_trials_must_be_on_it() {
    let flockbot = flockbot();
    let robot = HarsherFactors::default().apply(&flockbot).expect("harsher");

    let on_line = held_against(&robot, &exact(5, MEAN, 0.0));
    let beside = held_against(&robot, &exact(5, MEAN, 0.004));

    assert!(on_line.is_contained && !beside.is_contained);
    assert!(on_line.tubes[0].horizons[4].area_m2 < 0.02);
}

#[test]
fn the_smallest_factors_contain_faster_and_curving_robots() {
    let measured = measured();
    let base = HarsherFactors::default();
    let settings = Settings::default();
    // Three standard deviations of the measured robots beyond what the default factors contain.
    let faster = exact(5, ActuationGain { speed: 1.16, ..MEAN }, 0.0);
    let curving = exact(5, MEAN, 0.03);

    let found = smallest_factors(&measured, base, &settings, &faster, &options()).unwrap();
    let drifting = smallest_factors(&measured, base, &settings, &curving, &options()).unwrap();

    let factors = found.expect("a spread contains them").factors;
    assert!((2.5..8.0).contains(&factors.gain_sd_factor), "{factors:?}");
    assert_eq!(factors.drift_factor.to_bits(), 1.0_f64.to_bits());
    assert!(held_against(&factors.apply(&measured).unwrap(), &faster).is_contained);
    let factors = drifting.expect("more drift contains them").factors;
    assert_eq!(factors.gain_sd_factor.to_bits(), base.gain_sd_factor.to_bits());
    // A bias of 0.03 rad/s is 7.5 standard deviations of the measured one; 2.6 of them are 99 %.
    assert!((1.5..8.0).contains(&factors.drift_factor), "{factors:?}");
    assert!(held_against(&factors.apply(&measured).unwrap(), &curving).is_contained);
}

#[test]
fn no_factor_widens_what_a_profile_does_not_have() {
    let mut straight = measured();
    straight.actuation.turn.bias_sd_rad_s = 0.0;
    straight.actuation.turn.heading_noise_sd_rad = 0.0;
    let curving = exact(3, MEAN, 0.03);

    let none = smallest_factors(
        &straight,
        HarsherFactors::default(),
        &Settings::default(),
        &curving,
        &options(),
    );

    assert_eq!(none.unwrap(), None);
}

#[test]
fn the_same_seed_gives_the_same_answer() {
    let trials = drawn(&measured(), 3, 1);

    assert_eq!(held_against(&harsher(), &trials), held_against(&harsher(), &trials));
}

#[test]
fn what_cannot_be_held_against_a_simulator_is_refused() {
    let robot = harsher();
    let settings = Settings::default();
    let mut short = exact(1, MEAN, 0.0);
    short[0].samples.truncate(2);

    let nothing = validate(&robot, &settings, &[], &options());
    let too_short = validate(&robot, &settings, &short, &options());
    let few = ReachOptions { n_robots: 10, ..options() };
    let too_few = validate(&robot, &settings, &exact(1, MEAN, 0.0), &few);

    assert_eq!(nothing, Err(ReachError::NoTrials));
    assert_eq!(
        too_short.expect_err("a tenth of a second is no drive").to_string(),
        "trial `0` of robot_0 lasts 0.13 s, expected two control periods of 0.13 s or more"
    );
    assert_eq!(
        too_few.expect_err("ten robots have no 99 %").to_string(),
        "the number of simulated robots is 10, expected 200 or more"
    );
}
