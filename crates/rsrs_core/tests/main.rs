//! The method, on simulated trials, the measured Flockbots, and against other implementations.

mod adaptive;
mod agreement_oracle;
mod capability;
mod certainty;
mod choice;
mod comparison;
mod comparison_oracle;
mod controller_table;
mod error_rates;
mod fit_oracle;
mod flockbot;
#[path = "../examples/make_trials/generate.rs"]
mod generate;
mod impossible;
mod judge;
mod measure;
mod numbers;
mod order;
mod plan;
mod recovery;
mod sensors;
mod tables;
mod trials;
mod windows;
mod world_file;
