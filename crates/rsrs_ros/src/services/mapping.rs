//! The two ways of calling a service: which one a request is in, and how its answer finds back.

/// How a request names itself, so that its answer finds back.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mapping {
    /// In DDS's own fields, as Fast DDS, Connext and ros2-client do.
    Enhanced,
    /// In 16 bytes in front of the request, as ROS 2 does over Cyclone DDS.
    Cyclone,
}

/// First two bytes of every GUID of Cyclone DDS.
const CYCLONE: [u8; 2] = [0x01, 0x10];

impl Mapping {
    /// The mapping of this DDS vendor, most likely.
    pub(crate) fn of_vendor(vendor: [u8; 2]) -> Self {
        if vendor == CYCLONE { Self::Cyclone } else { Self::Enhanced }
    }

    /// The mapping in which a request is answered that cannot be understood.
    pub(super) fn likely(vendor: [u8; 2], request: &[u8]) -> Self {
        let likely = Self::of_vendor(vendor);
        if request.len() < likely.n_header_bytes() { Self::Enhanced } else { likely }
    }

    /// Both, the likelier one first.
    fn in_order(vendor: [u8; 2]) -> [Self; 2] {
        let likely = Self::of_vendor(vendor);
        [likely, likely.other()]
    }

    fn other(self) -> Self {
        match self {
            Self::Enhanced => Self::Cyclone,
            Self::Cyclone => Self::Enhanced,
        }
    }

    fn n_header_bytes(self) -> usize {
        match self {
            Self::Enhanced => 0,
            // Half of a GUID and a sequence number.
            Self::Cyclone => 16,
        }
    }
}

/// Understands the bytes of a request in the mapping that the vendor (the first two bytes of the
/// client's GUID) suggests, else in the other one. `decode` gets them without a header.
///
/// Both are tried because some programs over Cyclone DDS send no header; a request of one mapping
/// does not decode in the other, where it would have 16 bytes too many or too few.
pub(crate) fn understood<Q>(
    vendor: [u8; 2],
    bytes: &[u8],
    decode: impl Fn(&[u8]) -> Option<Q>,
) -> Option<(Mapping, Q)> {
    Mapping::in_order(vendor)
        .into_iter()
        .find_map(|mapping| Some((mapping, decode(bytes.get(mapping.n_header_bytes()..)?)?)))
}

/// Puts the header of a request in front of its answer.
pub(super) fn reply(mapping: Mapping, request: &[u8], answer: &[u8]) -> Vec<u8> {
    let header = &request[..mapping.n_header_bytes()];
    [header, answer].concat()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reply_carries_the_header_of_its_request() {
        let request = [&[7; 16][..], &[9]].concat();

        assert_eq!(reply(Mapping::Enhanced, &[9], &[1, 2]), [1, 2]);
        assert_eq!(reply(Mapping::Cyclone, &request, &[1, 2]), [&request[..16], &[1, 2]].concat());
    }
}
