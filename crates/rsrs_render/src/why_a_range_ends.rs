//! Why a range ends where it does, in words.

use rsrs_core::diagram::theory::Condition;
use rsrs_core::judge::counts::PhaseCounts;
use rsrs_core::judge::phase::Phase;
use rsrs_core::numerals::percent;
use rsrs_core::quantity::Axis;
use rsrs_pipeline::answer::{Edge, Quantity, Why};
use rsrs_pipeline::swarm::Swarm;

use crate::wording::quantity::named;

/// Why the range of a quantity ends where it does, in one sentence.
pub fn sentence(quantity: &Quantity) -> String {
    let axis = quantity.axis;
    match &quantity.why {
        Why::Nowhere { at: None, .. } => "it cannot be simulated".to_owned(),
        Why::Nowhere { at: Some(at), most } => {
            let most = most.map_or_else(
                || "no other value helps".to_owned(),
                |(value, share)| format!("at most {}, with {}", percent(share), named(axis, value)),
            );
            format!("{}; {most}", mill_and_end(at))
        }
        Why::Ends { below: None, above: None } => {
            format!("the {} does not matter as far as was tried", axis.name())
        }
        Why::Ends { below, above } => {
            let [below, above] =
                [below, above].map(|edge| edge.as_ref().map(|it| beyond(it, axis)));
            match (axis, below, above) {
                (Axis::Robots, below, Some(above)) => {
                    let above = format!("more robots are not always better: {above}");
                    below.map_or_else(|| above.clone(), |below| format!("{above}; {below}"))
                }
                (_, below, above) => {
                    below.into_iter().chain(above).collect::<Vec<String>>().join("; ")
                }
            }
        }
    }
}

/// What goes wrong beyond an end: `with 10 robots 76.0 % mill, and …; with 11 robots, neighbours on the
/// ring are …`.
fn beyond(edge: &Edge, axis: Axis) -> String {
    let first = named(axis, edge.value);
    let ends = format!("with {first} {}", mill_and_end(&edge.phases));
    match &edge.theory {
        None => ends,
        Some((value, swarm, condition)) => {
            let (rare, why) = (named(axis, *value), why(*swarm, *condition));
            if value.total_cmp(&edge.value).is_eq() {
                format!("with {first}, {why}")
            } else {
                format!("{ends}; with {rare}, {why}")
            }
        }
    }
}

/// A condition that does not hold, in words.
fn why(swarm: Swarm, condition: Condition) -> String {
    let ring = swarm.ring;
    let chord_m = ring.chord_m().unwrap_or(f64::INFINITY);
    let balance = swarm.turn_balance().unwrap_or(0.0);
    match condition {
        Condition::Existence => format!(
            "there is no ring: a cone of {:.1}° to either side is too wide for {} robots, of \
             which each would see the next at any distance",
            ring.half_angle_rad.to_degrees(),
            ring.n_robots
        ),
        Condition::Reach => format!(
            "neighbours on the ring are {chord_m:.2} m apart, and the edge of a cone touches bodies \
             up to {:.2} m away",
            ring.longest_chord_m()
        ),
        Condition::Room => "bodies on the ring would touch each other".to_owned(),
        Condition::FastTurnBalance => format!(
            "robots on an ideal ring turn inward in {} of the time, and by false detections alone \
             they do in {}",
            percent(balance),
            percent(ring.false_positive)
        ),
        Condition::SlowTurnBalance => format!(
            "robots on an ideal ring turn inward in {} of the time, and the robot ahead is detected \
             in only {}",
            percent(balance),
            percent(ring.true_positive)
        ),
    }
}

/// How many runs mill, and what most others come to.
fn mill_and_end(phases: &PhaseCounts) -> String {
    let behaviour = phases.behaviour();
    let others = behaviour.phases()[1..].iter().rev();
    let phase = *others.max_by_key(|phase| phases.get(**phase)).expect("there are five phases");
    let share = percent(phases.share(phase));
    let ends = match phase {
        Phase::SEMI_STABLE_MILLING => format!("the mills do not stay round in {share} of the runs"),
        Phase::UNFORMED => format!("{share} of the runs come to no mill"),
        Phase::DISPERSION => format!("the robots lose each other in {share} of the runs"),
        Phase::COLLIDING_UNSTABLE => format!("the robots block each other in {share} of the runs"),
        other => format!("{share} of the runs end {other}"),
    };
    format!("{} {}, and {ends}", percent(phases.wanted_share()), behaviour.verb().plain)
}
