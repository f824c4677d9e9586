//! Networks of our own, from which no packet can reach a lab's robots.
//!
//! A middleware that is set to use the loopback interface only still binds its sockets to every
//! interface and answers what it receives there. What has no business on the LAN therefore runs in a
//! network namespace, which has a loopback interface and nothing else.

use std::collections::BTreeSet;
use std::io;
use std::path::Path;
use std::process::Command;

use nix::errno::Errno;
use nix::sched::{CloneFlags, unshare};
use nix::unistd::{getegid, geteuid};
use rsrs_core::help::Help;

use crate::kernel;

/// What a process in its own network is known by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Confinement {
    /// The process whose network it is.
    pub pid: u32,
    /// Whether a user namespace was needed, because the caller is not root.
    pub user_namespace: bool,
}

impl Confinement {
    /// The start of a command line with which a person runs a viewer inside this network.
    pub fn enter_command(&self) -> String {
        let pid = self.pid;
        if self.user_namespace {
            format!("nsenter --target {pid} --user --net --preserve-credentials")
        } else {
            format!("nsenter --net=/proc/{pid}/ns/net")
        }
    }
}

/// Why a process is not in its own network.
#[derive(Debug, thiserror::Error)]
pub enum ConfineError {
    /// This machine does not let this user make network namespaces; nothing has changed.
    #[error("this machine forbids network namespaces to this user, or has none")]
    Forbidden {
        /// The kernel's error.
        #[source]
        source: io::Error,
    },
    /// Only the calling thread would move, and the others would stay on the LAN.
    #[error("a network of its own needs a process of 1 thread, found {n_threads}")]
    SeveralThreads {
        /// Threads of this process.
        n_threads: usize,
    },
    /// The kernel refused for another reason.
    #[error("no network of its own")]
    Kernel {
        /// The kernel's error.
        #[source]
        source: io::Error,
    },
}

impl Help for ConfineError {
    fn help(&self) -> Option<String> {
        match self {
            Self::Forbidden { .. } => Some(
                "on Ubuntu the package's profile allows them to `/usr/bin/rsrs` (`sudo apparmor_parser \
                 --replace /etc/apparmor.d/rsrs`); or run as root"
                    .to_owned(),
            ),
            Self::SeveralThreads { .. } | Self::Kernel { .. } => None,
        }
    }
}

impl ConfineError {
    fn new(source: io::Error) -> Self {
        match source.raw_os_error() {
            // No right to; no more namespaces allowed, in the codes of newer and of older kernels;
            // a kernel built without one kind of them, or without all.
            Some(
                libc::EPERM
                | libc::EACCES
                | libc::ENOSPC
                | libc::EUSERS
                | libc::EINVAL
                | libc::ENOSYS,
            ) => Self::Forbidden { source },
            _ => Self::Kernel { source },
        }
    }
}

/// Moves this process, and all it starts from now on, into its own network.
///
/// The network has a loopback interface, up and with multicast. Call this first in `main`, before
/// any thread is started.
///
/// # Errors
///
/// After [`ConfineError::Forbidden`] and [`ConfineError::SeveralThreads`] the process is where it
/// was.
pub fn into_own_network() -> Result<Confinement, ConfineError> {
    let n_threads = kernel::n_threads().map_err(|source| ConfineError::Kernel { source })?;
    if n_threads != 1 {
        return Err(ConfineError::SeveralThreads { n_threads });
    }

    let steps = Steps::of_the_kernel();
    kernel::try_in_a_copy(|| steps.enter().map(drop)).map_err(ConfineError::new)?;
    let user_namespace = steps.enter().map_err(ConfineError::new)?;
    Ok(Confinement { pid: std::process::id(), user_namespace })
}

/// Moves this thread, and all threads and processes that it starts from now on, into a network of
/// its own; the other threads of this process stay where they are. A process that is in a network
/// of its own already may make others.
pub fn thread_into_own_network() -> Result<(), ConfineError> {
    Steps::of_the_kernel().enter().map(drop).map_err(ConfineError::new)
}

/// Has `command` start in its own network, as [`into_own_network`] would put it there.
///
/// This process stays where it is and may have any number of threads. Starting the command fails
/// where namespaces are forbidden.
pub fn start_in_own_network(command: &mut Command) -> &mut Command {
    let steps = Steps::of_the_kernel();
    kernel::before_exec(command, move || steps.enter().map(drop));
    command
}

/// Whether this process sees no interface but `lo`.
pub fn is_confined() -> io::Result<bool> {
    // The thread's own view; sysfs would show the network in which it was mounted.
    Ok(lists_only_loopback(&std::fs::read_to_string("/proc/thread-self/net/dev")?))
}

fn lists_only_loopback(device_table: &str) -> bool {
    let names: Vec<&str> = device_table
        .lines()
        .filter_map(|line| line.split_once(':'))
        .map(|(name, _)| name.trim())
        .collect();
    names == ["lo"]
}

/// A domain (1 to 101) in which no process of this machine has a socket; `None` if there is none.
///
/// The second-best choice, for machines where [`into_own_network`] is forbidden: on the loopback
/// interface in such a domain, no process of this machine listens, and packets stay on the machine
/// unless one comes later.
pub fn free_loopback_domain() -> io::Result<Option<u16>> {
    let mut bound = BTreeSet::new();
    for table in ["/proc/net/udp", "/proc/net/udp6"] {
        // A kernel without IPv6 has no second table.
        if Path::new(table).exists() {
            bound.extend(bound_ports(&std::fs::read_to_string(table)?));
        }
    }
    // Two runs that start at the same time should not look in the same order.
    let [low, high, ..] = std::process::id().to_le_bytes();
    Ok(free_domain(&bound, u16::from_le_bytes([low, high]) % N_DOMAINS))
}

/// Domains 1 to 101: above, the ports fall among those that the kernel hands out.
const N_DOMAINS: u16 = 101;
/// First port of domain 0 (RTPS 9.6.2).
const FIRST_PORT: u16 = 7400;
/// Ports of one domain (RTPS 9.6.2).
const PORTS_PER_DOMAIN: u16 = 250;

fn free_domain(bound: &BTreeSet<u16>, start: u16) -> Option<u16> {
    (0..N_DOMAINS).map(|offset| (start + offset) % N_DOMAINS + 1).find(|domain| {
        let first = FIRST_PORT + PORTS_PER_DOMAIN * domain;
        bound.range(first..first + PORTS_PER_DOMAIN).next().is_none()
    })
}

/// Local ports in the kernel's table of sockets, whose second column is `ADDRESS:PORT` in hex.
fn bound_ports(socket_table: &str) -> impl Iterator<Item = u16> {
    socket_table.lines().skip(1).filter_map(|line| {
        let (_, port) = line.split_whitespace().nth(1)?.rsplit_once(':')?;
        u16::from_str_radix(port, 16).ok()
    })
}

/// The system calls of [`into_own_network`], exchangeable so that a refusal can be tested.
struct Steps {
    unshare: fn(CloneFlags) -> nix::Result<()>,
    write: fn(&str, &[u8]) -> io::Result<()>,
    bring_loopback_up: fn() -> io::Result<()>,
    /// Text for the kernel's tables of users and groups: everybody stays who they are.
    uid_map: String,
    gid_map: String,
}

impl Steps {
    fn of_the_kernel() -> Self {
        let (uid, gid) = (geteuid(), getegid());
        Self {
            unshare,
            write: |path, text| std::fs::write(path, text),
            bring_loopback_up: kernel::bring_loopback_up,
            uid_map: format!("{uid} {uid} 1"),
            gid_map: format!("{gid} {gid} 1"),
        }
    }

    /// Enters a new network; returns whether it took a user namespace. Allocates nothing.
    fn enter(&self) -> io::Result<bool> {
        let user_namespace = match (self.unshare)(CloneFlags::CLONE_NEWNET) {
            Ok(()) => false,
            Err(Errno::EPERM) => {
                (self.unshare)(CloneFlags::CLONE_NEWUSER | CloneFlags::CLONE_NEWNET)?;
                // Without it, only root may write the table of groups.
                (self.write)("/proc/self/setgroups", b"deny")?;
                (self.write)("/proc/self/uid_map", self.uid_map.as_bytes())?;
                (self.write)("/proc/self/gid_map", self.gid_map.as_bytes())?;
                true
            }
            Err(error) => return Err(error.into()),
        };
        (self.bring_loopback_up)()?;
        Ok(user_namespace)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused(_: CloneFlags) -> nix::Result<()> {
        Err(Errno::EPERM)
    }

    fn granted_with_users(flags: CloneFlags) -> nix::Result<()> {
        if flags.contains(CloneFlags::CLONE_NEWUSER) { Ok(()) } else { refused(flags) }
    }

    fn steps(unshare: fn(CloneFlags) -> nix::Result<()>) -> Steps {
        Steps {
            unshare,
            write: |_, _| Ok(()),
            bring_loopback_up: || Ok(()),
            uid_map: String::new(),
            gid_map: String::new(),
        }
    }

    #[test]
    fn whatever_a_kernel_calls_a_machine_without_namespaces_it_is_forbidden() {
        let refusals: [fn(CloneFlags) -> nix::Result<()>; 5] = [
            refused,
            |_| Err(Errno::EINVAL),
            |_| Err(Errno::EUSERS),
            |_| Err(Errno::ENOSPC),
            |_| Err(Errno::ENOSYS),
        ];
        for refusal in refusals {
            let error = ConfineError::new(steps(refusal).enter().unwrap_err());

            assert!(matches!(error, ConfineError::Forbidden { .. }), "{error:?}");
            assert!(error.help().is_some());
        }
        // What Ubuntu does: the namespace is made, but without capabilities in it.
        let without_rights = Steps {
            write: |_, _| Err(io::Error::from_raw_os_error(libc::EACCES)),
            ..steps(granted_with_users)
        };
        let error = ConfineError::new(without_rights.enter().unwrap_err());
        assert!(matches!(error, ConfineError::Forbidden { .. }), "{error:?}");
        let broken = ConfineError::new(io::Error::from_raw_os_error(libc::EIO));
        assert!(matches!(broken, ConfineError::Kernel { .. }), "{broken:?}");
    }

    #[test]
    fn root_needs_no_user_namespace_and_others_do() {
        assert!(!steps(|_| Ok(())).enter().unwrap());
        assert!(steps(granted_with_users).enter().unwrap());
    }

    #[test]
    fn a_process_with_several_threads_stays_where_it_is() {
        // The test harness has a thread of its own for each test.
        let other = std::thread::spawn(std::thread::park);

        let error = into_own_network().unwrap_err();

        assert!(matches!(error, ConfineError::SeveralThreads { n_threads: 2.. }), "{error:?}");
        other.thread().unpark();
        other.join().unwrap();
    }

    #[test]
    fn a_device_table_with_another_interface_is_not_confined() {
        let header = "Inter-|   Receive\n face |bytes    packets\n";
        let alone = format!("{header}    lo:    1500      10    0\n");
        let with_lan = format!("{alone}  eth0: 99 1 0\n");

        assert!(lists_only_loopback(&alone));
        assert!(!lists_only_loopback(&with_lan));
        assert!(!lists_only_loopback(header));
    }

    #[test]
    fn a_domain_with_a_bound_port_is_skipped() {
        // 7650 is the first port of domain 1, 0x1DE2.
        let table = "  sl  local_address rem_address   st\n   0: 00000000:1DE2 00000000:0000 07\n";
        let bound: BTreeSet<u16> = bound_ports(table).collect();

        assert_eq!(bound, BTreeSet::from([7650]));
        assert_eq!(free_domain(&bound, 0), Some(2));
        assert_eq!(free_domain(&BTreeSet::new(), 100), Some(101));
        assert_eq!(free_domain(&(0..=u16::MAX).collect(), 5), None);
    }

    #[test]
    fn the_command_to_look_inside_fits_the_kind_of_namespace() {
        let root = Confinement { pid: 7, user_namespace: false };
        let user = Confinement { pid: 7, user_namespace: true };

        assert_eq!(root.enter_command(), "nsenter --net=/proc/7/ns/net");
        assert_eq!(user.enter_command(), "nsenter --target 7 --user --net --preserve-credentials");
    }
}
