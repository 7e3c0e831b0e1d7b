//! Image of the difference between two pictures.

use super::{Picture, distance};

/// Colour of the source, below the drawing.
const SOURCE_COLOR: [u8; 3] = [190, 196, 203];
/// Colour of drawn lines that match the source.
const DRAWN_COLOR: [u8; 3] = [26, 26, 26];
/// Colour of lines of the source that are missing in the drawing.
const MISSING_COLOR: [u8; 3] = [209, 26, 33];
/// Colour of drawn lines without a source.
const EXTRA_COLOR: [u8; 3] = [240, 140, 20];
/// Line widths of source and drawing, mm. The drawing is thinner, so that the source stays visible
/// below.
const LINE_WIDTHS: [f64; 2] = [0.5, 0.2];

pub(super) fn png(source: &Picture, drawn: &Picture, tolerance: f64) -> Vec<u8> {
    let [width, height] = source.frame().size();
    let mut image = Image {
        size: [width, height],
        pixels: vec![255; width * height * 3],
    };
    let [thick, thin] =
        LINE_WIDTHS.map(|width| (width * source.frame().pixels_per_mm() / 2.0) as i64);
    let to_source = distance::transform(source);
    let to_drawn = distance::transform(drawn);
    let mut paint =
        |picture: &Picture, field: &[f32], beyond_tolerance: bool, radius: i64, colour| {
            let pixels = picture.inked().iter().zip(field).enumerate();
            for (at, (_, distance)) in pixels.filter(|(_, (inked, _))| **inked) {
                if (f64::from(*distance) > tolerance) == beyond_tolerance {
                    dot(&mut image, at, radius, colour);
                }
            }
        };
    paint(source, &to_drawn, false, thick, SOURCE_COLOR);
    paint(drawn, &to_source, false, thin, DRAWN_COLOR);
    paint(source, &to_drawn, true, thick, MISSING_COLOR);
    paint(drawn, &to_source, true, thick, EXTRA_COLOR);
    // Writing to memory cannot fail, and the picture has pixels.
    image.png().unwrap_or_default()
}

/// RGB image, rows from the top.
struct Image {
    size: [usize; 2],
    pixels: Vec<u8>,
}

impl Image {
    fn put(&mut self, column: usize, row: usize, colour: [u8; 3]) {
        let at = (row * self.size[0] + column) * 3;
        if let Some(pixel) = self.pixels.get_mut(at..at + 3) {
            pixel.copy_from_slice(&colour);
        }
    }

    fn png(&self) -> Result<Vec<u8>, png::EncodingError> {
        let [width, height] = self.size.map(|side| u32::try_from(side).unwrap_or(0));
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, width, height);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_compression(png::Compression::Fast);
        encoder.write_header()?.write_image_data(&self.pixels)?;
        Ok(bytes)
    }
}

/// Draws a round dot at a pixel. Pictures start with the lowest row, images with the highest.
fn dot(image: &mut Image, at: usize, radius: i64, colour: [u8; 3]) {
    let [width, height] = image.size.map(|side| side as i64);
    let (column, row) = ((at as i64) % width.max(1), (at as i64) / width.max(1));
    for dy in -radius..=radius {
        for dx in -radius..=radius {
            let (x, y) = (column + dx, height - 1 - row - dy);
            let round = dx * dx + dy * dy <= radius * radius;
            if round && (0..width).contains(&x) && (0..height).contains(&y) {
                image.put(x as usize, y as usize, colour);
            }
        }
    }
}
