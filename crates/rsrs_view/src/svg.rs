//! SVG as a tree of elements: escaped texts, fixed decimals, one element a line.

use std::fmt;

/// The fonts of every picture. All but the last have about the widths that [`crate::text`] assumes.
const FONT_FAMILY: &str = "DejaVu Sans, Verdana, Bitstream Vera Sans, Geneva, sans-serif";

/// The attribute that an SVG needs in a file of its own, and not within HTML.
const NAMESPACE: &str = "http://www.w3.org/2000/svg";

/// The class of what keeps its colours on a dark page: it lies on colours of its own.
const FIXED: &str = "fixed";

/// One element with its attributes and children.
#[derive(Clone, Debug)]
pub struct Element {
    name: &'static str,
    attributes: Vec<(&'static str, String)>,
    children: Vec<Node>,
}

#[derive(Clone, Debug)]
enum Node {
    Element(Element),
    Text(String),
}

impl Element {
    /// An element without attributes and children.
    pub fn new(name: &'static str) -> Self {
        Self { name, attributes: Vec::new(), children: Vec::new() }
    }

    /// A circle by its centre and radius, in pixels.
    pub fn circle((x_px, y_px): (f64, f64), radius_px: f64) -> Self {
        Self::new("circle").at("cx", x_px).at("cy", y_px).at("r", radius_px)
    }

    /// A path by its commands.
    pub fn path(commands: &str) -> Self {
        Self::new("path").with("d", commands)
    }

    /// A whole picture on white, with its name for screen readers.
    pub fn picture(width_px: f64, height_px: f64, title: &str) -> Self {
        let background = rectangle(0.0, 0.0, width_px, height_px).with("fill", "#ffffff");
        Self::new("svg")
            .with("xmlns", NAMESPACE)
            .at("width", width_px)
            .at("height", height_px)
            .with("viewBox", &format!("0 0 {} {}", number(width_px), number(height_px)))
            .with("role", "img")
            .with("font-family", FONT_FAMILY)
            .child(Self::new("title").text(title))
            .child(background)
    }

    /// Adds what a reader of the file finds and the picture does not show; nothing for an empty text.
    pub fn described(self, details: &str) -> Self {
        let description = (!details.is_empty()).then(|| Self::new("desc").text(details));
        self.children(description)
    }

    /// Keeps its colours on a dark page, with all that is inside it.
    pub fn fixed(self) -> Self {
        self.with("class", FIXED)
    }

    /// Adds an attribute; its value is escaped.
    pub fn with(mut self, name: &'static str, value: &str) -> Self {
        self.attributes.push((name, escaped(value)));
        self
    }

    /// Adds a numeric attribute, in pixels.
    pub fn at(self, name: &'static str, value_px: f64) -> Self {
        let value = number(value_px);
        self.with(name, &value)
    }

    /// Draws its outline, in pixels.
    pub fn stroked(self, colour: &str, width_px: f64) -> Self {
        self.with("stroke", colour).at("stroke-width", width_px)
    }

    /// Draws its outline and nothing else, in pixels.
    pub fn outlined(self, colour: &str, width_px: f64) -> Self {
        self.with("fill", "none").stroked(colour, width_px)
    }

    /// Fills it with what shows through.
    pub fn filled(self, colour: &str, opacity: &str) -> Self {
        self.with("fill", colour).with("fill-opacity", opacity)
    }

    /// Letters of a size in pixels, and a colour.
    pub fn lettered(self, size_px: f64, colour: &str) -> Self {
        self.at("font-size", size_px).with("fill", colour)
    }

    /// Bold letters of a size in pixels, and a colour.
    pub fn bold(self, size_px: f64, colour: &str) -> Self {
        self.at("font-size", size_px).with("font-weight", "bold").with("fill", colour)
    }

    /// Adds the text that shows where the pointer rests on it.
    pub fn titled(self, title: &str) -> Self {
        self.child(Self::new("title").text(title))
    }

    /// Moves it, with all that is inside it, in pixels.
    pub fn moved(self, (x_px, y_px): (f64, f64)) -> Self {
        self.with("transform", &format!("translate({} {})", number(x_px), number(y_px)))
    }

    /// Adds an element inside this one.
    pub fn child(mut self, child: Self) -> Self {
        self.children.push(Node::Element(child));
        self
    }

    /// Adds elements inside this one.
    pub fn children(mut self, children: impl IntoIterator<Item = Self>) -> Self {
        self.children.extend(children.into_iter().map(Node::Element));
        self
    }

    /// Adds text inside this element; it is escaped.
    pub fn text(mut self, text: &str) -> Self {
        self.children.push(Node::Text(escaped(text)));
        self
    }

    fn write(&self, out: &mut fmt::Formatter<'_>, depth: usize) -> fmt::Result {
        write!(out, "<{}", self.name)?;
        for (name, value) in &self.attributes {
            write!(out, " {name}=\"{value}\"")?;
        }
        if self.children.is_empty() {
            return write!(out, "/>");
        }
        write!(out, ">")?;
        // White space between elements means nothing, but inside a text it shows.
        let is_text = self.children.iter().any(|child| matches!(child, Node::Text(_)));
        for child in &self.children {
            if !is_text {
                write!(out, "\n{:1$}", "", 2 * (depth + 1))?;
            }
            match child {
                Node::Element(element) => element.write(out, depth + 1)?,
                Node::Text(text) => out.write_str(text)?,
            }
        }
        if !is_text {
            write!(out, "\n{:1$}", "", 2 * depth)?;
        }
        write!(out, "</{}>", self.name)
    }
}

impl fmt::Display for Element {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.write(formatter, 0)
    }
}

/// A document of this crate as it stands within HTML, which accepts SVG without a namespace.
pub fn inline(svg: &str) -> String {
    svg.replacen(&format!(" xmlns=\"{NAMESPACE}\""), "", 1)
}

/// The same picture as wide as asked for, in pixels, and as high as that makes it; the whole of it is
/// larger or smaller.
pub fn resized(svg: &str, width_px: f64) -> String {
    let size = |name: &str| -> Option<(std::ops::Range<usize>, f64)> {
        let from = svg.find(&format!(" {name}=\""))? + name.len() + 3;
        let to = from + svg[from..].find('"')?;
        Some((from..to, svg[from..to].parse().ok()?))
    };
    let (Some((wide, old_px)), Some((high, height_px))) = (size("width"), size("height")) else {
        return svg.to_owned();
    };
    let height = number(height_px * width_px / old_px);
    [&svg[..wide.start], &number(width_px), &svg[wide.end..high.start], &height, &svg[high.end..]]
        .concat()
}

/// The commands of a path along points, in pixels.
pub fn through(points: impl IntoIterator<Item = (f64, f64)>) -> String {
    let places: Vec<String> =
        points.into_iter().map(|(x, y)| format!("{} {}", number(x), number(y))).collect();
    format!("M{}", places.join("L"))
}

/// A rectangle by its upper left corner, in pixels.
pub fn rectangle(x_px: f64, y_px: f64, width_px: f64, height_px: f64) -> Element {
    Element::new("rect").at("x", x_px).at("y", y_px).at("width", width_px).at("height", height_px)
}

/// A line of text whose baseline starts at this point, in pixels.
pub fn line_of_text(x_px: f64, y_px: f64, text: &str) -> Element {
    Element::new("text").at("x", x_px).at("y", y_px).text(text)
}

/// A line of text about this point of its baseline, in pixels.
pub fn centred_text(x_px: f64, y_px: f64, text: &str) -> Element {
    line_of_text(x_px, y_px, text).with("text-anchor", "middle")
}

/// A number as it stands in attributes and paths: two decimals, no trailing zeros, no minus zero.
///
/// # Panics
///
/// If the number is not finite: data are checked before anything is drawn.
pub fn number(value: f64) -> String {
    assert!(value.is_finite(), "{value} cannot be drawn");
    let fixed = format!("{value:.2}");
    let short = fixed.trim_end_matches('0').trim_end_matches('.');
    if short == "-0" { "0".to_owned() } else { short.to_owned() }
}

/// Escapes what XML reads as markup, and replaces what XML 1.0 cannot hold at all.
pub fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&apos;"),
            '\n' | '\t' => out.push(character),
            '\u{fffe}' | '\u{ffff}' => out.push('\u{fffd}'),
            _ if character.is_control() => out.push('\u{fffd}'),
            _ => out.push(character),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_and_never_minus_zero() {
        assert_eq!(number(10.0), "10");
        assert_eq!(number(0.125), "0.12");
        assert_eq!(number(-0.001), "0");
        assert_eq!(number(100.0), "100");
        assert_eq!(number(-2.5), "-2.5");
    }

    #[test]
    fn markup_in_texts_and_attributes_is_escaped() {
        let element = Element::new("g").with("id", "\"a'").text("<b> & \u{1b}");

        assert_eq!(element.to_string(), "<g id=\"&quot;a&apos;\">&lt;b&gt; &amp; \u{fffd}</g>");
    }
}
