//! Programs of other makers over real DDS: rclpy of two distributions over Fast DDS, and Cyclone DDS.

#[path = "../controllers/mod.rs"]
mod controllers;
mod echo;
mod parameters;
mod peer;
mod rclpy;
#[path = "../../../../msgs/tests/messages/sampler.rs"]
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_possible_wrap,
    reason = "made-up numbers are bits of a draw, and which bits does not matter"
)]
mod sampler;

use peer::Maker;
use rsrs_testing::network::in_own_network;

#[test]
fn cyclone_dds_receives_and_publishes_every_topic_of_ours() {
    let python = Maker::Cyclone.python();
    in_own_network("cyclone_dds_receives_and_publishes_every_topic_of_ours", async || {
        echo::every_topic_both_ways(Maker::Cyclone, &python).await;
    });
}

#[test]
fn rclpy_of_jazzy_receives_and_publishes_every_topic_of_ours() {
    let python = Maker::Jazzy.python();
    in_own_network("rclpy_of_jazzy_receives_and_publishes_every_topic_of_ours", async || {
        echo::every_topic_both_ways(Maker::Jazzy, &python).await;
    });
}

#[test]
fn rclpy_of_kilted_receives_and_publishes_every_topic_of_ours() {
    let python = Maker::Kilted.python();
    in_own_network("rclpy_of_kilted_receives_and_publishes_every_topic_of_ours", async || {
        echo::every_topic_both_ways(Maker::Kilted, &python).await;
    });
}

#[test]
fn cyclone_uses_parameters_of_many_nodes_in_its_own_mapping_and_in_the_other() {
    let name = "cyclone_uses_parameters_of_many_nodes_in_its_own_mapping_and_in_the_other";
    let python = Maker::Cyclone.python();
    in_own_network(name, async || parameters::cyclone_uses_ours(&python).await);
}

#[test]
fn parameters_of_a_node_over_cyclone_are_used_in_its_mapping() {
    let python = Maker::Cyclone.python();
    in_own_network("parameters_of_a_node_over_cyclone_are_used_in_its_mapping", async || {
        parameters::we_use_cyclones(&python).await;
    });
}

#[test]
fn rclpy_lists_gets_sets_and_describes_parameters_and_reads_a_topic() {
    let name = "rclpy_lists_gets_sets_and_describes_parameters_and_reads_a_topic";
    let python = Maker::Jazzy.python();
    in_own_network(name, async || rclpy::uses_ours(&python).await);
}

#[test]
fn rclpy_of_kilted_does_so_too() {
    let python = Maker::Kilted.python();
    in_own_network("rclpy_of_kilted_does_so_too", async || rclpy::uses_ours(&python).await);
}
