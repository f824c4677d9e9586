//! Tables: each column as wide as its widest cell, two spaces apart.

use crate::words::Words;

/// Rows as columns.
pub fn columns<const N: usize>(rows: &[[String; N]]) -> String {
    let rows: Vec<[Words; N]> = rows.iter().map(|row| row.each_ref().map(Words::from)).collect();
    toned_columns(&rows).to_string()
}

/// Rows as columns, with the tones of their cells.
pub fn toned_columns<const N: usize>(rows: &[[Words; N]]) -> Words {
    // A cell is one line, also where its text is somebody else's.
    let rows: Vec<[Words; N]> =
        rows.iter().map(|row| row.each_ref().map(Words::on_one_line)).collect();
    let mut widths = [0; N];
    for row in &rows {
        for (width, cell) in widths.iter_mut().zip(row) {
            *width = (*width).max(cell.width());
        }
    }
    let line = |row: [Words; N]| {
        let cells = row.into_iter().zip(widths).map(|(cell, width)| {
            let gap = " ".repeat(width - cell.width() + 2);
            cell.then(gap)
        });
        cells.reduce(Words::then).unwrap_or_default().trimmed()
    };
    Words::lines(rows.into_iter().map(line))
}
