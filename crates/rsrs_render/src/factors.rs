//! Which of the factors that make robots worse does it, in words.

use rsrs_core::numerals::percent;
use rsrs_pipeline::sweep::ablation::{Ablation, FactorEffect};

use crate::columns::columns;

/// What each factor does, and which does most.
pub fn text(ablation: &Ablation) -> String {
    if ablation.b_s_with_all >= ablation.b_s_as_measured {
        return format!(
            "the factors of `harsher` do not make it worse at {} ({} runs each): {} end as wanted with robots as \
             measured, and {} with all factors",
            ablation.cell,
            ablation.n_replicates,
            percent(ablation.b_s_as_measured),
            percent(ablation.b_s_with_all)
        );
    }
    let mut lines = vec![format!(
        "which factor makes it worse at {} ({} runs each):\n  B_s, the share of runs that end as wanted, \
         is {} with robots as measured, and {} with all factors of `harsher`",
        ablation.cell,
        ablation.n_replicates,
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
