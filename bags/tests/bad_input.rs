//! Bags that are in order and still not what was asked for.

use std::error::Error;
use std::fs;
use std::os::unix::fs::symlink;
use std::path::Path;

use rsrs_bags::trajectory::TrajectoryError;
use rsrs_bags::{Bag, BagError, BagOptions, BagWriter, Sample, recover, recover_into};
use rsrs_core::help::Help;
use rsrs_msgs::rsrs::{LeaseState, RunLease};

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
    recording.lease(0, LeaseState::Running);
    (0..40).for_each(|step| recording.step(step));

    let bag = Bag::open(&path).unwrap();
    let refused = read(&bag).unwrap_err();
    let saved = recover(&path).unwrap();
    let read = read(&Bag::open(&saved.folder).unwrap()).unwrap();

    assert_eq!(bag.damage().len(), 1);
    assert!(matches!(&refused, TrajectoryError::Damaged(damage) if damage.is_end), "{refused}");
    assert!(refused.to_string().contains("run_0.mcap breaks off at byte "), "{refused}");
    assert!(refused.help().is_some_and(|help| help.contains("rsrs bag recover")));
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
    let lease =
        RunLease { state: u8::from(LeaseState::Running), epoch: 1, robots, ..RunLease::default() };
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
    recording.lease(0, LeaseState::Running);
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

/// A file as rosbag2 compresses it as a whole.
fn packed(path: &Path, content: &[u8]) {
    let packed = zstd::encode_all(content, 19).expect("there is memory");
    fs::write(path, packed).expect("the folder is writable");
}

#[test]
fn nothing_that_lies_beside_a_bag_is_written_to_or_removed_when_it_is_saved() {
    let folder = temporary();
    let whole = folder.path().join("whole");
    let mut recording = Recording::new(&whole, &["robot_1", "robot_2"]);
    (0..40).for_each(|step| recording.step(step));
    recording.writer.finish().unwrap();
    packed(&folder.path().join("run.mcap.zstd"), &fs::read(whole.join("whole_0.mcap")).unwrap());
    let keys = folder.path().join("keys");
    fs::write(&keys, "mine").unwrap();
    let link = folder.path().join("run_recovered.unpacked.part");
    symlink(&keys, &link).unwrap();

    let saved = recover(&folder.path().join("run.mcap.zstd")).unwrap();

    assert_eq!(saved.n_messages, 40 * 2 * 3);
    assert_eq!(fs::read_to_string(&keys).unwrap(), "mine");
    assert!(link.is_symlink());
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 5, "nothing was left beside them");
}

#[test]
fn a_file_that_unpacks_to_far_more_than_its_size_is_saved_only_if_somebody_insists() {
    let folder = temporary();
    let path = folder.path().join("run.mcap.zstd");
    let content = [mcap::MAGIC, &vec![0; 65 << 20]].concat();
    packed(&path, &content);

    let error = recover(&path).unwrap_err();
    let into = folder.path().join("saved");
    let insisted = recover_into(&path, &into, Some(100 << 20)).unwrap_err();

    assert!(matches!(error, BagError::TooLarge { limit_bytes: 0x400_0000, .. }), "{error}");
    assert!(error.help().unwrap().contains("--unpack-limit"));
    assert!(matches!(insisted, BagError::NotMcap { .. }), "it was unpacked: {insisted}");
}

#[test]
fn a_message_that_unpacks_to_far_more_than_its_size_is_damage() {
    let folder = temporary();
    let path = folder.path().join("run");
    let mut recording = Recording::new(&path, &["robot_1", "robot_2"]);
    recording.step(0);
    let bomb = zstd::encode_all(&*vec![0; 65 << 20], 19).unwrap();
    let sample = Sample { log_time_ns: 1, publish_time_ns: 1, sequence: 1, data: &bomb };
    let channel = recording.lease;
    recording.writer.write(channel, sample).unwrap();
    recording.writer.finish().unwrap();

    let bag = Bag::open(&path).unwrap();
    let error = bag.messages().find_map(Result::err).unwrap();
    let saved = recover(&path).unwrap();

    assert!(bomb.len() < 10_000);
    let cause = error.source().unwrap().to_string();
    assert!(cause.contains("holds more than 67108864 bytes"), "{cause}");
    assert_eq!((saved.n_messages, saved.is_complete()), (6, false));
}

#[test]
fn a_table_of_contents_names_files_of_its_folder_and_pipes_are_no_files() {
    let folder = temporary();
    let path = folder.path().join("run");
    let mut recording = Recording::new(&path, &["robot_1", "robot_2"]);
    recording.step(0);
    recording.writer.finish().unwrap();
    fs::copy(path.join("run_0.mcap"), folder.path().join("elsewhere.mcap")).unwrap();
    let table = path.join("metadata.yaml");
    let text = fs::read_to_string(&table).unwrap();
    for outside in ["../elsewhere.mcap", folder.path().join("elsewhere.mcap").to_str().unwrap()] {
        fs::write(&table, text.replace("run_0.mcap", outside)).unwrap();

        let error = Bag::open(&path).unwrap_err();

        let missing = path.join("elsewhere.mcap").display().to_string();
        assert!(error.to_string().contains(&missing), "{error}");
    }
    fs::write(&table, &text).unwrap();
    fs::remove_file(path.join("run_0.mcap")).unwrap();
    rustix::fs::mkfifoat(rustix::fs::CWD, path.join("run_0.mcap"), rustix::fs::Mode::RUSR).unwrap();

    let error = Bag::open(&path).unwrap_err();

    let is_refused = |error: &BagError| {
        let cause = Error::source(error).expect("it has a cause").to_string();
        assert_eq!(cause, "it is not a regular file", "{error}");
    };
    is_refused(&error);
    fs::remove_file(&table).unwrap();
    rustix::fs::mkfifoat(rustix::fs::CWD, &table, rustix::fs::Mode::RUSR).unwrap();
    for error in [Bag::open(&path).unwrap_err(), recover(&path).unwrap_err()] {
        is_refused(&error);
    }
}
