//! The program as its users meet it: one binary of tests, so that what they share is built once.

mod addressing;
mod answering;
mod bags_cli;
mod behaviours;
mod book;
mod by_hand;
mod campaign;
mod cells;
mod choosing;
mod cli;
mod command;
mod compare;
mod deploy;
mod diagnosing;
mod drawing;
mod dry_run;
mod exploring;
mod factors;
mod fleet;
mod fleet_foreign;
mod floor;
mod interop;
mod interop_robot;
mod judge;
mod kills;
mod laboratory;
mod measure;
#[path = "../nodes/robot/tests/robot/micro.rs"]
#[expect(dead_code, reason = "microcontrollers that misbehave are tested beside their driver")]
mod micro;
mod mixed;
mod notebook;
mod out_of_reach;
mod pages;
mod pipeline;
mod placing;
mod processes;
mod protocol;
mod recorded;
mod recording;
mod replay;
mod report;
mod resume;
mod scale;
mod schemas;
#[cfg(feature = "security")]
mod secured_fleet;
mod starting_files;
mod starts;
mod stopping;
mod swept_cells;
mod terminal;
mod tidy;
mod work;
mod worlds;
mod written_files;
