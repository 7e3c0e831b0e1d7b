//! Resolution of images as stored in their files.

use ::image::ImageFormat;

const MM_PER_INCH: f64 = 25.4;
/// Plausible sizes of a pixel, mm: 1 um to 100 mm. Other values are ignored.
const PIXEL_SIZE_RANGE: std::ops::RangeInclusive<f64> = 1e-3..=100.0;

/// Returns width and height of a pixel, mm, from PNG's `pHYs`, JFIF's density or BMP's resolution.
/// `None` if the file has none.
pub(super) fn pixel(format: ImageFormat, bytes: &[u8]) -> Option<[f64; 2]> {
    let pixel = match format {
        ImageFormat::Png => png(bytes),
        ImageFormat::Jpeg => jpeg(bytes),
        ImageFormat::Bmp => bmp(bytes),
        _ => None,
    }?;
    let sensible = pixel.iter().all(|side| PIXEL_SIZE_RANGE.contains(side));
    sensible.then_some(pixel)
}

/// Reads the chunk `pHYs` (PNG specification 11.3.4.3), which comes before the pixels.
fn png(bytes: &[u8]) -> Option<[f64; 2]> {
    let mut rest = bytes.get(8..)?;
    loop {
        let (length, after) = rest.split_first_chunk::<4>()?;
        let (kind, after) = after.split_first_chunk::<4>()?;
        let length = usize::try_from(u32::from_be_bytes(*length)).ok()?;
        let data = after.get(..length)?;
        match (kind, data) {
            (b"IDAT", _) => return None,
            (b"pHYs", [a, b, c, d, e, f, g, h, 1]) => {
                let per_metre = [[*a, *b, *c, *d], [*e, *f, *g, *h]].map(u32::from_be_bytes);
                return Some(per_metre.map(|count| 1000.0 / f64::from(count)));
            }
            _ => rest = after.get(length.checked_add(4)?..)?,
        }
    }
}

/// Reads the density of JFIF 1.02. Its marker APP0 directly follows the start of the image.
fn jpeg(bytes: &[u8]) -> Option<[f64; 2]> {
    let header = bytes.strip_prefix(&[0xFF, 0xD8, 0xFF, 0xE0])?.get(2..)?;
    let [_, _, unit, a, b, c, d] = *header.strip_prefix(b"JFIF\0")?.first_chunk::<7>()?;
    let length = match unit {
        1 => MM_PER_INCH,
        2 => 10.0,
        _ => return None,
    };
    let densities = [[a, b], [c, d]].map(u16::from_be_bytes);
    Some(densities.map(|count| length / f64::from(count)))
}

/// Reads the resolution from the header of 40 bytes and its successors.
fn bmp(bytes: &[u8]) -> Option<[f64; 2]> {
    let size = bytes.get(14..)?.first_chunk::<4>()?;
    if u32::from_le_bytes(*size) < 40 {
        return None;
    }
    let side = |at: usize| {
        let count = i32::from_le_bytes(*bytes.get(at..)?.first_chunk::<4>()?);
        Some(1000.0 / f64::from(count))
    };
    Some([side(38)?, side(42)?])
}
