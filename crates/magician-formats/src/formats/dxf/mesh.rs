//! Meshes: the edges of their faces, each drawn once.

use std::collections::HashSet;

use kurbo::{Affine, Point};
use magician_host::message;

use super::canvas::Canvas;
use super::pairs::Record;
use crate::Diagnostic;

/// Flags of a POLYLINE for a mesh closed in the M and in the N direction.
const CLOSED_FLAGS: [i64; 2] = [1, 32];
/// Flag of a vertex: it is a face of a polyface mesh.
const FACE_FLAG: i64 = 128;
/// Flag of a vertex that has coordinates; flag of a POLYLINE that is a polyface mesh.
const COORDINATES_FLAG: i64 = 64;
/// Flag of a vertex that is a control point. The smooth surface has separate vertices.
const CONTROL_POINT_FLAG: i64 = 16;

/// Draws the mesh of a POLYLINE, either a grid or a list of faces.
pub(super) fn draw<'p>(
    canvas: &mut Canvas<'p>,
    record: &'p Record<'p>,
    vertices: &'p [Record<'p>],
    layer: &'p str,
    map: Affine,
) -> Result<(), Diagnostic> {
    let flags = record.integer(70)?;
    let mut points = Vec::new();
    let mut faces = Vec::new();
    for vertex in vertices {
        let kind = vertex.integer(70)?;
        if kind & CONTROL_POINT_FLAG != 0 {
            continue;
        }
        if kind & FACE_FLAG != 0 && kind & COORDINATES_FLAG == 0 {
            faces.push(vertex);
        } else {
            let [x, y, _] = vertex.point(10)?;
            points.push(map * Point::new(x, y));
        }
    }
    let pairs = if flags & COORDINATES_FLAG != 0 {
        edges_of(&faces)?
    } else {
        // A smoothed surface has its own numbers of rows and columns.
        let count = |normal_code, smooth_code| match record.integer(smooth_code)? {
            0 => record.integer(normal_code),
            count => Ok(count),
        };
        let counts = [count(71, 73)?, count(72, 74)?];
        grid(
            counts,
            CLOSED_FLAGS.map(|flag| flags & flag != 0),
            points.len(),
        )
    };
    let mut drawn = HashSet::new();
    for [from, to] in pairs {
        let (Some(one), Some(other)) = (points.get(from), points.get(to)) else {
            continue;
        };
        if drawn.insert([from.min(to), from.max(to)]) {
            canvas.stroke(vec![*one, *other], record, layer)?;
        }
    }
    if drawn.is_empty() {
        canvas.leave_out(record, message!("its mesh has no edges"))
    } else {
        Ok(())
    }
}

/// Returns the edges of faces. Corner indices count from 1, and a negative one hides the edge after
/// it.
fn edges_of(faces: &[&Record<'_>]) -> Result<Vec<[usize; 2]>, Diagnostic> {
    let mut edges = Vec::new();
    for face in faces {
        let mut corners = Vec::new();
        for code in 71..=74 {
            let corner = face.integer(code)?;
            if corner != 0 {
                corners.push(corner);
            }
        }
        let next = corners.iter().cycle().skip(1);
        let visible = corners.iter().zip(next).filter(|(from, _)| **from > 0);
        let index = |corner: i64| usize::try_from(corner.unsigned_abs() - 1).unwrap_or(usize::MAX);
        edges.extend(visible.map(|(from, to)| [*from, *to].map(index)));
    }
    Ok(edges)
}

/// Returns the edges between neighbours in a grid.
fn grid([rows, columns]: [i64; 2], closed: [bool; 2], vertex_count: usize) -> Vec<[usize; 2]> {
    let [rows, columns] = [rows, columns].map(|count| usize::try_from(count).unwrap_or(0));
    if rows
        .checked_mul(columns)
        .is_none_or(|count| count > vertex_count)
    {
        return Vec::new();
    }
    let mut edges = Vec::new();
    for row in 0..rows {
        for column in 0..columns {
            let at = |row: usize, column: usize| row % rows * columns + column % columns;
            if row + 1 < rows || closed[0] {
                edges.push([at(row, column), at(row + 1, column)]);
            }
            if column + 1 < columns || closed[1] {
                edges.push([at(row, column), at(row, column + 1)]);
            }
        }
    }
    edges.retain(|[from, to]| from != to);
    edges
}
