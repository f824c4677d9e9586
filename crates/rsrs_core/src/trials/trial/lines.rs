//! The lines of a table and the fields of a line, whatever separates them.
//!
//! Not by the `csv` crate, whose rows go over several lines: a quote that is not closed would take all
//! that follows along, and behind blank lines and `CRLF`, which spreadsheets write, it counts other lines
//! ([208](https://github.com/BurntSushi/rust-csv/issues/208),
//! [395](https://github.com/BurntSushi/rust-csv/issues/395)). Rows that nobody fills in stay as they are.

use std::fmt;

use super::TrialKind;

/// What separates the fields of a table: commas, or what a spreadsheet takes in their place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Separator(char);

impl Separator {
    const COMMA: Self = Self(',');

    /// That of a table with this header.
    pub(super) fn from_header(header: &str) -> Self {
        let most =
            |separator: &char| (header.matches(*separator).count(), std::cmp::Reverse(*separator));
        Self([',', ';', '\t'].into_iter().max_by_key(most).expect("there are three"))
    }

    /// Splits a line where the separator is not in quotes; false if a quote stays open.
    pub(super) fn split<'a>(self, line: &'a str, fields: &mut Vec<&'a str>) -> bool {
        fields.clear();
        let mut is_quoted = false;
        let is_split = |letter: char| {
            is_quoted ^= letter == '"';
            letter == self.0 && !is_quoted
        };
        fields.extend(line.split(is_split).map(|field| {
            let field = field.trim();
            let inner = field.strip_prefix('"').and_then(|field| field.strip_suffix('"'));
            inner.map_or(field, str::trim)
        }));
        !is_quoted
    }

    /// The line of some fields, none of which has a quote in it.
    fn join(self, fields: &[impl AsRef<str>]) -> String {
        let quoted = |field: &_| {
            let field: &str = AsRef::as_ref(field);
            if field.contains(self.0) { format!("\"{field}\"") } else { field.to_owned() }
        };
        fields.iter().map(quoted).collect::<Vec<_>>().join(&self.0.to_string())
    }
}

/// The lines of a text, without the mark that a spreadsheet writes before the first.
pub(super) fn lines(text: &str) -> std::str::Lines<'_> {
    text.strip_prefix('\u{feff}').unwrap_or(text).lines()
}

/// Whether a line has nothing in it: a spreadsheet leaves rows of separators behind its last one.
pub(super) fn is_blank(line: &str) -> bool {
    line.chars().all(|letter| " \t,;".contains(letter))
}

/// A table that is filled in: all of its lines, in which only what is filled in changes.
#[derive(Clone, Debug, PartialEq)]
pub struct TableLines {
    lines: Vec<String>,
    separator: Separator,
}

impl TableLines {
    /// A table without rows.
    pub fn empty(kind: TrialKind) -> Self {
        Self { lines: vec![kind.header()], separator: Separator::COMMA }
    }

    /// Reads a table whose first line is its header.
    pub fn parse(text: &str) -> Self {
        let lines: Vec<String> = lines(text).map(str::to_owned).collect();
        let separator = Separator::from_header(lines.first().map_or("", String::as_str));
        Self { lines, separator }
    }

    /// A line as it stands, from 1; empty if it is not there.
    pub fn line(&self, line: usize) -> &str {
        self.lines.get(line - 1).map_or("", String::as_str)
    }

    /// The fields of a line, from 1; `None` if a quote in it is not closed.
    pub fn fields(&self, line: usize) -> Option<Vec<&str>> {
        let mut fields = Vec::new();
        self.separator.split(self.line(line), &mut fields).then_some(fields)
    }

    /// The lines below the header that are not blank, from 2.
    pub fn rows(&self) -> impl Iterator<Item = usize> {
        let rows = self.lines.iter().zip(1..).skip(1);
        rows.filter(|(row, _)| !is_blank(row)).map(|(_, line)| line)
    }

    /// The last line, from 1.
    pub fn last(&self) -> usize {
        self.lines.len()
    }

    /// How many of the last columns of a kind are not there, as [`TrialKind::n_missing`] has it.
    pub fn n_missing(&self, kind: TrialKind) -> Option<usize> {
        kind.n_missing(&self.fields(1)?)
    }

    /// Adds so many of the last columns of a kind, which are empty.
    pub fn add_columns(&mut self, kind: TrialKind, n_missing: usize) {
        if n_missing == 0 {
            return;
        }
        let rows: Vec<usize> = self.rows().collect();
        for line in rows {
            self.lines[line - 1].extend(std::iter::repeat_n(self.separator.0, n_missing));
        }
        self.lines[0] = self.separator.join(&kind.columns().collect::<Vec<_>>());
    }

    /// Puts fields into a line, from 1.
    pub fn set(&mut self, line: usize, fields: &[String]) {
        self.lines[line - 1] = self.separator.join(fields);
    }

    /// Adds a row.
    pub fn push(&mut self, fields: &[String]) {
        self.lines.push(self.separator.join(fields));
    }
}

impl fmt::Display for TableLines {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.lines.iter().try_for_each(|line| writeln!(out, "{line}"))
    }
}
