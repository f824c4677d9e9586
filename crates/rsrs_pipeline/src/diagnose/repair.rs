//! Which changes make robots mill: each capability by itself, and the fewest of them that a robot needs
//! which is perfect in everything else.

use rsrs_core::quantity::{Axis, Cell};

use crate::best_setting::search::{Changes, Confirmed, Search, Tried, promising};

use super::improvement::{Improvement, designs, imperfections};
use super::{Hopeless, NeededChange};

/// What was found.
pub struct Repairs {
    /// Changes that suffice, the most relevant first.
    pub causes: Vec<NeededChange>,
    /// What is of no help by itself.
    pub hopeless: Vec<Hopeless>,
}

/// A value of a improvement.
#[derive(Clone, Debug)]
struct Step {
    improvement: Improvement,
    value: f64,
}

/// A change that suffices, as far as some hundred runs show, and the settings in which it does.
struct Sufficient {
    step: Step,
    tried: Vec<Tried>,
}

/// What came of the values of a improvement.
struct Outcome {
    /// The nearest that suffices.
    sufficient: Option<Sufficient>,
    /// The one that helped most.
    best: Best,
}

/// The value of a improvement that helped most, and its best setting, if it has any.
type Best = (Step, Option<Tried>);

fn share((_, tried): &Best) -> f64 {
    tried.as_ref().map_or(0.0, |tried| tried.share.value())
}

/// Finds the changes after which robots mill, from the settings that were tried with the robot as
/// it is.
pub fn repairs(search: &Search<'_>, unchanged: &[Tried]) -> anyhow::Result<Repairs> {
    let noise = imperfections(&search.source.profile);
    let needs = needs(search, &noise)?;
    let cells = promising(&[unchanged, &needs.tried]);
    let (mut alone, mut short) = (Vec::new(), Vec::new());
    for improvement in noise.into_iter().chain(possible_designs(search)) {
        let outcome = outcome(search, &improvement, (&[], Some(&cells)))?;
        match outcome.sufficient {
            Some(sufficient) => alone.push(sufficient),
            None => short.push(outcome.best),
        }
    }
    alone.sort_by(|one, other| one.effort().total_cmp(&other.effort()));
    let is_necessary = |axis: Axis| needs.necessary.contains(&axis);
    // Robots are mended before they are designed anew, unless nothing else helps.
    alone.sort_by_key(|found| {
        let axis = found.step.improvement.axis;
        (!is_necessary(axis), axis.ideal().is_none())
    });

    let mut singles: Vec<NeededChange> = Vec::new();
    for found in alone.iter().take(MOST_SINGLES) {
        let steps = std::slice::from_ref(&found.step);
        let causes = causes(search, steps, [unchanged, &found.tried])?;
        if causes.is_empty() {
            short.push((found.step.clone(), found.tried.first().cloned()));
        }
        singles.extend(causes);
    }
    let mut singles = one_of_each(singles);
    let is_single =
        |step: &Step| singles.iter().any(|cause| cause.capability == step.improvement.axis);
    let mut together = Vec::new();
    if !needs.steps.iter().all(is_single) {
        let tried = search.best_of(&changes(&needs.steps), &cells, "together")?;
        together = causes(search, &needs.steps, [unchanged, &tried])?;
    }
    let pairs = pairs(search, &short, (&cells, unchanged))?;

    for cause in singles.iter_mut().chain(&mut together) {
        cause.necessary = is_necessary(cause.capability);
    }
    // What a robot that is perfect in all else could not do without comes first, then what makes up
    // for it, and then what takes several changes.
    let (first, others): (Vec<NeededChange>, Vec<NeededChange>) =
        singles.into_iter().partition(|cause| cause.necessary);
    let mut causes: Vec<NeededChange> = first.into_iter().chain(others).chain(together).collect();
    let is_new = |pair: &&[NeededChange; 2]| !causes.iter().any(|cause| same(cause, &pair[0]));
    let pairs: Vec<NeededChange> = pairs.iter().filter(is_new).flatten().cloned().collect();
    causes.extend(pairs);
    let hopeless = without_help(search, short, &causes)?;
    Ok(Repairs { causes, hopeless })
}

/// The designs that are commanded where the robots are tried.
fn possible_designs(search: &Search<'_>) -> Vec<Improvement> {
    let all = designs(&search.source.profile).into_iter();
    all.filter(|design| search.may_change(design.axis)).collect()
}

/// So many changes are narrowed down.
const MOST_SINGLES: usize = 5;
/// Changes that help most without being enough are paired, so many of them.
const PAIRED: usize = 5;
/// Of the pairs that suffice, so many are narrowed down.
const MOST_PAIRS: usize = 2;

/// Whether two changes stand for the same set.
fn same(one: &NeededChange, other: &NeededChange) -> bool {
    let set = |cause: &NeededChange| {
        let mut axes = cause.with.clone();
        axes.push(cause.capability);
        axes.sort();
        axes
    };
    set(one) == set(other)
}

/// Pairs of changes that suffice, of those that help most without being enough.
fn pairs(
    search: &Search<'_>,
    short: &[Best],
    (cells, unchanged): (&[Cell], &[Tried]),
) -> anyhow::Result<Vec<[NeededChange; 2]>> {
    let mut helpful: Vec<&Best> = short.iter().collect();
    helpful.sort_by(|one, other| share(other).total_cmp(&share(one)));
    let mut steps: Vec<Step> = Vec::new();
    for (step, _) in helpful {
        if steps.len() < PAIRED
            && steps.iter().all(|kept| kept.improvement.axis != step.improvement.axis)
        {
            steps.push(step.clone());
        }
    }
    let mut found = Vec::new();
    for (position, one) in steps.iter().enumerate() {
        for other in &steps[position + 1..] {
            let pair = [one.clone(), other.clone()];
            let tried = search.best_of(&changes(&pair), cells, "pairs")?;
            if search.suffices(&tried) {
                found.push((pair, tried));
            }
        }
    }
    let most = |tried: &[Tried]| tried[0].share.value();
    found.sort_by(|(_, one), (_, other)| most(other).total_cmp(&most(one)));
    let mut pairs = Vec::new();
    for (pair, tried) in found.iter().take(MOST_PAIRS) {
        let causes = causes(search, pair, [unchanged, tried])?;
        pairs.extend(<[NeededChange; 2]>::try_from(causes).ok());
    }
    Ok(pairs)
}

/// Tries the values of a improvement on top of other changes, until one suffices; in some settings, or all.
fn outcome(
    search: &Search<'_>,
    improvement: &Improvement,
    (others, cells): (&[(Axis, f64)], Option<&[Cell]>),
) -> anyhow::Result<Outcome> {
    let mut best: Option<Best> = None;
    for &value in &improvement.values {
        let step = Step { improvement: improvement.clone(), value };
        let changes: Changes = others.iter().copied().chain([(improvement.axis, value)]).collect();
        let tried = match cells {
            Some(cells) => search.best_of(&changes, cells, improvement.axis.key())?,
            None => search.best(&changes, improvement.axis.key())?,
        };
        let this = (step.clone(), tried.first().cloned());
        if best.as_ref().is_none_or(|most| share(&this) > share(most)) {
            best = Some(this.clone());
        }
        if search.suffices(&tried) {
            let sufficient = Some(Sufficient { step, tried });
            return Ok(Outcome { sufficient, best: this });
        }
    }
    Ok(Outcome { sufficient: None, best: best.expect("a improvement has values") })
}

/// What a robot needs that is perfect in all else.
struct Needs {
    /// The fewest changes; none if nothing suffices.
    steps: Vec<Step>,
    /// Capabilities without whose change it does not mill.
    necessary: Vec<Axis>,
    /// Settings, tried with the perfect robot.
    tried: Vec<Tried>,
}

/// The fewest changes that a robot needs which is otherwise perfect: all noise goes, then the design
/// changes where that is not enough, then comes back what may.
fn needs(search: &Search<'_>, noise: &[Improvement]) -> anyhow::Result<Needs> {
    let ideal = |improvement: &Improvement| Step {
        improvement: improvement.clone(),
        value: improvement.values[0],
    };
    let mut steps: Vec<Step> = noise.iter().map(ideal).collect();
    let mut perfect = search.best(&changes(&steps), "without noise")?;
    let mut designs = possible_designs(search);
    for _ in 0..MOST_DESIGNS {
        if search.suffices(&perfect) {
            break;
        }
        let Some(step) = best_design(search, &steps, &designs)? else { break };
        designs.retain(|design| design.axis != step.improvement.axis);
        steps.push(step);
        perfect = search.best(&changes(&steps), "without noise")?;
    }
    if !search.suffices(&perfect) {
        return Ok(Needs { steps: Vec::new(), necessary: Vec::new(), tried: perfect });
    }
    let cells = promising(&[&perfect]);
    let mut spared = Vec::new();
    let mut kept = Vec::new();
    for left_out in 0..steps.len() {
        let mut others = steps.clone();
        let step = others.remove(left_out);
        let tried = search.best_of(&changes(&others), &cells, "which of it matters")?;
        let share = tried.first().map_or(0.0, |best| best.share.value());
        if search.suffices(&tried) { spared.push((step, share)) } else { kept.push(step) }
    }
    let necessary: Vec<Axis> = kept.iter().map(|step| step.improvement.axis).collect();
    let suffice = |steps: &[Step]| -> anyhow::Result<bool> {
        let tried = search.best_of(&changes(steps), &cells, "the fewest changes")?;
        Ok(search.suffices(&tried))
    };
    if !suffice(&kept)? {
        // What is missed least goes first.
        spared.sort_by(|(_, one), (_, other)| other.total_cmp(one));
        kept.extend(spared.iter().map(|(step, _)| step.clone()));
        for (step, _) in spared {
            let mut others = kept.clone();
            others.retain(|other| other.improvement != step.improvement);
            if suffice(&others)? {
                kept = others;
            }
        }
    }
    Ok(Needs { steps: kept, necessary, tried: perfect })
}

/// So many properties of a design are changed at most.
const MOST_DESIGNS: usize = 3;

/// The change of a design that suffices with the least effort, on top of other changes; else the one
/// that helps most.
fn best_design(
    search: &Search<'_>,
    others: &[Step],
    designs: &[Improvement],
) -> anyhow::Result<Option<Step>> {
    let mut best: Option<(Step, (bool, f64))> = None;
    for design in designs {
        let outcome = outcome(search, design, (&changes(others), None))?;
        let merit = match &outcome.sufficient {
            Some(sufficient) => (true, -sufficient.effort()),
            None => (false, share(&outcome.best)),
        };
        if best.as_ref().is_none_or(|(_, most)| merit > *most) {
            best = Some((outcome.best.0, merit));
        }
    }
    Ok(best.map(|(step, _)| step))
}

impl Sufficient {
    fn effort(&self) -> f64 {
        self.step.improvement.effort(self.step.value)
    }
}

fn changes(steps: &[Step]) -> Changes {
    steps.iter().map(|step| (step.improvement.axis, step.value)).collect()
}

/// The smallest changes that suffice together, all moved by the same share of their way; none if fresh
/// runs confirm none.
fn causes(
    search: &Search<'_>,
    steps: &[Step],
    ends: [&[Tried]; 2],
) -> anyhow::Result<Vec<NeededChange>> {
    let at = |share: f64| -> Changes {
        let towards =
            |step: &Step| (step.improvement.axis, step.improvement.towards(step.value, share));
        steps.iter().map(towards).collect()
    };
    let axes: Vec<&str> = steps.iter().map(|step| step.improvement.axis.key()).collect();
    let doing = format!("how much {}", axes.join(" and "));
    let Some((changes, confirmed)) = search.smallest(&at, ends, &doing)? else {
        return Ok(Vec::new());
    };
    let of = |(step, (axis, value)): (&Step, &(Axis, f64))| {
        let others = changes.iter().map(|(other, _)| *other).filter(|other| other != axis);
        let with: Vec<Axis> = others.collect();
        NeededChange {
            alone: with.is_empty(),
            with,
            ..cause(&step.improvement, (*value, &confirmed))
        }
    };
    Ok(steps.iter().zip(&changes).map(of).collect())
}

fn cause(improvement: &Improvement, (needed, confirmed): (f64, &Confirmed)) -> NeededChange {
    NeededChange {
        capability: improvement.axis,
        now: improvement.now,
        needed,
        b_s: confirmed.b_s,
        b_s_low: confirmed.b_s_low,
        n_replicates: confirmed.n_replicates,
        alone: true,
        with: Vec::new(),
        necessary: false,
        cost: None,
        cell: confirmed.cell.clone(),
    }
}

/// The first change of each capability.
fn one_of_each(causes: Vec<NeededChange>) -> Vec<NeededChange> {
    let mut kept: Vec<NeededChange> = Vec::new();
    for cause in causes {
        if kept.iter().all(|other| other.capability != cause.capability) {
            kept.push(cause);
        }
    }
    kept
}

/// Of the capabilities that do not suffice alone, the value of each that helped most, confirmed in both
/// worlds: robots made worse may do what robots as measured do not.
fn without_help(
    search: &Search<'_>,
    short: Vec<Best>,
    causes: &[NeededChange],
) -> anyhow::Result<Vec<Hopeless>> {
    let mut most: Vec<Best> = Vec::new();
    for found in short {
        let capability = found.0.improvement.axis;
        if causes.iter().any(|cause| cause.alone && cause.capability == capability) {
            continue;
        }
        match most.iter_mut().find(|(step, _)| step.improvement.axis == capability) {
            Some(other) if share(other) < share(&found) => *other = found,
            Some(_) => {}
            None => most.push(found),
        }
    }
    let confirmed = |(step, tried): Best| -> anyhow::Result<Hopeless> {
        let changes = changes(std::slice::from_ref(&step));
        let (b_s, n_replicates) = match tried {
            Some(tried) => {
                let confirmed = search.confirmed(&changes, &tried.cell, 0)?;
                (confirmed.b_s, confirmed.n_replicates)
            }
            None => (0.0, 0),
        };
        let Step { improvement, value: best } = step;
        let (capability, now) = (improvement.axis, improvement.now);
        Ok(Hopeless { capability, now, best, b_s, n_replicates })
    };
    let mut hopeless = most.into_iter().map(confirmed).collect::<anyhow::Result<Vec<_>>>()?;
    hopeless.sort_by(|one, other| other.b_s.total_cmp(&one.b_s));
    Ok(hopeless)
}
