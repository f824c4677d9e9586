//! The network interfaces of this machine, and the one that a person chose.

use std::io;
use std::net::{IpAddr, Ipv4Addr};

use rsrs_core::help::Help;

use crate::kernel;

/// Name of the environment variable that chooses the interface.
pub const VARIABLE: &str = "RSRS_INTERFACE";

/// The loopback interface.
pub const LOOPBACK: IpAddr = IpAddr::V4(Ipv4Addr::LOCALHOST);
/// Its name on Linux.
const LOOPBACK_NAME: &str = "lo";

/// One address of one interface.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Interface {
    /// Its name, such as `wlan0`.
    pub name: String,
    /// One of its addresses.
    pub address: IpAddr,
}

/// Why there is no interface to use.
#[derive(Debug, thiserror::Error)]
pub enum InterfaceError {
    /// Nobody chose one, and the LAN is not used by accident.
    #[error("no network interface is chosen; this machine has {}", listed(available))]
    NotChosen {
        /// What there is.
        available: Vec<Interface>,
    },
    /// The chosen one is not there, is down, or has no IPv4 address.
    #[error("no interface or IPv4 address `{wanted}`; this machine has {}", listed(available))]
    NotFound {
        /// What was asked for.
        wanted: String,
        /// What there is.
        available: Vec<Interface>,
    },
    /// The kernel does not list them.
    #[error("the network interfaces cannot be listed")]
    Kernel {
        /// The kernel's error.
        #[source]
        source: io::Error,
    },
}

impl Help for InterfaceError {
    fn help(&self) -> Option<String> {
        Some(
            "choose one with `--interface NAME`, `--interface ADDRESS` or RSRS_INTERFACE"
                .to_owned(),
        )
    }
}

fn listed(interfaces: &[Interface]) -> String {
    let texts: Vec<String> =
        interfaces.iter().map(|i| format!("{} ({})", i.name, i.address)).collect();
    if texts.is_empty() { "none".to_owned() } else { texts.join(", ") }
}

/// The interfaces that are up and have an IPv4 address, which is what the middleware can use.
///
/// # Errors
///
/// [`InterfaceError::Kernel`].
pub fn list() -> Result<Vec<Interface>, InterfaceError> {
    let addresses =
        kernel::interface_addresses().map_err(|source| InterfaceError::Kernel { source })?;
    Ok(addresses
        .into_iter()
        .filter(|(_, address)| address.is_ipv4())
        .map(|(name, address)| Interface { name, address })
        .collect())
}

/// The address of the interface that a person chose: the flag first, then the environment.
///
/// # Arguments
///
/// * `flag` — value of `--interface`, a name or an address.
/// * `variable` — value of [`VARIABLE`].
///
/// # Errors
///
/// [`InterfaceError`], with the interfaces that there are.
pub fn chosen(flag: Option<&str>, variable: Option<&str>) -> Result<IpAddr, InterfaceError> {
    choose(flag.or(variable), list()?)
}

/// Whether this choice of an interface is the loopback interface.
pub(crate) fn is_loopback(wanted: &str) -> bool {
    wanted == LOOPBACK_NAME || wanted.parse().is_ok_and(|address: IpAddr| address.is_loopback())
}

fn choose(wanted: Option<&str>, available: Vec<Interface>) -> Result<IpAddr, InterfaceError> {
    let Some(wanted) = wanted else {
        return Err(InterfaceError::NotChosen { available });
    };
    let found = available
        .iter()
        .find(|i| i.name == wanted || wanted.parse() == Ok(i.address))
        .map(|interface| interface.address);
    found.ok_or_else(|| InterfaceError::NotFound { wanted: wanted.to_owned(), available })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn two() -> Vec<Interface> {
        vec![
            Interface { name: "lo".into(), address: LOOPBACK },
            Interface { name: "wlan0".into(), address: "10.0.0.7".parse().unwrap() },
        ]
    }

    #[test]
    fn an_interface_is_chosen_by_name_or_by_address() {
        let address: IpAddr = "10.0.0.7".parse().unwrap();

        assert_eq!(choose(Some("wlan0"), two()).unwrap(), address);
        assert_eq!(choose(Some("10.0.0.7"), two()).unwrap(), address);
    }

    #[test]
    fn what_is_not_there_is_refused_with_what_is() {
        let error = choose(Some("eth9"), two()).unwrap_err();

        assert_eq!(
            error.to_string(),
            "no interface or IPv4 address `eth9`; this machine has lo (127.0.0.1), wlan0 (10.0.0.7)"
        );
    }

    #[test]
    fn nothing_is_chosen_by_accident() {
        let error = choose(None, two()).unwrap_err();

        assert!(matches!(error, InterfaceError::NotChosen { .. }), "{error:?}");
    }

    #[test]
    fn this_machine_has_a_loopback_interface() {
        assert!(list().unwrap().iter().any(|interface| interface.address == LOOPBACK));
    }
}
