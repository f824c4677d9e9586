//! Moves real processes into networks of their own; without a test harness, because a harness has
//! threads.

use std::io::Write;
use std::net::{Ipv4Addr, UdpSocket};
use std::os::unix::fs::PermissionsExt;
use std::os::unix::process::CommandExt;
use std::process::Command;
use std::time::Duration;

use rsrs_ros::confine::{self, ConfineError};

/// Set in a child that runs as an ordinary user.
const IS_ORDINARY: &str = "RSRS_TEST_AS_ORDINARY_USER";
/// User and group "nobody".
const NOBODY: u32 = 65534;

fn main() {
    if std::env::var_os(IS_ORDINARY).is_some() {
        an_ordinary_user_gets_a_network_or_stays_where_they_are();
        return;
    }
    // First, because children of a confined process are confined too.
    as_ordinary_user();
    this_process_sees_lo_alone_and_multicast_works_on_it();
    writeln!(std::io::stdout(), "confinement: ok").expect("stdout is open");
}

fn this_process_sees_lo_alone_and_multicast_works_on_it() {
    let confinement = confine::into_own_network().expect("tests need network namespaces");

    assert_eq!(confinement.pid, std::process::id());
    assert!(confine::is_confined().expect("/proc is readable"));
    multicast_works();
    assert!(confine::free_loopback_domain().expect("/proc is readable").is_some());
}

fn multicast_works() {
    // The address on which DDS participants look for each other.
    let group = Ipv4Addr::new(239, 255, 0, 1);
    let listener = UdpSocket::bind((Ipv4Addr::UNSPECIFIED, 0)).expect("a socket");
    listener.join_multicast_v4(&group, &Ipv4Addr::LOCALHOST).expect("lo has multicast");
    listener.set_read_timeout(Some(Duration::from_secs(5))).expect("a timeout");
    let port = listener.local_addr().expect("it is bound").port();
    let sender = UdpSocket::bind((Ipv4Addr::UNSPECIFIED, 0)).expect("a socket");
    sender.send_to(b"hello", (group, port)).expect("there is a route for multicast");

    let mut buffer = [0; 16];
    let (n_bytes, _) = listener.recv_from(&mut buffer).expect("the datagram comes back");

    assert_eq!(&buffer[..n_bytes], b"hello");
}

/// Runs this program again as nobody; as it is, if this user is nobody special already.
fn as_ordinary_user() {
    let folder = tempfile::tempdir().expect("a folder to write in");
    std::fs::set_permissions(folder.path(), PermissionsExt::from_mode(0o755)).expect("it is ours");
    let program = folder.path().join("confine");
    // Nobody may not look into every folder where a build may be.
    std::fs::copy(std::env::current_exe().expect("it runs"), &program).expect("it is readable");
    let mut command = Command::new(&program);
    command.env(IS_ORDINARY, "1").current_dir("/");
    let is_root = std::fs::read_to_string("/proc/self/status")
        .expect("/proc is readable")
        .lines()
        .any(|line| line.starts_with("Uid:\t0\t"));
    if is_root {
        command.uid(NOBODY).gid(NOBODY);
    }

    let status = command.status().expect("a copy of a program runs");

    assert!(status.success(), "as an ordinary user: {status}");
}

fn an_ordinary_user_gets_a_network_or_stays_where_they_are() {
    let interfaces =
        || std::fs::read_to_string("/proc/thread-self/net/dev").map(|t| t.lines().count());
    let before = interfaces().expect("/proc is readable");

    match confine::into_own_network() {
        Ok(confinement) => {
            assert!(confinement.user_namespace, "only root needs no user namespace");
            assert!(confine::is_confined().expect("/proc is readable"));
            multicast_works();
        }
        Err(ConfineError::Forbidden { .. }) => {
            assert_eq!(interfaces().expect("/proc is readable"), before, "it moved half-way");
        }
        Err(other) => panic!("{other:?}"),
    }
}
