//! The experiment runner: one run from preflight to the closed bag.
//!
//! What it decides is [`rsrs_fleet::runner`]; here samples, answers and timers become its events.
//! The recorder uses the same subscriptions, so that a run whose data would be lost does not
//! start, and in lockstep the simulator does not step ahead of the bag.

mod arguments;
pub mod causes;
mod endpoint_compatibility;
mod event_loop;
mod expectation;
mod extras;
mod parameters;
pub mod places;
pub mod plan;
mod recorded_topics;
mod recorder;
mod report;
mod sample_events;
pub mod stop;
pub mod tracked;

pub use event_loop::run;
pub use recorder::RecorderError;
pub use report::{Progress, RunReport};
pub use rsrs_msgs::node_names::RUNNER as NODE;

use anyhow::bail;
use rsrs_fleet::record::{Ending, EndingKind};
use rsrs_ros::environment::Environment;
use rsrs_ros::runtime::runtime;
use rsrs_ros::shutdown;

use arguments::RunnerArguments;
pub use arguments::{Flags, backends, place_checks};
use plan::Plan;

/// Runs the node: one experiment, then it ends.
///
/// A run that was not completed is an error.
pub fn main(flags: Flags) -> anyhow::Result<()> {
    let options = RunnerArguments::new(flags, &Environment::of_this_process())?;
    options.ros.start_logging(options.log_level);
    options.ros.log_notes(NODE);
    let plan = Plan::read(&options.request)?;
    let stop = async {
        match shutdown::requested().await {
            Ok(_) => "interrupted".to_owned(),
            Err(error) => format!("signals cannot be received: {error}"),
        }
    };
    // Its messages go to the log by themselves.
    let mut watch = |_| {};
    let report = runtime()?.block_on(run(&plan, &options.session, &mut watch, stop))?;
    let Ending { kind, reason, .. } = report.ending;
    if kind != EndingKind::Completed {
        bail!("run {}: {reason}", kind.key());
    }
    Ok(())
}
