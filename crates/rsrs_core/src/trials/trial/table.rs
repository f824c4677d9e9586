//! A CSV table, read row by row without keeping any.

use super::error::{TrialError, TrialProblem, unit_of};
use super::kind::{BACKEND, PAUSED};
use super::lines::{Separator, is_blank, lines};
use super::{TrialBackend, TrialKind};
use crate::document::nearest;

/// A table whose header was found to be right.
pub struct Table<'a> {
    file: &'a str,
    lines: Lines<'a>,
    separator: Separator,
    n_fields: usize,
    /// Columns of this kind of table; shape `[n_columns]`.
    columns: Vec<&'static str>,
    /// Where each column stands in a row; shape `[n_columns]`.
    places: Vec<Option<usize>>,
    fields: Vec<&'a str>,
}

/// One row of a table.
pub struct Row<'t, 'a> {
    table: &'t Table<'a>,
    /// Line of the table, from 1.
    pub line: u64,
}

/// Lines with their numbers, without blank ones.
struct Lines<'a> {
    rest: std::iter::Enumerate<std::str::Lines<'a>>,
}

impl<'a> Lines<'a> {
    fn next_line(&mut self) -> Option<(u64, &'a str)> {
        self.rest
            .by_ref()
            .map(|(index, line)| (index as u64 + 1, line))
            .find(|(_, line)| !is_blank(line))
    }
}

impl<'a> Table<'a> {
    /// Reads the header of a table of this kind.
    pub fn open_kind(file: &'a str, text: &'a str, kind: TrialKind) -> Result<Self, TrialError> {
        Self::open(file, text, kind.required(), kind.optional())
    }

    /// Reads the header, in which no column may be missing, unknown or there twice.
    pub fn open(
        file: &'a str,
        text: &'a str,
        required: &[&'static str],
        optional: &[&'static str],
    ) -> Result<Self, TrialError> {
        let columns: Vec<&'static str> = required.iter().chain(optional).copied().collect();
        let mut lines = Lines { rest: lines(text).enumerate() };
        let named = || columns.iter().map(|column| (*column).to_owned()).collect();
        let (line, header) = lines.next_line().ok_or_else(|| TrialError {
            file: file.to_owned(),
            line: 1,
            problem: TrialProblem::Empty { expected: named() },
        })?;
        let refuse = |problem| Err(TrialError { file: file.to_owned(), line, problem });
        let separator = Separator::from_header(header);
        let mut found = Vec::new();
        if !separator.split(header, &mut found) {
            return refuse(TrialProblem::OpenQuote);
        }
        let places: Vec<Option<usize>> =
            columns.iter().map(|column| found.iter().position(|name| name == column)).collect();
        for (column, place) in required.iter().zip(&places) {
            if place.is_none() {
                let free = found.iter().copied().filter(|name| !columns.contains(name));
                return refuse(TrialProblem::MissingColumn {
                    column,
                    header: header.trim().to_owned(),
                    nearest: nearest(column, free).map(str::to_owned),
                });
            }
        }
        for (position, name) in found.iter().enumerate() {
            if found[..position].contains(name) {
                return refuse(TrialProblem::ColumnTwice { column: (*name).to_owned() });
            }
            if !columns.contains(name) {
                return refuse(TrialProblem::UnknownColumn {
                    column: (*name).to_owned(),
                    nearest: nearest(name, columns.iter().copied()).map(str::to_owned),
                    expected: named(),
                });
            }
        }
        let n_fields = found.len();
        Ok(Self { file, lines, separator, n_fields, columns, places, fields: Vec::new() })
    }

    /// Name of the table.
    pub fn file(&self) -> &str {
        self.file
    }

    /// The column of pauses, of tables that may have it.
    pub fn paused(&self) -> Option<usize> {
        self.columns.iter().position(|column| *column == PAUSED)
    }

    /// Whether an optional column is there.
    pub fn has(&self, column: usize) -> bool {
        self.places[column].is_some()
    }

    /// The next row that is not blank; it has as many fields as the header.
    pub fn next_row(&mut self) -> Result<Option<Row<'_, 'a>>, TrialError> {
        let Some((line, text)) = self.lines.next_line() else { return Ok(None) };
        let refuse = |problem| Err(TrialError { file: self.file.to_owned(), line, problem });
        if !self.separator.split(text, &mut self.fields) {
            return refuse(TrialProblem::OpenQuote);
        }
        let (found, expected) = (self.fields.len(), self.n_fields);
        if found != expected {
            return refuse(TrialProblem::Fields { expected, found });
        }
        Ok(Some(Row { table: self, line }))
    }

    /// A problem of the whole table.
    pub fn refuse(&self, problem: TrialProblem) -> TrialError {
        TrialError { file: self.file.to_owned(), line: 1, problem }
    }
}

impl Row<'_, '_> {
    fn field(&self, column: usize) -> &str {
        self.table.places[column].map_or("", |place| self.table.fields[place])
    }

    pub fn refuse(&self, problem: TrialProblem) -> TrialError {
        TrialError { file: self.table.file.to_owned(), line: self.line, problem }
    }

    /// A problem with a number's size.
    pub fn out_of_range(&self, column: usize, found: f64, expected: &'static str) -> TrialError {
        let column = self.table.columns[column];
        self.refuse(TrialProblem::OutOfRange { column, found, expected })
    }

    /// A problem with a number's likely unit.
    pub fn unit(&self, column: usize, found: f64, likely: &'static str) -> TrialError {
        let column = self.table.columns[column];
        let expected = unit_of(column);
        self.refuse(TrialProblem::Unit { column, found, likely, expected })
    }

    /// Refuses a number whose size suggests another unit.
    pub fn below(
        &self,
        column: usize,
        found: f64,
        most: f64,
        likely: &'static str,
    ) -> Result<(), TrialError> {
        if found.abs() > most { Err(self.unit(column, found, likely)) } else { Ok(()) }
    }

    /// A name; not empty.
    pub fn name(&self, column: usize) -> Result<&str, TrialError> {
        let field = self.field(column);
        if field.is_empty() {
            let column = self.table.columns[column];
            return Err(self.refuse(TrialProblem::EmptyField { column, expected: "a name" }));
        }
        Ok(field)
    }

    /// What moved the robot, by the column of that; `None` where it is empty or not there.
    pub fn backend(&self) -> Result<Option<TrialBackend>, TrialError> {
        let Some(column) = self.table.columns.iter().position(|column| *column == BACKEND) else {
            return Ok(None);
        };
        match self.field(column) {
            "" => Ok(None),
            key => match TrialBackend::from_key(key) {
                Some(backend) => Ok(Some(backend)),
                None => Err(self.refuse(TrialProblem::NoBackend { found: key.to_owned() })),
            },
        }
    }

    /// A finite number, or `None` for an empty field or a column that is not there.
    pub fn optional(&self, column: usize) -> Result<Option<f64>, TrialError> {
        let field = self.field(column);
        if field.is_empty() {
            return Ok(None);
        }
        let column = self.table.columns[column];
        let Ok(number) = field.parse::<f64>() else {
            let decimal_comma = field.replacen(',', ".", 1).parse::<f64>().is_ok();
            let found = field.to_owned();
            return Err(self.refuse(TrialProblem::NotANumber { column, found, decimal_comma }));
        };
        if !number.is_finite() {
            let found = field.to_owned();
            return Err(self.refuse(TrialProblem::NotFinite { column, found }));
        }
        Ok(Some(number))
    }

    /// A finite number.
    pub fn number(&self, column: usize) -> Result<f64, TrialError> {
        self.optional(column)?.ok_or_else(|| {
            let column = self.table.columns[column];
            self.refuse(TrialProblem::EmptyField { column, expected: "a number" })
        })
    }

    /// A finite number above zero.
    pub fn positive(&self, column: usize) -> Result<f64, TrialError> {
        let number = self.number(column)?;
        if number > 0.0 { Ok(number) } else { Err(self.out_of_range(column, number, "above 0")) }
    }

    /// A finite number that is not negative.
    pub fn not_negative(&self, column: usize) -> Result<f64, TrialError> {
        let number = self.number(column)?;
        if number >= 0.0 { Ok(number) } else { Err(self.out_of_range(column, number, "0 or more")) }
    }

    /// A whole number.
    pub fn count(&self, column: usize) -> Result<u64, TrialError> {
        let number = self.number(column)?;
        if (0.0..=MAX_COUNT).contains(&number) && number.fract() == 0.0 {
            return Ok(number as u64);
        }
        Err(self.out_of_range(column, number, "a whole number, 0 or more"))
    }
}

/// Whole numbers up to here are exact.
const MAX_COUNT: f64 = 9e15;
