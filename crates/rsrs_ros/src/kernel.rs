//! System calls that the standard library does not offer.

#![expect(unsafe_code, reason = "system calls are not safe by themselves")]

use std::collections::BTreeSet;
use std::ffi::{CStr, c_char, c_int, c_ulong};
use std::io;
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr};
use std::os::fd::{AsRawFd, FromRawFd, OwnedFd};
use std::os::unix::process::CommandExt;
use std::process::Command;

/// A new network for this thread and what it starts.
pub(crate) const NEW_NETWORK: c_int = libc::CLONE_NEWNET;
/// A new set of users, in which an ordinary user may make a network.
pub(crate) const NEW_USERS: c_int = libc::CLONE_NEWUSER;

/// Name of the loopback interface.
const LOOPBACK: &CStr = c"lo";

/// Turns -1 into the last error.
fn check(outcome: c_int) -> io::Result<()> {
    if outcome == -1 { Err(io::Error::last_os_error()) } else { Ok(()) }
}

/// Moves this thread into new namespaces.
pub(crate) fn unshare(flags: c_int) -> io::Result<()> {
    // SAFETY: takes flags and no pointers.
    check(unsafe { libc::unshare(flags) })
}

/// Does something in a thread that receives no signals meanwhile; nor do the threads that it starts,
/// for good.
pub(crate) fn without_signals<T>(work: impl FnOnce() -> T) -> io::Result<T> {
    // SAFETY: `sigset_t` is plain data, for which all zeros is a value; it is filled next.
    let [mut all, mut before]: [libc::sigset_t; 2] = unsafe { std::mem::zeroed() };
    // SAFETY: both sets live until the end of this function.
    check(unsafe { libc::sigfillset(&raw mut all) })?;
    // SAFETY: as above.
    check_number(unsafe {
        libc::pthread_sigmask(libc::SIG_SETMASK, &raw const all, &raw mut before)
    })?;
    let done = work();
    // SAFETY: `before` was filled by the call above.
    let restored = unsafe {
        libc::pthread_sigmask(libc::SIG_SETMASK, &raw const before, std::ptr::null_mut())
    };
    check_number(restored)?;
    Ok(done)
}

/// Turns an error's number into the error.
fn check_number(error: c_int) -> io::Result<()> {
    if error == 0 { Ok(()) } else { Err(io::Error::from_raw_os_error(error)) }
}

/// Effective user and group of this process.
pub(crate) fn effective_ids() -> (u32, u32) {
    // SAFETY: both only read a number and cannot fail.
    unsafe { (libc::geteuid(), libc::getegid()) }
}

/// Brings `lo` up, with multicast and the route for it.
pub(crate) fn bring_loopback_up() -> io::Result<()> {
    let socket = datagram_socket()?;
    set_loopback_flags(&socket)?;
    route_multicast_to_loopback(&socket)
}

/// A socket to ask the kernel about interfaces; nothing is sent on it.
fn datagram_socket() -> io::Result<OwnedFd> {
    // SAFETY: takes numbers and no pointers.
    let descriptor =
        unsafe { libc::socket(libc::AF_INET, libc::SOCK_DGRAM | libc::SOCK_CLOEXEC, 0) };
    check(descriptor)?;
    // SAFETY: the descriptor was just opened and has no other owner.
    Ok(unsafe { OwnedFd::from_raw_fd(descriptor) })
}

/// Adds "up", "running" and "multicast" to the flags of `lo`.
fn set_loopback_flags(socket: &OwnedFd) -> io::Result<()> {
    // SAFETY: `ifreq` is plain data, for which all zeros is a value.
    let mut request: libc::ifreq = unsafe { std::mem::zeroed() };
    for (to, from) in request.ifr_name.iter_mut().zip(LOOPBACK.to_bytes_with_nul()) {
        *to = from.cast_signed() as c_char;
    }

    // SAFETY: the request outlives the call and has the shape that this ioctl fills.
    check(unsafe {
        libc::ioctl(socket.as_raw_fd(), libc::SIOCGIFFLAGS as libc::Ioctl, &raw mut request)
    })?;
    let wanted = libc::IFF_UP | libc::IFF_RUNNING | libc::IFF_MULTICAST;
    let wanted = i16::try_from(wanted).expect("these flags are in the lower 15 bits");
    // SAFETY: the flags are the member of the union that the call before filled.
    unsafe { request.ifr_ifru.ifru_flags |= wanted };
    // SAFETY: the request outlives the call and has the shape that this ioctl reads.
    check(unsafe {
        libc::ioctl(socket.as_raw_fd(), libc::SIOCSIFFLAGS as libc::Ioctl, &raw const request)
    })
}

/// Adds the route `224.0.0.0/4 dev lo`.
fn route_multicast_to_loopback(socket: &OwnedFd) -> io::Result<()> {
    // SAFETY: `rtentry` is plain data, for which all zeros is a value.
    let mut route: libc::rtentry = unsafe { std::mem::zeroed() };
    route.rt_dst = address(Ipv4Addr::new(224, 0, 0, 0));
    route.rt_genmask = address(Ipv4Addr::new(240, 0, 0, 0));
    route.rt_flags = libc::RTF_UP;
    route.rt_dev = LOOPBACK.as_ptr().cast_mut();

    // SAFETY: the route and the name it points to outlive the call, which only reads them.
    check(unsafe {
        libc::ioctl(socket.as_raw_fd(), libc::SIOCADDRT as libc::Ioctl, &raw const route)
    })
}

/// An address as the kernel's route table takes it: family, port 0, four bytes.
fn address(ip: Ipv4Addr) -> libc::sockaddr {
    let mut data: [c_char; 14] = [0; 14];
    for (to, from) in data[2..6].iter_mut().zip(ip.octets()) {
        *to = from.cast_signed() as c_char;
    }
    let family = libc::sa_family_t::try_from(libc::AF_INET).expect("AF_INET is 2");
    libc::sockaddr { sa_family: family, sa_data: data }
}

/// Has a child run `prepare` between fork and exec.
///
/// `prepare` must restrict itself to system calls: another thread of this process may have held
/// the allocator's lock at the fork. The only caller is [`crate::confine`], whose steps open and
/// write files under short paths and call the functions above.
pub(crate) fn before_exec(
    command: &mut Command,
    prepare: impl FnMut() -> io::Result<()> + Send + Sync + 'static,
) {
    // SAFETY: as above, `prepare` neither allocates nor takes a lock.
    unsafe { command.pre_exec(prepare) };
}

/// Ends this process, without anything that an ordinary end runs.
pub(crate) fn exit_at_once(code: u8) -> ! {
    // SAFETY: takes a number, and does not return.
    unsafe { libc::_exit(c_int::from(code)) }
}

/// Tries `attempt` in a forked copy of this process, so that a failure leaves no trace in this one.
///
/// # Panics
///
/// If the process has more than one thread, because the copy has only one.
pub(crate) fn try_in_a_copy(attempt: impl FnOnce() -> io::Result<()>) -> io::Result<()> {
    assert_eq!(n_threads()?, 1, "a copy of a process with several threads may hang");
    // SAFETY: the process has one thread, so the copy is complete; it leaves by `_exit` alone.
    let child = unsafe { libc::fork() };
    check(child)?;
    if child == 0 {
        let code = attempt().err().map_or(0, |error| error.raw_os_error().unwrap_or(libc::EIO));
        // SAFETY: ends the copy at once, without the exit handlers of the original.
        unsafe { libc::_exit(code) };
    }
    let mut status = 0;
    // SAFETY: waits for the copy made above; `status` outlives the call.
    while unsafe { libc::waitpid(child, &raw mut status, 0) } == -1 {
        let error = io::Error::last_os_error();
        if error.kind() != io::ErrorKind::Interrupted {
            return Err(error);
        }
    }
    match libc::WEXITSTATUS(status) {
        0 if libc::WIFEXITED(status) => Ok(()),
        0 => Err(io::Error::from_raw_os_error(libc::EIO)),
        code => Err(io::Error::from_raw_os_error(code)),
    }
}

pub(crate) fn n_threads() -> io::Result<usize> {
    Ok(std::fs::read_dir("/proc/self/task")?.count())
}

/// Identities of the threads of this process whose name starts so.
pub(crate) fn threads_named(start: &str) -> io::Result<BTreeSet<u32>> {
    let mut found = BTreeSet::new();
    for entry in std::fs::read_dir("/proc/self/task")? {
        let entry = entry?;
        let Some(id) = entry.file_name().to_str().and_then(|name| name.parse().ok()) else {
            continue;
        };
        // A thread may end while we look.
        if std::fs::read_to_string(entry.path().join("comm"))
            .is_ok_and(|name| name.starts_with(start))
        {
            found.insert(id);
        }
    }
    Ok(found)
}

/// Whether a thread of this process waits for something.
pub(crate) fn is_asleep(thread: u32) -> bool {
    let stat = std::fs::read_to_string(format!("/proc/self/task/{thread}/stat"));
    stat.is_ok_and(|stat| {
        // The name before it may contain anything.
        let behind_name = stat.rsplit_once(')').map_or("", |(_, rest)| rest);
        behind_name.trim_start().starts_with('S')
    })
}

/// How often and how long a thread of this process has run, and waited for a processor, as the kernel
/// writes it; `None` if there is no such thread, or the kernel does not count it.
pub(crate) fn scheduled(thread: u32) -> Option<String> {
    std::fs::read_to_string(format!("/proc/self/task/{thread}/schedstat")).ok()
}

pub(crate) fn thread_id() -> u32 {
    // Not `libc::gettid`, which glibc has from 2.30 on: wheels are for 2.28.
    // SAFETY: takes nothing and cannot fail.
    let thread = unsafe { libc::syscall(libc::SYS_gettid) };
    u32::try_from(thread).expect("identities of threads are positive and small")
}

/// Sends this process `SIGTERM` when the thread that started it ends.
pub(crate) fn terminate_with_parent() -> io::Result<()> {
    let signal = c_ulong::try_from(libc::SIGTERM).expect("signals are positive");
    // SAFETY: takes numbers and no pointers.
    check(unsafe { libc::prctl(libc::PR_SET_PDEATHSIG, signal) })
}

/// Sends a process `SIGTERM`.
pub(crate) fn terminate(pid: u32) -> io::Result<()> {
    let pid = libc::pid_t::try_from(pid)
        .map_err(|error| io::Error::new(io::ErrorKind::InvalidInput, error))?;
    // SAFETY: takes numbers and no pointers.
    check(unsafe { libc::kill(pid, libc::SIGTERM) })
}

/// Every address of every interface that is up.
pub(crate) fn interface_addresses() -> io::Result<Vec<(String, IpAddr)>> {
    let mut first: *mut libc::ifaddrs = std::ptr::null_mut();
    // SAFETY: fills the pointer with a list, which is freed below.
    check(unsafe { libc::getifaddrs(&raw mut first) })?;

    let mut found = Vec::new();
    let mut next = first;
    // SAFETY: the list ends with a null pointer and lives until `freeifaddrs`.
    while let Some(entry) = unsafe { next.as_ref() } {
        next = entry.ifa_next;
        let flags = c_int::try_from(entry.ifa_flags).unwrap_or(0);
        if flags & libc::IFF_UP == 0 {
            continue;
        }
        // SAFETY: the address of an entry is null or a socket address of its own family.
        if let Some(ip) = unsafe { ip_address(entry.ifa_addr) } {
            // SAFETY: the name of an entry is a string that ends with zero.
            let name = unsafe { CStr::from_ptr(entry.ifa_name) };
            found.push((name.to_string_lossy().into_owned(), ip));
        }
    }
    // SAFETY: the list came from `getifaddrs`, and nothing points into it any more.
    unsafe { libc::freeifaddrs(first) };
    Ok(found)
}

/// The IP address in a socket address; `None` for other families.
///
/// # Safety
///
/// `socket_address` is null or points to a socket address as long as its family requires.
unsafe fn ip_address(socket_address: *const libc::sockaddr) -> Option<IpAddr> {
    // SAFETY: the caller guarantees that it is null or a socket address.
    let family = c_int::from(unsafe { socket_address.as_ref() }?.sa_family);
    if family == libc::AF_INET {
        // SAFETY: the family names the structure that is there; it is read wherever it lies.
        let v4 = unsafe { socket_address.cast::<libc::sockaddr_in>().read_unaligned() };
        Some(Ipv4Addr::from(v4.sin_addr.s_addr.to_ne_bytes()).into())
    } else if family == libc::AF_INET6 {
        // SAFETY: the family names the structure that is there; it is read wherever it lies.
        let v6 = unsafe { socket_address.cast::<libc::sockaddr_in6>().read_unaligned() };
        Some(Ipv6Addr::from(v6.sin6_addr.s6_addr).into())
    } else {
        None
    }
}
