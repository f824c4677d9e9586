//! Places and polygons in the plane; polygons go around by their corners.

/// A place, or a way from one to another, along x and y.
pub type Point = [f64; 2];

/// Both ways, one after the other.
#[inline]
pub fn plus(one: Point, other: Point) -> Point {
    [one[0] + other[0], one[1] + other[1]]
}

/// The way to one place from another.
#[inline]
pub fn minus(one: Point, other: Point) -> Point {
    [one[0] - other[0], one[1] - other[1]]
}

/// The place some share of the way from one to another.
#[inline]
pub fn between(from: Point, to: Point, share: f64) -> Point {
    [from[0] + share * (to[0] - from[0]), from[1] + share * (to[1] - from[1])]
}

/// The scalar product.
#[inline]
pub fn dot(one: Point, other: Point) -> f64 {
    one[0] * other[0] + one[1] * other[1]
}

/// The vector product: above 0 if the other way turns left from the one.
#[inline]
pub fn cross(one: Point, other: Point) -> f64 {
    one[0] * other[1] - one[1] * other[0]
}

/// How far a place is to the left of a side, from 0 on the line through it: twice the area of the
/// triangle of both.
#[inline]
pub fn left_of([from, to]: [Point; 2], place: Point) -> f64 {
    cross(minus(to, from), minus(place, from))
}

/// The sides of a polygon, the last one back to the first corner.
pub fn sides(corners: &[Point]) -> impl Iterator<Item = [Point; 2]> + '_ {
    let next = corners.iter().cycle().skip(1);
    corners.iter().zip(next).map(|(from, to)| [*from, *to])
}

/// Area of a simple polygon; positive if counterclockwise.
pub fn area(corners: &[Point]) -> f64 {
    sides(corners).map(|[from, to]| cross(from, to)).sum::<f64>() / 2.0
}
