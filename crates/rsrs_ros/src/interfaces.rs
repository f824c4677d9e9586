//! The network interfaces of this machine, and those that a person chose.

use std::io;
use std::net::{IpAddr, Ipv4Addr};

use nix::ifaddrs::getifaddrs;
use nix::net::if_::InterfaceFlags;
use rsrs_core::help::Help;

/// Name of the environment variable that chooses interfaces: names or addresses with commas between them.
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
    /// Others would be told an address that is their own.
    #[error(
        "`{wanted}` is the loopback interface, which reaches nobody outside of this machine, beside \
         another one"
    )]
    LoopbackBeside {
        /// What was asked for.
        wanted: String,
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
        Some(match self {
            Self::LoopbackBeside { .. } => {
                "leave it out: programs of this machine are found through the other one, too".to_owned()
            }
            Self::NotChosen { .. } | Self::NotFound { .. } | Self::Kernel { .. } => {
                "choose one with `--interface NAME`, `--interface ADDRESS` or RSRS_INTERFACE; several \
                 by `--interface` more than once"
                    .to_owned()
            }
        })
    }
}

fn listed(interfaces: &[Interface]) -> String {
    let texts: Vec<String> =
        interfaces.iter().map(|i| format!("{} ({})", i.name, i.address)).collect();
    if texts.is_empty() { "none".to_owned() } else { texts.join(", ") }
}

/// The interfaces that are up and have an IPv4 address, which is what the middleware can use.
pub fn list() -> Result<Vec<Interface>, InterfaceError> {
    let all = getifaddrs().map_err(|error| InterfaceError::Kernel { source: error.into() })?;
    let up = all.filter(|it| it.flags.contains(InterfaceFlags::IFF_UP));
    Ok(up
        .filter_map(|it| {
            let address = it.address?.as_sockaddr_in()?.ip().into();
            Some(Interface { name: it.interface_name, address })
        })
        .collect())
}

/// The names and addresses that a person chose: the values of `--interface` first, then that of
/// [`VARIABLE`].
pub(crate) fn wanted<'a>(flags: &'a [String], variable: Option<&'a str>) -> Vec<&'a str> {
    if flags.is_empty() {
        let words = variable.unwrap_or_default().split(',').map(str::trim);
        return words.filter(|word| !word.is_empty()).collect();
    }
    flags.iter().map(String::as_str).collect()
}

/// The addresses of the interfaces that a person chose by names or addresses, each once.
pub(crate) fn chosen(wanted: &[&str]) -> Result<Vec<IpAddr>, InterfaceError> {
    choose(wanted, list()?)
}

/// Whether this choice of an interface is the loopback interface.
pub(crate) fn is_loopback(wanted: &str) -> bool {
    wanted == LOOPBACK_NAME || wanted.parse().is_ok_and(|address: IpAddr| address.is_loopback())
}

fn choose(wanted: &[&str], available: Vec<Interface>) -> Result<Vec<IpAddr>, InterfaceError> {
    if wanted.is_empty() {
        return Err(InterfaceError::NotChosen { available });
    }
    let mut addresses: Vec<IpAddr> = Vec::new();
    for wanted in wanted {
        let is_wanted = |i: &&Interface| i.name == *wanted || wanted.parse() == Ok(i.address);
        let Some(found) = available.iter().find(is_wanted) else {
            let wanted = (*wanted).to_owned();
            return Err(InterfaceError::NotFound { wanted, available });
        };
        if !addresses.contains(&found.address) {
            addresses.push(found.address);
        }
    }
    let loopback = wanted.iter().find(|wanted| is_loopback(wanted));
    match loopback {
        Some(wanted) if addresses.len() > 1 => {
            Err(InterfaceError::LoopbackBeside { wanted: (*wanted).to_owned() })
        }
        _ => Ok(addresses),
    }
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
    fn several_interfaces_are_chosen_by_several_flags_or_by_commas_and_each_counts_once() {
        let mut available = two();
        available.push(Interface { name: "eth0".into(), address: "10.0.1.7".parse().unwrap() });
        let both: [IpAddr; 2] = ["10.0.1.7", "10.0.0.7"].map(|text| text.parse().unwrap());
        let flags = ["eth0", "wlan0", "10.0.0.7"].map(str::to_owned);

        let by_flags = choose(&wanted(&flags, Some("lo")), available.clone()).unwrap();
        let by_variable = choose(&wanted(&[], Some(" eth0, wlan0,")), available).unwrap();

        assert_eq!(by_flags, both);
        assert_eq!(by_variable, both);
    }

    #[test]
    fn the_loopback_interface_is_refused_beside_another_one() {
        let error = choose(&["wlan0", "127.0.0.1"], two()).unwrap_err();

        assert!(matches!(error, InterfaceError::LoopbackBeside { .. }), "{error:?}");
        assert!(error.help().is_some_and(|help| help.starts_with("leave it out")), "{error}");
        assert_eq!(choose(&["lo", "127.0.0.1"], two()).unwrap(), [LOOPBACK]);
    }

    #[test]
    fn what_is_not_there_is_refused_with_what_is() {
        let error = choose(&["wlan0", "eth9"], two()).unwrap_err();

        assert_eq!(
            error.to_string(),
            "no interface or IPv4 address `eth9`; this machine has lo (127.0.0.1), wlan0 (10.0.0.7)"
        );
    }

    #[test]
    fn nothing_is_chosen_by_accident() {
        for variable in [None, Some(""), Some(" , ")] {
            let error = choose(&wanted(&[], variable), two()).unwrap_err();

            assert!(matches!(error, InterfaceError::NotChosen { .. }), "{error:?}");
        }
    }

    #[test]
    fn this_machine_has_a_loopback_interface() {
        assert!(list().unwrap().iter().any(|interface| interface.address == LOOPBACK));
    }
}
