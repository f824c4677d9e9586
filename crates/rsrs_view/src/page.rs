//! A page of HTML that needs no other file: headings, tables and pictures.

use maud::{DOCTYPE, Markup, PreEscaped, html};

use crate::svg::inline;

/// How pages look, on a screen and on paper.
const STYLE: &str = include_str!("../assets/page.css");
/// A page asks for nothing from elsewhere, whatever is on it.
const POLICY: &str = "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'";
/// A page that holds [`crate::simulator::PAGE`] lets that, which is under the same policy, start its threads.
pub(crate) const SIMULATING: &str = " 'wasm-unsafe-eval' blob:; worker-src blob:";

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
    title: String,
    body: Vec<Markup>,
}

/// Names of columns, and rows of as many texts each.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    /// What it shows, for screen readers and as its caption; any text.
    pub caption: String,
    /// Names of the columns; any texts.
    pub head: Vec<String>,
    /// Any texts; shape `[n_rows][n_columns]`.
    pub rows: Vec<Vec<String>>,
}

impl Page {
    /// A page with a title, which is also its first heading.
    pub fn new(title: &str) -> Self {
        Self { title: title.to_owned(), body: Vec::new() }
    }

    /// Adds the heading of a section.
    pub fn heading(&mut self, text: &str) {
        self.body.push(html! { h2 { (text) } });
    }

    /// Adds a paragraph.
    pub fn paragraph(&mut self, text: &str) {
        self.body.push(html! { p { (text) } });
    }

    /// Adds a table.
    pub fn table(&mut self, of: &Table) {
        self.body.push(table(of));
    }

    /// Adds a picture, an SVG document of this crate.
    pub fn figure(&mut self, svg: &str) {
        self.body.push(html! { figure { (picture(svg)) } });
    }

    /// Adds pictures (SVG documents) with lines of text below each, side by side, as many as the
    /// width has room for.
    pub fn figures(&mut self, pictures: &[(String, Vec<String>)]) {
        self.body.push(html! {
            div.gallery {
                @for (svg, caption) in pictures {
                    figure {
                        (picture(svg))
                        figcaption { @for line in caption { (line) br; } }
                    }
                }
            }
        });
    }

    /// Adds a text that is shown on demand, line by line as it is.
    pub fn details(&mut self, summary: &str, text: &str) {
        self.body.push(details(summary, text));
    }

    /// The whole page.
    pub fn finish(self) -> String {
        document((&self.title, ""), &html! { @for part in &self.body { (part) } }, &html! {})
    }
}

/// A whole document, with its title as first heading too. At its end may stand data and script;
/// what scripts may do beyond [`POLICY`] is `more`.
pub(crate) fn document((title, more): (&str, &str), body: &Markup, end: &Markup) -> String {
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                meta http-equiv="Content-Security-Policy" content={ (POLICY) (more) };
                title { (title) }
                style { (PreEscaped(STYLE)) }
            }
            body {
                main {
                    h1 { (title) }
                    (body)
                }
                (end)
            }
        }
    };
    page.into_string()
}

/// A picture of this crate.
pub(crate) fn picture(svg: &str) -> Markup {
    html! { div.picture { (PreEscaped(inline(svg.trim_end()))) } }
}

/// A table that is scrolled where it is wider than the page.
pub(crate) fn table(table: &Table) -> Markup {
    html! {
        div.scrolled tabindex="0" role="region" aria-label=(table.caption) {
            table {
                caption { (table.caption) }
                thead { tr { @for name in &table.head { th scope="col" { (name) } } } }
                tbody {
                    @for row in &table.rows { tr { @for text in row { td { (text) } } } }
                }
            }
        }
    }
}

/// A text that is shown on demand.
pub(crate) fn details(summary: &str, text: &str) -> Markup {
    html! {
        details {
            summary { (summary) }
            pre tabindex="0" { (text) }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_that_a_person_wrote_becomes_markup() {
        let mut page = Page::new("<title> & \"co\"");
        page.heading("<h>");
        let rows = vec![vec!["<script>".to_owned()]];
        page.table(&Table { caption: "\"<c>".to_owned(), head: vec!["<a>".to_owned()], rows });
        page.figure("<svg></svg>");
        page.figures(&[("<svg/>".to_owned(), vec!["<f>".to_owned()])]);
        page.details("<s>", "</pre>");

        let html = page.finish();

        for markup in ["<title> &", "<h>", "<a>", "<c>", "<f>", "<script>", "<s>", "</pre></pre>"] {
            assert!(!html.contains(markup), "{markup} in {html}");
        }
        assert!(html.contains("<svg></svg>"), "{html}");
    }

    #[test]
    fn a_page_asks_for_nothing_from_elsewhere() {
        let html = Page::new("report").finish();

        for reference in ["http:", "https:", "src=", "href=", "@import", "url("] {
            assert!(!html.contains(reference), "{reference} in {html}");
        }
    }
}
