//! Tables: each column as wide as its widest cell, two spaces apart.

use crate::words::Words;

/// Rows as columns; all rows have as many cells.
pub fn columns<R: AsRef<[String]>>(rows: &[R]) -> String {
    let words = |row: &R| -> Vec<Words> { row.as_ref().iter().map(Words::from).collect() };
    let rows: Vec<Vec<Words>> = rows.iter().map(words).collect();
    toned_columns(&rows).to_string()
}

/// Rows as columns, with the tones of their cells.
pub fn toned_columns<R: AsRef<[Words]>>(rows: &[R]) -> Words {
    // A cell is one line, also where its text is somebody else's.
    let on_one_line =
        |row: &R| -> Vec<Words> { row.as_ref().iter().map(Words::on_one_line).collect() };
    let rows: Vec<Vec<Words>> = rows.iter().map(on_one_line).collect();
    let n_columns = rows.first().map_or(0, Vec::len);
    let width = |column: usize| rows.iter().map(|row| row[column].width()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..n_columns).map(width).collect();
    let line = |row: Vec<Words>| {
        let cells = row.into_iter().zip(&widths).map(|(cell, width)| {
            let gap = " ".repeat(width - cell.width() + 2);
            cell.then(gap)
        });
        cells.reduce(Words::then).unwrap_or_default().trimmed()
    };
    Words::lines(rows.into_iter().map(line))
}
