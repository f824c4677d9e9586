//! Fuzzing of the signed documents and certificates of an enclave.

use std::fs;
use std::time::Duration;

use rand::RngExt;
use rsrs_testing::fuzz::{self, Harness};

use crate::authority::Authority;
use crate::check::problems_of;
use crate::create::{KeystoreRequest, create};
use crate::layout::{CERTIFICATE, GOVERNANCE, PERMISSIONS};
use crate::signed_document::signed_text;

#[test]
fn fuzzed_documents_are_read_or_refused_and_verified_only_if_they_were_signed() {
    let folder = tempfile::tempdir().unwrap();
    let now = Duration::from_secs(1_767_268_800);
    let robots = ["robot_1".to_owned()];
    let request = KeystoreRequest {
        folder: folder.path(),
        robots: &robots,
        domain_id: Some(7),
        now,
        validity: None,
        readmitted: &[],
    };
    let enclave = create(&request).unwrap().enclaves.remove(0).folder;
    let authority = Authority::read(folder.path()).unwrap();
    let files = [GOVERNANCE, PERMISSIONS, CERTIFICATE].map(|file| {
        let path = enclave.join(file);
        let content = fs::read_to_string(&path).unwrap();
        (path, content)
    });
    let harness = Harness {
        corpus: concat!(env!("CARGO_MANIFEST_DIR"), "/tests/corpus/documents"),
        // The place of the file, and what it contains.
        seeds: (0..)
            .zip(&files)
            .map(|(at, (_, content))| [&[at], content.as_bytes()].concat())
            .collect(),
        mutation: &fuzz::behind(1, |input, other, draw| match draw.random_range(0..3) {
            0 => fuzz::base64(input, other, draw),
            _ => fuzz::text(input, other, draw),
        }),
    };

    let n_outcomes = harness.run(|input| {
        let (path, content) = &files[usize::from(input[0]) % files.len()];
        fs::write(path, &input[1..]).unwrap();
        let problems = problems_of("/robot_1", &enclave, 7, now);
        let verified = authority.signed_text(path).map(|text| {
            assert_eq!(signed_text(content), Ok(&*text), "this was never signed");
        });
        fs::write(path, content).unwrap();
        format!("{verified:?} {problems:?}")
    });

    assert!(n_outcomes > 5, "{n_outcomes} outcomes");
}
