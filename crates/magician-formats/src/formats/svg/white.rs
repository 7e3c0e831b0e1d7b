//! White on white is not seen, so it is not drawn; white on something darker is.

use kurbo::{Affine, Rect, Shape as _};
use magician_host::message;
use magician_host::{Given, Setting};
use usvg::{Color, Group, Node, Paint, Path};

use super::clip::{Region, Shape};
use super::collector::StrokeCollector;
use super::lines::{Closeness, Line, curves, flatten};
use super::source::Element;
use crate::formats::White;
use crate::{DiagnosticCode, Stroke};

/// As many points of a line are looked at.
const SAMPLES: usize = 32;
/// As many edges are looked at in all. What is left over counts as seen.
const MOST_WORK: usize = 50_000_000;

/// What was painted, and what of it was left out because it is white.
#[derive(Default)]
pub(super) struct Whites {
    /// Whether anything is white, and white is left out at all.
    any: bool,
    /// The filled shapes so far.
    painted: Vec<Painted>,
    work: usize,
    /// White lines, as long as there are no others.
    pub(super) kept: Vec<Stroke>,
    /// The first element that was left out, and how many there were.
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

    /// Whether a paint is not seen where nothing darker lies below it.
    pub(super) fn is_white(&self, paint: &Paint) -> bool {
        self.any && is_white(paint)
    }

    /// A filled shape lies on all before it.
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

    /// Whether at least half of a line lies on something that is not white.
    pub(super) fn lies_on_darker(&mut self, line: &Line) -> bool {
        let middles = line.iter().zip(line.iter().skip(1));
        let middles: Vec<[f64; 2]> = match line.as_slice() {
            [dot] => vec![*dot],
            _ => middles
                .map(|(from, to)| [0, 1].map(|axis| f64::midpoint(from[axis], to[axis])))
                .collect(),
        };
        let each = middles.len().div_ceil(SAMPLES).max(1);
        let (mut on, mut all) = (0, 0);
        for at in middles.into_iter().step_by(each) {
            all += 1;
            on += usize::from(self.is_darker_at(at));
        }
        2 * on >= all && all > 0
    }

    fn is_darker_at(&mut self, at: [f64; 2]) -> bool {
        if self.work > MOST_WORK {
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
    /// If everything is white, everything is drawn; otherwise a note reports what was left out.
    pub(super) fn tell_white(&mut self) {
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
            .add(note.remedy((Setting::White, Given::Word("draw")), "keeps it"));
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
