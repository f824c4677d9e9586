//! Texts of others, fit for a terminal and a log.
//!
//! Names, reasons and notes come from the network, from bags and from files. A terminal obeys the
//! control characters in them: it would overwrite the line above, or hide the one below. Whatever is
//! printed goes through here; what is to stay on one line does so where it comes in.

use std::borrow::Cow;

/// A text of others on one line.
///
/// Control characters, and those that turn the direction of writing, stand in it as `\u001b`.
pub fn one_line(text: &str) -> Cow<'_, str> {
    escaped(text, is_obeyed)
}

/// A text of several lines, and nothing else that a terminal obeys: as [`one_line`], but for `\n`.
pub fn lines(text: &str) -> Cow<'_, str> {
    escaped(text, |c| c != '\n' && is_obeyed(c))
}

fn escaped(text: &str, is_escaped: impl Fn(char) -> bool) -> Cow<'_, str> {
    if !text.contains(&is_escaped) {
        return Cow::Borrowed(text);
    }
    let escape =
        |c| if is_escaped(c) { format!("\\u{:04x}", u32::from(c)) } else { String::from(c) };
    Cow::Owned(text.chars().map(escape).collect())
}

/// Whether a terminal does something else with it than to show it.
fn is_obeyed(c: char) -> bool {
    // C0, DEL and C1; line and paragraph separators; marks and overrides of direction.
    c.is_control()
        || matches!(c, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}')
        || matches!(c, '\u{2066}'..='\u{2069}')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_character_that_a_terminal_obeys_is_left() {
        let hostile = "e-stop \u{1b}[1A\r\u{9b}2K\u{7f}robot_8\u{202e} yes\nrobot_9 yes";

        let shown = "e-stop \\u001b[1A\\u000d\\u009b2K\\u007frobot_8\\u202e yes";
        assert_eq!(one_line(hostile), format!("{shown}\\u000arobot_9 yes"));
        assert_eq!(lines(hostile), format!("{shown}\nrobot_9 yes"));
        assert!((0..=0x9f).filter_map(char::from_u32).all(|c| {
            let shown = one_line(c.encode_utf8(&mut [0; 4])).into_owned();
            !shown.contains(char::is_control)
        }));
    }

    #[test]
    fn ordinary_texts_stay_as_they_are() {
        for text in ["B_r ≥ 0.62", "Läufer 1, 陳", "רובוט", ""] {
            assert_eq!(one_line(text), text);
        }
    }
}
