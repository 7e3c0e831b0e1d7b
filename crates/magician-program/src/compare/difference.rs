//! The difference of two pictures as an image.

use image::{ImageFormat, Rgb, RgbImage};

use super::{Picture, distance};

const SOURCE: Rgb<u8> = Rgb([190, 196, 203]);
const DRAWN: Rgb<u8> = Rgb([26, 26, 26]);
const MISSING: Rgb<u8> = Rgb([209, 26, 33]);
const EXTRA: Rgb<u8> = Rgb([240, 140, 20]);
/// How wide the lines of the source and of what is drawn are, mm.
const WIDTHS: [f64; 2] = [0.5, 0.2];

pub(super) fn png(source: &Picture, drawn: &Picture, tolerance: f64) -> Vec<u8> {
    let [width, height] = source
        .frame()
        .size()
        .map(|side| u32::try_from(side).unwrap_or(0));
    let mut image = RgbImage::from_pixel(width, height, Rgb([255, 255, 255]));
    let [thick, thin] = WIDTHS.map(|width| (width * source.frame().pixels_per_mm() / 2.0) as i64);
    let to_source = distance::field(source);
    let to_drawn = distance::field(drawn);
    let mut paint = |picture: &Picture, field: &[f32], far: bool, half: i64, colour| {
        let places = picture.inked().iter().zip(field).enumerate();
        for (at, (_, distance)) in places.filter(|(_, (inked, _))| **inked) {
            if (f64::from(*distance) > tolerance) == far {
                dot(&mut image, at, half, colour);
            }
        }
    };
    paint(source, &to_drawn, false, thick, SOURCE);
    paint(drawn, &to_source, false, thin, DRAWN);
    paint(source, &to_drawn, true, thick, MISSING);
    paint(drawn, &to_source, true, thick, EXTRA);
    let mut bytes = std::io::Cursor::new(Vec::new());
    // Writing to memory does not fail for a picture that has pixels.
    let _ = image.write_to(&mut bytes, ImageFormat::Png);
    bytes.into_inner()
}

/// A round dot about a pixel; the lowest row is the image's last.
fn dot(image: &mut RgbImage, at: usize, half: i64, colour: Rgb<u8>) {
    let [width, height] = [image.width(), image.height()].map(i64::from);
    let (column, row) = ((at as i64) % width.max(1), (at as i64) / width.max(1));
    for dy in -half..=half {
        for dx in -half..=half {
            let (x, y) = (column + dx, height - 1 - row - dy);
            let round = dx * dx + dy * dy <= half * half;
            if round && (0..width).contains(&x) && (0..height).contains(&y) {
                image.put_pixel(x as u32, y as u32, colour);
            }
        }
    }
}
