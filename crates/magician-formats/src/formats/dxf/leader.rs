//! Leaders: lines with an arrow, and for MULTILEADER also the text.

use kurbo::{Affine, Point, Vec2};
use magician_host::message;

use super::canvas::{Canvas, InsertContext};
use super::mtext::Paragraph;
use super::pairs::{Pair, Record};
use super::text::rotation_to;
use crate::Diagnostic;

type DrawResult = Result<(), Diagnostic>;

/// Width of an arrow relative to its length.
const ARROW_WIDTH_SHARE: f64 = 1.0 / 3.0;

/// Draws a LEADER. Its text is a separate entity.
pub(super) fn leader<'p>(
    canvas: &mut Canvas<'p>,
    record: &'p Record<'p>,
    layer: &'p str,
    insert_context: &InsertContext<'p>,
) -> DrawResult {
    let points: Vec<Point> = record
        .points(10, -1)?
        .into_iter()
        .map(|([x, y, _], _)| Point::new(x, y))
        .collect();
    if points.len() < 2 {
        return canvas.leave_out(record, message!("it has no points"));
    }
    let arrow = match record.text(71) {
        Some("0") => 0.0,
        _ => canvas.arrow_size(record.text(3)),
    };
    with_arrow(canvas, &points, arrow, record, layer, insert_context)
}

/// Draws a line with an arrow at its first point, unless the first segment is too short for one.
fn with_arrow<'p>(
    canvas: &mut Canvas<'p>,
    points: &[Point],
    size: f64,
    record: &'p Record<'p>,
    layer: &'p str,
    insert_context: &InsertContext<'p>,
) -> DrawResult {
    let mapped = points
        .iter()
        .map(|point| insert_context.map * *point)
        .collect();
    canvas.stroke(mapped, record, layer)?;
    let [tip, next, ..] = points else {
        return Ok(());
    };
    let way = *next - *tip;
    if size <= 0.0 || way.hypot() < 2.0 * size {
        return Ok(());
    }
    let along = way / way.hypot() * size;
    let aside = Vec2::new(-along.y, along.x) * (ARROW_WIDTH_SHARE / 2.0);
    let corners = [*tip, *tip + along + aside, *tip + along - aside];
    let corners = corners.map(|corner| insert_context.map * corner).to_vec();
    canvas.area(vec![corners], record, layer)
}

/// Draws a MULTILEADER from the nested groups of its context data.
pub(super) fn multileader<'p>(
    canvas: &mut Canvas<'p>,
    record: &'p Record<'p>,
    layer: &'p str,
    insert_context: &InsertContext<'p>,
) -> DrawResult {
    let Context {
        text,
        height,
        arrow,
        location,
        direction,
        width,
        attachment,
        leaders,
    } = Context::of(record)?;
    if text.is_none() && leaders.is_empty() {
        return canvas.leave_out(record, message!("it has neither text nor lines"));
    }
    for leader in leaders {
        for line in leader.lines {
            let mut points = line;
            points.extend(leader.end);
            points.extend(leader.end.zip(leader.dogleg).map(|(end, way)| end + way));
            if points.len() > 1 {
                with_arrow(canvas, &points, arrow, record, layer, insert_context)?;
            }
        }
    }
    let (Some(text), Some(location)) = (text, location) else {
        return Ok(());
    };
    let map = insert_context.map * Affine::translate(location.to_vec2()) * rotation_to(direction);
    let paragraph = Paragraph {
        height,
        width,
        attachment,
        spacing: 1.0,
        stretch: 1.0,
        oblique: 0.0,
    };
    paragraph.draw(canvas, &text, &map, record, layer)
}

#[derive(Default)]
struct Leader {
    end: Option<Point>,
    dogleg: Option<Vec2>,
    lines: Vec<Vec<Point>>,
}

#[derive(Default)]
struct Context {
    text: Option<String>,
    height: f64,
    arrow: f64,
    location: Option<Point>,
    direction: Vec2,
    width: f64,
    attachment: i64,
    leaders: Vec<Leader>,
}

impl Context {
    fn of(record: &Record<'_>) -> Result<Self, Diagnostic> {
        let mut context = Self {
            attachment: 1,
            ..Self::default()
        };
        let mut groups: Vec<&str> = Vec::new();
        let mut dogleg = (Vec2::ZERO, 0.0);
        let mut pairs = record.pairs.iter();
        while let Some(pair) = pairs.next() {
            if let Some(group) = pair.value.strip_suffix('{').filter(|_| pair.code >= 300) {
                groups.push(group);
                match group {
                    "LEADER" => {
                        context.leaders.push(Leader::default());
                        dogleg = (Vec2::ZERO, 0.0);
                    }
                    "LEADER_LINE" => {
                        if let Some(leader) = context.leaders.last_mut() {
                            leader.lines.push(Vec::new());
                        }
                    }
                    _ => {}
                }
                continue;
            }
            if pair.value == "}" && pair.code >= 300 {
                groups.pop();
                continue;
            }
            let point = || point_at(pair, pairs.as_slice());
            match (groups.last().copied(), pair.code) {
                (Some("CONTEXT_DATA"), code) => match code {
                    304 => context.text = Some(pair.verbatim.to_owned()),
                    12 => context.location = Some(point()?),
                    13 => context.direction = point()?.to_vec2(),
                    41 => context.height = pair.number()?,
                    43 => context.width = pair.number()?,
                    140 => context.arrow = pair.number()?,
                    // Left, middle or right of the upper edge.
                    171 => context.attachment = pair.integer()?.clamp(1, 3),
                    _ => {}
                },
                (Some("LEADER"), code) => {
                    match code {
                        11 => dogleg.0 = point()?.to_vec2(),
                        40 => dogleg.1 = pair.number()?,
                        _ => {}
                    }
                    if let Some(leader) = context.leaders.last_mut() {
                        if code == 10 {
                            leader.end = Some(point()?);
                        }
                        let way = dogleg.0 * dogleg.1;
                        leader.dogleg = (way.hypot() > 0.0).then_some(way);
                    }
                }
                (Some("LEADER_LINE"), 10) => {
                    let line = context.leaders.last_mut();
                    if let Some(line) = line.and_then(|leader| leader.lines.last_mut()) {
                        line.push(point()?);
                    }
                }
                _ => {}
            }
        }
        Ok(context)
    }
}

/// Returns the point whose x is this value.
fn point_at(x: &Pair<'_>, rest: &[Pair<'_>]) -> Result<Point, Diagnostic> {
    let y = rest.first().filter(|pair| pair.code == x.code + 10);
    Ok(Point::new(x.number()?, y.map_or(Ok(0.0), Pair::number)?))
}
