//! Collection of the visible lines of a drawing, in painting order.
//!
//! [`StrokeCollector`] walks usvg's tree. A path yields the centre line of its stroke, or the
//! outline of its fill if it has no stroke; then dashes, clip paths and masks are applied. White
//! lines are special: they are drawn only if they are visible on something darker, which is known
//! once everything below them has been walked.

use std::collections::HashMap;

use kurbo::{Affine, BezPath};
use magician_host::message;
use magician_host::{Setting, SettingValue};
use usvg::{Group, Node, Paint, Path, Stroke as Outline, Transform};

use super::area::encloses;
use super::clip::Region;
use super::filled::Areas;
use super::lines::{Closeness, Line, curves, dashed, flatten};
use super::notes::Notes;
use super::source::Element;
use super::text::LaidFonts;
use super::white::Whites;
use crate::artwork::{Layer, Style, index_or_push};
use crate::fill::{Area, FillRule, Region as Shapes};
use crate::formats::Fills;
use crate::{Color, Diagnostic, DiagnosticCode, ReadOptions, Stroke};

/// Largest number of vertices of a drawing. It bounds memory.
const MAX_CORNERS: usize = 5_000_000;
/// Factor by which curves are flattened more finely for measuring dashes. Chords are shorter than
/// their curve, and the difference accumulates up to the last dash.
const DASH_FINENESS: f64 = 8.0;
/// Largest coordinate, mm. A choice above any sheet, which detects damaged files.
const MAX_COORDINATE: f64 = 100_000.0;

/// Walks the elements and collects strokes.
pub(super) struct StrokeCollector<'a> {
    pub(super) elements: &'a HashMap<String, Element>,
    pub(super) close: Closeness,
    pub(super) fills: Fills,
    pub(super) writing: &'a ReadOptions,
    /// Fonts of the texts.
    pub(super) fonts: LaidFonts,
    pub(super) notes: &'a mut Notes,
    pub(super) strokes: Vec<Stroke>,
    pub(super) areas: Areas,
    pub(super) names: Vec<String>,
    pub(super) whites: Whites,
    /// All layers of the file. `layers` holds the layers in which lines were found.
    source: &'a [Layer],
    pub(super) layers: Vec<Layer>,
    pub(super) colors: Vec<Color>,
    /// Index of each name in the list.
    known: HashMap<String, usize>,
    corners: usize,
}

/// State of the walk at an element.
#[derive(Clone)]
pub(super) struct NodeContext {
    /// Transform from local coordinates to mm on the sheet.
    pub(super) to: Affine,
    /// Regions that clip it.
    pub(super) clips: Vec<Region>,
    /// Innermost element with a known id.
    pub(super) element: Element,
    /// Index of its outermost layer from 1; 0 outside all layers.
    pub(super) layer: usize,
}

impl<'a> StrokeCollector<'a> {
    pub(super) fn new(
        elements: &'a HashMap<String, Element>,
        source: &'a [Layer],
        close: Closeness,
        writing: &'a ReadOptions,
        whites: Whites,
        notes: &'a mut Notes,
        fonts: LaidFonts,
    ) -> Self {
        Self {
            elements,
            close,
            fills: writing.fills,
            writing,
            fonts,
            whites,
            notes,
            strokes: Vec::new(),
            areas: Areas::default(),
            names: Vec::new(),
            source,
            layers: Vec::new(),
            colors: Vec::new(),
            known: HashMap::new(),
            corners: 0,
        }
    }

    /// Walks the whole tree; `to` maps pixels to mm on the sheet.
    pub(super) fn all(&mut self, root: &Group, to: Affine) -> Result<(), Diagnostic> {
        let place = NodeContext {
            to,
            clips: Vec::new(),
            element: Element::default(),
            layer: 0,
        };
        self.group(root, &place)?;
        self.note_white();
        Ok(())
    }

    fn group(&mut self, group: &Group, outer: &NodeContext) -> Result<(), Diagnostic> {
        if group.opacity().get() == 0.0 {
            return Ok(());
        }
        let mut place = self.inner(group.id(), outer);
        place.to = outer.to * matrix(group.transform());
        if let Some(clip) = group.clip_path() {
            place.clips.push(Region::of(clip, place.to, self.close));
        }
        if let Some(mask) = group.mask() {
            match Region::of_mask(mask, place.to, self.close) {
                Some(region) => place.clips.push(region),
                None => {
                    let remark =
                        message!("a gradual mask is ignored: the shapes that it hides are drawn");
                    let element = self.first(group).unwrap_or(&place.element);
                    self.notes
                        .add(element.diagnostic(remark).coded(DiagnosticCode::LeftOut));
                }
            }
        }
        for node in group.children() {
            match node {
                Node::Group(group) => self.group(group, &place)?,
                Node::Path(path) => self.path(path, &place)?,
                Node::Text(text) => self.text(text, &place)?,
                Node::Image(_) => {}
            }
        }
        Ok(())
    }

    /// Returns the first known element in a group. A group that exists only for a mask has no id.
    fn first(&self, group: &Group) -> Option<&'a Element> {
        let within = group.children().iter().find_map(|node| match node {
            Node::Group(group) => self.first(group),
            other => self.elements.get(other.id()),
        });
        self.elements.get(group.id()).or(within)
    }

    pub(super) fn inner(&self, id: &str, outer: &NodeContext) -> NodeContext {
        let known = self.elements.get(id);
        NodeContext {
            element: known.unwrap_or(&outer.element).clone(),
            layer: match outer.layer {
                0 => known.map_or(0, |known| known.layer),
                layer => layer,
            },
            ..outer.clone()
        }
    }

    fn path(&mut self, path: &Path, outer: &NodeContext) -> Result<(), Diagnostic> {
        if !path.is_visible() {
            return Ok(());
        }
        let place = self.inner(path.id(), outer);
        let stroke = path.stroke().filter(|stroke| stroke.opacity().get() > 0.0);
        let fill = path.fill().filter(|fill| fill.opacity().get() > 0.0);
        let white_line = stroke.is_some_and(|stroke| self.whites.is_white(stroke.paint()));
        let darker = |fill: &usvg::Fill| !self.whites.is_white(fill.paint());
        // A white stroke around a darker fill is the visible edge of the shape, if it encloses an
        // area.
        let edge_alone = white_line
            && fill.is_some_and(darker)
            && flatten(&self.curves(path, &place)?, self.close.tolerance, true)
                .iter()
                .any(|line| encloses(line, self.close.near));
        let white = match stroke {
            Some(_) => white_line && !edge_alone,
            None => !fill.is_none_or(darker),
        };
        let stroke = stroke.filter(|_| !edge_alone);
        if let Some(fill) = fill.filter(|_| self.fills == Fills::Areas) {
            let rings = flatten(&self.curves(path, &place)?, self.close.tolerance, true);
            self.area(rings, fill, &place)?;
        }
        let drawn = self.lines_of(path, stroke, fill, &place)?;
        let paint = stroke.map(Outline::paint).or(fill.map(usvg::Fill::paint));
        self.add(drawn, &place, white, paint)?;
        self.whites.paint(path, place.to, &place.clips, self.close);
        Ok(())
    }

    /// Returns the lines of a path: those of its stroke, else the outline of its fill.
    fn lines_of(
        &mut self,
        path: &Path,
        stroke: Option<&Outline>,
        fill: Option<&usvg::Fill>,
        place: &NodeContext,
    ) -> Result<Vec<Line>, Diagnostic> {
        match (stroke, fill) {
            (Some(stroke), _) => self.stroked(path, stroke, place),
            (None, Some(fill)) if self.is_area(fill) => Ok(Vec::new()),
            (None, Some(fill)) => {
                let mut lines = flatten(&self.curves(path, place)?, self.close.tolerance, true);
                let all = lines.len();
                lines.retain(|line| encloses(line, self.close.near));
                if lines.len() < all {
                    let remark = message!(
                        "lines without a stroke that enclose no area are left out: they \
                        are invisible"
                    );
                    let note = place.element.diagnostic(remark);
                    self.notes
                        .add(note.help(message!("give them a stroke to have them drawn")));
                }
                if lines.is_empty() || !self.takes_fill(fill.paint(), &place.element) {
                    return Ok(Vec::new());
                }
                Ok(lines)
            }
            (None, None) => Ok(Vec::new()),
        }
    }

    /// True if the fill becomes an area, so that its outline is not drawn.
    fn is_area(&self, fill: &usvg::Fill) -> bool {
        self.fills == Fills::Areas && !self.whites.is_white(fill.paint())
    }

    /// Adds a filled shape, clipped. A white one hides what is below it.
    pub(super) fn area(
        &mut self,
        rings: Vec<Line>,
        fill: &usvg::Fill,
        place: &NodeContext,
    ) -> Result<(), Diagnostic> {
        self.count(&rings)?;
        let rule = match fill.rule() {
            usvg::FillRule::NonZero => FillRule::NonZero,
            usvg::FillRule::EvenOdd => FillRule::EvenOdd,
        };
        let whole = Shapes::of(&Area { rings, rule });
        let shapes = place
            .clips
            .iter()
            .fold(whole, |shapes, clip| shapes.common(&clip.shapes()));
        if self.is_area(fill) {
            let origin = place.element.origin.named(self.name(&place.element.name));
            let style = self.style(place, Some(fill.paint()));
            self.areas.paint(shapes, origin, style);
        } else {
            self.areas.hide(&shapes);
        }
        Ok(())
    }

    /// True if the outline of a filled shape is drawn. Adds a note either way.
    fn takes_fill(&mut self, paint: &Paint, element: &Element) -> bool {
        let (take, remark) = match self.fills {
            Fills::Ignore => (false, "filled shapes without a line are left out"),
            // The walk cannot know yet whether white is drawn. That is decided and reported at its
            // end.
            Fills::Outline | Fills::Areas if self.whites.is_white(paint) => return true,
            Fills::Outline | Fills::Areas => {
                (true, "filled shapes without a line are drawn as outlines")
            }
        };
        let code = if take {
            DiagnosticCode::Assumed
        } else {
            DiagnosticCode::LeftOut
        };
        self.notes.add(element.diagnostic(remark).coded(code));
        take
    }

    pub(super) fn curves(&self, path: &Path, place: &NodeContext) -> Result<BezPath, Diagnostic> {
        let curves = curves(path.data(), place.to);
        let bounds = curves.control_box();
        let sides = [bounds.x0, bounds.y0, bounds.x1, bounds.y1];
        match sides
            .iter()
            .find(|side| side.is_nan() || side.abs() > MAX_COORDINATE)
        {
            None => Ok(curves),
            Some(side) => {
                let message = message!(
                    "it extends to {side:.0} mm, limit {farthest:.0} mm",
                    side,
                    farthest = MAX_COORDINATE
                );
                Err(place.element.diagnostic(message))
            }
        }
    }

    /// Returns the lines of a stroke, cut into dashes if it has a dash array.
    fn stroked(
        &mut self,
        path: &Path,
        stroke: &Outline,
        place: &NodeContext,
    ) -> Result<Vec<Line>, Diagnostic> {
        let curves = self.curves(path, place)?;
        let whole = || flatten(&curves, self.close.tolerance, false);
        let Some(pattern) = stroke.dasharray() else {
            return Ok(whole());
        };
        // Dashes are measured before the transform, which may stretch them.
        let [a, b, c, d, ..] = place.to.as_coeffs();
        let scale = libm::hypot(a, b).max(libm::hypot(c, d));
        let own = super::lines::curves(path.data(), Affine::IDENTITY);
        let pattern: Vec<f64> = pattern.iter().map(|part| f64::from(*part)).collect();
        let offset = f64::from(stroke.dashoffset());
        let fine = self.close.tolerance / scale / DASH_FINENESS;
        if !(fine.is_finite() && fine > 0.0) {
            return Ok(whole());
        }
        let Some(mut dashes) = dashed(&flatten(&own, fine, false), &pattern, offset) else {
            let remark = message!("dashes too fine to be drawn are drawn as whole lines");
            self.notes.add(
                place
                    .element
                    .diagnostic(remark)
                    .coded(DiagnosticCode::Assumed),
            );
            return Ok(whole());
        };
        for point in dashes.iter_mut().flatten() {
            let put = place.to * kurbo::Point::new(point[0], point[1]);
            *point = [put.x, put.y];
        }
        Ok(dashes)
    }

    /// Adds lines, clipped; of white ones only the visible parts.
    pub(super) fn add(
        &mut self,
        mut lines: Vec<Line>,
        place: &NodeContext,
        white: bool,
        paint: Option<&Paint>,
    ) -> Result<(), Diagnostic> {
        for region in &place.clips {
            let clipped: Option<Vec<Vec<Line>>> =
                lines.iter().map(|line| region.clip(line)).collect();
            let Some(clipped) = clipped else {
                let message = message!("its clip path is too fine to be followed");
                return Err(place.element.diagnostic(message));
            };
            lines = clipped.concat();
        }
        if lines.is_empty() {
            return Ok(());
        }
        let origin = place.element.origin.named(self.name(&place.element.name));
        if white {
            let (seen, unseen): (Vec<Line>, Vec<Line>) = lines
                .into_iter()
                .partition(|line| self.whites.lies_on_darker(line));
            if !unseen.is_empty() {
                let left_out = &mut self.whites.left_out;
                left_out.get_or_insert_with(|| (place.element.clone(), 0)).1 += 1;
            }
            if self.strokes.is_empty() && seen.is_empty() {
                self.count(&unseen)?;
                let style = self.style(place, paint);
                let strokes = unseen.into_iter().map(|points| Stroke {
                    points,
                    origin,
                    style,
                });
                self.whites.kept.extend(strokes);
            }
            lines = seen;
        }
        if !lines.is_empty() {
            self.whites.kept = Vec::new();
        }
        self.count(&lines)?;
        if lines.is_empty() {
            return Ok(());
        }
        let style = self.style(place, paint);
        let strokes = lines.into_iter().map(|points| Stroke {
            points,
            origin,
            style,
        });
        self.strokes.extend(strokes);
        Ok(())
    }

    /// Returns layer and colour of an element.
    fn style(&mut self, place: &NodeContext, paint: Option<&Paint>) -> Style {
        let color = match paint {
            Some(Paint::Color(color)) => {
                let color = Color([color.red, color.green, color.blue]);
                index_or_push(&mut self.colors, &color)
            }
            _ => 0,
        };
        let outside = Layer::default();
        let layer = place
            .layer
            .checked_sub(1)
            .and_then(|at| self.source.get(at));
        let layer = match self.source {
            [] => 0,
            _ => index_or_push(&mut self.layers, layer.unwrap_or(&outside)),
        };
        Style {
            layer,
            color,
            part: 0,
        }
    }

    /// Counts vertices, and refuses more than can be drawn.
    fn count(&mut self, lines: &[Line]) -> Result<(), Diagnostic> {
        for points in lines {
            self.corners += points.len();
            if self.corners > MAX_CORNERS {
                let message = message!(
                    "the drawing has more than {most_corners} corners",
                    most_corners = MAX_CORNERS
                );
                let tolerance = (Setting::Tolerance, SettingValue::Any("MM"));
                return Err(
                    Diagnostic::of_file(message).remedy(tolerance, "needs fewer if it is larger")
                );
            }
        }
        Ok(())
    }

    fn name(&mut self, name: &str) -> usize {
        if let Some(known) = self.known.get(name) {
            return *known;
        }
        let index = self.names.len();
        self.names.push(name.to_owned());
        self.known.insert(name.to_owned(), index);
        index
    }
}

/// Converts a transform from usvg to kurbo.
pub(super) fn matrix(transform: Transform) -> Affine {
    let Transform {
        sx,
        ky,
        kx,
        sy,
        tx,
        ty,
    } = transform;
    Affine::new([sx, ky, kx, sy, tx, ty].map(f64::from))
}
