//! Keystores of secured fleets: made, hardened, and looked at before a program starts.
//!
//! A keystore is a folder as SROS2 lays it out. An enclave in it is the folder of one member of the
//! fleet: a certificate with its key, the certificates of the authorities, and two signed documents.
//! The governance states what is protected, and the permissions what this member may publish and
//! receive.
//!
//! * [`create`] makes the keystore of a fleet: what each member may publish follows from the table of
//!   topics, by [`roles`].
//! * [`harden`] makes a keystore of SROS2 such that our middleware carries what it demands.
//! * [`members`] shows who belongs to a keystore and until when, gives it more time, and makes it anew
//!   without one of them.
//! * [`check`] reports what is wrong with an enclave, and [`problem`] what mends it; a program that is to be
//!   secured asks before it starts.
//!
//! Signatures and keys are those of the `RustCrypto` crates, so nothing here needs OpenSSL.
//!
//! # Example
//!
//! ```
//! use std::time::Duration;
//!
//! use rsrs_keystore::check::problems_of;
//! use rsrs_keystore::create::{KeystoreRequest, create};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let folder = tempfile::tempdir()?;
//! let robots = ["robot_1".to_owned()];
//! let now = Duration::from_secs(1_767_268_800);
//! let request = KeystoreRequest {
//!     folder: folder.path(),
//!     robots: &robots,
//!     domain_id: None,
//!     now,
//!     validity: None,
//!     readmitted: &[],
//! };
//!
//! let made = create(&request)?;
//!
//! assert_eq!(made.enclaves[0].enclave, "/robot_1");
//! assert_eq!(problems_of("/robot_1", &made.enclaves[0].folder, 0, now), []);
//! # Ok(())
//! # }
//! ```

mod authority;
pub mod certificate;
pub mod check;
pub mod create;
mod dates;
mod error;
mod files;
pub mod governance;
mod grant;
pub mod harden;
mod issue;
pub mod layout;
pub mod members;
pub mod permissions;
pub mod problem;
mod revocations;
pub mod roles;
mod signature;
pub mod signed_document;

pub use error::{KeystoreError, KeystoreFailure};
pub use signature::ForgedDocument;

#[cfg(test)]
mod fuzz;
#[cfg(test)]
mod tests;
