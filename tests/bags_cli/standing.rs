//! Bags of robots that stood and sensed, as trials of a sensor.

use std::fmt::Write;
use std::path::Path;

use rsrs_bags::{BagOptions, BagWriter, ChannelId, Sample};
use rsrs_core::conditions::{Conditions, Placement, Settings, Walls};
use rsrs_core::quantity::Axis;
use rsrs_fleet::record::{ATTACHMENT, ExperimentRecord};
use rsrs_msgs::rsrs::{LeaseState, RunLease};
use rsrs_msgs::std_msgs::Bool;
use rsrs_msgs::topics::Topic;
use rsrs_msgs::{RosMessage, cdr, topics};
use rsrs_testing::record::fleet_record;

use super::place;
use crate::cells::flockbot;
use crate::command::{code, json, rsrs, stderr};

const PERIOD_NS: u64 = 130_000_000;
/// While a sensor settles, it reports what is not to be counted.
const N_SETTLING: u64 = 4;

/// What a trial of `rsrs measure drive` records of itself.
fn record(neighbour: Option<(f64, f64)>) -> ExperimentRecord {
    let profile = flockbot();
    let values = vec![(Axis::Speed, 0.0), (Axis::TurnRate, 0.0), (Axis::Robots, 1.0)];
    let settings = Settings { values, walls: Walls::None, ..Settings::default() };
    let mut conditions = Conditions::resolve(&profile, &settings).expect("it may stand");
    if let Some((distance_m, bearing_rad)) = neighbour {
        conditions.placement = Placement::Pair { distance_m, bearing_rad };
    }
    let record = fleet_record(&profile.digest(), conditions);
    ExperimentRecord { run_id: "trial".to_owned(), duration_s: 14.0, ..record }
}

/// The bag of a trial without a tracker: the lease, and what the sensor reported.
fn stood(path: &Path, neighbour: Option<(f64, f64)>, (samples, detections): (u64, u64)) {
    let mut writer = BagWriter::create(path, BagOptions::default()).expect("it is new");
    let record = record(neighbour).to_json();
    writer.attach(ATTACHMENT, "application/json", record.as_bytes()).expect("room");
    let mut add = |topic: Topic| {
        writer.add_topic(&topic.for_robot("robot_1"), topic.type_name, topic.qos).expect("new")
    };
    let detection = add(topics::DETECTION);
    let lease = writer.add_topic(topics::LEASE.name, RunLease::TYPE_NAME, topics::LEASE.qos);
    let lease = lease.expect("it is new");
    let mut put = |channel: ChannelId, log_time_ns: u64, data: Vec<u8>| {
        let sample = Sample { log_time_ns, publish_time_ns: log_time_ns, sequence: 0, data: &data };
        writer.write(channel, sample).expect("room");
    };
    let printed =
        |state: LeaseState| cdr::encode(&RunLease { state: state.into(), ..RunLease::default() });
    put(lease, 0, printed(LeaseState::Running));
    for step in 0..N_SETTLING + samples {
        let data = step < N_SETTLING + detections;
        put(detection, step * PERIOD_NS, cdr::encode(&Bool { data }));
    }
    let end_ns = (N_SETTLING + samples) * PERIOD_NS;
    put(lease, end_ns, printed(LeaseState::Stopped));
    put(detection, end_ns + PERIOD_NS, cdr::encode(&Bool { data: true }));
    writer.finish().expect("room");
}

#[test]
fn bags_of_robots_that_stood_fit_the_sensor_that_their_table_fits() {
    let place = place();
    let here = place.path();
    let write = |name: &str, text: &str| std::fs::write(here.join(name), text).expect("writable");
    let speed = "robot,commanded_m_s,distance_m,duration_s\n\
                 robot_1,0.15,1.40,10\nrobot_1,0.15,1.42,10\nrobot_2,0.15,1.45,10\nrobot_2,0.15,1.44,10\n";
    let turn = "robot,commanded_rad_s,angle_rad,duration_s\n\
                robot_1,0.75,7.3,10\nrobot_1,0.75,7.4,10\nrobot_2,0.75,7.5,10\nrobot_2,0.75,7.4,10\n";
    write("speed.csv", speed);
    write("turn.csv", turn);
    let mut table = "robot,distance_m,bearing_rad,samples,detections\n".to_owned();
    let mut bags = Vec::new();
    let mut trial = |neighbour: Option<(f64, f64)>, counts: (u64, u64)| {
        let name = format!("stood_{}", bags.len());
        stood(&here.join(&name), neighbour, counts);
        let (distance, bearing) = neighbour.map_or_else(Default::default, |(distance, bearing)| {
            (distance.to_string(), bearing.to_string())
        });
        writeln!(table, "robot_1,{distance},{bearing},{},{}", counts.0, counts.1)
            .expect("a string takes any text");
        bags.push(name);
    };
    for distance_m in [0.2, 0.4, 0.6, 0.8, 1.0] {
        for bearing_rad in [-0.6, -0.3, -0.15, 0.0, 0.15, 0.3, 0.6] {
            let is_inside = distance_m < 0.75 && f64::abs(bearing_rad) < 0.2;
            trial(Some((distance_m, bearing_rad)), (50, if is_inside { 49 } else { 3 }));
        }
    }
    trial(None, (100, 5));
    write("detection.csv", &table);
    let tables = ["measure", "fit", "--speed", "speed.csv", "--turn", "turn.csv", "--name", "x"];
    let fit = |more: &[&str]| rsrs(here, &[&tables[..], &["--format", "json"], more].concat());
    let bags: Vec<&str> = bags.iter().map(String::as_str).collect();

    let of_table = fit(&["--detection", "detection.csv"]);
    let of_bags = fit(&[&["--bags"], &bags[..]].concat());
    let of_drives = fit(&["--bags", bags[0], "--detection", "detection.csv"]);

    assert_eq!((code(&of_table), code(&of_bags)), (0, 0), "{}", stderr(&of_bags));
    assert_eq!(json(&of_bags)["sensor"], json(&of_table)["sensor"]);
    assert_eq!(json(&of_drives)["sensor"], json(&of_table)["sensor"], "a table goes before bags");
}

#[test]
fn bags_in_which_nobody_stands_are_no_trials_of_a_sensor() {
    let place = place();
    let here = place.path();
    crate::simulated_bags::Run { robots: 1, ..crate::simulated_bags::Run::new(1) }
        .record(here, "run");

    let output = rsrs(here, &["measure", "fit", "--bags", "run", "--name", "x"]);

    assert_eq!(code(&output), 1);
    assert_eq!(
        stderr(&output),
        "error: in none of the bags does a robot stand and sense\nhelp: give a table with \
         `--detection`, or bags of `rsrs measure drive --distance M --bearing RAD` and `rsrs measure \
         drive --alone`\n"
    );
}
