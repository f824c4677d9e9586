//! Labels as a person reads them.

use std::fmt;

use rsrs_core::judge::certainty::Certainty;
use rsrs_core::judge::rule::Parameter;

use rsrs_fleet::record::Backend;

use super::{LOOK_AGAIN, Labelled, RunPart};

/// The label, and below it what else is to be known of it.
impl fmt::Display for Labelled {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.write_phase(out)?;
        if let Some(backend) = self.backend.filter(|backend| *backend != Backend::Fleet) {
            write!(out, "\n  robots moved by: {}", backend.in_words())?;
        }
        for sentence in &self.why {
            write!(out, "\n  why: {sentence}")?;
        }
        // How sure a phase is of poses that cannot be is of no use.
        if let Some(certainty) = self.certainty.as_ref().filter(|_| self.implausible.is_empty()) {
            write!(out, "\n  {}", sure(certainty))?;
        }
        for finding in &self.findings {
            let what = if finding.is_mended() { "mended" } else { "note" };
            write!(out, "\n  {what}: {finding}")?;
        }
        for found in &self.implausible {
            write!(out, "\n  implausible (look again): {}", found.text)?;
        }
        for deviation in &self.misplaced {
            write!(out, "\n  start: {deviation}")?;
        }
        for label in &self.labels {
            let differs = if label.phase == self.phase { "" } else { "; differs" };
            write!(out, "\n  by hand: {label}{differs}")?;
        }
        if !self.controller_only.is_empty() {
            write!(out, "\n  lease: controller only: {}", self.controller_only.join(", "))?;
        }
        for (robot, own) in &self.own_profiles {
            write!(out, "\n  {robot}: {own}")?;
        }
        for lost in &self.lost_robots {
            write!(out, "\n  {lost}")?;
        }
        match self.counts_without_lost {
            Some(true) => write!(
                out,
                "\n  none was lost before the judged time: by `robot_lost: abort_until_judged` of its \
                 experiment the run counts"
            )?,
            Some(false) => write!(out, "\n  it counts only `--with-lost-robots`")?,
            None => {}
        }
        for paused in &self.paused_robots {
            write!(out, "\n  {paused}")?;
        }
        if let Some(ending) = self.ending {
            let reason = self.reason.as_deref().unwrap_or_default();
            write!(out, "\n  the run was not completed: {ending} ({reason})")?;
        }
        if let Some(RunPart { recorded_s, set_s }) = self.part {
            let of = set_s.map_or_else(String::new, |set_s| format!(" of {set_s:.0} s"));
            write!(out, "\n  only a part of the run: {recorded_s:.1} s{of}; it counts nowhere")?;
        }
        match &self.damage {
            Some(damage) => write!(out, "\n  {damage}"),
            None => Ok(()),
        }
    }
}

impl Labelled {
    /// The phase, and what it rests on.
    fn write_phase(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "{}: {}", self.bag.display(), self.phase)?;
        if let (Some(evidence), Some(n_robots), Some(duration_s)) =
            (&self.evidence, self.n_robots, self.duration_s)
        {
            let lost = match evidence.lost {
                Some(lost) => format!("lost {lost:.2}"),
                None => "lost unknown without the robots' reach".to_owned(),
            };
            let asks_for_clusters = self.phase.behaviour().rules().ask_for(Parameter::Clustered);
            let clustered = evidence.clustered.filter(|_| asks_for_clusters);
            let clustered = clustered.map(|share| format!(", clustered {share:.2}"));
            let last = lost + &clustered.unwrap_or_default();
            write!(
                out,
                " ({n_robots} robots, {duration_s:.0} s; rotation {:.2}, orbit {:.2}, circliness \
                 {:.2} of {:.2}, blocked {:.2}, {last})",
                evidence.rotation,
                evidence.orbit,
                evidence.circliness,
                evidence.circliness_ceiling,
                evidence.blocked
            )?;
        }
        Ok(())
    }
}

/// How sure a verdict is.
fn sure(certainty: &Certainty) -> String {
    let settled = if certainty.is_settled { "settled" } else { LOOK_AGAIN };
    let nearest = certainty.nearest.as_ref().map_or_else(String::new, |nearest| {
        let parameters: Vec<&str> =
            nearest.parameters.iter().map(|parameter| parameter.key()).collect();
        let (phase, distance) = (nearest.becomes, nearest.distance);
        format!("; nearest is {phase}, {distance:.2} away in {}", parameters.join(" and "))
    });
    let blocks = 100.0 * certainty.confidence;
    format!("{settled}{nearest}; {blocks:.0} % of its 10 s blocks show the same phase")
}
