//! DDS Security: which enclave of a keystore a process has, as `ROS_SECURITY_*` and `--enclave` have it.
//!
//! The middleware signs, encrypts and verifies. What is here asks before it starts whether the files
//! of the enclave are there and whether the middleware can carry what they demand
//! ([`rsrs_keystore::check`]), and it never lets a process that was to be secured run plain in silence:
//! an [`Enclave`] can only be had by [`SecurityRequest::enclave`], which fails where this program was
//! built without the feature `security`.

mod enclave;
mod error;
mod request;

pub use enclave::Enclave;
pub use error::SecurityError;
pub use request::{Member, PermissiveStrategy, SecurityRequest, Strategy};

/// Whether this program can take part in a secured fleet.
pub const IS_BUILT_IN: bool = cfg!(feature = "security");
