//! The laws of robots that fail at a time.

use rsrs_core::conditions::Conditions;
use rsrs_core::robot::contact::ContactModel;
use rsrs_core::robot::controller::Command;
use rsrs_core::robot::region::Region;

use rsrs_core::world::{Failure, WorldFile};
use rsrs_sim::batch::runs_in_lanes;
use rsrs_sim::draw::Seed;
use rsrs_sim::episode::run_episode;
use rsrs_sim::failures::standing;
use rsrs_sim::world::World;

use crate::support::{HARSHER, SEED, at, driven, flockbots, perfect_at, steered_digest};

fn of_robot(robot: usize, at_s: f64) -> Failure {
    Failure { robot: Some(robot), at_s, ..Failure::default() }
}

fn failing(failures: Vec<Failure>) -> Conditions {
    let mut conditions = flockbots(0.15, 0.75, &HARSHER);
    conditions.robot.gust_sd_m_s = 0.02;
    conditions.robot.turn_bias_sd_rad_s = 0.05;
    conditions.world = WorldFile { failures, ..WorldFile::NOTHING };
    conditions.check().expect("it makes a world");
    conditions
}

/// The first step from a time in seconds on, which is between two.
fn first_step(conditions: &Conditions, at_s: f64) -> usize {
    usize::try_from(conditions.steps(at_s)).expect("runs fit into memory") + 1
}

#[test]
fn a_robot_that_stops_stands_still_from_its_time_on_and_nobody_else() {
    let conditions = failing(vec![Failure { stops: true, ..of_robot(3, 20.0) }]);
    assert!(!runs_in_lanes(&conditions, 60.0));
    let run = run_episode(&conditions, SEED, 40.0).expect("they fit");
    let step = first_step(&conditions, 20.0);

    assert!((20.0..20.0 + conditions.period_s).contains(&(step as f64 * conditions.period_s)));
    for robot in 0..9 {
        let moved = |from: usize, to: usize| run.poses_at(from)[robot] != run.poses_at(to)[robot];
        assert!(moved(0, step) && moved(step - 1, step), "{robot}");
        let stands = (step + 1..run.n_samples()).all(|sample| !moved(step, sample));
        assert_eq!(stands, robot == 2, "{robot}");
    }
    assert_eq!(standing(&conditions, SEED), [2]);
    let commands = run.commands_at(run.n_samples() - 1);
    assert!(commands[2].speed_m_s > 0.0, "its controller does not know");
}

#[test]
fn a_robot_that_stands_is_pushed_as_any_other() {
    let mut conditions = perfect_at(vec![at(0.0, 0.0, 0.0), at(0.2, 0.0, 0.0)]);
    conditions.robot.contact = ContactModel::Push;
    let failures = vec![Failure { stops: true, ..of_robot(2, 0.0) }];
    conditions.world = WorldFile { failures, ..WorldFile::NOTHING };

    let ahead = [Command { speed_m_s: 0.1, turn_rate_rad_s: 0.0 }; 2];
    let world = driven(&conditions, &ahead, 60);

    let pushed_m = world.poses().nth(1).expect("two").x_m - 0.2;
    assert!((0.2..0.5).contains(&pushed_m), "at half of the speed: {pushed_m}");
}

#[test]
fn sensors_that_stick_report_what_they_reported_then() {
    let mut conditions = flockbots(0.15, 0.75, &HARSHER);
    // A sensor that reports something now and then.
    (conditions.robot.true_positive, conditions.robot.false_positive) = (0.5, 0.4);
    let failures = (1..=9).map(|robot| Failure { sensors_stick: true, ..of_robot(robot, 2.0) });
    conditions.world = WorldFile { failures: failures.collect(), ..WorldFile::NOTHING };
    for further in [false, true] {
        if further {
            conditions.robot.details.bearing_rad = 0.1;
        }
        conditions.check().expect("it makes a world");
        let mut world = World::new(&conditions, SEED).expect("they fit");
        let first = first_step(&conditions, 2.0);
        let reports: Vec<Vec<bool>> = (0..80)
            .map(|_| {
                let reported = world.sense().to_vec();
                assert_eq!(world.sense(), reported, "looking again changes nothing");
                let of_all = world.sense_all().iter().map(|readings| readings.detection());
                assert_eq!(of_all.collect::<Vec<_>>(), reported);
                world.advance(&[Command { speed_m_s: 0.1, turn_rate_rad_s: 0.3 }; 9]);
                reported
            })
            .collect();

        assert!(reports[..first].windows(2).any(|two| two[0] != two[1]));
        assert!(reports[first..].iter().all(|reported| *reported == reports[first]));
        assert!(reports[first].contains(&true) && reports[first].contains(&false));
    }
}

#[test]
fn who_fails_of_a_count_is_drawn_for_each_replicate_and_every_robot_as_often() {
    let drawn = Failure { count: Some(3), at_s: 5.0, stops: true, ..Failure::default() };
    let conditions = failing(vec![drawn]);
    let mut times = [0; 9];
    for replicate in 0..900 {
        let standing = standing(&conditions, Seed { seed: 1, replicate });
        assert_eq!(standing.len(), 3);
        for robot in standing {
            times[robot] += 1;
        }
    }
    // 300 each, within four standard errors.
    assert!(times.iter().all(|n| (243..=357).contains(n)), "{times:?}");

    let all = failing(vec![Failure { count: Some(9), at_s: 0.0, stops: true, ..drawn }]);
    let run = run_episode(&all, SEED, 10.0).expect("they fit");
    assert!((1..run.n_samples()).all(|sample| run.poses_at(sample) == run.poses_at(0)));
}

#[test]
fn worlds_in_which_robots_fail_have_the_bits_that_they_always_had() {
    let drawn = |count, at_s| Failure { count: Some(count), at_s, ..Failure::default() };
    let mut conditions = failing(vec![
        Failure { stops: true, ..of_robot(2, 7.0) },
        Failure { sensors_stick: true, ..drawn(3, 12.0) },
        Failure { stops: true, sensors_stick: true, ..drawn(2, 20.0) },
    ]);
    let plain = steered_digest(&conditions);
    conditions.robot.region = Region::Cone { half_angle_rad: 0.3, range_m: 1.0 };
    conditions.robot.details.bearing_rad = -0.2;
    conditions.robot.contact = ContactModel::Push;

    assert_eq!([plain, steered_digest(&conditions)], ["85e0633f0b682917", "0c536bd84a096ca3"]);
}
