//! What a run would be labelled for every reach that its robots might have.

use crate::judge::order::nearest_neighbours_m;
use crate::judge::trajectory::{Bodies, Trajectory};

use super::{Phase, Rules, label_with};

/// How closely the reach is found from which on another phase holds, in metres.
const RESOLUTION_M: f64 = 1e-3;

/// The phase from each reach on, in metres and ascending, the first one from 0: the more robots
/// reach, the fewer are lost. The trajectory is finite throughout, and at least as long as what is
/// judged.
pub fn phases(trajectory: &Trajectory, bodies: &Bodies, rules: &Rules) -> Vec<(f64, Phase)> {
    let phase = |reach_m: f64| {
        let bodies = Bodies { reach_m: Some(reach_m), ..bodies.clone() };
        label_with(trajectory, &bodies, rules)
            .expect("a trajectory that was checked is judged where the reach is known")
            .phase
    };
    let n_samples = trajectory.n_samples();
    let n_needed = rules.window.n_needed(n_samples, trajectory.period_s);
    let farthest_m = (n_samples - n_needed..n_samples)
        .flat_map(|sample| nearest_neighbours_m(trajectory.poses_at(sample)))
        .filter(|distance_m| distance_m.is_finite())
        .fold(0.0, f64::max);
    let (least, most) = (Step { reach_m: 0.0, phase: phase(0.0) }, phase(farthest_m));
    let mut phases = vec![(0.0, least.phase)];
    between(least, Step { reach_m: farthest_m, phase: most }, &phase, &mut phases);
    phases
}

/// A reach and its phase.
#[derive(Clone, Copy)]
struct Step {
    reach_m: f64,
    phase: Phase,
}

/// Halves the way between two reaches until each change of phase is found.
fn between(from: Step, to: Step, phase: &impl Fn(f64) -> Phase, phases: &mut Vec<(f64, Phase)>) {
    if from.phase == to.phase {
        return;
    }
    if to.reach_m - from.reach_m <= RESOLUTION_M {
        phases.push((to.reach_m, to.phase));
        return;
    }
    let reach_m = from.reach_m.midpoint(to.reach_m);
    let middle = Step { reach_m, phase: phase(reach_m) };
    between(from, middle, phase, phases);
    between(middle, to, phase, phases);
}

/// `dispersion below 0.51 m, stable milling from 0.51 m on`.
pub fn in_words(phases: &[(f64, Phase)]) -> String {
    let words = phases.iter().enumerate().map(|(index, (from_m, phase))| {
        match (index, phases.get(index + 1)) {
            (0, Some((below_m, _))) => format!("{phase} below {below_m:.2} m"),
            (0, None) => format!("{phase} at any reach"),
            _ => format!("{phase} from {from_m:.2} m on"),
        }
    });
    words.collect::<Vec<_>>().join(", ")
}
