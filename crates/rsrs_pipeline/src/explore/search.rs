//! The two searches: for a behaviour, and for all that differ.

use std::cmp::Reverse;

use rsrs_core::judge::behaviour::Behaviour;
use rsrs_sim::exploration::archive::{Archive, Elite};
use rsrs_sim::exploration::evolution_strategy::EvolutionStrategy;
use rsrs_sim::exploration::space::Point;
use rsrs_sim::sweep::{Progress, confirmation_seed};

use super::ExploreOptions;
use super::journal::Journal;
use super::trial::{Name, TestBed, Trial};
use crate::execution::RunCounter;

/// Controllers that are proposed at once where the archive proposes them.
const GENERATION: usize = 64;
/// Controllers anywhere, of which the best is where the evolution strategy begins.
const FIRST: usize = 64;
/// Its first step, in parts of half the width of the space.
const STEP: f64 = 0.3;
/// Of so many controllers that came nearest to a behaviour ...
const RUN_AGAIN: usize = 24;
/// ... so many more runs are made, ...
const RUNS_AGAIN: u64 = 96;
/// ... and at most so many shown.
const SHOWN: usize = 4;
/// It begins elsewhere once its steps are smaller than this.
const LEAST_STEP: f64 = 0.02;

/// Searches, and returns one controller for each niche; where a behaviour is searched for, of those
/// that came nearest to it.
pub fn search(
    test_bed: &TestBed,
    journal: &mut Journal,
    options: &ExploreOptions,
) -> anyhow::Result<Vec<Trial>> {
    let counter = options.execution.observer.count("searching", "controllers");
    let total = options.controllers;
    counter.begin("searching", Progress { done: journal.len().min(total), total });
    let mut tried = Tried { test_bed, journal, options, counter: &*counter, trials: Vec::new() };
    let archive = match options.wanted {
        None => illuminate(&mut tried)?,
        Some(_) => optimise(&mut tried)?,
    };
    if let Some(wanted) = options.wanted {
        return surest(&tried, wanted);
    }
    Ok(archive.elites().map(|(_, elite)| tried.trials[elite.number].clone()).collect())
}

/// Of the controllers that came nearest to a behaviour those that lead to it most surely, one for each
/// niche: some of the many that were tried were lucky, so they are run again.
fn surest(tried: &Tried, wanted: Behaviour) -> anyhow::Result<Vec<Trial>> {
    let mut nearest: Vec<&Trial> = tried.trials.iter().collect();
    nearest.sort_by(|one, other| other.fitness.total_cmp(&one.fitness));
    nearest.truncate(RUN_AGAIN);
    let seed = confirmation_seed(confirmation_seed(tried.options.seed));
    let mut shares = Vec::new();
    for trial in nearest {
        let trial = Trial { name: Name::Behaviour(wanted), ..trial.clone() };
        let runs = (seed, RUNS_AGAIN);
        let shown = tried.test_bed.confirm(&trial, runs, tried.options)?;
        shares.push((shown.share.hits, trial));
    }
    shares.sort_by_key(|(hits, _)| Reverse(*hits));
    let mut surest: Vec<Trial> = Vec::new();
    for (_, trial) in shares {
        if surest.len() < SHOWN && surest.iter().all(|other| other.niche != trial.niche) {
            surest.push(trial);
        }
    }
    Ok(surest)
}

/// What was tried so far, and how more is.
struct Tried<'a, 'b> {
    test_bed: &'a TestBed,
    journal: &'a mut Journal,
    options: &'a ExploreOptions<'b>,
    counter: &'a dyn RunCounter,
    trials: Vec<Trial>,
}

impl Tried<'_, '_> {
    /// How many more may be tried.
    fn n_left(&self) -> usize {
        self.options.controllers - self.trials.len()
    }

    /// Tries controllers, or reads from the journal what they came to before; as many as may be tried.
    fn try_out(&mut self, points: &[Point]) -> anyhow::Result<&[Trial]> {
        let first = self.trials.len();
        let points = &points[..points.len().min(self.n_left())];
        let known = self.journal.known(first, points.len());
        let is_same = known.iter().zip(points).all(|(trial, point)| same(&trial.point, point));
        anyhow::ensure!(is_same, "the journal is that of another search; remove its folder");
        self.trials.extend_from_slice(known);
        let rest = &points[known.len()..];
        if !rest.is_empty() {
            let trials = self.test_bed.try_out(self.trials.len(), rest, self.options)?;
            self.journal.add(&trials)?;
            self.trials.extend(trials);
        }
        let total = self.options.controllers;
        self.counter.show(Progress { done: self.trials.len(), total });
        Ok(&self.trials[first..])
    }
}

/// Whether two points are one; to the bit, as they are repeated exactly.
fn same(one: &Point, other: &Point) -> bool {
    one.iter().map(|it| it.to_bits()).eq(other.iter().map(|it| it.to_bits()))
}

fn offer(archive: &mut Archive, trials: &[Trial]) {
    for trial in trials {
        let elite = Elite { point: trial.point.clone(), number: trial.number, share: trial.share };
        archive.offer(trial.niche, elite);
    }
}

/// Fills the archive from its own controllers.
fn illuminate(tried: &mut Tried) -> anyhow::Result<Archive> {
    let mut archive = Archive::default();
    let n_numbers = tried.test_bed.space.n_numbers();
    let mut generation = 0;
    while tried.n_left() > 0 {
        let points = archive.propose((GENERATION, n_numbers), tried.options.seed, generation);
        offer(&mut archive, tried.try_out(&points)?);
        generation += 1;
    }
    Ok(archive)
}

/// Follows the evolution strategy, from the best of some anywhere, and from others again.
fn optimise(tried: &mut Tried) -> anyhow::Result<Archive> {
    let mut archive = Archive::default();
    let n_numbers = tried.test_bed.space.n_numbers();
    let seed = tried.options.seed;
    let mut beginning = 0;
    while tried.n_left() > 0 {
        let anywhere = Archive::default().propose((FIRST, n_numbers), seed, u64::MAX - beginning);
        let trials = tried.try_out(&anywhere)?;
        offer(&mut archive, trials);
        let best = trials.iter().max_by(|one, other| one.fitness.total_cmp(&other.fitness));
        let Some(best) = best else { break };
        let mut strategy = EvolutionStrategy::new(&best.point, STEP, seed ^ beginning);
        while strategy.step() > LEAST_STEP && tried.n_left() > 0 {
            let points: Vec<Point> = strategy.sample();
            let trials = tried.try_out(&points)?;
            offer(&mut archive, trials);
            if trials.len() < points.len() {
                break;
            }
            let costs: Vec<f64> = trials
                .iter()
                .zip(&points)
                .map(|(trial, point)| 1.0 - trial.fitness + outside(point))
                .collect();
            strategy.update(&costs);
        }
        beginning += 1;
    }
    Ok(archive)
}

/// How far a point is outside the space; it costs, so that the search stays in it.
fn outside(point: &Point) -> f64 {
    point.iter().map(|coordinate| (coordinate.abs() - 1.0).max(0.0)).sum()
}
