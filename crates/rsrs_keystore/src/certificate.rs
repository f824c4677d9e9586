//! Who a certificate names, and how long it holds.

use std::time::Duration;

use x509_cert::Certificate;
use x509_cert::der::DecodePem;

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
///
/// # Errors
///
/// [`NoCertificate`].
pub fn read(pem: &str) -> Result<CertificateFacts, NoCertificate> {
    let certificate =
        Certificate::from_pem(pem).map_err(|error| NoCertificate { reason: error.to_string() })?;
    let certificate = certificate.tbs_certificate();
    let validity = certificate.validity();
    Ok(CertificateFacts {
        subject: certificate.subject().to_string(),
        not_before: validity.not_before.to_unix_duration(),
        not_after: validity.not_after.to_unix_duration(),
    })
}
