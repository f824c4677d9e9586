//! Runs that ended before they were completed, as errors.

use rsrs_bags::METADATA;
use rsrs_files::quoted;
use rsrs_fleet::message::E_STOP_REASON;
use rsrs_fleet::record::EndingKind;
use rsrs_pipeline::error::with_help;
use rsrs_pipeline::run_summary::RunSummary;
use rsrs_ros::ros_args::OtherMiddleware;

/// Refuses a run that was aborted or failed, with where its recording is, and with what may have kept
/// robots from being found.
pub fn refuse_unfinished(
    summary: &RunSummary,
    other_middleware: Option<OtherMiddleware>,
) -> anyhow::Result<()> {
    if let EndingKind::Completed | EndingKind::Void = summary.ending {
        return Ok(());
    }
    let kept = summary.bag.as_ref().map(|bag| {
        let recover = if bag.join(METADATA).exists() {
            String::new()
        } else {
            format!(", not closed: `rsrs bag recover {}`", quoted(bag))
        };
        format!("what was recorded is in {}{recover}", bag.display())
    });
    let release = "when the floor is safe, `rsrs stop --release` lets the next run start";
    let release = (summary.reason == E_STOP_REASON).then(|| release.to_owned());
    // Nothing was recorded of a run for which something was not found.
    let middleware = other_middleware.filter(|_| kept.is_none()).map(|other| other.to_string());
    let help: Vec<String> = kept.into_iter().chain(release).chain(middleware).collect();
    let message = format!("run {}: {}", summary.ending.key(), summary.reason.replace("; ", "\n  "));
    Err(if help.is_empty() {
        anyhow::anyhow!(message)
    } else {
        with_help(message, help.join("\n"))
    })
}
