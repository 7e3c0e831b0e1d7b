//! Hatches: areas within boundary paths, solid or with a line pattern.

use kurbo::{Affine, Point, Vec2};
use magician_host::message;

use super::canvas::{Canvas, InsertContext};
use super::curve::{self, Ellipse};
use super::entity::plane;
use super::pairs::{Pair, Record};
use super::spline::Spline;
use crate::Diagnostic;
use crate::fill::LineFamily;
use crate::formats::Chords;

type DrawResult = Result<(), Diagnostic>;

/// Draws a hatch: an area if it is solid, else the lines of its pattern.
pub(super) fn draw<'p>(
    canvas: &mut Canvas<'p>,
    record: &'p Record<'p>,
    layer: &'p str,
    context: &InsertContext<'p>,
) -> DrawResult {
    let [_, _, z] = match record.text(10) {
        Some(_) => record.point(10)?,
        None => [0.0; 3],
    };
    let map = context.map * plane(record, z)?;
    let mut reader = Reader {
        pairs: record.pairs,
        record,
    };
    let rings = match paths(&mut reader, &map, canvas) {
        Ok(rings) => rings,
        Err(why) => return canvas.leave_out(record, why.message),
    };
    if rings.is_empty() {
        return canvas.leave_out(record, message!("it has no boundary"));
    }
    // MPOLYGON has the flag of HATCH. Without a pattern it is drawn as a solid one.
    let solid = record.integer(70)? & 1 != 0 || record.integer(450)? == 1;
    let families = families(&mut reader)?;
    if solid || families.is_empty() {
        return canvas.area(rings, record, layer);
    }
    let rings: Vec<Vec<[f64; 2]>> = rings
        .iter()
        .map(|ring| ring.iter().map(|point| [point.x, point.y]).collect())
        .collect();
    for family in families {
        let Some(lines) = placed(family, &map).within(&rings) else {
            return canvas.leave_out(record, message!("its pattern has too many lines"));
        };
        for [from, to] in lines {
            let points = [from, to].map(|[x, y]| Point::new(x, y));
            canvas.stroke(points.to_vec(), record, layer)?;
        }
    }
    Ok(())
}

/// Returns the lines of a pattern after a transform.
fn placed(family: LineFamily, map: &Affine) -> LineFamily {
    let point = |[x, y]: [f64; 2]| *map * Point::new(x, y);
    let origin = point([0.0; 2]);
    let (base, offset) = (point(family.base), point(family.offset) - origin);
    let (sin, cos) = libm::sincos(family.angle.to_radians());
    let along = point([cos, sin]) - origin;
    let longer = along.hypot();
    LineFamily {
        angle: along.atan2().to_degrees(),
        base: [base.x, base.y],
        offset: [offset.x, offset.y],
        dashes: family.dashes.iter().map(|dash| dash * longer).collect(),
    }
}

/// Sequential reader of pairs, because in a hatch the same group code has several meanings.
struct Reader<'p> {
    pairs: &'p [Pair<'p>],
    record: &'p Record<'p>,
}

impl<'p> Reader<'p> {
    /// Skips to the next value with this code and returns it.
    fn find(&mut self, code: i32) -> Option<&'p Pair<'p>> {
        let at = self.pairs.iter().position(|pair| pair.code == code)?;
        let (found, rest) = self.pairs.get(at..)?.split_first()?;
        self.pairs = rest;
        Some(found)
    }

    fn number(&mut self, code: i32) -> Result<f64, Diagnostic> {
        self.optional(code)?.ok_or_else(|| {
            let why = message!("it ends before group code {code}", code);
            Diagnostic::new(self.record.origin, why)
        })
    }

    fn optional(&mut self, code: i32) -> Result<Option<f64>, Diagnostic> {
        self.find(code).map(Pair::number).transpose()
    }

    fn count(&mut self, code: i32) -> Result<usize, Diagnostic> {
        let count = self.number(code)?;
        // A count cannot exceed the number of remaining values, which bounds allocation for damaged
        // files.
        Ok((count.max(0.0) as usize).min(self.pairs.len()))
    }

    fn point(&mut self, code: i32) -> Result<Point, Diagnostic> {
        Ok(Point::new(self.number(code)?, self.number(code + 10)?))
    }

    /// Returns the next value if it has this code.
    fn next_if(&mut self, code: i32) -> Result<Option<f64>, Diagnostic> {
        match self.pairs.split_first() {
            Some((pair, rest)) if pair.code == code => {
                self.pairs = rest;
                pair.number().map(Some)
            }
            _ => Ok(None),
        }
    }
}

/// Returns the boundary paths as rings, mm.
fn paths(
    reader: &mut Reader<'_>,
    map: &Affine,
    canvas: &Canvas<'_>,
) -> Result<Vec<Vec<Point>>, Diagnostic> {
    let mut rings = Vec::new();
    for _ in 0..reader.count(91)? {
        let kind = reader.number(92)? as i64;
        let mut ring = Vec::new();
        if kind & 2 != 0 {
            polyline(reader, map, canvas.chords, &mut ring)?;
        } else {
            for _ in 0..reader.count(93)? {
                edge(reader, map, canvas, &mut ring)?;
                if ring.len() > canvas.room() {
                    break;
                }
            }
        }
        if ring.len() > 2 {
            rings.push(ring);
        }
    }
    Ok(rings)
}

fn polyline(
    reader: &mut Reader<'_>,
    map: &Affine,
    chords: &Chords,
    ring: &mut Vec<Point>,
) -> DrawResult {
    let bulged = reader.number(72)? != 0.0;
    let count = reader.count(93)?;
    let mut corners = Vec::new();
    for _ in 0..count {
        let point = reader.point(10)?;
        let bulge = if bulged { reader.next_if(42)? } else { None };
        corners.push((point, bulge.unwrap_or(0.0)));
    }
    corners.extend(corners.first().copied());
    ring.extend(corners.first().map(|(first, _)| *map * *first));
    for pair in corners.windows(2) {
        if let [(from, bulge), (to, _)] = *pair {
            curve::bulge(ring, map, [from, to], bulge, chords);
        }
    }
    Ok(())
}

/// Adds an edge of a boundary including its start, because edges of a path need not meet exactly.
fn edge(
    reader: &mut Reader<'_>,
    map: &Affine,
    canvas: &Canvas<'_>,
    ring: &mut Vec<Point>,
) -> DrawResult {
    let mut points = match reader.number(72)? as i64 {
        1 => {
            let from = reader.point(10)?;
            vec![*map * from, *map * reader.point(11)?]
        }
        2 => {
            let centre = reader.point(10)?;
            let radius = reader.number(40)?;
            let [from, to] = [reader.number(50)?, reader.number(51)?].map(f64::to_radians);
            let turns = reader.number(73)?;
            turned(map, centre, Vec2::new(radius, 0.0), 1.0, [from, to], turns)
                .points(canvas.chords)
        }
        3 => {
            let centre = reader.point(10)?;
            let major = reader.point(11)?.to_vec2();
            let ratio = reader.number(40)?;
            let [from, to] = [reader.number(50)?, reader.number(51)?].map(f64::to_radians);
            let turns = reader.number(73)?;
            turned(map, centre, major, ratio, [from, to], turns).points(canvas.chords)
        }
        4 => spline(reader, map, canvas)?,
        _ => {
            return Err(Diagnostic::new(
                reader.record.origin,
                message!("its boundary has an unknown edge"),
            ));
        }
    };
    // Edges may be stored against the direction of the path.
    if let (Some(end), [first, .., last]) = (ring.last(), points.as_slice())
        && end.distance(*last) < end.distance(*first)
    {
        points.reverse();
    }
    ring.append(&mut points);
    Ok(())
}

/// Creates an elliptic arc. Clockwise arcs count their angles in the other direction.
fn turned(
    map: &Affine,
    centre: Point,
    major: Vec2,
    ratio: f64,
    [from, to]: [f64; 2],
    turns: f64,
) -> Ellipse {
    let side = if turns == 0.0 { -1.0 } else { 1.0 };
    let minor = Vec2::new(-major.y, major.x) * (ratio * side);
    let middle = *map * centre;
    Ellipse {
        centre: middle,
        one: *map * (centre + major) - middle,
        other: *map * (centre + minor) - middle,
        from,
        sweep: curve::sweep(from, to),
    }
}

fn spline(
    reader: &mut Reader<'_>,
    map: &Affine,
    canvas: &Canvas<'_>,
) -> Result<Vec<Point>, Diagnostic> {
    let degree = reader.number(94)? as i64;
    let (knots, controls) = (reader.count(95)?, reader.count(96)?);
    let knots = (0..knots)
        .map(|_| reader.number(40))
        .collect::<Result<Vec<_>, _>>()?;
    let (mut points, mut weights) = (Vec::new(), Vec::new());
    for _ in 0..controls {
        points.push(*map * reader.point(10)?);
        weights.extend(reader.next_if(42)?);
    }
    let spline = Spline::new(degree, knots, &points, &weights);
    let spline = spline.map_err(|why| Diagnostic::new(reader.record.origin, why))?;
    Ok(spline.points(canvas.chords.for_curve(), canvas.room()))
}

/// Reads the lines of the pattern. The file stores them rotated and scaled already.
fn families(reader: &mut Reader<'_>) -> Result<Vec<LineFamily>, Diagnostic> {
    let Some(count) = reader.find(78) else {
        return Ok(Vec::new());
    };
    let count = (count.number()?.max(0.0) as usize).min(reader.pairs.len());
    let mut families = Vec::new();
    for _ in 0..count {
        let angle = reader.number(53)?;
        let base = [reader.number(43)?, reader.number(44)?];
        let offset = [reader.number(45)?, reader.number(46)?];
        let dashes = reader.count(79)?;
        let dashes = (0..dashes)
            .map(|_| reader.number(49))
            .collect::<Result<_, _>>()?;
        families.push(LineFamily {
            angle,
            base,
            offset,
            dashes,
        });
    }
    Ok(families)
}
