//! Mutations that leave most of an input as it is, and lengths and encodings right.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use rand::RngExt;
use rand::rngs::ChaCha8Rng;

/// What may stand for a word or a number.
const WORDS: [&str; 22] = [
    "",
    "0",
    "-1",
    "2",
    "-0.0",
    "1e-9",
    "1e300",
    "-1e300",
    "1e-320",
    "1e999",
    "NaN",
    ".nan",
    ".inf",
    "-.inf",
    "255",
    "65536",
    "18446744073709551616",
    "-9223372036854775809",
    "robot_1",
    "lab/robot_1",
    "..",
    "\u{1b}[2K\u{202e}\0é\u{1F916}",
];

/// What means something to YAML, JSON or XML.
const SIGNS: [&str; 20] = [
    "{", "}", "[", "]", ": ", ",", "\"", "'", "&a ", "*a", "!", "|\n", "<a>", "/", "%", "#", "- ",
    "\n", "\t", "\u{85}",
];

fn pick<'a, T: ?Sized>(of: &[&'a T], draw: &mut ChaCha8Rng) -> &'a T {
    of[draw.random_range(0..of.len())]
}

/// A number that may be one too many or far too many, or no number.
fn boundary(draw: &mut ChaCha8Rng) -> u64 {
    let number = match draw.random_range(0..3) {
        0 => [f64::NAN, f64::INFINITY, 1e300, -1.0][draw.random_range(0..4)].to_bits(),
        1 => 1 << draw.random_range(0..64),
        _ => draw.random_range(0..300),
    };
    if draw.random() { number } else { number.wrapping_sub(1) }
}

/// A piece of some bytes.
fn piece<'a>(bytes: &'a [u8], draw: &mut ChaCha8Rng) -> &'a [u8] {
    let from = draw.random_range(0..=bytes.len());
    &bytes[from..draw.random_range(from..=bytes.len().min(from + 64))]
}

/// Mutates what is behind the first bytes of an input.
pub fn behind(
    n_bytes: usize,
    mutation: impl Fn(&mut Vec<u8>, &[u8], &mut ChaCha8Rng),
) -> impl Fn(&mut Vec<u8>, &[u8], &mut ChaCha8Rng) {
    move |input, other, draw| {
        let mut rest = input.split_off(n_bytes);
        mutation(&mut rest, other, draw);
        input.extend(rest);
    }
}

/// Mutates any bytes.
pub fn bytes(input: &mut Vec<u8>, other: &[u8], draw: &mut ChaCha8Rng) {
    let at = draw.random_range(0..=input.len());
    match draw.random_range(0..7) {
        0 | 1 if at < input.len() => input[at] ^= 1 << draw.random_range(0..8),
        2 => {
            let size = [1, 2, 4, 8][draw.random_range(0..4)];
            let mut number = boundary(draw).to_le_bytes()[..size].to_vec();
            if draw.random() {
                number.reverse();
            }
            input.iter_mut().skip(at).zip(number).for_each(|(old, new)| *old = new);
        }
        3 => drop(input.drain(at..input.len().min(at + 8))),
        4 => {
            let copied = piece(input, draw).to_vec();
            input.splice(at..at, copied);
        }
        5 => drop(input.splice(at..at, piece(other, draw).iter().copied())),
        _ => input.truncate(at),
    }
}

/// Mutates a message in CDR: its bytes, or a text in it, whose length and padding are right again.
pub fn cdr(input: &mut Vec<u8>, other: &[u8], draw: &mut ChaCha8Rng) {
    // The bytes of a text with their length in front and a zero behind them, if there is one.
    let text_at = |at: usize| {
        let length = u32::from_le_bytes(*input.get(at..)?.first_chunk()?);
        let (zero, text) = input[at + 4..].get(..usize::try_from(length).ok()?)?.split_last()?;
        (*zero == 0).then_some((at, text.to_vec()))
    };
    let texts: Vec<_> = (4..input.len()).step_by(4).filter_map(text_at).collect();
    if texts.is_empty() || draw.random() {
        return bytes(input, other, draw);
    }
    let (at, mut content) = texts[draw.random_range(0..texts.len())].clone();
    let end = (at + 4 + content.len() + 1).next_multiple_of(4).min(input.len());
    text(&mut content, other, draw);
    content.push(0);
    let length = u32::try_from(content.len()).expect("inputs are short").to_le_bytes();
    content.resize(content.len().next_multiple_of(4), 0);
    input.splice(at..end, length.into_iter().chain(content));
}

/// Mutates a text of words, numbers and signs, such as YAML, JSON and XML.
pub fn text(input: &mut Vec<u8>, other: &[u8], draw: &mut ChaCha8Rng) {
    let is_sign = |byte: &u8| !byte.is_ascii_alphanumeric() && !b"_-.+".contains(byte);
    let word_at = |text: &[u8], at: usize| {
        let start = at + text[at..].iter().take_while(|byte| is_sign(byte)).count();
        start..start + text[start..].iter().take_while(|byte| !is_sign(byte)).count()
    };
    let at = draw.random_range(0..=input.len());
    let word = word_at(input, at);
    match draw.random_range(0..8) {
        0..=2 => drop(input.splice(word, pick(&WORDS, draw).bytes())),
        3 => drop(input.splice(at..at, pick(&SIGNS, draw).bytes())),
        4 => {
            let another = word_at(other, draw.random_range(0..=other.len()));
            input.splice(word, other[another].iter().copied());
        }
        5 => {
            let mut lines: Vec<_> = input.split_inclusive(|byte| *byte == b'\n').collect();
            let source = if draw.random() { other } else { &*input };
            let source: Vec<_> = source.split_inclusive(|byte| *byte == b'\n').collect();
            let from = draw.random_range(0..=lines.len());
            let to = draw.random_range(from..=lines.len().min(from + 1));
            let n_lines = usize::from(!source.is_empty() && draw.random());
            lines.splice(from..to, (0..n_lines).map(|_| pick(&source, draw)));
            *input = lines.concat();
        }
        6 => {
            let nested = pick(&["[", "{", "- ", "{\"a\":", "<a>", "  "], draw);
            let nested = nested.repeat(1 << draw.random_range(0..14));
            input.splice(at..at, nested.bytes());
        }
        _ => bytes(input, other, draw),
    }
}

/// Mutates the bytes behind the first lines of base64 in a text, such as a certificate or a signature.
pub fn base64(input: &mut Vec<u8>, other: &[u8], draw: &mut ChaCha8Rng) {
    let is_digit = |byte: &u8| byte.is_ascii_alphanumeric() || b"+/=".contains(byte);
    let lines: Vec<_> = input.split_inclusive(|byte| *byte == b'\n').collect();
    let is_base64 = |line: &&[u8]| line.trim_ascii_end().iter().all(is_digit);
    let first = lines.iter().position(|line| line.len() > 32 && is_base64(line));
    let first = first.unwrap_or(lines.len());
    let n_lines = lines[first..].iter().take_while(|line| is_base64(line)).count();
    let (before, rest) = lines.split_at(first);
    let (encoded, behind) = rest.split_at(n_lines);
    let encoded: Vec<_> = encoded.iter().flat_map(|line| line.trim_ascii_end()).copied().collect();
    let Ok(mut content) = STANDARD.decode(encoded) else { return bytes(input, other, draw) };
    bytes(&mut content, other, draw);
    let mut encoded = STANDARD.encode(content).into_bytes();
    encoded.push(b'\n');
    *input = [&before.concat(), &encoded, &*behind.concat()].concat();
}
