//! Documents signed as DDS Security has them: S/MIME, the text readable and the signature beside it.

use cms::cert::{CertificateChoices, IssuerAndSerialNumber};
use cms::content_info::{CmsVersion, ContentInfo};
use cms::signed_data::{
    CertificateSet, EncapsulatedContentInfo, SignedData, SignerIdentifier, SignerInfo, SignerInfos,
};
use p256::ecdsa::signature::{Signer, Verifier};
use p256::ecdsa::{DerSignature, SigningKey, VerifyingKey};
use p256::elliptic_curve::Generate;
use sha2::{Digest, Sha256};
use x509_cert::Certificate;
use x509_cert::attr::{Attribute, Attributes};
use x509_cert::der::asn1::{ObjectIdentifier, OctetString, SetOfVec};
use x509_cert::der::pem::{LineEnding, decode_vec, encode_string};
use x509_cert::der::{Any, Decode, Encode, Tagged};
use x509_cert::spki::AlgorithmIdentifierOwned;

use crate::signed_document;

/// `id-data`, RFC 5652.
const DATA: ObjectIdentifier = ObjectIdentifier::new_unwrap("1.2.840.113549.1.7.1");
/// `id-signedData`, RFC 5652.
const SIGNED_DATA: ObjectIdentifier = ObjectIdentifier::new_unwrap("1.2.840.113549.1.7.2");
/// `id-contentType`, RFC 5652.
const CONTENT_TYPE: ObjectIdentifier = ObjectIdentifier::new_unwrap("1.2.840.113549.1.9.3");
/// `id-messageDigest`, RFC 5652.
const MESSAGE_DIGEST: ObjectIdentifier = ObjectIdentifier::new_unwrap("1.2.840.113549.1.9.4");
/// `id-sha256`, RFC 5754.
const SHA256: ObjectIdentifier = ObjectIdentifier::new_unwrap("2.16.840.1.101.3.4.2.1");
/// `ecdsa-with-SHA256`, RFC 5758.
pub(crate) const ECDSA_WITH_SHA256: ObjectIdentifier =
    ObjectIdentifier::new_unwrap("1.2.840.10045.4.3.2");

/// A certificate and the key that belongs to it.
pub(crate) struct Pair {
    pub(crate) certificate: Certificate,
    pub(crate) key: SigningKey,
}

/// What the libraries can fail at.
#[derive(Debug, thiserror::Error)]
pub(crate) enum SignatureError {
    #[error(transparent)]
    Der(#[from] x509_cert::der::Error),
    #[error("{0}")]
    Pem(x509_cert::der::pem::Error),
    #[error(transparent)]
    Signature(#[from] p256::ecdsa::Error),
}

/// Why a document is not what an authority has signed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ForgedDocument {
    /// It has no signature that reads.
    #[error("its signature does not read: {reason}")]
    Unreadable {
        /// Why not.
        reason: String,
    },
    /// Its text is not the one that was signed.
    #[error("its text is not the one that was signed")]
    OtherText,
    /// Somebody else has signed it.
    #[error("it was not signed with the key of this keystore's authority")]
    OtherKey,
}

/// Whether a document has been signed by this authority, and not changed since.
pub(crate) fn verify(signer: &VerifyingKey, document: &str) -> Result<(), ForgedDocument> {
    let unreadable = |reason: &str| ForgedDocument::Unreadable { reason: reason.to_owned() };
    let [content, signature] =
        signed_document::parts(document).map_err(|error| unreadable(&error.to_string()))?;
    let base64: String = signature.lines().filter(|line| !line.contains(':')).collect();
    let pem = format!("-----BEGIN PKCS7-----\n{}\n-----END PKCS7-----\n", wrapped(&base64));
    let (_, der) = decode_vec(pem.as_bytes()).map_err(|error| unreadable(&error.to_string()))?;
    let signed = ContentInfo::from_der(&der)
        .and_then(|info| info.content.decode_as::<SignedData>())
        .map_err(|error| unreadable(&error.to_string()))?;
    let [info] = signed.signer_infos.0.as_slice() else {
        return Err(unreadable("expected one signer"));
    };
    let content = content.replace("\r\n", "\n").replace('\n', "\r\n");
    let attributes = info.signed_attrs.as_ref().ok_or_else(|| unreadable("no attributes"))?;
    let digest = attributes.iter().find(|attribute| attribute.oid == MESSAGE_DIGEST);
    let digest = digest.and_then(|attribute| attribute.values.get(0));
    let digest = digest.and_then(|value| value.decode_as::<OctetString>().ok());
    if digest.is_none_or(|digest| digest.as_bytes() != Sha256::digest(&content).as_slice()) {
        return Err(ForgedDocument::OtherText);
    }
    let bytes = attributes.to_der().map_err(|error| unreadable(&error.to_string()))?;
    let signature = DerSignature::try_from(info.signature.as_bytes());
    let is_its = signature.is_ok_and(|signature| signer.verify(&bytes, &signature).is_ok());
    if is_its { Ok(()) } else { Err(ForgedDocument::OtherKey) }
}

/// Base64 in lines, as PEM has it.
fn wrapped(base64: &str) -> String {
    let lines = base64.as_bytes().chunks(64).map(String::from_utf8_lossy);
    lines.collect::<Vec<_>>().join("\n")
}

/// Signs a text: a document of two parts, the text and the signature.
pub(crate) fn sign(signer: &Pair, text: &str) -> Result<String, SignatureError> {
    let text = text.trim_end();
    let part = format!("Content-Type: text/plain\n\n{text}\n");
    // What is signed has the line ends of mail.
    let signature = signed_data(signer, part.replace('\n', "\r\n").as_bytes())?;
    let signature = base64(&signature.to_der()?)?;
    let number = u128::from_be_bytes(<[u8; 16]>::generate());
    let boundary = format!("----{number:032X}");
    Ok(format!(
        "MIME-Version: 1.0\n\
         Content-Type: multipart/signed; protocol=\"application/x-pkcs7-signature\"; \
         micalg=\"sha-256\"; boundary=\"{boundary}\"\n\n\
         This is an S/MIME signed message\n\n\
         --{boundary}\n\
         {part}\n\
         --{boundary}\n\
         Content-Type: application/x-pkcs7-signature; name=\"smime.p7s\"\n\
         Content-Transfer-Encoding: base64\n\
         Content-Disposition: attachment; filename=\"smime.p7s\"\n\n\
         {signature}\n\
         --{boundary}--\n\n"
    ))
}

/// Lines of base64, each with its end.
fn base64(bytes: &[u8]) -> Result<String, SignatureError> {
    let pem = encode_string("PKCS7", LineEnding::LF, bytes).map_err(SignatureError::Pem)?;
    Ok(pem
        .lines()
        .filter(|line| !line.starts_with("-----"))
        .map(|line| line.to_owned() + "\n")
        .collect())
}

fn signed_data(signer: &Pair, content: &[u8]) -> Result<ContentInfo, SignatureError> {
    let info = signer_info(signer, content)?;
    let certificate = CertificateChoices::Certificate(signer.certificate.clone());
    let signed = SignedData {
        version: CmsVersion::V1,
        digest_algorithms: SetOfVec::try_from(vec![algorithm(SHA256)])?,
        encap_content_info: EncapsulatedContentInfo { econtent_type: DATA, econtent: None },
        certificates: Some(CertificateSet::try_from(vec![certificate])?),
        crls: None,
        signer_infos: SignerInfos::try_from(vec![info])?,
    };
    Ok(ContentInfo { content_type: SIGNED_DATA, content: Any::encode_from(&signed)? })
}

fn signer_info(signer: &Pair, content: &[u8]) -> Result<SignerInfo, SignatureError> {
    let digest = OctetString::new(Sha256::digest(content).to_vec())?;
    let attributes = Attributes::try_from(vec![
        attribute(CONTENT_TYPE, &DATA)?,
        attribute(MESSAGE_DIGEST, &digest)?,
    ])?;
    let signature: DerSignature = signer.key.try_sign(&attributes.to_der()?)?;
    let certificate = signer.certificate.tbs_certificate();
    Ok(SignerInfo {
        version: CmsVersion::V1,
        sid: SignerIdentifier::IssuerAndSerialNumber(IssuerAndSerialNumber {
            issuer: certificate.issuer().clone(),
            serial_number: certificate.serial_number().clone(),
        }),
        digest_alg: algorithm(SHA256),
        signed_attrs: Some(attributes),
        signature_algorithm: algorithm(ECDSA_WITH_SHA256),
        signature: OctetString::new(signature.as_bytes())?,
        unsigned_attrs: None,
    })
}

fn algorithm(oid: ObjectIdentifier) -> AlgorithmIdentifierOwned {
    AlgorithmIdentifierOwned { oid, parameters: None }
}

fn attribute<T: Tagged + Encode + x509_cert::der::EncodeValue>(
    oid: ObjectIdentifier,
    value: &T,
) -> Result<Attribute, SignatureError> {
    Ok(Attribute { oid, values: SetOfVec::try_from(vec![Any::encode_from(value)?])? })
}
