//! Reader of images: PNG, JPEG, BMP, WebP, GIF (first frame), TIFF and netpbm (PGM, PBM, PPM).
//!
//! Colours become grey by the weights of Rec. 709 (0.2126, 0.7152, 0.0722) on the stored values.
//! Transparent pixels are composed over white, and their opacity is kept. 16 bits are rounded to 8.
//! EXIF orientation is applied. Images too large to draw are scaled down while they are decoded
//! ([`large`]), with a note.

mod crop;
mod density;
mod large;
#[cfg(test)]
mod tests;

use std::io::Cursor;

use ::image::metadata::Orientation;
use ::image::{
    DynamicImage, GrayImage, ImageDecoder, ImageError, ImageFormat, ImageReader, Limits,
};
use magician_host::{Message, message};
use magician_host::{Setting, SettingValue};

use super::{Content, Parsed, ReadOptions};
use crate::{Diagnostic, DiagnosticCode, Raster};

use crop::Window;
use large::ReducedImage;

/// Largest side to decode at once, pixels. Larger images are scaled down while they are decoded.
const MAX_SIDE: u32 = 30_000;
/// Largest number of pixels to decode at once.
const MAX_PIXELS: u64 = 64_000_000;
/// Largest memory for decoding, bytes. A damaged header must not make the decoder allocate more.
const MAX_MEMORY: u64 = 512 << 20;

pub(super) fn read(bytes: &[u8], options: &ReadOptions) -> Result<Parsed, Diagnostic> {
    let format = ::image::guess_format(bytes).ok();
    let format = format
        .filter(|format| SUPPORTED_FORMATS.contains(format))
        .ok_or_else(unknown)?;
    let Decoded {
        grey,
        opacity,
        size: [width, height],
        turned,
        whole,
    } = decode(bytes, format, options.crop).map_err(refused)?;
    let kept = [grey.width(), grey.height()];
    let mut pixel =
        density::pixel(format, bytes).map(|[x, y]| if turned { [y, x] } else { [x, y] });
    let mut notes = Vec::new();
    if kept != [width, height] {
        // Enlarge the pixels, so that the image keeps its size on paper.
        let [across, down] = pixel.unwrap_or([Raster::DEFAULT_PIXEL_SIZE; 2]);
        let more = |pixels: u32, kept: u32| f64::from(pixels) / f64::from(kept);
        pixel = Some([across * more(width, kept[0]), down * more(height, kept[1])]);
        let of = if whole {
            message!("the image")
        } else {
            message!("what is kept of the image")
        };
        let message = message!(
            "{of} has {width} by {height} pixels: it is scaled down to {kept} by {kept_2} on reading",
            of,
            width,
            height,
            kept = kept[0],
            kept_2 = kept[1]
        );
        notes.push(Diagnostic::of_file(message).coded(DiagnosticCode::Assumed));
    }
    let pictures = match format {
        ImageFormat::Gif => frame_count(bytes),
        _ => 1,
    };
    if pictures > 1 {
        let message = message!(
            "the image is animated: only the first of its {pictures} pictures is used",
            pictures
        );
        let note = Diagnostic::of_file(message).coded(DiagnosticCode::LeftOut);
        notes.push(note.help(message!(
            "save another one of them as an image of its own to use that"
        )));
    }
    if format == ImageFormat::Jpeg && large::is_cut_off(bytes) {
        let message = message!("the file is cut off: what is missing of the image is grey");
        notes.push(Diagnostic::of_file(message).coded(DiagnosticCode::LeftOut));
    }
    let raster = Raster {
        title: options.title.clone(),
        width: kept[0] as usize,
        height: kept[1] as usize,
        grey: grey.into_raw(),
        opacity: opacity.map(GrayImage::into_raw).unwrap_or_default(),
        pixel,
    };
    Ok(Parsed {
        content: Content::Image(raster),
        notes,
    })
}

/// Counts the frames of a GIF by its blocks (GIF89a, sections 18 to 25), without decoding.
fn frame_count(bytes: &[u8]) -> usize {
    let table = |flags: u8| match flags & 0x80 {
        0 => 0,
        _ => 3 << ((flags & 7) + 1),
    };
    // Skips data sub-blocks, each preceded by its length, up to the empty one.
    let behind_data = |mut at: usize| {
        while let Some(length) = bytes.get(at).filter(|length| **length > 0) {
            at += 1 + usize::from(*length);
        }
        at + 1
    };
    let mut at = 13 + bytes.get(10).copied().map_or(0, table);
    let mut count = 0;
    loop {
        match bytes.get(at) {
            Some(b'!') => at = behind_data(at + 2),
            Some(b',') => {
                count += 1;
                let flags = bytes.get(at + 9).copied().unwrap_or_default();
                at = behind_data(at + 10 + table(flags) + 1);
            }
            // The trailer, or damaged data: count the frames so far.
            _ => return count,
        }
    }
}

/// Supported formats.
const SUPPORTED_FORMATS: [ImageFormat; 7] = [
    ImageFormat::Png,
    ImageFormat::Jpeg,
    ImageFormat::Bmp,
    ImageFormat::WebP,
    ImageFormat::Gif,
    ImageFormat::Tiff,
    ImageFormat::Pnm,
];

fn unknown() -> Diagnostic {
    Diagnostic::of_file(message!(
        "this is not a PNG, JPEG, BMP, WebP, GIF, TIFF or PNM image"
    ))
    .help(message!("save it as one of these"))
}

/// A decoded image, upright.
struct Decoded {
    grey: GrayImage,
    /// Opacities; `None` if the image is opaque.
    opacity: Option<GrayImage>,
    /// Size in pixels, upright and cropped, before scaling down.
    size: [u32; 2],
    /// True if the orientation swapped width and height.
    turned: bool,
    /// True if nothing was cropped.
    whole: bool,
}

fn decode(
    bytes: &[u8],
    format: ImageFormat,
    crop: Option<[u32; 4]>,
) -> Result<Decoded, DecodeFailure> {
    let limits = |side: u32| {
        let mut limits = Limits::default();
        limits.max_image_width = Some(side);
        limits.max_image_height = Some(side);
        limits.max_alloc = Some(MAX_MEMORY);
        limits
    };
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    // No size limit here: the header is read first, and the path is chosen by its size.
    reader.limits(limits(u32::MAX));
    let mut decoder = reader.into_decoder()?;
    let size @ [width, height] = <[u32; 2]>::from(decoder.dimensions());
    // An unreadable orientation counts as none.
    let orientation = decoder.orientation().unwrap_or(Orientation::NoTransforms);
    let window = Window::new(size, orientation, crop).map_err(DecodeFailure::Crop)?;
    let large = width.max(height) > MAX_SIDE || u64::from(width) * u64::from(height) > MAX_PIXELS;
    let (grey, opacity) = if large {
        let smaller = match format {
            ImageFormat::Png => large::png(bytes, window),
            ImageFormat::Jpeg if large::has_separate_luma(bytes) => large::jpeg(bytes, window),
            ImageFormat::Tiff => large::tiff(bytes, window),
            // Other formats cannot be decoded in parts.
            _ if decoder.total_bytes() > MAX_MEMORY => return Err(DecodeFailure::TooLarge(size)),
            _ => {
                decoder.set_limits(limits(u32::MAX))?;
                let image = DynamicImage::from_decoder(decoder)?;
                let opacity = opacity(&image);
                large::decoded(&grey(image), &opacity, size, window)
            }
        };
        let ReducedImage {
            width,
            height,
            grey,
            opacity,
        } = smaller.map_err(DecodeFailure::Large)?;
        let cut_off = || DecodeFailure::Large(message!("it is cut off"));
        let plane = |plane: Vec<u8>| GrayImage::from_raw(width, height, plane).ok_or_else(cut_off);
        let opacity = Some(opacity).filter(|opacity| !opacity.is_empty());
        (plane(grey)?, opacity.map(plane).transpose()?)
    } else {
        decoder.set_limits(limits(MAX_SIDE))?;
        let image = DynamicImage::from_decoder(decoder)?;
        let image = match crop {
            Some(_) => image.crop_imm(window.x, window.y, window.width, window.height),
            None => image,
        };
        let [width, height] = [image.width(), image.height()];
        let opacity = Some(opacity(&image)).filter(|opacity| !opacity.is_empty());
        let plane = |plane: Vec<u8>| GrayImage::from_raw(width, height, plane).unwrap_or_default();
        (plane(grey(image)), opacity.map(plane))
    };
    let upright = |plane: GrayImage| {
        let mut plane = DynamicImage::from(plane);
        plane.apply_orientation(orientation);
        plane.into_luma8()
    };
    let turned = crop::swaps_sides(orientation);
    let kept = [window.width, window.height];
    Ok(Decoded {
        grey: upright(grey),
        opacity: opacity.filter(|opacity| !is_opaque(opacity)).map(upright),
        size: if turned { [kept[1], kept[0]] } else { kept },
        turned,
        whole: crop.is_none(),
    })
}

/// Reason why an image was not decoded.
enum DecodeFailure {
    TooLarge([u32; 2]),
    /// The crop is outside the image.
    Crop(Message),
    /// Error while scaling a large image down.
    Large(Message),
    By(ImageError),
}

impl From<ImageError> for DecodeFailure {
    fn from(error: ImageError) -> Self {
        Self::By(error)
    }
}

fn refused(refused: DecodeFailure) -> Diagnostic {
    let (why, too_large) = match refused {
        DecodeFailure::TooLarge([width, height]) => {
            (message!("{width} by {height} pixels", width, height), true)
        }
        DecodeFailure::Crop(why) => {
            return Diagnostic::of_file(why).remedy(
                (Setting::Crop, SettingValue::Any("X,Y,W,H")),
                "keeps another part of it",
            );
        }
        DecodeFailure::Large(why) => {
            return Diagnostic::of_file(message!(
                "the image is too large to be read at once: {why}",
                why
            ));
        }
        DecodeFailure::By(error @ ImageError::Limits(_)) => (error.to_string().into(), true),
        DecodeFailure::By(ImageError::Unsupported(_)) => {
            let message = message!(
                "the image is of a kind that is not read, such as a fax (CCITT G3) or \
                numbers with a fraction"
            );
            return Diagnostic::of_file(message).help(message!("save it as PNG or JPEG"));
        }
        DecodeFailure::By(error) => (error.to_string().into(), false),
    };
    if too_large {
        let help = message!("save it as a PNG, JPEG or TIFF, which may have any size");
        return Diagnostic::of_file(message!("the image is too large: {why}", why)).help(help);
    }
    Diagnostic::of_file(message!("the image cannot be decoded: {why}", why))
}

/// True if every pixel is opaque.
fn is_opaque(opacity: &[u8]) -> bool {
    opacity.iter().all(|opacity| *opacity == u8::MAX)
}

/// Opacity of each pixel; empty if the image has no alpha channel.
fn opacity(image: &DynamicImage) -> Vec<u8> {
    if !image.color().has_alpha() {
        return Vec::new();
    }
    let wide = image.color().bytes_per_pixel() > image.color().channel_count();
    if wide {
        let image = image.to_luma_alpha16();
        image.pixels().map(|pixel| to_8_bits(pixel.0[1])).collect()
    } else {
        image
            .to_luma_alpha8()
            .pixels()
            .map(|pixel| pixel.0[1])
            .collect()
    }
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

/// Iterates over the greys of 8-bit pixels with 1 to 4 samples: grey, grey and alpha, RGB, RGBA.
fn grey_of(row: &[u8], samples: usize) -> impl Iterator<Item = u8> {
    let luma = |red: u8, green: u8, blue: u8| {
        // The same integer weights as the `image` crate uses, so that large and small images match.
        let sum = 2126 * u32::from(red) + 7152 * u32::from(green) + 722 * u32::from(blue);
        u8::try_from(sum / 10_000).unwrap_or(u8::MAX)
    };
    let over = |grey: u8, opacity: u8| {
        let (grey, opacity) = (u32::from(grey), u32::from(opacity));
        let shown = (grey * opacity + 255 * (255 - opacity) + 127) / 255;
        u8::try_from(shown).unwrap_or(u8::MAX)
    };
    row.chunks_exact(samples.max(1))
        .map(move |pixel| match *pixel {
            [grey] => grey,
            [grey, opacity] => over(grey, opacity),
            [red, green, blue] => luma(red, green, blue),
            [red, green, blue, opacity] => over(luma(red, green, blue), opacity),
            _ => u8::MAX,
        })
}

/// Iterates over the opacities of 8-bit pixels as in [`grey_of`]; opaque if they have none.
fn opacity_of(row: &[u8], samples: usize) -> impl Iterator<Item = u8> {
    row.chunks_exact(samples.max(1)).map(|pixel| match *pixel {
        [_, opacity] | [_, _, _, opacity] => opacity,
        _ => u8::MAX,
    })
}

/// Composes pairs of grey and opacity over white, and narrows them to 8 bits.
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

/// Scales 16 bits to 8 with rounding.
fn to_8_bits(value: u16) -> u8 {
    let rounded = (u32::from(value) + 128) / 257;
    u8::try_from(rounded).unwrap_or(u8::MAX)
}
