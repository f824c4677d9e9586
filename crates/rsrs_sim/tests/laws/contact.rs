//! The laws of contact: bodies that stop each other, push each other, or pass through each other.

use crate::support::{
    self, Crowd, HARSHER, PERFECT, SEED, assert_judged_alike, at, drive, exact, flockbots,
};
use rsrs_core::conditions::{Arena, Conditions, Placement, Walls};
use rsrs_core::robot::contact::ContactModel;
use rsrs_core::robot::controller::Command;
use rsrs_core::robot::unicycle::Pose;
use rsrs_sim::batch::runs_in_lanes;
use rsrs_sim::draw::Seed;
use rsrs_sim::episode::{episode_digests, run_episode};
use rsrs_sim::pushing::SLACK;
use rsrs_sim::world::World;
use rsrs_testing::draw::Draw;

const DIAMETER_M: f64 = 0.15;
/// What a robot drives in a step, in metres.
const STEP_M: f64 = 0.02;
/// What single precision may do to a place, in metres.
const ROUNDING_M: f64 = 1e-6;

/// Robots in a row, a hair apart, all heading along it.
fn row(n_robots: u32) -> Vec<Pose> {
    (0..n_robots).map(|robot| at(f64::from(robot) * (DIAMETER_M + 1e-5), 0.0, 0.0)).collect()
}

/// Where robots are after steps of these commands.
fn driven(conditions: &Conditions, commands: &[Command], n_steps: usize) -> Vec<Pose> {
    support::driven(conditions, commands, n_steps).poses().collect()
}

fn closest_m(poses: &[Pose]) -> f64 {
    let pairs = poses.iter().enumerate().flat_map(|(robot, pose)| {
        let others = poses[..robot].iter();
        others.map(move |other| libm::hypot(pose.x_m - other.x_m, pose.y_m - other.y_m))
    });
    pairs.fold(f64::INFINITY, f64::min)
}

#[test]
fn of_robots_in_a_row_some_push_the_others_at_their_share_of_the_speed() {
    for (n_driving, n_standing) in [(1, 1), (1, 4), (3, 1), (3, 5)] {
        let n_robots = n_driving + n_standing;
        let start = row(n_robots);
        let conditions = exact(ContactModel::Push, start.clone());
        let command = |robot| if robot < n_driving { drive(STEP_M) } else { Command::STOP };
        let commands: Vec<Command> = (0..n_robots).map(command).collect();

        let end = driven(&conditions, &commands, 50);

        let ways_m: Vec<f64> = end.iter().zip(&start).map(|(to, from)| to.x_m - from.x_m).collect();
        let share = f64::from(n_driving) / f64::from(n_robots);
        let slack_m = f64::from(n_robots) * (SLACK * DIAMETER_M + 1e-5);
        for way_m in &ways_m {
            assert!((way_m - 50.0 * STEP_M * share).abs() < slack_m, "{n_driving}: {ways_m:?}");
        }
        let (sum_m, driven_m) = (ways_m.iter().sum::<f64>(), 50.0 * STEP_M * f64::from(n_driving));
        assert!((sum_m - driven_m).abs() < 1e-4, "what one loses another gains: {sum_m}");
        assert!(end.iter().all(|pose| pose.y_m.abs() < ROUNDING_M), "{end:?}");
    }
}

#[test]
fn who_meets_another_stops_pushes_or_passes_as_its_kind_does() {
    let start = vec![at(0.0, 0.0, 0.0), at(0.2, 0.0, 0.0)];
    let meets = |contact| {
        let end = driven(&exact(contact, start.clone()), &[drive(STEP_M), Command::STOP], 30);
        [end[0].x_m, end[1].x_m]
    };

    let [stopped_m, stood_m] = meets(ContactModel::Stop);
    assert!((stopped_m - 0.06).abs() < ROUNDING_M, "the first step within two radii: {stopped_m}");
    assert_eq!(stood_m.to_bits(), f64::from(0.2_f32).to_bits());
    let [pushing_m, pushed_m] = meets(ContactModel::Push);
    assert!((pushed_m - pushing_m - DIAMETER_M).abs() < SLACK * DIAMETER_M, "{pushed_m}");
    assert!((pushed_m - 0.2 - (0.6 - 0.05) / 2.0).abs() < 1e-3, "{pushed_m}");
    let [passed_m, _] = meets(ContactModel::None);
    assert!((passed_m - 0.6).abs() < ROUNDING_M, "{passed_m}");
}

#[test]
fn where_nobody_touches_anybody_all_contacts_are_the_same_to_the_bit() {
    let start: Vec<Pose> = (0..6).map(|robot| at(f64::from(robot), 0.3, 0.9)).collect();
    let commands = vec![Command { speed_m_s: 0.1, turn_rate_rad_s: 0.75 }; 6];
    let end = |contact| driven(&exact(contact, start.clone()), &commands, 200);

    let stopping = end(ContactModel::Stop);

    assert_eq!(end(ContactModel::Push), stopping);
    assert_eq!(end(ContactModel::None), stopping);
}

#[test]
fn who_is_not_pushed_does_not_move() {
    // One beside the row, nearer than a radius, and one ahead of it.
    let mut start = row(4);
    start.extend([at(0.2, 0.151, 1.0), at(2.0, 0.0, 2.0)]);
    let conditions = exact(ContactModel::Push, start.clone());
    let mut commands = vec![Command::STOP; 6];
    commands[0] = drive(STEP_M);

    let end = driven(&conditions, &commands, 20);
    let left_alone = driven(&conditions, &[Command::STOP; 6], 20);

    for robot in [4, 5] {
        assert_eq!(end[robot], left_alone[robot]);
    }
    assert!(end[3].x_m > start[3].x_m + 0.05, "the row was pushed: {end:?}");
}

/// A crowd on a floor that it fills.
fn crowd(n_robots: usize, way_m: f64, friction: f64) -> Crowd {
    let mut conditions = flockbots(way_m / 0.13, 2.0, &HARSHER);
    conditions.robots = n_robots;
    conditions.robot.contact = ContactModel::Push;
    conditions.robot.contact_friction = friction;
    conditions.placement = Placement::DiscFacingOut { radius_m: 0.55 };
    conditions.arena = Arena { side_m: 1.3, walls: Walls::Clamp };
    conditions.check().expect("it makes a world");
    Crowd::new(conditions)
}

#[test]
fn bodies_that_push_never_overlap_however_they_drive() {
    // Up to more than a diameter in each step, in a crowd that fills a third of the floor.
    for (way_m, friction) in [(0.01, 0.0), (0.03, 0.5), (0.2, 0.0), (0.2, 2.0)] {
        let mut crowd = crowd(20, way_m, friction);
        let mut world = World::new(&crowd.conditions, SEED).expect("they fit");
        for step in 0..300 {
            world.sense();
            world.advance(&crowd.commands());

            let poses: Vec<Pose> = world.poses().collect();
            let closest_m = closest_m(&poses);
            let least_m = (1.0 - SLACK) * DIAMETER_M - ROUNDING_M;
            assert!(closest_m >= least_m, "{way_m} {friction} {step}: {closest_m}");
            let limit_m = 0.65 - 0.075 + ROUNDING_M;
            let is_inside = |pose: &Pose| pose.x_m.abs().max(pose.y_m.abs()) <= limit_m;
            assert!(poses.iter().all(is_inside), "{way_m} {friction} {step}");
        }
    }
}

/// Twelve robots near each other, and commands that drive them together.
fn cluster() -> (Vec<Pose>, Vec<Command>) {
    let mut draw = Draw::new(5);
    let mut between = |least: f64, most: f64| least + (most - least) * draw.uniform();
    let place = |robot: u32| {
        let (x_m, y_m) = (0.17 * f64::from(robot % 4) - 0.25, 0.17 * f64::from(robot / 4) - 0.17);
        let (x_m, y_m) = (x_m + between(0.0, 0.015), y_m + between(0.0, 0.015));
        at(x_m, y_m, libm::atan2(-y_m, -x_m))
    };
    let poses: Vec<Pose> = (0..12).map(place).collect();
    let mut command = |_: u32| Command { speed_m_s: 0.1, turn_rate_rad_s: draw.uniform() - 0.5 };
    (poses, (0..12).map(&mut command).collect())
}

#[test]
fn neither_the_order_nor_the_side_of_robots_that_push_matters() {
    let (start, commands) = cluster();
    let pushed = |poses: Vec<Pose>, commands: &[Command]| {
        let mut conditions = exact(ContactModel::Push, poses);
        conditions.robot.contact_friction = 0.3;
        driven(&conditions, commands, 40)
    };
    let expected = pushed(start.clone(), &commands);
    assert!(closest_m(&expected) < DIAMETER_M + 1e-4, "they touch");

    let reversed = |poses: &[Pose]| poses.iter().rev().copied().collect::<Vec<_>>();
    let backward: Vec<Command> = commands.iter().rev().copied().collect();
    assert_eq!(reversed(&pushed(reversed(&start), &backward)), expected);

    let mirror = |pose: &Pose| Pose { y_m: -pose.y_m, heading_rad: -pose.heading_rad, ..*pose };
    let turned: Vec<Command> = commands
        .iter()
        .map(|command| Command { turn_rate_rad_s: -command.turn_rate_rad_s, ..*command })
        .collect();
    let mirrored = pushed(start.iter().map(mirror).collect(), &turned);
    assert_eq!(mirrored.iter().map(mirror).collect::<Vec<_>>(), expected);
}

#[test]
fn friction_takes_along_what_would_slide() {
    // The first drives past the second, obliquely into it.
    let start = vec![at(0.0, 0.0, 0.8), at(0.151, 0.0, 0.0)];
    let second_m = |contact_friction| {
        let mut conditions = exact(ContactModel::Push, start.clone());
        conditions.robot.contact_friction = contact_friction;
        let end = driven(&conditions, &[drive(STEP_M), Command::STOP], 2);
        let sum_m = end[0].y_m + end[1].y_m;
        assert!((sum_m - 2.0 * STEP_M * libm::sin(0.8)).abs() < ROUNDING_M, "{end:?}");
        end[1].y_m
    };

    assert!(second_m(0.0) < 0.0, "it slides off");
    assert!(second_m(0.5) > 0.0 && second_m(2.0) > second_m(0.5), "it is taken along");
}

#[test]
fn one_that_stops_is_moved_by_nobody_and_one_that_passes_meets_nobody() {
    let start = vec![at(0.0, 0.0, 0.0), at(0.16, 0.0, 0.0), at(0.32, 0.0, 0.0)];
    let with_second = |contact| {
        let mut conditions = exact(ContactModel::Push, start.clone());
        let mut own = conditions.robot.clone();
        own.contact = contact;
        conditions.own_robots.insert(1, own);
        driven(&conditions, &[drive(STEP_M), Command::STOP, Command::STOP], 20)
    };

    let held = with_second(ContactModel::Stop);
    let passed = with_second(ContactModel::None);

    assert_eq!(held[1].x_m.to_bits(), f64::from(0.16_f32).to_bits());
    assert!((held[0].x_m - 0.01).abs() < 2.0 * SLACK * DIAMETER_M, "{held:?}");
    assert_eq!(passed[1].x_m.to_bits(), f64::from(0.16_f32).to_bits());
    assert!(passed[2].x_m > 0.4 && passed[0].x_m > 0.25, "{passed:?}");
}

/// The state of 20 robots in a crowd after 200 steps: it changes only when the world does.
const GOLDEN: [(ContactModel, u64); 2] =
    [(ContactModel::Push, 0x77ad_5fdf_6c4b_a590), (ContactModel::None, 0x7519_5ccb_50bd_8309)];

#[test]
fn a_crowd_has_the_bits_that_it_always_had() {
    let found = GOLDEN.map(|(contact, _)| {
        let mut crowd = crowd(20, 0.03, 0.2);
        crowd.conditions.robot.contact = contact;
        let mut world = World::new(&crowd.conditions, SEED).expect("they fit");
        for _ in 0..200 {
            world.sense();
            world.advance(&crowd.commands());
        }
        (contact, world.digest())
    });

    assert_eq!(found, GOLDEN, "found {found:#018x?}");
}

#[test]
fn what_does_not_stop_is_left_to_the_reference_and_judged_alike() {
    let mut conditions = flockbots(0.15, 0.75, &HARSHER);
    assert!(runs_in_lanes(&conditions, 120.0));

    for contact in [ContactModel::Push, ContactModel::None] {
        conditions.robot.contact = contact;
        assert!(!runs_in_lanes(&conditions, 120.0), "{contact:?}");
        assert_judged_alike(&conditions, 3);
        let digests = episode_digests(&conditions, SEED, 10.0).expect("they fit");
        assert_eq!(digests, episode_digests(&conditions, SEED, 10.0).expect("they fit"));
    }
}

/// Where on the default plane do robots that stop overlap least and most: nobody is blocked by who is at its
/// side, so that there is no bound.
#[test]
fn robots_that_stop_overlap_as_far_as_is_stated() {
    let least = |speed_m_s, turn_rate_rad_s| {
        let conditions = flockbots(speed_m_s, turn_rate_rad_s, &PERFECT);
        let of_run = |replicate| {
            let run = run_episode(&conditions, Seed { seed: 1, replicate }, 300.0);
            let run = run.expect("they fit");
            let samples = 0..run.n_samples();
            samples.map(|sample| closest_m(run.poses_at(sample))).fold(f64::INFINITY, f64::min)
        };
        (0..4).map(of_run).fold(f64::INFINITY, f64::min) / DIAMETER_M
    };

    let (recommended, on_wide_circles) = (least(0.15, 0.75), least(0.175, 0.25));

    assert!(recommended > 0.9, "{recommended}");
    assert!(on_wide_circles < 0.15, "{on_wide_circles}");
}
