//! The authority of a keystore: it issues certificates, and signs governance and permissions.

use std::path::Path;
use std::time::Duration;

use p256::ecdsa::SigningKey;
use p256::pkcs8::DecodePrivateKey;
use x509_cert::Certificate;
use x509_cert::der::DecodePem;

use crate::certificate;
use crate::error::KeystoreError;
use crate::files;
use crate::governance::Governance;
use crate::issue::{Issuer, NewMember, to_pem};
use crate::layout::{
    CERTIFICATE, ENCLAVES, GOVERNANCE, GOVERNANCE_TEXT, IDENTITY_CA, KEY, PERMISSIONS_CA, PRIVATE,
    PUBLIC, UNFINISHED,
};
use crate::signature::{self, Pair};
use crate::signed_document::signed_text;

/// The names of the authority's own files, to which the others are links.
const CA_CERTIFICATE: &str = "ca.cert.pem";
const CA_KEY: &str = "ca.key.pem";
/// The names of its keys in its two functions.
const IDENTITY_CA_KEY: &str = "identity_ca.key.pem";
const PERMISSIONS_CA_KEY: &str = "permissions_ca.key.pem";
/// What it is called.
const NAME: &str = "rsrsCA";

/// Who signs: a lab's own keystore may have one authority for identities and one for permissions.
pub(crate) struct Authority {
    identity: Pair,
    permissions: Pair,
}

impl Authority {
    /// Whether a folder has one.
    ///
    /// # Errors
    ///
    /// If that cannot be known: what is private is on a disk that is not there, or of another user.
    pub(crate) fn is_in(keystore: &Path) -> Result<bool, KeystoreError> {
        let private = keystore.join(PRIVATE);
        if let Ok(target) = private.read_link()
            && !private.exists()
        {
            return Err(KeystoreError::PrivateElsewhere { path: private, target });
        }
        let key = private.join(PERMISSIONS_CA_KEY);
        let is_there = key.try_exists().map_err(KeystoreError::file("read", &private))?;
        Ok(is_there && !keystore.join(UNFINISHED).exists())
    }

    pub(crate) fn create(
        keystore: &Path,
        holds: (Duration, Duration),
    ) -> Result<Self, KeystoreError> {
        let (public, private) = (keystore.join(PUBLIC), keystore.join(PRIVATE));
        files::make_folder(&public)?;
        files::make_private_folder(&private)?;
        let made = NewMember::new(NAME, holds)?.self_signed()?;
        files::write_key(&private.join(CA_KEY), &made.key_pem)?;
        files::write_public(&public.join(CA_CERTIFICATE), &to_pem(&made.certificate)?)?;
        for file in [IDENTITY_CA, PERMISSIONS_CA] {
            files::link(Path::new(CA_CERTIFICATE), &public.join(file))?;
        }
        for file in [IDENTITY_CA_KEY, PERMISSIONS_CA_KEY] {
            files::link(Path::new(CA_KEY), &private.join(file))?;
        }
        Self::read(keystore)
    }

    pub(crate) fn read(keystore: &Path) -> Result<Self, KeystoreError> {
        Ok(Self {
            identity: pair(keystore, IDENTITY_CA, IDENTITY_CA_KEY)?,
            permissions: pair(keystore, PERMISSIONS_CA, PERMISSIONS_CA_KEY)?,
        })
    }

    /// Makes key and certificate of an enclave.
    pub(crate) fn issue(
        &self,
        folder: &Path,
        enclave: &str,
        holds: (Duration, Duration),
    ) -> Result<(), KeystoreError> {
        let made = NewMember::new(enclave, holds)?.signed_by(&self.issuer())?;
        // The key last: an enclave that has one is complete.
        files::write_public(&folder.join(CERTIFICATE), &to_pem(&made.certificate)?)?;
        files::write_key(&folder.join(KEY), &made.key_pem)
    }

    /// Makes the certificate of an enclave anew, for a member with the key that it has.
    pub(crate) fn certify(&self, folder: &Path, member: NewMember) -> Result<(), KeystoreError> {
        let made = member.signed_by(&self.issuer())?;
        files::write_public(&folder.join(CERTIFICATE), &to_pem(&made.certificate)?)
    }

    fn issuer(&self) -> Issuer<'_> {
        let Pair { certificate, key } = &self.identity;
        Issuer { name: certificate.tbs_certificate().subject().clone(), key }
    }

    /// Makes the authority's own certificates anew, for the keys that it has.
    pub(crate) fn renewed(
        self,
        keystore: &Path,
        holds: (Duration, Duration),
    ) -> Result<Self, KeystoreError> {
        let public = keystore.join(PUBLIC);
        let one = files::text(&public.join(CA_CERTIFICATE)).ok();
        for (pair, file) in [(self.identity, IDENTITY_CA), (self.permissions, PERMISSIONS_CA)] {
            let path = public.join(file);
            // Copies of the one file were links, and are links again.
            if one.is_some() && files::text(&path).ok() == one {
                files::link(Path::new(CA_CERTIFICATE), &path)?;
            }
            let made = NewMember::of_certificate(&pair.certificate, holds, pair.key);
            let made = made.self_signed()?;
            // Where both are one, through the link to it.
            let path = path.canonicalize().map_err(KeystoreError::file("find", &path))?;
            files::write_public(&path, &to_pem(&made.certificate)?)?;
        }
        Self::read(keystore)
    }

    /// Since 1970: when the first of its certificates ends.
    pub(crate) fn ends(&self) -> Duration {
        let end = |pair: &Pair| pair.certificate.tbs_certificate().validity().not_after;
        end(&self.identity).to_unix_duration().min(end(&self.permissions).to_unix_duration())
    }

    /// The governance of its keystore, which it must have signed.
    pub(crate) fn governance(&self, keystore: &Path) -> Result<Governance, KeystoreError> {
        let path = keystore.join(ENCLAVES).join(GOVERNANCE);
        if path.symlink_metadata().is_err() {
            return Err(KeystoreError::NoGovernance { path });
        }
        Governance::parse(&self.signed_text(&path)?)
            .map_err(|source| KeystoreError::Governance { path, source })
    }

    /// The text of a document, which it must have signed.
    pub(crate) fn signed_text(&self, path: &Path) -> Result<String, KeystoreError> {
        let document = files::read(path)?;
        let text = signed_text(&document)
            .map_err(|source| KeystoreError::NotSigned { path: path.to_owned(), source })?;
        signature::verify(self.permissions.key.verifying_key(), &document)
            .map_err(|source| KeystoreError::Forged { path: path.to_owned(), source })?;
        Ok(text.to_owned())
    }

    pub(crate) fn sign(&self, text: &str) -> Result<String, KeystoreError> {
        signature::sign(&self.permissions, text).map_err(KeystoreError::cryptography("a signature"))
    }

    /// Writes the governance of a keystore, and signs it.
    pub(crate) fn write_governance(
        &self,
        keystore: &Path,
        governance: &Governance,
    ) -> Result<(), KeystoreError> {
        let enclaves = keystore.join(ENCLAVES);
        let text = governance.to_xml();
        files::write_public(&enclaves.join(GOVERNANCE_TEXT), &text)?;
        files::write_public(&enclaves.join(GOVERNANCE), &self.sign(&text)?)
    }
}

fn pair(keystore: &Path, certificate: &str, key: &str) -> Result<Pair, KeystoreError> {
    let path = keystore.join(PUBLIC).join(certificate);
    let pem = files::read(&path)?;
    let no = |reason: String| KeystoreError::Certificate { path: path.clone(), reason };
    let certificate = Certificate::from_pem(pem.as_str()).map_err(|error| no(error.to_string()))?;
    let key = key_in(&keystore.join(PRIVATE).join(key))?;
    // What it signed would be trusted by nobody.
    if !certificate::is_of(&certificate, &key) {
        return Err(no("it is of another key than that in the folder `private`".to_owned()));
    }
    Ok(Pair { certificate, key })
}

/// Reads a private key.
pub(crate) fn key_in(path: &Path) -> Result<SigningKey, KeystoreError> {
    let pem = files::read(path)?;
    SigningKey::from_pkcs8_pem(&pem).map_err(|_secret| KeystoreError::Key { path: path.to_owned() })
}
