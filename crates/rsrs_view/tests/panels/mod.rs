//! Pictures of several panels, and that all of them can be read on any page.

use rsrs_core::diagram::{DiagramCell, PhaseDiagram};
use rsrs_core::judge::counts::PhaseCounts;
use rsrs_core::judge::phase::Phase;
use rsrs_core::quantity::{Axis, Cell};
use rsrs_core::robot::unicycle::Pose;
use rsrs_core::statistics::share::Share;
use rsrs_core::world::WorldFile;
use rsrs_view::curves::{self, Curve, CurvesPicture, UprightBoundary};
use rsrs_view::diagram::{Boundary, DiagramPicture, ExperimentMark, Panel, Side, svg};
use rsrs_view::placement::{self, Area, PlacementPicture};
use rsrs_view::theme::Theme;

use super::readable::{self, keep};
use super::{cell, default_diagram, draw, plain};

/// The same diagram for several numbers of robots.
pub fn three_axes(robots: &[f64]) -> PhaseDiagram {
    let mut cells = Vec::new();
    for robots in robots {
        for entry in default_diagram().cells {
            let cell = Cell::new([(Axis::Robots, *robots)].into_iter().chain(entry.cell.iter()));
            cells.push(DiagramCell { cell: cell.expect("three finite values"), ..entry });
        }
    }
    PhaseDiagram { axes: vec![Axis::Robots, Axis::Speed, Axis::TurnRate], cells }
}

#[test]
#[should_panic(expected = "a line runs through")]
fn a_line_through_a_text_is_found() {
    let through = "<path d=\"M0 50h200\" fill=\"none\" stroke=\"#000000\"/>";
    let svg = |line: &str| {
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"200\" height=\"100\">\
             <text x=\"20\" y=\"55\" font-size=\"20\">milling</text>{line}</svg>"
        )
    };

    readable::assert_readable("no line", &svg(""));
    readable::assert_readable("a line", &svg(through));
}

#[test]
fn pages_of_curves_can_be_read() {
    let curve = |heading: &str, axis| Curve {
        heading: heading.to_owned(),
        axis,
        behaviour: rsrs_core::judge::behaviour::Behaviour::MILLING,
        points: (0..9).map(|at| (0.05 + 0.03 * f64::from(at), Share { hits: 7, n: 9 })).collect(),
        range: Some([0.08, 0.2]),
        marked: Some(0.15),
        boundaries: vec![UprightBoundary {
            value: 0.12,
            label: "ideal ring: the robot ahead is in reach".to_owned(),
            holds: Side::Right,
        }],
        compared: None,
        real: vec![(0.11, Share { hits: 2, n: 3 })],
    };
    let picture = CurvesPicture {
        theme: Theme::Screen,
        title: "Nine Flockbots: what they need".to_owned(),
        subtitles: vec!["robots made worse, 100 runs each".to_owned()],
        details: "seed 42".to_owned(),
        curves: vec![
            curve("How fast?", Axis::Speed),
            curve("How sharply turning may they be, at most?", Axis::TurnRate),
            curve("How alike?", Axis::Heterogeneity),
            curve("How good are the sensors?", Axis::TruePositive),
        ],
        marked: "recommended",
        wanted: Some((0.8, "viable: 80 % of the runs mill".to_owned())),
        width_px: None,
    };

    let svg = curves::svg(&picture).unwrap();
    keep("curves", &svg, 1600);
    for (name, width_px) in [("curves_88_mm", 332.6), ("curves_180_mm", 680.3)] {
        let svg = curves::svg(&CurvesPicture { width_px: Some(width_px), ..picture.clone() });
        keep(name, &svg.unwrap(), 1600);
    }

    assert!(svg.contains("in reach, holds right of the line"));
}

#[test]
fn the_last_number_below_a_curve_keeps_the_margin_of_its_page() {
    let swept = |at: u32| DiagramCell {
        cell: cell(&format!("speed_m_s={}", 0.05 + 0.05 * f64::from(at))),
        counts: PhaseCounts::new([Phase::STABLE_MILLING; 9]),
    };
    let diagram = PhaseDiagram { axes: vec![Axis::Speed], cells: (0..6).map(swept).collect() };
    let picture = DiagramPicture { x: Axis::Speed, y: None, ..plain(&diagram) };
    for (name, width_px) in [("curve_60_mm", 226.8), ("curve_88_mm", 332.6)] {
        let svg = draw(name, &DiagramPicture { width_px: Some(width_px), ..picture.clone() }).0;

        let right_px = f64::from(readable::assert_readable(name, &svg));
        assert!(right_px <= width_px - 7.5, "{name}: {right_px} of {width_px} px");
    }
}

#[test]
fn a_start_can_be_read() {
    let at = |index: u32| {
        let (sine, cosine) = libm::sincos(f64::from(index) * 0.7);
        let pose = Pose { x_m: 0.6 * cosine, y_m: 0.6 * sine, heading_rad: f64::from(index) };
        (format!("robot_{index}"), pose)
    };
    let robots: Vec<(String, Pose)> = (1..=9).map(at).collect();

    let svg = placement::svg(&PlacementPicture {
        robots: &robots,
        area: Area::Disc { radius_m: 0.825 },
        radius_m: 0.075,
        objects: &[],
        world: &WorldFile::NOTHING,
        walls_m: None,
        theme: Theme::Screen,
        title: "Where the robots start".to_owned(),
        subtitle: "9 robots".to_owned(),
    });

    keep("start", &svg, 1600);
}

#[test]
fn several_panels_share_a_legend_and_fit_any_page() {
    let diagram = three_axes(&[5.0, 6.0, 7.0, 8.0, 9.0]);
    let line = |label: &str, slope: f64| Boundary {
        label: label.to_owned(),
        points: vec![(0.0, 0.0), (0.4, 0.4 * slope)],
        holds: Side::Below,
    };
    let panel = |robots: f64, heading: String| Panel {
        heading,
        at: vec![(Axis::Robots, robots)],
        boundaries: vec![line("in reach", 1.2 + robots), line("apart", 30.0 / robots)],
        ..Panel::new(&diagram)
    };
    let chosen = cell("robots=9,speed_m_s=0.15,turn_rate_rad_s=0.75");
    let at = cell("robots=6,speed_m_s=0.15,turn_rate_rad_s=0.75");
    let names = vec!["monday".to_owned(), "tuesday".to_owned()];
    let nine = |phase, n| ExperimentMark {
        cell: chosen.clone(),
        phase,
        is_settled: true,
        is_simulated: false,
        n,
        names: Vec::new(),
    };
    let experiments = [
        ExperimentMark {
            cell: at,
            phase: Phase::UNFORMED,
            is_settled: false,
            is_simulated: true,
            n: 2,
            names,
        },
        nine(Phase::STABLE_MILLING, 12),
        nine(Phase::UNFORMED, 1),
    ];
    for (name, width_px, robots) in [
        ("panels", None, &[5.0, 6.0, 7.0, 8.0, 9.0][..]),
        ("panels_180_mm", Some(680.0), &[6.0, 9.0]),
        ("panels_88_mm", Some(332.6), &[6.0, 9.0]),
        ("one_88_mm", Some(332.6), &[9.0]),
        ("one_60_mm", Some(226.8), &[9.0]),
        ("one_400_mm", Some(1512.0), &[9.0]),
    ] {
        let is_alone = robots.len() == 1;
        let heading =
            |robots: f64| if is_alone { String::new() } else { format!("{robots} robots") };
        let picture = DiagramPicture {
            panels: robots.iter().map(|robots| panel(*robots, heading(*robots))).collect(),
            chosen: Some(&chosen),
            chosen_note: Some("confirmed: 88 % of 1,000 fresh runs mill (86 to 90 %)".to_owned()),
            // Its cells are too small for symbols.
            experiments: if name == "one_60_mm" { &[] } else { &experiments },
            width_px,
            ..plain(&diagram)
        };

        let (svg, _) = draw(name, &picture);

        assert_eq!(svg.matches(">Theory<").count(), 1, "{name}");
        assert_eq!(svg.matches("robots</text>").count(), robots.len() + 1, "{name}");
        if let Some(width_px) = width_px {
            assert!(
                svg.contains(&format!(
                    "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width_px}\""
                )),
                "{name}"
            );
        }
    }
    let narrow = DiagramPicture { width_px: Some(100.0), ..plain(&diagram) };
    let error = svg(&narrow).unwrap_err();
    assert_eq!(error.to_string(), "the page is 100 px wide, expected 226 px or more");
}

#[test]
fn long_headings_are_wrapped_above_their_panels() {
    let diagram = three_axes(&[6.0, 9.0]);
    let line = Boundary {
        label: "in reach".to_owned(),
        points: vec![(0.0, 0.0), (0.4, 0.4 * 7.0)],
        holds: Side::Below,
    };
    let panel = |(robots, angle): (f64, &str), boundaries: &[Boundary]| Panel {
        heading: format!("{robots} robots, half-angle of the sensor {angle}"),
        at: vec![(Axis::Robots, robots)],
        boundaries: boundaries.to_vec(),
        ..Panel::new(&diagram)
    };
    let slices = [(6.0, "0.1 rad (5.7°)"), (9.0, "0.1 rad (5.7°)"), (6.0, "1 rad"), (9.0, "1 rad")];
    for (name, width_px, boundaries) in [
        ("headings", None, &[line.clone()][..]),
        ("headings_without_lines", None, &[]),
        ("headings_180_mm", Some(680.0), std::slice::from_ref(&line)),
        ("headings_88_mm", Some(332.6), std::slice::from_ref(&line)),
        ("headings_60_mm", Some(226.8), &[]),
    ] {
        let panels = slices.iter().map(|slice| panel(*slice, boundaries)).collect();

        // It asserts that no text lies on another one or leaves the page.
        let (svg, _) = draw(name, &DiagramPicture { panels, width_px, ..plain(&diagram) });

        assert_eq!(svg.matches(">6 robots,").count(), 2, "{name}");
    }
}
