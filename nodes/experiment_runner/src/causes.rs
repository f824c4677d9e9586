//! What can go wrong with the bag of a run, and with what some runs have: objects and further readings.

use std::io;

use rsrs_bags::BagError;
use rsrs_bags::trajectory::Finding;
use rsrs_fleet::causes::{Cause, Chapter};
use rsrs_fleet::preflight::Problem;
use rsrs_fleet::runner::{Failure, LossCause, SampleKind};
use rsrs_fleet::{causes, contradictions, controller};
use rsrs_msgs::cdr::CdrError;

use crate::recorder::RecorderError;

/// The chapter about objects and further readings.
pub fn of_objects_and_readings() -> Chapter {
    Chapter {
        title: "Objects and further readings",
        about: "What stands in none of the chapters above, of robots with [several sensors](sensors.md) and of \
                [objects](worlds.md) that they push.",
        causes: of_readings().into_iter().chain(of_objects()).collect(),
    }
}

fn of_readings() -> [Cause; 4] {
    let robot = || "robot_3".to_owned();
    let wall = || SampleKind::FurtherDetection("wall".to_owned());
    let first = Failure::NoSample { robot: robot(), kind: wall() };
    let loss = LossCause::NoSample { kind: wall(), silence_s: 3 };
    [
        Cause {
            shown: first.to_string(),
            means: "The robot's further sensor has a publisher, and nothing came from it while the robots moved.",
            help: "`ros2 topic hz` on its topic before the next run.",
        },
        Cause {
            shown: loss.to_string(),
            means: "A further sensor fell silent; a robot without one of its readings is not commanded.",
            help: "Look at the sensor, and at the node that publishes it.",
        },
        Cause {
            shown: controller::nothing_on("wall"),
            means: "In the log of a controller: its table needs the reading, which did not come for a second, or not \
                    with the last detections.",
            help: "Start who publishes it, or look at its name.",
        },
        Cause {
            shown: contradictions::in_words(
                &robot(),
                ["/robot_3/detection", "/robot_3/detection/wall"].map(str::to_owned),
            ),
            means: "What the robot publishes is not what its profile says of its sensor.",
            help: "Publish the nearest thing alone, or give the profile two sensors.",
        },
    ]
}

fn of_objects() -> [Cause; 4] {
    let object = || "object_3".to_owned();
    let missing =
        Problem::NoPublisher { topic: "/objects/object_3/pose".to_owned(), nearest: None };
    let (found, expected) = ("lab".to_owned(), "map".to_owned());
    [
        Cause {
            shown: missing.to_string(),
            means: "Nobody publishes where an object is that the world of the run has.",
            help: "Have the tracker publish it, or start with another world's file.",
        },
        Cause {
            shown: Finding::LostObject { object: object(), time_s: 12.0 }.to_string(),
            means: "The tracker did not see it for a while; `rsrs label` says so, and no behaviour over objects is \
                    judged.",
            help: "Look at the markers of the object, and at who covers them.",
        },
        Cause {
            shown: Finding::ObjectFrame { object: object(), found, expected }.to_string(),
            means: "Robots and objects are tracked in two frames.",
            help: "Publish both in one.",
        },
        Cause {
            shown: Finding::ObjectJump { object: object(), by_m: 0.8, in_s: 0.1, time_s: 12.0 }
                .to_string(),
            means: "Its poses cannot be those of one object that robots push.",
            help: "As the message asks; define the bodies of objects that are alike by different markers.",
        },
    ]
}

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
    let cause = |error: BagError, means, help| Cause { shown: error.to_string(), means, help };
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
