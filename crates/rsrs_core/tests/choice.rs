//! Which cell is chosen, on diagrams whose answer is plain to see.

use rsrs_core::diagram::choice::{
    AsMeasured, AtCircliness, Candidate, Choice, Edge, Margin, VIABLE_B_S_LOW, Worlds, rank, tail,
};
use rsrs_core::diagram::{DiagramCell, PhaseDiagram};
use rsrs_core::judge::counts::PhaseCounts;
use rsrs_core::judge::order::OrderParameters;
use rsrs_core::judge::phase::Phase;
use rsrs_core::quantity::{Axis, Cell};
use rsrs_core::statistics::interval_kind::IntervalKind;

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
    counts.add_many(Phase::STABLE_MILLING, milling);
    counts.add_many(Phase::DISPERSION, n - milling);
    counts
}

fn ranked(diagram: &PhaseDiagram) -> Vec<Candidate> {
    let worlds = Worlds { simulated: diagram, as_measured: None };
    rank(worlds, IntervalKind::ClopperPearson, VIABLE_B_S_LOW)
}

/// The candidates of two worlds.
fn ranked_in_both(simulated: &PhaseDiagram, measured: &PhaseDiagram) -> Vec<Candidate> {
    let worlds = Worlds { simulated, as_measured: Some(measured) };
    rank(worlds, IntervalKind::ClopperPearson, VIABLE_B_S_LOW)
}

fn position(cell: &Cell) -> (f64, f64) {
    let value = |axis| cell.get(axis).expect("both axes are swept");
    let rounded = |number: f64| (number * 1e6).round() / 1e6;
    (rounded(value(Axis::Speed)), rounded(value(Axis::TurnRate)))
}

#[test]
fn where_a_margin_ends_with_the_sweep_nothing_is_known_and_where_it_ends_at_a_cell_it_is() {
    let corner = ranked(&diagram(&["00000", "ffff0", "ffff0", "ffff0"]));
    let middle = ranked(&diagram(&[
        "0000000", //
        "0fffff0", "0fffff0", "0fffff0", "0fffff0", "0fffff0", "0000000",
    ]));
    let line = ranked(&diagram(&["fff"]));

    let edges = corner[0].edge.values().copied().collect::<Vec<_>>();
    assert_eq!(edges, [Edge { low: true, high: false }; 2], "{:?}", corner[0]);
    assert_eq!(middle[0].edge.len(), 0, "{:?}", middle[0]);
    let both = Edge { low: true, high: true };
    assert!(line[0].edge.values().all(|edge| *edge == both), "{:?}", line[0]);
}

#[test]
fn the_middle_of_the_region_wins() {
    let ranked = ranked(&diagram(&[
        "0000000", //
        "0fffff0", "0fffff0", "0fffff0", "0fffff0", "0fffff0", "0000000",
    ]));

    // A cell stands for its neighbours, too: those next to a cell that never mills are outside of the
    // region, and come last.
    assert_eq!(ranked.len(), 25);
    assert_eq!(position(&ranked[0].cell), (0.20, 1.0));
    assert_eq!(ranked[0].depth.to_bits(), 2.0_f64.to_bits());
    assert_eq!(ranked.iter().filter(|candidate| candidate.depth > 0.0).count(), 9);
    let margin = ranked[0].margin[&Axis::TurnRate];
    assert_eq!(margin, Margin { low: 0.25, high: 0.25 });
    assert_eq!(ranked[0].margin[&Axis::Speed], Margin { low: 0.05, high: 0.05 });
}

#[test]
fn the_border_of_the_grid_is_an_edge() {
    let ranked = ranked(&diagram(&["fff", "fff", "fff"]));

    assert_eq!(position(&ranked[0].cell), (0.10, 0.5));
    assert_eq!(ranked[0].depth.to_bits(), 2.0_f64.to_bits());
    assert_eq!(ranked[8].depth.to_bits(), 1.0_f64.to_bits());
}

#[test]
fn a_hole_of_the_region_is_an_edge_and_depth_is_euclidean() {
    let ranked = ranked(&diagram(&[
        "fffffff", "fffffff", "fffffff", "fff0fff", "fff0fff", "fffffff", "fffffff", "fffffff",
    ]));

    // Around the two cells that never mill, the mean of nine is below 0.8 where both are among them.
    let diagonal = ranked.iter().find(|entry| position(&entry.cell) == (0.10, 1.75));
    assert_eq!(diagonal.expect("it mills").depth.to_bits(), 2.0_f64.to_bits());
    let beside = ranked.iter().find(|entry| position(&entry.cell) == (0.15, 1.25));
    assert_eq!(beside.expect("it mills").depth.to_bits(), 0.0_f64.to_bits());
    assert!(ranked.iter().all(|entry| position(&entry.cell) != (0.20, 1.25)));
}

#[test]
fn one_bad_draw_makes_no_hole() {
    // 11 of 16 in the middle: it may be one of 0.8 still.
    let ranked = ranked(&diagram(&["fffff", "fffff", "ffbff", "fffff", "fffff"]));

    assert_eq!(position(&ranked[0].cell), (0.15, 0.75));
    assert_eq!(ranked[0].depth.to_bits(), 3.0_f64.to_bits());
}

#[test]
fn the_world_in_which_mills_are_rarer_counts() {
    let worse = diagram(&["fffff", "fffff", "fffff", "fffff", "fffff"]);
    let measured = diagram(&["ff000", "ff000", "ff000", "ff000", "ff000"]);

    let here = ranked_in_both(&worse, &measured);
    let there = ranked_in_both(&measured, &worse);

    let cells = |ranked: &[Candidate]| {
        ranked.iter().map(|candidate| candidate.index).collect::<Vec<usize>>()
    };
    assert_eq!(cells(&here), cells(&there));
    assert_eq!(here.len(), 10);
    assert_eq!(position(&here[0].cell).0.to_bits(), 0.05_f64.to_bits());
}

#[test]
fn a_cell_that_mills_alone_comes_last_and_is_not_forgotten() {
    let ranked =
        ranked(&diagram(&["0000000", "0000f00", "0000000", "fff0000", "fff0000", "fff0000"]));

    let last = ranked.last().expect("there are candidates");
    assert_eq!(position(&last.cell), (0.25, 1.25));
    assert_eq!((ranked.len(), last.depth.to_bits()), (10, 0.0_f64.to_bits()));
}

#[test]
fn of_equally_deep_cells_the_one_whose_neighbourhood_mills_more_often_wins_then_the_central_one() {
    let better = ranked(&diagram(&["dddddddd", "dddddfdd", "dddddddd"]));
    let central = ranked(&diagram(&["fffff", "fffff"]));

    assert_eq!(position(&better[0].cell), (0.25, 0.5));
    assert_eq!(position(&central[0].cell).0.to_bits(), 0.15_f64.to_bits());
}

#[test]
fn a_cell_that_surely_mills_too_seldom_is_no_candidate() {
    // The upper bounds are 0.78 and 0.80.
    let candidates = ranked(&diagram(&["89"]));

    assert_eq!(candidates.len(), 1);
    assert_eq!(position(&candidates[0].cell).0.to_bits(), 0.10_f64.to_bits());
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
    assert_eq!(ranked[0].smooth.to_bits(), 1.0_f64.to_bits());
}

#[test]
fn the_bounds_of_all_candidates_hold_together() {
    let all: f64 = (1..100_000).map(tail).sum();

    assert!(all <= 0.05 && all > 0.049, "{all}");
    assert_eq!(tail(1).to_bits(), 0.025_f64.to_bits());
}

#[test]
fn a_cell_of_which_a_neighbour_surely_fails_comes_after_those_of_which_none_does() {
    // Smoothed, the hole in the middle belongs to the region, and the cells next to it are the deepest.
    let ranked = ranked(&diagram(&["fffff", "fffff", "ff8ff", "fffff", "fffff"]));

    let next_to_hole = ranked.iter().find(|it| position(&it.cell) == (0.10, 0.75)).unwrap();
    assert!(!next_to_hole.is_robust && ranked[0].is_robust, "{ranked:?}");
    assert_eq!(next_to_hole.depth.to_bits(), ranked[0].depth.to_bits());
    assert_eq!(position(&ranked[0].cell), (0.10, 0.5));
    assert!(ranked.is_sorted_by_key(|it| !it.is_robust), "{ranked:?}");
}

#[test]
fn the_choice_rests_on_the_confirmation_alone() {
    let ranked = ranked(&diagram(&["fff", "fff", "fff"]));

    let good = Choice::new(&ranked[0], confirmed(868, 1000), 1);
    let poor = Choice::new(&ranked[0], confirmed(810, 1000), 1);

    assert_eq!((good.n_replicates, good.b_s.to_bits()), (1000, 0.868_f64.to_bits()));
    assert!((good.b_s_low - 0.845_434_553_391_940_6).abs() < 1e-9);
    assert!(good.is_viable(VIABLE_B_S_LOW));
    assert!(!poor.is_viable(VIABLE_B_S_LOW) && poor.is_viable(0.75));
}

#[test]
fn that_worse_robots_mill_more_often_is_stated_only_where_it_is_sure() {
    let ranked = ranked(&diagram(&["fff", "fff", "fff"]));
    let choice = |measured: u64| Choice {
        as_measured: Some(AsMeasured::new(&confirmed(measured, 1000), 1)),
        ..Choice::new(&ranked[0], confirmed(868, 1000), 1)
    };

    assert!(choice(636).worse_is_better());
    assert!(!choice(810).is_viable(VIABLE_B_S_LOW), "as measured it is not sure");
    assert!(choice(860).is_viable(VIABLE_B_S_LOW));
    assert!(!choice(840).worse_is_better(), "the intervals overlap");
    assert!(!choice(1000).worse_is_better());
    assert!(!Choice::new(&ranked[0], confirmed(868, 1000), 1).worse_is_better());
}

#[test]
fn the_share_of_mills_moves_with_the_circliness_that_makes_one() {
    let evidence = |circliness| OrderParameters {
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
        clustered: None,
        ..OrderParameters::default()
    };

    let mill = |circliness: f64| {
        let is_stable = circliness >= 0.5;
        let phase = if is_stable { Phase::STABLE_MILLING } else { Phase::SEMI_STABLE_MILLING };
        (phase, evidence(circliness))
    };
    // A fifth one that was torn apart counts nowhere.
    let torn = (Phase::SEMI_STABLE_MILLING, evidence(0.9));

    let moved = AtCircliness::new(&[mill(0.3), mill(0.45), mill(0.55), mill(0.65)]);
    let with_torn = AtCircliness::new(&[mill(0.65), torn]);

    let found: Vec<(f64, f64)> = moved.iter().map(|at| (at.stable_circliness, at.b_s)).collect();
    assert_eq!(found, [(0.4, 0.75), (0.5, 0.5), (0.6, 0.25)]);
    assert!(with_torn.iter().all(|at| at.b_s.to_bits() == 0.5_f64.to_bits()), "{with_torn:?}");
}

#[test]
fn the_choice_serialises_as_documented() {
    let ranked = ranked(&diagram(&["fff", "fff", "fff"]));
    let choice = Choice::new(&ranked[0], confirmed(8, 8), 1);

    let json = serde_json::to_string(&choice).expect("a choice is plain data");

    let expected = format!(
        r#"{{"cell":{{"speed_m_s":0.1,"turn_rate_rad_s":0.5}},"b_s":1.0,"b_s_low":{},"b_s_high":1.0,"n_replicates":8,"margin":{{"speed_m_s":{{"low":0.05,"high":0.05}},"turn_rate_rad_s":{{"low":0.25,"high":0.25}}}},"edge":{{"speed_m_s":{{"low":true,"high":true}},"turn_rate_rad_s":{{"low":true,"high":true}}}},"phases":{{"stable_milling":8,"semi_stable_milling":0,"unformed":0,"dispersion":0,"colliding_unstable":0}},"candidates_tried":1}}"#,
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

    // Of 27 neighbours 18 mill next to one side that does not, so the region is a step smaller there;
    // on the first axis 5 of 7 are left, on the second 1 of 5, on the third 3 of 5.
    let inside: Vec<&Candidate> = ranked.iter().filter(|entry| entry.depth > 0.0).collect();
    assert_eq!((ranked.len(), inside.len()), (5 * 3 * 4, 9));
    assert_eq!(ranked[0].depth.to_bits(), 1.0_f64.to_bits());
    assert_eq!(
        ranked[0].cell.to_string(),
        "speed_m_s=0.15000000000000002,turn_rate_rad_s=0.5,robots=8"
    );
    assert_eq!(ranked[0].margin[&Axis::Speed], Margin { low: 0.05, high: 0.05 });
    assert_eq!(ranked[0].margin[&Axis::TurnRate], Margin { low: 0.0, high: 0.0 });
    assert_eq!(ranked[0].margin[&Axis::Robots], Margin { low: 1.0, high: 1.0 });
}

#[test]
fn where_the_runs_decided_their_number_fewer_cells_are_excluded() {
    // The upper bounds of 8 of 16 are 0.75 if 16 was fixed before, and more at any time.
    let diagram = diagram(&["8f"]);
    let worlds = Worlds { simulated: &diagram, as_measured: None };

    let fixed = rank(worlds, IntervalKind::ClopperPearson, VIABLE_B_S_LOW);
    let anytime = rank(worlds, IntervalKind::AnytimeValid, VIABLE_B_S_LOW);

    assert_eq!((fixed.len(), anytime.len()), (1, 2));
}

#[test]
fn the_order_of_equals_is_that_of_the_sweep() {
    let square = diagram(&["ff", "ff"]);

    let order: Vec<usize> = ranked(&square).iter().map(|entry| entry.index).collect();

    assert_eq!(order, [0, 1, 2, 3]);
}
