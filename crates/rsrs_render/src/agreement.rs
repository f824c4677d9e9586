//! How far the judge and people agree, in words.

use rsrs_core::judge::agreement::Agreement;
use rsrs_pipeline::label::agreement::{AgreementReport, Pair};

/// How far everybody agrees, and what to look at again.
pub fn text(report: &AgreementReport) -> String {
    let mut lines: Vec<String> = report.pairs.iter().map(of_pair).collect();
    if report.pairs.is_empty() {
        lines.push("no two have labelled the same bag".to_owned());
    }
    lines.push(match report.disagreements.len() {
        0 => "no labels disagree".to_owned(),
        n => format!("look again at {n} of {} bags:", report.n_bags),
    });
    for bag in &report.disagreements {
        let labels: Vec<String> =
            bag.labels.iter().map(|(who, phase)| format!("{phase} by {who}")).collect();
        let distance = bag.distance.map_or_else(String::new, |distance| {
            format!(" (the judge is {distance:.2} from another phase)")
        });
        lines.push(format!("  {}: {}{distance}", bag.bag.display(), labels.join(", ")));
    }
    lines.extend(report.not_judged.iter().map(|bag| format!("not judged: {}", bag.reason)));
    lines.join("\n")
}

fn of_pair(pair: &Pair) -> String {
    let [one, other] = &pair.by;
    let Agreement { n, n_same, share, share_interval, kappa, kappa_interval, .. } = pair.agreement;
    let kappa = match kappa.zip(kappa_interval) {
        Some((kappa, interval)) => format!(
            "Cohen's kappa {kappa:.2} (95 % interval {:.2} to {:.2})",
            interval.low, interval.high
        ),
        None => "no kappa, because both gave every bag the same label".to_owned(),
    };
    format!(
        "{one} and {other}: {kappa}; the same label on {n_same} of {n} bags, {:.0} % \
         ({:.0} to {:.0} %)",
        100.0 * share,
        100.0 * share_interval.low,
        100.0 * share_interval.high
    )
}
