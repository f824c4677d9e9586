//! What the parser of YAML refuses, in words of files and not of parsers.

use serde_saphyr::Error;

use super::{DocumentError, Problem, did_you_mean, nearest};

/// A document that was refused, called `file`.
pub fn refuse(file: &str, text: &str, error: &Error) -> DocumentError {
    let (line, column) =
        error.location().map_or((1, 1), |location| (location.line(), location.column()));
    let problem = match error.without_snippet() {
        Error::SerdeUnknownField { field, expected, .. } => Problem::UnknownKey {
            key: field.clone(),
            nearest: nearest(field, expected.iter().copied()).map(str::to_owned),
            expected: expected.iter().map(|key| (*key).to_owned()).collect(),
        },
        Error::SerdeMissingField { field, .. } => {
            Problem::Missing { keys: vec![(*field).to_owned()] }
        }
        other => {
            let found = word_at(text, line, column);
            let said = in_words(other, found);
            Problem::Invalid(said.unwrap_or_else(|| without_location(&other.to_string())))
        }
    };
    DocumentError { file: file.to_owned(), line, column, problem }
}

/// That there is no number; where one has its unit with it, that the key has the unit.
fn no_number(found: &str) -> String {
    match found.split_once(' ') {
        Some((number, unit)) if number.parse::<f64>().is_ok() => {
            format!(
                "`{found}` is no number: write it without `{}`, in the unit of its key",
                unit.trim()
            )
        }
        _ => format!("`{found}` is no number"),
    }
}

/// What is wrong, where the parser's own words are about types and events; `found` is what stands there.
fn in_words(error: &Error, found: &str) -> Option<String> {
    Some(match error {
        Error::InvalidScalar { ty: "boolean", .. } => {
            format!("`{found}` is neither `true` nor `false`")
        }
        Error::InvalidScalar { ty: "floating point", .. } => {
            let point = found.replacen(',', ".", 1);
            match point.parse::<f64>() {
                Ok(_) if point != found => {
                    format!("`{found}` is no number, decimals have a point: did you mean {point}?")
                }
                _ => no_number(found),
            }
        }
        Error::InvalidScalar { ty, .. } if ty.starts_with('u') && found.parse::<u128>().is_ok() => {
            format!("`{found}` is too great")
        }
        Error::InvalidScalar { ty, .. } if ty.starts_with('u') => {
            format!("`{found}` is no whole number from 0 on")
        }
        Error::InvalidScalar { ty, .. } if ty.starts_with('i') => {
            format!("`{found}` is no whole number")
        }
        Error::Unexpected { expected, .. } if expected.starts_with("sequence") => {
            "expected a list here, as `[one, another]`".to_owned()
        }
        Error::Unexpected { expected, .. } if expected.starts_with("mapping") => {
            "expected keys with their values here, as `{key: value}`".to_owned()
        }
        Error::Unexpected { expected, .. } if expected.contains("scalar") => {
            "expected one value here, and no list or keys".to_owned()
        }
        Error::SerdeInvalidType { unexpected, expected, .. } => {
            format!("expected {expected}, found {unexpected}")
        }
        Error::SerdeInvalidLength { len, expected, .. } => {
            let n: String = expected.chars().filter(char::is_ascii_digit).collect();
            format!("this list has {len} values, expected {n}")
        }
        Error::SerdeUnknownVariant { variant, expected, .. } => {
            let meant = did_you_mean(nearest(variant, expected.iter().copied()));
            format!("unknown `{variant}`, expected one of {}{meant}", expected.join(", "))
        }
        Error::ExpectedMappingEndAfterEnumVariantValue { .. } => {
            "expected one key here, found more".to_owned()
        }
        Error::DuplicateMappingKey { key, .. } => {
            let key = key.as_deref().unwrap_or(found);
            format!("key `{key}` is given twice")
        }
        Error::UnknownAnchor { .. } => {
            format!("`{found}` refers to nothing: a text that begins with `*` stands in quotes")
        }
        Error::ExternalMessage { msg, .. } => format!("this is not YAML: {msg}"),
        Error::Eof { .. } => "the file ends in the middle".to_owned(),
        Error::MultipleDocuments { .. } => "a second document begins here, expected one".to_owned(),
        _ => return None,
    })
}

/// The value at a place, from 1, as it is written: to the end of the line, or of its place in a list or map.
fn word_at(text: &str, line: u64, column: u64) -> &str {
    let index = |place: u64| usize::try_from(place.saturating_sub(1)).unwrap_or(usize::MAX);
    let line = text.lines().nth(index(line)).unwrap_or_default();
    let begin = line.char_indices().nth(index(column)).map_or(line.len(), |(begin, _)| begin);
    let rest = &line[begin..];
    let ends = [", ", ": ", " #", "}", "]", "\t"].into_iter().filter_map(|end| rest.find(end));
    let end = ends.min().unwrap_or(rest.len());
    rest[..end].trim_end_matches([',', ':', ' '])
}

/// The parser ends its sentences with the place, which the error already has in front.
fn without_location(message: &str) -> String {
    let first_line = message.lines().next().unwrap_or(message);
    let sentence = first_line.strip_prefix("error: ").unwrap_or(first_line);
    let sentence = match sentence.rfind(" at line ") {
        Some(end) => &sentence[..end],
        None => sentence,
    };
    match sentence.strip_prefix("line ").and_then(|rest| rest.split_once(": ")) {
        Some((_, rest)) => rest.to_owned(),
        None => sentence.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use serde::Deserialize;

    use super::super::parse;

    #[derive(Debug, Deserialize)]
    #[serde(deny_unknown_fields)]
    #[expect(dead_code, reason = "parsed only")]
    struct Document {
        speed_m_s: Option<f64>,
        robots: Option<u32>,
        is_loud: Option<bool>,
        names: Option<[String; 3]>,
        walls: Option<Walls>,
        numbers: Option<BTreeMap<String, f64>>,
    }

    #[derive(Debug, Deserialize)]
    #[serde(rename_all = "snake_case")]
    enum Walls {
        Clamp,
        Slide,
    }

    #[test]
    fn what_is_wrong_is_said_without_words_of_a_parser() {
        for (text, expected) in [
            ("speed_m_s: fast", "1:12: `fast` is no number"),
            (
                "speed_m_s: 0,15",
                "1:12: `0,15` is no number, decimals have a point: did you mean 0.15?",
            ),
            (
                "speed_m_s: 15 cm/s   # slow",
                "1:12: `15 cm/s` is no number: write it without `cm/s`, in the unit of its key",
            ),
            (
                "numbers: {a: 98 %, b: 1}",
                "1:14: `98 %` is no number: write it without `%`, in the unit of its key",
            ),
            ("robots: 5000000000", "1:9: `5000000000` is too great"),
            ("robots: -3", "1:9: `-3` is no whole number from 0 on"),
            ("is_loud: 1", "1:10: `1` is neither `true` nor `false`"),
            ("names: [a, b]", "1:1: this list has 2 values, expected 3"),
            ("names: [a", "1:8: this is not YAML: unclosed bracket"),
            ("names: a", "1:8: expected a list here, as `[one, another]`"),
            (
                "walls: clmap",
                "1:8: unknown `clmap`, expected one of clamp, slide; did you mean `clamp`?",
            ),
            ("numbers: 3", "1:10: expected keys with their values here, as `{key: value}`"),
            ("robots: 3\nrobots: 4", "2:1: key `robots` is given twice"),
            (
                "names: *one",
                "1:8: `*one` refers to nothing: a text that begins with `*` stands in quotes",
            ),
        ] {
            let error = parse::<Document>("a.yaml", text).unwrap_err().to_string();
            assert!(error.starts_with(&format!("a.yaml:{expected}")), "{error}");
        }
    }
}
