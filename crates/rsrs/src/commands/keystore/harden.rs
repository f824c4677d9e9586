//! `rsrs keystore harden`: a keystore of SROS2, made such that robots of ours can use it.

use std::path::PathBuf;

use rsrs_keystore::harden::{Hardened, harden};
use rsrs_pipeline::error::helped;
use rsrs_render::keystore as render;

use crate::commands::{Format, report};
use crate::failure::Outcome;
use crate::notes::print_always;

/// Change a keystore so that this program can use it and no outsider can forge anything.
///
/// Signs another governance where that of SROS2 protects too little, or protects payloads by
/// themselves, which this middleware cannot carry; links it, and the authority's certificates, into
/// enclaves that have copies; and makes private keys readable by their owner alone. Certificates,
/// permissions, domains and topics stay. Programs that run already keep the old governance until they are
/// started again, and do not match those that have the new one.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  rsrs keystore harden keystore")]
pub struct Arguments {
    /// Folder of the keystore, with its private keys.
    #[arg(value_name = "DIR")]
    keystore: PathBuf,
    /// How to report.
    #[arg(long, value_enum, default_value = "text")]
    format: Format,
}

pub fn run(arguments: &Arguments) -> anyhow::Result<Outcome> {
    let hardened =
        harden(&arguments.keystore).map_err(|error| helped(error.of(&arguments.keystore)))?;
    let Hardened { cured, keys_made_private, linked } = &hardened;
    report(arguments.format, &hardened, render::hardened(cured, keys_made_private, linked))?;
    if !(cured.is_empty() && linked.is_empty()) {
        print_always(render::AFTER_HARDENED);
    }
    Ok(Outcome::Done)
}
