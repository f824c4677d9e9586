#![doc = include_str!("../README.md")]
//! # Modules
//!
//! Reading order: the world ([`world`]) and its parts, what a robot sees ([`field_of_view`]), what stops it
//! ([`contact`], [`shaped_border`]) or pushes it ([`pushing`]), what disturbs it ([`disturbance`]) or fails ([`failures`]) and where it starts ([`placement`]); its
//! arithmetic ([`turn`], [`draw`]); what decides ([`controllers`]), one run ([`episode`]), some at once ([`batch`]), and many
//! ([`sweep`]); and which controllers to run at all ([`exploration`]).

#![expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "the world is single precision by definition, and its numbers are checked before"
)]

pub mod world;

pub mod contact;
mod detections;
pub mod disturbance;
pub mod failures;
pub mod field_of_view;
mod grid;
mod kinds;
mod numbering;
mod objects;
pub mod placement;
pub mod pushing;
mod robots;
mod sensors;
pub mod shaped_border;
mod wall_sight;
mod wall_view;

pub mod draw;
pub mod turn;
mod vector;

pub mod batch;
pub mod controllers;
pub mod episode;
pub mod exploration;
pub mod reachable_set;
pub mod sweep;
pub mod worlds;
