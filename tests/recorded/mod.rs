//! What a bag holds, message by message.

use rsrs_bags::Bag;
use rsrs_msgs::{RosMessage, cdr};

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
