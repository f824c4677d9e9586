//! Bags that other tools have converted: they keep messages, and neither attachments nor metadata.

use std::path::{Path, PathBuf};
use std::process::Command;

use rsrs_bags::{Bag, BagOptions, BagWriter, Sample};
use rsrs_fleet::record::{ATTACHMENT, ENDING};
use rsrs_msgs::topics;
use serde_json::Value;

use super::{episode, place};
use crate::cells::CELLS;
use crate::command::{code, json, rsrs, stderr};
use rsrs_testing::python::{BAGS, must_run, python_with};

use rsrs_testing::conditions::FLOCKBOT;

/// One episode of each cell.
fn recorded(here: &Path) -> Vec<String> {
    let names = (0..CELLS.len()).map(|cell| {
        let name = format!("cell_{cell}");
        let record = episode(CELLS[cell], 0);
        rsrs_pipeline::episode::write(&here.join(&name), &record).expect("the disk has room");
        name
    });
    names.collect()
}

/// A copy that has the messages of a bag alone, without these topics.
fn stripped(from: &Path, name: &str, without: &[&str]) -> PathBuf {
    let original = Bag::open(from).expect("it is a bag");
    let path = from.with_file_name(name);
    let mut writer = BagWriter::create(&path, BagOptions::default()).expect("it is new");
    let mut channels = Vec::new();
    for topic in original.topics().into_iter().filter(|topic| !without.contains(&&*topic.name)) {
        let qos = topics::CMD_VEL.qos;
        let channel = writer.add_topic(&topic.name, &topic.type_name, qos).expect("it is new");
        channels.push((topic.name, channel));
    }
    for message in original.messages() {
        let message = message.expect("the bag is whole");
        let Some((_, channel)) = channels.iter().find(|(name, _)| **name == *message.topic) else {
            continue;
        };
        let (log_time_ns, data) = (message.log_time_ns, &message.bytes);
        let sample = Sample { log_time_ns, publish_time_ns: log_time_ns, sequence: 0, data };
        writer.write(*channel, sample).expect("the disk has room");
    }
    writer.finish().expect("the disk has room");
    path
}

/// The label of one bag, without its name.
fn label(here: &Path, bag: &str, more: &[&str]) -> Value {
    let labels = rsrs(here, &[&["label", bag, "--format", "json"], more].concat());
    assert_eq!(code(&labels), 0, "{bag}: {}", stderr(&labels));
    let mut label = json(&labels)[0].take();
    label.as_object_mut().expect("a label is an object").remove("bag");
    label
}

#[test]
fn a_bag_that_was_converted_has_the_label_of_the_original() {
    let python = python_with(&BAGS);
    let convert = python.with_file_name("rosbags-convert");
    let place = place();
    let here = place.path();
    let mut phases = Vec::new();

    for name in recorded(here) {
        let converted = format!("{name}_converted");
        let mut command = Command::new(&convert);
        command.current_dir(here).args(["--src", &name, "--dst", &converted]);
        must_run(command.args(["--dst-storage", "mcap"]));
        let bag = Bag::open(&here.join(&converted)).expect("it is a bag");
        assert!(bag.attachment(ATTACHMENT).is_none() && bag.metadata(ENDING).is_none());

        let original = label(here, &name, &[]);

        assert_eq!(label(here, &converted, &[]), original, "{name}");
        let info = json(&rsrs(here, &["bag", "info", &converted, "--format", "json"]));
        assert_eq!((&info["run_id"], &info["ending"]), (&"episode_0".into(), &"completed".into()));
        assert_eq!(info["has_experiment"], true);
        phases.push(original["phase"].clone());
    }

    phases.sort_by_key(Value::to_string);
    phases.dedup();
    assert!(phases.len() >= 2, "the cells should differ, found only {phases:?}");
}

#[test]
fn a_bag_without_record_and_messages_of_it_is_labelled_by_the_profile_and_by_no_guess() {
    let place = place();
    let here = place.path();
    std::fs::write(here.join("flockbot.yaml"), FLOCKBOT).expect("the folder is writable");
    let notes = [topics::EXPERIMENT.name, topics::ENDING.name];

    for name in recorded(here) {
        let bare = format!("{name}_bare");
        stripped(&here.join(&name), &bare, &notes);
        let (original, refused) = (label(here, &name, &[]), rsrs(here, &["label", &bare]));

        let phase = |label: &Value| (label["phase"].clone(), label["evidence"]["lost"].clone());
        let by_profile = label(here, &bare, &["--profile", "flockbot.yaml"]);
        // Bodies of 7.5 cm are seen up to 0.75 m away.
        let by_reach = label(here, &bare, &["--reach", "0.825"]);

        assert_eq!(code(&refused), 1);
        let printed = stderr(&refused);
        let start = format!(
            "error: {bare}: holds no record of its experiment; the robots' reach is not known, and \
             decides: dispersion below "
        );
        assert!(printed.starts_with(&start), "{printed}");
        assert!(printed.contains(&format!("`rsrs label {bare} --profile PROFILE`")), "{printed}");
        assert!(printed.contains("`--reach M`"), "{printed}");
        assert_eq!(phase(&by_profile), phase(&original), "{name}");
        assert_eq!(phase(&by_reach), phase(&original), "{name}");
        // It holds for each reach what is reported of it.
        let (least_m, then) = last_step(&printed);
        let title = |reach_m: f64| {
            label(here, &bare, &["--reach", &reach_m.to_string()])["phase"]
                .as_str()
                .map(|key| key.replace('_', " ").replacen("semi ", "semi-", 1))
                .expect("a phase is a text")
        };
        assert_eq!(title(least_m + 0.02), then, "{printed}");
        assert_ne!(title(least_m - 0.02), then, "{printed}");
    }
}

/// The last reach that an error names, in metres, and the phase from there on.
fn last_step(printed: &str) -> (f64, String) {
    let line = printed.lines().next().expect("it prints something");
    let step = line.rsplit(", ").next().expect("there is a last part");
    let (phase, reach) = step.split_once(" from ").expect("another phase from some reach on");
    let reach = reach.strip_suffix(" m on").expect("in metres");
    (reach.parse().expect("a number"), phase.to_owned())
}
