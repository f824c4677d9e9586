//! The whole loop, as a newcomer runs it.

mod processes;

use std::f64::consts::TAU;
use std::path::Path;
use std::time::Duration;

use processes::{Process, confined_rsrs, nodes_of};
use rsrs_bags::Bag;
use rsrs_fleet::record::{ATTACHMENT, ExperimentRecord};
use rsrs_msgs::cdr;
use rsrs_msgs::geometry_msgs::TwistStamped;
use rsrs_msgs::nav_msgs::Odometry;
use rsrs_msgs::rsrs::WorldDigest;
use rsrs_sim::draw::Seed;
use rsrs_sim::episode::{episode_digests, run_episode};

/// Far longer than it takes on a busy machine.
const PATIENCE: Duration = Duration::from_secs(300);

#[test]
fn the_whole_loop_leaves_bags_that_pass_through_the_states_of_the_replicates() {
    let folder = tempfile::tempdir().unwrap();
    let mut command = confined_rsrs();
    command.current_dir(&folder).args(["dry-run", "--experiments", "2", "-o", "loop"]);
    let mut process = Process::start(command.args(["--format", "json"]));
    let pid = process.0.id();
    let stdout = process.0.stdout.take().unwrap();
    let reading = std::thread::spawn(move || std::io::read_to_string(stdout).unwrap());

    let (status, errors) = process.wait(PATIENCE);

    assert!(status.success(), "{errors}");
    assert_eq!(nodes_of(pid), Vec::<u32>::new());
    let summary: serde_json::Value = serde_json::from_str(&reading.join().unwrap()).unwrap();
    let loop_folder = folder.path().join("loop");
    for file in ["sweep/cells.csv", "sweep/choice.json", "diagram.png", "comparison.json"] {
        assert!(loop_folder.join(file).is_file(), "{file}");
    }
    assert_eq!(summary["comparison"]["bags"].as_array().unwrap().len(), 2);
    let records: Vec<ExperimentRecord> = ["experiment_1", "experiment_2"]
        .map(|bag| check_bag(&loop_folder.join("bags").join(bag)))
        .into();
    assert_ne!(records[0].seed, records[1].seed);
    assert_eq!(records[0].conditions, records[1].conditions);
}

/// Checks that a bag lost nothing and that its states are those of the replicate with its seed.
fn check_bag(path: &Path) -> ExperimentRecord {
    let bag = Bag::open(path).expect("the bag is whole");
    assert_eq!(bag.damage().len(), 0);
    let record = bag.attachment(ATTACHMENT).expect("a bag of ours has a record");
    let record = std::str::from_utf8(&record.data).expect("JSON is text");
    let record = ExperimentRecord::from_json(record).expect("the record reads back");
    let seed = Seed { seed: record.seed, replicate: record.replicate };
    let expected =
        episode_digests(&record.conditions, seed, record.duration_s).expect("the robots fit");
    let n_steps = expected.len();

    let digests: Vec<WorldDigest> = messages(&bag, "/swarm/world_digest")
        .into_iter()
        .map(|(_, data)| cdr::decode(&data).expect("it is a digest"))
        .collect();
    let steps: Vec<u64> = digests.iter().map(|digest| digest.step).collect();
    assert_eq!(steps, (1..=n_steps as u64).collect::<Vec<_>>());
    assert!(digests.iter().map(|digest| digest.digest).eq(expected), "{}", path.display());

    let times: Vec<u64> = (1..=n_steps as u64).map(|step| step * 130_000_000).collect();
    for robot in &record.robots {
        for topic in ["detection", "cmd_vel", "odom"] {
            let recorded = messages(&bag, &format!("/{robot}/{topic}"));
            let found: Vec<u64> = recorded.iter().map(|(time_ns, _)| *time_ns).collect();
            assert!(found == times, "{robot} {topic}: {} of {n_steps}", found.len());
        }
    }
    check_poses_and_commands(&bag, &record, seed);
    record
}

fn check_poses_and_commands(bag: &Bag, record: &ExperimentRecord, seed: Seed) {
    let expected =
        run_episode(&record.conditions, seed, record.duration_s).expect("the robots fit");
    for (index, robot) in record.robots.iter().enumerate() {
        let of_robot = |row: usize| row * record.robots.len() + index;
        let poses = messages(bag, &format!("/{robot}/odom"));
        for (step, (_, bytes)) in poses.into_iter().enumerate() {
            let found = cdr::decode::<Odometry>(&bytes).expect("it is a pose").pose.pose;
            let pose = expected.poses[of_robot(step)];
            assert_eq!((found.position.x, found.position.y), (pose.x_m, pose.y_m));
            let heading_rad = 2.0 * libm::atan2(found.orientation.z, found.orientation.w);
            let apart_rad = libm::remainder(heading_rad - pose.heading_rad, TAU);
            // A quaternion in f64 keeps more of an angle than this.
            assert!(apart_rad.abs() < 1e-9, "{robot}, step {step}: {apart_rad} rad apart");
        }
        let commands = messages(bag, &format!("/{robot}/cmd_vel"));
        for (step, (_, bytes)) in commands.into_iter().enumerate() {
            let found = cdr::decode::<TwistStamped>(&bytes).expect("it is a command").twist;
            let command = expected.commands[of_robot(step)];
            assert_eq!(
                (found.linear.x, found.angular.z),
                (command.speed_m_s, command.turn_rate_rad_s)
            );
        }
    }
}

/// Log time and bytes of every message on a topic.
fn messages(bag: &Bag, topic: &str) -> Vec<(u64, Vec<u8>)> {
    bag.messages_on([topic])
        .map(|message| message.map(|message| (message.log_time_ns, message.bytes)))
        .collect::<Result<_, _>>()
        .expect("the bag is whole")
}
