//! Which participant an endpoint belongs to.

/// Bytes of a GUID that name the participant; the first two name the vendor.
pub(super) type Prefix = [u8; 12];

/// The participant in the identity of one of its endpoints.
pub(super) fn prefix(guid: [u8; 16]) -> Prefix {
    *guid.first_chunk().expect("a GUID is longer than its prefix")
}
