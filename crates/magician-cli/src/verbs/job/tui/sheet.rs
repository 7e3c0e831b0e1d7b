//! Drawing of a job on the screen, with the completed part.

use std::iter;

use magician::preflight::Preflight;
use magician_motion::TopView;
use magician_program::Program;
use magician_program::toolpath::DrawnLine;
use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::Color;
use ratatui::symbols::Marker;
use ratatui::widgets::canvas::{Canvas, Context, Line, Points};

use crate::terminal::{Theme, panel};

/// Distance between the dots of lines still to be drawn, in dots of the screen.
const DOT_SPACING: f64 = 3.0;
/// Margin around the drawing, as a share of its size.
const MARGIN: f64 = 0.04;
/// Smallest width shown, mm, so that a tiny drawing is not magnified beyond this.
const MIN_WIDTH: f64 = 10.0;

/// Strokes of one loop, and the sheet below them.
#[derive(Debug)]
pub(super) struct Sheet {
    strokes: Vec<DrawnLine>,
    /// Corners of the sheet in the view of the paper.
    outline: Vec<[f64; 2]>,
    bounds: [[f64; 2]; 2],
    /// Number of steps in a loop.
    round: u64,
}

impl Sheet {
    /// Computes the strokes that a program leaves. `outline` has the corners of the sheet, if
    /// known.
    pub(super) fn of(program: &Program, start: &Preflight, outline: &[[f64; 2]]) -> Self {
        let strokes = DrawnLine::of(program.plan(), start).into_iter();
        let strokes = strokes.map(|stroke| DrawnLine {
            from: TopView::PAPER.project(stroke.from),
            to: TopView::PAPER.project(stroke.to),
            ..stroke
        });
        let outline = outline.iter().map(|corner| TopView::PAPER.project(*corner));
        let round = program.plan().steps.len() as u64;
        Self::new(strokes.collect(), outline.collect(), round)
    }

    fn new(strokes: Vec<DrawnLine>, outline: Vec<[f64; 2]>, round: u64) -> Self {
        let ends = strokes.iter().flat_map(|stroke| [stroke.from, stroke.to]);
        let points = ends.chain(outline.iter().copied());
        let around = |bounds: Option<[[f64; 2]; 2]>, [x, y]: [f64; 2]| {
            let [across, up] = bounds.unwrap_or([[x, x], [y, y]]);
            let wider = |[low, high]: [f64; 2], value: f64| [low.min(value), high.max(value)];
            Some([wider(across, x), wider(up, y)])
        };
        let bounds = points.fold(None, around).unwrap_or_default();
        Self {
            strokes,
            outline,
            bounds,
            round: round.max(1),
        }
    }

    /// Returns the number of completed strokes for a step count over all loops.
    fn done(&self, steps: u64, all: Option<u64>) -> usize {
        if all.is_some_and(|all| steps >= all) {
            return self.strokes.len();
        }
        let steps = steps % self.round;
        self.strokes
            .partition_point(|stroke| (stroke.step as u64) < steps)
    }

    /// Draws completed strokes as lines, the others as dots, with the sheet around them.
    pub(super) fn draw(
        &self,
        frame: &mut Frame<'_>,
        area: Rect,
        (steps, all): (u64, Option<u64>),
        tip: Option<[f64; 2]>,
        theme: Theme,
    ) {
        let block = panel("sheet", theme);
        let (bounds, dot) = fitted(block.inner(area), self.bounds);
        let (done, rest) = self.strokes.split_at(self.done(steps, all));
        let canvas = Canvas::default()
            .block(block)
            .marker(Marker::Braille)
            .x_bounds(bounds[0])
            .y_bounds(bounds[1])
            .paint(|pen| {
                self.edge(pen, theme.ink(Color::DarkGray));
                let coords: Vec<(f64, f64)> = dotted(rest, DOT_SPACING * dot).collect();
                let color = theme.ink(Color::DarkGray);
                pen.draw(&Points::new(&coords, color));
                pen.layer();
                for stroke in done {
                    pen.draw(&line(stroke.from, stroke.to, theme.ink(Color::Green)));
                }
                if let Some(tip) = tip {
                    let [x, y] = TopView::PAPER.project(tip);
                    pen.print(x, y, ratatui::text::Span::styled("+", theme.key()));
                }
            });
        frame.render_widget(canvas, area);
    }

    fn edge(&self, pen: &mut Context<'_>, color: Color) {
        let next = self.outline.iter().cycle().skip(1);
        for (from, to) in self.outline.iter().zip(next) {
            pen.draw(&line(*from, *to, color));
        }
    }
}

fn line([x1, y1]: [f64; 2], [x2, y2]: [f64; 2], color: Color) -> Line {
    Line::new(x1, y1, x2, y2, color)
}

/// Returns evenly spaced points along all strokes.
fn dotted(strokes: &[DrawnLine], apart: f64) -> impl Iterator<Item = (f64, f64)> {
    let mut left = 0.0;
    strokes.iter().flat_map(move |stroke| {
        let ([x1, y1], [x2, y2]) = (stroke.from, stroke.to);
        let long = (x2 - x1).hypot(y2 - y1);
        let first = left;
        let count = if first > long {
            0
        } else {
            ((long - first) / apart).floor() as u64 + 1
        };
        left = first + count as f64 * apart - long;
        iter::successors(Some(first), move |at| Some(at + apart))
            .take(usize::try_from(count).unwrap_or(usize::MAX))
            .map(move |at| {
                let share = if long > 0.0 { at / long } else { 0.0 };
                (x1 + share * (x2 - x1), y1 + share * (y2 - y1))
            })
    })
}

/// Returns bounds that contain the drawing at equal scale in both directions, and the size of a
/// dot; a character cell has 2 by 4 dots.
fn fitted(area: Rect, bounds: [[f64; 2]; 2]) -> ([[f64; 2]; 2], f64) {
    let dots = [
        f64::from(area.width.max(1)) * 2.0,
        f64::from(area.height.max(1)) * 4.0,
    ];
    let size = |axis: usize| {
        let [low, high] = bounds[axis];
        ((high - low) * (1.0 + 2.0 * MARGIN)).max(MIN_WIDTH)
    };
    let dot = (size(0) / dots[0]).max(size(1) / dots[1]);
    let fit = |axis: usize| {
        let [low, high] = bounds[axis];
        let middle = f64::midpoint(low, high);
        let half = dots[axis] * dot / 2.0;
        [middle - half, middle + half]
    };
    ([fit(0), fit(1)], dot)
}

#[cfg(test)]
impl Sheet {
    /// Two strokes, in steps 1 and 3 of four, on a sheet.
    pub(super) fn example() -> Self {
        let stroke = |step, from, to| DrawnLine { step, from, to };
        Self::new(
            vec![
                stroke(1, [0.0, 0.0], [80.0, 0.0]),
                stroke(3, [80.0, 0.0], [80.0, 40.0]),
            ],
            vec![[-10.0, -10.0], [90.0, -10.0], [90.0, 50.0], [-10.0, 50.0]],
            4,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_complete_with_their_last_step_and_restart_in_each_loop() {
        let sheet = Sheet::example();
        let done = |steps| sheet.done(steps, Some(8));
        assert_eq!([0, 1, 2, 3, 4, 5, 6, 8].map(done), [0, 0, 1, 1, 0, 0, 1, 2]);
        assert_eq!(sheet.done(4, None), 0);
    }

    #[test]
    fn dot_spacing_is_equal_over_corners() {
        let sheet = Sheet::example();
        let dots: Vec<(f64, f64)> = dotted(&sheet.strokes, 30.0).collect();
        assert_eq!(
            dots,
            [
                (0.0, 0.0),
                (30.0, 0.0),
                (60.0, 0.0),
                (80.0, 10.0),
                (80.0, 40.0)
            ]
        );
        assert_eq!(dotted(&[], 1.0).count(), 0);
    }

    #[test]
    fn both_directions_have_the_same_scale() {
        let (bounds, dot) = fitted(Rect::new(0, 0, 40, 10), [[0.0, 80.0], [0.0, 0.0]]);
        let [across, up] = bounds.map(|[low, high]| high - low);
        assert!((across / 80.0 - dot).abs() < 1e-9 && (up / 40.0 - dot).abs() < 1e-9);
        assert!(bounds[0][0] <= 0.0 && bounds[0][1] >= 80.0);
    }
}
