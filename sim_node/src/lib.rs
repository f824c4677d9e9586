//! The simulator node: the world behind the topics of a fleet, in lockstep or in real time.
//!
//! One process stands in for many robots, each with the topics, types and gate of a real one, all
//! on one participant. The pace is decided by [`rsrs_fleet::simulator`], who may move by
//! [`rsrs_fleet::robot`], and what happens by [`rsrs_sim::world`]: with a seed it passes through
//! exactly the states of that replicate of a sweep, as long as it goes in lockstep.

mod display;
mod entities;
mod event_loop;
mod frames;
mod mixed;
mod parameters;
mod placed_world;
mod robots;
mod rows;
mod services;
mod steering;
mod subscriptions;
mod virtual_pose_publisher;

pub use rsrs_fleet::parameters::simulator::NODE;

use rsrs_ros::node_arguments::{NodeFlags, Part, Program, run};
use rsrs_ros::ros_args::TopicRules;

/// The world behind the topics of a fleet, in lockstep or in real time.
#[derive(Clone, Debug, clap::Parser)]
pub struct Flags {
    #[command(flatten)]
    node: NodeFlags,
}

/// Runs the node until SIGINT or SIGTERM.
pub fn main(flags: Flags) -> anyhow::Result<()> {
    let program = Program { nodes: &[NODE], topics: TopicRules::Refused, part: Part::Simulator };
    run(program, flags.node, event_loop::run)
}

#[cfg(test)]
mod tests {
    use rsrs_fleet::simulator::RECORDER_WINDOW;
    use rsrs_msgs::topics::{self, Durability, Reliability};

    /// The recorder confirms each step.
    const STEPS_PER_CONFIRMATION: u64 = 1;

    #[test]
    fn queues_are_reliable_and_deeper_than_what_lockstep_leaves_unread() {
        let counted_on =
            [topics::DETECTION, topics::CMD_VEL, topics::ODOM, topics::CLOCK, topics::WORLD_DIGEST];

        for topic in counted_on {
            let n_unread = RECORDER_WINDOW + STEPS_PER_CONFIRMATION;
            assert!(u64::from(topic.qos.depth) > n_unread, "{}", topic.name);
            assert_eq!(topic.qos.reliability, Reliability::Reliable, "{}", topic.name);
            // Who comes late is not handed an old command.
            assert_eq!(topic.qos.durability, Durability::Volatile, "{}", topic.name);
        }
    }
}
