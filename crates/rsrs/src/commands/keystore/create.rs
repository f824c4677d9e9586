//! `rsrs keystore create`: a keystore for a fleet.

use rsrs_fleet::fleet_file::FleetFile;
use rsrs_keystore::create::{KeystoreRequest, MadeEnclave, create};
use rsrs_keystore::members::is_keystore;
use rsrs_keystore::problem::{EnclaveProblem, cures};
use rsrs_pipeline::error::helped;
use rsrs_pipeline::files::read_text;
use rsrs_render::keystore as render;
use std::path::PathBuf;

use crate::commands::keystore::{DAY, since_1970};
use crate::commands::{Format, report};
use crate::failure::Outcome;
use crate::notes::{print_always, print_note};

/// Make a keystore for a fleet, or the enclaves that one lacks.
///
/// It is laid out as `ros2 security create_keystore` does, and ROS 2 programs use it as their own. Each
/// robot gets an enclave, in which it may publish its own topics alone; `/runner` holds leases and sets
/// parameters, `/stop` stops, `/controllers` and `/simulator` stand in for robots, `/tracker` publishes
/// poses, `/viewer` only watches. Keys are readable by their owner alone, and never overwritten; a
/// certificate that is missing, or does not belong to its key, is made anew. Revoked members are left
/// out. The folder `private` stays on this machine: whoever has it can make members.
///
/// Exit code 3 means that an enclave cannot be used yet; what to type is printed.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  rsrs keystore create keystore --fleet fleet.yaml
  rsrs keystore create keystore --fleet fleet.yaml --domain 7
  ROS_SECURITY_ENABLE=true ROS_SECURITY_STRATEGY=Enforce ROS_SECURITY_KEYSTORE=$PWD/keystore \\
      rsrs stop --interface wlan0")]
pub struct Arguments {
    /// Folder of the keystore: a new one, or one to complete.
    #[arg(value_name = "DIR")]
    keystore: PathBuf,
    /// Fleet file (YAML): every robot in it gets an enclave, enabled or not.
    #[arg(long, value_name = "FLEET")]
    fleet: PathBuf,
    /// The domain of the fleet, the only one in which the keystore is valid (default: the keystore's;
    /// for a new one `ROS_DOMAIN_ID`, or 0).
    #[arg(long, value_name = "ID", value_parser = clap::value_parser!(u16).range(0..=232))]
    domain: Option<u16>,
    /// For how many days what is signed now is valid: certificates of new members, and permissions of
    /// all in the fleet file, old members included (default: as long as the keystore's authority; in a
    /// new one 3650, as in SROS2).
    #[arg(long, value_name = "DAYS", value_parser = clap::value_parser!(u32).range(1..=36500))]
    valid_days: Option<u32>,
    /// Make the enclave of a revoked member again, with other keys; may be given more than once.
    #[arg(long, value_name = "NAME")]
    readmit: Vec<String>,
    /// How to report.
    #[arg(long, value_enum, default_value = "text")]
    format: Format,
}

pub fn run(arguments: &Arguments) -> anyhow::Result<Outcome> {
    let name = arguments.fleet.display().to_string();
    let fleet = FleetFile::parse(&name, &read_text(&arguments.fleet)?).map_err(helped)?;
    let robots: Vec<String> = fleet.robots.into_iter().map(|robot| robot.name).collect();
    let domain_id = match arguments.domain {
        None if !is_keystore(&arguments.keystore) => Some(domain_of_the_environment()?),
        asked => asked,
    };
    let made = create(&KeystoreRequest {
        folder: &arguments.keystore,
        robots: &robots,
        domain_id,
        now: since_1970()?,
        validity: arguments.valid_days.map(|days| DAY * days),
        readmitted: &arguments.readmit,
    })
    .map_err(|error| helped(error.of(&arguments.keystore)))?;
    let rows: Vec<_> =
        made.enclaves.iter().map(|it| (it.enclave.as_str(), row(it, &made.problems))).collect();
    let folder = &arguments.keystore;
    report(arguments.format, &made.enclaves, render::made(&rows))?;
    for enclave in &made.left_out {
        print_always(render::left_out(enclave, folder, &arguments.fleet));
    }
    if let Some(others) = render::others(&made.others, folder) {
        print_always(others);
    }
    for (enclave, problem) in &made.problems {
        print_always(match problem {
            EnclaveProblem::Governance(weakness) => render::of_governance(weakness),
            problem => format!("{enclave}: {problem}"),
        });
    }
    let problems: Vec<EnclaveProblem> = made.problems.into_iter().map(|(_, it)| it).collect();
    if let Some(next) = render::next(&cures(folder, Some(&arguments.fleet), &problems)) {
        print_always(next);
    }
    print_note(render::after_made(made.domain_id, made.ends, folder));
    let can_be_used = problems.iter().all(EnclaveProblem::is_warning);
    Ok(if can_be_used { Outcome::Done } else { Outcome::NegativeAnswer })
}

/// As ROS 2 reads it.
fn domain_of_the_environment() -> anyhow::Result<u16> {
    let environment = rsrs_ros::environment::Environment::of_this_process();
    let ros = rsrs_ros::ros_args::RosArgs::parse(&[], &environment).map_err(helped)?;
    Ok(ros.domain_id)
}

/// What became of an enclave, as far as people read of it.
fn row(made: &MadeEnclave, problems: &[(String, EnclaveProblem)]) -> render::EnclaveOutcome {
    let is_its = |(enclave, problem): &(String, EnclaveProblem)| {
        *enclave == made.enclave && !matches!(problem, EnclaveProblem::Governance(_))
    };
    match (made.is_new, made.is_certified) {
        _ if problems.iter().any(is_its) => render::EnclaveOutcome::Unusable,
        (true, _) => render::EnclaveOutcome::New,
        (false, true) => render::EnclaveOutcome::CertifiedAnew,
        (false, false) => render::EnclaveOutcome::PermittedAnew,
    }
}
