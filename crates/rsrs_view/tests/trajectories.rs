//! Pictures of one run. Each test leaves its picture in the target directory's `tmp/pictures`, to
//! be looked at.

mod readable;

use libm::sincos;
use readable::keep;
use rsrs_core::judge::behaviour::Behaviour;
use rsrs_core::judge::order::OrderParameters;
use rsrs_core::judge::phase::Phase;
use rsrs_core::judge::trajectory::{Bodies, Trajectory};
use rsrs_core::judge::window::{BLOCK_S, samples_in};
use rsrs_core::robot::controller::Command;
use rsrs_core::robot::unicycle::Pose;
use rsrs_view::film::{Film, Kind, film, frame_svg};
use rsrs_view::gallery;
use rsrs_view::order_over_time::{self, OrderPicture, RunPicture, order_svg};
use rsrs_view::theme::Theme;
use rsrs_view::trajectory::{PoseNotFinite, TrajectoryPicture, TrajectoryPictureError, svg};

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

/// Names of nine robots, of which one has no number.
fn names() -> Vec<String> {
    let mut names: Vec<String> = (1..=9).map(|robot| format!("flockbot_{robot}")).collect();
    "Alice".clone_into(&mut names[3]);
    names
}

fn picture(trajectory: &Trajectory, phase: Option<Phase>) -> TrajectoryPicture<'_> {
    TrajectoryPicture {
        trajectory,
        radius_m: 0.075,
        tail_s: 20.0,
        phase,
        lost: &[],
        names: &[],
        walls_m: None,
        world: None,
        classes: &[],
        theme: Theme::Screen,
        title: "Nine Flockbots, one run".to_owned(),
        subtitle: "0.15 m/s · 0.75 rad/s · 300 s · seed 42".to_owned(),
    }
}

fn draw(name: &str, picture: &TrajectoryPicture) -> String {
    let [text, again] = [(); 2].map(|()| svg(picture).expect("the run can be drawn"));
    assert_eq!(text, again, "it is the same text again");
    let pixmap = keep(name, &text, 960);
    let n_dark = pixmap.pixels().iter().filter(|pixel| pixel.red() < 100).count();
    assert!(n_dark > 2000, "{n_dark}");
    text
}

#[test]
fn a_mill_gets_its_ring() {
    let (run, names) = (mill(300.0), names());
    let picture = TrajectoryPicture { names: &names, ..picture(&run, Some(Phase::STABLE_MILLING)) };

    let svg = draw("mill", &picture);

    assert!(svg.contains("ring: mean radius 0.90 m"));
    assert!(svg.contains(">Alice</text>") && svg.contains(">9</text>"), "robots have their names");
    assert!(svg.contains("0.5 m"), "the scale bar");
}

#[test]
fn robots_that_left_get_no_ring() {
    let away = run(60.0, |robot, time_s| {
        let heading_rad = robot * std::f64::consts::TAU / 9.0 + 0.01 * time_s;
        let (sine, cosine) = sincos(heading_rad);
        Pose { x_m: 0.15 * time_s * cosine, y_m: 0.06 * time_s * sine, heading_rad }
    });

    let svg = draw("left", &picture(&away, Some(Phase::DISPERSION)));

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
        Err(TrajectoryPictureError::PoseNotFinite(PoseNotFinite { sample: 1, robot: 3, .. }))
    ));
    assert_eq!(
        svg(&bodiless).expect_err("a body has a size").to_string(),
        "the body's radius in m is 0; expected a positive number"
    );
}

#[test]
fn order_parameters_are_drawn_beside_the_run_with_their_bounds() {
    let mill = mill(120.0);
    let bodies = Bodies { radius_m: Some(0.075), reach_m: Some(0.9), ..Bodies::UNKNOWN };
    let n_block = samples_in(BLOCK_S, mill.period_s);
    let block = |number: usize| {
        let samples = number * n_block..(number + 1) * n_block;
        (samples.start as f64 * mill.period_s, OrderParameters::new(&mill, samples, &bodies))
    };
    let blocks: Vec<(f64, OrderParameters)> = (0..mill.n_samples() / n_block).map(block).collect();
    let notes = ["robot_5 left the ring at 212 s".to_owned()];
    let picture = RunPicture {
        run: picture(&mill, Some(Phase::STABLE_MILLING)),
        order: OrderPicture {
            blocks: &blocks,
            block_s: BLOCK_S,
            duration_s: mill.duration_s(),
            judged_s: [60.0, mill.duration_s()],
            rules: &Behaviour::MILLING.rules(),
            notes: &notes,
        },
    };

    let svg = order_over_time::svg(&picture).expect("the run can be drawn");

    for text in ["circliness (stable milling: 0.50 or more)", "robot_5 left the ring at 212 s"] {
        assert!(svg.contains(text), "{text}");
    }
    keep("run_with_order_parameters", &svg, 960);
    assert_eq!(order_over_time::svg(&picture).as_ref(), Ok(&svg), "it is the same text again");
    let alone = order_svg(&picture.order, "order parameters of run_1");
    let right_px = alone.corner_px.0 + alone.curves_px.0;
    assert!(right_px < alone.size_px.0 && right_px > 0.9 * alone.size_px.0, "{right_px}");
    keep("order_parameters", &alone.svg, 960);
    let again = order_svg(&picture.order, "order parameters of run_1");
    assert_eq!(alone.svg, again.svg, "it is the same text again");
}

/// A mill that one robot leaves, straight away from it.
fn torn(duration_s: f64) -> Trajectory {
    let mut torn = mill(duration_s);
    for (sample, pose) in torn.poses.iter_mut().step_by(9).enumerate() {
        let away_m = 0.15 * 0.13 * sample as f64;
        *pose = Pose { x_m: 1.2 + away_m, y_m: -0.2, heading_rad: 0.0 };
    }
    torn
}

const LONG_TITLE: &str = "run_2026-11-23T08-41-00Z_nine_flockbots_on_the_large_floor_with_lids: semi-stable \
                          milling (not settled: look again)";

#[test]
fn a_ring_that_is_torn_stays_off_the_words() {
    let torn = torn(120.0);
    let picture = TrajectoryPicture {
        lost: &[0],
        names: &names(),
        walls_m: Some(1.3),
        world: None,
        classes: &[],
        title: LONG_TITLE.to_owned(),
        ..picture(&torn, Some(Phase::SEMI_STABLE_MILLING))
    };

    draw("torn", &picture);
}

#[test]
fn all_walls_are_shown_of_an_arena_that_is_not_much_wider_than_what_was_driven_over() {
    let run = mill(60.0);
    let sides = |svg: &str| {
        let walls =
            svg.split("<path d=\"").find(|path| path.contains("#8a6d4b")).map(str::to_owned);
        walls.map_or(0, |path| path.matches(['H', 'V']).count())
    };
    let above = |walls_m| svg(&TrajectoryPicture { walls_m, ..picture(&run, None) });
    let filmed = |walls_m| frame_svg(&Film { walls_m, ..film_of(&run) }, 0);

    for (walls_m, n_sides) in [(Some(1.6), 4), (Some(7.5), 0), (None, 0)] {
        assert_eq!(sides(&above(walls_m).expect("it can be drawn")), n_sides, "{walls_m:?}");
        assert_eq!(sides(&filmed(walls_m).expect("it can be drawn")), n_sides, "{walls_m:?}");
    }
}

#[test]
fn a_gallery_can_be_read_and_has_the_same_text_again() {
    let (mill, torn) = (mill(60.0), torn(60.0));
    let runs = [&mill, &torn, &mill, &torn, &mill];
    let named = ["milling", "partly spread out", "wall following", "other", "other"];
    let words = "partly circling, farther than twice the reach from their centre, half of them in one \
                 cluster, blocking each other";
    let pictures: Vec<TrajectoryPicture> = runs
        .iter()
        .zip(named)
        .zip(1..)
        .map(|((trajectory, name), number)| TrajectoryPicture {
            title: format!("{number}: {name}"),
            subtitle: format!("98.5 % of runs; {words}"),
            theme: Theme::Screen,
            ..picture(trajectory, (number == 1).then_some(Phase::STABLE_MILLING))
        })
        .collect();
    let drawn = || gallery::svg("What 9 robots can do", &pictures, 3).expect("it can be drawn");

    let svg = drawn();

    keep("gallery", &svg, 960);
    assert_eq!(svg, drawn());
    assert_eq!(svg.matches(": other</text>").count(), 2);
}

#[test]
fn every_frame_of_a_film_can_be_read_and_has_the_same_text_again() {
    for (name, trajectory) in [("film_of_a_mill", mill(60.0)), ("film_of_a_torn_mill", torn(60.0))]
    {
        let names = names();
        let film = Film {
            title: LONG_TITLE.to_owned(),
            width_px: 480,
            names: &names,
            ..film_of(&trajectory)
        };
        assert!(film.n_frames() > 25, "{}", film.n_frames());

        for frame in 0..film.n_frames() {
            let svg = frame_svg(&film, frame).expect("it can be drawn");

            readable::assert_readable(&format!("{name}, frame {frame}"), &svg);
            assert_eq!(svg, frame_svg(&film, frame).expect("as before"), "frame {frame}");
        }
        keep(name, &frame_svg(&film, film.n_frames() / 2).expect("as before"), 960);
    }
}

/// A short and small film.
fn film_of(trajectory: &Trajectory) -> Film<'_> {
    Film {
        trajectory,
        radius_m: 0.075,
        title: "Nine Flockbots".to_owned(),
        speed: 10.0,
        frames_per_s: 5,
        captions: &[],
        tail_s: 5.0,
        width_px: 160,
        lost: &[3],
        names: &[],
        walls_m: Some(2.0),
        world: None,
        classes: &[],
    }
}

#[test]
fn a_film_states_what_is_known_at_each_time_and_not_what_comes_later() {
    let mill = mill(12.0);
    let captions = [(4.0, "so far: unformed".to_owned()), (8.0, "stable milling".to_owned())];
    let of = Film { captions: &captions, ..film_of(&mill) };
    let frame = |time_s: usize| frame_svg(&of, time_s / 2).expect("it can be drawn");

    assert!(frame(2).contains(">2 s<"), "{}", frame(2));
    assert!(frame(4).contains(">4 s<") && frame(4).contains(">so far: unformed<"), "{}", frame(4));
    assert!(frame(8).contains(">8 s<") && frame(8).contains(">stable milling<"), "{}", frame(8));
}

#[test]
fn a_film_has_its_frames_and_the_same_bytes_again() {
    let mill = mill(12.0);
    let of = film_of(&mill);
    let done = |_| true;

    let gif = film(&of, Kind::Gif, &done).expect("it is filmed").expect("it is not called off");
    let again = film(&of, Kind::Gif, &done).expect("it is filmed");
    let apng = film(&of, Kind::Apng, &done).expect("it is filmed").expect("it is not called off");

    assert_eq!(Some(&gif), again.as_ref());
    let mut decoder = ::gif::Decoder::new(&gif[..]).expect("it is a GIF");
    assert_eq!(decoder.width(), 160);
    let mut n_frames = 0;
    while decoder.read_next_frame().expect("the GIF is whole").is_some() {
        n_frames += 1;
    }
    assert_eq!((n_frames, of.n_frames()), (7, 7));
    let reader = ::png::Decoder::new(std::io::Cursor::new(apng)).read_info().expect("it is a PNG");
    let control = reader.info().animation_control.expect("it moves");
    assert_eq!((reader.info().width, control.num_frames), (160, 7));
}

#[test]
fn films_that_make_no_sense_are_refused_and_others_can_be_called_off() {
    let mill = mill(12.0);
    let none = Trajectory::new(0.13, 9);
    let error = |of: &Film| film(of, Kind::Gif, &|_| true).expect_err("it is refused").to_string();

    assert_eq!(error(&film_of(&none)), "the trajectory has no samples, expected 1 or more");
    assert_eq!(
        error(&Film { speed: f64::NAN, ..film_of(&mill) }),
        "the speed of the film is NaN, expected a positive number"
    );
    assert_eq!(
        error(&Film { width_px: 5000, ..film_of(&mill) }),
        "the width in px is 5000, expected 64 to 2048"
    );
    assert_eq!(film(&film_of(&mill), Kind::Gif, &|done| done < 2).expect("called off"), None);
}
