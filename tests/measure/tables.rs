//! Tables of trials: what they contain, and what is wrong with them.

use std::path::Path;
use std::process::Output;

use super::{number, read, trials, write};
use crate::command::{bring, code, done, json, rsrs, shipped, stderr, stdout};

fn fit(folder: &Path, rest: &[&str]) -> Output {
    let line =
        "measure fit --speed speed.csv --turn turn.csv --detection detection.csv --name flockbot";
    rsrs(folder, &[&line.split(' ').collect::<Vec<_>>()[..], rest].concat())
}

#[test]
fn the_flockbots_trials_give_the_gains_of_the_paper() {
    let place = trials();

    let output = fit(place.path(), &["--period", "period.csv", "-o", "p.yaml", "--format", "json"]);

    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let report = json(&output);
    let gains = |commanded_m_s: f64| -> Vec<String> {
        let rows = report["speed"].as_array().expect("rows").iter();
        rows.filter(|row| number(&row["commanded_m_s"]).to_bits() == commanded_m_s.to_bits())
            .map(|row| format!("{:.2}", number(&row["gain"])))
            .collect()
    };
    // `tab:speed1`: three robots at 25 mm/s, and at 50 mm/s.
    assert_eq!(gains(0.025), ["0.89", "0.86", "0.89"]);
    assert_eq!(gains(0.05), ["0.97", "0.97", "0.97"]);
    for row in report["speed"].as_array().expect("rows") {
        assert!(number(&row["gain_low"]) < number(&row["gain"]), "{row}");
        assert!(number(&row["gain"]) < number(&row["gain_high"]), "{row}");
    }
    let sensor = &report["sensor"];
    assert!(sensor["polygon_m"].as_array().expect("corners").len() >= 3);
    assert!(number(&sensor["false_positive_low"]) < 0.065);
    assert!(number(&sensor["false_positive_high"]) > 0.065);
    assert!((number(&report["period_s"]) - 0.13).abs() < 0.005, "{}", report["period_s"]);
    assert!(number(&report["details"]["speed"]["robot_sd"]["low"]) < 0.02);
}

#[test]
fn a_fitted_profile_can_be_swept() {
    let place = trials();
    let sweep = "profile: p.yaml\nharsher: none\naxes: {speed_m_s: [0.05], turn_rate_rad_s: [0.75]}\n\
                 fixed: {robots: 5}\nreplicates: 4\nduration_s: 70\nseed: 3\n";
    write(place.path(), "sweep.yaml", sweep);

    let fitted = fit(place.path(), &["-o", "p.yaml"]);
    let swept = rsrs(place.path(), &["sweep", "sweep.yaml", "-o", "out"]);

    assert_eq!((code(&fitted), code(&swept)), (0, 0), "{}{}", stderr(&fitted), stderr(&swept));
    assert!(read(place.path(), "p.yaml").contains("sees: centre"));
    assert!(stdout(&fitted).contains("control period: not measured"), "{}", stdout(&fitted));
}

#[test]
fn a_radius_that_was_given_is_not_reported_as_assumed() {
    let place = trials();

    let [given, assumed] =
        [&["--radius", "0.08", "-o", "p.yaml"][..], &["-o", "p.yaml"]].map(|more| {
            assert_eq!(code(&fit(place.path(), more)), 0);
            read(place.path(), "p.yaml")
        });

    assert!(given.contains("radius_m: 0.08"), "{given}");
    assert!(given.contains("body.radius_m: given to rsrs measure fit"), "{given}");
    assert!(assumed.contains("body.radius_m: \"assumed: as the Flockbot"), "{assumed}");
}

#[test]
fn the_pictures_show_speeds_and_sensor() {
    let place = trials();

    let output = fit(place.path(), &["--pictures", "pictures"]);

    assert_eq!(code(&output), 0, "{}", stderr(&output));
    assert!(read(place.path(), "pictures/speeds.svg").contains("gain 0.86"));
    assert!(read(place.path(), "pictures/sensor.svg").contains("measured: detected at least 80 %"));
    for picture in ["speeds.png", "sensor.png"] {
        let bytes =
            std::fs::read(place.path().join("pictures").join(picture)).expect("it is there");
        assert!(bytes.starts_with(b"\x89PNG"), "{picture}");
    }
}

#[test]
fn a_table_out_of_a_spreadsheet_means_the_same() {
    let place = trials();
    let plain = fit(place.path(), &["--format", "json"]);
    let speed = read(place.path(), "speed.csv");
    let (header, rows) = speed.split_once('\n').expect("a header and rows");
    let mut rows: Vec<&str> = rows.lines().collect();
    rows.reverse();
    let unsorted = format!("\u{feff}{header}\r\n{}\r\n", rows.join("\r\n")).replace(',', ";");
    write(place.path(), "speed.csv", unsorted);

    let spreadsheet = fit(place.path(), &["--format", "json"]);

    assert_eq!(code(&spreadsheet), 0, "{}", stderr(&spreadsheet));
    let gains = |output: &Output| -> Vec<String> {
        let report = json(output);
        let rows = report["speed"].as_array().expect("rows").iter();
        rows.map(|row| format!("{} {:.9}", row["robot"], number(&row["gain"]))).collect()
    };
    assert_eq!(gains(&spreadsheet), gains(&plain));
}

#[test]
fn wrong_tables_are_refused_with_file_line_and_the_likely_cause() {
    const HEADER: &str = "robot,commanded_m_s,distance_m,duration_s\n";
    let with = |rows: &str| format!("{HEADER}{rows}");
    for (table, expected) in [
        (String::new(), "speed.csv:1: the table is empty, expected the header `robot,"),
        (HEADER.to_owned(), "speed.csv:1: the table has a header and no rows"),
        (
            "robot,commanded_mm_s,distance_m,duration_s\na,25,2,80\n".to_owned(),
            "speed.csv:1: no column `commanded_m_s` in the header `robot,commanded_mm_s,",
        ),
        (with("a,150,2,13\n"), "speed.csv:2: commanded_m_s is 150: this looks like mm/s"),
        (with("a,0.15,2000,13\n"), "speed.csv:2: distance_m is 2000: this looks like mm"),
        (with("a,0.15,2,13\na,0.15,2,0\n"), "speed.csv:3: duration_s is 0, expected"),
        (with("a,0.15,-2,13\n"), "speed.csv:2: distance_m is -2, expected"),
        (with("a,0.15,NaN,13\n"), "speed.csv:2: distance_m is NaN, expected a finite number"),
        (with("a,0.15,2\n"), "speed.csv:2: the row has 3 fields, expected 4"),
        (with("a,0.15,2,\n"), "speed.csv:2: duration_s is empty"),
        (
            "robot;commanded_m_s;distance_m;duration_s\na;0,15;2;13\n".to_owned(),
            "with a decimal point, not a comma",
        ),
    ] {
        let place = trials();
        write(place.path(), "speed.csv", &table);

        let output = fit(place.path(), &["-o", "p.yaml"]);

        assert_eq!(code(&output), 1, "{table}");
        assert!(stderr(&output).contains(expected), "{table}: {}", stderr(&output));
        assert!(!place.path().join("p.yaml").exists(), "{table}");
    }
}

#[test]
fn one_trial_and_one_speed_are_fitted_and_called_few() {
    let place = trials();
    write(place.path(), "speed.csv", "robot,commanded_m_s,distance_m,duration_s\na,0.15,2,13.5\n");

    let output = fit(place.path(), &["-o", "p.yaml"]);

    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let text = stdout(&output);
    for expected in [
        "0.988  no interval",
        "sd of the speed gain between robots  unknown",
        "one robot only, so nothing is known of how robots differ",
        "one command only (0.15 m/s); its gain is held at all others",
    ] {
        assert!(text.contains(expected), "{expected}: {text}");
    }
}

#[test]
fn a_sensor_that_ten_times_as_many_misses_would_blind_gets_factors_that_leave_it_most_detections() {
    let place = trials();
    bring("profiles/smars_trials/detection.csv", &place.path().join("detection.csv"));

    let output = fit(place.path(), &[]);

    assert_eq!(code(&output), 0, "{}", stderr(&output));
    assert!(!stdout(&output).contains("warning: with the default factors"), "{}", stdout(&output));
}

#[test]
fn missing_tables_are_bad_arguments() {
    let place = trials();

    let nothing =
        rsrs(place.path(), &["measure", "fit", "--detection", "detection.csv", "--name", "x"]);
    let elsewhere = fit(place.path(), &["--period", "nowhere.csv"]);

    assert_eq!(code(&nothing), 2);
    assert_eq!(code(&elsewhere), 1);
    assert!(stderr(&elsewhere).contains("cannot read nowhere.csv"), "{}", stderr(&elsewhere));
}

#[test]
fn the_detection_grid_is_that_of_the_robots_that_are_measured() {
    let place = tempfile::tempdir().expect("a temporary folder");
    let robot = ["--range", "1.0", "--radius", "0.1", "--half-angle", "0.8", "--period", "0.1"];
    let arguments = [&["measure", "plan", "--format", "json"][..], &robot].concat();

    let planned = done(place.path(), &arguments);
    let plan: serde_json::Value = serde_json::from_str(&planned).expect("it is JSON");
    let ends = |key: &str| {
        let values = plan[key].as_array().expect("a list");
        [&values[0], &values[values.len() - 1]].map(ToString::to_string)
    };
    assert_eq!(ends("distances_m"), ["0.2", "1.25"], "from contact to beyond the range");
    assert_eq!(ends("bearings_rad"), ["-1.2", "1.2"], "beyond both edges of the sensor");
}

#[test]
fn a_plan_is_a_sheet_and_tables_that_are_not_overwritten() {
    let place = tempfile::tempdir().expect("a temporary folder");
    let fleet = &shipped("fleets/nine_virtual.yaml");
    let arguments =
        ["measure", "plan", fleet, "--speed", "0.05,0.15", "--commands", "2", "-o", "trials"];

    let planned = rsrs(place.path(), &arguments);
    let again = rsrs(place.path(), &arguments);
    let unfilled = fit(&place.path().join("trials"), &[]);

    assert_eq!(code(&planned), 0, "{}", stderr(&planned));
    assert!(stdout(&planned).contains("speeds: 0.05, 0.15 m/s"), "{}", stdout(&planned));
    assert!(stdout(&planned).starts_with(&read(place.path(), "trials/sheet.txt")));
    assert!(stdout(&planned).contains("then: rsrs measure fit --plan trials --name NAME"));
    assert_eq!(code(&again), 1);
    assert!(stderr(&again).contains("trials exists"), "{}", stderr(&again));
    assert_eq!(code(&unfilled), 1);
    assert!(
        stderr(&unfilled).contains("help: delete the rows of trials that were not run"),
        "{}",
        stderr(&unfilled)
    );
}
