//! Everything that can go wrong in a run: what is shown, what it means, and what to do about it.
//!
//! The page of the book is made of it. Each enumeration has its table here, and a variant without a row
//! does not compile.

use std::fmt::Write as _;

use rsrs_core::judge::plausibility::{FloorAxis, Implausibility as Motion};

use crate::epoch;
use crate::message::RobotState;
use crate::parameters::{Deviation, Value, gate};
use crate::placement;
use crate::preflight::{ClockLead, DiagnosticError, Problem, UnfitTopic};
use crate::robot::{StandReason, WORLD_REPLACED};
use crate::runner::{self, AbortCause, Failure, LossCause, SampleKind, Target};
use crate::simulator::VoidCause;

/// One thing that can go wrong.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Cause {
    /// What is shown; names and numbers stand for any.
    pub shown: String,
    /// What it means.
    pub means: &'static str,
    /// What to do about it.
    pub help: &'static str,
}

/// Causes that belong together.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Chapter {
    /// Its heading.
    pub title: &'static str,
    /// What they have in common, and what follows from any of them.
    pub about: &'static str,
    /// The causes.
    pub causes: Vec<Cause>,
}

/// The causes that are variants of an enumeration, each by an example: its fields in braces, what it means
/// and what to do. A variant without a row does not compile.
#[macro_export]
macro_rules! causes {
    ($all:ident { $($variant:ident $example:tt: $means:literal, $help:literal;)* }) => {{
        // A variant without a row does not compile.
        let _is_listed = |of: &$all| match of {
            $($all::$variant { .. } => {})*
        };
        vec![$($crate::causes::Cause {
            shown: $all::$variant $example.to_string(),
            means: $means,
            help: $help,
        }),*]
    }};
}

/// A robot that stands for any.
fn robot() -> String {
    "robot_3".to_owned()
}

fn text(text: &str) -> String {
    text.to_owned()
}

/// All causes that the machines of the protocol name, in the order in which a person meets them.
pub fn chapters() -> Vec<Chapter> {
    vec![
        Chapter {
            title: "Before a run",
            about: "Everything that is wrong is named at once, nothing moves, and the run is `failed`. \
                    Robots with the same problem share one line.",
            causes: problems(),
        },
        Chapter {
            title: "While a run is prepared",
            about: "The robots were found, but a later step failed; the run is `failed`. Nothing moves, \
                    unless a first sample never came: the robots have then moved for 5 s.",
            causes: failures(),
        },
        Chapter {
            title: "Runs that are stopped",
            about: "All robots are stopped, the bag is closed, and the run is `aborted`.",
            causes: aborts(),
        },
        Chapter {
            title: "Robots that are lost",
            about: "These stand behind `lost robot_3:`. The robot is left out of the leases, so that it stands; \
                    the experiment's `robot_lost` decides whether the run goes on. At the end of a run, `not \
                    confirmed to stand, go and look` names robots that did not report that they stand: go there.",
            causes: losses(),
        },
        Chapter {
            title: "Poses and motions that cannot be",
            about: "These are noted in a run, from its third second on, and stand in the label of its bag; \
                    `compare` leaves such a run out unless told otherwise \
                    ([Poses that cannot be those of the robots](reading_results.md#poses-that-cannot-be-those-of-the-robots)).",
            causes: motions(),
        },
        Chapter {
            title: "Runs that are void",
            about: "A simulated world in lockstep waits for everybody, so anything that is lost stops it. The \
                    run is `void`: it says nothing about the robots, and campaigns run it again. A robot that \
                    is lost in lockstep ends the run in the same way.",
            causes: voids(),
        },
        Chapter {
            title: "Why a robot stands",
            about: "A robot reports these itself: in its status, in `rsrs watch`, and behind \
                    `lost …: stopped in epoch …` or `did not arm: …`.",
            causes: stands(),
        },
    ]
}

fn problems() -> Vec<Cause> {
    let topic = || text("/robot_3/detection");
    let twist = || text("geometry_msgs/msg/Twist");
    let stamped = || text("geometry_msgs/msg/TwistStamped");
    let lead = || ClockLead { ahead_s: -61.5, change_s: Some(-3.0) };
    let deviation = || Deviation {
        parameter: text(gate::DETECTION_THRESHOLD),
        found: Value::Double(0.6),
        expected: Value::Double(0.75),
    };
    causes!(Problem {
        RobotMissing { robot: robot() }: "The node of the robot does not run, runs in another namespace, or is not in this network and domain.", "Start it; `ros2 topic list` shows the names that there are. See also [Programs do not find each other](troubleshooting.md#programs-do-not-find-each-other).";
        LeaseNotHeld { robot: robot() }: "The fleet file has `lease: controller`, but its controller was started without it.", "As the message says, or leave the key out if the robot has a gate.";
        ControllerMissing { robot: robot() }: "No controller for this robot runs.", "`rsrs node controller --robots …`; `rsrs node robot` brings its own.";
        SimulatorMissing {}: "Virtual robots without a simulator.", "[A fleet without robots](fleet_without_robots.md).";
        WrongType { topic: text("/robot_3/cmd_vel"), nodes: vec![text("/robot_3/controller")], found: twist(), expected: stamped(), taken: [stamped()].into() }: "Somebody publishes the topic as another type; nobody who expects the right one receives it.", "Set the type on one of the two sides, as the message says.";
        WrongSubscriber { topic: text("/robot_3/cmd_vel"), node: text("/robot_3/base"), found: twist(), expected: stamped() }: "A node of the robot waits for another type, and receives nothing.", "Set the type on one of the two sides, as the message says.";
        Unfit { 0: UnfitTopic { topic: text("/robot_3/cmd_vel"), reason: text("/robot_3/base subscribes transient local, and /robot_3/controller publishes volatile: set the durability of the subscription to volatile") } }: "The two ends of a topic that steers the robot do not fit each other, and are silent.", "Change the end that is named ([Quality of service](robot_drivers.md#quality-of-service)).";
        Unrecordable { topic: text("/robot_3/bumper"), reason: text("it is to be recorded, and it has no publisher") }: "The experiment names a topic to be recorded that cannot be.", "Start who publishes it, give the folder with its type in `record.definitions`, or leave it out of `record.topics`.";
        NoPublisher { topic: topic(), nearest: Some(text("/robot_3/detecton")) }: "Nobody publishes what the run needs.", "Start the node; look at names and namespaces with `ros2 topic list`.";
        StrangeObjects { topics: vec![text("/objects/box/pose")], n_objects: 9 }: "A tracker sees an object that the world of the run does not have, or calls one by another name.", "As the message says: `object_1` and so on are the names, in the order of [the world's file](worlds.md#the-file).";
        Renamed { topic: topic(), node: text("/robot_3/controller"), renamed: text("/camera/seen") }: "A node of the robot was started with `-r`, so that the run does not find its topic.", "Leave that rule out, and rename the topic of the other program instead.";
        SeveralPublishers { topic: topic(), found: 2 }: "Two programs publish what one should: two robots of one name, or a node that was started twice.", "End one of them; `ros2 topic info -v` names both.";
        OtherRunner { run_id: text("milling_20261124_101500_3f2a") }: "A second `rsrs run` or `rsrs campaign` has one of these robots, or was started before; runs of other robots go on beside it.", "Wait for its end, or end it.";
        Faulted { robot: robot(), reason: text("hardware fault: no state of the microcontroller for 500 ms") }: "The robot's driver reports that its hardware does not work.", "Repair what is named; it reports itself when it works again.";
        BatteryLow { robot: robot(), found_v: 6.25, expected_v: 6.6 }: "Its voltage is below `battery_min_v` of the fleet file.", "Charge it.";
        BatteryUnknown { robot: robot(), expected_v: 6.6 }: "The fleet file has `battery_min_v`, and the robot does not report its voltage.", "Have its driver report it, or leave the key out.";
        Clock { robot: robot(), lead: lead() }: "The robot's clock is being set, or runs unevenly, so recorded times cannot be aligned.", "`chronyc tracking` on the robot; wait until it is steady.";
        TooSlow { behind_s: 4.6 }: "The computer of the run does not keep up with what it receives; no robot is at fault.", "End other programs on it; record fewer topics.";
        Diagnostic { 0: DiagnosticError { robot: robot(), part: text("robot_3: serial driver"), message: text("no answer") } }: "The robot's own `/diagnostics` report an error.", "Repair the part that is named.";
        Setting { robot: robot(), deviation: deviation() }: "The gate of the robot was started with an older file, or another `-p`: it would be another experiment.", "Copy the files to the robot, and start its node again.";
        Locked { robots: vec![robot()] }: "The e-stop was pressed, its publisher has left, and the lock stays.", "When the floor is safe, `rsrs stop --release`.";
        EStop { by: vec![text("/button_box")] }: "The e-stop is pressed.", "Release the button, or end that program.";
        WithoutWorld { robot: robot() }: "A simulator stands in for the robot, and has placed no world.", "Set `driver: {kind: virtual}` in the fleet file, so that the run places the world.";
        Epoch { robot: robot(), refused: epoch::check(u64::MAX, 7).expect_err("no runner counts so far") }: "The robot has received an epoch that no runner counts to, and will obey no other.", "Start its node again, and look for who publishes on `/swarm/lease`.";
        PoseClock { robot: robot(), lead: lead() }: "The clock of whoever publishes the poses is being set, or runs unevenly.", "Set it by NTP, or stamp poses with a clock that runs evenly.";
        PoseUnusable { robot: robot(), reason: text("its orientation is no rotation") }: "The tracker gives positions only, or no numbers.", "Have it publish orientations.";
        OneSpot { robots: vec![text("robot_1"), robot()], radius_m: 0.08 }: "Each robot's odometry starts at 0, 0, which is no pose on the floor.", "Publish poses in one frame ([Poses](robot_drivers.md#poses)).";
        NobodyObeys { topic: text("/robot_3/cmd_vel") }: "No program subscribes to what drives the robot, so it would stand.", "Start its base.";
        Misplaced { 0: placement::Deviation::Outside { robot: robot(), found_m: 1.25, expected_m: 0.75 } }: "`--place-check require` was asked for, and a robot does not stand where it should start.", "`rsrs place` shows the places; put it there.";
        PlaceUnknown { robot: robot() }: "`--place-check require` was asked for, and where the robot stands is not known.", "Look at the tracker: `ros2 topic hz` on the topic of its poses.";
        PlacesInFrames { frames: text("robot_1 in `robot_1/odom`, robot_3 in `robot_3/odom`") }: "Places are in one frame, and each robot's poses are in one of its own.", "Publish the transforms between them, or poses in one frame.";
        Outside { robot: robot(), x_m: 2.75, y_m: -0.25 }: "A robot stands where it must not be.", "Put it back, or correct the rectangle.";
        FenceFrames { frames: vec![text("robot_1/odom"), text("robot_3/odom")] }: "Each robot's odometry has its own frame, so one rectangle cannot hold for all.", "As the message says.";
        Frames { frames: vec![(text("robot_1"), text("robot_1/odom")), (robot(), text("robot_3/odom"))] }: "Each robot has a frame of its own, and nothing ties them together.", "Publish the transforms between them, or poses in one frame.";
    })
}

fn failures() -> Vec<Cause> {
    causes!(Failure {
        Preflight { 0: Problem::RobotMissing { robot: robot() } }: "One of the causes above.", "See there.";
        NotSet { target: Target::Robot(robot()), reason: text("node `/robot_3/controller` refused: speed: 0.5 is not from -0.3 to 0.3") }: "A controller or the simulator refuses a value, or does not answer.", "The reason is in the message; often a limit of the profile.";
        NotConfirmed { target: Target::Robot(robot()), reason: text("digest 3f2a…, expected 91c4…") }: "What is read back is not what was set: another program changes it, or somebody else holds the lease than the fleet file states.", "End the other program; the message names what to start otherwise.";
        NotArmed { robot: robot(), found: text("fault in epoch 7 (hardware fault: wheel), expected armed in epoch 7") }: "The robot or its controller does not join the run.", "Look at its status and its log; [Why a robot stands](#why-a-robot-stands).";
        NoPose { robot: robot() }: "The tracker does not see the robot, or calls it by another name; a run without its poses cannot be judged.", "Look at the tracker; the fleet file has the names that it uses.";
        NoSample { robot: robot(), kind: SampleKind::Pose }: "The first sample never came, while the robots moved: the tracker does not see the robot, or its sensor does not work.", "`ros2 topic hz` on its topic before the next run.";
        Recorder { reason: text("nothing was written for 10 s, 120 MB left") }: "The bag does not have all of the run: [The bag](#the-bag) lists the reasons.", "The robots stand; `rsrs bag recover` saves what is in the folder that is named.";
    })
}

fn aborts() -> Vec<Cause> {
    let topic = || text("/robot_3/cmd_vel");
    causes!(AbortCause {
        EStop {}: "The e-stop was pressed, or its publisher fell silent.", "When the floor is safe, `rsrs stop --release` lets the next run start.";
        OtherRunner { run_id: text("milling_20261124_101500_3f2a") }: "A second run was started with the same robots.", "Start one after the other.";
        HigherEpoch { found: 8, expected: 7 }: "Another runner, which this one does not receive, has taken a robot.", "Look for a second `rsrs run`, also on other computers.";
        ArmedForAnother { run_id: text("milling_20261124_101500_3f2a") }: "Two runners that do not receive each other have started at once.", "Look for a second `rsrs run`, also on other computers.";
        LostRobots { by_reason: vec![text("robot_3: silent for more than 1 s")] }: "A robot is out of reach, stands, or gives no samples any more; the experiment's `robot_lost` ends the run then.", "The reason is in the message; [Why a robot stands](#why-a-robot-stands) and [Wi-Fi](troubleshooting.md#wi-fi).";
        LostAll {}: "No robot is left in the run.", "Look at the network of the computer of the run.";
        SecondPublisher { topic: topic(), node: text("/teleop") }: "Another program began to steer a robot, such as teleoperation.", "End that program before the next run.";
        UnnamedPublisher { topic: topic() }: "The same, by a program whose node is not announced, as in ROS 2 Humble.", "`ros2 topic info -v` on the topic.";
        Interrupted { reason: text("interrupted") }: "Ctrl-C or SIGTERM, or this program's network has ended, which is then the reason shown.", "Nothing after Ctrl-C; else start again.";
    })
}

fn losses() -> Vec<Cause> {
    let reason = || text("hardware fault: no state of the microcontroller for 500 ms");
    causes!(LossCause {
        Silent {}: "No status of the robot or its controller: its process, its computer or the network.", "[Wi-Fi](troubleshooting.md#wi-fi); look at the load of the robot's computer.";
        NotMoving { state: RobotState::Fault, epoch: 7, reason: reason() }: "It stands for the reason that is shown.", "[Why a robot stands](#why-a-robot-stands).";
        NoSample { kind: SampleKind::Pose, silence_s: 5 }: "The tracker does not see it any more, or its sensor is silent, while its node runs on.", "Look at the tracker's volume and markers, or at the sensor.";
        LeftGeofence { x_m: 2.75, y_m: -0.25 }: "It was outside of the fleet file's rectangle.", "Put it back; a run that many robots leave needs a larger floor.";
        StoodTooLong { stood_s: 3.4 }: "Its link fails again and again; each time it stood, and went on.", "[Wi-Fi](troubleshooting.md#wi-fi): the channel, power saving, the access point.";
    })
}

fn motions() -> Vec<Cause> {
    causes!(Motion {
        Scale { factor: 1000.0 }: "The tracker's unit is another one.", "Set `scale` in the fleet file's `tracker`.";
        Line { axis: FloorAxis::X }: "Two of its axes are not those of the floor.", "Set `axes` in the fleet file's `tracker`.";
        HeadingStands {}: "Its orientations do not turn with the robots.", "Have it track rigid bodies, not points.";
        Mirrored {}: "Places and headings are mirrored against the commands.", "Look at `axes`, and at how the motors are connected.";
        HeadingMirrored {}: "Either places or headings are mirrored, not both.", "Look at how the tracker's orientations are turned into headings.";
        Degrees { factor: 57.3 }: "Angles are in another unit.", "Have the tracker publish quaternions.";
        HeadingUnrelated {}: "Orientations are not those of the bodies that move.", "Define the rigid bodies anew.";
        Askew { by_deg: 90.0 }: "A body is turned in the tracker.", "Define it with its front along x.";
        Swapped {}: "Two bodies have each other's names.", "Exchange their names, in the tracker or by `body` in the fleet file.";
        Stands { time_s: 10.0, for_s: 9.0, speed_m_s: 0.15, turn_rate_rad_s: 0.0, moved_m: 0.0 }: "Its base does not obey: a battery, a hardware e-stop, commands beyond its limits. Time within touch of another robot is not counted.", "Look at the base; the robot's `/rosout` names commands that are refused.";
    })
}

fn voids() -> Vec<Cause> {
    let owed = || text("no command from robot_3");
    let mut causes = causes!(VoidCause {
        Frozen { step: 17, steps: 2307 }: "A robot stands: its node or its controller has ended, or the computer is so busy that leases run out.", "Look at the load of the computer, and at the log of the robot's node.";
        Stalled { step: 17, steps: 2307, owed: owed() }: "A message that the next step needs was lost, or was refused for the reason that is shown.", "Run it again; if it comes back, look at the log of the controller that is named.";
    });
    causes.push(Cause {
        shown: runner::world_replaced(),
        means: "Whatever its pace: somebody set the simulator's parameters, reset it or moved its robots by hand, \
                before they were armed, or in a countdown or a pause.",
        help: "Run it again; look for a second runner.",
    });
    causes
}

fn stands() -> Vec<Cause> {
    let mut causes = causes!(StandReason {
        Idle {}: "No run has it.", "Nothing, before a run.";
        Asking {}: "Its node has just started, and takes over what the e-stop has locked.", "Wait for 2 s.";
        WithoutWorld {}: "A simulated robot without a world.", "Let a run set its conditions, or set `cell` by hand.";
        Armed {}: "The countdown is running.", "Wait, or Ctrl-C.";
        LeaseLapsed {}: "No lease reached it in time: bad Wi-Fi, a runner that was stopped, or a computer on either side that is very busy.", "[Wi-Fi](troubleshooting.md#wi-fi); look at the load of both computers.";
        ControllerUnconfirmed {}: "Its controller has ended, or somebody has changed its parameters in the run.", "Look at the controller's log.";
        EStop {}: "The e-stop is pressed, or its publisher fell silent in the run.", "When the floor is safe, `rsrs stop --release`.";
        Latched { 0: text("stopped by the runner") }: "It stands until the next run arms it.", "Nothing.";
        Fault { 0: text("no valid reading of the sensor for more than 500 ms, from /robot_3/hardware/range") }: "Its sensor or its wheels do not work.", "Repair what is named.";
    });
    causes.push(Cause {
        shown: WORLD_REPLACED.to_owned(),
        means: "Somebody set the simulator's parameters, or reset it, while the run was paused.",
        help: "Run it again; look for a second runner.",
    });
    causes
}

/// The page of the book, as Markdown, with more chapters on what the protocol does not know, such
/// as the bag.
pub fn page(more: &[Chapter]) -> String {
    let mut page = text(
        "# What can go wrong in a run\n\n\
         This page is what `rsrs schema --causes` prints: every cause that the program knows. Names and \
         numbers are examples.\n\
         [Troubleshooting](troubleshooting.md) has what goes beyond a single message.\n",
    );
    for Chapter { title, about, causes } in chapters().iter().chain(more) {
        write!(page, "\n## {title}\n\n{about}\n\n| shown | means | do |\n|---|---|---|\n")
            .expect("a string takes any text");
        for Cause { shown, means, help } in causes {
            let shown = in_cell(shown);
            writeln!(page, "| {shown} | {means} | {help} |").expect("a string takes any text");
        }
    }
    page
}

/// A message as code in a cell of a table.
fn in_cell(message: &str) -> String {
    let message = message.replace('|', "\\|").replace('\n', " ");
    // A message that has code in it needs two signs around it.
    if message.contains('`') { format!("`` {message} ``") } else { format!("`{message}`") }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn no_two_causes_of_a_chapter_are_shown_alike_and_each_has_something_to_do() {
        for chapter in chapters() {
            let mut shown = BTreeSet::new();
            for cause in &chapter.causes {
                assert!(shown.insert(cause.shown.clone()), "{}", cause.shown);
                assert!(cause.means.ends_with('.'), "{}", cause.means);
                assert!(cause.help.ends_with('.'), "{}", cause.help);
            }
        }
    }

    #[test]
    fn a_message_with_code_in_it_stays_one_cell() {
        assert_eq!(in_cell("`a` | b"), "`` `a` \\| b ``");
        assert_eq!(in_cell("a"), "`a`");
    }
}
