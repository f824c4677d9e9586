//! YAML documents: parsed strictly, refused with file, line, column and the nearest valid key.

pub mod file_error;
pub mod kind;
mod refusal;
pub mod source;

use std::collections::BTreeSet;
use std::fmt;

use serde::Serialize;
use serde::de::{Deserialize, DeserializeOwned, Deserializer, IgnoredAny, MapAccess, Visitor};

use self::kind::Kind;
use crate::help::Help;

/// Why a document was refused, and where.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{file}:{line}:{column}: {problem}")]
pub struct DocumentError {
    /// Name of the document, as the user gave it.
    pub file: String,
    /// Line of the first offending character, from 1.
    pub line: u64,
    /// Column of the first offending character, from 1.
    pub column: u64,
    /// What is wrong.
    pub problem: Problem,
}

/// What is wrong with a document.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Problem {
    /// A key that the document's kind does not have.
    #[error("unknown key `{key}`{}", did_you_mean(nearest.as_deref()))]
    UnknownKey {
        /// The key found.
        key: String,
        /// The valid key that is closest in spelling, if any is close.
        nearest: Option<String>,
        /// All valid keys at this place.
        expected: Vec<String>,
    },
    /// A document of another kind.
    #[error("this is {}, expected a file with the keys {}", kind.name, expected.join(", "))]
    OtherKind {
        /// What it is.
        kind: Kind,
        /// All valid keys at this place.
        expected: Vec<String>,
    },
    /// Required keys that are not there.
    #[error("{}", missing(keys))]
    Missing {
        /// The keys, in the order in which the document's kind has them.
        keys: Vec<String>,
    },
    /// No key at all.
    #[error("there is nothing in it")]
    Empty,
    /// Anything else that the parser or a value's type refuses.
    #[error("{0}")]
    Invalid(String),
}

fn missing(keys: &[String]) -> String {
    let named: Vec<String> = keys.iter().map(|key| format!("`{key}`")).collect();
    let word = if keys.len() == 1 { "key" } else { "keys" };
    format!("missing {word} {}", named.join(", "))
}

/// The end of a sentence about an unknown name.
pub fn did_you_mean(nearest: Option<&str>) -> String {
    nearest.map_or_else(String::new, |nearest| format!("; did you mean `{nearest}`?"))
}

/// Whether a text is a name that people give in files: small letters, digits and `_`, a letter first.
pub fn is_name(text: &str) -> bool {
    let is_letter = |character: char| character.is_ascii_lowercase();
    text.starts_with(is_letter)
        && text.chars().all(|it| is_letter(it) || it.is_ascii_digit() || it == '_')
}

impl Help for DocumentError {
    fn help(&self) -> Option<String> {
        match &self.problem {
            Problem::UnknownKey { expected, .. } => {
                Some(format!("the keys here are: {}", expected.join(", ")))
            }
            Problem::OtherKind { kind, .. } => Some(kind.used_by.to_owned()),
            Problem::Missing { keys } => {
                let lines: Vec<String> = keys.iter().map(|key| format!("`{key}:`")).collect();
                Some(format!("give {}", lines.join(", ")))
            }
            Problem::Empty | Problem::Invalid(_) => None,
        }
    }
}

/// Parses one YAML document into `T`; errors call it `file`, and nothing is opened.
///
/// Unknown keys are errors when `T` denies them, as every configuration of ours does.
pub fn parse<T: DeserializeOwned>(file: &str, text: &str) -> Result<T, DocumentError> {
    let options = serde_saphyr::options! { with_snippet: false };
    serde_saphyr::from_str_with_options(text, options).map_err(|error| {
        let refused = refusal::refuse(file, text, &error);
        if is_empty(text) {
            return DocumentError { line: 1, column: 1, problem: Problem::Empty, ..refused };
        }
        DocumentError { problem: kind::of_another(refused.problem, text), ..refused }
    })
}

/// Plain data as a YAML document. Types have functions of their own that call it, so that how each is
/// written is compiled once, as it is with [`parse`].
pub fn to_yaml<T: Serialize>(data: &T) -> String {
    serde_saphyr::to_string(data).expect("words, numbers, lists and maps have a YAML form")
}

/// Whether there are blank lines and comments alone.
fn is_empty(text: &str) -> bool {
    text.lines().map(str::trim).all(|line| line.is_empty() || line.starts_with('#'))
}

/// As [`parse`]; of the `required` keys, those of `T` that have no default, all that are missing
/// are named, in this order, and not only the first.
pub fn parse_with<T: DeserializeOwned>(
    file: &str,
    text: &str,
    required: &[&str],
) -> Result<T, DocumentError> {
    let refused = match parse::<T>(file, text) {
        Ok(parsed) => return Ok(parsed),
        Err(refused) => refused,
    };
    // What does not parse as a map lacks more than keys.
    let Ok(Keys(found)) = parse(file, text) else { return Err(refused) };
    let keys: Vec<String> =
        required.iter().filter(|key| !found.contains(**key)).map(|key| (*key).to_owned()).collect();
    let is_one_of_them = match &refused.problem {
        Problem::Missing { keys: first } => first.iter().all(|key| keys.contains(key)),
        Problem::UnknownKey { .. }
        | Problem::OtherKind { .. }
        | Problem::Empty
        | Problem::Invalid(_) => false,
    };
    if is_one_of_them {
        return Err(DocumentError { problem: Problem::Missing { keys }, ..refused });
    }
    Err(refused)
}

/// The keys of a map, whatever they stand for.
struct Keys(BTreeSet<String>);

impl<'de> Deserialize<'de> for Keys {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Found;

        impl<'de> Visitor<'de> for Found {
            type Value = Keys;

            fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
                formatter.write_str("a map")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Keys, A::Error> {
                let mut keys = BTreeSet::new();
                while let Some((key, IgnoredAny)) = map.next_entry()? {
                    keys.insert(key);
                }
                Ok(Keys(keys))
            }
        }

        deserializer.deserialize_map(Found)
    }
}

/// The candidate closest in spelling to `word`, if one is close enough to be a slip of the hand:
/// one that begins with the word, else the first candidate with the least edit distance, if that is
/// at most a third of the word's length (2 edits are always allowed), or if the word begins with
/// it.
pub fn nearest<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let few = word.chars().count() / 3;
    // `sped` begins as `speed_m_s` does.
    let begins = |candidate: &str| {
        let mut ends = candidate.match_indices('_').map(|(end, _)| end);
        ends.any(|end| edit_distance(word, &candidate[..end]) <= few)
    };
    candidates
        .into_iter()
        .map(|candidate| (edit_distance(word, candidate), candidate))
        .filter(|(distance, candidate)| {
            *distance <= few.max(2)
                || candidate.starts_with(word)
                || word.starts_with(candidate)
                || begins(candidate)
        })
        .min_by_key(|(distance, candidate)| (!candidate.starts_with(word), *distance))
        .map(|(_, candidate)| candidate)
}

/// Levenshtein distance: insertions, deletions and substitutions that lead from one word to another.
fn edit_distance(from: &str, to: &str) -> usize {
    let to: Vec<char> = to.chars().collect();
    let mut row: Vec<usize> = (0..=to.len()).collect();
    for (line, from_character) in from.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = line + 1;
        for (column, to_character) in to.iter().enumerate() {
            let substituted = diagonal + usize::from(from_character != *to_character);
            diagonal = row[column + 1];
            row[column + 1] = substituted.min(diagonal + 1).min(row[column] + 1);
        }
    }
    row[to.len()]
}

#[cfg(test)]
mod tests {
    use serde::Deserialize;

    use super::*;

    #[derive(Debug, Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Sweep {
        #[expect(dead_code, reason = "parsed only")]
        duration_s: f64,
        #[expect(dead_code, reason = "parsed only")]
        replicates: u32,
    }

    #[test]
    fn a_wrong_key_is_named_with_its_place_and_the_nearest_key() {
        let error = parse::<Sweep>("sweep.yaml", "replicates: 3\nduration: 300\n").unwrap_err();

        assert_eq!(
            error.to_string(),
            "sweep.yaml:2:1: unknown key `duration`; did you mean `duration_s`?"
        );
    }

    #[test]
    fn all_missing_keys_are_named_at_once_and_other_mistakes_before_them() {
        let keys = ["duration_s", "replicates"];
        let refused = |text: &str| parse_with::<Sweep>("sweep.yaml", text, &keys).unwrap_err();

        let nothing = refused("{}");
        assert!(
            nothing.to_string().ends_with("missing keys `duration_s`, `replicates`"),
            "{nothing}"
        );
        assert_eq!(nothing.help().unwrap(), "give `duration_s:`, `replicates:`");
        assert!(refused("duration_s: 3").to_string().ends_with("missing key `replicates`"));
        assert!(refused("duration: 3").to_string().contains("did you mean `duration_s`?"));
        assert!(refused("duration_s: much").to_string().contains("`much` is no number"));
    }
}
