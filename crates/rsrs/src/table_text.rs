//! Tables in a terminal.

/// Rows as columns: each as wide as its widest field, two spaces apart.
pub fn columns<const N: usize>(rows: &[[String; N]]) -> String {
    let mut widths = [0; N];
    for row in rows {
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
