//! Rasteriser of a virtual arm and its world, for programs that learn from images. It draws no text
//! and no grid, and takes a hundredth of the time of the SVG.

use magician_host::{Geometry, JointAngles};
use magician_sim::Controller;
use magician_sim::scenario::Color;
use magician_sim::world::StrokeKind;
use resvg::tiny_skia::{
    self, FillRule, LineCap, LineJoin, Paint, PathBuilder, Pixmap, Stroke, Transform,
};

use super::{
    ABOVE_PART, BASE_BODY, BELT_COLOR, LINK_COLOR, LINK_THICKNESS, PLATE_THICKNESS, SIDE_PART,
    Snapshot, Surroundings, TABLE_COLOR, base_side_corners, links_from_above, links_from_side,
};
use crate::svg::palette::{BASE, DRAWN, INK};

/// Direction of view.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum View {
    /// From above: x to the right, y up.
    Top,
    /// From the side: distance from the base axis to the right, z up.
    Side,
}

/// Returns the pixels of a virtual arm and its world, RGB, rows from the top.
///
/// The content is that of [`Snapshot::of_world`] without text, scaled to fit. `None` if the size is
/// zero or exceeds 64 million pixels.
#[must_use]
pub fn pixels(arm: &Controller, view: View, [height, width]: [u32; 2]) -> Option<Vec<u8>> {
    if u64::from(height) * u64::from(width) > 64_000_000 {
        return None;
    }
    let (looks, around) = Snapshot::view_of(arm);
    let mut canvas = Canvas::new(view, [height, width])?;
    let geometry = Geometry::magician(looks.tool);
    match view {
        View::Top => above(&mut canvas, &geometry, &looks.joints, &around),
        View::Side => side(&mut canvas, &geometry, &looks.joints, &around),
    }
    // Everything is opaque, so premultiplied colours equal plain ones.
    let data = canvas.pixels.data().chunks_exact(4);
    Some(
        data.flat_map(|pixel| pixel.iter().copied().take(3))
            .collect(),
    )
}

struct Canvas {
    pixels: Pixmap,
    onto: Transform,
}

impl Canvas {
    fn new(view: View, [height, width]: [u32; 2]) -> Option<Self> {
        let [[left, bottom], [right, top]] = match view {
            View::Top => ABOVE_PART,
            View::Side => SIDE_PART,
        };
        let [across, down] = [f64::from(width), f64::from(height)];
        let scale = (across / (right - left)).min(down / (top - bottom));
        let [x, y] = [f64::midpoint(left, right), f64::midpoint(bottom, top)];
        let [dx, dy] = [across / 2.0 - x * scale, down / 2.0 + y * scale].map(|way| way as f32);
        let scale = scale as f32;
        let mut pixels = Pixmap::new(width, height)?;
        pixels.fill(tiny_skia::Color::WHITE);
        Some(Self {
            pixels,
            onto: Transform::from_row(scale, 0.0, 0.0, -scale, dx, dy),
        })
    }

    fn area(&mut self, corners: &[[f64; 2]], color: Color) {
        if let Some(path) = line(corners, true) {
            let paint = paint(color);
            self.pixels
                .fill_path(&path, &paint, FillRule::Winding, self.onto, None);
        }
    }

    fn rectangle(&mut self, [[x0, y0], [x1, y1]]: [[f64; 2]; 2], color: Color) {
        self.area(&[[x0, y0], [x1, y0], [x1, y1], [x0, y1]], color);
    }

    fn line(&mut self, points: &[[f64; 2]], width: f64, color: Color) {
        let stroke = Stroke {
            width: width as f32,
            line_cap: LineCap::Round,
            line_join: LineJoin::Round,
            ..Stroke::default()
        };
        if let [[x, y]] = points {
            self.dot([*x, *y], width / 2.0, color);
        } else if let Some(path) = line(points, false) {
            self.pixels
                .stroke_path(&path, &paint(color), &stroke, self.onto, None);
        }
    }

    fn dot(&mut self, [x, y]: [f64; 2], radius: f64, color: Color) {
        if let Some(path) = PathBuilder::from_circle(x as f32, y as f32, radius as f32) {
            let paint = paint(color);
            self.pixels
                .fill_path(&path, &paint, FillRule::Winding, self.onto, None);
        }
    }
}

/// Parses a colour of the palette.
fn shade(text: &str) -> Color {
    Color::parse(text).unwrap_or(Color::GREY)
}

fn paint(Color([red, green, blue]): Color) -> Paint<'static> {
    let mut paint = Paint::default();
    paint.set_color_rgba8(red, green, blue, 255);
    paint
}

fn line(points: &[[f64; 2]], closed: bool) -> Option<tiny_skia::Path> {
    let mut path = PathBuilder::new();
    for (nth, point) in points.iter().enumerate() {
        // Beyond any view, and within the numeric range of the rasteriser.
        let [x, y] = point.map(|value| value.clamp(-1e4, 1e4) as f32);
        match nth {
            0 => path.move_to(x, y),
            _ => path.line_to(x, y),
        }
    }
    if closed {
        path.close();
    }
    path.finish()
}

fn above(canvas: &mut Canvas, arm: &Geometry, joints: &JointAngles, around: &Surroundings) {
    if let Some((_, [[x0, x1], [y0, y1]])) = around.table {
        canvas.rectangle([[x0, y0], [x1, y1]], shade(TABLE_COLOR));
    }
    if let Some(belt) = &around.belt {
        canvas.area(&belt.corners(), shade(BELT_COLOR));
    }
    for stroke in around.drawing.strokes() {
        let width = match stroke.kind {
            StrokeKind::Ink => 1.2,
            StrokeKind::Burn => 0.8,
        };
        canvas.line(&stroke.points, width, shade(DRAWN));
    }
    let bodies = |canvas: &mut Canvas, held: bool| {
        for body in around.bodies.iter().filter(|body| body.is_held() == held) {
            canvas.area(&body.corners(), body.color);
        }
    };
    bodies(canvas, false);
    canvas.rectangle([[-BASE_BODY[0]; 2], [BASE_BODY[0]; 2]], shade(BASE));
    let [axis, wrist, tip] = links_from_above(arm, joints);
    canvas.line(&[axis, wrist], LINK_THICKNESS[0], shade(LINK_COLOR));
    canvas.line(&[wrist, tip], LINK_THICKNESS[0] / 3.0, shade(LINK_COLOR));
    bodies(canvas, true);
    canvas.dot(tip, 5.0, shade(INK));
}

fn side(canvas: &mut Canvas, arm: &Geometry, joints: &JointAngles, around: &Surroundings) {
    canvas.rectangle(base_side_corners(), shade(BASE));
    if let Some((height, [[_, far], _])) = around.table {
        canvas.rectangle(
            [[BASE_BODY[0], height - PLATE_THICKNESS], [far, height]],
            shade(TABLE_COLOR),
        );
    }
    if let Some(belt) = &around.belt {
        canvas.rectangle(belt.side_corners(), shade(BELT_COLOR));
    }
    for body in &around.bodies {
        canvas.rectangle(body.side_corners(), body.color);
    }
    let [shoulder, elbow, wrist, tip] = links_from_side(arm, joints);
    canvas.line(
        &[shoulder, elbow, wrist],
        LINK_THICKNESS[1],
        shade(LINK_COLOR),
    );
    canvas.line(&[wrist, tip], LINK_THICKNESS[1] / 2.0, shade(LINK_COLOR));
    canvas.dot(tip, 5.0, shade(INK));
}

#[cfg(test)]
mod tests {
    use super::*;
    use magician_sim::{Profile, Scenario, World};

    #[test]
    fn object_is_drawn_at_its_position() {
        let scenario = Scenario::from_toml(
            "table = { height = -60 }\n\
             object = [{ name = \"cube\", size = [40, 40, 40], at = [200, 200], color = \"#ff0102\" }]",
        );
        let world = World::from_scenario(&scenario.unwrap());
        let arm = Controller::in_world(Profile::default(), world);
        // One pixel per millimetre, except for the unused space.
        let seen = pixels(&arm, View::Top, [680, 460]).unwrap();
        let at = |x: usize, y: usize| &seen[(y * 460 + x) * 3..][..3];
        assert_eq!(seen.len(), 680 * 460 * 3);
        // x from -100, y downwards from 340.
        assert_eq!(at(300, 140), [0xff, 1, 2]);
        assert_eq!(at(300, 165), shade(TABLE_COLOR).0);
        assert_eq!(at(359, 340), shade(INK).0);
        let side = pixels(&arm, View::Side, [440, 450]).unwrap();
        let far = libm::hypot(200.0, 200.0) as usize;
        // Distance from -90, z downwards from 260.
        let at = |x: usize, z: usize| &side[(z * 450 + x) * 3..][..3];
        assert_eq!(at(90 + far, 260 + 40), [0xff, 1, 2]);
        assert_eq!(pixels(&arm, View::Top, [0, 10]), None);
    }
}
