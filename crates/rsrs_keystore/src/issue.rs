//! Certificates as SROS2 issues them: a name, a key on prime256v1, and whether it may issue others.

use std::str::FromStr;
use std::time::{Duration, UNIX_EPOCH};

use p256::ecdsa::{DerSignature, SigningKey};
use p256::elliptic_curve::Generate;
use p256::elliptic_curve::zeroize::Zeroizing;
use p256::pkcs8::EncodePrivateKey;
use x509_cert::Certificate;
use x509_cert::builder::profile::BuilderProfile;
use x509_cert::builder::{Builder, CertificateBuilder};
use x509_cert::certificate::TbsCertificate;
use x509_cert::der::EncodePem;
use x509_cert::der::pem::LineEnding;
use x509_cert::ext::pkix::BasicConstraints;
use x509_cert::ext::{Extension, ToExtension};
use x509_cert::name::Name;
use x509_cert::serial_number::SerialNumber;
use x509_cert::spki::{SubjectPublicKeyInfo, SubjectPublicKeyInfoRef};
use x509_cert::time::{Time, Validity};

use crate::error::KeystoreError;

/// Bytes of a serial number; the first bit stays zero.
const SERIAL_BYTES: usize = 16;

/// How clocks may differ: certificates hold from so long ago.
const CLOCKS_DIFFER: Duration = Duration::from_secs(24 * 3600);

/// From when certificates hold that are made now.
pub(crate) fn from(now: Duration) -> Duration {
    now.saturating_sub(CLOCKS_DIFFER)
}

/// Who signs a certificate.
pub(crate) struct Issuer<'a> {
    pub(crate) name: Name,
    pub(crate) key: &'a SigningKey,
}

/// A certificate with its new key.
pub(crate) struct Made {
    pub(crate) certificate: Certificate,
    /// Gone from memory when it is dropped.
    pub(crate) key_pem: Zeroizing<String>,
}

/// Somebody who needs a certificate.
pub(crate) struct NewMember {
    name: Name,
    holds: (Duration, Duration),
    key: SigningKey,
    /// One is drawn where there is none.
    serial: Option<SerialNumber>,
}

impl NewMember {
    /// An enclave, such as `/robot_3`, with a new key; its certificate is to hold from one time to
    /// another, both since 1970.
    pub(crate) fn new(name: &str, holds: (Duration, Duration)) -> Result<Self, KeystoreError> {
        Self::with_key(name, holds, SigningKey::generate())
    }

    /// As [`NewMember::new`], with a key that it has already.
    pub(crate) fn with_key(
        name: &str,
        holds: (Duration, Duration),
        key: SigningKey,
    ) -> Result<Self, KeystoreError> {
        let name =
            Name::from_str(&format!("CN={name}")).map_err(cannot("the name of a certificate"))?;
        Ok(Self { name, holds, key, serial: None })
    }

    /// Who has a certificate: with its whole name and its serial number, by which documents name whose
    /// signature they have.
    pub(crate) fn of_certificate(
        certificate: &Certificate,
        holds: (Duration, Duration),
        key: SigningKey,
    ) -> Self {
        let certificate = certificate.tbs_certificate();
        let serial = Some(certificate.serial_number().clone());
        Self { name: certificate.subject().clone(), holds, key, serial }
    }

    /// An authority.
    pub(crate) fn self_signed(self) -> Result<Made, KeystoreError> {
        let constraints = BasicConstraints { ca: true, path_len_constraint: Some(1) };
        let issuer = Issuer { name: self.name.clone(), key: &self.key };
        self.made(constraints, &issuer)
    }

    /// One who issues nothing.
    pub(crate) fn signed_by(self, issuer: &Issuer<'_>) -> Result<Made, KeystoreError> {
        self.made(BasicConstraints { ca: false, path_len_constraint: None }, issuer)
    }

    fn made(
        &self,
        constraints: BasicConstraints,
        issuer: &Issuer<'_>,
    ) -> Result<Made, KeystoreError> {
        let profile =
            Profile { subject: self.name.clone(), issuer: issuer.name.clone(), constraints };
        let public_key = SubjectPublicKeyInfo::from_key(self.key.verifying_key())
            .map_err(cannot("a public key"))?;
        let serial = self.serial.clone().map_or_else(serial, Ok)?;
        let builder = CertificateBuilder::new(profile, serial, validity(self.holds)?, public_key)
            .map_err(cannot("a certificate"))?;
        let certificate = builder.build::<_, DerSignature>(issuer.key);
        let key_pem = self.key.to_pkcs8_pem(LineEnding::LF);
        Ok(Made {
            certificate: certificate.map_err(cannot("a certificate"))?,
            key_pem: key_pem.map_err(cannot("a key"))?,
        })
    }
}

fn serial() -> Result<SerialNumber, KeystoreError> {
    let mut bytes = <[u8; SERIAL_BYTES]>::generate();
    bytes[0] &= 0x7f;
    // Not zero, and as long whatever was drawn.
    bytes[0] |= 0x40;
    SerialNumber::new(&bytes).map_err(cannot("a serial number"))
}

fn validity((first, last): (Duration, Duration)) -> Result<Validity, KeystoreError> {
    let time = |since_1970: Duration| {
        let time = UNIX_EPOCH.checked_add(since_1970).and_then(|time| Time::try_from(time).ok());
        time.ok_or(KeystoreError::Validity { from_s: first.as_secs(), to_s: last.as_secs() })
    };
    Ok(Validity::new(time(first)?, time(last)?))
}

/// A certificate as a file has it.
pub(crate) fn to_pem(certificate: &Certificate) -> Result<String, KeystoreError> {
    certificate.to_pem(LineEnding::LF).map_err(cannot("a certificate"))
}

fn cannot<E: ToString>(what: &'static str) -> impl Fn(E) -> KeystoreError {
    KeystoreError::cryptography(what)
}

struct Profile {
    subject: Name,
    issuer: Name,
    constraints: BasicConstraints,
}

impl BuilderProfile for Profile {
    fn get_issuer(&self, _subject: &Name) -> Name {
        self.issuer.clone()
    }

    fn get_subject(&self) -> Name {
        self.subject.clone()
    }

    fn build_extensions(
        &self,
        _key: SubjectPublicKeyInfoRef<'_>,
        _issuer_key: SubjectPublicKeyInfoRef<'_>,
        _certificate: &TbsCertificate,
    ) -> x509_cert::builder::Result<Vec<Extension>> {
        Ok(vec![self.constraints.clone().to_extension(&self.subject, &[])?])
    }
}
