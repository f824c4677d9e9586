//! Pictures of one run. Each test leaves its picture in the target directory's `tmp/pictures`, to
//! be looked at.

use std::path::Path;

use libm::sincos;
use resvg::tiny_skia::Pixmap;
use rsrs_core::judge::phase::Phase;
use rsrs_core::judge::trajectory::Trajectory;
use rsrs_core::robot::controller::Command;
use rsrs_core::robot::unicycle::Pose;
use rsrs_view::raster::png;
use rsrs_view::trajectory::{TrajectoryPicture, TrajectoryPictureError, svg};

/// Nine robots that spiral from a wide disc onto a ring of 0.9 m about (0.3, -0.2) m.
fn mill(duration_s: f64) -> Trajectory {
    run(duration_s, |robot, time_s| {
        let settled = 1.0 - libm::exp(-time_s / 25.0);
        let radius_m = 0.9 * settled + (1.0 - settled) * (0.25 + 0.06 * robot);
        let angle = robot * std::f64::consts::TAU / 9.0 + 0.165 * time_s;
        let (sine, cosine) = sincos(angle);
        Pose {
            x_m: 0.3 * settled + radius_m * cosine,
            y_m: -0.2 * settled + radius_m * sine,
            heading_rad: angle + std::f64::consts::FRAC_PI_2,
        }
    })
}

fn run(duration_s: f64, pose: impl Fn(f64, f64) -> Pose) -> Trajectory {
    let mut trajectory = Trajectory::new(0.13, 9);
    let mut time_s = 0.0;
    while time_s < duration_s {
        for robot in 0..9 {
            trajectory.poses.push(pose(f64::from(robot), time_s));
            trajectory.commands.push(Command { speed_m_s: 0.15, turn_rate_rad_s: -0.75 });
        }
        time_s += 0.13;
    }
    trajectory
}

fn picture(trajectory: &Trajectory, phase: Option<Phase>) -> TrajectoryPicture<'_> {
    TrajectoryPicture {
        trajectory,
        radius_m: 0.075,
        tail_s: 20.0,
        phase,
        title: "Nine Flockbots, one run".to_owned(),
        subtitle: "0.15 m/s · 0.75 rad/s · 300 s · seed 42".to_owned(),
    }
}

fn draw(name: &str, picture: &TrajectoryPicture) -> String {
    let svg = svg(picture).expect("the run can be drawn");
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("pictures");
    std::fs::create_dir_all(&folder).expect("the target directory can be written");
    std::fs::write(folder.join(name).with_extension("svg"), &svg).expect("as above");
    let png = png(&svg, 960).expect("the SVG can be rasterised");
    std::fs::write(folder.join(name).with_extension("png"), &png).expect("as above");
    let pixmap = Pixmap::decode_png(&png).expect("the PNG can be read");
    let n_dark = pixmap.pixels().iter().filter(|pixel| pixel.red() < 100).count();
    assert!(n_dark > 2000, "{n_dark}");
    svg
}

#[test]
fn a_mill_gets_its_ring_and_stays_small() {
    let svg = draw("mill", &picture(&mill(300.0), Some(Phase::StableMilling)));

    assert!(svg.contains("mean radius 0.90 m") && svg.contains("stable milling"));
    assert!(svg.contains("0.5 m"), "the scale bar");
    assert!(svg.len() < 70_000, "{}", svg.len());
}

#[test]
fn robots_that_left_get_no_ring() {
    let away = run(60.0, |robot, time_s| {
        let heading_rad = robot * std::f64::consts::TAU / 9.0 + 0.01 * time_s;
        let (sine, cosine) = sincos(heading_rad);
        Pose { x_m: 0.15 * time_s * cosine, y_m: 0.06 * time_s * sine, heading_rad }
    });

    let svg = draw("left", &picture(&away, Some(Phase::Dispersion)));

    assert!(!svg.contains("mean radius") && !svg.contains("stroke-dasharray"));
}

#[test]
fn a_single_sample_is_drawn() {
    let svg = draw("start", &picture(&mill(0.1), None));

    assert!(svg.contains("the last 0.13 s"));
}

#[test]
fn runs_that_cannot_be_drawn_are_refused() {
    let none = Trajectory::new(0.13, 9);
    let mut lost = mill(1.0);
    lost.poses[12].y_m = f64::NAN;
    let run = mill(1.0);
    let bodiless = TrajectoryPicture { radius_m: 0.0, ..picture(&run, None) };

    assert_eq!(
        svg(&picture(&none, None)),
        Err(TrajectoryPictureError::Empty { n_samples: 0, n_robots: 9 })
    );
    assert!(matches!(
        svg(&picture(&lost, None)),
        Err(TrajectoryPictureError::PoseNotFinite { sample: 1, robot: 3, .. })
    ));
    assert_eq!(
        svg(&bodiless).expect_err("a body has a size").to_string(),
        "the body's radius in m is 0; expected a positive number"
    );
}
