//! A report as one HTML file that needs no other: headings, tables and pictures.

use std::fmt::Write;

use crate::svg::escaped;

/// How it looks, on a screen and on paper.
const STYLE: &str = "\
body{font:16px/1.5 'DejaVu Sans',Verdana,Geneva,sans-serif;color:#1b2733;max-width:62rem;\
margin:2rem auto;padding:0 1rem}\
h1{font-size:1.6rem}h2{font-size:1.25rem;margin-top:2.5rem}\
table{border-collapse:collapse;margin:1rem 0;font-size:.9rem}\
th,td{text-align:left;padding:.25rem .75rem .25rem 0;border-bottom:1px solid #d5dce2;\
vertical-align:top}\
figure{margin:1rem 0}figcaption{font-size:.9rem}svg{max-width:100%;height:auto}\
.runs{display:flex;flex-wrap:wrap;gap:1.5rem}.runs figure{flex:1 1 22rem;min-width:0}\
pre{background:#f4f6f8;padding:1rem;overflow-x:auto;font-size:.8rem}\
@media print{figure{break-inside:avoid}}";

/// A page that is being written; every text is escaped, and only pictures of this crate go in as
/// they are.
///
/// # Example
///
/// ```
/// use rsrs_view::page::Page;
///
/// let mut page = Page::new("Monday's runs");
/// page.paragraph("3 < 4");
/// let html = page.finish();
///
/// assert!(html.starts_with("<!DOCTYPE html>"));
/// assert!(html.contains("<p>3 &lt; 4</p>"));
/// ```
#[derive(Clone, Debug)]
pub struct Page {
    html: String,
}

impl Page {
    /// A page with a title, which is also its first heading.
    pub fn new(title: &str) -> Self {
        let title = escaped(title);
        Self {
            html: format!(
                "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
                 <meta name=\"viewport\" content=\"width=device-width\">\n<title>{title}</title>\n\
                 <style>{STYLE}</style>\n</head>\n<body>\n<h1>{title}</h1>\n"
            ),
        }
    }

    /// Adds the heading of a section.
    pub fn heading(&mut self, text: &str) {
        self.line(&format!("<h2>{}</h2>", escaped(text)));
    }

    /// Adds a paragraph.
    pub fn paragraph(&mut self, text: &str) {
        self.line(&format!("<p>{}</p>", escaped(text)));
    }

    /// Adds a table.
    ///
    /// # Arguments
    ///
    /// * `head` — names of the columns.
    /// * `rows` — texts, as many in each row as there are columns; shape `[n_rows][n_columns]`.
    pub fn table<const N: usize>(&mut self, head: [&str; N], rows: &[[String; N]]) {
        let cells = |tag: &str, texts: &[&str]| -> String {
            let cell = |text: &&str| format!("<{tag}>{}</{tag}>", escaped(text));
            texts.iter().map(cell).collect::<Vec<_>>().concat()
        };
        self.line(&format!("<table>\n<tr>{}</tr>", cells("th", &head)));
        for row in rows {
            let texts: Vec<&str> = row.iter().map(String::as_str).collect();
            self.line(&format!("<tr>{}</tr>", cells("td", &texts)));
        }
        self.line("</table>");
    }

    /// Adds a picture.
    ///
    /// # Arguments
    ///
    /// * `svg` — a document of this crate.
    /// * `caption` — lines of text below it.
    pub fn figure(&mut self, svg: &str, caption: &[String]) {
        let lines: Vec<String> = caption.iter().map(|line| escaped(line)).collect();
        let caption = lines.join("<br>\n");
        self.line(&format!(
            "<figure>\n{}\n<figcaption>{caption}</figcaption>\n</figure>",
            svg.trim_end()
        ));
    }

    /// Adds pictures side by side, as many as the width has room for.
    ///
    /// # Arguments
    ///
    /// * `pictures` — SVG and caption of each, as for [`Self::figure`].
    pub fn figures(&mut self, pictures: &[(String, Vec<String>)]) {
        self.line("<div class=\"runs\">");
        for (svg, caption) in pictures {
            self.figure(svg, caption);
        }
        self.line("</div>");
    }

    /// Adds a text that is shown on demand, line by line as it is.
    pub fn details(&mut self, summary: &str, text: &str) {
        self.line(&format!(
            "<details>\n<summary>{}</summary>\n<pre>{}</pre>\n</details>",
            escaped(summary),
            escaped(text)
        ));
    }

    /// The whole page.
    pub fn finish(mut self) -> String {
        self.line("</body>\n</html>");
        self.html
    }

    fn line(&mut self, text: &str) {
        writeln!(self.html, "{text}").expect("a string takes any text");
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_that_a_person_wrote_becomes_markup() {
        let mut page = Page::new("<title> & \"co\"");
        page.heading("<h>");
        page.table(["<a>"], &[["<script>".to_owned()]]);
        page.figure("<svg></svg>", &["<img>".to_owned()]);
        page.details("<s>", "</pre>");

        let html = page.finish();

        for markup in ["<title> &", "<h>", "<a>", "<script>", "<img>", "<s>", "</pre></pre>"] {
            assert!(!html.contains(markup), "{markup} in {html}");
        }
        assert!(html.contains("<figure>\n<svg></svg>\n<figcaption>&lt;img&gt;"), "{html}");
    }

    #[test]
    fn a_page_asks_for_nothing_from_elsewhere() {
        let html = Page::new("report").finish();

        for reference in ["http", "src=", "href=", "@import", "url("] {
            assert!(!html.contains(reference), "{reference} in {html}");
        }
    }
}
