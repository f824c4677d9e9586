//! How sure verdicts are, on made-up trajectories whose order parameters are known.

use rsrs_core::judge::behaviour::Behaviour;
use rsrs_core::judge::certainty::{Certainty, Parameter};
use rsrs_core::judge::phase::{Phase, Verdict, label};
use rsrs_core::judge::trajectory::{Bodies, Trajectory};

use crate::judge::{FLOCKBOT, on_circle, run, spacing_rad};

/// Nine robots on a ring, each at a radius of its own that is a function of robot and time.
fn ring(radius_m: impl Fn(usize, f64) -> f64, orbits_at_m_s: f64) -> Trajectory {
    run(78.0, |robot, time_s| {
        let bearing_rad = spacing_rad(robot, 9) + orbits_at_m_s / 0.7 * time_s;
        on_circle(0.0, radius_m(robot, time_s), bearing_rad)
    })
}

fn judged(trajectory: &Trajectory, bodies: &Bodies) -> (Verdict, Certainty) {
    let verdict = label(trajectory, bodies).expect("the trajectory is long enough and finite");
    let certainty = Certainty::new(&verdict, &Behaviour::MILLING.rules());
    (verdict, certainty)
}

/// A ring of two radii with a fatness that follows from them.
fn fat(fatness: f64) -> impl Fn(usize, f64) -> f64 {
    let inner_m = 0.7 * (1.0 - fatness).sqrt();
    // Three by three, so that the centroid stays in the middle.
    move |robot, _| if robot.is_multiple_of(3) { inner_m } else { 0.7 }
}

#[test]
fn a_perfect_ring_is_sure_and_its_blocks_agree() {
    let (verdict, certainty) = judged(&ring(|_, _| 0.7, 0.15), &FLOCKBOT);

    assert_eq!(verdict.phase, Phase::STABLE_MILLING);
    assert!(certainty.is_settled);
    assert_eq!(certainty.confidence.to_bits(), 1.0_f64.to_bits());
    let of_stable = certainty.margins.iter().filter(|m| m.phase == Phase::STABLE_MILLING);
    assert!(of_stable.into_iter().all(|margin| margin.distance > 0.0), "{certainty:?}");
}

#[test]
fn a_fat_ring_is_as_far_from_stable_as_its_circliness_is() {
    for fatness in [0.42, 0.47, 0.53, 0.58] {
        let (verdict, certainty) = judged(&ring(fat(fatness), 0.15), &FLOCKBOT);

        let (expected, becomes) = if fatness < 0.5 {
            (Phase::STABLE_MILLING, Phase::SEMI_STABLE_MILLING)
        } else {
            (Phase::SEMI_STABLE_MILLING, Phase::STABLE_MILLING)
        };
        assert_eq!(verdict.phase, expected);
        assert_eq!(certainty.is_settled, (fatness - 0.5_f64).abs() > 0.05, "{fatness}");
        let margin = certainty
            .margins
            .iter()
            .find(|margin| margin.parameter == Parameter::CIRCLINESS)
            .expect("stable milling has a least circliness");
        assert!((margin.distance - (0.5 - fatness)).abs() < 1e-9, "{margin:?}");
        let slow = verdict.evidence.blocked + 0.02 < (fatness - 0.5_f64).abs();
        if !slow {
            let nearest = certainty.nearest.expect("another phase can be had");
            assert_eq!(
                (nearest.becomes, &*nearest.parameters),
                (becomes, &[Parameter::CIRCLINESS][..])
            );
        }
    }
}

#[test]
fn where_two_parameters_must_move_together_the_farther_one_counts() {
    // Round, but it orbits at two fifths of its command: neither stable nor semi-stable.
    let (verdict, certainty) = judged(&ring(|_, _| 0.7, 0.06), &FLOCKBOT);

    let nearest = certainty.nearest.expect("another phase can be had");
    assert_eq!(verdict.phase, Phase::UNFORMED);
    assert_eq!(nearest.becomes, Phase::SEMI_STABLE_MILLING);
    assert_eq!(nearest.parameters, [Parameter::ORBIT]);
    assert!((nearest.distance - (0.5 - verdict.evidence.orbit)).abs() < 1e-12);
}

#[test]
fn moving_as_far_as_the_nearest_boundary_changes_the_phase_and_less_does_not() {
    for orbits_at_m_s in [0.0, 0.03, 0.06, 0.08, 0.11, 0.15] {
        for fatness in [0.1, 0.3, 0.49, 0.51, 0.7, 0.9] {
            let (verdict, certainty) = judged(&ring(fat(fatness), orbits_at_m_s), &FLOCKBOT);
            let Some(nearest) = certainty.nearest else {
                panic!("a swarm of known range can always disperse: {certainty:?}")
            };
            let moved = |share: f64| {
                let step = nearest.distance * share;
                let corners = (0..1 << 6).map(|corner: u32| {
                    let sign = |bit: u32| if corner & (1 << bit) == 0 { -step } else { step };
                    let mut evidence = verdict.evidence;
                    // Below the first robot none is lost.
                    let whole = |lost: f64| Some(lost + sign(0)).filter(|lost| *lost >= 1.0 / 9.0);
                    evidence.lost = evidence.lost.map(|lost| whole(lost).unwrap_or(0.0));
                    evidence.stuck += sign(1);
                    evidence.blocked += sign(2);
                    evidence.rotation += sign(3);
                    evidence.orbit += sign(4);
                    evidence.circliness += sign(5);
                    Behaviour::MILLING.rules().phase(&evidence)
                });
                corners.filter(|phase| *phase != verdict.phase).count()
            };

            assert!(moved(1.000_001) > 0, "{verdict:?} {nearest:?}");
            assert_eq!(moved(0.999_999), 0, "{verdict:?} {nearest:?}");
        }
    }
}
