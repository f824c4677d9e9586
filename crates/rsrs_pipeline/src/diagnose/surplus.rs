//! What of a robot that mills could be worse.

use crate::best_setting::search::{Changes, Search, Tried};

use super::Spare;
use super::remedy::savings;

/// Finds how much worse each capability may be while all others stay, from the settings that were
/// tried with the robot as it is.
pub fn spare(search: &Search<'_>, unchanged: &[Tried]) -> anyhow::Result<Vec<Spare>> {
    let mut found = Vec::new();
    for remedy in savings(&search.source.profile) {
        let mut fails = None;
        let mut holds = (remedy.now, unchanged.to_vec());
        for &value in &remedy.values {
            let tried = search.again(&vec![(remedy.axis, value)], &holds.1, remedy.axis.key())?;
            if search.suffices(&tried) {
                holds = (value, tried);
            } else {
                fails = Some((value, tried));
                break;
            }
        }
        // From what is too little towards what the robot has.
        let (from, tried) = fails.unwrap_or_else(|| holds.clone());
        let way = super::remedy::Remedy { now: from, ..remedy.clone() };
        let at = |share: f64| -> Changes { vec![(way.axis, way.towards(remedy.now, share))] };
        let smallest = search.smallest(&at, [&tried, &holds.1], remedy.axis.key())?;
        let Some((changes, confirmed)) = smallest else { continue };
        let enough = changes[0].1;
        if (enough - remedy.now).abs() <= 1e-9 {
            continue;
        }
        found.push(Spare {
            capability: remedy.axis,
            now: remedy.now,
            enough,
            b_s: confirmed.b_s,
            b_s_low: confirmed.b_s_low,
            cell: confirmed.cell,
        });
    }
    Ok(found)
}
