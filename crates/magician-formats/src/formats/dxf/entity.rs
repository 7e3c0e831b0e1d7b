//! Drawing of single entities.

use kurbo::{Affine, Point, Vec2};
use magician_host::message;

use super::canvas::{Canvas, InsertContext};
use super::curve::{self, Ellipse};
use super::pairs::Record;
use super::spline::{Spline, interpolated};
use super::{hatch, leader, mesh, mtext, text};
use crate::Diagnostic;

type DrawResult = Result<(), Diagnostic>;

/// Draws an entity, or adds a note with the reason why it is not drawn. `vertices` are those of a
/// POLYLINE.
pub(super) fn draw<'p>(
    canvas: &mut Canvas<'p>,
    record: &'p Record<'p>,
    vertices: &'p [Record<'p>],
    layer: &'p str,
    context: &InsertContext<'p>,
) -> DrawResult {
    let painter = EntityPainter {
        record,
        layer,
        map: context.map,
    };
    match record.kind {
        "LINE" => painter.line(canvas, &[10, 11], false),
        "POINT" => painter.line(canvas, &[10], false),
        "CIRCLE" => painter.arc(canvas, true),
        "ARC" => painter.arc(canvas, false),
        "ELLIPSE" => painter.ellipse(canvas),
        "LWPOLYLINE" => painter.light_polyline(canvas),
        "POLYLINE" => painter.polyline(canvas, vertices),
        "SPLINE" | "HELIX" => painter.spline(canvas),
        "SOLID" | "TRACE" => painter.solid(canvas),
        "3DFACE" => painter.face(canvas),
        "TEXT" => text::text(canvas, record, layer, context),
        // Bit 1 hides an attribute.
        "ATTRIB" if record.integer(70)? & 1 == 0 => text::text(canvas, record, layer, context),
        // Within a block an attribute definition is a template for the texts of each insert, unless
        // it is constant.
        "ATTDEF" if record.integer(70)? & 1 == 0 && !context.is_in_block() => {
            text::text(canvas, record, layer, context)
        }
        "ATTRIB" | "ATTDEF" => Ok(()),
        "MTEXT" => mtext::draw(canvas, record, layer, context),
        "HATCH" | "MPOLYGON" => hatch::draw(canvas, record, layer, context),
        "LEADER" => leader::leader(canvas, record, layer, context),
        "MULTILEADER" | "MLEADER" => leader::multileader(canvas, record, layer, context),
        _ => canvas.leave_out(record, message!("this kind of entity is not drawn")),
    }
}

/// Transform from an entity's object coordinate system (OCS), at a height above its plane, to the
/// drawing seen from above. The plane is given by its normal, and its x axis by the arbitrary axis
/// algorithm of the DXF Reference.
pub(super) fn plane(record: &Record<'_>, height: f64) -> Result<Affine, Diagnostic> {
    let normal = normal(record)?;
    let [nx, ny, nz] = normal;
    let near_z = nx.abs() < 1.0 / 64.0 && ny.abs() < 1.0 / 64.0;
    let [ax, ay, az] = unit(if near_z {
        [nz, 0.0, -nx]
    } else {
        [-ny, nx, 0.0]
    });
    let [bx, by] = [ny * az - nz * ay, nz * ax - nx * az];
    Ok(Affine::new([ax, ay, bx, by, nx * height, ny * height]))
}

fn normal(record: &Record<'_>) -> Result<[f64; 3], Diagnostic> {
    let [x, y, z] = [210, 220, 230].map(|code| record.number(code));
    Ok(unit([
        x?.unwrap_or(0.0),
        y?.unwrap_or(0.0),
        z?.unwrap_or(1.0),
    ]))
}

/// Normalises a vector; +z if it has no direction.
fn unit(vector: [f64; 3]) -> [f64; 3] {
    let greatest = vector
        .iter()
        .fold(0.0, |most, value| f64::max(most, value.abs()));
    if greatest == 0.0 {
        return [0.0, 0.0, 1.0];
    }
    let [x, y, z] = vector.map(|value| value / greatest);
    let length = libm::hypot(libm::hypot(x, y), z);
    [x / length, y / length, z / length]
}

/// Entity to draw, with its layer and its transform to mm.
struct EntityPainter<'p> {
    record: &'p Record<'p>,
    layer: &'p str,
    map: Affine,
}

impl<'p> EntityPainter<'p> {
    fn stroke(&self, canvas: &mut Canvas<'p>, points: Vec<Point>) -> DrawResult {
        canvas.stroke(points, self.record, self.layer)
    }

    /// Draws straight lines through the points with these group codes; if `closed`, back to the
    /// first point.
    fn line(&self, canvas: &mut Canvas<'p>, codes: &[i32], closed: bool) -> DrawResult {
        let mut points = Vec::new();
        for code in codes {
            let [x, y, _] = self.record.point(*code)?;
            points.push(self.map * Point::new(x, y));
        }
        if closed {
            points.extend(points.first().copied());
        }
        self.stroke(canvas, points)
    }

    /// Draws a filled shape of three or four corners, which the file lists crosswise.
    fn solid(&self, canvas: &mut Canvas<'p>) -> DrawResult {
        let fourth = self.record.text(13).map_or(12, |_| 13);
        let mut points = Vec::new();
        for code in [10, 11, fourth, 12] {
            let [x, y, z] = self.record.point(code)?;
            points.push(self.map * plane(self.record, z)? * Point::new(x, y));
        }
        canvas.area(vec![points], self.record, self.layer)
    }

    /// Draws the edges of a face, except the invisible ones.
    fn face(&self, canvas: &mut Canvas<'p>) -> DrawResult {
        let hidden_edges = self.record.integer(70)?;
        if hidden_edges & 15 == 0 {
            return self.line(canvas, &[10, 11, 12, 13], true);
        }
        for (nth, codes) in [[10, 11], [11, 12], [12, 13], [13, 10]].iter().enumerate() {
            if hidden_edges & (1 << nth) == 0 {
                self.line(canvas, codes, false)?;
            }
        }
        Ok(())
    }

    fn arc(&self, canvas: &mut Canvas<'p>, whole: bool) -> DrawResult {
        let [x, y, z] = self.record.point(10)?;
        let radius = self.record.needed(40)?;
        let (from, sweep) = if whole {
            (0.0, std::f64::consts::TAU)
        } else {
            let [from, to] = [self.record.needed(50)?, self.record.needed(51)?];
            let [from, to] = [from, to].map(|angle| angle.rem_euclid(360.0).to_radians());
            (from, curve::sweep(from, to))
        };
        let map = self.map * plane(self.record, z)?;
        let arc = Ellipse::circle(&map, Point::new(x, y), radius, from, sweep);
        self.stroke(canvas, arc.points(canvas.chords))
    }

    fn ellipse(&self, canvas: &mut Canvas<'p>) -> DrawResult {
        let [x, y, _] = self.record.point(10)?;
        let [major_x, major_y, major_z] = self.record.point(11)?;
        let ratio = self.record.needed(40)?;
        let from = self.record.number(41)?.unwrap_or(0.0);
        let to = self.record.number(42)?.unwrap_or(std::f64::consts::TAU);
        let [nx, ny, nz] = normal(self.record)?;
        // The cross product of normal and major axis is the minor axis, seen from above.
        let minor = Vec2::new(ny * major_z - nz * major_y, nz * major_x - nx * major_z) * ratio;
        let middle = Point::new(x, y);
        let centre = self.map * middle;
        let ellipse = Ellipse {
            centre,
            one: self.map * (middle + Vec2::new(major_x, major_y)) - centre,
            other: self.map * (middle + minor) - centre,
            from,
            sweep: curve::sweep(from, to),
        };
        self.stroke(canvas, ellipse.points(canvas.chords))
    }

    fn light_polyline(&self, canvas: &mut Canvas<'p>) -> DrawResult {
        let height = self.record.number(38)?.unwrap_or(0.0);
        let map = self.map * plane(self.record, height)?;
        let corners = self.record.points(10, 42)?;
        let corners = corners
            .into_iter()
            .map(|([x, y, _], bulge)| (Point::new(x, y), bulge));
        let closed = self.record.integer(70)? & 1 != 0;
        self.corners(canvas, &map, corners.collect(), closed)
    }

    fn polyline(&self, canvas: &mut Canvas<'p>, vertices: &'p [Record<'p>]) -> DrawResult {
        let flags = self.record.integer(70)?;
        let (closed, in_space) = (flags & 1 != 0, flags & 8 != 0);
        if flags & (16 | 64) != 0 {
            return mesh::draw(canvas, self.record, vertices, self.layer, self.map);
        }
        let height = self.record.number(30)?.unwrap_or(0.0);
        let map = if in_space {
            self.map
        } else {
            self.map * plane(self.record, height)?
        };
        let mut corners = Vec::new();
        let mut level = None;
        let mut flat = true;
        for vertex in vertices {
            // Skip the control vertices of a spline: the curve has its own vertices.
            if vertex.integer(70)? & 16 != 0 {
                continue;
            }
            let [x, y, z] = vertex.point(10)?;
            flat &= *level.get_or_insert(z) == z;
            let bulge = if in_space { None } else { vertex.number(42)? };
            corners.push((Point::new(x, y), bulge.unwrap_or(0.0)));
        }
        if in_space && !flat {
            canvas.flattened(self.record);
        }
        self.corners(canvas, &map, corners, closed)
    }

    /// Draws a polyline; each corner has the bulge of the segment to the next.
    fn corners(
        &self,
        canvas: &mut Canvas<'p>,
        map: &Affine,
        mut corners: Vec<(Point, f64)>,
        closed: bool,
    ) -> DrawResult {
        let Some(first) = corners.first().copied() else {
            return canvas.leave_out(self.record, message!("it has no corners"));
        };
        if closed {
            corners.push(first);
        }
        let mut points = vec![*map * first.0];
        for pair in corners.windows(2) {
            if let [(from, bulge), (to, _)] = *pair {
                curve::bulge(&mut points, map, [from, to], bulge, canvas.chords);
            }
            if points.len() > canvas.room() {
                break;
            }
        }
        self.stroke(canvas, points)
    }

    /// Returns the points of a spline given by fit points and end tangents.
    fn interpolated(&self, through: &[Point], tolerance: f64) -> Result<Vec<Point>, Diagnostic> {
        let direction = |code| -> Result<Option<Vec2>, Diagnostic> {
            match self.record.text(code) {
                Some(_) => {
                    let [x, y, _] = self.record.point(code)?;
                    // A direction is rotated with the drawing, but not translated.
                    let direction = self.map * Point::new(x, y) - self.map * Point::ORIGIN;
                    Ok(Some(direction))
                }
                None => Ok(None),
            }
        };
        let ends = [direction(12)?, direction(13)?];
        let closed = self.record.integer(70)? & 1 != 0;
        Ok(interpolated(through, ends, closed, tolerance))
    }

    fn spline(&self, canvas: &mut Canvas<'p>) -> DrawResult {
        // A helix is stored as a spline, followed by its axis and turns.
        let record = self.record.until_class("AcDbHelix");
        let flat = |points: Vec<([f64; 3], f64)>| -> Vec<Point> {
            let points = points.into_iter();
            points
                .map(|([x, y, _], _)| self.map * Point::new(x, y))
                .collect()
        };
        let controls = flat(record.points(10, -1)?);
        let through = flat(record.points(11, -1)?);
        if controls.is_empty() && through.len() > 1 {
            let points = self.interpolated(&through, canvas.chords.for_curve())?;
            return match points.len() {
                0 | 1 => canvas.leave_out(self.record, message!("its fit points are all the same")),
                _ => self.stroke(canvas, points),
            };
        }
        if controls.is_empty() {
            return canvas.leave_out(self.record, message!("it has no control points"));
        }
        let degree = record.integer(71)?;
        let (knots, weights) = (record.numbers(40)?, record.numbers(41)?);
        match Spline::new(degree, knots, &controls, &weights) {
            Ok(spline) => {
                let tolerance = canvas.chords.for_curve();
                let mut points = spline.points(tolerance, canvas.room());
                // The ends of a closed spline may differ by rounding.
                if let ([first, .., last], true) =
                    (points.as_mut_slice(), record.integer(70)? & 1 != 0)
                    && first.distance(*last) < tolerance
                {
                    *last = *first;
                }
                self.stroke(canvas, points)
            }
            Err(why) => canvas.leave_out(self.record, why),
        }
    }
}
