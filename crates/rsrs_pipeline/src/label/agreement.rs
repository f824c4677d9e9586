//! How far the judge and people agree, and where they do not.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use rsrs_core::judge::agreement::Agreement;
use rsrs_core::judge::phase::Phase;
use serde::Serialize;

use crate::error::{in_one_line, with_help};
use crate::label::human_labels::{self, HumanLabel, JUDGE};
use crate::label::{LabelOptions, label_bag};

/// How far everybody agrees.
#[derive(Debug, Serialize)]
pub struct AgreementReport {
    /// Bags that were looked at.
    pub n_bags: usize,
    /// Everybody against everybody else, where they have bags in common; the judge first.
    pub pairs: Vec<Pair>,
    /// Bags whose labels differ: those first of which the judge is surest, because there somebody is
    /// plainly wrong.
    pub disagreements: Vec<Disagreement>,
    /// Bags that the judge cannot label.
    pub not_judged: Vec<NotJudged>,
}

/// Two who label.
#[derive(Debug, Serialize)]
pub struct Pair {
    /// Their names.
    pub by: [String; 2],
    /// How far they agree.
    #[serde(flatten)]
    pub agreement: Agreement,
}

/// A bag to look at again.
#[derive(Debug, Serialize)]
pub struct Disagreement {
    /// The bag.
    pub bag: PathBuf,
    /// The label by each of them.
    pub labels: BTreeMap<String, Phase>,
    /// How far the judge's order parameters are from another phase; `None` if it has not judged, or
    /// there is no such phase.
    pub distance: Option<f64>,
}

/// A bag without the judge's label.
#[derive(Debug, Serialize)]
pub struct NotJudged {
    /// The bag.
    pub bag: PathBuf,
    /// Why.
    pub reason: String,
}

/// One bag with all labels.
struct Seen {
    bag: PathBuf,
    /// The phase by who gave it.
    labels: BTreeMap<String, Phase>,
    distance: Option<f64>,
    refusal: Option<String>,
}

/// Compares the labels of the judge and of people.
pub fn agreement(bags: &[PathBuf], options: LabelOptions) -> anyhow::Result<AgreementReport> {
    let labels = bags.iter().map(|bag| human_labels::read(bag)).collect::<Result<Vec<_>, _>>()?;
    if labels.iter().all(Vec::is_empty) {
        return Err(with_help(
            "no person has labelled any of these bags",
            "add labels of your own: `rsrs label BAG --as PHASE --by WHO`",
        ));
    }
    let seen: Vec<Seen> =
        bags.iter().zip(&labels).map(|(bag, labels)| look(bag, labels, options)).collect();
    Ok(AgreementReport {
        n_bags: bags.len(),
        pairs: pairs(&seen),
        disagreements: disagreements(&seen),
        not_judged: not_judged(&seen),
    })
}

fn look(bag: &Path, by_hand: &[HumanLabel], options: LabelOptions) -> Seen {
    // Of one person's labels the last one counts.
    let mut labels: BTreeMap<String, Phase> =
        by_hand.iter().map(|label| (label.by.clone(), label.phase)).collect();
    let (mut distance, mut refusal) = (None, None);
    match label_bag(bag, options) {
        Ok(labelled) => {
            labels.insert(JUDGE.to_owned(), labelled.phase);
            let nearest = labelled.certainty.and_then(|certainty| certainty.nearest);
            distance = nearest.map(|nearest| nearest.distance);
        }
        Err(error) => refusal = Some(in_one_line(&error)),
    }
    Seen { bag: bag.to_path_buf(), labels, distance, refusal }
}

fn pairs(seen: &[Seen]) -> Vec<Pair> {
    let people: BTreeSet<&String> = seen.iter().flat_map(|seen| seen.labels.keys()).collect();
    let mut all: Vec<&String> = people.into_iter().collect();
    all.sort_by_key(|name| (*name != JUDGE, *name));
    let couples = all
        .iter()
        .enumerate()
        .flat_map(|(index, one)| all[index + 1..].iter().map(move |other| (*one, *other)));
    couples
        .filter_map(|(one, other)| {
            let both = |seen: &Seen| Some((*seen.labels.get(one)?, *seen.labels.get(other)?));
            let labels: Vec<(Phase, Phase)> = seen.iter().filter_map(both).collect();
            let agreement = Agreement::new(&labels)?;
            Some(Pair { by: [one.clone(), other.clone()], agreement })
        })
        .collect()
}

fn disagreements(seen: &[Seen]) -> Vec<Disagreement> {
    let differ = |seen: &&Seen| seen.labels.values().collect::<BTreeSet<_>>().len() > 1;
    let mut queue: Vec<Disagreement> = seen
        .iter()
        .filter(differ)
        .map(|seen| Disagreement {
            bag: seen.bag.clone(),
            labels: seen.labels.clone(),
            distance: seen.distance,
        })
        .collect();
    let sureness = |bag: &Disagreement| bag.distance.unwrap_or(0.0);
    queue.sort_by(|one, other| sureness(other).total_cmp(&sureness(one)));
    queue
}

fn not_judged(seen: &[Seen]) -> Vec<NotJudged> {
    let refused = |seen: &Seen| Some((seen.bag.clone(), seen.refusal.clone()?));
    seen.iter().filter_map(refused).map(|(bag, reason)| NotJudged { bag, reason }).collect()
}
