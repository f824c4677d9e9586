//! What else is worth knowing of a setting: how robots fare that start closer together, or are others in
//! number.

use rsrs_core::conditions::{Conditions, Placement};
use rsrs_core::diagram::choice::{Choice, DenserStart, OtherNumber};
use rsrs_core::statistics::share::Share;
use rsrs_sim::sweep::SweepError;

use super::{Best, SearchOptions, confirm};
use crate::sweep::source::ResolvedSweep;

/// Radii of discs over that of the setting's.
const SHARES: [f64; 3] = [0.8, 0.65, 0.5];
/// Runs that show whether a disc is worth more of them, and those of another number of robots.
const FEW: u64 = 100;
/// A disc from which so much less of the few runs end as wanted is not worth more.
const HOPELESS: f64 = 0.1;
/// Numbers of robots over that of the setting.
const MORE: [isize; 4] = [-2, -1, 1, 2];

/// Runs the setting with other starts and numbers, in both worlds.
pub fn add(
    source: &ResolvedSweep,
    best: &mut Best,
    options: SearchOptions<'_>,
) -> anyhow::Result<()> {
    let mut worlds = vec![source.conditions_of(best.index)?];
    if let Some(measured) = source.as_measured() {
        worlds.push(measured.conditions_of(best.index)?);
    }
    let setting = Setting { source, worlds, options };
    best.choice.robots = Some(setting.worlds[0].robots);
    best.choice.denser_start = setting.denser_start(&best.choice)?;
    best.choice.other_numbers = setting.other_numbers()?;
    Ok(())
}

struct Setting<'a> {
    source: &'a ResolvedSweep,
    /// The robots made worse, and as measured if those are others.
    worlds: Vec<Conditions>,
    options: SearchOptions<'a>,
}

impl Setting<'_> {
    /// The setting in both worlds with something changed; `None` if the robots find no place then.
    fn changed(&self, change: impl Fn(&mut Conditions)) -> Option<Vec<Conditions>> {
        let mut worlds = self.worlds.clone();
        worlds.iter_mut().for_each(change);
        worlds.iter().all(|world| world.check().is_ok()).then_some(worlds)
    }

    /// The share in the world in which it is smaller; `None` if the robots do not always find a place.
    fn least(&self, worlds: &[Conditions], replicates: u64) -> anyhow::Result<Option<Share>> {
        let runs = match confirm(worlds, self.source, (replicates, self.options)) {
            Err(error) if error.is::<SweepError>() => return Ok(None),
            runs => runs?,
        };
        let shares = runs.counts(worlds.len());
        Ok(shares.iter().map(Share::milling).min_by_key(|share| share.hits))
    }

    /// Where the setting is not viable, the largest disc from which it is; else that from which most runs
    /// end as wanted; `None` if the robots do not start in a disc, or fit into no smaller one.
    fn denser_start(&self, choice: &Choice) -> anyhow::Result<Option<DenserStart>> {
        let Placement::DiscFacingOut { radius_m: now_m } = self.worlds[0].placement else {
            return Ok(None);
        };
        let mut discs = Vec::new();
        for share in SHARES {
            // Two decimals are what a tape gives.
            let radius_m = (share * now_m * 100.0).round() / 100.0;
            let placement = Placement::DiscFacingOut { radius_m };
            let Some(worlds) = self.changed(|world| world.placement = placement.clone()) else {
                continue;
            };
            let few = self.least(&worlds, self.options.confirm.min(FEW))?;
            discs.extend(few.map(|few| (radius_m, worlds, few.value())));
        }
        let wanted = self.options.wanted;
        let is_viable = choice.is_viable(wanted);
        let is_worth_it = |few: f64| few >= wanted - HOPELESS;
        let is_hopeless = !discs.iter().any(|(_, _, few)| is_worth_it(*few));
        if is_viable || is_hopeless {
            discs.sort_by(|(_, _, one), (_, _, other)| other.total_cmp(one));
        } else {
            discs.retain(|(_, _, few)| is_worth_it(*few));
        }
        let mut found: Option<DenserStart> = None;
        for (placement_radius_m, worlds, _) in discs {
            let Some(share) = self.least(&worlds, self.options.confirm)? else { continue };
            let b_s_low = share.interval().low;
            if found.is_none_or(|best| b_s_low > best.b_s_low) {
                let (b_s, n_replicates) = (share.value(), share.n);
                found = Some(DenserStart { placement_radius_m, now_m, b_s, b_s_low, n_replicates });
            }
            if is_viable || b_s_low >= wanted || is_hopeless {
                break;
            }
        }
        Ok(found)
    }

    fn other_numbers(&self) -> anyhow::Result<Vec<OtherNumber>> {
        if matches!(self.worlds[0].placement, Placement::Given { .. }) {
            return Ok(Vec::new());
        }
        let mut numbers = Vec::new();
        for more in MORE {
            let robots = self.worlds[0].robots.checked_add_signed(more).filter(|n| *n > 1);
            let Some(robots) = robots else { continue };
            let Some(worlds) = self.changed(|world| world.robots = robots) else { continue };
            let share = self.least(&worlds, self.options.confirm.min(2 * FEW))?;
            numbers.extend(share.map(|share| {
                let interval = share.interval();
                let (b_s_low, b_s_high) = (interval.low, interval.high);
                OtherNumber { robots, b_s: share.value(), b_s_low, b_s_high, n_replicates: share.n }
            }));
        }
        Ok(numbers)
    }
}
