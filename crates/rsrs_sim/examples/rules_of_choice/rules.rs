//! The rules that are compared.

use rsrs_core::diagram::choice::{Worlds, rank};
use rsrs_core::judge::phase::Phase;
use rsrs_core::statistics::interval::Interval;
use rsrs_core::statistics::interval_kind::IntervalKind;

use crate::plane::{Plane, TRUTH};

/// Least lower bound of a viable cell.
pub const VIABLE: f64 = 0.8;

/// More than there are values on an axis.
const SIDE: usize = 16;

/// What a rule chose.
pub struct Outcome {
    pub chosen: Option<usize>,
    /// How many cells it had confirmed.
    pub n_confirmed: u64,
}

type Rule = (&'static str, fn(&Plane, (&Plane, u64)) -> Outcome);

/// The rules, the first as it was and the last as it is.
pub const RULES: [Rule; 4] = [
    ("lower bound ≥ 0.5 when worse, the deepest only", as_it_was),
    ("least share ≥ 0.8, from the deepest on", |swept, truth| {
        let region = |cell: usize| swept.least(cell) >= VIABLE;
        until_confirmed(&by_depth(swept, region), from(truth))
    }),
    ("greatest smoothed least share", |swept, truth| {
        let worlds = both(swept);
        let mut ranked = rank(worlds, IntervalKind::ClopperPearson, VIABLE);
        ranked.sort_by(|one, other| other.smooth.total_cmp(&one.smooth));
        let order: Vec<usize> = ranked.iter().map(|candidate| candidate.index).collect();
        until_confirmed(&order, from(truth))
    }),
    ("smoothed least share ≥ 0.8, from the deepest on", |swept, truth| {
        smoothed(swept, from(truth))
    }),
];

/// The rule of `rsrs choose`.
pub fn smoothed(swept: &Plane, confirm: impl Fn(usize) -> [u64; 2]) -> Outcome {
    let ranked = rank(both(swept), IntervalKind::ClopperPearson, VIABLE);
    let order: Vec<usize> = ranked.iter().map(|candidate| candidate.index).collect();
    until_confirmed(&order, confirm)
}

/// The deepest cell where the lower bound is one half in the world of robots made worse, confirmed
/// there alone.
fn as_it_was(swept: &Plane, truth: (&Plane, u64)) -> Outcome {
    let region = |cell: usize| {
        let counts = &swept.worlds[0].cells[cell].counts;
        Interval::clopper_pearson(counts.get(Phase::STABLE_MILLING), counts.total()).low >= 0.5
    };
    let first = by_depth(swept, region).first().copied();
    let holds = |cell: &usize| is_viable(from(truth)(*cell)[0]);
    Outcome { chosen: first.filter(holds), n_confirmed: u64::from(first.is_some()) }
}

fn both(swept: &Plane) -> Worlds<'_> {
    Worlds { simulated: &swept.worlds[0], as_measured: Some(&swept.worlds[1]) }
}

/// Fresh runs drawn from the truth.
fn from((truth, draw): (&Plane, u64)) -> impl Fn(usize) -> [u64; 2] {
    move |cell| truth.hits(cell, 2 * draw + 1, TRUTH)
}

fn is_viable(hits: u64) -> bool {
    Interval::clopper_pearson(hits, TRUTH).low >= VIABLE
}

fn until_confirmed(order: &[usize], confirm: impl Fn(usize) -> [u64; 2]) -> Outcome {
    let holds = |cell: &usize| confirm(*cell).into_iter().all(is_viable);
    let position = order.iter().position(holds);
    Outcome {
        chosen: position.map(|position| order[position]),
        n_confirmed: position.map_or(order.len(), |position| position + 1) as u64,
    }
}

/// The cells of a region, the deepest first; of equally deep ones, those that mill more often when
/// worse.
fn by_depth(swept: &Plane, region: impl Fn(usize) -> bool) -> Vec<usize> {
    let n_cells = swept.worlds[0].cells.len();
    let places: Vec<[usize; 2]> = (0..n_cells).map(|cell| swept.place(cell)).collect();
    let inside: Vec<bool> = (0..n_cells).map(region).collect();
    // The plane with a border that is outside.
    let mut is_inside = [[false; SIDE]; SIDE];
    for (place, inside) in places.iter().zip(&inside) {
        is_inside[place[0] + 1][place[1] + 1] = *inside;
    }
    let depth = |cell: usize| {
        let here = places[cell].map(|position| position + 1);
        let mut least = usize::MAX;
        for (x, row) in is_inside.iter().enumerate() {
            for (y, inside) in row.iter().enumerate() {
                if !inside {
                    least = least.min(x.abs_diff(here[0]).pow(2) + y.abs_diff(here[1]).pow(2));
                }
            }
        }
        least
    };
    let mut order: Vec<(usize, usize)> =
        (0..n_cells).filter(|cell| inside[*cell]).map(|cell| (depth(cell), cell)).collect();
    let share = |cell: usize| swept.shares(cell)[0];
    order.sort_by(|one, other| {
        other.0.cmp(&one.0).then(share(other.1).total_cmp(&share(one.1))).then(one.1.cmp(&other.1))
    });
    order.into_iter().map(|(_, cell)| cell).collect()
}
