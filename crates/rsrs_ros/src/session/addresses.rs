//! Whether an interface of this participant has another address now.
//!
//! A participant announces the addresses at which it receives, once, when it starts. When a robot's
//! interface is given another address (by DHCP, after its Wi-Fi was away), all others go on sending to
//! the old one: nothing is received any more, and no call fails. An interface that is down for a while,
//! or without an address, and then has the same one, goes on as before.

use std::net::IpAddr;

use super::SessionEnded;
use crate::interfaces::{self, Interface};

/// The interfaces that a participant was started with.
pub(super) struct Addresses(Vec<Interface>);

impl Addresses {
    pub(super) fn new(used: &[IpAddr]) -> Self {
        // Without a list of interfaces no change can be found, and nothing else is lost.
        let mut interfaces = interfaces::list().unwrap_or_default();
        interfaces.retain(|interface| used.contains(&interface.address));
        Self(interfaces)
    }

    /// Whether all of them are up with their addresses.
    pub(super) fn are_present(&self) -> bool {
        interfaces::list().is_ok_and(|present| self.0.iter().all(|used| present.contains(used)))
    }

    /// Looks whether they have other addresses.
    pub(super) fn change(&self) -> Option<SessionEnded> {
        change(&self.0, &interfaces::list().ok()?)
    }
}

fn change(used: &[Interface], present: &[Interface]) -> Option<SessionEnded> {
    let of = |before: &Interface| {
        if present.contains(before) {
            return None;
        }
        let now = present.iter().find(|interface| interface.name == before.name)?;
        Some(SessionEnded::AddressChanged {
            interface: before.name.clone(),
            before: before.address,
            now: now.address,
        })
    };
    used.iter().find_map(of)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn interface(name: &str, address: &str) -> Interface {
        Interface { name: name.to_owned(), address: address.parse().unwrap() }
    }

    #[test]
    fn an_interface_with_another_address_is_found_and_one_that_is_only_away_is_not() {
        let used = [interface("wlan0", "10.0.0.7")];
        let other = interface("eth0", "10.0.1.7");

        let of = |present: &[Interface]| change(&used, present);

        assert_eq!(of(&[other.clone(), used[0].clone()]), None);
        assert_eq!(of(std::slice::from_ref(&other)), None, "it is down: a program could not start");
        assert_eq!(of(&[interface("wlan0", "10.0.0.8"), used[0].clone()]), None, "it has two");
        let changed = of(&[other, interface("wlan0", "10.0.0.8")]);
        let expected = SessionEnded::AddressChanged {
            interface: "wlan0".to_owned(),
            before: used[0].address,
            now: "10.0.0.8".parse().unwrap(),
        };
        assert_eq!(changed, Some(expected));
    }
}
