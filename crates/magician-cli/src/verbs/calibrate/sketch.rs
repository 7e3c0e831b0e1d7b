//! Sketch of the points to touch, in text characters, turned as the user sees the table.

use magician_motion::TopView;
use ratatui::style::Style;
use ratatui::text::{Line, Span};

use super::session::Touched;
use super::subject::Subject;
use super::view::point_symbol;
use crate::terminal::{Theme, arrow};

/// Returns the sketch for the subject, with the points numbered.
pub(super) fn sketch(touched: &Touched, view: TopView, theme: Theme) -> Vec<Line<'static>> {
    let dim_line = |text: &&str| Line::styled((*text).to_owned(), theme.dim());
    match touched.subject {
        Subject::Sheet => paper(touched, view, theme),
        Subject::Surface => [
            "            │ tool",
            "            ▼",
            "   ─────────┴───────── paper or table",
        ]
        .iter()
        .map(dim_line)
        .collect(),
        Subject::Tool => [
            "     │              │",
            "     └─┐          ┌─┘   turned by J4",
            "       ▼          ▼",
            "   ────+──────────+──── the same mark",
        ]
        .iter()
        .map(dim_line)
        .collect(),
    }
}

/// Columns and rows of the paper's sketch.
const SIZE: [usize; 2] = [27, 6];
/// Corners to touch, as directions from the middle of the paper in the arm's coordinates. The
/// sketch assumes that the axes of the drawing are parallel to those of the arm.
const CORNERS: [[f64; 2]; 3] = [[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0]];

/// Box of characters: first and last column, first and last row.
#[derive(Clone, Copy)]
struct CellBox {
    columns: [usize; 2],
    rows: [usize; 2],
}

impl CellBox {
    /// Returns the cell at a relative position: 0, 0 is the middle, 1 the right or upper edge.
    fn cell_at(self, [right, up]: [f64; 2]) -> [usize; 2] {
        let along = |[first, last]: [usize; 2], share: f64| {
            let (middle, half) = ((first + last) as f64 / 2.0, (last - first) as f64 / 2.0);
            (middle + share * half).round() as usize
        };
        [along(self.columns, right), along(self.rows, -up)]
    }
}

/// Styled characters in rows.
struct Canvas {
    cells: Vec<Vec<(char, Style)>>,
}

impl Canvas {
    fn write(&mut self, [column, row]: [usize; 2], text: &str, style: Style) {
        let cells = self.cells.get_mut(row).into_iter().flatten();
        for (cell, character) in cells.skip(column).zip(text.chars()) {
            *cell = (character, style);
        }
    }

    fn draw_box(&mut self, cell_box: CellBox, style: Style) {
        let ([left, right], [top, bottom]) = (cell_box.columns, cell_box.rows);
        let edge = "─".repeat(right - left - 1);
        self.write([left, top], &format!("┌{edge}┐"), style);
        self.write([left, bottom], &format!("└{edge}┘"), style);
        for row in top + 1..bottom {
            self.write([left, row], "│", style);
            self.write([right, row], "│", style);
        }
    }

    fn lines(self) -> Vec<Line<'static>> {
        let spans = |row: Vec<(char, Style)>| {
            let spans = row.into_iter();
            spans
                .map(|(character, style)| Span::styled(character.to_string(), style))
                .collect()
        };
        self.cells.into_iter().map(spans).collect()
    }
}

/// Draws the paper in front of the arm with numbered corners, turned as the view is.
fn paper(touched: &Touched, view: TopView, theme: Theme) -> Vec<Line<'static>> {
    let dim = theme.dim();
    let mut canvas = Canvas {
        cells: vec![vec![(' ', Style::new()); SIZE[0]]; SIZE[1]],
    };
    let ahead = view.project([1.0, 0.0]);
    let (paper, arm) = boxes(ahead);
    canvas.draw_box(paper, dim);
    canvas.draw_box(arm, dim);
    let [column, row] = arm.cell_at([0.0, 0.0]);
    canvas.write([column - 1, row], "arm", dim);
    let [column, row] = paper.cell_at([0.0, 0.0]);
    canvas.write([column - 2, row], "paper", dim);
    for (nth, corner) in CORNERS.into_iter().enumerate() {
        let (symbol, style) = point_symbol(touched, nth, theme);
        let direction = view.project(corner);
        let [column, row] = paper.cell_at(direction);
        let number = (nth + 1).to_string();
        canvas.write([column, row], symbol, style);
        if direction[0] > 0.0 {
            canvas.write([column + 1, row], &number, style)
        } else {
            canvas.write([column - 1, row], &number, style)
        }
    }
    for (nth, (name, direction)) in [("x+", [1.0, 0.0]), ("y+", [0.0, 1.0])]
        .into_iter()
        .enumerate()
    {
        let text = format!("{name} {}", arrow(view, direction));
        canvas.write([SIZE[0] - 4, nth], &text, theme.title());
    }
    canvas.lines()
}

/// Returns the boxes of paper and arm. `[right, up]` is the direction on the screen in which the
/// arm faces.
fn boxes([right, up]: [f64; 2]) -> (CellBox, CellBox) {
    let cell_box = |columns, rows| CellBox { columns, rows };
    if up > 0.5 {
        (cell_box([3, 19], [0, 3]), cell_box([8, 14], [4, 5]))
    } else if up < -0.5 {
        (cell_box([3, 19], [2, 5]), cell_box([8, 14], [0, 1]))
    } else if right > 0.0 {
        (cell_box([8, 20], [0, 5]), cell_box([0, 4], [2, 4]))
    } else {
        (cell_box([1, 13], [0, 5]), cell_box([16, 20], [2, 4]))
    }
}
