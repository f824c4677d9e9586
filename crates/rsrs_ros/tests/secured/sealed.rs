//! Datagrams as a member protects them, made by whoever has its keys (DDS Security 1.1, 7.3.6 and 9.5.3.3).

use ring::aead::{AES_256_GCM, Aad, LessSafeKey, Nonce, UnboundKey};
use ring::hmac;

use crate::stolen_keys::StolenKey;

/// Submessages, by their numbers.
const INFO_SOURCE: u8 = 0x0c;
const BODY: u8 = 0x30;
const PREFIX: u8 = 0x31;
const POSTFIX: u8 = 0x32;
const RTPS_PREFIX: u8 = 0x33;
const RTPS_POSTFIX: u8 = 0x34;

/// Version of RTPS, and who made the middleware.
const VERSION_AND_VENDOR: [u8; 4] = [2, 3, 1, 18];

/// A submessage, encrypted as of the publisher whose key it is.
pub fn encrypted(submessage: &[u8], key: &StolenKey, number: u64) -> Vec<u8> {
    let (mut content, mac) = seal(key, number, &[], submessage.to_vec());
    let length = u32::try_from(content.len()).expect("short").to_be_bytes();
    content.splice(..0, length);
    [framed(PREFIX, &header(key, number)), framed(BODY, &content), framed(POSTFIX, &footer(mac))]
        .concat()
}

/// A datagram of these submessages, signed as of the participant whose key it is.
pub fn signed(participant: [u8; 12], submessages: &[u8], key: &StolenKey, number: u64) -> Vec<u8> {
    let source = framed(INFO_SOURCE, &[&[0; 4], &VERSION_AND_VENDOR[..], &participant].concat());
    let content = [source, submessages.to_vec()].concat();
    let (_, mac) = seal(key, number, &content, Vec::new());
    [
        b"RTPS".to_vec(),
        VERSION_AND_VENDOR.to_vec(),
        participant.to_vec(),
        framed(RTPS_PREFIX, &header(key, number)),
        content,
        framed(RTPS_POSTFIX, &footer(mac)),
    ]
    .concat()
}

/// The number takes part in the initialization vector, which is not to be used twice.
fn vector(number: u64) -> [u8; 12] {
    [b"thf!".to_vec(), number.to_be_bytes().to_vec()].concat().try_into().expect("12 bytes")
}

fn seal(key: &StolenKey, number: u64, plain: &[u8], mut secret: Vec<u8>) -> (Vec<u8>, [u8; 16]) {
    let vector = vector(number);
    let master = hmac::Key::new(hmac::HMAC_SHA256, &key.key);
    let text = [&b"SessionKey"[..], &key.salt, &vector[..4]].concat();
    let session_key = hmac::sign(&master, &text);
    let cipher = UnboundKey::new(&AES_256_GCM, session_key.as_ref()).expect("256 bits");
    let tag = LessSafeKey::new(cipher)
        .seal_in_place_separate_tag(
            Nonce::assume_unique_for_key(vector),
            Aad::from(plain),
            &mut secret,
        )
        .expect("short");
    (secret, tag.as_ref().try_into().expect("16 bytes"))
}

fn header(key: &StolenKey, number: u64) -> Vec<u8> {
    [&key.kind[..], &key.id, &vector(number)].concat()
}

/// With the signature for all, and none for each receiver: that takes a key that only it and the sender have.
fn footer(mac: [u8; 16]) -> Vec<u8> {
    [&mac[..], &[0; 4]].concat()
}

fn framed(kind: u8, content: &[u8]) -> Vec<u8> {
    let [high, low] = u16::try_from(content.len()).expect("short").to_be_bytes();
    [&[kind, 0, high, low], content].concat()
}
