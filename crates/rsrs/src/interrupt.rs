//! Ctrl-C and SIGTERM: as a flag that long work looks at, and as something to wait for.

use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::Context;
use rsrs_ros::shutdown;

static REQUESTED: AtomicBool = AtomicBool::new(false);

/// Listens for SIGINT and SIGTERM from now on.
///
/// # Returns
///
/// A flag that becomes true at the first signal; work then ends and leaves nothing half-written.
///
/// # Errors
///
/// If the signals cannot be listened for.
pub fn listen() -> anyhow::Result<&'static AtomicBool> {
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()
        .context("starting the signal listener")?;
    std::thread::Builder::new()
        .name("signals".to_owned())
        .spawn(move || {
            if runtime.block_on(shutdown::requested()).is_ok() {
                REQUESTED.store(true, Ordering::Relaxed);
            }
        })
        .context("starting the signal listener")?;
    Ok(&REQUESTED)
}

/// Waits until this process is requested to stop, and returns how.
pub async fn asked_to_stop() -> String {
    match shutdown::requested().await {
        Ok(shutdown::Request::Interrupt) => "interrupted".to_owned(),
        Ok(shutdown::Request::Terminate) => "asked to terminate".to_owned(),
        Err(error) => format!("signals cannot be received: {error}"),
    }
}
