//! A drawing as PNG.

use tiny_skia::{Color, LineCap, LineJoin, Paint, Path, PathBuilder, Pixmap, Transform};

use super::drawing::{Drawing, Stroke, StrokeKind};
use super::svg::{BURN_WIDTH, INK_WIDTH, MARK, PictureOptions, has_round_ends, seen};

/// Why a picture cannot be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PictureError {
    /// The scale is not a number above 0.
    #[error("a picture needs more than 0 pixels per millimetre, not {0}")]
    Scale(f64),
    /// It would have too many pixels.
    #[error(
        "the picture would be {width:.0} by {height:.0} pixels, limit {most} pixels: use fewer \
            pixels per millimetre"
    )]
    Size {
        /// Pixels across.
        width: f64,
        /// Pixels down.
        height: f64,
        /// The most pixels that a picture has.
        most: f64,
    },
    /// The encoder failed.
    #[error("the picture cannot be encoded: {0}")]
    Encode(String),
}

impl Drawing {
    /// As many pixels has the largest picture.
    pub const MOST_PIXELS: f64 = 64e6;

    /// The drawing as PNG: what [`to_svg`](Self::to_svg) shows, on white.
    ///
    /// # Errors
    /// [`PictureError`] if the scale makes no sense, or the picture would have more than
    /// [`MOST_PIXELS`](Self::MOST_PIXELS).
    pub fn to_png(&self, pixels_per_mm: f64) -> Result<Vec<u8>, PictureError> {
        self.to_png_with(pixels_per_mm, &PictureOptions::default())
    }

    /// The same with what [`to_svg_with`](Self::to_svg_with) shows.
    ///
    /// # Errors
    /// As [`to_png`](Self::to_png).
    pub fn to_png_with(
        &self,
        pixels_per_mm: f64,
        options: &PictureOptions,
    ) -> Result<Vec<u8>, PictureError> {
        if !(pixels_per_mm > 0.0 && pixels_per_mm.is_finite()) {
            return Err(PictureError::Scale(pixels_per_mm));
        }
        let [[left, bottom], [right, top]] = self.frame(options);
        let pixels = |mm: f64| (mm * pixels_per_mm).round().max(1.0);
        let [width, height] = [right - left, top - bottom].map(pixels);
        let most = Self::MOST_PIXELS;
        let size = PictureError::Size {
            width,
            height,
            most,
        };
        if width * height > most {
            return Err(size);
        }
        let mut picture = Pixmap::new(width as u32, height as u32).ok_or(size)?;
        picture.fill(Color::WHITE);
        let scale = pixels_per_mm as f32;
        let onto = Transform::from_row(
            scale,
            0.0,
            0.0,
            -scale,
            (-left * pixels_per_mm) as f32,
            (top * pixels_per_mm) as f32,
        );
        let sheet = options.sheet.as_deref().and_then(outline);
        let base = mark().filter(|_| self.shows_base(options));
        for path in sheet.iter().chain(&base) {
            let grey = [153, 153, 153, 255];
            line(&mut picture, path, grey, 0.3, LineCap::Round, onto);
        }
        for stroke in self.strokes() {
            draw(&mut picture, stroke, onto);
        }
        picture
            .encode_png()
            .map_err(|error| PictureError::Encode(error.to_string()))
    }
}

fn draw(picture: &mut Pixmap, stroke: &Stroke, onto: Transform) {
    let (color, width) = match stroke.kind {
        StrokeKind::Ink => ([26, 26, 26, 255], INK_WIDTH),
        // A conversion of a float saturates.
        StrokeKind::Burn => ([74, 37, 8, (stroke.power * 2.55) as u8], BURN_WIDTH),
    };
    if let [point] = stroke.points.as_slice() {
        let [x, y] = seen(*point).map(|value| value as f32);
        if let Some(dot) = PathBuilder::from_circle(x, y, width as f32 / 2.0) {
            let paint = paint(color);
            picture.fill_path(&dot, &paint, tiny_skia::FillRule::Winding, onto, None);
        }
        return;
    }
    let mut path = PathBuilder::new();
    for (nth, point) in stroke.points.iter().enumerate() {
        let [x, y] = seen(*point).map(|value| value as f32);
        if nth == 0 {
            path.move_to(x, y);
        } else {
            path.line_to(x, y);
        }
    }
    if let Some(path) = path.finish() {
        let ends = match has_round_ends(stroke) {
            true => LineCap::Round,
            false => LineCap::Butt,
        };
        line(picture, &path, color, width, ends, onto);
    }
}

/// Corners, joined all round.
fn outline(corners: &[[f64; 2]]) -> Option<Path> {
    let mut path = PathBuilder::new();
    for (nth, corner) in corners.iter().enumerate() {
        let [x, y] = seen(*corner).map(|value| value as f32);
        match nth {
            0 => path.move_to(x, y),
            _ => path.line_to(x, y),
        }
    }
    path.close();
    path.finish()
}

fn mark() -> Option<Path> {
    let radius = MARK as f32;
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
    ends: LineCap,
    onto: Transform,
) {
    let stroke = tiny_skia::Stroke {
        width: width as f32,
        line_cap: ends,
        line_join: LineJoin::Round,
        ..tiny_skia::Stroke::default()
    };
    picture.stroke_path(path, &paint(color), &stroke, onto, None);
}

fn paint([red, green, blue, opacity]: [u8; 4]) -> Paint<'static> {
    let mut paint = Paint {
        anti_alias: true,
        ..Paint::default()
    };
    paint.set_color_rgba8(red, green, blue, opacity);
    paint
}
