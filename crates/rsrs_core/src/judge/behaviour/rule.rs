//! Rules that distinguish the phases of a behaviour: bounds on order parameters, in order.

use super::condition::{Condition, Needs};
use super::phase::Phase;
use crate::judge::order::{OrderParameters, Parameter};
use crate::judge::window::Window;

/// A phase, and what must hold for it.
#[derive(Clone, Debug, PartialEq)]
pub struct Rule {
    /// The phase.
    pub phase: Phase,
    /// All of them must hold.
    pub conditions: Vec<Condition>,
}

impl Rule {
    /// Whether every condition holds.
    pub fn holds(&self, evidence: &OrderParameters) -> bool {
        self.conditions.iter().all(|condition| condition.holds(evidence))
    }
}

/// The rules of a behaviour: the first one that holds gives the phase.
#[derive(Clone, Debug, PartialEq)]
pub struct Rules {
    /// In the order in which the judge looks.
    pub rules: Vec<Rule>,
    /// The phase if none holds.
    pub otherwise: Phase,
    /// The phase that the behaviour is named for.
    pub wanted: Phase,
    /// The phase of a run that shows the wanted one on the whole but does not stay in it.
    pub not_lasting: Phase,
    /// Which time of a run is judged.
    pub window: Window,
    /// Order parameters that are measured besides those that rules look at, and decide nothing.
    pub also: Vec<Parameter>,
}

/// One of so many blocks of the window may break the rule of the wanted phase, and one of any window: a ring in
/// which a single robot strays for a moment is still one.
pub const BLOCKS_OF_A_STRAY: usize = 6;

impl Rules {
    /// The phase of a swarm with these order parameters, by the first rule that holds: that of the
    /// whole window, before [`Self::lasting`].
    pub fn phase(&self, evidence: &OrderParameters) -> Phase {
        let holding = self.rules.iter().find(|rule| rule.holds(evidence));
        holding.map_or(self.otherwise, |rule| rule.phase)
    }

    /// The phases that are possible where some order parameters are not known, in the order in which the
    /// judge looks; one alone if what is not known decides nothing.
    pub fn possible(
        &self,
        evidence: &OrderParameters,
        is_known: impl Fn(Parameter) -> bool,
    ) -> Vec<Phase> {
        let mut phases = Vec::new();
        for Rule { phase, conditions } in &self.rules {
            let mut known = conditions.iter().filter(|condition| is_known(condition.parameter));
            if !known.all(|condition| condition.holds(evidence)) {
                continue;
            }
            if !phases.contains(phase) {
                phases.push(*phase);
            }
            if conditions.iter().all(|condition| is_known(condition.parameter)) {
                return phases;
            }
        }
        phases.push(self.otherwise);
        phases
    }

    /// Whether any of them looks at what robots were commanded.
    pub fn need_commands(&self) -> bool {
        self.conditions().any(|condition| condition.parameter.needs_commands())
    }

    /// The order parameters that they look at, each once.
    pub fn parameters(&self) -> Vec<Parameter> {
        Parameter::all().filter(|it| self.ask_for(*it)).collect()
    }

    /// Those of them, and of [`Self::also`], that are measured only where they are asked for.
    pub fn asked(&self) -> Vec<Parameter> {
        let is_asked =
            |it: &Parameter| it.is_asked() && (self.ask_for(*it) || self.also.contains(it));
        Parameter::all().filter(is_asked).collect()
    }

    fn conditions(&self) -> impl Iterator<Item = &Condition> {
        self.rules.iter().flat_map(|rule| &rule.conditions)
    }

    /// Whether the rule of the wanted phase alone holds, as blocks of a run are held against it.
    pub fn is_wanted(&self, evidence: &OrderParameters) -> bool {
        self.of(self.wanted).any(|rule| rule.holds(evidence))
    }

    /// How far the order parameters are from where the wanted phase begins: the least distance to a bound of
    /// its rule, negative where that is not kept; dimensionless. Of several rules it is the nearest one.
    pub fn wanted_margin(&self, evidence: &OrderParameters) -> f64 {
        let distance = |condition: &Condition| {
            let over = condition.parameter.of(evidence) - condition.bound;
            match condition.needs {
                Needs::AtLeast => over,
                Needs::Below | Needs::AtMost => -over,
            }
        };
        let least =
            |rule: &Rule| rule.conditions.iter().map(distance).fold(f64::INFINITY, f64::min);
        self.of(self.wanted).map(least).fold(f64::NEG_INFINITY, f64::max)
    }

    /// The phase of a run whose whole window shows `whole` by [`Self::phase`], and `n_good` of whose
    /// `n_blocks` blocks of 10 s satisfy the rule of the wanted phase by themselves: a mill that tears
    /// apart inside the window is not stable, however good it is on average.
    ///
    /// # Source
    ///
    /// Of nine rules this meets most labels by eye: `docs/judge_by_eye.md`.
    pub fn lasting(&self, whole: Phase, n_good: usize, n_blocks: usize) -> Phase {
        let n_stray = (n_blocks / BLOCKS_OF_A_STRAY).max(1);
        if whole == self.wanted && n_good + n_stray < n_blocks {
            return self.not_lasting;
        }
        whole
    }

    /// The rules that give a phase.
    pub fn of(&self, phase: Phase) -> impl Iterator<Item = &Rule> {
        self.rules.iter().filter(move |rule| rule.phase == phase)
    }

    /// Whether any of them looks at an order parameter.
    pub fn ask_for(&self, parameter: Parameter) -> bool {
        self.conditions().any(|condition| condition.parameter == parameter)
    }

    /// The bound of the wanted phase on an order parameter; `None` if it has none.
    pub fn wanted_bound(&self, parameter: Parameter) -> Option<f64> {
        let mut conditions = self.of(self.wanted).flat_map(|rule| &rule.conditions);
        Some(conditions.find(|condition| condition.parameter == parameter)?.bound)
    }

    /// The same rules with another bound of the wanted phase on an order parameter.
    #[must_use]
    pub fn with_wanted_bound(mut self, parameter: Parameter, bound: f64) -> Self {
        let wanted = self.wanted;
        let rules = self.rules.iter_mut().filter(|rule| rule.phase == wanted);
        for condition in rules.flat_map(|rule| &mut rule.conditions) {
            if condition.parameter == parameter {
                condition.bound = bound;
            }
        }
        self
    }
}
