//! Why a range ends where it does: by geometry where that explains it, else by how runs end.

use rsrs_core::diagram::theory::Condition;
use rsrs_core::judge::phase::Phase;
use rsrs_core::quantity::Axis;

use super::curve::Swept;
use crate::swarm::Swarm;
use crate::wording::percent;
use crate::wording::quantity::named;

/// An end of a range.
pub struct Edge<'a> {
    /// What was tried from the recommendation outward, itself first.
    pub outward: Vec<&'a Swept>,
    /// How many of these belong to the range; not all.
    pub n_inside: usize,
}

/// Where fewer runs mill than this share of those at the recommendation, it is plain what goes wrong.
const RARE: f64 = 0.5;

impl Edge<'_> {
    /// What goes wrong beyond it: `with 10 robots 76.0 % mill, and …; with 11 robots, neighbours on the
    /// ring are …`.
    pub fn sentence(&self, axis: Axis) -> String {
        let first = self.outward[self.n_inside];
        let share = percent(milling(first));
        let mill = first.phases.behaviour().verb().plain;
        let value = named(axis, first.value);
        let beyond = format!("with {value} {share} {mill}, and {}", as_runs_end(first));
        let is_rare =
            |index: &usize| milling(self.outward[*index]) < RARE * milling(self.outward[0]);
        let rare = (self.n_inside..self.outward.len()).find(is_rare);
        match rare.and_then(|rare| Some((rare, self.by_theory(rare)?))) {
            None => beyond,
            Some((rare, why)) if rare == self.n_inside => format!("with {value}, {why}"),
            Some((rare, why)) => {
                format!("{beyond}; with {}, {why}", named(axis, self.outward[rare].value))
            }
        }
    }

    /// The condition for an ideal ring that ceases to hold where mills become rare, in words.
    ///
    /// # Returns
    ///
    /// `None` also if up to there robots mill on rings of another kind.
    fn by_theory(&self, rare: usize) -> Option<String> {
        let is_ideal = |swept: &&Swept| {
            let swarm = Swarm::of(&swept.harsher);
            swarm.zip(swept.ring_m).is_some_and(|(swarm, ring_m)| swarm.is_ring(ring_m))
        };
        let (mills, beyond) = (&self.outward[..rare], Swarm::of(&self.outward[rare].harsher)?);
        let meets = |swept: &Swept, condition| {
            Swarm::of(&swept.harsher).and_then(|swarm| swarm.meets(condition)) == Some(true)
        };
        let breaks = |condition: &Condition| {
            mills.iter().all(|swept| meets(swept, *condition))
                && !meets(self.outward[rare], *condition)
        };
        let broken = Condition::ALL.into_iter().find(breaks);
        broken.filter(|_| mills.iter().all(is_ideal)).map(|condition| why(beyond, condition))
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

fn milling(swept: &Swept) -> f64 {
    swept.phases.wanted_share()
}

/// What most runs with a value come to.
fn as_runs_end(swept: &Swept) -> String {
    let phases = &swept.phases;
    let others = phases.behaviour().phases()[1..].iter().rev();
    let phase = *others.max_by_key(|phase| phases.get(**phase)).expect("there are five phases");
    let share = percent(phases.share(phase));
    match phase {
        Phase::SemiStableMilling => format!("the mills do not stay round in {share} of the runs"),
        Phase::Unformed => format!("{share} of the runs come to no mill"),
        Phase::Dispersion => format!("the robots lose each other in {share} of the runs"),
        Phase::CollidingUnstable => format!("the robots block each other in {share} of the runs"),
        other => format!("{share} of the runs end {other}"),
    }
}

/// Both ends of a range in one sentence.
pub fn of(axis: Axis, edges: [Option<String>; 2]) -> String {
    let [below, above] = edges;
    match (axis, below, above) {
        (_, None, None) => format!("the {} does not matter as far as was tried", axis.name()),
        (Axis::Robots, below, Some(above)) => {
            let above = format!("more robots are not always better: {above}");
            below.map_or_else(|| above.clone(), |below| format!("{above}; {below}"))
        }
        (_, below, above) => {
            let edges: Vec<String> = below.into_iter().chain(above).collect();
            edges.join("; ")
        }
    }
}

/// That robots mill too rarely even at the recommendation, and where more often.
pub fn nowhere(axis: Axis, swept: &[Swept], at: Option<&Swept>) -> String {
    let Some(at) = at else { return "it cannot be simulated".to_owned() };
    let most = swept.iter().rev().max_by(|one, other| milling(one).total_cmp(&milling(other)));
    let most = most.filter(|most| milling(most) > milling(at)).map_or_else(
        || "no other value helps".to_owned(),
        |most| format!("at most {}, with {}", percent(milling(most)), named(axis, most.value)),
    );
    let mill = at.phases.behaviour().verb().plain;
    format!("{} {mill}, and {}; {most}", percent(milling(at)), as_runs_end(at))
}
