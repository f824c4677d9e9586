//! System calls that the standard library does not offer.

#![expect(unsafe_code, reason = "system calls are not safe by themselves")]

use std::collections::BTreeSet;
use std::ffi::{CStr, c_char, c_int};
use std::io;
use std::net::Ipv4Addr;
use std::os::fd::{AsRawFd, OwnedFd};
use std::os::unix::process::CommandExt;
use std::process::Command;

use nix::errno::Errno;
use nix::sys::signal::{SigSet, SigmaskHow};
use nix::sys::socket::{AddressFamily, SockFlag, SockType, socket};
use nix::sys::wait::{WaitStatus, waitpid};
use nix::unistd::{ForkResult, fork};

/// Name of the loopback interface.
const LOOPBACK: &CStr = c"lo";

/// Turns -1 into the last error.
fn check(outcome: c_int) -> io::Result<()> {
    if outcome == -1 { Err(io::Error::last_os_error()) } else { Ok(()) }
}

/// Does something in a thread that receives no signals meanwhile; nor do the threads that it starts,
/// for good.
pub(crate) fn without_signals<T>(work: impl FnOnce() -> T) -> io::Result<T> {
    let before = SigSet::all().thread_swap_mask(SigmaskHow::SIG_SETMASK)?;
    let done = work();
    before.thread_set_mask()?;
    Ok(done)
}

/// Brings `lo` up, with multicast and the route for it.
pub(crate) fn bring_loopback_up() -> io::Result<()> {
    // To ask the kernel about interfaces; nothing is sent on it.
    let socket = socket(AddressFamily::Inet, SockType::Datagram, SockFlag::SOCK_CLOEXEC, None)?;
    set_loopback_flags(&socket)?;
    route_multicast_to_loopback(&socket)
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
/// write files under short paths, ask for a namespace, and call [`bring_loopback_up`].
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
    let child = match unsafe { fork() }? {
        ForkResult::Parent { child } => child,
        ForkResult::Child => {
            let code = attempt().err().map_or(0, |error| error.raw_os_error().unwrap_or(libc::EIO));
            // SAFETY: ends the copy at once, without the exit handlers of the original.
            unsafe { libc::_exit(code) };
        }
    };
    let status = loop {
        match waitpid(child, None) {
            Err(Errno::EINTR) => {}
            status => break status?,
        }
    };
    match status {
        WaitStatus::Exited(_, 0) => Ok(()),
        WaitStatus::Exited(_, code) => Err(io::Error::from_raw_os_error(code)),
        _ => Err(io::Error::from_raw_os_error(libc::EIO)),
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
