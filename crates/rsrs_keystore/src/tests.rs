use std::collections::BTreeSet;
use std::error::Error;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use rsrs_core::help::Help;
use tempfile::TempDir;

use crate::authority::Authority;
use crate::check::problems_of;
use crate::create::{KeystoreRequest, MadeEnclave, create};
use crate::error::KeystoreError;
use crate::files;
use crate::governance::{Domains, Governance, Switch, Weakness};
use crate::harden::{Hardened, harden};
use crate::layout::KEY;
use crate::members::{ShownMember, renew, revoke, show};
use crate::problem::{EnclaveProblem, cures};

/// Noon of a day in 2026.
const NOW: Duration = Duration::new(1_767_268_800, 600_000_000);
const DAY: Duration = Duration::from_secs(24 * 3600);

fn robots() -> Vec<String> {
    ["robot_1", "robot_2"].map(str::to_owned).to_vec()
}

fn request<'a>(folder: &'a Path, robots: &'a [String]) -> KeystoreRequest<'a> {
    let validity = Some(DAY * 30);
    KeystoreRequest { folder, robots, domain_id: Some(7), now: NOW, validity, readmitted: &[] }
}

/// A keystore of two robots.
fn created() -> (TempDir, Vec<String>) {
    let (folder, robots) = (tempfile::tempdir().unwrap(), robots());
    create(&request(folder.path(), &robots)).unwrap();
    (folder, robots)
}

/// Copies a folder, and what its links lead to.
fn copy_of(folder: &Path, to: &Path) {
    let copied = Command::new("cp").arg("-rLp").args([folder, to]).status();
    assert!(copied.unwrap().success());
}

/// What is wrong with an enclave that is called as its folder.
fn texts(folder: &Path, domain_id: u16, now: Duration) -> Vec<String> {
    let name = format!("/{}", folder.file_name().unwrap().to_str().unwrap());
    problems_of(&name, folder, domain_id, now).iter().map(ToString::to_string).collect()
}

/// What is wrong with the members of a keystore, each with its enclave.
fn shown(keystore: &Path) -> Vec<String> {
    let members = show(keystore, NOW).unwrap().members.into_iter();
    let text = |member: ShownMember| {
        let problems = member.problems.iter().map(ToString::to_string).collect::<Vec<_>>();
        (!problems.is_empty()).then(|| format!("{}: {}", member.enclave, problems.join("; ")))
    };
    members.filter_map(text).map(|text| text.replace(keystore.to_str().unwrap(), "k")).collect()
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

    let made = create(&request(folder.path(), &robots)).unwrap().enclaves;

    assert_eq!(made[0].enclave, "/lab/robot_1");
    for enclave in &made {
        assert_eq!(
            problems_of(&enclave.enclave, &enclave.folder, 7, NOW),
            [],
            "{}",
            enclave.enclave
        );
    }
    let grant = std::fs::read_to_string(made[0].folder.join("permissions.xml")).unwrap();
    assert!(grant.contains("rt/lab/robot_1/detection"), "{grant}");
    assert!(!grant.contains("rt/robot_2/detection"), "{grant}");
}

#[test]
fn every_enclave_of_a_new_keystore_can_be_used_in_its_domain_and_in_its_time() {
    let folder = tempfile::tempdir().unwrap();
    let robots = robots();

    let made = create(&request(folder.path(), &robots)).unwrap().enclaves;

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
    let (folder, _) = created();
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
    let (folder, mut robots) = created();
    let keys = |folder: &Path| -> Vec<(PathBuf, String)> {
        let keys = files::keys_in(folder).unwrap().into_iter();
        keys.map(|key| (key.clone(), std::fs::read_to_string(key).unwrap())).collect()
    };
    let before = keys(folder.path());

    robots.push("robot_3".to_owned());
    let made = create(&request(folder.path(), &robots)).unwrap().enclaves;

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

    copy_of(&folder.path().join("keystore/enclaves/robot_1"), &copy);

    assert_eq!(texts(&copy, 7, NOW), [""; 0]);
}

#[test]
fn a_keystore_of_sros2_is_hardened_once() {
    let (folder, _) = created();
    let enclave = folder.path().join("enclaves/robot_1");
    // What `ros2 security` leaves: payloads protected by themselves, keys that others can read.
    let text = std::fs::read_to_string(folder.path().join("enclaves/governance.xml")).unwrap();
    let of_sros2 = text.replace("<data_protection_kind>NONE", "<data_protection_kind>ENCRYPT");
    let authority = Authority::read(folder.path()).unwrap();
    let governance = Governance::parse(&of_sros2).unwrap();
    authority.write_governance(folder.path(), &governance).unwrap();
    let key = enclave.join(KEY);
    std::fs::set_permissions(&key, std::fs::Permissions::from_mode(0o644)).unwrap();
    let before = texts(&enclave, 7, NOW);

    let hardened = harden(folder.path()).unwrap();

    assert_eq!(before.len(), 2, "{before:?}");
    assert_eq!(hardened.keys_made_private, [key]);
    assert!(hardened.cured[0].contains("multiple of 4"), "{hardened:?}");
    assert_eq!(texts(&enclave, 7, NOW), [""; 0]);
    let again = harden(folder.path()).unwrap();
    assert_eq!(
        again,
        Hardened { cured: Vec::new(), keys_made_private: Vec::new(), linked: Vec::new() }
    );
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
    let names =
        ["runner", "swarm", "simulator/a", "experiment_runner", "rsrs_stop", "rosout", "tf"];
    for name in names.map(str::to_owned) {
        let error = create(&request(folder.path(), std::slice::from_ref(&name))).unwrap_err();

        assert!(error.to_string().starts_with(&format!("robot `{name}` has the name")), "{error}");
    }
    assert!(!folder.path().join("enclaves").exists());
}

#[test]
fn a_keystore_keeps_its_domain_and_refuses_another_one() {
    let (folder, robots) = created();

    let again = KeystoreRequest { domain_id: None, ..request(folder.path(), &robots) };
    let made = create(&again).unwrap();
    let elsewhere = KeystoreRequest { domain_id: Some(0), ..request(folder.path(), &robots) };
    let refused = create(&elsewhere).unwrap_err();

    assert_eq!(made.domain_id, 7);
    for enclave in &made.enclaves {
        assert_eq!(texts(&enclave.folder, 7, NOW), [""; 0]);
    }
    assert_eq!(refused.to_string(), "the keystore holds in domain 7, and not in 0");
}

#[test]
fn nothing_is_signed_that_holds_longer_than_its_authority() {
    let (folder, robots) = created();
    let at = |now: Duration, validity: Option<Duration>| {
        create(&KeystoreRequest { now, validity, ..request(folder.path(), &robots) })
    };

    let longer = at(NOW + DAY, Some(DAY * 30)).unwrap_err();
    let late = at(NOW + DAY * 60, None).unwrap_err();
    at(NOW + DAY, None).unwrap();

    assert!(longer.to_string().starts_with("the authority ends on 2026-01-31T12:00:00Z, before"));
    assert!(late.to_string().ends_with("and signs nothing any more"), "{late}");
    let shown = show(folder.path(), NOW).unwrap();
    let ends: BTreeSet<_> = shown.members.iter().map(|member| member.ends).collect();
    assert_eq!(ends, BTreeSet::from([Some(shown.authority_ends)]));
    assert_eq!(shown.authority_ends, Duration::from_secs(NOW.as_secs()) + DAY * 30);
}

#[test]
fn a_keystore_that_has_ended_is_renewed_with_the_keys_that_it_has() {
    let folder = tempfile::tempdir().unwrap();
    let robots = robots();
    let made = create(&request(folder.path(), &robots)).unwrap().enclaves;
    let keys = || {
        let keys = files::keys_in(folder.path()).unwrap().into_iter();
        keys.map(|key| std::fs::read_to_string(key).unwrap()).collect::<Vec<_>>()
    };
    let (before, late) = (keys(), NOW + DAY * 60);

    renew(folder.path(), late, DAY * 365).unwrap();

    assert_eq!(keys(), before);
    for enclave in &made {
        assert_eq!(texts(&enclave.folder, 7, late + DAY * 364), [""; 0], "{}", enclave.enclave);
    }
    let (public, certificate) = (folder.path().join("public"), made[0].folder.join("cert.pem"));
    let authority = public.join("identity_ca.cert.pem");
    assert!(authority.is_symlink() && !public.join("ca.cert.pem").is_symlink());
    let at = late.as_secs().to_string();
    let authority = authority.to_str().unwrap();
    let (is_chain, text) =
        openssl(&["verify", "-attime", &at, "-CAfile", authority, certificate.to_str().unwrap()]);
    assert!(is_chain, "{text}");
}

#[test]
fn of_who_was_revoked_nothing_is_obeyed_and_the_others_have_the_rights_that_they_had() {
    let folder = tempfile::tempdir().unwrap();
    let (keystore, robots) = (folder.path().join("keystore"), robots());
    let made = create(&request(&keystore, &robots)).unwrap().enclaves;
    let rules = |path: &Path| {
        let text = std::fs::read_to_string(path.join("permissions.xml")).unwrap();
        text.lines().filter(|line| line.contains("<topic>")).map(str::to_owned).collect::<Vec<_>>()
    };
    let before: Vec<_> = made.iter().map(|enclave| rules(&enclave.folder)).collect();
    let stolen = std::fs::read_to_string(made[0].folder.join("cert.pem")).unwrap();
    std::fs::write(folder.path().join("stolen.pem"), stolen).unwrap();

    let nobody = revoke(&keystore, "robot_9", NOW, DAY * 30).unwrap_err();
    // As a shell completes it.
    let typed = PathBuf::from(format!("{}/", keystore.display()));
    let old = revoke(&typed, "robot_1", NOW, DAY * 30).unwrap().old;

    let meant = "the keystore has no enclave /robot_9; did you mean /robot_1?";
    assert_eq!(nobody.to_string(), meant);
    assert!(old.join("enclaves/robot_1").exists() && !made[0].folder.exists());
    for (enclave, before) in made.iter().zip(&before).skip(1) {
        assert_eq!(texts(&enclave.folder, 7, NOW), [""; 0], "{}", enclave.enclave);
        assert_eq!(rules(&enclave.folder), *before, "{}", enclave.enclave);
    }
    let authority = keystore.join("public/identity_ca.cert.pem");
    let (at, stolen) = (NOW.as_secs().to_string(), folder.path().join("stolen.pem"));
    let chain = ["verify", "-attime", &at, "-CAfile", authority.to_str().unwrap()];
    let (is_chain, text) = openssl(&[&chain[..], &[stolen.to_str().unwrap()]].concat());
    assert!(!is_chain, "{text}");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 3, "nothing else was left");

    // A second theft, by a link to the keystore.
    let link = folder.path().join("link");
    std::os::unix::fs::symlink(&keystore, &link).unwrap();
    let again = revoke(&link, "robot_2", NOW, DAY * 30).unwrap().old;
    assert!(again.ends_with("keystore.old_2") && link.is_symlink(), "{}", again.display());
    assert!(!keystore.join("enclaves/robot_2").exists());
}

#[test]
fn who_was_revoked_comes_back_by_name_only_and_with_other_keys() {
    let folder = tempfile::tempdir().unwrap();
    let (keystore, robots) = (folder.path().join("keystore"), robots());
    let made = create(&request(&keystore, &robots)).unwrap();
    assert_eq!(made.left_out, [""; 0]);
    let key = |keystore: &Path| std::fs::read(keystore.join("enclaves/robot_1/key.pem")).unwrap();
    let old = revoke(&keystore, "robot_1", NOW, DAY * 30).unwrap().old;
    revoke(&keystore, "stop", NOW, DAY * 30).unwrap();
    let again = revoke(&keystore, "robot_1", NOW, DAY * 30).unwrap_err();
    assert_eq!(again.to_string(), "/robot_1 was revoked already");
    let slip = revoke(&keystore, "contrlers", NOW, DAY * 30).unwrap_err();
    assert!(slip.to_string().ends_with("; did you mean /controllers?"), "{slip}");

    // With the fleet file of before the theft.
    let again = create(&request(&keystore, &robots)).unwrap();
    let readmit = |name: &str, domain_id| {
        let readmitted = &[name.to_owned()];
        create(&KeystoreRequest { domain_id, readmitted, ..request(&keystore, &robots) })
    };
    let nobody = readmit("robot_2", None).unwrap_err();
    let elsewhere = readmit("robot_1", Some(9)).unwrap_err();
    let still = show(&keystore, NOW).unwrap().revoked;
    let back = readmit("robot_1", None).unwrap();

    assert_eq!(again.left_out, ["/robot_1", "/stop"]);
    assert!(!again.enclaves.iter().any(|made| again.left_out.contains(&made.enclave)));
    assert_eq!(nobody.to_string(), "/robot_2 was not revoked");
    assert!(matches!(elsewhere, KeystoreError::OtherDomain { asked: 9, .. }), "{elsewhere}");
    assert_eq!(still, again.left_out, "a command that fails lets nobody in");
    assert_eq!(back.left_out, ["/stop"]);
    assert!(back.enclaves[0].is_new && key(&keystore) != key(&old));
    assert_eq!(show(&keystore, NOW).unwrap().revoked, ["/stop"]);
}

#[test]
fn keys_behind_links_and_in_copies_of_other_names_are_shown_and_made_private_too() {
    let ((folder, _), elsewhere) = (created(), tempfile::tempdir().unwrap());
    let key = folder.path().join("enclaves/robot_1/key.pem");
    let text = std::fs::read_to_string(&key).unwrap();
    let backup = folder.path().join("private/ca.key.pem.bak");
    let other_name = folder.path().join("public/saved.txt");
    let linked = elsewhere.path().join("robot_1.pem");
    for copy in [&backup, &other_name, &linked] {
        std::fs::write(copy, &text).unwrap();
        std::fs::set_permissions(copy, std::fs::Permissions::from_mode(0o644)).unwrap();
    }
    let authority = folder.path().join("private/ca.key.pem");
    assert!(show(folder.path(), NOW).unwrap().open_keys.iter().all(|key| *key != authority));
    std::fs::set_permissions(&authority, std::fs::Permissions::from_mode(0o640)).unwrap();
    std::fs::remove_file(&key).unwrap();
    std::os::unix::fs::symlink(&linked, &key).unwrap();
    // Leads back, and nowhere.
    std::os::unix::fs::symlink("..", folder.path().join("public/up")).unwrap();
    std::os::unix::fs::symlink("none", folder.path().join("public/none.key.pem")).unwrap();

    let open = show(folder.path(), NOW).unwrap().open_keys;
    let hardened = harden(folder.path()).unwrap();

    assert_eq!(open, [key, authority, backup, other_name]);
    assert_eq!(hardened.keys_made_private, open);
    assert!(show(folder.path(), NOW).unwrap().open_keys.is_empty());
}

#[test]
fn an_enclave_that_is_a_link_is_refused_by_name_and_lost_by_nobody() {
    let ((folder, _), elsewhere) = (created(), tempfile::tempdir().unwrap());
    let stop = folder.path().join("enclaves/stop");
    std::fs::rename(&stop, elsewhere.path().join("stop")).unwrap();
    std::os::unix::fs::symlink(elsewhere.path().join("stop"), &stop).unwrap();

    let shown = show(folder.path(), NOW).unwrap_err();
    let revoked = revoke(folder.path(), "robot_1", NOW, DAY).unwrap_err();

    for error in [shown, revoked] {
        let expected = format!("{} is a link", stop.display());
        assert!(error.to_string().starts_with(&expected), "{error}");
        let help = error.of(folder.path()).help();
        assert!(help.is_some_and(|help| help.contains("remove the link")));
    }
}

#[test]
fn a_key_or_an_authority_of_somebody_else_is_no_enclave() {
    let (folder, other) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let robots = robots();
    let made = create(&request(folder.path(), &robots)).unwrap().enclaves;
    create(&request(other.path(), &robots)).unwrap();
    let enclave =
        |name: &str| made.iter().find(|made| made.enclave == name).unwrap().folder.clone();
    std::fs::copy(enclave("/stop").join(KEY), enclave("/robot_1").join(KEY)).unwrap();
    let authority = enclave("/robot_2").join("identity_ca.cert.pem");
    std::fs::remove_file(&authority).unwrap();
    std::fs::copy(other.path().join("public/identity_ca.cert.pem"), authority).unwrap();

    let of_key = texts(&enclave("/robot_1"), 7, NOW);
    let of_authority = texts(&enclave("/robot_2"), 7, NOW);

    assert_eq!(of_key, ["cert.pem: it does not belong to key.pem"]);
    assert_eq!(of_authority, ["cert.pem: identity_ca.cert.pem has not signed it"]);
}

#[test]
fn a_renewal_that_fails_changes_nothing() {
    let (folder, _) = created();
    let before = show(folder.path(), NOW).unwrap();
    std::fs::write(folder.path().join("enclaves/viewer/key.pem"), "no key").unwrap();

    let error = renew(folder.path(), NOW, DAY * 365).unwrap_err();

    assert_eq!(error.to_string(), "/viewer: key.pem: it is no private key");
    let help = error.of(folder.path()).help().unwrap();
    assert!(help.starts_with("`rm ") && help.contains("/viewer/key.pem && rsrs"), "{help}");
    let after = show(folder.path(), NOW).unwrap();
    let is_other = |member: &&ShownMember| member.enclave != "/viewer";
    assert!(after.members.iter().filter(is_other).eq(before.members.iter().filter(is_other)));
}

#[test]
fn a_file_that_is_no_file_of_a_keystore_by_its_size_is_not_read() {
    let folder = tempfile::tempdir().unwrap();
    let robots = robots();
    let made = create(&request(folder.path(), &robots)).unwrap().enclaves;
    let governance = folder.path().join("enclaves/governance.p7s");
    std::fs::File::create(&governance).unwrap().set_len(1 << 40).unwrap();

    let found = texts(&made[0].folder, 7, NOW);

    assert!(found[0].ends_with("governance.p7s cannot be read: file too large"), "{found:?}");
    assert!(matches!(show(folder.path(), NOW), Err(KeystoreError::File { .. })));
}

#[test]
fn a_keystore_without_governance_gets_one_for_a_domain_that_somebody_names() {
    let (folder, robots) = created();
    std::fs::remove_file(folder.path().join("enclaves/governance.p7s")).unwrap();

    let shown = show(folder.path(), NOW).unwrap_err();
    let unnamed = create(&KeystoreRequest { domain_id: None, ..request(folder.path(), &robots) })
        .unwrap_err();
    let made = create(&request(folder.path(), &robots)).unwrap();

    for error in [shown, unnamed] {
        assert!(error.to_string().ends_with("enclaves/governance.p7s is missing"), "{error}");
        let help = error.of(Path::new("my keys")).help().unwrap();
        let typed = "`rsrs keystore create 'my keys' --fleet FLEET.yaml --domain ID`";
        assert!(help.starts_with(typed), "{help}");
    }
    assert_eq!(texts(&made.enclaves[0].folder, 7, NOW), [""; 0]);
}

#[test]
fn what_somebody_has_changed_is_not_signed_again() {
    let (folder, robots) = created();
    let path = folder.path().join("enclaves/governance.p7s");
    let signed = std::fs::read_to_string(&path).unwrap();
    let weaker = signed.replace("<data_protection_kind>NONE", "<data_protection_kind>SIGN");
    std::fs::write(&path, weaker).unwrap();

    let changed = harden(folder.path()).unwrap_err();
    assert!(matches!(renew(folder.path(), NOW, DAY), Err(KeystoreError::Forged { .. })));
    let other = tempfile::tempdir().unwrap();
    create(&request(other.path(), &robots)).unwrap();
    std::fs::copy(other.path().join("enclaves/governance.p7s"), &path).unwrap();
    let of_another = harden(folder.path()).unwrap_err();

    let cause = |error: &KeystoreError| error.source().unwrap().to_string();
    assert_eq!(cause(&changed), "its text is not the one that was signed");
    assert_eq!(cause(&of_another), "it was not signed with the key of this keystore's authority");
    std::fs::write(&path, &signed).unwrap();
    assert_eq!(harden(folder.path()).unwrap().cured, [""; 0]);
}

#[test]
fn a_document_that_openssl_has_signed_is_known() {
    let (folder, _) = created();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    // As `ros2 security` signs, and with the text packed into the signature.
    let sign = |into: &str, how: &[&str]| {
        let text = path("enclaves/governance.xml");
        let certificate = path("public/permissions_ca.cert.pem");
        let key = path("private/permissions_ca.key.pem");
        let certificate = ["-signer", &certificate, "-inkey", &key];
        let files = ["-md", "sha256", "-in", &text, "-out", &path(into)];
        let (is_signed, printed) =
            openssl(&[&["smime", "-sign", "-text"], &files[..], &certificate[..], how].concat());
        assert!(is_signed, "{printed}");
    };
    sign("packed", &["-nodetach"]);
    sign("enclaves/governance.p7s", &[]);

    assert_eq!(harden(folder.path()).unwrap().cured, [""; 0]);
    std::fs::copy(path("packed"), path("enclaves/governance.p7s")).unwrap();
    let opaque = harden(folder.path()).unwrap_err();
    assert!(matches!(opaque, KeystoreError::NotSigned { .. }), "{opaque}");
}

#[test]
fn a_rule_that_another_one_goes_before_in_some_domains_is_hardened_too() {
    let (folder, _) = created();
    let authority = Authority::read(folder.path()).unwrap();
    let strong = Governance::recommended(Domains { first: 0, last: 10 }).rules.remove(0);
    let mut weak = Governance::recommended(Domains { first: 5, last: 20 }).rules.remove(0);
    weak.unauthenticated_participants = Switch::On;
    let both = Governance { rules: vec![strong, weak] };
    authority.write_governance(folder.path(), &both).unwrap();

    let hardened = harden(folder.path()).unwrap();

    assert_eq!(hardened.cured, ["lets participants without a certificate take part"]);
    let governance = authority.governance(folder.path()).unwrap();
    assert_eq!(governance.weaknesses(15), []);
}

/// As Fast DDS and Cyclone verify: with the certificate of the authority alone, and not with those that a
/// document brings.
fn is_verified_by_others(document: &Path, authority: &Path) -> (bool, String) {
    let [document, authority] = [document, authority].map(|path| path.to_str().unwrap());
    let how = ["-noverify", "-nointern", "-certfile", authority, "-out", "/dev/null"];
    openssl(&[&["smime", "-verify", "-text", "-in", document], &how[..]].concat())
}

#[test]
fn what_was_copied_before_a_renewal_and_what_is_copied_after_it_is_verified_by_other_middlewares() {
    let folder = tempfile::tempdir().unwrap();
    let (keystore, before) = (folder.path().join("keystore"), folder.path().join("before"));
    let robots = robots();
    create(&request(&keystore, &robots)).unwrap();
    copy_of(&keystore, &before);

    let ends = renew(&keystore, NOW + DAY * 10, DAY * 60).unwrap();

    assert_eq!(ends, NOW + DAY * 70);
    let authority = |keystore: &Path| keystore.join("public/permissions_ca.cert.pem");
    let texts = [&before, &keystore].map(|it| std::fs::read(authority(it)).unwrap());
    assert_ne!(texts[0], texts[1]);
    for from in [&before, &keystore] {
        for by in [&before, &keystore] {
            for file in ["governance.p7s", "robot_1/permissions.p7s"] {
                let document = from.join("enclaves").join(file);
                let (is_verified, text) = is_verified_by_others(&document, &authority(by));
                assert!(is_verified, "{} by {}: {text}", document.display(), by.display());
            }
            let (at, chain) = ((NOW + DAY * 11).as_secs().to_string(), authority(by));
            let certificate = from.join("enclaves/robot_1/cert.pem");
            let [chain, certificate] = [&chain, &certificate].map(|path| path.to_str().unwrap());
            let (is_chain, text) =
                openssl(&["verify", "-attime", &at, "-CAfile", chain, certificate]);
            assert!(is_chain, "{text}");
        }
    }
}

#[test]
fn what_is_wrong_with_a_member_is_shown_and_completing_the_keystore_mends_it() {
    let ((folder, robots), (other, _)) = (created(), created());
    let keystore = folder.path();
    let enclave = |name: &str| keystore.join("enclaves").join(name);
    let of_other = other.path().join("enclaves");
    let copy = |from: PathBuf, to: PathBuf| assert!(std::fs::copy(from, to).unwrap() > 0);
    let remove = |path: PathBuf| std::fs::remove_file(path).unwrap();
    let change = |path: PathBuf| {
        let text = std::fs::read_to_string(&path).unwrap().replace("rt/clock", "rt/cloak");
        std::fs::write(path, text).unwrap();
    };
    remove(enclave("robot_1/permissions.p7s"));
    change(enclave("robot_2/permissions.p7s"));
    copy(enclave("stop/permissions.p7s"), enclave("runner/permissions.p7s"));
    remove(enclave("stop/cert.pem"));
    copy(of_other.join("viewer/cert.pem"), enclave("viewer/cert.pem"));
    copy(enclave("viewer/key.pem"), enclave("tracker/key.pem"));
    remove(enclave("simulator/key.pem"));
    remove(enclave("controllers/governance.p7s"));

    let found = shown(keystore);
    let renewed = renew(keystore, NOW, DAY * 30).unwrap_err();
    let revoked = revoke(keystore, "runner", NOW, DAY * 30).unwrap_err();
    let made = create(&request(keystore, &robots)).unwrap();

    assert_eq!(
        found,
        [
            "/controllers: k/enclaves/controllers/governance.p7s is missing",
            "/robot_1: k/enclaves/robot_1/permissions.p7s is missing",
            "/robot_2: permissions.p7s: it is not what permissions_ca.cert.pem has signed: its text \
             is not the one that was signed",
            "/runner: permissions.p7s has no grant for `CN=/runner`, so it is of another member",
            "/simulator: k/enclaves/simulator/key.pem is missing",
            "/stop: k/enclaves/stop/cert.pem is missing",
            "/tracker: cert.pem: it does not belong to key.pem",
            "/viewer: cert.pem: it does not belong to key.pem; cert.pem: identity_ca.cert.pem has not \
             signed it",
        ]
    );
    for error in [renewed, revoked] {
        let text = error.to_string();
        assert!(text.starts_with("/robot_1: ") && text.contains("; /robot_2: "), "{text}");
        let help = error.of(keystore).help().unwrap();
        assert!(
            help.starts_with("`rsrs keystore create") && help.ends_with("command again"),
            "{help}"
        );
    }
    let has = |which: fn(&MadeEnclave) -> bool| -> Vec<String> {
        made.enclaves.iter().filter(|it| which(it)).map(|it| it.enclave.clone()).collect()
    };
    assert_eq!(has(|made| made.is_new), ["/simulator"]);
    assert_eq!(has(|made| made.is_certified), ["/simulator", "/stop", "/tracker", "/viewer"]);
    assert_eq!((made.problems, shown(keystore)), (vec![], vec![]));
}

#[test]
fn an_authority_whose_certificate_is_of_another_key_signs_nothing() {
    let ((folder, robots), (other, _)) = (created(), created());
    let certificate = folder.path().join("public/ca.cert.pem");
    std::fs::copy(other.path().join("public/ca.cert.pem"), &certificate).unwrap();

    let error = create(&request(folder.path(), &robots)).unwrap_err();

    assert!(error.to_string().contains("it is of another key"), "{error}");
    let help = error.of(folder.path()).help().unwrap();
    assert!(help.contains("every enclave that was copied has it"), "{help}");
}

#[test]
fn a_key_that_is_none_is_named_with_what_makes_another_and_never_written_over() {
    let (folder, robots) = created();
    let key = folder.path().join("enclaves/robot_1/key.pem");
    let cut = std::fs::read_to_string(&key).unwrap()[..100].to_owned();
    std::fs::write(&key, &cut).unwrap();

    let found = show(folder.path(), NOW).unwrap().members.swap_remove(1);
    let made = create(&request(folder.path(), &robots)).unwrap();

    assert_eq!(made.problems, [("/robot_1".to_owned(), found.problems[0].clone())]);
    let typed = cures(folder.path(), None, &found.problems);
    let expected =
        format!("rm {} && rsrs keystore create {}", key.display(), folder.path().display());
    assert!(typed[0].starts_with(&expected), "{typed:?}");
    assert_eq!(std::fs::read_to_string(&key).unwrap(), cut);
}

#[test]
fn what_a_governance_leaves_open_and_the_time_that_has_not_come_are_shown() {
    let folder = tempfile::tempdir().unwrap();
    let robots = robots();
    let now = NOW + DAY * 30;
    create(&KeystoreRequest { now, ..request(folder.path(), &robots) }).unwrap();
    let authority = Authority::read(folder.path()).unwrap();
    let mut governance = Governance::recommended(Domains { first: 7, last: 7 });
    governance.rules[0].join_access_control = Switch::Off;
    authority.write_governance(folder.path(), &governance).unwrap();

    let open = show(folder.path(), now).unwrap();
    let early = show(folder.path(), NOW).unwrap().members;

    assert_eq!(open.weaknesses, [Weakness::JoiningTakesNoPermission]);
    assert!(open.members.iter().all(|member| member.problems.is_empty()), "said once");
    let is_early = |member: &ShownMember| {
        member.problems.iter().all(|it| matches!(it, EnclaveProblem::NotYet { .. }))
            && member.problems.len() == 4
    };
    assert!(early.iter().all(is_early), "{early:?}");
}

#[test]
fn several_that_complete_a_keystore_at_once_leave_whole_enclaves() {
    let folder = tempfile::tempdir().unwrap();
    let keystore = folder.path().join("keystore");
    let robots: Vec<String> = (1..=6).map(|number| format!("robot_{number}")).collect();

    let made = std::thread::scope(|scope| {
        let starts: Vec<_> = (0..3)
            .map(|_| scope.spawn(|| create(&request(&keystore, &robots)).unwrap().enclaves))
            .collect();
        starts.into_iter().flat_map(|start| start.join().unwrap()).collect::<Vec<_>>()
    });

    assert_eq!(made.iter().filter(|made| made.is_new).count(), robots.len() + 6);
    assert_eq!(shown(&keystore), [""; 0]);
}

#[test]
fn a_keystore_that_was_copied_without_its_links_is_changed_as_a_whole() {
    let folder = tempfile::tempdir().unwrap();
    let (first, keystore) = (folder.path().join("first"), folder.path().join("copy"));
    let robots = robots();
    create(&request(&first, &robots)).unwrap();
    let authority = Authority::read(&first).unwrap();
    let mut governance = Governance::recommended(Domains { first: 7, last: 7 });
    governance.rules[0].join_access_control = Switch::Off;
    authority.write_governance(&first, &governance).unwrap();
    let renewed = folder.path().join("renewed");
    copy_of(&first, &keystore);
    copy_of(&first, &renewed);

    let hardened = harden(&keystore).unwrap();
    renew(&renewed, NOW + DAY, DAY * 60).unwrap();

    assert_eq!(hardened.linked.len(), 8 * 3, "{hardened:?}");
    for name in ["robot_1", "stop"] {
        assert_eq!(texts(&keystore.join("enclaves").join(name), 7, NOW), [""; 0]);
        let after = texts(&renewed.join("enclaves").join(name), 7, NOW + DAY * 60);
        assert_eq!(after.len(), 1, "{after:?}");
        assert!(after[0].contains("enable_join_access_control is false"), "{after:?}");
    }
    let public = renewed.join("public");
    let texts = ["ca.cert.pem", "identity_ca.cert.pem", "permissions_ca.cert.pem"]
        .map(|file| std::fs::read_to_string(public.join(file)).unwrap());
    assert!(texts[0] == texts[1] && texts[1] == texts[2]);
}

#[test]
fn a_new_keystore_that_was_interrupted_is_made_from_the_start() {
    let (folder, robots) = created();
    // As where it was killed before its governance was there.
    std::fs::write(folder.path().join(".unfinished"), "").unwrap();
    std::fs::remove_file(folder.path().join("enclaves/governance.p7s")).unwrap();
    let key = || std::fs::read(folder.path().join("private/ca.key.pem")).unwrap();
    let before = key();

    let help = show(folder.path(), NOW).unwrap_err().of(folder.path()).help().unwrap();
    let made = create(&KeystoreRequest { domain_id: None, ..request(folder.path(), &robots) });

    assert!(help.ends_with("type it again"), "{help}");
    assert_eq!((made.unwrap().domain_id, shown(folder.path())), (0, vec![]));
    assert!(key() != before && !folder.path().join(".unfinished").exists());
}

#[test]
fn who_is_readmitted_is_of_the_fleet_and_who_is_not_of_it_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let (keystore, robots) = (folder.path().join("keystore"), robots());
    create(&request(&keystore, &robots)).unwrap();
    revoke(&keystore, "/robot_1/", NOW, DAY * 30).unwrap();
    let one = ["robot_3".to_owned()];
    let asked = |robots: &[String], names: &[&str]| {
        let readmitted: Vec<String> = names.iter().map(|&name| name.to_owned()).collect();
        create(&KeystoreRequest { readmitted: &readmitted, ..request(&keystore, robots) })
    };

    let elsewhere = asked(&one, &["robot_1"]).unwrap_err();
    let slip = asked(&robots, &["robt_1"]).unwrap_err();
    let still = show(&keystore, NOW).unwrap().revoked;
    let others = asked(&one, &[]).unwrap().others;
    asked(&robots, &["robot_1", "/robot_1"]).unwrap();

    let expected = "/robot_1 cannot be readmitted: it is not in the fleet file";
    assert_eq!(elsewhere.to_string(), expected);
    assert_eq!(slip.to_string(), "/robt_1 was not revoked; did you mean /robot_1?");
    assert_eq!(still, ["/robot_1"]);
    assert_eq!(others, ["/robot_2"]);
    assert_eq!(show(&keystore, NOW).unwrap().revoked, [""; 0]);
    for nothing in ["", "/"] {
        let error = revoke(&keystore, nothing, NOW, DAY).unwrap_err();
        assert_eq!(error.to_string(), "the keystore has no enclave /");
    }
}

#[test]
fn what_is_private_stays_on_its_disk_and_is_missed_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let (keystore, disk) = (folder.path().join("keystore"), folder.path().join("disk"));
    let robots = robots();
    create(&request(&keystore, &robots)).unwrap();
    std::fs::create_dir(&disk).unwrap();
    std::fs::rename(keystore.join("private"), disk.join("private")).unwrap();
    std::os::unix::fs::symlink(disk.join("private"), keystore.join("private")).unwrap();

    let revoked = revoke(&keystore, "robot_1", NOW, DAY * 30).unwrap();

    let private = revoked.private.unwrap();
    assert_eq!(keystore.join("private").canonicalize().unwrap(), private);
    assert!(private.starts_with(&disk) && private.join("ca.key.pem").exists());
    assert!(Authority::is_in(&revoked.old).unwrap(), "the old one has its own");
    assert_eq!(shown(&keystore), [""; 0]);
    std::fs::rename(&disk, folder.path().join("away")).unwrap();
    let away = show(&keystore, NOW).unwrap_err().to_string();
    assert!(away.ends_with("which is not there"), "{away}");
}

#[test]
fn a_folder_that_an_interrupted_revocation_left_is_shown() {
    let folder = tempfile::tempdir().unwrap();
    let keystore = folder.path().join("keystore");
    create(&request(&keystore, &robots())).unwrap();
    let left = files::folder_beside(&keystore).unwrap().keep();

    assert_eq!(show(&keystore, NOW).unwrap().leftovers, [left]);
}

#[test]
fn an_enclave_that_is_a_link_is_not_written_through() {
    let ((folder, mut robots), elsewhere) = (created(), tempfile::tempdir().unwrap());
    std::os::unix::fs::symlink(elsewhere.path(), folder.path().join("enclaves/robot_3")).unwrap();
    robots.push("robot_3".to_owned());

    let error = create(&request(folder.path(), &robots)).unwrap_err();

    assert!(matches!(error, KeystoreError::LinkedFolder { .. }), "{error}");
    assert_eq!(std::fs::read_dir(elsewhere.path()).unwrap().count(), 0);
    elsewhere.close().unwrap();
    let to_nothing = show(folder.path(), NOW).unwrap_err();
    assert!(matches!(to_nothing, KeystoreError::LinkedFolder { .. }), "{to_nothing}");
}
