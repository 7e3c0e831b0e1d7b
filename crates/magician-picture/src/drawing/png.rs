//! Rasteriser of drawings to PNG, without an intermediate SVG.

use magician_sim::world::{Drawing, Stroke, StrokeKind};
use resvg::tiny_skia::{
    self, Color, FillRule, LineCap, LineJoin, Paint, Path, PathBuilder, Pixmap, Transform,
};

use super::{
    BASE_MARK_RADIUS, BURN_WIDTH, DrawingOptions, INK_WIDTH, has_round_ends, project, shown_part,
    shows_base,
};
use crate::png::{MAX_PIXELS, PictureError};

/// Returns the picture of a drawing as PNG: the content of [`drawing_svg`](crate::drawing_svg), on
/// white, at this resolution.
///
/// # Errors
/// [`PictureError`] if the scale is not positive and finite, or the picture would have more than 64
/// million pixels.
pub fn drawing_png(
    drawing: &Drawing,
    pixels_per_mm: f64,
    options: &DrawingOptions,
) -> Result<Vec<u8>, PictureError> {
    if !(pixels_per_mm > 0.0 && pixels_per_mm.is_finite()) {
        return Err(PictureError::Scale(pixels_per_mm));
    }
    let [[left, bottom], [right, top]] = shown_part(drawing, options);
    let pixels = |mm: f64| (mm * pixels_per_mm).round().max(1.0);
    let [width, height] = [right - left, top - bottom].map(pixels);
    let size = PictureError::Size([width, height]);
    if width * height > MAX_PIXELS {
        return Err(size);
    }
    let mut picture = Pixmap::new(width as u32, height as u32).ok_or(size)?;
    picture.fill(Color::WHITE);
    let scale = pixels_per_mm as f32;
    let to_pixels = Transform::from_row(
        scale,
        0.0,
        0.0,
        -scale,
        (-left * pixels_per_mm) as f32,
        (top * pixels_per_mm) as f32,
    );
    let sheet = options.sheet.as_deref().and_then(outline);
    let base = base_mark().filter(|_| shows_base(drawing, options));
    for path in sheet.iter().chain(&base) {
        let grey = [153, 153, 153, 255];
        line(&mut picture, path, grey, 0.3, LineCap::Round, to_pixels);
    }
    for stroke in drawing.strokes() {
        draw(&mut picture, stroke, to_pixels);
    }
    picture
        .encode_png()
        .map_err(|error| PictureError::Drawing(error.to_string()))
}

fn draw(picture: &mut Pixmap, stroke: &Stroke, to_pixels: Transform) {
    let (color, width) = match stroke.kind {
        StrokeKind::Ink => ([26, 26, 26, 255], INK_WIDTH),
        // A cast from float saturates.
        StrokeKind::Burn => ([74, 37, 8, (stroke.power * 2.55) as u8], BURN_WIDTH),
    };
    if let [point] = stroke.points.as_slice() {
        let [x, y] = project(*point).map(|value| value as f32);
        if let Some(dot) = PathBuilder::from_circle(x, y, width as f32 / 2.0) {
            let paint = paint(color);
            picture.fill_path(&dot, &paint, FillRule::Winding, to_pixels, None);
        }
        return;
    }
    let mut path = PathBuilder::new();
    for (nth, point) in stroke.points.iter().enumerate() {
        let [x, y] = project(*point).map(|value| value as f32);
        if nth == 0 {
            path.move_to(x, y);
        } else {
            path.line_to(x, y);
        }
    }
    if let Some(path) = path.finish() {
        let cap = if has_round_ends(stroke) {
            LineCap::Round
        } else {
            LineCap::Butt
        };
        line(picture, &path, color, width, cap, to_pixels);
    }
}

/// Returns a closed path along corners.
fn outline(corners: &[[f64; 2]]) -> Option<Path> {
    let mut path = PathBuilder::new();
    for (nth, corner) in corners.iter().enumerate() {
        let [x, y] = project(*corner).map(|value| value as f32);
        match nth {
            0 => path.move_to(x, y),
            _ => path.line_to(x, y),
        }
    }
    path.close();
    path.finish()
}

fn base_mark() -> Option<Path> {
    let radius = BASE_MARK_RADIUS as f32;
    let mut path = PathBuilder::new();
    path.push_circle(0.0, 0.0, radius);
    path.move_to(-radius, 0.0);
    path.line_to(radius, 0.0);
    path.move_to(0.0, -radius);
    path.line_to(0.0, radius);
    path.finish()
}

fn line(
    picture: &mut Pixmap,
    path: &Path,
    color: [u8; 4],
    width: f64,
    cap: LineCap,
    to_pixels: Transform,
) {
    let stroke = tiny_skia::Stroke {
        width: width as f32,
        line_cap: cap,
        line_join: LineJoin::Round,
        ..tiny_skia::Stroke::default()
    };
    picture.stroke_path(path, &paint(color), &stroke, to_pixels, None);
}

fn paint([red, green, blue, opacity]: [u8; 4]) -> Paint<'static> {
    let mut paint = Paint {
        anti_alias: true,
        ..Paint::default()
    };
    paint.set_color_rgba8(red, green, blue, opacity);
    paint
}
