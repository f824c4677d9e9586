//! Why a robot stands.

use crate::message::{E_STOP_REASON, StopCause};

/// Why a robot of a simulator stands whose run was paused while somebody placed another world.
pub(crate) const WORLD_REPLACED: &str = "its world was placed anew";

/// Why a robot stands.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum StandReason {
    /// It belongs to no run.
    #[error("belongs to no run")]
    Idle,
    /// Its node has just started, and asks the others what the e-stop has locked.
    #[error("just started: asks the other robots for the e-stop")]
    Asking,
    /// It belongs to no run, and to no world either: its simulator has none.
    #[error("its simulator has placed no world: set its `conditions`")]
    WithoutWorld,
    /// It waits for the start.
    #[error("armed, waiting for the start")]
    Armed,
    /// No lease has echoed a recent enough status.
    #[error("lease ran out")]
    LeaseLapsed,
    /// Its controller has been silent, or drives with other parameters than the runner confirmed.
    #[error("controller silent or its parameters not the confirmed ones")]
    ControllerUnconfirmed,
    /// The e-stop is engaged, or its publisher has fallen silent during the run.
    #[error("{E_STOP_REASON}")]
    EStop,
    /// It stands until a newer epoch arms it.
    #[error("{0}")]
    Latched(String),
    /// Its hardware failed.
    #[error("hardware fault: {0}")]
    Fault(String),
}

impl StandReason {
    /// What others decide by.
    pub fn cause(&self) -> StopCause {
        match self {
            Self::Idle => StopCause::NoRun,
            Self::Asking => StopCause::Asking,
            Self::WithoutWorld => StopCause::NoWorld,
            Self::Armed => StopCause::Waiting,
            Self::LeaseLapsed => StopCause::Lease,
            Self::ControllerUnconfirmed => StopCause::Controller,
            Self::EStop => StopCause::EStop,
            Self::Latched(_) => StopCause::Latched,
            Self::Fault(_) => StopCause::Hardware,
        }
    }
}
