//! Plane polygons, corner by corner.

/// Area of a simple polygon, in square metres; positive if counterclockwise.
pub fn area_m2(polygon_m: &[[f64; 2]]) -> f64 {
    let corners = polygon_m.iter().zip(polygon_m.iter().cycle().skip(1));
    corners.map(|([x, y], [next_x, next_y])| (x * next_y - next_x * y) / 2.0).sum()
}

/// Whether a point lies in a convex, counterclockwise polygon, or on its border.
pub(crate) fn contains(polygon_m: &[[f64; 2]], [x_m, y_m]: [f64; 2]) -> bool {
    (0..polygon_m.len()).all(|corner| {
        let [from_x, from_y] = polygon_m[corner];
        let [to_x, to_y] = polygon_m[(corner + 1) % polygon_m.len()];
        (to_x - from_x) * (y_m - from_y) - (to_y - from_y) * (x_m - from_x) >= -1e-9
    })
}
