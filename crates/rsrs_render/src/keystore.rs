//! Keystores of secured fleets in words: what was made, who belongs to one, and what is to be copied where.

use std::fmt::Display;
use std::path::{Path, PathBuf};
use std::time::Duration;

use jiff::Timestamp;
use rsrs_files::quoted;
use serde::Serialize;

use crate::columns::columns;

/// What became of an enclave.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EnclaveOutcome {
    /// Something is wrong with it.
    Unusable,
    /// It was not there.
    New,
    /// It has the key that it had, and another certificate.
    CertifiedAnew,
    /// It has the key and the certificate that it had.
    PermittedAnew,
}

/// The enclaves of a keystore that was made or completed, by their names.
pub fn made(enclaves: &[(&str, EnclaveOutcome)]) -> String {
    let width = enclaves.iter().map(|(enclave, _)| enclave.len()).max().unwrap_or(0);
    let lines = enclaves.iter().map(|(enclave, made)| {
        let what = match made {
            EnclaveOutcome::Unusable => "cannot be used yet",
            EnclaveOutcome::New => "new",
            EnclaveOutcome::CertifiedAnew => "key kept, certificate and permissions made anew",
            EnclaveOutcome::PermittedAnew => "key kept, permissions written anew",
        };
        format!("{enclave:width$}  {what}")
    });
    lines.collect::<Vec<_>>().join("\n")
}

/// A revoked member that was left out, and how it would be back.
pub fn left_out(enclave: &str, keystore: &Path, fleet: &Path) -> String {
    format!(
        "left out: {enclave}, which was revoked; if it is to be back with other keys:\n  rsrs keystore \
         create {} --fleet {} --readmit {}",
        quoted(keystore),
        quoted(fleet),
        enclave.trim_start_matches('/')
    )
}

/// Members that a fleet file does not have, and how one is taken out; nothing if there are none.
pub fn others(members: &[String], keystore: &Path) -> Option<String> {
    let first = members.first()?;
    Some(format!(
        "not in this fleet file, still members: {}; to take one out:\n  rsrs keystore revoke {} {}",
        members.join(", "),
        quoted(keystore),
        first.trim_start_matches('/')
    ))
}

/// What is wrong with the governance of a keystore.
pub fn of_governance(weakness: &impl Display) -> String {
    format!("the governance {weakness}")
}

/// What to type next about problems, a line each; nothing if nothing cures them.
pub fn next(cures: &[String]) -> Option<String> {
    (!cures.is_empty()).then(|| format!("next:\n  {}", cures.join("\n  ")))
}

/// Until when a keystore holds that was made for a domain, and what is to be copied where.
pub fn after_made(domain_id: u16, ends: Duration, keystore: &Path) -> String {
    format!(
        "domain {domain_id}, until {}; copy to each robot's computer (HOST) its own enclave (ROBOT), with what its \
         links lead to:\n{}\nand keep {} where it is",
        day(ends),
        copy_lines(keystore),
        quoted(keystore.join("private"))
    )
}

/// What was changed about a keystore: its governance, private keys that others could read, and what enclaves had
/// as copies.
pub fn hardened(cured: &[String], keys: &[PathBuf], linked: &[PathBuf]) -> String {
    let cured = cured.iter().map(|weakness| format!("cured: {}", of_governance(weakness)));
    let keys = keys.iter().map(|key| format!("made private: {}", key.display()));
    let links = linked.iter();
    let links = links.map(|path| format!("linked to that of the keystore: {}", path.display()));
    let lines: Vec<String> = cured.chain(keys).chain(links).collect();
    if lines.is_empty() { "nothing to change".to_owned() } else { lines.join("\n") }
}

/// What is to be done where the governance was changed.
pub const AFTER_HARDENED: &str =
    "copy `governance.p7s` into every enclave that was copied, and start all anew";

/// Who belongs to a keystore, and until when.
#[derive(Clone, Debug, Serialize)]
pub struct KeystoreJson {
    /// Domains in which it is valid.
    pub domains: Vec<String>,
    /// The day until which its authority holds.
    pub authority_ends: String,
    /// What is wrong with its governance.
    pub governance: Vec<String>,
    /// Its members.
    pub members: Vec<MemberJson>,
    /// Members that were revoked.
    pub revoked: Vec<String>,
    /// Private keys that others can read.
    pub open_keys: Vec<PathBuf>,
    /// What revocations that were interrupted have left.
    pub leftovers: Vec<PathBuf>,
}

/// A member of a keystore.
#[derive(Clone, Debug, Serialize)]
pub struct MemberJson {
    /// Its enclave.
    pub enclave: String,
    /// The day until which it can take part.
    pub ends: Option<String>,
    /// Days until then; one that has begun counts.
    pub days_left: Option<i64>,
    /// Why it cannot take part.
    pub problems: Vec<String>,
}

/// A table of the members, with what is wrong.
pub fn shown(keystore: &KeystoreJson) -> String {
    let rows = keystore.members.iter().map(|member| {
        let until = member.ends.as_ref().map_or_else(String::new, |ends| format!("until {ends}"));
        let left = match (member.problems.as_slice(), member.days_left) {
            ([], Some(1)) => "1 day left".to_owned(),
            ([], Some(days)) => format!("{days} days left"),
            (problems, _) => problems.join("; "),
        };
        [member.enclave.clone(), until, left]
    });
    let revoked = keystore.revoked.iter().map(|enclave| format!("\nrevoked: {enclave}"));
    let weak = keystore.governance.iter().map(|weakness| format!("\n{}", of_governance(weakness)));
    format!(
        "domain {}; authority until {}\n{}{}",
        keystore.domains.join(", "),
        keystore.authority_ends,
        columns(&rows.collect::<Vec<_>>()),
        weak.chain(revoked).collect::<String>()
    )
}

/// What to do about a keystore that is shown: what cures its problems, keys that others can read, and what was
/// left.
pub fn after_shown(keystore: &KeystoreJson, folder: &Path, cures: &[String]) -> Vec<String> {
    let next = next(cures)
        .map(|next| format!("{next}\nand copy what was changed, to where it was copied before"));
    let keys: Vec<String> = keystore.open_keys.iter().map(quoted).collect();
    let open_keys = (!keys.is_empty()).then(|| {
        format!(
            "others can read private keys here, and a program whose key they can read does not start; \
             next:\n  chmod 600 {}\nand `rsrs keystore revoke {} NAME` whose key may have been read",
            keys.join(" "),
            quoted(folder)
        )
    });
    let leftovers = keystore.leftovers.iter().map(|left| {
        format!(
            "a revocation that was interrupted has left private keys; next:\n  rm -r {}",
            quoted(left)
        )
    });
    next.into_iter().chain(open_keys).chain(leftovers).collect()
}

/// Until when a keystore was renewed, and what is to be copied where.
pub fn renewed(ends: Duration, keystore: &Path) -> String {
    format!(
        "renewed until {}; copy to each robot's computer (HOST) its own enclave (ROBOT), and start its \
         service anew:\n{}\nand to each other machine those that it has, such as:\n{}",
        day(ends),
        copy_lines(keystore),
        copy_line_of_others(keystore)
    )
}

/// That a keystore was made anew without a member, until when, what is to be copied where, and where the `old` one
/// is.
pub fn revoked(member: &str, ends: Duration, keystore: &Path, old: &Path) -> String {
    format!(
        "made anew without {}, until {}; before the next run copy to every robot's computer (HOST) its own \
         enclave (ROBOT):\n{}\nto every other machine those that it has, such as:\n{}\nand start all \
         anew; the old keystore is {}; remove it when nobody needs it any more",
        member.trim_matches('/'),
        day(ends),
        copy_lines(keystore),
        copy_line_of_others(keystore),
        quoted(old)
    )
}

/// That the private keys of a keystore are somewhere else now.
pub fn private_moved(private: &Path) -> String {
    format!("`private` leads to {} now, beside where it led before", quoted(private))
}

/// A moment since 1970 as a day.
pub fn day(at: Duration) -> String {
    let moment = i64::try_from(at.as_secs()).ok().and_then(|s| Timestamp::from_second(s).ok());
    moment.map_or_else(|| "never".to_owned(), |moment| moment.strftime("%Y-%m-%d").to_string())
}

/// What copies the enclave of a robot to its computer, and gives its key to the user of its service: a key
/// that was copied belongs to root, also where one was that did not. A host is not called as a robot in a
/// namespace is: rsync would take that for a folder.
fn copy_lines(keystore: &Path) -> String {
    let from = quoted(keystore.join("./enclaves/ROBOT"));
    format!(
        "  rsync -rpRL --mkpath --rsync-path='sudo rsync' {from} HOST:/etc/rsrs/keystore/\n  \
         ssh HOST sudo chown rsrs /etc/rsrs/keystore/enclaves/ROBOT/key.pem"
    )
}

/// The same for an enclave on a computer of a person, such as `/stop` on a laptop.
fn copy_line_of_others(keystore: &Path) -> String {
    format!("  rsync -rpRL --mkpath {} HOST:keystore/", quoted(keystore.join("./enclaves/stop")))
}
