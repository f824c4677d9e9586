//! `rsrs keystore create`: a keystore for a fleet.

use rsrs_fleet::fleet_file::FleetFile;
use rsrs_keystore::create::{KeystoreRequest, MadeEnclave, create};
use rsrs_keystore::members::is_keystore;
use rsrs_pipeline::error::helped;
use rsrs_pipeline::files::read_text;
use rsrs_pipeline::wording::shell::quoted;
use std::path::PathBuf;

use crate::commands::keystore::{DAY, copy_lines, since_1970};
use crate::commands::{Format, report};
use crate::failure::Outcome;
use crate::notes::{print_always, print_note};

/// Make a keystore for a fleet, or the enclaves that one lacks.
///
/// It is laid out as `ros2 security create_keystore` does, and ROS 2 programs use it as their own. Each
/// robot gets an enclave, in which it may publish its own topics alone; `/runner` holds leases and
/// sets parameters, `/stop` stops, `/controllers` and `/simulator` stand in for robots, `/tracker`
/// publishes poses, `/viewer` looks. Keys are readable by their owner alone, and those that are there
/// are never written again. Who was revoked is left out. The folder `private` stays on this machine: who
/// has it can make members.
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
    /// The domain of the fleet, in which alone the keystore holds (default: that of the keystore, or of a
    /// new one `ROS_DOMAIN_ID`, or 0).
    #[arg(long, value_name = "ID", value_parser = clap::value_parser!(u16).range(0..=232))]
    domain: Option<u16>,
    /// For how many days certificates hold (default: as long as the keystore's authority; in a new one
    /// 3650, as in SROS2).
    #[arg(long, value_name = "DAYS", value_parser = clap::value_parser!(u32).range(1..=36500))]
    valid_days: Option<u32>,
    /// Make the enclave of somebody again who was revoked, with other keys; may be given more than once.
    #[arg(long, value_name = "NAME")]
    readmit: Vec<String>,
    /// How to report.
    #[arg(long, value_enum, default_value = "text")]
    format: Format,
}

/// Runs the command.
///
/// # Errors
///
/// If the fleet file is wrong, or the folder is another one than a keystore or cannot be written.
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
    .map_err(helped)?;
    report(arguments.format, &made.enclaves, text(&made.enclaves))?;
    for enclave in &made.left_out {
        print_always(format!(
            "left out: {enclave}, which was revoked; if it is to be back with other keys:\n  rsrs keystore \
             create {} --fleet {} --readmit {}",
            quoted(&arguments.keystore),
            quoted(&arguments.fleet),
            enclave.trim_start_matches('/')
        ));
    }
    print_note(format!(
        "domain {}; copy to each robot its own enclave, with what its links lead to:\n{}\nand keep {} \
         where it is",
        made.domain_id,
        copy_lines(&arguments.keystore),
        arguments.keystore.join("private").display()
    ));
    Ok(Outcome::Done)
}

/// As ROS 2 reads it.
fn domain_of_the_environment() -> anyhow::Result<u16> {
    let environment = rsrs_ros::environment::Environment::of_this_process();
    let (ros, _) = rsrs_ros::ros_args::RosArgs::parse(&[], &environment).map_err(helped)?;
    Ok(ros.domain_id)
}

fn text(made: &[MadeEnclave]) -> String {
    let width = made.iter().map(|made| made.enclave.len()).max().unwrap_or(0);
    let lines = made.iter().map(|made| {
        let what = if made.is_new { "new" } else { "key kept, permissions written anew" };
        format!("{:width$}  {what}", made.enclave)
    });
    lines.collect::<Vec<_>>().join("\n")
}
