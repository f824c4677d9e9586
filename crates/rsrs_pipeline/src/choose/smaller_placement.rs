//! Whether a cell that is not viable would be, if its robots started closer together.

use rsrs_core::conditions::{Conditions, Placement};
use rsrs_core::statistics::interval::Interval;
use rsrs_sim::sweep::{Runs, SweepError};
use serde::Serialize;

use super::Options;
use crate::sweep::source::ResolvedSweep;

/// A disc in which robots would have to start for a cell to be viable.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct SmallerPlacement {
    /// Radius of the disc, in metres.
    pub placement_radius_m: f64,
    /// Radius of the sweep's disc, in metres.
    pub now_m: f64,
    /// The smaller share of stable mills of both worlds, in fresh runs from the smaller disc.
    pub b_s: f64,
    /// Its exact lower bound, at 95 %.
    pub b_s_low: f64,
    /// Fresh runs in each world.
    pub n_replicates: u64,
}

/// Radii that are tried, as shares of the sweep's; the largest that helps is the answer.
const SHARES: [f64; 3] = [0.8, 0.65, 0.5];

/// Runs that show whether a disc is worth more of them.
const FEW: u64 = 100;
/// A disc from which so much less of the few runs mill than are wanted is not worth more.
const HOPELESS: f64 = 0.1;

/// Runs a cell from smaller discs until it is viable.
///
/// # Returns
///
/// `None` if none of them helps, or the robots of the sweep do not start in a disc.
///
/// # Errors
///
/// If the runs are called off.
pub fn find(
    source: &ResolvedSweep,
    index: usize,
    options: Options<'_>,
) -> anyhow::Result<Option<SmallerPlacement>> {
    let worlds = [Some(source.clone()), source.as_measured()];
    let mut conditions = Vec::new();
    for world in worlds.iter().flatten() {
        conditions.push(world.conditions_of(index)?);
    }
    let Placement::DiscFacingOut { radius_m: now_m } = conditions[0].placement else {
        return Ok(None);
    };
    for share in SHARES {
        // Two decimals are what a tape gives.
        let radius_m = (share * now_m * 100.0).round() / 100.0;
        let placed: Vec<Conditions> = conditions
            .iter()
            .map(|conditions| Conditions {
                placement: Placement::DiscFacingOut { radius_m },
                ..conditions.clone()
            })
            .collect();
        // Too many robots for so small a disc.
        if placed.iter().any(|conditions| conditions.check().is_err()) {
            break;
        }
        let few = Options { confirm: options.confirm.min(FEW), ..options };
        let Some((share, _)) = least(&placed, source, few)? else { break };
        if share < options.viable - HOPELESS {
            continue;
        }
        let Some((b_s, b_s_low)) = least(&placed, source, options)? else { break };
        if b_s_low >= options.viable {
            let n_replicates = options.confirm;
            let found = SmallerPlacement {
                placement_radius_m: radius_m,
                now_m,
                b_s,
                b_s_low,
                n_replicates,
            };
            return Ok(Some(found));
        }
    }
    Ok(None)
}

/// The smaller share of mills of several worlds, with its lower bound; `None` if the robots do not all
/// find a place.
fn least(
    worlds: &[Conditions],
    source: &ResolvedSweep,
    options: Options<'_>,
) -> anyhow::Result<Option<(f64, f64)>> {
    let mut least = (f64::INFINITY, f64::INFINITY);
    for conditions in worlds {
        let runs = Runs {
            seed: source.sweep.seed,
            replicates: options.confirm,
            duration_s: source.sweep.duration_s,
            n_threads: options.execution.n_threads,
        };
        let fresh = options.execution.simulate("starting in a smaller disc", |watch| {
            rsrs_sim::sweep::confirm(conditions, runs, watch)
        });
        let fresh = match fresh {
            Err(error) if is_too_full(&error) => return Ok(None),
            fresh => fresh?,
        };
        let mills = fresh
            .outcomes
            .iter()
            .filter(|outcome| outcome.phase == outcome.phase.behaviour().wanted());
        let (hits, n) = (mills.count() as u64, fresh.outcomes.len() as u64);
        let low = Interval::clopper_pearson(hits, n).low;
        if low < least.1 {
            least = (hits as f64 / n as f64, low);
        }
    }
    Ok(Some(least))
}

fn is_too_full(error: &anyhow::Error) -> bool {
    matches!(error.downcast_ref(), Some(SweepError::Placement { .. }))
}

impl SmallerPlacement {
    /// The sentence for people.
    pub fn text(&self) -> String {
        format!(
            "from a smaller disc it would be: with `placement_radius_m: {}` (now {:.2}) B_s is \
             {:.1} % in {} fresh runs, lower bound {:.1} %; place the robots so, and sweep again",
            self.placement_radius_m,
            self.now_m,
            100.0 * self.b_s,
            self.n_replicates,
            100.0 * self.b_s_low
        )
    }
}
