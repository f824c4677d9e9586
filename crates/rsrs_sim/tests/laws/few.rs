//! Swarms of no robot, of one and of two.

use rsrs_core::conditions::Conditions;
use rsrs_core::judge::phase::{JudgeError, Phase};
use rsrs_sim::batch::{Batch, BatchError, VectorUnit};

use crate::support::{HARSHER, flockbots};

fn swarm(robots: usize) -> Conditions {
    Conditions { robots, ..flockbots(0.15, 0.75, &HARSHER) }
}

#[test]
fn nobody_has_states_but_no_verdict() {
    for unit in VectorUnit::available() {
        let mut batch = Batch::on(unit).expect("an available unit");

        let digests = batch.digests(&swarm(0), 1, 0..3, 10).expect("no robots fit anywhere");
        let error = batch.judge(&swarm(0), 1, 0..3, 60.0).unwrap_err();

        assert_eq!(digests.len(), 3);
        assert_eq!(digests[0], digests[2]);
        assert_eq!(error, BatchError::Judge(JudgeError::NoRobots));
    }
}

#[test]
fn one_robot_is_lost_and_circles_alone() {
    for unit in VectorUnit::available() {
        let mut batch = Batch::on(unit).expect("an available unit");

        let judged = batch.judge(&swarm(1), 1, 0..20, 120.0).expect("it fits and is long enough");

        for judged in judged {
            let evidence = judged.evidence;
            assert_eq!(judged.phase, Phase::DISPERSION);
            assert_eq!((evidence.lost, evidence.mean_radius_m), (Some(1.0), 0.0));
            assert_eq!((evidence.contact_onsets_per_s, evidence.stuck), (Some(0.0), 0.0));
        }
    }
}

#[test]
fn two_robots_end_in_some_phase_with_finite_order() {
    for unit in VectorUnit::available() {
        let mut batch = Batch::on(unit).expect("an available unit");

        let judged = batch.judge(&swarm(2), 1, 0..20, 120.0).expect("they fit");

        for judged in judged {
            let evidence = judged.evidence;
            let sum = evidence.rotation + evidence.orbit + evidence.circliness + evidence.stuck;
            assert!(sum.is_finite() && evidence.mean_radius_m > 0.0, "{evidence:?}");
            // Two robots are always equally far from their middle.
            assert!(evidence.fatness < 1e-6, "{evidence:?}");
        }
    }
}
