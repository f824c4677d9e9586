//! Who a certificate names, how long it holds, and whose it is.

use std::time::Duration;

use p256::ecdsa::signature::Verifier;
use p256::ecdsa::{DerSignature, SigningKey, VerifyingKey};
use p256::pkcs8::{DecodePrivateKey, DecodePublicKey, PrivateKeyInfoRef};
use x509_cert::Certificate;
use x509_cert::der::pem::decode_vec;
use x509_cert::der::{DecodePem, Encode};

use crate::signature::{self, ECDSA_WITH_SHA256, ForgedDocument};

/// What is asked of a certificate before the middleware gets it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CertificateFacts {
    /// Whom it names, such as `CN=/robot_3`.
    pub subject: String,
    /// Since 1970: when it begins to hold.
    pub not_before: Duration,
    /// Since 1970: when it ends.
    pub not_after: Duration,
}

/// A file that is no certificate.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("it is no X.509 certificate in PEM: {reason}")]
pub struct NoCertificate {
    /// What is wrong with it.
    pub reason: String,
}

/// Reads a certificate.
pub fn read(pem: &str) -> Result<CertificateFacts, NoCertificate> {
    let certificate =
        Certificate::from_pem(pem).map_err(|error| NoCertificate { reason: error.to_string() })?;
    Ok(facts_of(&certificate))
}

fn facts_of(certificate: &Certificate) -> CertificateFacts {
    let certificate = certificate.tbs_certificate();
    let validity = certificate.validity();
    CertificateFacts {
        subject: certificate.subject().to_string(),
        not_before: validity.not_before.to_unix_duration(),
        not_after: validity.not_after.to_unix_duration(),
    }
}

/// Whether a file is a private key at all, of whatever kind.
pub(crate) fn is_key(pem: &str) -> bool {
    let Ok((label, der)) = decode_vec(pem.as_bytes()) else { return false };
    label != "PRIVATE KEY" || PrivateKeyInfoRef::try_from(der.as_slice()).is_ok()
}

/// Whether a private key is that of a certificate; `None` of kinds of keys that SROS2 does not make.
pub(crate) fn has_key(certificate: &str, key: &str) -> Option<bool> {
    let key = SigningKey::from_pkcs8_pem(key).ok()?;
    Some(is_of(&Certificate::from_pem(certificate).ok()?, &key))
}

/// The same of what was read already.
pub(crate) fn is_of(certificate: &Certificate, key: &SigningKey) -> bool {
    public_key(certificate).is_some_and(|public| public == *key.verifying_key())
}

/// Whether an authority has signed a certificate; `None` of kinds of signatures that SROS2 does not make.
pub(crate) fn is_signed_by(certificate: &str, authority: &str) -> Option<bool> {
    let certificate = Certificate::from_pem(certificate).ok()?;
    let authority = Certificate::from_pem(authority).ok()?;
    if certificate.signature_algorithm().oid != ECDSA_WITH_SHA256 {
        return None;
    }
    let signature = DerSignature::try_from(certificate.signature().raw_bytes()).ok()?;
    let signed = certificate.tbs_certificate().to_der().ok()?;
    let key = public_key(&authority);
    Some(key.is_some_and(|key| key.verify(&signed, &signature).is_ok()))
}

/// Why a document is not what an authority has signed; `None` also of keys that SROS2 does not make.
pub(crate) fn forgery_of(document: &str, authority: &str) -> Option<ForgedDocument> {
    let key = public_key(&Certificate::from_pem(authority).ok()?)?;
    signature::verify(&key, document).err()
}

fn public_key(certificate: &Certificate) -> Option<VerifyingKey> {
    let info = certificate.tbs_certificate().subject_public_key_info().to_der().ok()?;
    VerifyingKey::from_public_key_der(&info).ok()
}
