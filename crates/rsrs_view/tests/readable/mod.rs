//! Whether a picture can be read: no line runs through a text, no text lies on another one, none leaves
//! the page. By the geometry of the tree that is drawn, letters as outlines; what lies under the ground of
//! a text, such as the circle around a letter, does not count.

use std::path::Path as FilePath;

use resvg::tiny_skia::{Path, PathSegment, Pixmap, Point, Rect, Transform};
use resvg::usvg::{Group, Node, Text, TextChunk};
use rsrs_view::raster::{parse, png};

/// What two things may share by a rounding, in pixels.
const SLACK_PX: f32 = 0.4;
/// Steps into which a curve is cut.
const CURVE_STEPS: usize = 16;

/// A text with the room that its letters take.
struct Written {
    text: String,
    room: Rect,
    /// The strokes that are drawn before its ground, if it has one.
    n_hidden: usize,
}

/// Leaves a picture in the target directory's `tmp/pictures`, to be looked at, and returns its pixels.
///
/// Asserts that every text of it can be read, and that its pixels have the same bytes again.
pub fn keep(name: &str, svg: &str, width_px: u32) -> Pixmap {
    let folder = FilePath::new(env!("CARGO_TARGET_TMPDIR")).join("pictures");
    std::fs::create_dir_all(&folder).expect("the target directory can be written");
    std::fs::write(folder.join(name).with_extension("svg"), svg).expect("as above");
    assert_readable(name, svg);
    let [png, again] = [(); 2].map(|()| png(svg, width_px).expect("the SVG can be rasterised"));
    assert!(png == again, "{name} has other bytes again");
    std::fs::write(folder.join(name).with_extension("png"), &png).expect("as above");
    let pixmap = Pixmap::decode_png(&png).expect("the PNG can be read");
    assert_eq!(pixmap.width(), width_px);
    pixmap
}

/// Asserts that every text of a picture can be read, and returns where the rightmost ends, in pixels.
pub fn assert_readable(name: &str, svg: &str) -> f32 {
    let tree = parse(svg).expect("the picture is an SVG");
    let mut found = Found::default();
    found.look_through(tree.root());
    assert!(!found.texts.is_empty(), "{name} has no text");

    let page = Rect::from_xywh(0.0, 0.0, tree.size().width(), tree.size().height());
    let page = page.expect("a page has a size");
    for (index, written) in found.texts.iter().enumerate() {
        let Written { text, room, n_hidden } = written;
        assert!(contains(page, *room), "{name}: “{text}” leaves the page: {room:?} in {page:?}");
        for other in &found.texts[index + 1..] {
            let is_apart = inner(*room).intersect(&inner(other.room)).is_none();
            assert!(is_apart, "{name}: “{text}” lies on “{}”", other.text);
        }
        for ground in found.grounds.iter().filter(|ground| ground.n_texts > index) {
            let is_apart = inner(*room).intersect(&ground.inside()).is_none();
            assert!(is_apart, "{name}: something covers “{text}” at {room:?}");
        }
        for stroke in &found.strokes[*n_hidden..] {
            assert!(
                stroke.windows(2).all(|pair| !meets(inner(*room), pair[0], pair[1])),
                "{name}: a line runs through “{text}” at {room:?}"
            );
        }
    }
    found.texts.iter().map(|written| written.room.right()).fold(0.0, f32::max)
}

/// An area that nothing shows through.
struct Ground {
    room: Rect,
    /// The strokes that are drawn before it.
    n_strokes: usize,
    /// The texts that are drawn before it.
    n_texts: usize,
}

impl Ground {
    /// A circle has no more room than this within its bounds.
    fn inside(&self) -> Rect {
        let (width, height) = (self.room.width(), self.room.height());
        self.room.inset(0.15 * width, 0.15 * height).unwrap_or(self.room)
    }
}

/// Texts and strokes of a tree, on the page.
#[derive(Default)]
struct Found {
    texts: Vec<Written>,
    strokes: Vec<Vec<Point>>,
    /// Areas that nothing shows through.
    grounds: Vec<Ground>,
}

impl Found {
    fn look_through(&mut self, group: &Group) {
        for node in group.children() {
            match node {
                Node::Group(group) => self.look_through(group),
                Node::Text(text) => self.texts.extend(self.written(text)),
                Node::Path(path) if path.is_visible() => {
                    if path.fill().is_some_and(|fill| fill.opacity().get() >= 1.0) {
                        let room = path.abs_bounding_box();
                        let (n_strokes, n_texts) = (self.strokes.len(), self.texts.len());
                        self.grounds.push(Ground { room, n_strokes, n_texts });
                    }
                    if path.stroke().is_some() {
                        self.strokes.extend(lines(path.data(), path.abs_transform()));
                    }
                }
                Node::Path(_) | Node::Image(_) => {}
            }
        }
    }

    /// A text by its letters; `None` for one that has none.
    fn written(&self, text: &Text) -> Option<Written> {
        let mut rooms = Vec::new();
        letters(text.flattened(), &mut rooms);
        // Letters know where they are in their text, and not on the page.
        let room = rooms.into_iter().reduce(around)?.transform(text.abs_transform())?;
        let grounds = self.grounds.iter().filter(|ground| contains(ground.inside(), room));
        let n_hidden = grounds.map(|ground| ground.n_strokes).max().unwrap_or(0);
        let text = text.chunks().iter().map(TextChunk::text).collect();
        Some(Written { text, room, n_hidden })
    }
}

fn around(one: Rect, other: Rect) -> Rect {
    Rect::from_ltrb(
        one.left().min(other.left()),
        one.top().min(other.top()),
        one.right().max(other.right()),
        one.bottom().max(other.bottom()),
    )
    .expect("two rooms make one")
}

fn letters(group: &Group, rooms: &mut Vec<Rect>) {
    for node in group.children() {
        match node {
            Node::Group(group) => letters(group, rooms),
            Node::Path(path) => rooms.push(path.abs_bounding_box()),
            Node::Text(_) | Node::Image(_) => {}
        }
    }
}

/// The lines of a path on the page, its curves in steps.
fn lines(path: &Path, transform: Transform) -> Vec<Vec<Point>> {
    let mut lines: Vec<Vec<Point>> = Vec::new();
    let path = path.clone().transform(transform).expect("the transform is finite");
    for segment in path.segments() {
        let last = lines.last().and_then(|line| line.last()).copied().unwrap_or_default();
        let mut add = |points: Vec<Point>| lines.last_mut().expect("a path begins").extend(points);
        match segment {
            PathSegment::MoveTo(point) => lines.push(vec![point]),
            PathSegment::LineTo(point) => add(vec![point]),
            PathSegment::QuadTo(control, end) => {
                add(curve(|t| mixed(t, mixed(t, last, control), mixed(t, control, end))));
            }
            PathSegment::CubicTo(one, other, end) => add(curve(|t| {
                let (a, b, c) = (mixed(t, last, one), mixed(t, one, other), mixed(t, other, end));
                mixed(t, mixed(t, a, b), mixed(t, b, c))
            })),
            PathSegment::Close => {
                let first = lines.last().expect("a path begins")[0];
                lines.last_mut().expect("a path begins").push(first);
            }
        }
    }
    lines
}

fn curve(at: impl Fn(f32) -> Point) -> Vec<Point> {
    (1..=CURVE_STEPS).map(|step| at(step as f32 / CURVE_STEPS as f32)).collect()
}

fn mixed(share: f32, from: Point, to: Point) -> Point {
    Point::from_xy(from.x + share * (to.x - from.x), from.y + share * (to.y - from.y))
}

fn inner(room: Rect) -> Rect {
    room.inset(SLACK_PX, SLACK_PX).unwrap_or(room)
}

fn contains(page: Rect, room: Rect) -> bool {
    page.left() <= room.left()
        && room.right() <= page.right()
        && page.top() <= room.top()
        && room.bottom() <= page.bottom()
}

/// Whether a segment meets a rectangle, by Liang and Barsky's parameters of entry and exit.
fn meets(room: Rect, from: Point, to: Point) -> bool {
    let (dx, dy) = (to.x - from.x, to.y - from.y);
    let (mut enter, mut leave) = (0.0_f32, 1.0_f32);
    for (towards, way) in [
        (-dx, from.x - room.left()),
        (dx, room.right() - from.x),
        (-dy, from.y - room.top()),
        (dy, room.bottom() - from.y),
    ] {
        if towards < 0.0 {
            enter = enter.max(way / towards);
        } else if towards > 0.0 {
            leave = leave.min(way / towards);
        } else if way < 0.0 {
            return false;
        }
    }
    enter < leave
}
