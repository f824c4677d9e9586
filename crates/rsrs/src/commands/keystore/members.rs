//! `rsrs keystore show`, `renew` and `revoke`: the members of a keystore that is there.

use std::path::PathBuf;
use std::time::Duration;

use rsrs_keystore::check::ENDS_SOON;
use rsrs_keystore::layout::CERTIFICATE;
use rsrs_keystore::members::{self, ShownKeystore};
use rsrs_keystore::problem::{EnclaveProblem, cures};
use rsrs_pipeline::error::helped;
use rsrs_render::keystore as render;

use super::{DAY, since_1970};
use crate::commands::{Format, print_text, report};
use crate::failure::Outcome;
use crate::notes::print_always;

/// Show who belongs to a keystore, and until when.
///
/// Names problems as programs that start with it do, with what to type. Exit code 3 means that somebody
/// cannot take part now, that programs refuse the governance, that private keys are readable by more
/// than their owner, or that such keys were left by a command that was interrupted.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  rsrs keystore show keystore")]
pub struct ShowArguments {
    /// Folder of the keystore, with its private keys.
    #[arg(value_name = "DIR")]
    keystore: PathBuf,
    /// How to report.
    #[arg(long, value_enum, default_value = "text")]
    format: Format,
}

/// Give a keystore more time, with the keys that it has.
///
/// Its authority and all of its members get new certificates, and permissions that hold as long; the
/// governance is signed again. What was copied from it takes part until it ends, also among stock ROS 2
/// nodes, so it may be copied anew one robot after the other.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  rsrs keystore renew keystore")]
pub struct RenewArguments {
    /// Folder of the keystore, with its private keys.
    #[arg(value_name = "DIR")]
    keystore: PathBuf,
    #[command(flatten)]
    validity: Validity,
}

/// Make a keystore anew without one of its members, such as a robot that was stolen.
///
/// This middleware has no list of revoked certificates. So the authority and all keys are made anew,
/// and whoever has the old ones is shut out. Every member has to be copied anew before the next run;
/// until then the members with old keys and those with new ones do not hear each other. The old
/// keystore is moved aside.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  rsrs keystore revoke keystore robot_3")]
pub struct RevokeArguments {
    /// Folder of the keystore, with its private keys.
    #[arg(value_name = "DIR")]
    keystore: PathBuf,
    /// Member to remove.
    #[arg(value_name = "NAME")]
    name: String,
    #[command(flatten)]
    validity: Validity,
}

/// How long a keystore holds that is made now.
#[derive(clap::Args)]
struct Validity {
    /// For how many days it holds, from now.
    #[arg(
        long, value_name = "DAYS", default_value = "3650",
        value_parser = clap::value_parser!(u32).range(1..=36500)
    )]
    valid_days: u32,
}

pub fn show(arguments: &ShowArguments) -> anyhow::Result<Outcome> {
    let (folder, now) = (&arguments.keystore, since_1970()?);
    let keystore = members::show(folder, now).map_err(|error| helped(error.of(folder)))?;
    let shown = shown(&keystore, now);
    report(arguments.format, &shown, render::shown(&shown))?;
    let of_all = keystore.weaknesses.iter().cloned().map(EnclaveProblem::Governance);
    let of_members = keystore.members.iter().flat_map(|member| member.problems.iter().cloned());
    let mut problems: Vec<EnclaveProblem> = of_all.chain(of_members).collect();
    let is_usable = problems.iter().all(EnclaveProblem::is_warning);
    let soon = keystore.members.iter().filter_map(|member| member.ends).min();
    if let Some(ended) = soon.filter(|ends| *ends < now.saturating_add(ENDS_SOON)) {
        problems.push(EnclaveProblem::Ended { file: CERTIFICATE, ended });
    }
    for text in render::after_shown(&shown, folder, &cures(folder, None, &problems)) {
        print_always(text);
    }
    Ok(if is_usable && shown.open_keys.is_empty() && shown.leftovers.is_empty() {
        Outcome::Done
    } else {
        Outcome::NegativeAnswer
    })
}

fn shown(keystore: &ShownKeystore, now: Duration) -> render::KeystoreJson {
    let days_left = |ends: Duration| {
        let left_s = ends.as_secs().cast_signed() - now.as_secs().cast_signed();
        // A day that has begun is a day.
        -(-left_s).div_euclid(DAY.as_secs().cast_signed())
    };
    let members = keystore.members.iter().map(|member| render::MemberJson {
        enclave: member.enclave.clone(),
        ends: member.ends.map(render::day),
        days_left: member.ends.map(days_left),
        problems: member.problems.iter().map(ToString::to_string).collect(),
    });
    render::KeystoreJson {
        domains: keystore.domains.iter().map(ToString::to_string).collect(),
        authority_ends: render::day(keystore.authority_ends),
        governance: keystore.weaknesses.iter().map(ToString::to_string).collect(),
        members: members.collect(),
        revoked: keystore.revoked.clone(),
        open_keys: keystore.open_keys.clone(),
        leftovers: keystore.leftovers.clone(),
    }
}

pub fn renew(arguments: &RenewArguments) -> anyhow::Result<Outcome> {
    let validity = DAY * arguments.validity.valid_days;
    let folder = &arguments.keystore;
    let ends = members::renew(folder, since_1970()?, validity)
        .map_err(|error| helped(error.of(folder)))?;
    print_text(render::renewed(ends, folder))?;
    Ok(Outcome::Done)
}

pub fn revoke(arguments: &RevokeArguments) -> anyhow::Result<Outcome> {
    let validity = DAY * arguments.validity.valid_days;
    let folder = &arguments.keystore;
    let made = members::revoke(folder, &arguments.name, since_1970()?, validity)
        .map_err(|error| helped(error.of(folder)))?;
    print_text(render::revoked(&arguments.name, made.ends, folder, &made.old))?;
    if let Some(private) = made.private {
        print_always(render::private_moved(&private));
    }
    Ok(Outcome::Done)
}
