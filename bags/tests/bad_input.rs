//! Bags that are in order and still not what was asked for.

use rsrs_bags::trajectory::TrajectoryError;
use rsrs_bags::{Bag, BagOptions, BagWriter, recover};
use rsrs_msgs::rsrs::RunLease;

use crate::recording::damage::{messages, temporary};
use crate::recording::outcome::read;
use crate::recording::{Recording, SPEED_M_S, odometry};

#[test]
fn an_empty_bag_is_whole_gives_no_trajectory_and_is_saved_empty() {
    let folder = temporary();
    let path = folder.path().join("run");
    BagWriter::create(&path, BagOptions::default()).unwrap().finish().unwrap();

    let bag = Bag::open(&path).unwrap();

    assert_eq!((bag.n_messages(), bag.damage().len(), bag.topics().len()), (0, 0, 0));
    let error = read(&bag).unwrap_err();
    assert!(matches!(&error, TrajectoryError::NoMessages { n_topics: 0 }));
    let saved = recover(&path).unwrap();
    assert_eq!(Bag::open(&saved.folder).unwrap().n_messages(), 0);
}

#[test]
fn a_bag_that_is_still_being_written_is_saved_up_to_its_last_flush_and_not_taken_for_a_run() {
    let folder = temporary();
    let path = folder.path().join("run");
    let mut recording = Recording::new(&path, &["robot_1", "robot_2"]);
    recording.lease(0, RunLease::RUNNING);
    (0..40).for_each(|step| recording.step(step));

    let bag = Bag::open(&path).unwrap();
    let refused = read(&bag).unwrap_err();
    let saved = recover(&path).unwrap();
    let read = read(&Bag::open(&saved.folder).unwrap()).unwrap();

    assert_eq!(bag.damage().len(), 1);
    assert!(matches!(&refused, TrajectoryError::Damaged(damage) if damage.is_end), "{refused}");
    // Everything but the last second.
    assert!((40 - 9..40).contains(&read.trajectory.n_samples()), "{}", read.trajectory.n_samples());
    assert_eq!(saved.n_messages, bag.n_messages());
    assert!(!saved.is_complete());
    // Nobody who looked on was in the way of the recorder.
    recording.step(40);
    recording.writer.finish().unwrap();
    assert_eq!(messages(&path).len(), 1 + 41 * 2 * 3);
}

#[test]
fn a_bag_of_other_robots_than_the_lease_names_is_refused_by_their_names() {
    let folder = temporary();
    let path = folder.path().join("run");
    let mut recording = Recording::new(&path, &["robot_1", "robot_2"]);
    let robots = ["robot_1", "robot_7", "robot_12"].map(str::to_owned).to_vec();
    let lease = RunLease { state: RunLease::RUNNING, epoch: 1, robots, ..RunLease::default() };
    let channel = recording.lease;
    recording.put(channel, 0, &lease);
    (0..40).for_each(|step| recording.step(step));
    recording.writer.finish().unwrap();

    let outcome = read(&Bag::open(&path).unwrap());

    let Err(TrajectoryError::MissingRobots { robots }) = outcome else { panic!("{outcome:?}") };
    assert_eq!(robots, ["robot_7", "robot_12"]);
}

#[test]
fn a_clock_that_was_set_back_in_the_middle_is_refused() {
    let folder = temporary();
    let path = folder.path().join("run");
    let mut recording = Recording::new(&path, &["robot_1", "robot_2"]);
    recording.lease(0, RunLease::RUNNING);
    for step in 0..40 {
        // The clock of all computers is set back by 15 steps.
        let stamped = if step < 20 { step } else { step - 15 };
        for robot in 0..2 {
            recording.odom(robot, stamped, &odometry(robot, stamped));
            recording.cmd_vel(robot, stamped, SPEED_M_S);
        }
    }
    recording.writer.finish().unwrap();

    let outcome = read(&Bag::open(&path).unwrap());

    // In the order of the bag's times the same stamps come twice.
    assert!(matches!(outcome, Err(TrajectoryError::TooClose { .. })), "{outcome:?}");
}
