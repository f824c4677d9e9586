//! Pictures of steps 1 and 2. Each test leaves its picture in the target directory's
//! `tmp/pictures`, to be looked at.

mod readable;

use rsrs_core::conditions::Settings;
use rsrs_core::robot::controller::Command;
use rsrs_core::robot::harsher::HarsherFactors;
use rsrs_core::robot::profile::RobotProfile;
use rsrs_core::robot::unicycle::{ActuationGain, Pose, step};
use rsrs_core::trials::fit::{Fit, Tables, Unmeasured, fit};
use rsrs_core::trials::trial::{
    DrivenSample, DrivenTrial, MovedBy, detection_trials, period_trials, speed_trials, turn_trials,
};
use rsrs_core::trials::validation::{Tube, Validation};
use rsrs_sim::reachable_set::{ReachOptions, validate};
use rsrs_view::distribution::{self, DistributionPicture, DistributionPictureError, DrivenSpeed};
use rsrs_view::reachable_set::{self, ReachPicture, ReachPictureError, TubeMembership};
use rsrs_view::sensor::{self, SensorPicture, SensorPictureError};
use rsrs_view::theme::Theme;

macro_rules! kind {
    ($name:literal) => {
        [
            include_str!(concat!("../../../launch_configs/profiles/", $name, "_trials/speed.csv")),
            include_str!(concat!("../../../launch_configs/profiles/", $name, "_trials/turn.csv")),
            include_str!(concat!(
                "../../../launch_configs/profiles/",
                $name,
                "_trials/detection.csv"
            )),
            include_str!(concat!("../../../launch_configs/profiles/", $name, "_trials/period.csv")),
        ]
    };
}

fn fitted([speed, turn, detection, period]: [&str; 4], radius_m: f64) -> Fit {
    let tables = Tables {
        speed: &speed_trials("speed.csv", speed).expect("valid"),
        turn: &turn_trials("turn.csv", turn).expect("valid"),
        detection: &detection_trials("detection.csv", detection).expect("valid"),
        period: Some(&period_trials("period.csv", period).expect("valid")),
        driven: &[],
        arc: None,
        from_rest: &[],
        moved_by: MovedBy::default(),
    };
    fit(tables, &Unmeasured { radius_m, ..Unmeasured::default() })
        .expect("the trials that ship can be fitted")
}

fn keep(name: &str, svg: &str) {
    let pixmap = readable::keep(name, svg, 1000);
    let n_dark = pixmap.pixels().iter().filter(|pixel| pixel.red() < 100).count();
    assert!(n_dark > 2000, "{n_dark}");
}

fn distributions(fit: &Fit) -> DistributionPicture<'_> {
    DistributionPicture {
        speeds: &fit.speed,
        trials: &[],
        theme: Theme::Screen,
        title: "Measured speeds".to_owned(),
        subtitle: "flockbot · made-up trials with the means and deviations of tab:speed1"
            .to_owned(),
    }
}

#[test]
fn every_robot_has_its_distribution_in_the_panel_of_its_command() {
    let fit = fitted(kind!("flockbot"), 0.075);

    let trials: Vec<DrivenSpeed> = fit
        .speed
        .iter()
        .flat_map(|speed| {
            [-1.0, 0.0, 1.5].map(|sd| DrivenSpeed {
                robot: speed.robot.clone(),
                commanded_m_s: speed.commanded_m_s,
                measured_m_s: speed.mean_m_s + sd * speed.sd_m_s.unwrap_or(0.0),
            })
        })
        .collect();
    let picture = DistributionPicture { trials: &trials, ..distributions(&fit) };

    let svg = distribution::svg(&picture).expect("it can be drawn");

    keep("speed_distribution", &svg);
    assert_eq!(distribution::svg(&picture).as_ref(), Ok(&svg), "it is the same text again");
    assert_eq!(svg.matches("fill-opacity=\"0.75\"").count(), trials.len(), "a dot for each trial");
    assert!(svg.contains("commanded 0.025 m/s") && svg.contains("commanded 0.05 m/s"));
    assert_eq!(svg.matches("made_up_2: mean").count(), 2);
    assert!(svg.contains("made_up_1: mean 0.02215 m/s, standard deviation 0.00057 m/s, 5 trials"));
}

#[test]
fn one_trial_is_a_stroke_and_no_trial_is_refused() {
    let mut fit = fitted(kind!("flockbot"), 0.075);
    fit.speed.truncate(1);
    fit.speed[0].sd_m_s = None;

    let svg = distribution::svg(&distributions(&fit)).expect("it can be drawn");
    fit.speed.clear();

    assert!(svg.contains("one trial"));
    assert_eq!(distribution::svg(&distributions(&fit)), Err(DistributionPictureError::Empty));
}

#[test]
fn the_measured_polygon_is_blue_and_the_simulated_red() {
    for (name, trials, radius_m) in [
        ("sensor_flockbot", kind!("flockbot"), 0.075),
        ("sensor_smars", kind!("smars"), 0.06),
        ("sensor_lta", kind!("lta"), 0.3),
    ] {
        let fit = fitted(trials, radius_m);
        let picture = SensorPicture {
            map: &fit.details.sensor,
            simulated_m: &fit.sensor.polygon_m,
            radius_m,
            title: "What the sensor detects".to_owned(),
            subtitle: format!("{name} · made-up trials"),
            theme: Theme::Screen,
        };

        let svg = sensor::svg(&picture).expect("it can be drawn");

        keep(name, &svg);
        assert_eq!(sensor::svg(&picture).as_ref(), Ok(&svg), "it is the same text again");
        let place = |text: &str| svg.find(text).expect("it is drawn");
        assert!(place("stroke=\"#0072b2\"") < place("stroke=\"#c1121f\""));
        assert!(svg.contains("of 60 readings"));
    }
}

#[test]
fn a_sensor_without_a_region_is_refused() {
    let fit = fitted(kind!("flockbot"), 0.075);
    let picture = SensorPicture {
        map: &fit.details.sensor,
        simulated_m: &[],
        radius_m: 0.075,
        title: String::new(),
        subtitle: String::new(),
        theme: Theme::Screen,
    };

    let bodiless =
        SensorPicture { radius_m: 0.0, simulated_m: &fit.sensor.polygon_m, ..picture.clone() };

    assert!(matches!(sensor::svg(&picture), Err(SensorPictureError::Empty { n_corners: 0, .. })));
    assert_eq!(
        sensor::svg(&bodiless).expect_err("a body has a size").to_string(),
        "the body's radius in m is 0, expected a finite number above 0"
    );
}

/// Robots that drive a wide left curve for 30 s, the last of them too fast.
fn curves() -> Vec<DrivenTrial> {
    let command = Command { speed_m_s: 0.1, turn_rate_rad_s: 0.08 };
    let drive = |(robot, speed): (usize, f64)| {
        let mut pose = Pose::default();
        let samples = (0..=230).map(|sample| {
            let now = pose;
            pose = step(pose, command, ActuationGain { speed, turn: 0.97 }, 0.13);
            DrivenSample { time_s: f64::from(sample) * 0.13, pose: now, command, object_m: None }
        });
        let samples = samples.collect();
        DrivenTrial {
            robot: format!("robot_{robot}"),
            trial: "1".to_owned(),
            going_s: 0.0,
            samples,
        }
    };
    [0.93, 0.97, 1.0, 1.25].into_iter().enumerate().map(drive).collect()
}

fn validated(trials: &[DrivenTrial]) -> Validation {
    let text = include_str!("../../../launch_configs/profiles/smars.yaml");
    let mut measured = RobotProfile::parse("smars.yaml", text).expect("it is valid");
    measured.actuation.speed.robot_sd = 0.02;
    let robot = HarsherFactors::default().apply(&measured).expect("the defaults are harsher");
    let options = ReachOptions { n_robots: 1000, n_horizons: 6, ..ReachOptions::default() };
    validate(&robot, &Settings::default(), trials, &options).expect("it can be simulated")
}

fn tube_picture<'a>(
    tube: &'a Tube,
    trials: &'a [(&'a DrivenTrial, TubeMembership)],
) -> ReachPicture<'a> {
    ReachPicture {
        tube,
        trials,
        title: "Simulated reach and real trajectories".to_owned(),
        subtitle: "0.1 m/s · 0.08 rad/s · 99 % at each time".to_owned(),
        theme: Theme::Screen,
    }
}

#[test]
fn trajectories_lie_over_the_tube_and_those_outside_are_red() {
    let trials = curves();
    let found = validated(&trials);
    let places: Vec<(&DrivenTrial, TubeMembership)> = trials
        .iter()
        .zip(&found.trials)
        .map(|(trial, place)| (trial, TubeMembership::new(&place.exits)))
        .collect();

    let picture = tube_picture(&found.tubes[0], &places);
    let svg = reachable_set::svg(&picture).expect("it can be drawn");

    keep("reach", &svg);
    assert_eq!(reachable_set::svg(&picture).as_ref(), Ok(&svg), "it is the same text again");
    assert!(svg.contains("3 trials inside") && svg.contains("1 trial outside"), "{found:?}");
}

#[test]
fn a_tube_without_horizons_is_refused() {
    let mut tube = validated(&curves()).tubes.remove(0);

    tube.horizons.truncate(1);
    tube.horizons[0].region.loops_m[0][0][0] = f64::NAN;
    let lost = reachable_set::svg(&tube_picture(&tube, &[])).expect_err("it is nowhere");
    tube.horizons.clear();

    assert!(matches!(lost, ReachPictureError::NotFinite { .. }));
    assert_eq!(reachable_set::svg(&tube_picture(&tube, &[])), Err(ReachPictureError::Empty));
}

#[test]
fn many_robots_with_long_names_can_be_read() {
    let mut fit = fitted(kind!("flockbot"), 0.075);
    let one = fit.speed[0].clone();
    fit.speed = (1..=12)
        .flat_map(|robot| {
            let of = |commanded_m_s: f64, mean_m_s: f64| {
                let robot = format!("turtlebot_of_the_laboratory_{robot}");
                rsrs_core::trials::fit::SpeedFit { robot, commanded_m_s, mean_m_s, ..one.clone() }
            };
            let slower = 1.0 - 0.01 * f64::from(robot);
            [0.025, 0.1, 0.2, 0.3].map(|speed| of(speed, speed * slower))
        })
        .collect();
    let picture = DistributionPicture {
        title: "Measured speeds of twelve robots, of which each has a long name of its own, and a \
                long title"
            .to_owned(),
        ..distributions(&fit)
    };

    let svg = distribution::svg(&picture).expect("it can be drawn");

    keep("speed_distribution_of_many", &svg);
}
