//! Counts, sizes and times as people read them.

pub mod quantity;
pub mod shell;

use std::path::PathBuf;

use jiff::Timestamp;
use rsrs_core::printable::one_line;

/// Log times from here on are of the wall clock, earlier ones of a simulation: none simulates
/// 30 years.
const FIRST_WALL_NS: u64 = 1_000_000_000_000_000_000;

/// A count with commas between thousands: `87,666`.
pub fn count(n: u64) -> String {
    let digits = n.to_string();
    let mut text = String::new();
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// A count of things: `1 message`, `2 messages`.
pub fn counted(n: u64, what: &str) -> String {
    if n == 1 { format!("{n} {what}") } else { format!("{} {what}s", count(n)) }
}

/// A number in three significant digits, as a person would write it.
///
/// # Panics
///
/// Never: what is written is a number again.
pub fn significant(number: f64) -> f64 {
    format!("{number:.2e}").parse().expect("a number that was written reads")
}

/// A share: `97.3 %`.
pub fn percent(share: f64) -> String {
    format!("{:.1} %", 100.0 * share)
}

/// A sentence with a capital letter in front.
pub fn capitalised(sentence: &str) -> String {
    let mut characters = sentence.chars();
    let first = characters.next().map(|first| first.to_uppercase().to_string());
    first.unwrap_or_default() + characters.as_str()
}

/// A size: `312 bytes`, `3.1 MB`.
pub fn size(n_bytes: u64) -> String {
    let units = [("GB", 1e9), ("MB", 1e6), ("kB", 1e3)];
    match units.into_iter().find(|(_, unit)| n_bytes as f64 >= *unit) {
        Some((name, unit)) => format!("{:.1} {name}", n_bytes as f64 / unit),
        None => counted(n_bytes, "byte"),
    }
}

/// Files as one source: all names of a few, the first of many.
pub fn names(paths: &[&PathBuf]) -> String {
    let names: Vec<String> = paths.iter().map(|path| path.display().to_string()).collect();
    match &names[..] {
        [first, .., last] if names.len() > 3 => {
            format!("{first} to {last} ({} files)", names.len())
        }
        _ => names.join(", "),
    }
}

/// A moment of a recording: a date where the wall clock was recorded, seconds where a simulation's
/// was.
pub fn moment(time_ns: u64) -> String {
    if time_ns >= FIRST_WALL_NS
        && let Ok(timestamp) = Timestamp::from_nanosecond(time_ns.into())
    {
        return format!("{timestamp:.3}");
    }
    format!("{:.3} s", time_ns as f64 / 1e9)
}

/// Rows as columns: each as wide as its widest field, two spaces apart.
pub fn columns<const N: usize>(rows: &[[String; N]]) -> String {
    // A cell is one line, also where its text is somebody else's.
    let one_lined = |row: &[String; N]| row.each_ref().map(|cell| one_line(cell).into_owned());
    let rows: Vec<[String; N]> = rows.iter().map(one_lined).collect();
    let mut widths = [0; N];
    for row in &rows {
        for (width, field) in widths.iter_mut().zip(row) {
            *width = (*width).max(field.chars().count());
        }
    }
    let line = |row: &[String; N]| {
        let fields: Vec<String> =
            row.iter().zip(widths).map(|(field, width)| format!("{field:width$}")).collect();
        fields.join("  ").trim_end().to_owned()
    };
    rows.iter().map(line).collect::<Vec<_>>().join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thousands_have_commas() {
        let texts = [0, 999, 1_000, 87_666, 1_234_567].map(count);

        assert_eq!(texts, ["0", "999", "1,000", "87,666", "1,234,567"]);
        assert_eq!((&*counted(1, "topic"), &*counted(2_000, "topic")), ("1 topic", "2,000 topics"));
    }

    #[test]
    fn sizes_have_the_largest_unit_that_fits() {
        let texts = [1, 312, 1_000, 3_140_000, 2_500_000_000].map(size);

        assert_eq!(texts, ["1 byte", "312 bytes", "1.0 kB", "3.1 MB", "2.5 GB"]);
    }

    #[test]
    fn times_of_the_wall_are_dates_and_simulated_ones_are_not() {
        assert_eq!(moment(299_910_000_000), "299.910 s");
        assert_eq!(moment(1_795_248_000_000_000_000), "2026-11-21T08:00:00.000Z");
    }
}
