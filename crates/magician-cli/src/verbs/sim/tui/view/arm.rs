//! Pictures of the arm from above and from the side.

use std::f64::consts::TAU;

use magician_sim::scenario::Conveyor;
use magician_sim::world::Support;
use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::Color;
use ratatui::symbols::Marker;
use ratatui::widgets::canvas::{Canvas, Context, Line, Points};

use super::View;
use super::reach::{outline, ring};
use crate::terminal::arrow;
use crate::verbs::sim::tui::arm_view::{Figure, Item};

/// Ground shown from above: opposite corners x, y in mm.
const TOP_VIEW_AREA: [[f64; 2]; 2] = [[-260.0, -350.0], [360.0, 350.0]];
/// Area shown from the side, mm: r outwards, z upwards.
const SIDE_VIEW_AREA: [[f64; 2]; 2] = [[-75.0, 365.0], [-165.0, 195.0]];
/// Height of the arm's foot if the table's is unknown, mm: the middle of reported heights of tables
/// (model section 1).
const FOOT_Z: f64 = -67.5;
/// Half the width of the base, mm.
const BASE_HALF_WIDTH: f64 = 40.0;
/// Largest distance between the arm's plane and the edge of an object that is still shown from the
/// side, mm.
const MAX_PLANE_DISTANCE: f64 = 15.0;
/// Distance between marks across the belt, mm.
const BELT_MARK_SPACING: f64 = 50.0;
/// Largest distance in the arm's plane at which things are drawn, mm.
const MAX_DRAWN_DISTANCE: u32 = 450;
/// Samples of a curve.
const SAMPLES: u32 = 48;

const ARM: Color = Color::Cyan;
const TOOL: Color = Color::Yellow;
const TRAIL: Color = Color::Blue;
const FAINT: Color = Color::DarkGray;
const INK: Color = Color::Magenta;

impl View<'_> {
    pub(super) fn seen_from_above(self, frame: &mut Frame<'_>, area: Rect) {
        let rail = self.look.rail();
        let [a, b] = TOP_VIEW_AREA.map(|[x, y]| self.app.view.project([x, y + rail]));
        let in_sight = [0, 1].map(|axis| [a[axis].min(b[axis]), a[axis].max(b[axis])]);
        self.draw(
            frame,
            area,
            &format!("from above: {}", self.axes()),
            in_sight,
            |pen| {
                let mut pen = FromAbove(Pen { pen, view: self });
                pen.surroundings();
                pen.ink();
                pen.arm();
            },
        );
    }

    /// Describes the directions of the axes in the view from above.
    pub(super) fn axes(self) -> String {
        let names = [("x+", [1.0, 0.0]), ("y+", [0.0, 1.0])];
        let names = names.map(|(name, way)| format!("{name} {}", arrow(self.app.view, way)));
        names.join(" ")
    }

    pub(super) fn seen_from_the_side(self, frame: &mut Frame<'_>, area: Rect) {
        self.draw(frame, area, "from the side", SIDE_VIEW_AREA, |pen| {
            let mut pen = FromSide(Pen { pen, view: self });
            pen.surroundings();
            pen.arm();
        });
    }

    /// Draws a panel with a picture to scale.
    fn draw(
        self,
        frame: &mut Frame<'_>,
        area: Rect,
        title: &str,
        in_sight: [[f64; 2]; 2],
        paint: impl Fn(&mut Context<'_>),
    ) {
        let block = self.panel(title);
        let [across, up] = fitted(block.inner(area), in_sight);
        let canvas = Canvas::default()
            .block(block)
            .marker(Marker::Braille)
            .x_bounds(across)
            .y_bounds(up)
            .paint(paint);
        frame.render_widget(canvas, area);
    }
}

/// Returns bounds that contain the area at equal scale in both directions; a character cell has 2
/// by 4 dots.
fn fitted(area: Rect, [across, up]: [[f64; 2]; 2]) -> [[f64; 2]; 2] {
    let dots = [
        f64::from(area.width.max(1)) * 2.0,
        f64::from(area.height.max(1)) * 4.0,
    ];
    let [width, height] = [across, up].map(|[from, to]| to - from);
    let scale = (width / dots[0]).max(height / dots[1]);
    let fit = |[from, to]: [f64; 2], dots: f64| {
        let middle = f64::midpoint(from, to);
        let half = dots * scale / 2.0;
        [middle - half, middle + half]
    };
    [fit(across, dots[0]), fit(up, dots[1])]
}

/// Returns the nearest of the basic terminal colours that is visible on a dark background.
pub(super) fn nearest(color: magician_sim::scenario::Color) -> Color {
    const KNOWN: [([i32; 3], Color); 8] = [
        ([255, 0, 0], Color::Red),
        ([0, 255, 0], Color::Green),
        ([0, 0, 255], Color::Blue),
        ([255, 255, 0], Color::Yellow),
        ([255, 128, 0], Color::LightRed),
        ([160, 0, 160], Color::Magenta),
        ([0, 255, 255], Color::Cyan),
        ([255, 255, 255], Color::White),
    ];
    let color = color.0.map(i32::from);
    if color.iter().max().is_none_or(|most| *most < 140)
        && color
            .iter()
            .max()
            .zip(color.iter().min())
            .is_none_or(|(a, b)| a - b < 60)
    {
        return Color::Gray;
    }
    let far = |other: &[i32; 3]| -> i32 {
        let apart = color.iter().zip(other);
        apart.map(|(a, b)| (a - b) * (a - b)).sum()
    };
    let near = KNOWN.iter().min_by_key(|(other, _)| far(other));
    near.map_or(Color::White, |(_, color)| *color)
}

/// Pen for lines in mm.
struct Pen<'a, 'b, 'c> {
    pen: &'a mut Context<'b>,
    view: View<'c>,
}

impl Pen<'_, '_, '_> {
    fn line(&mut self, [x1, y1]: [f64; 2], [x2, y2]: [f64; 2], color: Color) {
        let color = self.view.theme.ink(color);
        self.pen.draw(&Line::new(x1, y1, x2, y2, color));
    }

    fn lines(&mut self, points: impl IntoIterator<Item = [f64; 2]>, color: Color) {
        let mut points = points.into_iter();
        let Some(mut last) = points.next() else {
            return;
        };
        for point in points {
            self.line(last, point, color);
            last = point;
        }
    }

    fn dots(&mut self, points: impl IntoIterator<Item = [f64; 2]>, color: Color) {
        let coords: Vec<_> = points.into_iter().map(|[x, y]| (x, y)).collect();
        let color = self.view.theme.ink(color);
        let coords = &coords[..];
        self.pen.draw(&Points { coords, color });
    }

    fn closed(&mut self, corners: [[f64; 2]; 4], color: Color) {
        let first = corners[0];
        self.lines(corners.into_iter().chain([first]), color);
    }

    /// Draws the symbol of the tool's tip on top of everything.
    fn mark(&mut self, [x, y]: [f64; 2]) {
        let state = &self.view.look.state;
        let working = state.suction.reached || state.gripper.reached || state.laser;
        let sign = if working { "◉" } else { "o" };
        let style = self.view.theme.key();
        self.pen
            .print(x, y, ratatui::text::Line::styled(sign, style));
    }
}

/// View from above, turned as the user chose.
struct FromAbove<'a, 'b, 'c>(Pen<'a, 'b, 'c>);

impl FromAbove<'_, '_, '_> {
    /// Returns the projection of a point x, y onto the canvas.
    fn seen(&self) -> impl Fn([f64; 2]) -> [f64; 2] + Copy + use<> {
        let view = self.0.view.app.view;
        move |point| view.project(point)
    }

    fn surroundings(&mut self) {
        let above = self.seen();
        let View { app, look, .. } = self.0.view;
        self.reach();
        if let Some(belt) = &app.subject().conveyor {
            let place = [belt.start[0], belt.start[1]];
            let across = belt.width / 2.0;
            let on = |along: f64, left: f64| above(turned(place, belt.direction, [along, left]));
            let corners = [
                (0.0, across),
                (belt.length, across),
                (belt.length, -across),
                (0.0, -across),
            ];
            self.0
                .closed(corners.map(|(along, left)| on(along, left)), FAINT);
            let mut mark = look.belt_travel.rem_euclid(BELT_MARK_SPACING);
            while mark < belt.length {
                self.0.line(on(mark, across), on(mark, -across), FAINT);
                mark += BELT_MARK_SPACING;
            }
        }
        if look.state.rail.is_some() {
            let rail = |x: f64| [[x, -2000.0], [x, 2000.0]].map(above);
            for x in [-BASE_HALF_WIDTH, BASE_HALF_WIDTH] {
                let [from, to] = rail(x);
                self.0.line(from, to, FAINT);
            }
        }
        for item in look.items.iter().filter(|item| item.rest != Support::Floor) {
            let (place, half) = (
                [item.place.x, item.place.y],
                [item.size[0] / 2.0, item.size[1] / 2.0],
            );
            let corners = [[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]];
            let corners = corners
                .map(|[a, b]| above(turned(place, item.place.yaw, [a * half[0], b * half[1]])));
            self.0.closed(corners, nearest(item.color));
        }
    }

    /// Draws the area that the tool can reach at its current height.
    fn reach(&mut self) {
        let above = self.seen();
        let View { app, look, .. } = self.0.view;
        let limits = &app.subject().limits;
        let figure = look.figure();
        let Some(radii) = ring(figure.tip[1], look.tool, limits) else {
            return;
        };
        let rail = look.rail();
        let (from, to) = (limits.j1.min.to_radians(), limits.j1.max.to_radians());
        let at = move |radius: f64, angle: f64| {
            above([radius * angle.cos(), radius * angle.sin() + rail])
        };
        for radius in radii {
            let angle =
                move |step: u32| from + (to - from) * f64::from(step) / f64::from(SAMPLES * 2);
            self.0
                .dots((0..=SAMPLES * 2).map(|step| at(radius, angle(step))), FAINT);
        }
        for angle in [from, to] {
            self.0.line(at(radii[0], angle), at(radii[1], angle), FAINT);
        }
    }

    fn ink(&mut self) {
        let above = self.seen();
        let View { app, .. } = self.0.view;
        for stroke in &app.ink {
            self.0.lines(stroke.iter().copied().map(above), INK);
        }
        self.0
            .dots(app.trail.iter().map(|tip| above(tip.above)), TRAIL);
    }

    fn arm(&mut self) {
        let above = self.seen();
        let look = self.0.view.look;
        let rail = look.rail();
        let base = (0..=SAMPLES).map(|step| {
            let angle = TAU * f64::from(step) / f64::from(SAMPLES);
            above([
                BASE_HALF_WIDTH * angle.cos(),
                BASE_HALF_WIDTH * angle.sin() + rail,
            ])
        });
        self.0.lines(base, FAINT);
        if slipped(look.slips()) {
            self.links(&look.commanded(), FAINT, FAINT);
        }
        let figure = look.figure();
        self.links(&figure, ARM, TOOL);
        self.0.mark(above(figure.tip_above()));
    }

    fn links(&mut self, figure: &Figure, arm: Color, tool: Color) {
        let above = self.seen();
        let shoulder = above([0.0, self.0.view.look.rail()]);
        let [elbow, wrist, tip] = [
            figure.elbow_above(),
            figure.wrist_above(),
            figure.tip_above(),
        ]
        .map(above);
        self.0.line(shoulder, elbow, arm);
        self.0.line(elbow, wrist, arm);
        self.0.line(wrist, tip, tool);
    }
}

/// View from the side, with r and z.
struct FromSide<'a, 'b, 'c>(Pen<'a, 'b, 'c>);

impl FromSide<'_, '_, '_> {
    fn surroundings(&mut self) {
        let View { app, look, .. } = self.0.view;
        let subject = app.subject();
        let reach = outline(look.tool, &subject.limits);
        self.0.dots(reach, FAINT);
        if let Some(table) = &subject.table {
            let height = table.height;
            self.0
                .line([-1000.0, height], [1000.0, height], Color::White);
        }
        let figure = look.figure();
        if let Some(belt) = &subject.conveyor {
            let cut = (0..=MAX_DRAWN_DISTANCE)
                .map(f64::from)
                .filter(|r| on_belt(belt, figure.out(*r)));
            self.0.dots(cut.map(|r| [r, belt.height]), FAINT);
        }
        for item in look.items.iter().filter(|item| item.rest != Support::Floor) {
            self.item(item, &figure);
        }
        self.0.dots(app.trail.iter().map(|tip| tip.beside), TRAIL);
    }

    /// Draws an object near the arm's plane.
    fn item(&mut self, item: &Item, figure: &Figure) {
        let [r, left] = figure.seen([item.place.x, item.place.y]);
        let half = item.size[0].max(item.size[1]) / 2.0;
        if left.abs() > half + MAX_PLANE_DISTANCE {
            return;
        }
        let (low, high) = (item.place.z, item.place.z + item.size[2]);
        let corners = [
            [r - half, low],
            [r + half, low],
            [r + half, high],
            [r - half, high],
        ];
        self.0.closed(corners, nearest(item.color));
    }

    fn arm(&mut self) {
        let View { app, look, .. } = self.0.view;
        let foot = app.subject().table.map_or(FOOT_Z, |table| table.height);
        self.0
            .line([-BASE_HALF_WIDTH, foot], [BASE_HALF_WIDTH, foot], FAINT);
        self.0.line(
            [-BASE_HALF_WIDTH, foot],
            [-BASE_HALF_WIDTH / 2.0, 0.0],
            FAINT,
        );
        self.0
            .line([BASE_HALF_WIDTH, foot], [BASE_HALF_WIDTH / 2.0, 0.0], FAINT);
        if slipped(look.slips()) {
            self.links(&look.commanded(), FAINT, FAINT);
        }
        let figure = look.figure();
        self.links(&figure, ARM, TOOL);
        self.0.mark(figure.tip);
    }

    fn links(&mut self, figure: &Figure, arm: Color, tool: Color) {
        self.0.line([0.0, 0.0], figure.elbow, arm);
        self.0.line(figure.elbow, figure.wrist, arm);
        self.0.line(figure.wrist, figure.tip, tool);
    }
}

/// True if a point x, y is on a belt.
fn on_belt(belt: &Conveyor, [x, y]: [f64; 2]) -> bool {
    let from = [x - belt.start[0], y - belt.start[1]];
    let [along, left] = turned([0.0, 0.0], -belt.direction, from);
    (0.0..=belt.length).contains(&along) && left.abs() <= belt.width / 2.0
}

/// True if a joint visibly deviates from its commanded angle.
fn slipped(slips: [f64; 4]) -> bool {
    slips.iter().any(|degrees| degrees.abs() > 0.5)
}

/// Converts a point from a frame at `[x, y]`, turned by `degrees`.
fn turned([x, y]: [f64; 2], degrees: f64, [along, left]: [f64; 2]) -> [f64; 2] {
    let (sin, cos) = degrees.to_radians().sin_cos();
    [x + along * cos - left * sin, y + along * sin + left * cos]
}
