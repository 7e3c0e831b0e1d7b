//! Lines of an SVG, extracted without the reader that makes plans of it: a second opinion.

use magician_formats::svg_options;
use magician_program::Diagnostic;
use resvg::tiny_skia::{PathSegment, Point};
use resvg::usvg::{self, Group, Node};

/// Pixels (96 per inch) per millimetre.
const PIXELS_PER_MM: f64 = 96.0 / 25.4;
/// Smallest number of pieces of a curve.
const MIN_PIECES: f64 = 8.0;
/// Length of a curve's hull for each further piece, mm.
const PIECE_LENGTH: f64 = 0.2;
/// Largest number of pieces of a curve.
const MAX_PIECES: f64 = 10_000.0;

/// Returns the lines of an SVG, mm, from the lower left corner of its sheet: the centre lines of
/// strokes, and the outlines of fills without a stroke.
///
/// # Errors
/// A [`Diagnostic`] if it is not an SVG.
pub fn svg_lines(svg: &[u8]) -> Result<Vec<Vec<[f64; 2]>>, Diagnostic> {
    let options = svg_options();
    let tree = usvg::Tree::from_data(svg, &options);
    let tree = tree.map_err(|error| Diagnostic::of_file(error.to_string()))?;
    let mut lines = Vec::new();
    collect_lines(tree.root(), &mut lines);
    let height = f64::from(tree.size().height());
    for point in lines.iter_mut().flatten() {
        let [x, y] = *point;
        *point = [x / PIXELS_PER_MM, (height - y) / PIXELS_PER_MM];
    }
    Ok(lines)
}

fn collect_lines(group: &Group, lines: &mut Vec<Vec<[f64; 2]>>) {
    for node in group.children() {
        match node {
            Node::Group(group) => collect_lines(group, lines),
            Node::Path(path) if path.is_visible() => {
                let shown = path.stroke().is_some() || path.fill().is_some();
                if let Some(data) = path
                    .data()
                    .clone()
                    .transform(path.abs_transform())
                    .filter(|_| shown)
                {
                    flatten_path(&data, lines);
                }
            }
            Node::Text(text) => collect_lines(text.flattened(), lines),
            Node::Path(_) | Node::Image(_) => {}
        }
    }
}

/// Flattens a path.
fn flatten_path(path: &resvg::tiny_skia::Path, lines: &mut Vec<Vec<[f64; 2]>>) {
    let (mut at, mut start) = (Point::zero(), Point::zero());
    let mut line = Vec::new();
    for segment in path.segments() {
        match segment {
            PathSegment::MoveTo(to) => {
                lines.push(std::mem::take(&mut line));
                (at, start) = (to, to);
                line.push(flat(to));
            }
            PathSegment::LineTo(to) => {
                line.push(flat(to));
                at = to;
            }
            PathSegment::QuadTo(by, to) => {
                flatten_curve(&mut line, &[at, by, to]);
                at = to;
            }
            PathSegment::CubicTo(by, then, to) => {
                flatten_curve(&mut line, &[at, by, then, to]);
                at = to;
            }
            PathSegment::Close => {
                line.push(flat(start));
                at = start;
            }
        }
    }
    lines.push(line);
    lines.retain(|line| !line.is_empty());
}

/// Flattens a Bézier curve of any degree (de Casteljau).
fn flatten_curve(line: &mut Vec<[f64; 2]>, corners: &[Point]) {
    let corners: Vec<_> = corners.iter().map(|corner| flat(*corner)).collect();
    let sides = corners.iter().zip(corners.iter().skip(1));
    let hull: f64 = sides
        .map(|(a, b)| libm::hypot(b[0] - a[0], b[1] - a[1]))
        .sum();
    let pieces = (MIN_PIECES + hull / PIXELS_PER_MM / PIECE_LENGTH)
        .min(MAX_PIECES)
        .ceil();
    for nth in 1..=pieces as u64 {
        let share = nth as f64 / pieces;
        let mut points = corners.clone();
        while points.len() > 1 {
            let next = points.iter().skip(1);
            points = (points.iter().zip(next))
                .map(|(a, b)| [0, 1].map(|axis| a[axis] + share * (b[axis] - a[axis])))
                .collect();
        }
        line.extend(points);
    }
}

fn flat(point: Point) -> [f64; 2] {
    [point.x, point.y].map(f64::from)
}
