//! A keystore for a fleet: one authority, and an enclave for each member.

use std::io;
use std::path::{Path, PathBuf};
use std::time::Duration;

use crate::authority::Authority;
use crate::governance::{Domains, Governance};
use crate::grant::GrantText;
use crate::layout::{
    ENCLAVES, GOVERNANCE, GOVERNANCE_TEXT, IDENTITY_CA, KEY, PERMISSIONS, PERMISSIONS_CA,
    PERMISSIONS_TEXT, PUBLIC,
};
use crate::roles::Role;
use crate::{KeystoreError, files};

/// How clocks may differ: certificates hold from so long ago.
const CLOCKS_DIFFER: Duration = Duration::from_secs(24 * 3600);

/// A keystore to make, or to complete.
#[derive(Clone, Debug)]
pub struct KeystoreRequest<'a> {
    /// Its folder.
    pub folder: &'a Path,
    /// The fleet.
    pub robots: &'a [String],
    /// The domain in which the fleet is.
    pub domain_id: u16,
    /// Since 1970.
    pub now: Duration,
    /// How long the certificates hold.
    pub validity: Duration,
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
/// written anew, because those of some name all robots.
///
/// # Errors
///
/// [`KeystoreError`] if the folder is another one than a keystore, or cannot be written.
pub fn create(request: &KeystoreRequest) -> Result<Vec<MadeEnclave>, KeystoreError> {
    let folder = request.folder;
    check_robots(request.robots)?;
    let holds =
        (request.now.saturating_sub(CLOCKS_DIFFER), request.now.saturating_add(request.validity));
    let authority = if Authority::is_in(folder) {
        Authority::read(folder)?
    } else {
        check_empty(folder)?;
        Authority::create(folder, holds)?
    };
    let enclaves = folder.join(ENCLAVES);
    files::make_folder(&enclaves)?;
    if !enclaves.join(GOVERNANCE).exists() {
        let domains = Domains { first: request.domain_id, last: request.domain_id };
        write_governance(&authority, folder, &Governance::recommended(domains))?;
    }
    Role::all_of(request.robots)
        .into_iter()
        .map(|role| enclave(&authority, request, holds, &role))
        .collect()
}

/// A robot whose name were that of another enclave would have its rights.
fn check_robots(robots: &[String]) -> Result<(), KeystoreError> {
    let others = Role::all_of(&[]);
    let taken = |robot: &&String| others.iter().any(|role| role.enclave() == format!("/{robot}"));
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

/// Writes the governance of a keystore, and signs it.
pub(crate) fn write_governance(
    authority: &Authority,
    folder: &Path,
    governance: &Governance,
) -> Result<(), KeystoreError> {
    let enclaves = folder.join(ENCLAVES);
    let text = governance.to_xml();
    files::write_public(&enclaves.join(GOVERNANCE_TEXT), &text)?;
    files::write_public(&enclaves.join(GOVERNANCE), &authority.sign(&text)?)
}

/// Makes one enclave, or writes the permissions of one that is there anew.
fn enclave(
    authority: &Authority,
    request: &KeystoreRequest,
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
    // Up to the folder of all enclaves, through those of a namespace.
    let up: PathBuf = name.trim_start_matches('/').split('/').map(|_| "..").collect();
    for file in [IDENTITY_CA, PERMISSIONS_CA] {
        files::link(&up.join("..").join(PUBLIC).join(file), &folder.join(file))?;
    }
    files::link(&up.join(GOVERNANCE), &folder.join(GOVERNANCE))?;
    let grant = GrantText { role, domain_id: request.domain_id, holds };
    let text = grant.to_xml(request.robots)?;
    files::write_public(&folder.join(PERMISSIONS_TEXT), &text)?;
    let signed = authority.sign(&text)?;
    files::write_public(&folder.join(PERMISSIONS), &signed)?;
    Ok(MadeEnclave { enclave: name, folder, is_new })
}
