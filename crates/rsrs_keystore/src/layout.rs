//! Names of folders and files in a keystore, as ROS 2 has them.

/// Folder of all enclaves in a keystore.
pub const ENCLAVES: &str = "enclaves";
/// Certificate of the authority that signs identities.
pub const IDENTITY_CA: &str = "identity_ca.cert.pem";
/// Certificate of a process.
pub const CERTIFICATE: &str = "cert.pem";
/// Private key of a process.
pub const KEY: &str = "key.pem";
/// Certificate of the authority that signs the two documents.
pub const PERMISSIONS_CA: &str = "permissions_ca.cert.pem";
/// What is protected, signed.
pub const GOVERNANCE: &str = "governance.p7s";
/// What a process may publish and receive, signed.
pub const PERMISSIONS: &str = "permissions.p7s";

/// Every file that an enclave needs.
pub const FILES: [&str; 6] =
    [IDENTITY_CA, CERTIFICATE, KEY, PERMISSIONS_CA, GOVERNANCE, PERMISSIONS];

/// Those of them that all enclaves share, as links.
pub const SHARED: [&str; 3] = [IDENTITY_CA, PERMISSIONS_CA, GOVERNANCE];

/// The text of the governance, beside what is signed.
pub const GOVERNANCE_TEXT: &str = "governance.xml";
/// The text of the permissions, beside what is signed.
pub const PERMISSIONS_TEXT: &str = "permissions.xml";
/// The folder of what everybody may read.
pub const PUBLIC: &str = "public";
/// The folder of what stays on the machine that has the keystore.
pub const PRIVATE: &str = "private";
/// In that folder: the enclaves that were revoked, one in each line.
pub const REVOKED: &str = "revoked.txt";
/// Held by the command that changes a keystore.
pub(crate) const LOCK: &str = ".lock";
/// There while a new keystore is made, and where that was interrupted.
pub(crate) const UNFINISHED: &str = ".unfinished";
