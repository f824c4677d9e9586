//! What can go wrong with the bag of a run.

use std::io;

use rsrs_bags::BagError;
use rsrs_fleet::causes;
use rsrs_fleet::causes::{Cause, Chapter};
use rsrs_msgs::cdr::CdrError;

use crate::recorder::RecorderError;

/// The chapter about the bag.
pub fn of_bags() -> Chapter {
    Chapter {
        title: "The bag",
        about: "These stand behind `recorder:`, with the system's reason if there is one. A bag that does not \
                have all of the run ends it, as `failed`. The message names the folder, and `rsrs bag recover` \
                saves what is in it.",
        causes: of_recorder().into_iter().chain(of_writer()).collect(),
    }
}

fn of_recorder() -> Vec<Cause> {
    let topic = || "/robot_3/detection".to_owned();
    let full = BagError::Full { path: "results/bag".into(), max_bytes: 50 << 30 };
    let cdr = CdrError::NoEncapsulation { type_name: "std_msgs/msg/Bool", n_bytes: 3 };
    causes!(RecorderError {
        Bag { 0: full }: "The bag has reached `max_bag_gib` of the experiment file.", "Record fewer topics, or raise the limit.";
        Thread { source: io::ErrorKind::OutOfMemory.into() }: "The system gives the program no thread.", "End other programs on the computer.";
        TooSlow { n_waiting: 100_000 }: "More is recorded than the disk takes.", "Record to another disk, or fewer topics.";
        OutOfStep { topic: topic(), count: 17, found: 18 }: "In lockstep a message was lost on its way to the bag, which would not be complete.", "Run it again; look at the load of the computer.";
        Unstamped { topic: topic(), n_bytes: 3 }: "Somebody publishes a message that is too short for its type.", "End that program; `ros2 topic info -v` names it.";
        Undecodable { topic: topic(), source: cdr }: "Somebody publishes a message of another type than its topic.", "End that program; `ros2 topic info -v` names it.";
    })
}

/// What may happen to the files. Most of [`BagError`] is about bags that are read.
fn of_writer() -> Vec<Cause> {
    let path = || "results/bag".into();
    let cause = |error: BagError, means, remedy| Cause { shown: error.to_string(), means, remedy };
    let no_space = || io::Error::from(io::ErrorKind::StorageFull);
    vec![
        cause(
            BagError::Exists { path: path() },
            "Something is in the place of the new bag.",
            "Choose another folder (`-o`), or move that one away.",
        ),
        cause(
            BagError::Io { action: "close", path: path(), source: no_space() },
            "The system refuses: no right to write there, or no space.",
            "Look at `df -h` and at the owner of the folder.",
        ),
        cause(
            BagError::Write { path: path(), source: no_space().into() },
            "The disk is full, or was taken away.",
            "Make space; `rsrs bag recover` saves what was recorded.",
        ),
    ]
}
