//! How a node ends: on request, and never later than the process that started it.

use std::io::{self, Write};
use std::os::unix::process::parent_id;
use std::process::ExitCode;

use nix::sys::prctl::set_pdeathsig;
use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use tokio::signal::unix::{self, SignalKind, signal};

use crate::kernel;
use crate::logging;
use crate::session::is_stuck;

/// Who asked a node to end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Request {
    /// `SIGINT`, usually Ctrl-C.
    Interrupt,
    /// `SIGTERM`, usually another program.
    Terminate,
}

/// Receives what asks this process to end.
///
/// From now on, neither signal kills the process any more; a node that died of one would be taken for
/// alive by its peers for the better part of a minute.
#[derive(Debug)]
pub struct Requests {
    interrupt: unix::Signal,
    terminate: unix::Signal,
}

impl Requests {
    /// Begins to receive them, within a runtime.
    pub fn new() -> io::Result<Self> {
        Ok(Self {
            interrupt: signal(SignalKind::interrupt())?,
            terminate: signal(SignalKind::terminate())?,
        })
    }

    /// Waits for one.
    pub async fn next(&mut self) -> Request {
        tokio::select! {
            _ = self.interrupt.recv() => Request::Interrupt,
            _ = self.terminate.recv() => Request::Terminate,
        }
    }
}

/// Waits until this process is asked to end; received is what comes from the first poll on.
pub async fn requested() -> io::Result<Request> {
    Ok(Requests::new()?.next().await)
}

/// Asks another process, of the same user, to end, with `SIGTERM`.
pub fn terminate(pid: u32) -> io::Result<()> {
    let pid =
        i32::try_from(pid).map_err(|error| io::Error::new(io::ErrorKind::InvalidInput, error))?;
    Ok(kill(Pid::from_raw(pid), Signal::SIGTERM)?)
}

/// Why this process would outlive its parent.
#[derive(Debug, thiserror::Error)]
pub enum ParentError {
    /// It has gone already.
    #[error("process {expected} has ended; this process now belongs to {found}")]
    Gone {
        /// Who started this process.
        expected: u32,
        /// Who adopted it.
        found: u32,
    },
    /// The kernel refused.
    #[error("the end of process {expected} cannot be watched")]
    Kernel {
        /// Who started this process.
        expected: u32,
        /// The kernel's error.
        #[source]
        source: io::Error,
    },
}

/// Has the kernel send this process `SIGTERM` when its parent ends, however it ends.
///
/// The kernel watches the *thread* that started this process: start children from a thread that
/// stays. The parent is named by an argument that it gave this process; a process that asked for
/// its own parent could already have been adopted by another.
///
/// # Errors
///
/// [`ParentError::Gone`] if the parent ended before this call.
pub fn die_with_parent(parent: u32) -> Result<(), ParentError> {
    set_pdeathsig(Signal::SIGTERM)
        .map_err(|error| ParentError::Kernel { expected: parent, source: error.into() })?;
    let found = parent_id();
    if found == parent { Ok(()) } else { Err(ParentError::Gone { expected: parent, found }) }
}

/// The exit code of a process, for its `main` to return.
///
/// Where a session could not be left in time ([`Session::close`](crate::session::Session::close)), the
/// process ends here and now: what an ordinary end runs could wait for what was left behind.
pub fn leave(code: u8) -> ExitCode {
    logging::flush();
    if is_stuck() {
        // Who does not read any more misses nothing.
        drop(io::stdout().flush());
        kernel::exit_at_once(code);
    }
    ExitCode::from(code)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_parent_that_has_gone_is_noticed() {
        let error = die_with_parent(u32::MAX).unwrap_err();

        assert!(matches!(error, ParentError::Gone { expected: u32::MAX, .. }), "{error:?}");
        die_with_parent(parent_id()).unwrap();
    }
}
