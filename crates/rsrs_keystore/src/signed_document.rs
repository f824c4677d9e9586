//! Documents that are signed as S/MIME, of which the text is readable.

/// What a signed document begins with, up to its text.
const TEXT_HEADER: &str = "Content-Type: text/plain";

/// A file that is no signed document.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("it is no document that was signed as S/MIME (multipart/signed)")]
pub struct NotSigned;

/// The text of a signed document. Its signature is not verified here: the middleware does that.
pub fn signed_text(document: &str) -> Result<&str, NotSigned> {
    let [text, _signature] = parts(document)?;
    let text = text.trim_start();
    Ok(text.strip_prefix(TEXT_HEADER).unwrap_or(text).trim())
}

/// What is signed, with its header, and the signature, with its headers.
pub(crate) fn parts(document: &str) -> Result<[&str; 2], NotSigned> {
    let boundary = document.split_once("boundary=\"").and_then(|(_, rest)| rest.split_once('"'));
    let (boundary, _) = boundary.filter(|(name, _)| !name.is_empty()).ok_or(NotSigned)?;
    let delimiter = format!("\n--{boundary}");
    let mut parts = document.split(delimiter.as_str()).skip(1);
    let (Some(text), Some(signature)) = (parts.next(), parts.next()) else {
        return Err(NotSigned);
    };
    // The line ends before and behind a part belong to its delimiters (RFC 2046, 5.1.1).
    let text = text.trim_start_matches('\r').strip_prefix('\n').unwrap_or(text);
    Ok([text.strip_suffix('\r').unwrap_or(text), signature])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_text_is_what_stands_between_the_first_two_boundaries() {
        let document = "MIME-Version: 1.0\nContent-Type: multipart/signed; boundary=\"----A1\"\n\n\
            This is an S/MIME signed message\n\n------A1\nContent-Type: text/plain\n\n\
            <dds/>\n\n------A1\nContent-Type: application/x-pkcs7-signature\n\nMIIB\n\n------A1--\n";

        assert_eq!(signed_text(document), Ok("<dds/>"));
    }

    #[test]
    fn what_was_not_signed_is_none() {
        let one_part = "Content-Type: multipart/signed; boundary=\"A\"\n\n--A\n<dds/>";
        for document in ["", "<dds/>", "boundary=\"\"", one_part] {
            assert_eq!(signed_text(document), Err(NotSigned), "{document}");
        }
    }
}
