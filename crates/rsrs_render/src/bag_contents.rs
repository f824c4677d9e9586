//! What is in a bag.

use std::collections::BTreeMap;
use std::fmt::Write;

use rsrs_bags::{Bag, BagInfo, OfferedQos};
use rsrs_core::judge::behaviour::Behaviour;
use rsrs_core::numerals::{count, counted, size};
use rsrs_core::printable::one_line;
use rsrs_core::robot::controller::Controller;
use rsrs_files::quoted;
use rsrs_fleet::record::{Backend, Ending, ExperimentRecord, LostRobot, OwnProfile, PausedRobot};
use rsrs_pipeline::label::human_labels::HumanLabel;
use rsrs_pipeline::recorded_run::{BrokenRecording, LossyRecovery};
use serde::Serialize;

use crate::columns::columns;
use crate::label::human;
use crate::wording::moment;

/// What is in a bag, with the record of its run and labels by people.
#[derive(Serialize)]
pub struct BagContents {
    #[serde(flatten)]
    info: BagInfo,
    /// Names the run; `None` in a bag that no runner of ours has made.
    run_id: Option<String>,
    /// Robots of the run.
    n_robots: Option<usize>,
    /// What moved the robots.
    backend: Option<Backend>,
    /// What decided on the robots' commands.
    controller: Option<Controller>,
    /// What the swarm was to be judged for.
    behaviour: Option<Behaviour>,
    /// How the run ended; `None` if the recorder was killed before its end.
    ending: Option<&'static str>,
    /// Why, if it was not completed.
    reason: Option<String>,
    /// Robots with a profile of their own, and in what it differs from the fleet's.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    own_profiles: BTreeMap<String, OwnProfile>,
    /// Robots that did not take part to the end.
    lost_robots: Vec<LostRobot>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    paused_robots: Vec<PausedRobot>,
    /// What people labelled the bag.
    labels: Vec<HumanLabel>,
    #[serde(skip)]
    record: Option<ExperimentRecord>,
    /// What it lacks, if it was recovered from a damaged bag.
    #[serde(skip)]
    lossy: Option<LossyRecovery>,
    /// Where its recording breaks off or is damaged.
    #[serde(skip)]
    broken: Option<BrokenRecording>,
}

impl BagContents {
    /// What is in a bag, damaged or not.
    pub fn new(
        bag: &Bag,
        record: Option<ExperimentRecord>,
        ending: Option<Ending>,
        labels: Vec<HumanLabel>,
    ) -> Self {
        Self {
            info: bag.info(),
            run_id: record.as_ref().map(|record| record.run_id.clone()),
            n_robots: record.as_ref().map(|record| record.robots.len()),
            backend: record.as_ref().map(|record| record.backend),
            controller: record.as_ref().map(|record| record.conditions.controller.clone()),
            behaviour: record.as_ref().map(|record| record.conditions.behaviour),
            own_profiles: record.as_ref().map(|it| it.own_profiles.clone()).unwrap_or_default(),
            ending: ending.as_ref().map(|ending| ending.kind.key()),
            lost_robots: ending.as_ref().map(|ending| ending.lost.clone()).unwrap_or_default(),
            paused_robots: ending.as_ref().map(|ending| ending.paused.clone()).unwrap_or_default(),
            reason: ending.map(|ending| ending.reason).filter(|reason| !reason.is_empty()),
            labels,
            record,
            lossy: LossyRecovery::in_bag(bag),
            broken: BrokenRecording::in_bag(bag),
        }
    }

    /// Whether all that was recorded is in it.
    pub fn is_whole(&self) -> bool {
        let lacks = self.info.recovery.as_ref().is_some_and(|recovery| !recovery.is_complete);
        self.info.damage.is_empty() && !lacks
    }
}

/// What is in it, line by line, with its topics and attachments as tables.
pub fn text(contents: &BagContents) -> String {
    let BagContents { info, record, .. } = contents;
    let as_far = if info.damage.is_empty() { "" } else { ", up to its damage" };
    let mut text = format!(
        "{}{as_far}: {:.1} s, {} on {}, {} in {}\n",
        info.path.display(),
        info.duration_s,
        counted(info.n_messages, "message"),
        counted(info.topics.len() as u64, "topic"),
        size(info.n_bytes),
        counted(info.files.len() as u64, "file")
    );
    let mut line = |printed: String| {
        writeln!(text, "{}", one_line(&printed)).expect("a string takes any text");
    };
    if let Some((start_ns, end_ns)) = info.start_ns.zip(info.end_ns) {
        line(format!("recorded: {} to {}", moment(start_ns), moment(end_ns)));
    }
    if let Some(record) = record {
        line(format!("run: {}", run_of(record, contents)));
        line(format!("robots moved by: {}", record.backend.in_words()));
        line(format!("controller: {}", record.conditions.controller));
        line(format!("judged for: {}", record.conditions.behaviour));
    }
    for (robot, own) in &contents.own_profiles {
        line(format!("{robot}: {own}"));
    }
    for lost in &contents.lost_robots {
        line(lost.to_string());
    }
    for paused in &contents.paused_robots {
        line(paused.to_string());
    }
    line(format!("written by: {}", writer(info)));
    for label in &contents.labels {
        line(format!("label: {}", human(label)));
    }
    for damage in &info.damage {
        line(format!("damage: {}: {}", damage.path.display(), damage.reason));
    }
    for fault in &info.summary_faults {
        line(format!("damage: the summary section alone, of which nothing is needed: {fault}"));
    }
    if let Some(lossy) = &contents.lossy {
        line(format!("damage: {lossy}"));
    }
    if let Some(broken) = &contents.broken {
        line(format!("damage: {broken}"));
        line(format!("next: rsrs bag recover {}", quoted(&info.path)));
    } else if info.n_messages == 0 {
        line("damage: none, but nothing was recorded".to_owned());
    }
    line("topics:".to_owned());
    text.push_str(&topics(info));
    text.push('\n');
    if !info.attachments.is_empty() {
        text.push_str("attachments:\n");
        let row = |name: &str, kind: &str, n: usize| [indented(name), kind.into(), size(n as u64)];
        let rows = info.attachments.iter().map(|it| row(&it.name, &it.media_type, it.n_bytes));
        text.push_str(&columns(&rows.collect::<Vec<_>>()));
    }
    text
}

fn run_of(record: &ExperimentRecord, contents: &BagContents) -> String {
    let ending = match (contents.ending, &contents.reason) {
        (None, _) if !contents.info.damage.is_empty() => {
            "its end is behind the damage, if it was recorded".to_owned()
        }
        (None, _) => "its end is not recorded".to_owned(),
        (Some(ending), None) => ending.to_owned(),
        (Some(ending), Some(reason)) => format!("{ending} ({reason})"),
    };
    format!(
        "{}, {}, set to last {} s, seed {}, {ending}",
        record.run_id,
        counted(record.robots.len() as u64, "robot"),
        record.duration_s,
        record.seed
    )
}

fn writer(info: &BagInfo) -> String {
    let mut libraries: Vec<&str> = info.files.iter().map(|file| file.library.as_str()).collect();
    libraries.dedup();
    let named = libraries.iter().any(|library| !library.is_empty());
    let mut parts =
        vec![if named { libraries.join(", ") } else { "an unknown program".to_owned() }];
    parts.extend(info.ros_distro.iter().map(|distro| format!("ROS {distro}")));
    parts.push(match info.metadata_version {
        Some(version) => format!("metadata version {version}"),
        None => "no metadata.yaml".to_owned(),
    });
    let compression = &info.compression;
    let mut packed = compression.chunks.clone();
    packed.extend(compression.files.then(|| "whole files compressed".to_owned()));
    packed.extend(compression.messages.then(|| "single messages compressed".to_owned()));
    parts.push(if packed.is_empty() { "not compressed".to_owned() } else { packed.join(", ") });
    if info.files.iter().any(|file| !file.is_indexed) {
        parts.push("without index".to_owned());
    }
    parts.join("; ")
}

fn topics(info: &BagInfo) -> String {
    let rows = info.topics.iter().map(|topic| {
        let rate = topic.rate_hz.map_or_else(String::new, |rate_hz| format!("{rate_hz:.1} Hz"));
        let qos: Vec<String> = topic.offered_qos.iter().map(quality).collect();
        let mut qos: Vec<&str> = qos.iter().map(String::as_str).collect();
        qos.dedup();
        let type_name = if topic.type_name.is_empty() { "unknown type" } else { &topic.type_name };
        [indented(&topic.name), type_name.to_owned(), count(topic.n_messages), rate, qos.join("; ")]
    });
    columns(&rows.collect::<Vec<_>>())
}

fn indented(name: &str) -> String {
    format!("  {name}")
}

fn quality(qos: &OfferedQos) -> String {
    let depth = if qos.history == "keep_all" {
        "keep all".to_owned()
    } else {
        format!("depth {}", qos.depth)
    };
    format!("{}, {}, {depth}", qos.reliability, qos.durability).replace('_', " ")
}
