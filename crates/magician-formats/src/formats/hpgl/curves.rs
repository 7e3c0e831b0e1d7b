//! Flattening of arcs and Bézier curves.

use kurbo::{Arc, BezPath, PathEl, Point, Shape, Vec2, flatten};

/// Share of the tolerance for each of the two steps from an arc to lines, so that both together
/// keep it.
const TOLERANCE_SHARE: f64 = 0.5;

/// Returns points along an arc without the first; `sweep` is in degrees, counter-clockwise, and
/// starts at the angle of `from`.
pub(super) fn arc(centre: [f64; 2], from: [f64; 2], sweep: f64, tolerance: f64) -> Vec<[f64; 2]> {
    let out = Vec2::new(from[0] - centre[0], from[1] - centre[1]);
    let arc = Arc {
        center: Point::new(centre[0], centre[1]),
        radii: Vec2::new(out.hypot(), out.hypot()),
        start_angle: out.atan2(),
        sweep_angle: sweep.to_radians(),
        x_rotation: 0.0,
    };
    corners(
        &arc.to_path(tolerance * TOLERANCE_SHARE),
        tolerance * TOLERANCE_SHARE,
    )
}

/// Returns points along a cubic Bézier curve without the first.
pub(super) fn curve(points: [[f64; 2]; 4], tolerance: f64) -> Vec<[f64; 2]> {
    let [a, b, c, d] = points.map(|[x, y]| Point::new(x, y));
    let mut path = BezPath::new();
    path.move_to(a);
    path.curve_to(b, c, d);
    corners(&path, tolerance)
}

fn corners(path: &BezPath, tolerance: f64) -> Vec<[f64; 2]> {
    let mut corners = Vec::new();
    flatten(path, tolerance, |piece| {
        if let PathEl::LineTo(point) = piece {
            corners.push([point.x, point.y]);
        }
    });
    corners
}
