//! `rsrs keystore show`, `renew` and `revoke`: the members of a keystore that is there.

use std::path::PathBuf;
use std::time::Duration;

use jiff::Timestamp;
use rsrs_keystore::check::ENDS_SOON;
use rsrs_keystore::members::{self, ShownKeystore};
use rsrs_pipeline::error::helped;
use rsrs_pipeline::wording::columns;
use rsrs_pipeline::wording::shell::quoted;
use serde::Serialize;

use super::{DAY, copy_lines, since_1970};
use crate::commands::{Format, print_text, report};
use crate::failure::Outcome;
use crate::notes::print_always;

/// Show who belongs to a keystore, and until when.
///
/// Exit code 3 means that somebody can no longer take part, or that others than their owner can read
/// private keys.
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
/// Its authority and all of its members get new certificates, and permissions that hold as long. What was
/// copied from it takes part until it ends, so it may be copied anew one robot after the other.
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
/// There is no list of revoked certificates in DDS Security as this middleware has it. So the authority and
/// all keys are new, and who has the old ones takes part in nothing. Every member has to be copied anew
/// before the next run; until then the members with old keys and those with new ones do not hear each
/// other. The old keystore is moved aside.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  rsrs keystore revoke keystore robot_3")]
pub struct RevokeArguments {
    /// Folder of the keystore, with its private keys.
    #[arg(value_name = "DIR")]
    keystore: PathBuf,
    /// Whose enclave goes.
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

#[derive(Serialize)]
struct Shown {
    domains: Vec<String>,
    authority_ends: String,
    members: Vec<Member>,
    revoked: Vec<String>,
    open_keys: Vec<PathBuf>,
}

#[derive(Serialize)]
struct Member {
    enclave: String,
    ends: String,
    days_left: i64,
}

/// Runs `rsrs keystore show`.
///
/// # Errors
///
/// If the folder is no keystore, or something in it does not read.
pub fn show(arguments: &ShowArguments) -> anyhow::Result<Outcome> {
    let keystore = members::show(&arguments.keystore).map_err(helped)?;
    let shown = shown(&keystore, since_1970()?);
    report(arguments.format, &shown, text(&shown))?;
    let least = shown.members.iter().map(|member| member.days_left).min().unwrap_or(i64::MAX);
    if least < i64::try_from(ENDS_SOON.as_secs() / DAY.as_secs()).unwrap_or(i64::MAX) {
        let renew = format!("rsrs keystore renew {}", quoted(&arguments.keystore));
        print_always(format!("next: {renew}   # and copy it anew"));
    }
    if !shown.open_keys.is_empty() {
        let keys: Vec<String> = shown.open_keys.iter().map(quoted).collect();
        print_always(format!(
            "others can read private keys here, and a program whose key they can read does not start; \
             next:\n  chmod 600 {}\nand `rsrs keystore revoke` whose key may have been read",
            keys.join(" ")
        ));
    }
    Ok(if least < 0 || !shown.open_keys.is_empty() {
        Outcome::NegativeAnswer
    } else {
        Outcome::Done
    })
}

fn shown(keystore: &ShownKeystore, now: Duration) -> Shown {
    let day = |at: Duration| {
        let moment = i64::try_from(at.as_secs()).ok().and_then(|s| Timestamp::from_second(s).ok());
        moment.map_or_else(|| "never".to_owned(), |moment| moment.strftime("%Y-%m-%d").to_string())
    };
    let members = keystore.members.iter().map(|member| {
        let ends = member.ends(keystore.authority_ends);
        let left_s = ends.as_secs().cast_signed() - now.as_secs().cast_signed();
        let days_left = left_s.div_euclid(DAY.as_secs().cast_signed());
        Member { enclave: member.enclave.clone(), ends: day(ends), days_left }
    });
    Shown {
        domains: keystore.domains.iter().map(ToString::to_string).collect(),
        authority_ends: day(keystore.authority_ends),
        members: members.collect(),
        revoked: keystore.revoked.clone(),
        open_keys: keystore.open_keys.clone(),
    }
}

fn text(shown: &Shown) -> String {
    let rows = shown.members.iter().map(|member| {
        let left = match member.days_left {
            ..=-1 => "takes part in nothing any more".to_owned(),
            1 => "1 day left".to_owned(),
            days => format!("{days} days left"),
        };
        [member.enclave.clone(), format!("until {}", member.ends), left]
    });
    let revoked = shown.revoked.iter().map(|enclave| format!("\nrevoked: {enclave}"));
    format!(
        "domain {}; authority until {}\n{}{}",
        shown.domains.join(", "),
        shown.authority_ends,
        columns(&rows.collect::<Vec<_>>()),
        revoked.collect::<String>()
    )
}

/// Runs `rsrs keystore renew`.
///
/// # Errors
///
/// If the folder is no keystore, or cannot be written.
pub fn renew(arguments: &RenewArguments) -> anyhow::Result<Outcome> {
    let validity = DAY * arguments.validity.valid_days;
    members::renew(&arguments.keystore, since_1970()?, validity).map_err(helped)?;
    print_text(format!(
        "renewed for {} days; copy to each robot its own enclave, and start its service anew:\n{}",
        arguments.validity.valid_days,
        copy_lines(&arguments.keystore)
    ))?;
    Ok(Outcome::Done)
}

/// Runs `rsrs keystore revoke`.
///
/// # Errors
///
/// If there is no such member, or the folder is no keystore or cannot be written.
pub fn revoke(arguments: &RevokeArguments) -> anyhow::Result<Outcome> {
    let validity = DAY * arguments.validity.valid_days;
    let old = members::revoke(&arguments.keystore, &arguments.name, since_1970()?, validity);
    let old = old.map_err(helped)?;
    print_text(format!(
        "made anew without {}; copy to every robot its own enclave before the next run, and to every \
         machine that has others, and start all anew:\n{}\nthe old keystore is {}; remove it when nobody \
         needs it any more",
        arguments.name,
        copy_lines(&arguments.keystore),
        quoted(&old)
    ))?;
    Ok(Outcome::Done)
}
