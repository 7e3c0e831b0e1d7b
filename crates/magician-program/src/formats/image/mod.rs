//! PNG, JPEG and BMP images.
//!
//! Colours become grey by the weights of Rec. 709 (0.2126, 0.7152, 0.0722) on the values as they are stored; what is transparent
//! shows white below it; 16 bits are rounded to 8. An image that a camera holds turned (EXIF) is turned upright.

mod density;
#[cfg(test)]
mod tests;

use std::io::Cursor;

use ::image::{DynamicImage, ImageDecoder, ImageError, ImageFormat, ImageReader, Limits};

use super::{Content, ReadOptions, Reading};
use crate::{Problem, Raster};

/// Pixels on a side, at most.
const MOST_SIDE: u32 = 30_000;
/// Pixels in all, at most.
const MOST_PIXELS: u64 = 64_000_000;
/// Memory to decode them, at most, bytes.
const MOST_MEMORY: u64 = 512 << 20;

pub(super) fn read(bytes: &[u8], options: &ReadOptions) -> Result<Reading, Problem> {
    let format = ::image::guess_format(bytes).ok();
    let known = [ImageFormat::Png, ImageFormat::Jpeg, ImageFormat::Bmp];
    let format = format
        .filter(|format| known.contains(format))
        .ok_or_else(|| Problem::of_file("this is no PNG, JPEG or BMP image"))?;
    let (image, turned) = decode(bytes, format).map_err(refused)?;
    let (width, height) = (image.width() as usize, image.height() as usize);
    let pixel = density::pixel(format, bytes);
    let raster = Raster {
        title: options.title.clone(),
        width,
        height,
        grey: grey(image),
        pixel: pixel.map(|[x, y]| if turned { [y, x] } else { [x, y] }),
    };
    Ok(Reading {
        content: Content::Image(raster),
        notes: Vec::new(),
    })
}

/// The image, upright, and whether its sides have changed places for that.
fn decode(bytes: &[u8], format: ImageFormat) -> Result<(DynamicImage, bool), Refused> {
    let mut limits = Limits::default();
    limits.max_image_width = Some(MOST_SIDE);
    limits.max_image_height = Some(MOST_SIDE);
    limits.max_alloc = Some(MOST_MEMORY);
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    reader.limits(limits);
    let mut decoder = reader.into_decoder()?;
    let (width, height) = decoder.dimensions();
    if u64::from(width) * u64::from(height) > MOST_PIXELS {
        return Err(Refused::TooLarge([width, height]));
    }
    // A turn that cannot be read is none.
    let orientation = decoder.orientation().ok();
    let mut image = DynamicImage::from_decoder(decoder)?;
    if let Some(orientation) = orientation {
        image.apply_orientation(orientation);
    }
    let turned = width != height && (image.width(), image.height()) == (height, width);
    Ok((image, turned))
}

/// Why an image was not decoded.
enum Refused {
    TooLarge([u32; 2]),
    By(ImageError),
}

impl From<ImageError> for Refused {
    fn from(error: ImageError) -> Self {
        Self::By(error)
    }
}

fn refused(refused: Refused) -> Problem {
    let (why, too_large) = match refused {
        Refused::TooLarge([width, height]) => (format!("{width} by {height} pixels"), true),
        Refused::By(error @ ImageError::Limits(_)) => (error.to_string(), true),
        Refused::By(error) => (error.to_string(), false),
    };
    if too_large {
        let megapixels = MOST_PIXELS / 1_000_000;
        let most = format!("at most {MOST_SIDE} pixels on a side and {megapixels} million in all");
        return Problem::of_file(format!("the image is too large: {why}")).help(most);
    }
    Problem::of_file(format!("the image cannot be decoded: {why}"))
}

fn grey(image: DynamicImage) -> Vec<u8> {
    let has_alpha = image.color().has_alpha();
    let wide = image.color().bytes_per_pixel() > image.color().channel_count();
    match (wide, has_alpha) {
        (false, false) => image.into_luma8().into_raw(),
        (false, true) => over_white(image.into_luma_alpha8().as_raw(), 255, |value| value),
        (true, false) => {
            let wide = image.into_luma16().into_raw();
            wide.into_iter().map(to_8_bits).collect()
        }
        (true, true) => over_white(image.into_luma_alpha16().as_raw(), 65_535, to_8_bits),
    }
}

/// Pairs of grey and opacity over white, narrowed.
fn over_white<T>(pairs: &[T], full: u64, narrow: impl Fn(T) -> u8) -> Vec<u8>
where
    T: Copy + Into<u64> + TryFrom<u64>,
{
    let over = |grey: T, opacity: T| {
        let opacity: u64 = opacity.into();
        let shown = (grey.into() * opacity + full * (full - opacity) + full / 2) / full;
        T::try_from(shown).map_or(255, &narrow)
    };
    let pairs = pairs.chunks_exact(2);
    pairs
        .map(|pair| match pair {
            [grey, opacity] => over(*grey, *opacity),
            _ => 255,
        })
        .collect()
}

/// Rounds 0 to 65535 to 0 to 255.
fn to_8_bits(value: u16) -> u8 {
    let rounded = (u32::from(value) + 128) / 257;
    u8::try_from(rounded).unwrap_or(u8::MAX)
}
