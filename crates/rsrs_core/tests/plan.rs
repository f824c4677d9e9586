//! Which trials are worth running, and whether they are enough.

use rsrs_core::statistics::variance::Estimate;
use rsrs_core::trials::plan::{Plan, PlanError, PlanRequest, repetitions_for};
use rsrs_core::trials::trial::{
    arc_trials, detection_trials, period_trials, speed_trials, turn_trials,
};
use rsrs_testing::draw::Draw;

fn request() -> PlanRequest {
    let robots = (1..=9).map(|robot| format!("robot_{robot}")).collect();
    PlanRequest { robots, ..PlanRequest::default() }
}

#[test]
fn the_sheet_reads_as_it_is_to_be_done() {
    insta::assert_snapshot!(Plan::new(request()).unwrap().text(), @r"
    Trials of 5 robots: robot_1, robot_2, robot_4, robot_6, robot_8

    1  Straight runs: 175, over a track of 2 m
       speeds: 0.02, 0.09, 0.16, 0.23, 0.3 m/s (2, 9, 16, 23, 30 cm/s)
       7 times each; write down the time, and where the robot ended:
       lateral_m beside the line (left is positive), heading_change_rad (left is positive)
    2  Turns in place: 175, a full circle (6.2832 rad, 360°) each
       rates: 0.1, 0.7, 1.3, 1.9, 2.5 rad/s (5.7, 40.1, 74.5, 108.9, 143.2°/s)
       7 times each; write down the time
    3  Arcs: 175, the same turns while driving at 0.16 m/s (16 cm/s); write down the time
    4  Detections: one robot, another at 81 places, 70 readings each
       distances, centre to centre: 0.15, 0.248, 0.347, 0.445, 0.544, 0.642, 0.741, 0.839, 0.938 m (15, 24.8, 34.7, 44.5, 54.4, 64.2, 74.1, 83.9, 93.8 cm)
       bearings, left is positive: -0.525, -0.394, -0.262, -0.131, 0, 0.131, 0.262, 0.394, 0.525 rad (-30.1, -22.6, -15, -7.5, 0, 7.5, 15, 22.6, 30.1°)
    5  False positives: 128 readings of each robot alone, 83 s in all
    6  Period: 20 control periods of each robot, from its log or a bag

    About 13.5 h in all: 3.3 h of driving and reading, and 10.2 h by hand, if placing and writing down take 1 min for each of the 611 trials.
    Expected precision: each gain (measured over commanded) to ±0.02 (if trials of a robot differ by 0.02), each rate of detections to ±0.1, at 95 %.
    ");
}

#[test]
fn what_takes_less_than_an_hour_is_stated_in_minutes() {
    let small = PlanRequest {
        robots: vec!["robot_1".to_owned()],
        n_commands: 1,
        gain_precision: 0.1,
        n_distances: Some(3),
        n_bearings: 1,
        ..PlanRequest::default()
    };

    let text = Plan::new(small).unwrap().text();

    let line = text.lines().find(|line| line.contains(" in all: ")).unwrap();
    assert!(line.starts_with("About ") && line.matches(" min ").count() == 4, "{line}");
}

#[test]
fn tables_that_are_filled_in_can_be_read() {
    let plan = Plan::new(request()).unwrap();
    let n_commands = plan.robots.len() * plan.repetitions * 5;
    let filled = |table: &str, gap: &str, value: &str| {
        let (header, rows) = table.split_once('\n').expect("a header");
        format!("{header}\n{}", rows.replace(gap, value))
    };

    let speed = speed_trials("s.csv", &filled(&plan.speed_csv(), ",,,,,\n", ",20,,,,\n")).unwrap();
    let turn = turn_trials("t.csv", &filled(&plan.turn_csv(), ",,,\n", ",9,,\n")).unwrap();
    let arc = arc_trials("a.csv", &filled(&plan.arc_csv(), ",,,\n", ",9,,\n")).unwrap();
    let detection =
        detection_trials("d.csv", &filled(&plan.detection_csv(), ",,\n", ",3,\n")).unwrap();
    let period = period_trials("p.csv", &filled(&plan.period_csv(), ",,\n", ",0.13,\n")).unwrap();

    assert_eq!([speed.rows.len(), turn.rows.len(), arc.rows.len()], [n_commands; 3]);
    assert_eq!((speed.robots.len(), period.rows.len()), (5, 100));
    let n_alone = detection.rows.iter().filter(|row| row.neighbour.is_none()).count();
    assert_eq!(n_alone, 5);
}

#[test]
fn tables_that_are_not_filled_in_are_refused_with_the_line() {
    let plan = Plan::new(request()).unwrap();

    let error = speed_trials("speed.csv", &plan.speed_csv()).unwrap_err();

    insta::assert_snapshot!(error, @"speed.csv:2: duration_s is empty, expected a number");
}

#[test]
fn the_repetitions_give_the_precision_that_was_asked_for() {
    for (sd, half_width) in [(0.02, 0.02), (0.02, 0.01), (0.05, 0.02)] {
        let repetitions = repetitions_for(sd, half_width);
        let mut draw = Draw::new(1);

        let widths = (0..2000).map(|_| {
            let gains: Vec<f64> = (0..repetitions).map(|_| draw.normal(0.95, sd)).collect();
            let Estimate { low: Some(low), high: Some(high), .. } = Estimate::of_mean(&gains)
            else {
                panic!("several trials have an interval")
            };
            (high - low) / 2.0
        });
        let mean = widths.sum::<f64>() / 2000.0;

        // No waste either: twice as many repetitions would give less than 0.7 of the half-width.
        assert!(mean <= half_width && mean > 0.7 * half_width, "{sd} {half_width}: {mean}");
    }
}

#[test]
fn a_request_that_makes_no_sense_is_refused() {
    let no_robots = PlanRequest { robots: Vec::new(), ..request() };
    let backwards = PlanRequest { limits_m_s: [0.3, 0.1], ..request() };
    let blind = PlanRequest { range_m: 0.1, ..request() };
    let endless = PlanRequest { range_m: f64::INFINITY, ..request() };

    assert_eq!(Plan::new(no_robots), Err(PlanError::NoRobots));
    insta::assert_snapshot!(Plan::new(backwards).unwrap_err(), @"the greatest safe speed in m/s is 0.1, expected more than the least");
    insta::assert_snapshot!(Plan::new(blind).unwrap_err(), @"the sensor's range in m is 0.1, expected more than two radii");
    insta::assert_snapshot!(Plan::new(endless).unwrap_err(), @"the sensor's range in m is inf, expected a number above 0");
    let millimetres = PlanRequest { limits_m_s: [20.0, 300.0], ..request() };
    let degrees = PlanRequest { limits_rad_s: [5.0, 140.0], ..request() };
    insta::assert_snapshot!(Plan::new(millimetres).unwrap_err(), @"speed_m_s is 300: this looks like mm/s, expected m/s");
    insta::assert_snapshot!(Plan::new(degrees).unwrap_err(), @"turn_rate_rad_s is 140: this looks like degrees per second, expected rad/s");
}
