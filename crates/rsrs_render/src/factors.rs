//! Which of the factors that make robots worse does it, in words.

use rsrs_core::numerals::{count, percent};
use rsrs_core::statistics::share::Share;
use rsrs_pipeline::sweep::ablation::{Ablation, FactorEffect};

use crate::columns::columns;

/// What the factors do, and which does most, or that their runs do not show it.
pub fn text(ablation: &Ablation) -> String {
    shown(ablation).unwrap_or_else(|| {
        format!(
            "{} other runs of each do not show that the factors of `harsher` make robots do worse at {}: {}",
            count(ablation.n_replicates),
            ablation.cell,
            shares(ablation)
        )
    })
}

/// What the factors do, and which does most, where their runs show it: the intervals of the shares with and
/// without them do not overlap.
pub fn shown(ablation: &Ablation) -> Option<String> {
    let n = ablation.n_replicates;
    let interval = |share: f64| Share::from_value(share, n).interval();
    let [measured, all] = [ablation.b_s_as_measured, ablation.b_s_with_all].map(interval);
    if all.low > measured.high {
        return Some(format!(
            "the factors of `harsher` do not make robots do worse at {} ({} other runs of each): {}",
            ablation.cell,
            count(n),
            shares(ablation)
        ));
    }
    (all.high < measured.low).then(|| which(ablation))
}

fn shares(ablation: &Ablation) -> String {
    format!(
        "{} end as wanted with robots as measured, and {} with all factors",
        percent(ablation.b_s_as_measured),
        percent(ablation.b_s_with_all)
    )
}

/// What each factor does, and which does most.
fn which(ablation: &Ablation) -> String {
    let mut lines = vec![format!(
        "which factor of `harsher` makes robots do worse at {} ({} other runs of each):\n  B_s, the share of \
         runs that end as wanted, is {} with robots as measured, and {} with all factors",
        ablation.cell,
        count(ablation.n_replicates),
        percent(ablation.b_s_as_measured),
        percent(ablation.b_s_with_all)
    )];
    let row = |effect: &FactorEffect| {
        [
            format!("  {}", effect.factor),
            format!("({})", effect.meaning),
            format!("alone {}", percent(effect.b_s_alone)),
            format!("all but this one {}", percent(effect.b_s_without)),
        ]
    };
    let rows: Vec<[String; 4]> = ablation.factors.iter().map(row).collect();
    lines.push(columns(&rows));
    lines.push(match ablation.worst() {
        Some(worst) => format!("  {} does most of it", worst.factor),
        None => "  no single factor does much of it".to_owned(),
    });
    lines.join("\n")
}

#[cfg(test)]
mod tests {
    use rsrs_core::quantity::{Axis, Cell};

    use super::*;

    fn ablation(n_replicates: u64, b_s_as_measured: f64, b_s_with_all: f64) -> Ablation {
        let cell = Cell::new([(Axis::Speed, 0.15)]).unwrap();
        Ablation { cell, n_replicates, b_s_as_measured, b_s_with_all, factors: Vec::new() }
    }

    #[test]
    fn factors_are_blamed_or_cleared_only_where_their_runs_show_it() {
        let (never, close) = (ablation(4, 0.0, 0.0), ablation(200, 0.72, 0.81));
        let (worse, better) = (ablation(200, 0.9, 0.5), ablation(200, 0.5, 0.9));

        assert_eq!((shown(&never), shown(&close)), (None, None));
        assert_eq!(
            text(&close),
            "200 other runs of each do not show that the factors of `harsher` make robots do worse at \
             speed_m_s=0.15: 72.0 % end as wanted with robots as measured, and 81.0 % with all factors"
        );
        let blamed =
            "which factor of `harsher` makes robots do worse at speed_m_s=0.15 (200 other runs";
        assert!(text(&worse).starts_with(blamed), "{}", text(&worse));
        let cleared = "the factors of `harsher` do not make robots do worse at speed_m_s=0.15 (200 other runs";
        assert!(text(&better).starts_with(cleared), "{}", text(&better));
    }
}
