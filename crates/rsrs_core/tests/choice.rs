//! Which cell is chosen, on diagrams whose answer is plain to see.

use rsrs_core::axis::{Axis, Cell};
use rsrs_core::choice::{
    AsMeasured, AtCircliness, Candidate, Choice, Margin, VIABLE_B_S_LOW, rank,
};
use rsrs_core::diagram::{DiagramCell, PhaseCounts, PhaseDiagram};
use rsrs_core::interval_kind::IntervalKind;
use rsrs_core::order::Evidence;
use rsrs_core::phase::Phase;

/// A diagram from a drawing: columns are speeds, rows turning rates from the greatest down; the
/// digit is the number of milling replicates of 16, in hexadecimal, and `f` stands for all.
fn diagram(rows: &[&str]) -> PhaseDiagram {
    let mut cells = Vec::new();
    for speed in 0..rows[0].len() {
        for (turn, row) in rows.iter().rev().enumerate() {
            let digit = row.as_bytes()[speed] as char;
            let milling = match digit.to_digit(16).expect("a hexadecimal digit") {
                15 => 16,
                milling => u64::from(milling),
            };
            let counts = confirmed(milling, 16);
            let values = [
                (Axis::Speed, 0.05 + 0.05 * speed as f64),
                (Axis::TurnRate, 0.25 + 0.25 * turn as f64),
            ];
            cells.push(DiagramCell { cell: Cell::new(values).expect("distinct axes"), counts });
        }
    }
    PhaseDiagram { axes: vec![Axis::Speed, Axis::TurnRate], cells }
}

/// How many of so many fresh replicates milled; the others dispersed.
fn confirmed(milling: u64, n: u64) -> PhaseCounts {
    let mut counts = PhaseCounts::default();
    counts.add_many(Phase::StableMilling, milling);
    counts.add_many(Phase::Dispersion, n - milling);
    counts
}

fn ranked(diagram: &PhaseDiagram) -> Vec<Candidate> {
    rank(diagram, IntervalKind::ClopperPearson)
}

fn position(cell: &Cell) -> (f64, f64) {
    let value = |axis| cell.get(axis).expect("both axes are swept");
    let rounded = |number: f64| (number * 1e6).round() / 1e6;
    (rounded(value(Axis::Speed)), rounded(value(Axis::TurnRate)))
}

#[test]
fn the_middle_of_the_region_wins() {
    let ranked = ranked(&diagram(&[
        "0000000", //
        "0fffff0", "0fffff0", "0fffff0", "0fffff0", "0fffff0", "0000000",
    ]));

    assert_eq!(ranked.len(), 25);
    assert_eq!(position(&ranked[0].cell), (0.20, 1.0));
    assert_eq!(ranked[0].depth.to_bits(), 3.0_f64.to_bits());
    let margin = ranked[0].margin[&Axis::TurnRate];
    assert_eq!(margin, Margin { low: 0.5, high: 0.5 });
    assert_eq!(ranked[0].margin[&Axis::Speed], Margin { low: 0.1, high: 0.1 });
}

#[test]
fn the_border_of_the_grid_is_an_edge() {
    let ranked = ranked(&diagram(&["fff", "fff", "fff"]));

    assert_eq!(position(&ranked[0].cell), (0.10, 0.5));
    assert_eq!(ranked[0].depth.to_bits(), 2.0_f64.to_bits());
    assert_eq!(ranked[8].depth.to_bits(), 1.0_f64.to_bits());
}

#[test]
fn a_hole_is_an_edge_and_depth_is_euclidean() {
    let ranked = ranked(&diagram(&["fffff", "fffff", "fffff", "ff0ff", "fffff", "fffff", "fffff"]));

    // All cells are next to the border, the hole, or diagonal to it and one from the border.
    let diagonal = ranked.iter().find(|entry| position(&entry.cell) == (0.10, 0.75));
    assert_eq!(diagonal.expect("it mills").depth.to_bits(), 2.0_f64.sqrt().to_bits());
    assert_eq!(position(&ranked[0].cell), (0.15, 0.50));
}

#[test]
fn of_equally_deep_cells_the_one_that_mills_more_often_wins_and_then_the_central_one() {
    let better = ranked(&diagram(&["000000", "0ddfd0", "000000"]));
    let central = ranked(&diagram(&["0000000", "0fffff0", "0000000"]));

    assert_eq!(position(&better[0].cell), (0.20, 0.5));
    assert_eq!(position(&central[0].cell), (0.20, 0.5));
}

#[test]
fn twelve_of_sixteen_is_outside_and_thirteen_inside() {
    // The lower bounds are 0.476 and 0.544.
    let ranked = ranked(&diagram(&["cd"]));

    assert_eq!(ranked.len(), 1);
    assert_eq!(position(&ranked[0].cell).0.to_bits(), 0.10_f64.to_bits());
}

#[test]
fn no_milling_region_leaves_no_candidate() {
    assert!(ranked(&diagram(&["000", "010", "000"])).is_empty());
}

#[test]
fn an_axis_with_a_single_value_is_not_an_edge() {
    let ranked = ranked(&diagram(&["fffff"]));

    assert_eq!(position(&ranked[0].cell).0.to_bits(), 0.15_f64.to_bits());
    assert_eq!(ranked[0].depth.to_bits(), 3.0_f64.to_bits());
    assert_eq!(ranked[0].margin[&Axis::TurnRate], Margin { low: 0.0, high: 0.0 });
}

#[test]
fn a_point_that_was_not_simulated_is_outside() {
    let mut sparse = diagram(&["fff", "fff", "fff"]);
    sparse.cells.remove(0);

    let ranked = ranked(&sparse);

    assert_eq!(ranked[0].depth.to_bits(), 2.0_f64.sqrt().to_bits());
}

#[test]
fn the_choice_rests_on_the_confirmation_alone() {
    let ranked = ranked(&diagram(&["fff", "fff", "fff"]));

    let good = Choice::new(&ranked[0], confirmed(868, 1000));
    let poor = Choice::new(&ranked[0], confirmed(810, 1000));

    assert_eq!((good.n_replicates, good.b_s.to_bits()), (1000, 0.868_f64.to_bits()));
    assert!((good.b_s_low - 0.845_434_553_391_940_6).abs() < 1e-9);
    assert!(good.is_viable(VIABLE_B_S_LOW));
    assert!(!poor.is_viable(VIABLE_B_S_LOW) && poor.is_viable(0.75));
}

#[test]
fn that_worse_robots_mill_more_often_is_said_only_where_it_is_sure() {
    let ranked = ranked(&diagram(&["fff", "fff", "fff"]));
    let choice = |measured: u64| Choice {
        as_measured: Some(AsMeasured::of(&confirmed(measured, 1000))),
        ..Choice::new(&ranked[0], confirmed(868, 1000))
    };

    assert!(choice(636).worse_is_better());
    assert!(!choice(840).worse_is_better(), "the intervals overlap");
    assert!(!choice(1000).worse_is_better());
    assert!(!Choice::new(&ranked[0], confirmed(868, 1000)).worse_is_better());
}

#[test]
fn the_share_of_mills_moves_with_the_circliness_that_makes_one() {
    let mill = |circliness| Evidence {
        lost: Some(0.0),
        blocked: 0.0,
        stuck: 0.0,
        rotation: 0.99,
        orbit: 0.99,
        fatness: 1.0 - circliness,
        tangentness: 0.0,
        circliness,
        mean_radius_m: 0.9,
        contact_onsets_per_s: Some(0.0),
        circliness_ceiling: 0.95,
    };

    let moved = AtCircliness::of(&[mill(0.3), mill(0.45), mill(0.55), mill(0.65)]);

    let found: Vec<(f64, f64)> = moved.iter().map(|at| (at.stable_circliness, at.b_s)).collect();
    assert_eq!(found, [(0.4, 0.75), (0.5, 0.5), (0.6, 0.25)]);
}

#[test]
fn the_choice_serialises_as_the_contract_says() {
    let ranked = ranked(&diagram(&["fff", "fff", "fff"]));
    let choice = Choice::new(&ranked[0], confirmed(8, 8));

    let json = serde_json::to_string(&choice).expect("a choice is plain data");

    let expected = format!(
        r#"{{"cell":{{"speed_m_s":0.1,"turn_rate_rad_s":0.5}},"b_s":1.0,"b_s_low":{},"b_s_high":1.0,"n_replicates":8,"margin":{{"speed_m_s":{{"low":0.05,"high":0.05}},"turn_rate_rad_s":{{"low":0.25,"high":0.25}}}},"phases":{{"stable_milling":8,"semi_stable_milling":0,"unformed":0,"dispersion":0,"colliding_unstable":0}}}}"#,
        choice.b_s_low
    );
    assert_eq!(json, expected);
    assert_eq!(serde_json::from_str::<Choice>(&json).expect("it reads back"), choice);
}

#[test]
fn a_choice_without_phases_reads_too() {
    let json = r#"{"cell":{"speed_m_s":0.1},"b_s":1.0,"b_s_low":0.6,"b_s_high":1.0,"n_replicates":8,"margin":{}}"#;

    let choice: Choice = serde_json::from_str(json).expect("it has every key of the contract");

    assert_eq!(choice.phases, None);
}

#[test]
fn on_three_axes_the_middle_wins_and_every_axis_has_its_margin() {
    let mut cells = Vec::new();
    for speed in 0..7_u8 {
        for turn in 0..5_u8 {
            for robots in 0..5_u8 {
                let inside = (1..6).contains(&speed) && (1..4).contains(&turn) && robots > 0;
                let values = [
                    (Axis::Speed, 0.05 * f64::from(speed)),
                    (Axis::TurnRate, 0.25 * f64::from(turn)),
                    (Axis::Robots, 5.0 + f64::from(robots)),
                ];
                let counts = confirmed(if inside { 16 } else { 0 }, 16);
                cells.push(DiagramCell { cell: Cell::new(values).expect("distinct"), counts });
            }
        }
    }
    let cube = PhaseDiagram { axes: vec![Axis::Speed, Axis::TurnRate, Axis::Robots], cells };

    let ranked = ranked(&cube);

    // Two steps to the nearest point outside, on the second axis; of the cells that are as deep, the
    // one next to the region's centroid, (3, 2, 2.5).
    assert_eq!(ranked.len(), 5 * 3 * 4);
    assert_eq!(ranked[0].depth.to_bits(), 2.0_f64.to_bits());
    assert_eq!(
        ranked[0].cell.to_string(),
        "speed_m_s=0.15000000000000002,turn_rate_rad_s=0.5,robots=7"
    );
    assert_eq!(ranked[0].margin[&Axis::Speed], Margin { low: 0.1, high: 0.1 });
    assert_eq!(ranked[0].margin[&Axis::TurnRate], Margin { low: 0.25, high: 0.25 });
    assert_eq!(ranked[0].margin[&Axis::Robots], Margin { low: 1.0, high: 2.0 });
}

#[test]
fn where_the_runs_decided_their_number_the_region_is_smaller() {
    // The lower bounds of 13 of 16 are 0.544 if 16 was fixed before, and 0.47 at any time.
    let diagram = diagram(&["df"]);

    let fixed = rank(&diagram, IntervalKind::ClopperPearson);
    let anytime = rank(&diagram, IntervalKind::AnytimeValid);

    assert_eq!((fixed.len(), anytime.len()), (2, 1));
    assert_eq!(anytime[0].index, 1);
}

#[test]
fn the_order_of_equals_is_that_of_the_sweep() {
    let square = diagram(&["ff", "ff"]);

    let order: Vec<usize> = ranked(&square).iter().map(|entry| entry.index).collect();

    assert_eq!(order, [0, 1, 2, 3]);
}
