//! A keystore for a fleet: one authority, and an enclave for each member.

use std::collections::{BTreeMap, BTreeSet};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::time::Duration;

use rsrs_core::document::nearest;

use crate::authority::{self, Authority};
use crate::check::problems_of_member;
use crate::error::KeystoreError;
use crate::files;
use crate::governance::{Domains, Governance};
use crate::grant::GrantText;
use crate::issue::{NewMember, from};
use crate::layout::{
    CERTIFICATE, ENCLAVES, GOVERNANCE, KEY, LOCK, PERMISSIONS, PERMISSIONS_TEXT, PRIVATE, PUBLIC,
    UNFINISHED,
};
use crate::members::enclaves_of;
use crate::problem::EnclaveProblem;
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
    /// Since 1970: until when the permissions that were written hold.
    pub ends: Duration,
    /// Its enclaves, those of the robots first.
    pub enclaves: Vec<MadeEnclave>,
    /// The names of those that were not made, because they were revoked.
    pub left_out: Vec<String>,
    /// The names of members that the fleet does not have: they have the permissions that they had, and the
    /// others' permissions no longer name them.
    pub others: Vec<String>,
    /// What is still wrong with the enclaves that were asked for, each problem once, with its enclave.
    pub problems: Vec<(String, EnclaveProblem)>,
}

/// An enclave of a keystore that was made or completed.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct MadeEnclave {
    /// Its name in ROS 2, such as `/robot_3`.
    pub enclave: String,
    /// Where its files are.
    pub folder: PathBuf,
    /// Whether its key was made now; otherwise it was there, and stays.
    pub is_new: bool,
    /// Whether its certificate was made now, because it was missing, of another key, or had ended.
    pub is_certified: bool,
}

/// Makes a keystore, or the enclaves that one lacks.
///
/// Keys that are there are kept, and so are certificates that belong to them. Permissions of the
/// enclaves of this fleet are written anew, because those of some name all robots. Who was revoked
/// is left out, until it is [readmitted](KeystoreRequest::readmitted).
///
/// # Errors
///
/// Among others, if the folder is another one than a keystore or of another domain, if the authority ends
/// before what it would sign, or if who is readmitted was not revoked or is not of this fleet.
pub fn create(request: &KeystoreRequest) -> Result<MadeKeystore, KeystoreError> {
    let folder = request.folder;
    check_robots(request.robots)?;
    let roles = Role::all_of(request.robots);
    // Before a folder is made or touched.
    Authority::is_in(folder)?;
    check_empty(folder)?;
    readmission(request, &roles)?;
    files::make_folder(folder)?;
    let _lock = files::lock(folder)?;
    let gone = readmission(request, &roles)?;
    // Certificates know whole seconds.
    let now = Duration::from_secs(request.now.as_secs());
    let asked = request.validity.map(|validity| now.saturating_add(validity));
    let is_there = Authority::is_in(folder)?;
    let (authority, members) = if is_there {
        (Authority::read(folder)?, enclaves_of(folder)?)
    } else {
        begin(folder)?;
        let ends = asked.unwrap_or(now.saturating_add(USUAL_VALIDITY));
        (Authority::create(folder, (from(now), ends))?, BTreeMap::new())
    };
    let ends = authority.ends();
    if ends <= now || asked.is_some_and(|asked| asked > ends) {
        return Err(KeystoreError::AuthorityEnds { ends, asked });
    }
    let ends = asked.unwrap_or(ends);
    let enclaves = folder.join(ENCLAVES);
    files::make_folder(&enclaves)?;
    let domain_id = if enclaves.join(GOVERNANCE).symlink_metadata().is_ok() {
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
    let (left_out, wanted): (Vec<Role>, Vec<Role>) = roles.into_iter().partition(is_gone);
    let mut made = Vec::new();
    let mut problems: Vec<(String, EnclaveProblem)> = Vec::new();
    for role in &wanted {
        let (enclave, wrong) =
            enclave(&authority, request, domain_id, (from(now), ends), now, role)?;
        for problem in wrong {
            if !problems.iter().any(|(_, known)| *known == problem) {
                problems.push((enclave.enclave.clone(), problem));
            }
        }
        made.push(enclave);
    }
    if !request.readmitted.is_empty() {
        write_revoked(folder, &gone)?;
    }
    if !is_there {
        files::remove(&folder.join(UNFINISHED))?;
    }
    let is_other = |name: &String| !made.iter().any(|made| made.enclave == *name);
    Ok(MadeKeystore {
        domain_id,
        ends,
        left_out: left_out.iter().map(Role::enclave).collect(),
        others: members.into_keys().filter(is_other).collect(),
        enclaves: made,
        problems,
    })
}

/// Who stays revoked when those who are asked for are readmitted.
fn readmission(
    request: &KeystoreRequest,
    roles: &[Role],
) -> Result<BTreeSet<String>, KeystoreError> {
    let gone = revoked(request.folder)?;
    let wanted: BTreeSet<String> = request.readmitted.iter().map(|it| enclave_of(it)).collect();
    let fleet: Vec<String> = roles.iter().map(Role::enclave).collect();
    for name in &wanted {
        let is_of_fleet = fleet.contains(name);
        if !gone.contains(name) {
            let meant = nearest(name, gone.iter().map(String::as_str)).map(str::to_owned);
            let meant = meant.filter(|_| !is_of_fleet);
            return Err(KeystoreError::NotRevoked { name: name.clone(), meant });
        }
        if !is_of_fleet {
            return Err(KeystoreError::NotInFleet { name: name.clone() });
        }
    }
    Ok(gone.difference(&wanted).cloned().collect())
}

/// Notes that a keystore is being made, and removes what one has left that was interrupted.
fn begin(folder: &Path) -> Result<(), KeystoreError> {
    check_empty(folder)?;
    for made in [ENCLAVES, PUBLIC, PRIVATE] {
        files::remove(&folder.join(made))?;
    }
    files::note(&folder.join(UNFINISHED))
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

/// Whether nothing is lost where a keystore is made: the folder is not there, or has nothing but what was
/// left of one that was interrupted.
fn check_empty(folder: &Path) -> Result<(), KeystoreError> {
    let of_others = |path: &PathBuf| path.file_name().is_none_or(|name| name != LOCK);
    let is_empty = match files::entries_of(folder) {
        Ok(entries) => !entries.iter().any(of_others),
        Err(KeystoreError::File { source, .. }) if source.kind() == ErrorKind::NotFound => true,
        Err(error) => return Err(error),
    };
    // In this order: another command may make it meanwhile.
    if is_empty || folder.join(UNFINISHED).exists() || Authority::is_in(folder)? {
        return Ok(());
    }
    Err(KeystoreError::HasFiles { folder: folder.to_owned() })
}

/// Makes one enclave, or completes one that is there and writes its permissions anew, and finds
/// what is wrong with it still.
fn enclave(
    authority: &Authority,
    request: &KeystoreRequest,
    domain_id: u16,
    holds: (Duration, Duration),
    now: Duration,
    role: &Role,
) -> Result<(MadeEnclave, Vec<EnclaveProblem>), KeystoreError> {
    let name = role.enclave();
    let folder = request.folder.join(ENCLAVES).join(name.trim_start_matches('/'));
    files::make_folder(&folder)?;
    files::link_shared(&folder, &name)?;
    let text = GrantText { role, domain_id, holds }.to_xml(request.robots)?;
    files::write_public(&folder.join(PERMISSIONS_TEXT), &text)?;
    files::write_public(&folder.join(PERMISSIONS), &authority.sign(&text)?)?;
    let problems = || problems_of_member(request.folder, (&name, &folder), domain_id, now);
    let is_new = folder.join(KEY).symlink_metadata().is_err();
    let is_certified = is_new || problems().iter().any(|it| it.file() == CERTIFICATE);
    if is_new {
        authority.issue(&folder, &name, holds)?;
    } else if is_certified {
        let key = authority::key_in(&folder.join(KEY))?;
        authority.certify(&folder, NewMember::with_key(&name, holds, key)?)?;
    }
    let problems = problems();
    Ok((MadeEnclave { enclave: name, folder, is_new, is_certified }, problems))
}
