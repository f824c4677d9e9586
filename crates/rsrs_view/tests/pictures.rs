//! Whole pictures, from data to pixels. Each test leaves its picture in the target directory's
//! `tmp/pictures`, to be looked at.

mod panels;
mod readable;

use readable::keep;
use resvg::tiny_skia::{Pixmap, PremultipliedColorU8};
use rsrs_core::diagram::{DiagramCell, PhaseDiagram};
use rsrs_core::help::Help;
use rsrs_core::judge::behaviour::Behaviour;
use rsrs_core::judge::counts::PhaseCounts;
use rsrs_core::judge::phase::Phase;
use rsrs_core::quantity::{Axis, AxisValues, Cell};
use rsrs_view::diagram::{
    Boundary, CellValues, DiagramPicture, ExperimentMark, Numbers, Panel, Side, ValueScale, svg,
};
use rsrs_view::theme::Theme;

/// A made-up world of 16 replicates per cell in which the mill has a best radius.
fn counts(speed_m_s: f64, turn_rate_rad_s: f64) -> PhaseCounts {
    let ring_m = speed_m_s / turn_rate_rad_s;
    let off = libm::log(ring_m / 0.2).abs();
    let mut counts = PhaseCounts::default();
    let of_16 = |share: f64| (1_u64..=16).filter(|n| *n as f64 <= 16.0 * share).count();
    let stable = of_16(1.3 - off * 2.2 - (speed_m_s - 0.15).abs() * 4.0) as u64;
    let semi = (of_16(1.6 - off * 1.8) as u64).min(16 - stable);
    let unformed = u64::from(semi > 3 && speed_m_s > 0.2) * (16 - stable - semi);
    let rest = 16 - stable - semi - unformed;
    counts.add_many(Phase::STABLE_MILLING, stable);
    counts.add_many(Phase::SEMI_STABLE_MILLING, semi);
    counts.add_many(Phase::UNFORMED, unformed);
    let end = if ring_m > 0.2 { Phase::DISPERSION } else { Phase::COLLIDING_UNSTABLE };
    counts.add_many(end, rest);
    counts
}

fn diagram(speeds: &[f64], turn_rates: &[f64]) -> PhaseDiagram {
    let mut cells = Vec::new();
    for speed in speeds {
        for turn_rate in turn_rates {
            let cell = Cell::new([(Axis::Speed, *speed), (Axis::TurnRate, *turn_rate)]);
            let cell = cell.expect("two finite values");
            cells.push(DiagramCell { cell, counts: counts(*speed, *turn_rate) });
        }
    }
    PhaseDiagram { axes: vec![Axis::Speed, Axis::TurnRate], cells }
}

fn default_diagram() -> PhaseDiagram {
    let speeds = AxisValues::evenly_spaced(0.05, 0.30, 11);
    let turn_rates = AxisValues::evenly_spaced(0.25, 2.0, 8);
    diagram(&speeds.0, &turn_rates.0)
}

fn plain(diagram: &PhaseDiagram) -> DiagramPicture<'_> {
    DiagramPicture {
        panels: vec![Panel::new(diagram)],
        x: Axis::Speed,
        y: Some(Axis::TurnRate),
        theme: Theme::Screen,
        title: "Nine simulated Flockbots".to_owned(),
        subtitle: "flockbot, harsher · 9 robots · 300 s · 16 replicates per cell · sees: body"
            .to_owned(),
        details: "gain_sd_factor 2.5, seed 42".to_owned(),
        chosen: None,
        chosen_note: None,
        values: None,
        numbers: Numbers::Shown,
        experiments: &[],
        wanted: None,
        note: None,
        width_px: None,
    }
}

fn cell(text: &str) -> Cell {
    text.parse().expect("the tests write cells well")
}

/// Draws, checks what every picture must be, and leaves it to be looked at.
fn draw(name: &str, picture: &DiagramPicture) -> (String, Pixmap) {
    let svg = svg(picture).expect("the picture can be drawn");
    (svg.clone(), keep(name, &svg, 1600))
}

fn n_pixels_of(pixmap: &Pixmap, colour: [u8; 3]) -> usize {
    let is_it =
        |pixel: &&PremultipliedColorU8| [pixel.red(), pixel.green(), pixel.blue()] == colour;
    pixmap.pixels().iter().filter(is_it).count()
}

#[test]
fn a_full_picture_shows_all_there_is() {
    let diagram = default_diagram();
    let chosen = cell("speed_m_s=0.15,turn_rate_rad_s=0.75");
    let experiment = |at: &str, phase, n| ExperimentMark {
        cell: cell(at),
        phase,
        is_settled: true,
        is_simulated: false,
        n,
        names: Vec::new(),
    };
    let line = |label: &str, slope: f64| Boundary {
        label: label.to_owned(),
        points: vec![(0.0, 0.0), (0.4, 0.4 * slope)],
        holds: Side::Above,
    };
    let picture = DiagramPicture {
        chosen: Some(&chosen),
        chosen_note: None,
        numbers: Numbers::Shown,
        panels: vec![Panel {
            boundaries: vec![
                line("ring radius equals the sensing range", 1.6),
                line("neighbours on the ring touch", 8.5),
            ],
            ..Panel::new(&diagram)
        }],
        experiments: &[
            experiment("speed_m_s=0.15,turn_rate_rad_s=0.75", Phase::STABLE_MILLING, 3),
            experiment("speed_m_s=0.15,turn_rate_rad_s=1", Phase::SEMI_STABLE_MILLING, 1),
            experiment("speed_m_s=0.25,turn_rate_rad_s=0.75", Phase::DISPERSION, 2),
            experiment("speed_m_s=0.25,turn_rate_rad_s=0.75", Phase::STABLE_MILLING, 1),
            experiment("speed_m_s=0.1,turn_rate_rad_s=1.5", Phase::COLLIDING_UNSTABLE, 1),
            experiment("speed_m_s=0.2,turn_rate_rad_s=1.25", Phase::UNFORMED, 1),
            experiment("speed_m_s=0.5,turn_rate_rad_s=1.25", Phase::UNFORMED, 2),
        ],
        note: Some("This sweep is not validated against trajectories of real robots.".to_owned()),
        ..plain(&diagram)
    };

    let (svg, pixmap) = draw("full", &picture);
    assert_eq!(svg, rsrs_view::diagram::svg(&picture).unwrap(), "it is the same text again");

    for text in [
        "Nine simulated Flockbots",
        "speed (m/s)",
        "turning rate (rad/s)",
        "chosen cell",
        "speed 0.15 m/s",
        "ring radius equals the",
        "stable milling: 4",
        "2 not shown",
        "not validated",
        "<desc>gain_sd_factor 2.5, seed 42</desc>",
        ">3/3</text>",
        ">1/3</text>",
        ">0/1</text>",
        ">n/n</text>",
    ] {
        assert!(svg.contains(text), "{text}");
    }
    let is_number = |line: &&str| {
        line.contains("<text") && line.contains(" stroke=\"#") && !line.contains("stroke-width")
    };
    assert_eq!(svg.lines().filter(is_number).count(), 88, "marks leave the numbers");
    for phase in Behaviour::MILLING.phases().iter().copied() {
        assert!(svg.contains(&format!(">{}<", phase.title())), "{phase}");
        let in_legend = n_pixels_of(&pixmap, rsrs_view::palette::hue(phase).rgb);
        assert!(in_legend > 300, "{phase}: {in_legend}");
    }
}

#[test]
fn the_readme_picture_is_clean() {
    let diagram = default_diagram();
    let chosen = cell("speed_m_s=0.15,turn_rate_rad_s=0.75");

    let (svg, pixmap) =
        draw("readme", &DiagramPicture { chosen: Some(&chosen), ..plain(&diagram) });

    // Slow and turning fast, robots collide; fast and turning slowly, they disperse.
    let at = |x_px: u32, y_px: u32| pixmap.pixel(x_px, y_px).map(PremultipliedColorU8::red);
    assert_eq!((at(150, 140), at(1050, 825)), (Some(0xd5), Some(0xbb)));
    assert!(!svg.contains("Theory") && !svg.contains("Experiments"));
    assert!(svg.contains("speed 0.15 m/s, turning rate 0.75 rad/s\n16 replicates:"));
}

#[test]
fn cells_may_show_a_number_in_the_place_of_their_phases() {
    let diagram = default_diagram();
    let share = |entry: &DiagramCell| entry.counts.wanted_share();
    let circliness = CellValues {
        name: "circliness, mean of the runs".to_owned(),
        scale: ValueScale::Sequential { low: 0.0, high: 1.0 },
        of_panels: vec![diagram.cells.iter().map(|it| Some(share(it))).collect()],
        framed: None,
    };
    let difference = CellValues {
        name: "difference of the share of stable milling".to_owned(),
        scale: ValueScale::Diverging { most: 0.5 },
        of_panels: vec![
            diagram
                .cells
                .iter()
                .enumerate()
                .map(|(n, it)| (n != 7).then(|| share(it) - 0.5))
                .collect(),
        ],
        framed: Some((
            "intervals do not overlap".to_owned(),
            vec![diagram.cells.iter().map(|it| (share(it) - 0.5).abs() > 0.45).collect()],
        )),
    };

    let (plain_svg, _) =
        draw("circliness", &DiagramPicture { values: Some(circliness), ..plain(&diagram) });
    let (svg, _) =
        draw("difference", &DiagramPicture { values: Some(difference), ..plain(&diagram) });

    assert!(plain_svg.contains("circliness, mean of the runs: 0.62"), "in a tooltip");
    assert!(svg.contains("intervals do not overlap") && svg.contains(">+0.50</text>"));
    assert!(svg.contains("no value") && !svg.contains("Most frequent phase"));
}

#[test]
fn many_small_cells_have_no_numbers_and_twenty_by_twenty_have() {
    for (name, n_speeds, n_turn_rates, has_numbers) in
        [("fine", 60, 50, false), ("twenty", 20, 20, true)]
    {
        let speeds = AxisValues::evenly_spaced(0.05, 0.30, n_speeds);
        let turn_rates = AxisValues::evenly_spaced(0.25, 2.0, n_turn_rates);
        let diagram = diagram(&speeds.0, &turn_rates.0);
        let chosen = diagram.cells[n_speeds / 2 * n_turn_rates + 15].cell.clone();

        let (svg, _) = draw(name, &DiagramPicture { chosen: Some(&chosen), ..plain(&diagram) });

        assert_eq!(svg.contains("share of stable milling"), has_numbers, "{name}");
        assert!(has_numbers || svg.contains("<circle"), "{name}");
    }
}

#[test]
fn one_axis_gives_a_curve() {
    let mut cells = Vec::new();
    for robots in [3.0, 6.0, 9.0, 12.0, 15.0] {
        let cell = Cell::new([(Axis::Robots, robots)]).expect("finite");
        cells.push(DiagramCell { cell, counts: counts(0.02 * robots, 1.0) });
    }
    let diagram = PhaseDiagram { axes: vec![Axis::Robots], cells };
    let chosen = cell("robots=9");
    let mut measured = diagram.clone();
    for entry in &mut measured.cells {
        entry.counts.add_many(Phase::STABLE_MILLING, 8);
    }
    let panel = Panel {
        compared: Some(("robots as measured".to_owned(), &measured)),
        ..Panel::new(&diagram)
    };
    let picture = DiagramPicture {
        panels: vec![panel],
        x: Axis::Robots,
        y: None,
        chosen: Some(&chosen),
        wanted: Some((0.8, "viable: 80 %".to_owned())),
        ..plain(&diagram)
    };

    let (svg, _) = draw("one_axis", &picture);

    assert!(svg.contains("number of robots") && svg.contains("95 % interval"));
    assert!(svg.contains("the same, robots as measured") && svg.contains("viable: 80 %"));
}

#[test]
fn one_column_and_irregular_rows_with_a_hole_are_drawn() {
    let mut diagram = diagram(&[0.15], &[0.25, 0.5, 0.75, 1.0, 2.0]);
    diagram.cells.push(DiagramCell {
        cell: cell("speed_m_s=0.2,turn_rate_rad_s=0.5"),
        counts: counts(0.2, 0.5),
    });

    let (svg, _) = draw("holes", &plain(&diagram));

    assert!(svg.contains("no result") && svg.contains("not swept"));
}

#[test]
fn hostile_texts_stay_texts() {
    let diagram = default_diagram();
    let hostile = "</text><script>alert(\"1\")</script> & \u{0} 'quoted' \u{fffe}";
    let long = "a title that goes on and on about robots and the rings that they form ".repeat(4);
    let picture = DiagramPicture {
        title: long + hostile,
        subtitle: hostile.to_owned(),
        panels: vec![Panel {
            boundaries: vec![Boundary {
                label: hostile.to_owned(),
                points: vec![(0.1, 0.0), (0.1, 3.0)],
                holds: Side::Left,
            }],
            ..Panel::new(&diagram)
        }],
        note: Some(hostile.to_owned()),
        ..plain(&diagram)
    };

    let (svg, _) = draw("hostile", &picture);

    assert!(!svg.contains("<script") && svg.contains("&lt;script"));
}

#[test]
fn a_slice_of_three_axes_states_where_it_was_cut() {
    let diagram = panels::three_axes(&[6.0, 9.0]);
    let chosen = cell("robots=6,speed_m_s=0.15,turn_rate_rad_s=0.75");
    let picture = DiagramPicture {
        panels: vec![Panel {
            at: vec![(Axis::Robots, 9.0)],
            boundaries: vec![Boundary {
                label: "far away".to_owned(),
                points: vec![(1.0, 1.0); 2],
                holds: Side::Left,
            }],
            ..Panel::new(&diagram)
        }],
        chosen: Some(&chosen),
        ..plain(&diagram)
    };

    let (svg, _) = draw("slice", &picture);

    assert!(svg.contains("Slice at 9 robots"));
    assert!(!svg.contains("chosen cell") && !svg.contains("far away"), "what is not shown");
}

#[test]
fn a_boundary_without_a_place_and_axes_that_were_not_swept_are_refused() {
    let diagram = default_diagram();
    let boundary =
        Boundary { label: "limit".to_owned(), points: vec![(0.1, f64::NAN)], holds: Side::Left };

    let panels = vec![Panel { boundaries: vec![boundary], ..Panel::new(&diagram) }];
    let error = svg(&DiagramPicture { panels, ..plain(&diagram) }).unwrap_err();

    assert_eq!(
        error.to_string(),
        "boundary `limit` has the point (0.1, NaN); expected finite numbers"
    );
    let not_swept = svg(&DiagramPicture { x: Axis::Range, ..plain(&diagram) }).unwrap_err();
    assert_eq!(not_swept.help().as_deref(), Some("draw `--x speed_m_s --y turn_rate_rad_s`"));
}

#[test]
fn runs_that_are_not_settled_are_hollow_and_counted_by_themselves() {
    let diagram = default_diagram();
    let names = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect();
    let runs = |is_settled, names: Vec<String>| ExperimentMark {
        cell: cell("speed_m_s=0.15,turn_rate_rad_s=0.75"),
        phase: Phase::STABLE_MILLING,
        is_settled,
        // One that somebody should look at again is one of a dry run.
        is_simulated: !is_settled,
        n: names.len() as u64,
        names,
    };
    let experiments = [runs(true, names(&["run_1", "run_2"])), runs(false, names(&["run_3"]))];

    let (svg, _) =
        draw("unsettled", &DiagramPicture { experiments: &experiments, ..plain(&diagram) });

    assert!(svg.contains(
        "2 stable milling: run_1, run_2\n1 stable milling (not settled: look again): run_3"
    ));
    assert!(svg.contains(">3/3</text>"));
    assert!(svg.contains(">stable milling: 2</text>"));
    assert!(svg.contains(">stable milling: 1, not settled:"), "in the legend");
    assert!(svg.contains(">Experiments, some simulated</text>"));
}

#[test]
fn runs_at_one_cell_are_counted_beside_one_symbol_however_many_there_are() {
    let diagram = default_diagram();
    let runs = |n: u64| {
        let names = (1..=n).map(|run| format!("run_{run}")).collect();
        let at = cell("speed_m_s=0.15,turn_rate_rad_s=0.75");
        [ExperimentMark {
            cell: at,
            phase: Phase::STABLE_MILLING,
            is_settled: true,
            is_simulated: false,
            n,
            names,
        }]
    };
    let drawn = |n: u64| {
        let experiments = runs(n);
        draw("named", &DiagramPicture { experiments: &experiments, ..plain(&diagram) }).0
    };

    let (nine, hundred) = (drawn(9), drawn(100));

    assert!(nine.contains("<title>9 stable milling: run_1, run_2"));
    assert!(nine.contains(">9/9</text>") && hundred.contains(">100/100</text>"));
}

#[test]
fn a_tiny_diagram_is_exactly_this_text() {
    let diagram = diagram(&[0.15, 0.2], &[0.75]);
    let chosen = cell("speed_m_s=0.15,turn_rate_rad_s=0.75");
    let picture = DiagramPicture {
        title: "Two cells".to_owned(),
        subtitle: String::new(),
        details: String::new(),
        chosen: Some(&chosen),
        ..plain(&diagram)
    };

    let svg = svg(&picture).unwrap();
    // The legend is the same in every picture.
    let plot: Vec<&str> = svg.lines().take_while(|line| !line.contains("Most frequent")).collect();

    insta::assert_snapshot!(plot.join("\n"), @r##"
    <svg xmlns="http://www.w3.org/2000/svg" width="598.49" height="342" viewBox="0 0 598.49 342" role="img" font-family="DejaVu Sans, Verdana, Bitstream Vera Sans, Geneva, sans-serif">
      <title>Two cells</title>
      <rect x="0" y="0" width="598.49" height="342" fill="#ffffff"/>
      <text x="24" y="34" font-size="16" font-weight="bold" fill="#1a1a1a">Two cells</text>
      <g class="fixed" stroke-width="0.6">
        <rect x="78.49" y="56" width="110" height="220" fill="#0072b2" stroke="#ffffff">
          <title>speed 0.15 m/s, turning rate 0.75 rad/s
    16 replicates: 16 stable milling</title>
        </rect>
        <rect x="188.49" y="56" width="110" height="220" fill="#f5f09a" stroke="#ffffff">
          <title>speed 0.2 m/s, turning rate 0.75 rad/s
    16 replicates: 9 semi-stable milling, 7 stable milling</title>
        </rect>
      </g>
      <path class="fixed" d="M188.49 56V276" fill="none" stroke="#1a1a1a" stroke-width="1.2" stroke-linecap="square"/>
      <g>
        <rect x="78.49" y="56" width="220" height="220" fill="none" stroke="#1a1a1a" stroke-width="1"/>
        <path d="M133.49 276v5M243.49 276v5" stroke="#1a1a1a" stroke-width="1"/>
        <g font-size="11" text-anchor="middle" fill="#555555">
          <text x="133.49" y="294">0.15</text>
          <text x="243.49" y="294">0.20</text>
        </g>
        <text x="188.49" y="316" text-anchor="middle" font-size="12.5" fill="#1a1a1a">speed (m/s)</text>
        <path d="M78.49 166h-5" stroke="#1a1a1a" stroke-width="1"/>
        <g font-size="11" text-anchor="end" fill="#555555">
          <text x="69.49" y="169.96">0.75</text>
        </g>
        <text x="33" y="166" text-anchor="middle" font-size="12.5" fill="#1a1a1a" transform="rotate(-90 33 166)">turning rate (rad/s)</text>
      </g>
      <g class="fixed" font-size="11" text-anchor="middle" pointer-events="none" stroke-width="4" stroke-linejoin="round" paint-order="stroke">
        <text x="133.49" y="169.96" fill="#ffffff" stroke="#0072b2">1.00</text>
        <text x="243.49" y="169.96" fill="#1a1a1a" stroke="#f5f09a">0.44</text>
      </g>
      <g class="fixed" pointer-events="none">
        <rect x="78.99" y="56.5" width="109" height="219" stroke-linejoin="round" fill="none" stroke="#ffffff" stroke-width="6"/>
        <rect x="78.99" y="56.5" width="109" height="219" stroke-linejoin="round" fill="none" stroke="#1a1a1a" stroke-width="3"/>
      </g>
    "##);
}
