//! What is reported of bags that are not what they should be, by every command that takes bags.

use std::fs;
use std::path::Path;

use rsrs_bags::{Bag, BagMessage, BagOptions, BagWriter, Sample};
use rsrs_fleet::record::{ATTACHMENT, ENDING};
use rsrs_msgs::builtin_interfaces::Time;
use rsrs_msgs::nav_msgs::Odometry;
use rsrs_msgs::rsrs::RunLease;
use rsrs_msgs::{cdr, topics};

use super::place;
use crate::command::{code, json, rsrs, stderr, stdout};
use crate::prepared_sweeps::{SPEEDS, swept};
use crate::simulated_bags::Run;

const ODOM: &str = "/robot_1/odom";

/// Copies a bag with other messages, as long as the recorder is left to live.
pub fn copied(
    from: &Path,
    name: &str,
    change: impl Fn(BagMessage) -> Vec<BagMessage>,
) -> BagWriter {
    let original = Bag::open(from).expect("it is a bag");
    let path = from.with_file_name(name);
    let mut writer = BagWriter::create(&path, BagOptions::default()).expect("it is new");
    let record = original.attachment(ATTACHMENT).expect("it has a record");
    writer.attach(ATTACHMENT, &record.media_type, &record.data).expect("the disk has room");
    let mut channels = Vec::new();
    for topic in original.topics() {
        let qos = topics::CMD_VEL.qos;
        let channel = writer.add_topic(&topic.name, &topic.type_name, qos).expect("it is new");
        channels.push((topic.name, channel));
    }
    for message in original.messages() {
        for message in change(message.expect("the bag is whole")) {
            let channel = channels.iter().find(|(name, _)| **name == *message.topic);
            let (_, channel) = channel.expect("every topic was added");
            let (log_time_ns, data) = (message.log_time_ns, &message.bytes);
            let sample = Sample { log_time_ns, publish_time_ns: log_time_ns, sequence: 0, data };
            writer.write(*channel, sample).expect("the disk has room");
        }
    }
    let ending = original.metadata(ENDING).expect("it was recorded").clone();
    writer.metadata(ENDING, ending).expect("the disk has room");
    writer
}

/// A bag with other poses of the first robot after half a minute.
fn spoilt(from: &Path, name: &str, spoil: impl Fn(&mut Odometry)) {
    let writer = copied(from, name, |mut message| {
        if *message.topic == *ODOM && message.log_time_ns > 30_000_000_000 {
            let mut odometry: Odometry = cdr::decode(&message.bytes).expect("it is one");
            spoil(&mut odometry);
            message.bytes = cdr::encode(&odometry);
        }
        vec![message]
    });
    writer.finish().expect("the disk has room");
}

/// All sorts of bags, in a folder that may have a sweep in it.
fn lab_folder(place: tempfile::TempDir) -> (tempfile::TempDir, BagWriter) {
    let here = place.path();
    let good = Run::new(1).record(here, "good");
    write(here, "notes.mcap", "these are notes\n");
    fs::create_dir(here.join("hollow")).expect("it is writable");
    write(here, "zero/zero_0.mcap", "");
    write(here, "old/old_0.db3", "SQLite format 3\0");
    copied(&good, "silent", |_| Vec::new()).finish().expect("the disk has room");
    spoilt(&good, "nan", |odometry| odometry.pose.pose.position.x = f64::NAN);
    spoilt(&good, "backwards", |odometry| {
        let stamp_ns = odometry.header.stamp.to_nanos().expect("it is after 1970");
        odometry.header.stamp = Time::from_nanos(stamp_ns - 5_000_000_000);
    });
    let twins = copied(&good, "twins", |message| {
        if *message.topic != *ODOM {
            return vec![message];
        }
        let mut twin: Odometry = cdr::decode(&message.bytes).expect("it is one");
        twin.pose.pose.position.x += 1.0;
        vec![BagMessage { bytes: cdr::encode(&twin), ..message.clone() }, message]
    });
    twins.finish().expect("the disk has room");
    let short = copied(&good, "short", |mut message| {
        if *message.topic == *ODOM {
            message.bytes.truncate(40);
        }
        vec![message]
    });
    short.finish().expect("the disk has room");
    // Its lease names robots that nobody has seen.
    let strangers = copied(&good, "strangers", |mut message| {
        if *message.topic == *topics::LEASE.name {
            let mut lease: RunLease = cdr::decode(&message.bytes).expect("it is one");
            lease.robots = vec!["robot_1".to_owned(), "rover_7".to_owned()];
            message.bytes = cdr::encode(&lease);
        }
        vec![message]
    });
    strangers.finish().expect("the disk has room");
    Run { robots: 5, ..Run::new(3) }.record(here, "five");
    Run::new(4).record(here, "edited");
    write(here, "edited/labels.yaml", "- phase: milling\n");
    Run::new(4).record(here, "yaml");
    write(here, "yaml/metadata.yaml", "rosbag2_bagfile_information: [\n");
    // Its recorder lives.
    let writing = copied(&good, "writing", |message| vec![message]);
    (place, writing)
}

fn write(folder: &Path, name: &str, text: &str) {
    let path = folder.join(name);
    fs::create_dir_all(path.parent().expect("it is in a folder")).expect("it is writable");
    fs::write(path, text).expect("it is writable");
}

/// A bag with what is reported of it.
struct Case {
    bag: &'static str,
    /// Why it is no bag at all, for every command.
    unreadable: Option<&'static str>,
    /// Why the judge has no verdict on it.
    unjudged: Option<&'static str>,
    /// Why it is not held against the sweep.
    not_compared: Option<&'static str>,
    /// What to do about it.
    help: &'static str,
}

const READABLE: Case =
    Case { bag: "", unreadable: None, unjudged: None, not_compared: None, help: "" };

const CASES: [Case; 11] = [
    Case {
        bag: "notes.mcap",
        unreadable: Some("notes.mcap is not an MCAP file"),
        help: "give a bag of ROS 2: a folder as `ros2 bag record --storage mcap` makes it",
        ..READABLE
    },
    Case {
        bag: "gone",
        unreadable: Some("cannot open gone"),
        help: "give the folder that holds metadata.yaml, or the .mcap file itself",
        ..READABLE
    },
    Case {
        bag: "hollow",
        unreadable: Some("hollow holds no .mcap file"),
        help: "give the folder that holds metadata.yaml, or the .mcap file itself",
        ..READABLE
    },
    Case {
        bag: "zero",
        unreadable: Some("zero/zero_0.mcap is empty"),
        help: "nothing was recorded: the recorder ended before it wrote anything, or has just begun",
        ..READABLE
    },
    Case {
        bag: "old",
        unreadable: Some("old is in SQLite format, expected MCAP"),
        help: "convert it: `echo 'output_bags: ",
        ..READABLE
    },
    Case {
        bag: "silent",
        unjudged: Some("silent: the bag has no messages; topics in it: 19"),
        help: "record it again: the recorder must run in the network of the robots",
        ..READABLE
    },
    Case {
        bag: "nan",
        unjudged: Some("nan: pose of robot robot_1 at 30.030 s is not a number"),
        help: "take another source of poses with `--poses`, or judge the run by eye instead: `rsrs ",
        ..READABLE
    },
    Case {
        bag: "backwards",
        unjudged: Some("backwards: the stamps of robot robot_1 go back by 4.870 s at 29.900 s"),
        help: "a clock was set during the run: keep clocks with chrony",
        ..READABLE
    },
    Case {
        bag: "twins",
        unjudged: Some(
            "twins: robot robot_1 has poses 0.0000 s apart at 0.000 s, expected about 0.1300 s: two \
             publishers on one topic?",
        ),
        help: "give every robot a name of its own, and one source of poses",
        ..READABLE
    },
    Case {
        bag: "strangers",
        unjudged: Some("strangers: robots of the run without poses: rover_7"),
        help: "record the poses of every robot, or take another source with `--poses`",
        ..READABLE
    },
    Case {
        bag: "five",
        not_compared: Some("five: the number of robots is 5, expected 9 as simulated"),
        help: "leave such bags out, or compare them with the sweep that simulates their experiment",
        ..READABLE
    },
];

/// Refuses in its own words, with one line on what to do, and nothing else.
fn assert_refuses(here: &Path, arguments: &[&str], reason: &str, help: &str) {
    let output = rsrs(here, arguments);
    let (printed, what) = (stderr(&output), arguments.join(" "));
    assert_eq!(code(&output), 1, "{what}: {printed}");
    assert_eq!(stdout(&output), "", "{what}");
    assert!(printed.starts_with("error: "), "{what}: {printed}");
    assert!(printed.contains(reason), "{what}: {printed}");
    assert_eq!(printed.matches(reason).count(), 1, "{what} reports it once: {printed}");
    let last = printed.lines().last().unwrap_or_default();
    assert!(last.starts_with(&format!("help: {help}")), "{what}: {printed}");
}

/// `compare` lists a run that it cannot judge, with the reason and what to do, and says so by its exit
/// code: one bag of many must not keep the others from being compared.
fn assert_lists(here: &Path, bag: &str, reason: &str, help: &str) {
    let output = rsrs(here, &["compare", "out", "--bags", bag]);
    let (printed, reason) = (stdout(&output), reason.trim_start_matches(&format!("{bag}: ")));
    assert_eq!(code(&output), 3, "{bag}: {}", stderr(&output));
    let line = printed.lines().find(|line| line.starts_with(&format!("not counted: {bag} (")));
    let line = line.unwrap_or_else(|| panic!("{bag} is not listed: {printed}"));
    assert!(line.contains(reason) && line.contains(help), "{line}");
    assert!(printed.contains("(no run counts)"), "{printed}");
}

#[test]
fn every_command_reports_what_is_wrong_with_a_bag_and_what_to_do_about_it() {
    let (place, _writing) = lab_folder(swept(SPEEDS, "true_positive: 0.8"));
    let here = place.path();
    let label = rsrs(here, &["label", "good", "--format", "json"]);
    write(here, "label.json", &stdout(&label));
    for Case { bag, unreadable, unjudged, not_compared, help } in CASES {
        let into = format!("{}_saved", bag.trim_end_matches(".mcap"));
        let info = ["bag", "info", bag];
        let recover = ["bag", "recover", bag, "-o", &into];
        let compare = ["compare", "out", "--bags", bag];
        let judged = [&["label", bag][..], &["replay", bag, "--into", "judge"]];
        let fed = ["replay", bag, "--into", "controller"];

        if let Some(reason) = unreadable {
            for arguments in [&info[..], &recover, &compare, &fed, judged[0], judged[1]] {
                assert_refuses(here, arguments, reason, help);
            }
            assert!(!here.join(&into).exists(), "{bag}: nothing half-made is left");
            continue;
        }
        // It is a bag, whatever is in it: it can be looked at and copied.
        for arguments in [&info[..], &recover] {
            assert_eq!(code(&rsrs(here, arguments)), 0, "{arguments:?}");
        }
        if let Some(reason) = unjudged {
            for arguments in judged {
                assert_refuses(here, arguments, reason, help);
            }
            assert_lists(here, bag, reason, help);
        }
        if let Some(reason) = not_compared {
            assert_refuses(here, &compare, reason, help);
            let of_others = "label.json is of 9 robots, and five has 5";
            assert_refuses(here, judged[1], of_others, "name its own one with `--recorded FILE`");
        }
        let controller = "no robot has both detections and commands";
        assert_refuses(here, &fed, controller, "record /<robot>/detection and /<robot>/cmd_vel");
    }
}

#[test]
fn what_a_message_is_not_is_reported_with_where_it_is() {
    let (place, _writing) = lab_folder(place());
    let here = place.path();

    let printed = stderr(&rsrs(here, &["label", "short"]));

    assert_eq!(
        printed,
        "error: short: a message on /robot_1/odom at 0.000 s of log time does not decode\n  because \
         nav_msgs/msg/Odometry does not decode from a body of 36 bytes\n  because unexpected end of \
         input\nhelp: what was recorded is not of its type: look which program published it\n"
    );
}

#[test]
fn a_table_of_contents_that_makes_no_sense_is_named_by_line_and_written_anew() {
    let (place, _writing) = lab_folder(swept(SPEEDS, "true_positive: 0.8"));
    let here = place.path();
    let help = "mend it or move it away: bags are read without it, too";

    for arguments in
        [&["label", "yaml"][..], &["bag", "info", "yaml"], &["compare", "out", "--bags", "yaml"]]
    {
        assert_refuses(
            here,
            arguments,
            "yaml/metadata.yaml:1:30: expected keys with their values here, as `{key: value}`",
            help,
        );
    }
    let recover = rsrs(here, &["bag", "recover", "yaml"]);
    let label = rsrs(here, &["label", "yaml_recovered"]);

    assert_eq!((code(&recover), code(&label)), (0, 0), "{}", stderr(&label));
}

#[test]
fn labels_that_were_spoilt_by_hand_stop_every_command_before_it_writes() {
    let (place, _writing) = lab_folder(swept(SPEEDS, "true_positive: 0.8"));
    let here = place.path();
    let spoilt = fs::read(here.join("edited/labels.yaml")).expect("it was written");

    for arguments in [
        &["label", "edited"][..],
        &["label", "edited", "--as", "dispersion", "--by", "ana"],
        &["label", "edited", "--agreement"],
        &["bag", "info", "edited"],
        &["bag", "recover", "edited"],
    ] {
        let reason = "edited/labels.yaml:1:10: unknown phase `milling`";
        assert_refuses(here, arguments, reason, "the phases are: stable_milling, ");
    }
    assert_lists(here, "edited", "labels.yaml:1:10: unknown phase `milling`", "the phases are: ");

    assert!(!here.join("edited_recovered").exists());
    assert_eq!(fs::read(here.join("edited/labels.yaml")).expect("it is there"), spoilt);
}

#[test]
fn a_bag_that_is_still_written_is_not_taken_for_a_whole_one() {
    let (place, writing) = lab_folder(swept(SPEEDS, "true_positive: 0.8"));
    let here = place.path();
    let so_far = "the recording breaks off after ";
    let doubt = " (or goes on: the file has just grown)";

    let label = rsrs(here, &["label", "writing"]);
    let info = rsrs(here, &["bag", "info", "writing"]);
    let recover = rsrs(here, &["bag", "recover", "writing"]);
    assert_lists(here, "writing", so_far, "saves what can be saved");
    writing.finish().expect("the disk has room");
    let whole = rsrs(here, &["label", "writing", "--format", "json"]);

    assert_eq!((code(&label), code(&info), code(&recover), code(&whole)), (1, 3, 3, 0));
    let printed = stderr(&label);
    let damage = printed.lines().next().unwrap_or_default().trim_start_matches("error: writing: ");
    assert!(damage.starts_with(so_far) && damage.ends_with(doubt), "{printed}");
    let info = stdout(&info);
    assert!(
        info.contains(&format!("damage: {damage}\nnext: rsrs bag recover writing\n")),
        "{info}"
    );
    assert!(info.contains("no metadata.yaml; zstd; without index"), "{info}");
    assert!(json(&whole)[0].get("damage").is_none(), "{}", stdout(&whole));
}

#[test]
fn an_empty_bag_is_reported_as_one_in_which_nothing_was_recorded() {
    let (place, _writing) = lab_folder(place());
    let here = place.path();

    let text = stdout(&rsrs(here, &["bag", "info", "silent"]));
    let info = json(&rsrs(here, &["bag", "info", "silent", "--format", "json"]));

    assert!(text.starts_with("silent: 0.0 s, 0 messages on 19 topics, "), "{text}");
    assert!(text.contains("\ndamage: none, but nothing was recorded\n"), "{text}");
    assert_eq!(
        (&info["n_messages"], &info["start_ns"]),
        (&serde_json::json!(0), &serde_json::json!(null))
    );
}
