//! Which cell is chosen, on diagrams whose answer is plain to see.

use rsrs_core::axis::{Axis, Cell};
use rsrs_core::choice::{Choice, Margin, VIABLE_B_S_LOW, rank};
use rsrs_core::diagram::{DiagramCell, PhaseCounts, PhaseDiagram};
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

fn position(cell: &Cell) -> (f64, f64) {
    let value = |axis| cell.get(axis).expect("both axes are swept");
    let rounded = |number: f64| (number * 1e6).round() / 1e6;
    (rounded(value(Axis::Speed)), rounded(value(Axis::TurnRate)))
}

#[test]
fn the_middle_of_the_region_wins() {
    let ranked = rank(&diagram(&[
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
    let ranked = rank(&diagram(&["fff", "fff", "fff"]));

    assert_eq!(position(&ranked[0].cell), (0.10, 0.5));
    assert_eq!(ranked[0].depth.to_bits(), 2.0_f64.to_bits());
    assert_eq!(ranked[8].depth.to_bits(), 1.0_f64.to_bits());
}

#[test]
fn a_hole_is_an_edge_and_depth_is_euclidean() {
    let ranked = rank(&diagram(&["fffff", "fffff", "fffff", "ff0ff", "fffff", "fffff", "fffff"]));

    // All cells are next to the border, the hole, or diagonal to it and one from the border.
    let diagonal = ranked.iter().find(|entry| position(&entry.cell) == (0.10, 0.75));
    assert_eq!(diagonal.expect("it mills").depth.to_bits(), 2.0_f64.sqrt().to_bits());
    assert_eq!(position(&ranked[0].cell), (0.15, 0.50));
}

#[test]
fn of_equally_deep_cells_the_one_that_mills_more_often_wins_and_then_the_central_one() {
    let better = rank(&diagram(&["000000", "0ddfd0", "000000"]));
    let central = rank(&diagram(&["0000000", "0fffff0", "0000000"]));

    assert_eq!(position(&better[0].cell), (0.20, 0.5));
    assert_eq!(position(&central[0].cell), (0.20, 0.5));
}

#[test]
fn twelve_of_sixteen_is_outside_and_thirteen_inside() {
    // The lower bounds are 0.476 and 0.544.
    let ranked = rank(&diagram(&["cd"]));

    assert_eq!(ranked.len(), 1);
    assert_eq!(position(&ranked[0].cell).0.to_bits(), 0.10_f64.to_bits());
}

#[test]
fn no_milling_region_leaves_no_candidate() {
    assert!(rank(&diagram(&["000", "010", "000"])).is_empty());
}

#[test]
fn an_axis_with_a_single_value_is_not_an_edge() {
    let ranked = rank(&diagram(&["fffff"]));

    assert_eq!(position(&ranked[0].cell).0.to_bits(), 0.15_f64.to_bits());
    assert_eq!(ranked[0].depth.to_bits(), 3.0_f64.to_bits());
    assert_eq!(ranked[0].margin[&Axis::TurnRate], Margin { low: 0.0, high: 0.0 });
}

#[test]
fn a_point_that_was_not_simulated_is_outside() {
    let mut sparse = diagram(&["fff", "fff", "fff"]);
    sparse.cells.remove(0);

    let ranked = rank(&sparse);

    assert_eq!(ranked[0].depth.to_bits(), 2.0_f64.sqrt().to_bits());
}

#[test]
fn the_choice_rests_on_the_confirmation_alone() {
    let ranked = rank(&diagram(&["fff", "fff", "fff"]));

    let good = Choice::new(&ranked[0], confirmed(868, 1000));
    let poor = Choice::new(&ranked[0], confirmed(810, 1000));

    assert_eq!((good.n_replicates, good.b_s.to_bits()), (1000, 0.868_f64.to_bits()));
    assert!((good.b_s_low - 0.845_434_553_391_940_6).abs() < 1e-9);
    assert!(good.is_viable(VIABLE_B_S_LOW));
    assert!(!poor.is_viable(VIABLE_B_S_LOW) && poor.is_viable(0.75));
}

#[test]
fn the_choice_serialises_as_the_contract_says() {
    let ranked = rank(&diagram(&["fff", "fff", "fff"]));
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
