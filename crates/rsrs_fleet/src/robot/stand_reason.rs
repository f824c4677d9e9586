//! Why a robot stands.

use std::fmt;

use crate::message::{E_STOP_REASON, StopCause};

/// Why a robot stands.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum StandReason {
    /// It belongs to no run.
    Idle,
    /// Its node has just started, and asks the others what the e-stop has locked.
    Asking,
    /// It belongs to no run, and to no world either: its simulator has none.
    WithoutWorld,
    /// It waits for the start.
    Armed,
    /// It receives a running lease but was not armed for it, as after a restart.
    NotArmed,
    /// No lease has echoed a recent enough status.
    LeaseLapsed,
    /// Its controller has been silent, or drives with other parameters than the runner confirmed.
    ControllerUnconfirmed,
    /// The e-stop is engaged, or its publisher has fallen silent during the run.
    EStop,
    /// It stands until a newer epoch arms it.
    Latched(String),
    /// Its hardware failed.
    Fault(String),
}

impl fmt::Display for StandReason {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&self.text())
    }
}

impl StandReason {
    /// What others decide by.
    pub fn cause(&self) -> StopCause {
        match self {
            Self::Idle => StopCause::NoRun,
            Self::Asking => StopCause::Asking,
            Self::WithoutWorld => StopCause::NoWorld,
            Self::Armed => StopCause::Waiting,
            Self::NotArmed => StopCause::NotArmed,
            Self::LeaseLapsed => StopCause::Lease,
            Self::ControllerUnconfirmed => StopCause::Controller,
            Self::EStop => StopCause::EStop,
            Self::Latched(_) => StopCause::Latched,
            Self::Fault(_) => StopCause::Hardware,
        }
    }

    /// The reason in words, for people.
    pub fn text(&self) -> String {
        match self {
            Self::Idle => "belongs to no run".to_owned(),
            Self::Asking => "just started: asks the other robots for the e-stop".to_owned(),
            Self::WithoutWorld => {
                "its simulator has placed no world: set its `conditions`".to_owned()
            }
            Self::Armed => "armed, waiting for the start".to_owned(),
            Self::NotArmed => "not armed in this run".to_owned(),
            Self::LeaseLapsed => "lease ran out".to_owned(),
            Self::ControllerUnconfirmed => {
                "controller silent or its parameters not the confirmed ones".to_owned()
            }
            Self::EStop => E_STOP_REASON.to_owned(),
            Self::Latched(reason) => reason.clone(),
            Self::Fault(reason) => format!("hardware fault: {reason}"),
        }
    }
}
