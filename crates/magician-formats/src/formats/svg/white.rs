//! Visibility of white: white on paper is invisible and not drawn, white on something darker is.

use kurbo::{Affine, Rect, Shape as _};
use magician_host::message;
use magician_host::{Setting, SettingValue};
use usvg::{Color, Group, Node, Paint, Path};

use super::clip::{Region, Shape};
use super::collector::StrokeCollector;
use super::lines::{Closeness, Line, curves, flatten};
use super::source::Element;
use crate::formats::White;
use crate::{DiagnosticCode, Stroke};

/// Largest number of samples per line. A choice: enough to decide whether half of it is visible.
const MAX_SAMPLES: usize = 32;
/// Largest number of edges to test in total. Beyond it lines count as visible.
const MAX_WORK: usize = 50_000_000;

/// Shapes painted so far, and the white lines left out.
#[derive(Default)]
pub(super) struct Whites {
    /// True if the drawing contains white and white is to be left out.
    any: bool,
    /// Filled shapes so far, in painting order.
    painted: Vec<Painted>,
    work: usize,
    /// White lines left out so far, as long as nothing else was drawn.
    pub(super) kept: Vec<Stroke>,
    /// First element left out, and their number.
    pub(super) left_out: Option<(Element, usize)>,
}

struct Painted {
    shape: Shape,
    bounds: Rect,
    white: bool,
}

impl Whites {
    pub(super) fn of(root: &Group, white: White) -> Self {
        Self {
            any: white == White::Skip && has_white(root),
            ..Self::default()
        }
    }

    /// True if a paint is white, so that it is visible only on something darker.
    pub(super) fn is_white(&self, paint: &Paint) -> bool {
        self.any && is_white(paint)
    }

    /// Records a filled shape, which covers everything painted before.
    pub(super) fn paint(&mut self, path: &Path, to: Affine, clips: &[Region], close: Closeness) {
        let Some(fill) = path.fill().filter(|fill| fill.opacity().get() > 0.0) else {
            return;
        };
        if !self.any {
            return;
        }
        let curves = curves(path.data(), to);
        self.painted.push(Painted {
            bounds: curves
                .bounding_box()
                .inflate(close.tolerance, close.tolerance),
            shape: Shape::new(
                &flatten(&curves, close.tolerance, true),
                fill.rule(),
                clips,
                close.near,
            ),
            white: is_white(fill.paint()),
        });
    }

    /// True if at least half of a line lies on something other than white.
    pub(super) fn lies_on_darker(&mut self, line: &Line) -> bool {
        let middles = line.iter().zip(line.iter().skip(1));
        let middles: Vec<[f64; 2]> = match line.as_slice() {
            [dot] => vec![*dot],
            // Middles of segments, because an end may lie exactly on an edge.
            _ => middles
                .map(|(from, to)| [0, 1].map(|axis| f64::midpoint(from[axis], to[axis])))
                .collect(),
        };
        let each = middles.len().div_ceil(MAX_SAMPLES).max(1);
        let (mut on, mut all) = (0, 0);
        for at in middles.into_iter().step_by(each) {
            all += 1;
            on += usize::from(self.is_darker_at(at));
        }
        2 * on >= all && all > 0
    }

    fn is_darker_at(&mut self, at: [f64; 2]) -> bool {
        if self.work > MAX_WORK {
            return true;
        }
        let point = kurbo::Point::new(at[0], at[1]);
        for painted in self.painted.iter().rev() {
            self.work += 1;
            if !painted.bounds.contains(point) {
                continue;
            }
            self.work += painted.shape.edges();
            if painted.shape.contains(at) {
                return !painted.white;
            }
        }
        false
    }
}

impl StrokeCollector<'_> {
    /// Draws everything if all of it is white. Otherwise notes what was left out.
    pub(super) fn note_white(&mut self) {
        let Some((element, count)) = self.whites.left_out.take() else {
            return;
        };
        if self.strokes.is_empty() {
            self.strokes = std::mem::take(&mut self.whites.kept);
            let remark = message!("all of it is white: it is drawn anyway");
            self.notes
                .add(element.diagnostic(remark).coded(DiagnosticCode::Assumed));
            return;
        }
        let remark = match count {
            1 => message!("white on white is left out: it is invisible"),
            count => message!(
                "white on white is left out: it is invisible ({count} elements)",
                count
            ),
        };
        let note = element.diagnostic(remark).coded(DiagnosticCode::LeftOut);
        self.notes
            .add(note.remedy((Setting::White, SettingValue::Word("draw")), "keeps it"));
    }
}

fn is_white(paint: &Paint) -> bool {
    matches!(paint, Paint::Color(color) if *color == Color::white())
}

fn has_white(group: &Group) -> bool {
    group.children().iter().any(|node| match node {
        Node::Group(group) => has_white(group),
        Node::Path(path) => {
            let stroke = path.stroke().map(usvg::Stroke::paint);
            let fill = path.fill().map(usvg::Fill::paint);
            stroke.into_iter().chain(fill).any(is_white)
        }
        Node::Text(text) => has_white(text.flattened()),
        Node::Image(_) => false,
    })
}
