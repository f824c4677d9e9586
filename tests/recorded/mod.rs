//! What a bag holds, message by message.

use std::path::Path;

use rsrs_bags::Bag;
use rsrs_core::world::WorldFile;
use rsrs_fleet::record::{ATTACHMENT, ExperimentRecord};
use rsrs_msgs::geometry_msgs::{PoseStamped, TwistStamped};
use rsrs_msgs::rsrs::WorldDigest;
use rsrs_msgs::{RosMessage, cdr};
use rsrs_sim::draw::Seed;
use rsrs_sim::episode::{episode_digests, run_episode};

/// All messages of a robot's topic.
pub fn messages<M: RosMessage>(bag: &Bag, robot: &str, topic: &str) -> Vec<M> {
    let name = format!("/{robot}/{topic}");
    bag.messages_on([name])
        .map(|message| {
            let bytes = message.expect("the bag is whole").bytes;
            cdr::decode(&bytes).expect("it is of the topic's type")
        })
        .collect()
}

/// A bag and the record in it.
pub fn record_of(path: &Path) -> (Bag, ExperimentRecord) {
    let bag = Bag::open(path).expect("a bag");
    let attached = &bag.attachment(ATTACHMENT).expect("it is attached").data;
    let record = ExperimentRecord::from_json(&String::from_utf8_lossy(attached)).expect("one");
    (bag, record)
}

/// The seed of a recorded run.
pub fn seed_of(record: &ExperimentRecord) -> Seed {
    Seed { seed: record.seed, replicate: record.replicate }
}

/// The same world, bit by bit, as one that is made of the record.
pub fn assert_digests_of_replicate(bag: &Bag, record: &ExperimentRecord) {
    let seed = seed_of(record);
    let expected = episode_digests(&record.conditions, seed, record.duration_s).expect("it fits");
    let digests: Vec<WorldDigest> = messages(bag, "swarm", "world_digest");
    let found: Vec<u64> = digests.iter().map(|digest| digest.digest).collect();
    assert!(found.len() > 400, "{}", found.len());
    assert_eq!(found, expected[..found.len()]);
}

/// The same places of every object as in the replicate, bit by bit; returns how many were pushed.
pub fn assert_objects_of_replicate(bag: &Bag, record: &ExperimentRecord) -> usize {
    let expected = run_episode(&record.conditions, seed_of(record), record.duration_s);
    let expected = expected.expect("it fits");
    let bits = |place_m: [f64; 2]| place_m.map(f64::to_bits);
    for object in 0..record.conditions.world.n_objects() {
        let name = format!("objects/{}", WorldFile::object_name(object));
        let found: Vec<PoseStamped> = messages(bag, &name, "pose");
        assert!(found.len() > 400, "{}", found.len());
        for (sample, message) in found.iter().enumerate() {
            let position = message.pose.position;
            let place_m = expected.objects_at(sample)[object];
            assert_eq!(bits([position.x, position.y]), bits(place_m), "object {object} {sample}");
        }
    }
    let (first, last) = (expected.objects_at(0), expected.objects_at(expected.n_samples() - 1));
    first.iter().zip(last).filter(|(before, after)| bits(**before) != bits(**after)).count()
}

/// The same commands of every robot as in the replicate.
pub fn assert_commands_of_replicate(bag: &Bag, record: &ExperimentRecord) {
    let seed = seed_of(record);
    let episode = run_episode(&record.conditions, seed, record.duration_s).expect("it fits");
    for (place, robot) in record.robots.iter().enumerate() {
        let commands: Vec<TwistStamped> = messages(bag, robot, "cmd_vel");
        assert!(commands.len() > 400, "{}", commands.len());
        for (step, command) in commands.iter().enumerate() {
            let expected = episode.commands[step * record.robots.len() + place];
            let found = (command.twist.linear.x, command.twist.angular.z);
            assert_eq!(found, (expected.speed_m_s, expected.turn_rate_rad_s), "{robot} {step}");
        }
    }
}
