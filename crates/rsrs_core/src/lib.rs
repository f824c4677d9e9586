//! The method, pure: robots, controller, order parameters, phases, choice and comparison.
//!
//! `rsrs` takes a robot swarm through four steps: measure the robots, build a simulator that is
//! deliberately worse than they are, explore it into a phase diagram, and run the chosen cell on
//! the real fleet. This crate holds what those steps *mean*. It draws no random number, opens no
//! file, reads no clock, and knows neither the simulator nor the middleware.
//!
//! Reading order: how a robot is measured ([`plan`], [`trial`], [`fit`], [`gain`], [`variance`]); what
//! it is ([`profile`]), how it is made worse ([`harsher`]) and whether
//! it is ([`capability`], [`validation`]); the conditions
//! of one experiment ([`conditions`], the paper's `E`) and how a sweep file spans them ([`axis`],
//! [`sweep_file`]); what a robot does ([`controller`], [`unicycle`]); what a swarm did
//! ([`trajectory`], [`order`], over any [`number`], [`phase`]), how sure that is ([`certainty`]) and
//! who says the same ([`agreement`]), and what geometry expects of it ([`theory`]); what follows
//! for a cell ([`diagram`], [`interval`], [`sequence`], [`choice`]), where to simulate more
//! ([`adaptive`]), and for the method ([`operator_conditions`],
//! [`comparison`], [`pooled`], [`e_value`]).

#![expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "counts and steps are floats only where values of any axis are; they are checked before"
)]
#![expect(
    clippy::missing_panics_doc,
    reason = "`expect` says what cannot happen; what can is documented"
)]
#![expect(
    clippy::result_large_err,
    reason = "errors of documents are made once and printed; boxes would hide their fields"
)]

pub mod axis;
pub mod conditions;
pub mod harsher;
pub mod profile;
pub mod start_file;
pub mod sweep_file;

pub mod capability;
pub mod fit;
pub mod gain;
pub mod plan;
pub mod trial;
pub mod validation;
pub mod variance;

pub mod controller;
pub mod unicycle;

pub mod agreement;
pub mod certainty;
pub mod number;
pub mod order;
pub mod phase;
pub mod theory;
pub mod trajectory;

pub mod adaptive;
mod beta;
pub mod choice;
pub mod comparison;
pub mod diagram;
pub mod e_value;
pub mod interval;
pub mod interval_kind;
pub mod next_experiment;
pub mod operator_conditions;
pub mod pooled;
mod posterior;
mod quantile;
pub mod sequence;
pub mod settling;
pub mod share;

pub mod digest;
pub mod document;
