//! What is on the screen, at the sizes that people have.

use std::f64::consts::{FRAC_PI_2, TAU};
use std::time::Duration;

use ratatui::Terminal;
use ratatui::backend::TestBackend;
use ratatui::buffer::Buffer;
use ratatui::style::{Color, Modifier};
use rsrs_core::robot::controller::Command;
use rsrs_core::robot::pose_source::PoseSource;
use rsrs_core::robot::unicycle::Pose;
use rsrs_core::world::WorldFile;
use rsrs_fleet::message::{Echo, Lease, LeaseState, RobotState, Status, StopCause};
use rsrs_fleet::observation::{Event, Observation};
use rsrs_fleet::wire;
use rsrs_msgs::diagnostic_msgs::{DiagnosticArray, DiagnosticStatus};
use rsrs_testing::conditions::flockbot_conditions;
use rsrs_testing::record::fleet_record;

use super::look::{BannerKind, Colours, Look, Signs};
use super::screen::draw;
use super::view::{Banner, PlayState, Timeline, View};

/// Columns and rows.
const SIZES: [(u16, u16); 4] = [(60, 20), (80, 24), (120, 30), (200, 50)];
const PLAIN: Look = Look { colours: Colours::Off, signs: Signs::Unicode };
/// For how long the fleet of the tests has moved, in seconds.
const NOW_S: f64 = 20.0;

fn name(index: usize) -> String {
    format!("robot_{}", index + 1)
}

fn status(state: RobotState, stop_cause: StopCause, counter: u64) -> Status {
    let is_stopped = stop_cause == StopCause::EStop;
    Status {
        counter,
        epoch: 7,
        run_id: "run".to_owned(),
        parameter_digest: 1,
        state,
        stop_cause,
        stop_reason: if is_stopped { "e-stop".to_owned() } else { String::new() },
        battery_v: 7.4,
    }
}

/// A mill in its twentieth second, of which the second robot is held by the e-stop and the third one
/// is silent.
fn mill(n_robots: usize) -> Observation {
    let mut observation = Observation::default();
    let robots = 0..n_robots;
    for step in 0..=200_u32 {
        let time_s = f64::from(step) * 0.1;
        let now = Duration::from_secs_f64(time_s);
        let echo = |index| Echo { robot: name(index), counter: 1 };
        let lease = Lease {
            run_id: "flockbot_milling-20261123T082500-a1b2".to_owned(),
            epoch: 7,
            state: LeaseState::Running,
            parameter_digest: 1,
            robots: robots.clone().map(echo).collect(),
        };
        observation.on_event(Event::Lease(lease), now);
        for index in robots.clone() {
            let angle_rad = TAU * index as f64 / n_robots as f64 + 0.3 * time_s;
            let (sine, cosine) = libm::sincos(angle_rad);
            let pose = Pose { x_m: cosine, y_m: sine, heading_rad: angle_rad + FRAC_PI_2 };
            let robot = name(index);
            let command = Command { speed_m_s: 0.3, turn_rate_rad_s: 0.3 };
            let status = match index {
                1 => status(RobotState::Stopped, StopCause::EStop, u64::from(step) + 1),
                _ => status(RobotState::Moving, StopCause::None, u64::from(step) + 1),
            };
            let detected = index % 2 == 0;
            let pose = Event::Pose { robot: robot.clone(), source: PoseSource::Odom, pose };
            observation.on_event(pose, now);
            observation.on_event(Event::Command { robot: robot.clone(), command }, now);
            observation.on_event(Event::Detection { robot: robot.clone(), detected }, now);
            if index != 2 || step < 100 {
                observation.on_event(Event::Status { robot, status }, now);
            }
        }
    }
    observation
}

fn view(observation: &Observation) -> View<'_> {
    View {
        observation,
        now: Duration::from_secs_f64(NOW_S),
        order: observation.order(),
        place: "wlan0, domain 0",
        timeline: None,
        banner: None,
        first_row: 0,
        shows_help: false,
        look: PLAIN,
    }
}

fn drawn(view: &View<'_>, (width, height): (u16, u16)) -> Buffer {
    let mut terminal = Terminal::new(TestBackend::new(width, height)).expect("it is in memory");
    terminal
        .draw(|frame| {
            let area = frame.area();
            draw(view, area, frame.buffer_mut());
        })
        .expect("it is in memory");
    terminal.backend().buffer().clone()
}

fn rows(buffer: &Buffer) -> Vec<String> {
    let width = usize::from(buffer.area.width);
    let signs: Vec<&str> = buffer.content.iter().map(ratatui::buffer::Cell::symbol).collect();
    signs.chunks(width).map(<[&str]>::concat).collect()
}

/// The part of the screen beside the table.
fn beside_table(row: &str, of: &[String]) -> (String, String) {
    let head = of.iter().find(|row| row.contains(" from above ")).expect("the arena has a title");
    let start = head.chars().position(|sign| sign == '─').expect("its title has a line");
    (row.chars().take(start).collect(), row.chars().skip(start).collect())
}

#[test]
fn every_robot_is_listed_or_counted_at_every_size() {
    for n_robots in [9, 30] {
        let observation = mill(n_robots);
        for size in SIZES {
            let rows = rows(&drawn(&view(&observation), size));

            let n_listed = rows.iter().filter(|row| row.starts_with("robot_")).count();
            let n_more = n_robots - n_listed;
            let counted = format!("and {n_more} more: ");
            let is_counted = rows.iter().any(|row| row.starts_with(&counted));
            assert_eq!(n_more > 0, is_counted, "{n_robots} at {size:?}:\n{}", rows.join("\n"));
            assert!(rows[0].contains(&format!("{n_robots} robots, ")), "{}", rows[0]);
        }
    }
}

#[test]
fn scrolling_comes_past_every_robot_and_no_further() {
    let observation = mill(30);
    let mut seen = std::collections::BTreeSet::new();
    for first_row in [0, 10, 20, 1_000] {
        let view = View { first_row, ..view(&observation) };
        for row in rows(&drawn(&view, (60, 20))) {
            seen.extend(
                row.split_whitespace()
                    .next()
                    .filter(|it| it.starts_with("robot_"))
                    .map(str::to_owned),
            );
        }
    }

    assert_eq!(seen.len(), 30, "{seen:?}");
}

#[test]
fn nothing_lies_over_anything_else() {
    for n_robots in [9, 30] {
        let observation = mill(n_robots);
        for size in SIZES {
            let rows = rows(&drawn(&view(&observation), size));
            let page = rows.join("\n");

            let body = &rows[2..rows.len() - 1];
            for row in body {
                let (table, _) = beside_table(row, &rows);
                assert!(table.ends_with(' '), "the table touches the arena: {row}\n{page}");
            }
            let of_robot = |name: &str| {
                let row = body.iter().find(|row| row.starts_with(name)).expect("it is listed");
                beside_table(row, &rows).0.split_whitespace().map(str::to_owned).collect::<Vec<_>>()
            };
            let first = of_robot("robot_1 ");
            assert_eq!(first[..4], ["robot_1", "moving", "●", "10.0"], "{page}");
            assert_eq!(of_robot("robot_2 ")[1], "E-STOP", "{page}");
            assert_eq!(of_robot("robot_3 ")[1], "silent", "{page}");
            for whole in [" from above ", " the swarm ", "stable milling", "circliness 1.00"] {
                assert!(page.contains(whole), "{whole} at {size:?}:\n{page}");
            }
            assert!(rows[1].contains("RUNNING 20.0 s") && rows[1].contains("E-STOP holds 1 of"));
            assert!(rows[rows.len() - 1].contains("s stop all robots   q quit"), "{page}");
        }
    }
}

#[test]
fn every_robot_that_has_a_pose_is_in_the_arena() {
    let arrows = ["→", "↗", "↑", "↖", "←", "↙", "↓", "↘"];
    for (n_robots, size) in [(9, (60, 20)), (9, (80, 24)), (30, (200, 50))] {
        let observation = mill(n_robots);
        let rows = rows(&drawn(&view(&observation), size));

        let arena = rows[2..rows.len() - 1].iter().map(|row| beside_table(row, &rows).1);
        let arena: String = arena.collect();
        let n_arrows: usize = arrows.iter().map(|arrow| arena.matches(arrow).count()).sum();
        assert_eq!(n_arrows, n_robots, "{size:?}:\n{}", rows.join("\n"));
    }
}

#[test]
fn the_walls_of_an_arena_that_is_no_plain_square_are_around_the_robots() {
    let seen = |world: &str, signs| {
        let mut conditions = flockbot_conditions();
        conditions.world =
            WorldFile::parse("world.yaml", world, &[15.0], &[]).expect("it is a world");
        let record = fleet_record("0", conditions);
        let mut observation = mill(9);
        let now = Duration::from_secs_f64(NOW_S);
        observation.on_event(Event::Experiment(Box::new(record)), now);
        let look = Look { signs, ..PLAIN };
        let rows = rows(&drawn(&View { look, ..view(&observation) }, (120, 40)));
        rows[2..rows.len() - 3].to_vec()
    };
    let n_signs = |rows: &[String], is_one: fn(char) -> bool| {
        rows.iter().flat_map(|row| row.chars()).filter(|sign| is_one(*sign)).count()
    };
    let is_dot = |sign| ('\u{2801}'..='\u{28ff}').contains(&sign);

    let without = seen("goals: [{place_m: [0, 0], radius_m: 0.1}]", Signs::Unicode);
    let around = seen("arena: {disc_m: 2}", Signs::Unicode);
    let plain = seen("goals: [{place_m: [0, 0], radius_m: 0.1}]", Signs::Ascii);
    let pillar = seen("obstacles: [{place_m: [0, 0], radius_m: 0.4}]", Signs::Ascii);
    let n_points = |rows: &[String]| n_signs(rows, |sign| sign == '.');

    assert!(n_signs(&around, is_dot) > n_signs(&without, is_dot) + 40, "{around:#?}");
    assert!(n_points(&pillar) > n_points(&plain) + 10, "{pillar:#?}");
}

#[test]
fn a_wide_screen_has_every_column_and_a_narrow_one_the_first() {
    let observation = mill(9);
    let heads =
        [(200, 50), (60, 20)].map(|size| rows(&drawn(&view(&observation), size))[2].clone());

    let everything =
        ["robot", "state", "sees", "det", "cmd", "pose", "m/s", "batt", "lease", "why"];
    for column in everything {
        assert!(heads[0].contains(column), "{column}: {}", heads[0]);
    }
    assert!(!heads[1].contains("lease") && heads[1].contains("det"), "{}", heads[1]);
}

#[test]
fn what_further_sensors_report_stands_beside_the_detection() {
    let mut observation = mill(9);
    let now = Duration::from_secs_f64(NOW_S);
    let mut report = |index: usize, reading: &str, is_true, before_s: u64| {
        let (robot, reading) = (name(index), reading.to_owned());
        let at = now.saturating_sub(Duration::from_secs(before_s));
        observation.on_event(Event::Reading { robot, reading, is_true }, at);
    };
    report(0, "goal", true, 0);
    report(0, "wall", true, 0);
    report(1, "goal", false, 0);
    report(1, "wall", true, 0);
    report(3, "goal", false, 0);
    report(4, "wall", true, 5);

    let rows = rows(&drawn(&view(&observation), (120, 30)));

    let of = |index: usize| {
        let row = rows.iter().find(|row| row.starts_with(&format!("{} ", name(index))));
        row.unwrap_or_else(|| panic!("robot_{index}: {rows:#?}")).clone()
    };
    for (index, expected) in
        [(0, "● goal wall "), (1, "○ wall "), (3, "○  "), (4, "wall 5 s "), (6, "●  ")]
    {
        assert!(of(index).contains(expected), "{}", of(index));
    }
}

#[test]
fn a_line_that_nobody_should_overlook_is_whole_at_60_columns() {
    let observation = mill(9);
    let text = "30 of 30 robots stand (0.31 s); next: rsrs stop --release".to_owned();
    let banner = Some(Banner { text: text.clone(), kind: BannerKind::Done });

    let rows = rows(&drawn(&View { banner, ..view(&observation) }, (60, 20)));

    assert!(rows[2].contains(&text), "{}", rows[2]);
}

#[test]
fn what_robots_say_is_wrong_with_them_is_shown_while_they_say_so() {
    let mut observation = mill(9);
    let of = |name: &str, hardware: &str, level| DiagnosticStatus {
        level,
        name: name.to_owned(),
        message: "no answer".to_owned(),
        hardware_id: hardware.to_owned(),
        values: Vec::new(),
    };
    let status = vec![
        of("robot_2: serial driver", "robot_2", DiagnosticStatus::ERROR),
        of("motors", "robot_3", DiagnosticStatus::ERROR),
        of("camera", "nobody", DiagnosticStatus::ERROR),
        of("robot_4: gate", "", DiagnosticStatus::OK),
    ];
    let said = Duration::from_secs(90);
    let diagnoses = wire::diagnoses(DiagnosticArray { status, ..DiagnosticArray::default() });
    observation.on_event(Event::Diagnoses(diagnoses), said);

    let text = |seconds| {
        let banner = Banner::of_faults(&observation, said + Duration::from_secs(seconds));
        banner.map(|banner| banner.text)
    };
    assert_eq!(text(2).as_deref(), Some("robot_2: serial driver: no answer, and 1 more"));
    assert_eq!(text(20), None, "nobody says so any more");
    let repaired = vec![of("robot_2: serial driver", "robot_2", DiagnosticStatus::OK)];
    let diagnoses =
        wire::diagnoses(DiagnosticArray { status: repaired, ..DiagnosticArray::default() });
    observation.on_event(Event::Diagnoses(diagnoses), said);
    let banner = Banner::of_faults(&observation, said).expect("one is left");
    assert_eq!(banner.text, "robot_3: motors: no answer");
}

#[test]
fn a_recording_shows_how_far_it_is() {
    let observation = mill(9);
    let timeline = Timeline {
        at: Duration::from_secs(30),
        duration: Duration::from_secs(120),
        pace: 2.0,
        state: PlayState::Plays,
    };
    let view = View { timeline: Some(timeline), ..view(&observation) };

    let rows = rows(&drawn(&view, (80, 24)));

    let line = &rows[22];
    assert!(line.contains("▶ 0:30.0") && line.contains("2:00.0") && line.contains("x2"), "{line}");
    let (done, left) = (line.matches('━').count(), line.matches('─').count());
    assert!(done * 3 == left || done.abs_diff(left / 3) <= 1, "{line}");
    assert!(rows[23].contains("space pause") && !rows[23].contains("stop"), "{}", rows[23]);
}

#[test]
fn without_colours_nothing_is_coloured_and_alarms_stand_out() {
    let observation = mill(9);
    let buffer = drawn(&view(&observation), (80, 24));

    let is_plain =
        |cell: &ratatui::buffer::Cell| cell.fg == Color::Reset && cell.bg == Color::Reset;
    assert!(buffer.content.iter().all(is_plain));
    let row =
        rows(&buffer).iter().position(|row| row.starts_with("robot_2 ")).expect("it is listed");
    let state = buffer.cell((8, u16::try_from(row).expect("24 rows"))).expect("80 columns");
    assert!(state.symbol() == "E" && state.modifier.contains(Modifier::REVERSED), "{state:?}");
}

#[test]
fn with_plain_signs_there_are_no_others() {
    let observation = mill(30);
    let look = Look { colours: Colours::On, signs: Signs::Ascii };
    for shows_help in [false, true] {
        let view = View { shows_help, look, ..view(&observation) };

        let page = rows(&drawn(&view, (80, 24))).join("\n");

        assert!(page.is_ascii(), "{page}");
    }
}

#[test]
fn no_size_is_too_small_and_no_fleet_too_strange() {
    let nothing = Observation::default();
    let mut strange = mill(3);
    let far = Pose { x_m: 1e300, y_m: -1e300, heading_rad: 1e9 };
    let name = "a_name_that_is_longer_than_any_robot_has_ever_had\u{1b}[31m".to_owned();
    let pose = Event::Pose { robot: name, source: PoseSource::Pose, pose: far };
    strange.on_event(pose, Duration::from_secs_f64(NOW_S));
    for observation in [&nothing, &strange] {
        for shows_help in [false, true] {
            for width in [1, 10, 24, 30, 51, 52, 53, 60, 80, 300] {
                for height in [1, 2, 5, 6, 7, 10, 24, 100] {
                    let view = View { shows_help, ..view(observation) };

                    let page = rows(&drawn(&view, (width, height))).join("\n");

                    assert!(!page.contains('\u{1b}'));
                }
            }
        }
    }
}
