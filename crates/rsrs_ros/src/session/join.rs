//! Joining a network: through which interfaces, and as whom.

use std::net::IpAddr;

use rsrs_fleet::timing::Transport;
use rustdds::{DomainParticipant, DomainParticipantBuilder};

use super::SessionError;
use crate::security::Enclave;

/// Where a session lives.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SessionOptions {
    /// `ROS_DOMAIN_ID`; 0 to 232.
    pub domain_id: u16,
    /// The interfaces to use, by address; never empty: loopback when confined.
    pub interfaces: Vec<IpAddr>,
    /// Who this is in a secured fleet; `None` in one that is not.
    pub enclave: Option<Enclave>,
}

impl SessionOptions {
    /// How messages travel, on which some times of the protocol depend.
    pub fn transport(&self) -> Transport {
        if self.enclave.is_some() { Transport::Secured } else { Transport::Plain }
    }
}

pub(super) fn participant(options: &SessionOptions) -> Result<DomainParticipant, SessionError> {
    let failed = |reason: String| SessionError::Join { domain_id: options.domain_id, reason };
    let builder = DomainParticipantBuilder::new(options.domain_id)
        .with_only_networks(options.interfaces.iter().copied());
    #[cfg(feature = "security")]
    let builder = match &options.enclave {
        Some(enclave) => builder.builtin_security(files_of(enclave)),
        None => builder,
    };
    // An enclave cannot be had without the feature; should there be one, nothing runs plain instead.
    #[cfg(not(feature = "security"))]
    if let Some(enclave) = &options.enclave {
        return Err(SessionError::NotSecured { enclave: enclave.name().to_owned() });
    }
    builder.build().map_err(|error| failed(error.to_string()))
}

#[cfg(feature = "security")]
fn files_of(enclave: &Enclave) -> rustdds::DomainParticipantSecurityConfigFiles {
    // SROS2 does not encrypt keys.
    let password = String::new();
    rustdds::DomainParticipantSecurityConfigFiles::with_ros_default_names(
        enclave.folder(),
        password,
    )
}
