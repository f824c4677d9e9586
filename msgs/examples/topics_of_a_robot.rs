//! Lists a robot's topics with their types, and the hashes by which ROS tells versions of a type apart.
//!
//! `cargo run -p rsrs_msgs --example topics_of_a_robot -- robot_1`

#![expect(clippy::print_stdout, reason = "prints its result")]

use rsrs_msgs::{schema, topics};

fn main() {
    let robot = std::env::args().nth(1).unwrap_or_else(|| "robot_1".to_owned());
    for topic in topics::ALL.iter().filter(|topic| !topic.is_absolute()) {
        let hash = schema::type_hash(topic.type_name).unwrap_or("without a hash");
        println!("{}: {} {hash}", topic.for_robot(&robot), topic.type_name);
    }
}
