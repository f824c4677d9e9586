use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use crate::authority::Authority;
use crate::check::problems_of;
use crate::create::{KeystoreRequest, MadeEnclave, create, write_governance};
use crate::files;
use crate::governance::Governance;
use crate::harden::{Hardened, harden};
use crate::layout::KEY;

/// Noon of a day in 2026.
const NOW: Duration = Duration::from_secs(1_767_268_800);
const DAY: Duration = Duration::from_secs(24 * 3600);

fn robots() -> Vec<String> {
    ["robot_1", "robot_2"].map(str::to_owned).to_vec()
}

fn request<'a>(folder: &'a Path, robots: &'a [String]) -> KeystoreRequest<'a> {
    KeystoreRequest { folder, robots, domain_id: 7, now: NOW, validity: DAY * 30 }
}

fn texts(folder: &Path, domain_id: u16, now: Duration) -> Vec<String> {
    problems_of(folder, domain_id, now).iter().map(ToString::to_string).collect()
}

/// The openssl program, which is part of every system that this runs on.
fn openssl(arguments: &[&str]) -> (bool, String) {
    let output = Command::new("openssl").args(arguments).output().expect("openssl is installed");
    let text = [output.stdout, output.stderr].concat();
    (output.status.success(), String::from_utf8_lossy(&text).into_owned())
}

#[test]
fn a_robot_in_a_namespace_has_an_enclave_in_a_folder_of_it_whose_links_lead_to_its_files() {
    let folder = tempfile::tempdir().unwrap();
    let robots = ["lab/robot_1".to_owned(), "robot_2".to_owned()];

    let made = create(&request(folder.path(), &robots)).unwrap();

    assert_eq!(made[0].enclave, "/lab/robot_1");
    for enclave in &made {
        assert_eq!(problems_of(&enclave.folder, 7, NOW), [], "{}", enclave.enclave);
    }
    let grant = std::fs::read_to_string(made[0].folder.join("permissions.xml")).unwrap();
    assert!(grant.contains("rt/lab/robot_1/detection"), "{grant}");
    assert!(!grant.contains("rt/robot_2/detection"), "{grant}");
}

#[test]
fn every_enclave_of_a_new_keystore_can_be_used_in_its_domain_and_in_its_time() {
    let folder = tempfile::tempdir().unwrap();
    let robots = robots();

    let made = create(&request(folder.path(), &robots)).unwrap();

    let names: Vec<&str> = made.iter().map(|made| made.enclave.as_str()).collect();
    let others = ["/controllers", "/simulator", "/runner", "/stop", "/tracker", "/viewer"];
    assert_eq!(names, [&["/robot_1", "/robot_2"][..], &others[..]].concat());
    for MadeEnclave { folder, is_new, .. } in &made {
        assert!(is_new);
        assert_eq!(texts(folder, 7, NOW), [""; 0]);
        let elsewhere = texts(folder, 8, NOW);
        assert!(elsewhere[0].contains("governance.p7s has no rule for domain 8"), "{elsewhere:?}");
        assert!(elsewhere[1].contains("allows nothing in domain 8"), "{elsewhere:?}");
        let late = texts(folder, 7, NOW + DAY * 31);
        assert!(late.iter().all(|text| text.contains("has expired at 2026-01-31")), "{late:?}");
        assert_eq!(late.len(), 4, "{late:?}");
    }
}

#[test]
fn the_openssl_program_verifies_certificates_and_documents_and_refuses_what_was_changed() {
    let folder = tempfile::tempdir().unwrap();
    let robots = robots();
    create(&request(folder.path(), &robots)).unwrap();
    let enclave = folder.path().join("enclaves/robot_1");
    let path = |file: &str| enclave.join(file).to_str().unwrap().to_owned();
    let authority = path("permissions_ca.cert.pem");
    let at = NOW.as_secs().to_string();
    let verify = |file: &str| {
        let document = path(file);
        let with = ["-CAfile", authority.as_str(), "-attime", at.as_str()];
        openssl(&[&["smime", "-verify", "-text", "-in", document.as_str()], &with[..]].concat())
    };

    let identity = path("identity_ca.cert.pem");
    let certificate = path("cert.pem");
    let chain = ["verify", "-attime", &at, "-CAfile", &identity, &certificate];
    let (is_chain, text) = openssl(&chain);
    assert!(is_chain, "{text}");
    for file in ["governance.p7s", "permissions.p7s"] {
        let (is_signed, text) = verify(file);
        assert!(is_signed && text.contains("</dds>"), "{file}: {text}");
    }
    let changed = std::fs::read_to_string(path("permissions.p7s")).unwrap();
    std::fs::write(path("changed.p7s"), changed.replace("rt/robot_1/", "rt/robot_2/")).unwrap();
    let (is_signed, text) = verify("changed.p7s");
    assert!(!is_signed, "{text}");
    let (is_key, text) = openssl(&["pkey", "-in", &path("key.pem"), "-noout", "-check"]);
    assert!(is_key, "{text}");
}

#[test]
fn keys_are_private_and_never_written_again() {
    let folder = tempfile::tempdir().unwrap();
    let mut robots = robots();
    create(&request(folder.path(), &robots)).unwrap();
    let keys = |folder: &Path| -> Vec<(PathBuf, String)> {
        let keys = files::keys_below(folder).unwrap().into_iter();
        keys.map(|key| (key.clone(), std::fs::read_to_string(key).unwrap())).collect()
    };
    let before = keys(folder.path());

    robots.push("robot_3".to_owned());
    let made = create(&request(folder.path(), &robots)).unwrap();

    let new: Vec<&str> =
        made.iter().filter(|made| made.is_new).map(|made| made.enclave.as_str()).collect();
    assert_eq!(new, ["/robot_3"]);
    let after = keys(folder.path());
    assert!(before.iter().all(|key| after.contains(key)) && after.len() == before.len() + 1);
    for (key, _) in &after {
        let mode = std::fs::metadata(key).unwrap().permissions().mode();
        assert_eq!(mode & 0o777, 0o600, "{}", key.display());
    }
    let simulator = folder.path().join("enclaves/simulator/permissions.xml");
    assert!(std::fs::read_to_string(simulator).unwrap().contains("rt/robot_3/detection"));
}

#[test]
fn a_copy_of_one_enclave_with_what_its_links_lead_to_is_whole() {
    let folder = tempfile::tempdir().unwrap();
    let robots = robots();
    create(&request(&folder.path().join("keystore"), &robots)).unwrap();
    let copy = folder.path().join("robot_1");

    let copied = Command::new("cp")
        .args(["-rLp"])
        .arg(folder.path().join("keystore/enclaves/robot_1"))
        .arg(&copy)
        .status();

    assert!(copied.unwrap().success());
    assert_eq!(texts(&copy, 7, NOW), [""; 0]);
}

#[test]
fn a_keystore_of_sros2_is_hardened_once() {
    let folder = tempfile::tempdir().unwrap();
    let robots = robots();
    create(&request(folder.path(), &robots)).unwrap();
    let enclave = folder.path().join("enclaves/robot_1");
    // What `ros2 security` leaves: payloads protected by themselves, keys that others can read.
    let text = std::fs::read_to_string(folder.path().join("enclaves/governance.xml")).unwrap();
    let of_sros2 = text.replace("<data_protection_kind>NONE", "<data_protection_kind>ENCRYPT");
    let authority = Authority::read(folder.path()).unwrap();
    let governance = Governance::parse(&of_sros2).unwrap();
    write_governance(&authority, folder.path(), &governance).unwrap();
    let key = enclave.join(KEY);
    std::fs::set_permissions(&key, std::fs::Permissions::from_mode(0o644)).unwrap();
    let before = texts(&enclave, 7, NOW);

    let hardened = harden(folder.path()).unwrap();

    assert_eq!(before.len(), 2, "{before:?}");
    assert_eq!(hardened.keys_made_private, [key]);
    assert!(hardened.cured[0].contains("multiple of 4"), "{hardened:?}");
    assert_eq!(texts(&enclave, 7, NOW), [""; 0]);
    let again = harden(folder.path()).unwrap();
    assert_eq!(again, Hardened { cured: Vec::new(), keys_made_private: Vec::new() });
}

#[test]
fn other_folders_are_left_alone() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("notes.txt"), "mine").unwrap();
    let robots = robots();

    let created = create(&request(folder.path(), &robots)).unwrap_err();
    let hardened = harden(folder.path()).unwrap_err();

    assert!(created.to_string().contains("has files, and is no keystore"), "{created}");
    assert!(hardened.to_string().contains("is no keystore"), "{hardened}");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn no_robot_gets_the_rights_of_another_member_by_its_name() {
    let folder = tempfile::tempdir().unwrap();
    let robots = ["runner".to_owned()];

    let error = create(&request(folder.path(), &robots)).unwrap_err();

    assert!(error.to_string().contains("robot `runner` has the name of an enclave"), "{error}");
}
