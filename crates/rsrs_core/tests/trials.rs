//! Tables of trials: what is read as it comes, and what is refused with which words.

use rsrs_core::robot::controller::Command;
use rsrs_core::robot::unicycle::{ActuationGain, Pose, step};
use rsrs_core::statistics::variance::Estimate;
use rsrs_core::trials::fit::step_noise;
use rsrs_core::trials::trial::{
    DrivenSample, DrivenTrial, detection_trials, driven_trials, period_trials, reduced,
    speed_trials, turn_trials,
};
use rsrs_testing::draw::Draw;

fn speed_error(text: &str) -> String {
    speed_trials("speed.csv", text).expect_err("this is refused").to_string()
}

#[test]
fn a_table_from_a_spreadsheet_is_read_as_it_comes() {
    let plain = "robot,commanded_m_s,distance_m,duration_s\na,0.1,2,21\nb,0.1,2,22\n";
    let foreign = "\u{feff}duration_s;robot;commanded_m_s;distance_m\r\n21;\"a\";0.1;2\r\n\
                   22;b;0.1;2\r\n;;;\r\n";

    assert_eq!(speed_trials("t.csv", foreign).unwrap(), speed_trials("t.csv", plain).unwrap());
}

#[test]
fn columns_are_named_with_the_header_and_the_nearest_name() {
    insta::assert_snapshot!(
        speed_error("robot,commanded_mm_s,distance_m,duration_s\na,25,2,80\n"),
        @"speed.csv:1: no column `commanded_m_s` in the header `robot,commanded_mm_s,distance_m,duration_s`; is it `commanded_mm_s`?"
    );
    insta::assert_snapshot!(
        speed_error("robot,commanded_m_s,distance_m,duration_s,latteral_m\na,0.1,2,20,0\n"),
        @"speed.csv:1: unknown column `latteral_m`; did you mean `lateral_m`?"
    );
    insta::assert_snapshot!(
        speed_error("robot,robot,commanded_m_s,distance_m,duration_s\n"),
        @"speed.csv:1: column `robot` occurs twice"
    );
}

#[test]
fn numbers_that_cannot_be_are_refused_with_their_line() {
    let row = |row: &str| {
        let header = "robot,commanded_m_s,distance_m,duration_s,lateral_m,heading_change_rad";
        speed_error(&format!("{header}\na,0.1,2,21,0,0\n\n{row}\n"))
    };
    insta::assert_snapshot!(row("a,0.1,2,0,0,0"), @"speed.csv:4: duration_s is 0, expected above 0");
    insta::assert_snapshot!(row("a,0.1,-2,20,0,0"), @"speed.csv:4: distance_m is -2, expected 0 or more");
    insta::assert_snapshot!(row("a,0.1,NaN,20,0,0"), @"speed.csv:4: distance_m is NaN, expected a finite number");
    insta::assert_snapshot!(row("a,0.1,inf,20,0,0"), @"speed.csv:4: distance_m is inf, expected a finite number");
    insta::assert_snapshot!(row("a,0.1,two,20,0,0"), @"speed.csv:4: distance_m is `two`, expected a number");
    insta::assert_snapshot!(row("a,0.1,2,,0,0"), @"speed.csv:4: duration_s is empty, expected a number");
    insta::assert_snapshot!(row(",0.1,2,20,0,0"), @"speed.csv:4: robot is empty, expected a name");
    insta::assert_snapshot!(row("a,0.1,2,20"), @"speed.csv:4: the row has 4 fields, expected 6 as in the header");
    insta::assert_snapshot!(row("\"a,0.1,2,20,0,0"), @"speed.csv:4: a quote is opened and not closed in this line");
    insta::assert_snapshot!(
        speed_error("robot;commanded_m_s;distance_m;duration_s\na;0,1;2;20\n"),
        @"speed.csv:2: commanded_m_s is `0,1`, expected a number with a decimal point, not a comma"
    );
    insta::assert_snapshot!(speed_error(" \n"), @"speed.csv:1: the table is empty, expected the header `robot,commanded_m_s,distance_m,duration_s,lateral_m,heading_change_rad,paused_s,backend`");
    insta::assert_snapshot!(speed_error("robot,commanded_m_s,distance_m,duration_s\n"), @"speed.csv:1: the table has a header and no rows");
}

#[test]
fn other_units_are_refused_with_the_likely_cause() {
    let speed = |row: &str| {
        speed_error(&format!(
            "robot,commanded_m_s,distance_m,duration_s,lateral_m,heading_change_rad\n{row}\n"
        ))
    };
    insta::assert_snapshot!(speed("a,25,2,80,,"), @"speed.csv:2: commanded_m_s is 25: this looks like mm/s, expected m/s");
    insta::assert_snapshot!(speed("a,0.025,2000,80,,"), @"speed.csv:2: distance_m is 2000: this looks like mm, expected metres");
    insta::assert_snapshot!(speed("a,2.5,2,80,,"), @"speed.csv:2: commanded_m_s is 2.5: this looks like cm/s, expected m/s");
    insta::assert_snapshot!(speed("a,0.025,2,80,30,"), @"speed.csv:2: lateral_m is 30: this looks like mm, expected metres");
    insta::assert_snapshot!(speed("a,0.025,2,80,,12"), @"speed.csv:2: heading_change_rad is 12: this looks like degrees, expected radians");
    let turn = |row: &str| {
        let text = format!("robot,commanded_rad_s,angle_rad,duration_s\n{row}\n");
        turn_trials("turn.csv", &text).expect_err("this is refused").to_string()
    };
    insta::assert_snapshot!(turn("a,43,360,8.4"), @"turn.csv:2: commanded_rad_s is 43: this looks like degrees per second, expected rad/s");
    insta::assert_snapshot!(turn("a,0.75,360,8.4"), @"turn.csv:2: angle_rad is 360: this looks like degrees, expected radians");
    insta::assert_snapshot!(turn("a,5,6.2832,72"), @"turn.csv:2: commanded_rad_s is 5: this looks like degrees per second, expected rad/s");
    insta::assert_snapshot!(turn("a,-0.75,6.2832,8.4"), @"turn.csv:2: angle_rad is 6.2832, expected an angle with the sign of commanded_rad_s (counterclockwise is positive)");
    insta::assert_snapshot!(turn("a,0,6.2832,8.4"), @"turn.csv:2: commanded_rad_s is 0, expected a turning rate that is not 0");
    let detection = |row: &str| {
        let text = format!("robot,distance_m,bearing_rad,samples,detections\n{row}\n");
        detection_trials("d.csv", &text).expect_err("this is refused").to_string()
    };
    insta::assert_snapshot!(detection("a,300,0,50,50"), @"d.csv:2: distance_m is 300: this looks like mm or cm, expected metres");
    insta::assert_snapshot!(detection("a,0.3,15,50,50"), @"d.csv:2: bearing_rad is 15: this looks like degrees, expected radians");
    insta::assert_snapshot!(detection("a,0.3,0,50,51"), @"d.csv:2: detections is 51, expected at most samples");
    insta::assert_snapshot!(detection("a,0.3,0,0,0"), @"d.csv:2: samples is 0, expected 1 or more");
    insta::assert_snapshot!(detection("a,,0.1,50,3"), @"d.csv:2: bearing_rad is 0.1, expected no bearing where distance_m is empty (no neighbour)");
    insta::assert_snapshot!(
        period_trials("p.csv", "robot,period_s\na,130\n").expect_err("this is refused"),
        @"p.csv:2: period_s is 130: this looks like ms, expected seconds"
    );
}

#[test]
fn trajectories_are_sorted_and_their_headings_made_continuous() {
    let text = "robot,trial,time_s,x_m,y_m,heading_rad,commanded_m_s,commanded_rad_s\n\
                a,1,2,0.2,0,-3.1,0.1,0.1\na,1,0,0,0,3.0,0.1,0.1\na,1,1,0.1,0,3.1,0.1,0.1\n";

    let trials = driven_trials("t.csv", text).unwrap();

    let headings: Vec<f64> =
        trials[0].samples.iter().map(|sample| sample.pose.heading_rad).collect();
    assert!((headings[2] - (std::f64::consts::TAU - 3.1)).abs() < 1e-12, "{headings:?}");
    // It headed to -x from the start, so that is ahead of it.
    let half_way = trials[0].displacement_at(1.5);
    assert!((half_way.x_m + 0.15 * libm::cos(3.0).abs()).abs() < 1e-12, "{half_way:?}");
}

#[test]
fn a_recording_that_begins_before_the_robot_does_begins_with_its_command() {
    let header = "robot,trial,time_s,x_m,y_m,heading_rad,commanded_m_s,commanded_rad_s";
    let rows = |commands: &[f64]| {
        let row = |(index, speed_m_s): (usize, &f64)| format!("a,1,{index},0,0,0,{speed_m_s},0");
        let rows: Vec<String> = commands.iter().enumerate().map(row).collect();
        let text = format!("{header}\n{}", rows.join("\n"));
        let trial = driven_trials("t.csv", &text).unwrap().remove(0);
        let command = trial.constant_command().map(|command| command.speed_m_s);
        (trial.samples[0].time_s, trial.samples.len(), command)
    };

    assert_eq!(rows(&[0.0, 0.0, 0.1, 0.1, 0.0]), (2.0, 3, Some(0.1)));
    assert_eq!(rows(&[0.1, 0.1, 0.1]), (0.0, 3, Some(0.1)));
    assert_eq!(rows(&[0.0, 0.1, 0.2, 0.2]), (1.0, 3, None), "of two commands none is constant");
    assert_eq!(rows(&[0.0, 0.0, 0.0]), (0.0, 3, Some(0.0)), "it stood");
    assert_eq!(rows(&[0.0, 0.0, 0.1]), (0.0, 3, Some(0.0)), "and the last command is not driven");
}

#[test]
fn trajectories_that_cannot_be_are_refused() {
    let error = |rows: &str| {
        let header = "robot,trial,time_s,x_m,y_m,heading_rad,commanded_m_s,commanded_rad_s";
        driven_trials("t.csv", &format!("{header}\n{rows}")).expect_err("refused").to_string()
    };
    insta::assert_snapshot!(error("a,1,0,0,0,0,0.1,0\n"), @"t.csv:2: trial `1` of a has one sample, expected 2 or more");
    insta::assert_snapshot!(error("a,1,0,0,0,0,0.1,0\na,1,0,0,0,0,0.1,0\n"), @"t.csv:3: trial `1` of a has two samples at 0 s");
    insta::assert_snapshot!(error("a,1,0,0,0,90,0.1,0\n"), @"t.csv:2: heading_rad is 90: this looks like degrees, expected radians");
    insta::assert_snapshot!(error("a,1,0,1200,0,0,0.1,0\n"), @"t.csv:2: x_m is 1200: this looks like mm, expected metres");
}

#[test]
fn a_trajectory_may_have_an_object_in_all_of_its_rows() {
    let header = "robot,trial,time_s,x_m,y_m,heading_rad,commanded_m_s,commanded_rad_s,object_x_m,object_y_m";
    let read = |rows: &str| driven_trials("t.csv", &format!("{header}\n{rows}"));
    let rows = "a,1,0,1,2,1.5707963267948966,0.1,0,1,2.3\na,1,1,1,2.1,1.57,0.1,0,0.9,2.35\n\
                a,2,0,0,0,0,0.1,0,,\na,2,1,0.1,0,0,0.1,0,,\n";

    let trials = read(rows).expect("the table is right");

    let [ahead_m, left_m] = trials[0].object_start_m().expect("it has an object");
    assert!((ahead_m - 0.3).abs() < 1e-9 && left_m.abs() < 1e-9, "{ahead_m} {left_m}");
    let moved = trials[0].of_object().expect("it has an object").displacement_at(1.0);
    assert!((moved.x_m - 0.05).abs() < 1e-9 && (moved.y_m - 0.1).abs() < 1e-9, "{moved:?}");
    assert!(trials[0].moves_object() && !trials[1].moves_object());
    assert_eq!((trials[1].object_start_m(), trials[1].of_object()), (None, None));
    let error = |rows: &str| read(rows).expect_err("refused").to_string();
    insta::assert_snapshot!(error("a,1,0,0,0,0,0.1,0,1,2\na,1,1,0,0,0,0.1,0,,\n"), @"t.csv:3: trial `1` of a has an object in some of its rows only");
    insta::assert_snapshot!(error("a,1,0,0,0,0,0.1,0,1,\n"), @"t.csv:2: object_y_m is not there, and the other coordinate of the object is");
    insta::assert_snapshot!(error("a,1,0,0,0,0,0.1,0,1200,2\n"), @"t.csv:2: object_x_m is 1200: this looks like mm, expected metres");
}

/// Two straight runs, a turn in place and a curve of one robot, 100 samples each.
fn driven() -> Vec<DrivenTrial> {
    [(0.1, 0.0), (0.2, 0.0), (0.0, -0.5), (0.1, 0.5)]
        .into_iter()
        .zip(1..)
        .map(|((speed_m_s, turn_rate_rad_s), trial)| {
            let command = Command { speed_m_s, turn_rate_rad_s };
            let gain = ActuationGain { speed: 0.9, turn: 0.8 };
            let mut pose = Pose { x_m: 1.0, y_m: 2.0, heading_rad: 0.5 };
            let samples = (0..100).map(|sample| {
                let now = pose;
                pose = step(pose, command, gain, 0.1);
                // The tracker writes a stop into the last sample.
                let command = if sample == 99 { Command::STOP } else { command };
                DrivenSample {
                    time_s: 7.0 + f64::from(sample) * 0.1,
                    pose: now,
                    command,
                    object_m: None,
                }
            });
            let samples = samples.collect();
            DrivenTrial { robot: "a".to_owned(), trial: trial.to_string(), going_s: 0.0, samples }
        })
        .collect()
}

#[test]
fn trajectories_become_straight_runs_turns_in_place_and_arcs() {
    let found = reduced("t.csv", &driven());

    let gains: Vec<f64> = found
        .speed
        .rows
        .iter()
        .map(|run| run.distance_m / run.duration_s / run.commanded_m_s)
        .collect();
    assert!(gains.iter().all(|gain| (gain - 0.9).abs() < 1e-9), "{gains:?}");
    assert!(found.speed.rows[0].lateral_m.is_some_and(|lateral_m| lateral_m.abs() < 1e-9));
    let turn = found.turn.rows[0];
    assert!((turn.angle_rad / turn.duration_s / turn.commanded_rad_s - 0.8).abs() < 1e-9);
    let arc = found.arc.rows[0];
    let gain = arc.turn.angle_rad / arc.turn.duration_s / arc.turn.commanded_rad_s;
    assert!(
        (gain - 0.8).abs() < 1e-9 && arc.commanded_m_s.to_bits() == 0.1_f64.to_bits(),
        "{arc:?}"
    );
    assert_eq!([found.speed.rows.len(), found.turn.rows.len(), found.arc.rows.len()], [2, 1, 1]);
    assert_eq!(found.left_out, []);
}

#[test]
fn noise_of_the_robot_is_distinguished_from_noise_of_the_tracker() {
    let mut draw = Draw::new(5);
    let (heading_sd_rad, step_sd, period_s) = (0.02, 0.3, 0.13);
    let command = Command { speed_m_s: 0.1, turn_rate_rad_s: 0.0 };
    let trials: Vec<DrivenTrial> = (0..30)
        .map(|trial| {
            let mut pose = Pose::default();
            let samples = (0..300).map(|sample| {
                // A tracker that is off by a centimetre and two degrees.
                let seen = Pose {
                    x_m: pose.x_m + draw.normal(0.0, 0.01),
                    y_m: pose.y_m + draw.normal(0.0, 0.01),
                    heading_rad: pose.heading_rad + draw.normal(0.0, 0.035),
                };
                let gain = ActuationGain { speed: 0.95 + draw.normal(0.0, step_sd), turn: 1.0 };
                pose = step(pose, command, gain, period_s);
                pose.heading_rad += draw.normal(0.0, heading_sd_rad);
                DrivenSample {
                    time_s: f64::from(sample) * period_s,
                    pose: seen,
                    command,
                    object_m: None,
                }
            });
            let samples = samples.collect();
            DrivenTrial { robot: "a".to_owned(), trial: trial.to_string(), going_s: 0.0, samples }
        })
        .collect();

    let found = step_noise(&trials, period_s).expect("there are trajectories");

    let covers = |estimate: Estimate, truth: f64| {
        estimate.low.is_some_and(|low| low <= truth)
            && estimate.high.is_some_and(|high| truth <= high)
    };
    // With the tracker's noise in it, it would be 0.053.
    assert!(covers(found.heading_noise_sd_rad, heading_sd_rad), "{found:?}");
    assert!(found.heading_noise_sd_rad.value < 0.03, "{found:?}");
    // With the tracker's noise in it, it would be 1.1.
    let speed = found.speed_step_sd.expect("they drove forward");
    assert!(covers(speed, step_sd) && speed.value < 0.6, "{found:?}");
}

#[test]
fn trials_in_which_commands_paused_are_no_rows() {
    let table = "robot,commanded_rad_s,angle_rad,duration_s,paused_s\n\
                 a,0.5,5.8,12,\na,0.5,3.1,12,0.445\nb,0.5,5.9,12,\n";

    let found = turn_trials("turn.csv", table).expect("the table is right");

    assert_eq!(found.rows.len(), 2);
    assert_eq!(found.paused, [3]);
}
