//! The runtime of everything that waits for messages.

use anyhow::Context;

/// A runtime on this thread, by whose end the nodes notice that of this process.
pub fn runtime() -> anyhow::Result<tokio::runtime::Runtime> {
    tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()
        .context("starting the runtime")
}
