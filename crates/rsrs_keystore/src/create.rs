//! A keystore for a fleet: one authority, and an enclave for each member.

use std::io;
use std::path::{Path, PathBuf};
use std::time::Duration;

use crate::authority::Authority;
use crate::error::KeystoreError;
use crate::files;
use crate::governance::{Domains, Governance};
use crate::grant::GrantText;
use crate::issue::from;
use crate::layout::{ENCLAVES, GOVERNANCE, KEY, PERMISSIONS, PERMISSIONS_TEXT};
use crate::revocations::{enclave_of, revoked, write_revoked};
use crate::roles::Role;

/// How long an authority holds that nobody asked for otherwise, as in SROS2.
pub const USUAL_VALIDITY: Duration = Duration::from_secs(3650 * 24 * 3600);

/// A keystore to make, or to complete.
#[derive(Clone, Debug)]
pub struct KeystoreRequest<'a> {
    /// Its folder.
    pub folder: &'a Path,
    /// The fleet.
    pub robots: &'a [String],
    /// The domain in which the fleet is; `None` for that of a keystore that is there, and 0 in a new one.
    pub domain_id: Option<u16>,
    /// Since 1970.
    pub now: Duration,
    /// How long the certificates hold; `None` for as long as the authority that signs them.
    pub validity: Option<Duration>,
    /// Names of enclaves that were revoked and are made again, with other keys.
    pub readmitted: &'a [String],
}

/// A keystore that was made or completed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MadeKeystore {
    /// The domain in which alone it holds.
    pub domain_id: u16,
    /// Its enclaves, those of the robots first.
    pub enclaves: Vec<MadeEnclave>,
    /// The names of those that were not made, because they were revoked.
    pub left_out: Vec<String>,
}

/// An enclave of a keystore that was made or completed.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct MadeEnclave {
    /// Its name in ROS 2, such as `/robot_3`.
    pub enclave: String,
    /// Where its files are.
    pub folder: PathBuf,
    /// Whether its key and certificate were made now; otherwise they were there, and stay.
    pub is_new: bool,
}

/// Makes a keystore, or the enclaves that one lacks.
///
/// Keys and certificates that are there are kept. Permissions of the enclaves of this fleet are
/// written anew, because those of some name all robots. Who was revoked is left out, until it is
/// [readmitted](KeystoreRequest::readmitted).
///
/// # Errors
///
/// [`KeystoreError`] if the folder is another one than a keystore, is of another domain, or cannot be
/// written, if its authority ends before what it would sign, or if who is readmitted was not revoked.
pub fn create(request: &KeystoreRequest) -> Result<MadeKeystore, KeystoreError> {
    let folder = request.folder;
    check_robots(request.robots)?;
    let mut gone = revoked(folder)?;
    for name in request.readmitted {
        let name = enclave_of(name);
        if !gone.remove(&name) {
            return Err(KeystoreError::NotRevoked { name });
        }
    }
    // Certificates know whole seconds.
    let now = Duration::from_secs(request.now.as_secs());
    let asked = request.validity.map(|validity| now.saturating_add(validity));
    let is_there = Authority::is_in(folder);
    let authority = if is_there {
        Authority::read(folder)?
    } else {
        check_empty(folder)?;
        let ends = asked.unwrap_or(now.saturating_add(USUAL_VALIDITY));
        Authority::create(folder, (from(now), ends))?
    };
    let ends = authority.ends();
    if ends <= now || asked.is_some_and(|asked| asked > ends) {
        return Err(KeystoreError::AuthorityEnds { ends, asked });
    }
    let holds = (from(now), asked.unwrap_or(ends));
    let enclaves = folder.join(ENCLAVES);
    files::make_folder(&enclaves)?;
    let domain_id = if enclaves.join(GOVERNANCE).exists() {
        domain_of(&authority.governance(folder)?, request.domain_id)?
    } else if is_there && request.domain_id.is_none() {
        return Err(KeystoreError::NoGovernance { path: enclaves.join(GOVERNANCE) });
    } else {
        let domain_id = request.domain_id.unwrap_or(0);
        let domains = Domains { first: domain_id, last: domain_id };
        authority.write_governance(folder, &Governance::recommended(domains))?;
        domain_id
    };
    let is_gone = |role: &Role| gone.contains(&role.enclave());
    let (left_out, made): (Vec<Role>, Vec<Role>) =
        Role::all_of(request.robots).into_iter().partition(is_gone);
    let enclaves = made.iter().map(|role| enclave(&authority, request, domain_id, holds, role));
    let enclaves = enclaves.collect::<Result<_, _>>()?;
    if !request.readmitted.is_empty() {
        write_revoked(folder, &gone)?;
    }
    Ok(MadeKeystore { domain_id, enclaves, left_out: left_out.iter().map(Role::enclave).collect() })
}

/// The domain that a governance is for, which must be the one that was asked for, if any was.
fn domain_of(governance: &Governance, asked: Option<u16>) -> Result<u16, KeystoreError> {
    let first = governance.domains().next().map_or(0, |domains| domains.first);
    let domain_id = asked.unwrap_or(first);
    if governance.domains().any(|domains| domains.contain(domain_id)) {
        return Ok(domain_id);
    }
    Err(KeystoreError::OtherDomain { asked: domain_id, holds: governance.domains().collect() })
}

/// A robot whose name were that of another member would have its rights.
fn check_robots(robots: &[String]) -> Result<(), KeystoreError> {
    let taken = |robot: &&String| Role::is_taken(robot);
    match robots.iter().find(taken) {
        Some(robot) => Err(KeystoreError::RobotName { robot: robot.clone() }),
        None => Ok(()),
    }
}

fn check_empty(folder: &Path) -> Result<(), KeystoreError> {
    let is_empty = match std::fs::read_dir(folder) {
        Ok(mut entries) => entries.next().is_none(),
        Err(error) if error.kind() == io::ErrorKind::NotFound => true,
        Err(error) => return Err(KeystoreError::file("list", folder)(error)),
    };
    if is_empty { Ok(()) } else { Err(KeystoreError::HasFiles { folder: folder.to_owned() }) }
}

/// Makes one enclave, or writes the permissions of one that is there anew.
fn enclave(
    authority: &Authority,
    request: &KeystoreRequest,
    domain_id: u16,
    holds: (Duration, Duration),
    role: &Role,
) -> Result<MadeEnclave, KeystoreError> {
    let name = role.enclave();
    let folder = request.folder.join(ENCLAVES).join(name.trim_start_matches('/'));
    files::make_folder(&folder)?;
    let is_new = !folder.join(KEY).exists();
    if is_new {
        authority.issue(&folder, &name, holds)?;
    }
    files::link_shared(&folder, &name)?;
    let grant = GrantText { role, domain_id, holds };
    let text = grant.to_xml(request.robots)?;
    files::write_public(&folder.join(PERMISSIONS_TEXT), &text)?;
    let signed = authority.sign(&text)?;
    files::write_public(&folder.join(PERMISSIONS), &signed)?;
    Ok(MadeEnclave { enclave: name, folder, is_new })
}
