#![doc = include_str!("../README.md")]
//! # Modules
//!
//! The tests drive the machines of a whole fleet under a seeded fake network.
//!
//! Times are [`std::time::Duration`]s on the monotonic clock of the machine's own host, from
//! any origin; no two hosts' times are ever compared.
//!
//! Reading order: the messages ([`message`]), as they are on the wire ([`wire`]); who has locked all robots
//! ([`e_stop`]); of which run they are ([`epoch`]); who may move ([`robot`], the final gate); who decides
//! ([`controller`]); the world's pace ([`simulator`]); who conducts ([`preflight`], [`placement`], [`geofence`],
//! [`runner`], [`rates`], [`contradictions`]); who stops everything ([`stopper`]); which robots there are
//! ([`fleet_file`]) and what their nodes are set to ([`parameters`]), what is run with them
//! ([`experiment`]), what was run ([`record`]), what people see of it ([`observation`]) and what can go
//! wrong ([`mod@causes`]).

pub mod e_stop;
pub mod epoch;
mod heartbeat;
pub mod message;
pub mod timing;
pub mod wire;

pub mod controller;
pub mod robot;
pub mod simulator;

pub mod contradictions;
pub mod geofence;
pub mod placement;
pub mod preflight;
pub mod rates;
pub mod runner;
pub mod stopper;

pub mod observation;

pub mod causes;
pub mod experiment;
pub mod fleet_file;
pub mod parameters;
pub mod record;
