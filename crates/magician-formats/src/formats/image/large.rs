//! Large images, scaled down while they are decoded.
//!
//! Phones and scanners produce images far larger than anything the arm can draw. Each pixel kept is
//! the mean of a square of pixels, and only sums are held in memory:
//!
//! * PNG is decoded row by row and TIFF strip by strip, so memory is bounded at any size.
//! * Of JPEG only the luma plane (Rec. 601, as stored) is decoded, one byte per pixel.
//! * Other formats are decoded at once, as far as memory allows.

use std::io::Cursor;

use magician_host::{Message, message};
use zune_core::bytestream::ZCursor;
use zune_core::colorspace::ColorSpace;
use zune_core::options::DecoderOptions;
use zune_jpeg::JpegDecoder;

use super::crop::Window;
use super::{MAX_MEMORY, grey_of, opacity_of};

/// Largest number of pixels to keep: a point of 0.1 mm over the whole reach of the arm.
const MAX_KEPT_PIXELS: u64 = 16_000_000;
/// Largest number of pixels to decode, which takes minutes.
const MAX_DECODED_PIXELS: u64 = 4_000_000_000;
/// Largest side of a JPEG by its format.
const JPEG_MAX_SIDE: usize = 65_535;

/// A grey image, scaled down.
pub(super) struct ReducedImage {
    pub(super) width: u32,
    pub(super) height: u32,
    pub(super) grey: Vec<u8>,
    /// Opacities; empty if the image is opaque.
    pub(super) opacity: Vec<u8>,
}

/// Reason why an image is refused.
pub(super) type RefusalReason = Message;

/// Scales rows down as they arrive.
struct Reducer {
    /// Side of the square of pixels that becomes one.
    each: usize,
    window: Window,
    sums: Vec<u32>,
    /// Number of rows of the file so far.
    rows_read: u32,
    /// Number of rows in the sums.
    rows: u32,
    smaller: ReducedImage,
}

impl Reducer {
    fn new([width, height]: [u32; 2], window: Window) -> Result<Self, RefusalReason> {
        let pixels = u64::from(width) * u64::from(height);
        if pixels > MAX_DECODED_PIXELS {
            let most = MAX_DECODED_PIXELS / 1_000_000;
            return Err(message!(
                "{width} by {height} pixels, limit {most} million",
                width,
                height,
                most
            ));
        }
        let Window { width, height, .. } = window;
        let mut each = 1_u32;
        while u64::from(width.div_ceil(each)) * u64::from(height.div_ceil(each)) > MAX_KEPT_PIXELS {
            each += 1;
        }
        let (columns, lines) = (width.div_ceil(each), height.div_ceil(each));
        Ok(Self {
            each: each as usize,
            window,
            sums: vec![0; columns as usize],
            rows_read: 0,
            rows: 0,
            smaller: ReducedImage {
                width: columns,
                height: lines,
                grey: Vec::with_capacity(columns as usize * lines as usize),
                opacity: Vec::new(),
            },
        })
    }

    fn row(&mut self, row: &[u8]) {
        let Window {
            x,
            y,
            width,
            height,
        } = self.window;
        let nth = self.rows_read;
        self.rows_read += 1;
        if nth < y || nth - y >= height {
            return;
        }
        let row = row.get(x as usize..).unwrap_or_default();
        let row = row.get(..width as usize).unwrap_or(row);
        for (sum, pixels) in self.sums.iter_mut().zip(row.chunks(self.each)) {
            *sum += pixels.iter().map(|grey| u32::from(*grey)).sum::<u32>();
        }
        self.rows += 1;
        if self.rows as usize == self.each {
            self.finish_row();
        }
    }

    fn finish_row(&mut self) {
        let (each, width, rows) = (self.each, self.window.width as usize, self.rows);
        let means = self.sums.iter().enumerate().map(|(nth, sum)| {
            let across = each.min(width.saturating_sub(nth * each)).max(1);
            let count = u32::try_from(across).unwrap_or(1) * rows.max(1);
            u8::try_from((sum + count / 2) / count).unwrap_or(u8::MAX)
        });
        self.smaller.grey.extend(means);
        self.sums.fill(0);
        self.rows = 0;
    }

    fn finish(mut self) -> ReducedImage {
        if self.rows > 0 {
            self.finish_row();
        }
        self.smaller
    }
}

/// Scales rows of greys and of opacities down.
struct GreyAndOpacityReducer {
    grey: Reducer,
    opacity: Option<Reducer>,
}

impl GreyAndOpacityReducer {
    fn new(size: [u32; 2], window: Window, has_opacity: bool) -> Result<Self, RefusalReason> {
        let opacity = has_opacity.then(|| Reducer::new(size, window));
        Ok(Self {
            grey: Reducer::new(size, window)?,
            opacity: opacity.transpose()?,
        })
    }

    fn row(&mut self, grey: &[u8], opacity: &[u8]) {
        self.grey.row(grey);
        if let Some(shrink) = &mut self.opacity {
            shrink.row(opacity);
        }
    }

    fn finish(self) -> ReducedImage {
        let opacity = self.opacity.map(|shrink| shrink.finish().grey);
        ReducedImage {
            opacity: opacity.unwrap_or_default(),
            ..self.grey.finish()
        }
    }
}

/// Decodes a PNG row by row.
pub(super) fn png(bytes: &[u8], window: Window) -> Result<ReducedImage, RefusalReason> {
    let told = |error: png::DecodingError| Message::from(error.to_string());
    let limits = png::Limits {
        bytes: usize::try_from(MAX_MEMORY).unwrap_or(usize::MAX),
    };
    let mut decoder = png::Decoder::new_with_limits(Cursor::new(bytes), limits);
    decoder.set_transformations(png::Transformations::normalize_to_color8());
    let mut reader = decoder.read_info().map_err(told)?;
    let info = reader.info();
    let size @ [width, _] = [info.width, info.height];
    if info.interlaced {
        return Err(message!("it is interlaced; save it without interlacing"));
    }
    let (color, _) = reader.output_color_type();
    let samples = color.samples();
    let mut shrink = GreyAndOpacityReducer::new(size, window, has_opacity(samples))?;
    let mut grey = Vec::with_capacity(width as usize);
    let mut opacity = Vec::new();
    while let Some(row) = reader.next_row().map_err(told)? {
        grey.clear();
        grey.extend(grey_of(row.data(), samples));
        opacity.clear();
        opacity.extend(opacity_of(row.data(), samples));
        shrink.row(&grey, &opacity);
    }
    Ok(shrink.finish())
}

/// True if pixels with this number of samples have an opacity.
fn has_opacity(samples: usize) -> bool {
    matches!(samples, 2 | 4)
}

/// True if a JPEG stores luma separately, which it does not with four inks (CMYK).
pub(super) fn has_separate_luma(bytes: &[u8]) -> bool {
    let mut decoder = JpegDecoder::new(ZCursor::new(bytes));
    // An unreadable header fails with its reason when it is decoded.
    decoder.decode_headers().is_err() || decoder.info().is_none_or(|info| info.components < 4)
}

/// Decodes only the luma of a JPEG.
pub(super) fn jpeg(bytes: &[u8], window: Window) -> Result<ReducedImage, RefusalReason> {
    let options = DecoderOptions::default()
        .set_max_width(JPEG_MAX_SIDE)
        .set_max_height(JPEG_MAX_SIDE)
        .jpeg_set_out_colorspace(ColorSpace::Luma);
    let mut decoder = JpegDecoder::new_with_options(ZCursor::new(bytes), options);
    decoder
        .decode_headers()
        .map_err(|error| error.to_string())?;
    let info = decoder
        .info()
        .ok_or_else(|| message!("its header has no size"))?;
    let size @ [width, height] = [u32::from(info.width), u32::from(info.height)];
    let pixels = u64::from(width) * u64::from(height);
    // The decoder holds one byte per pixel of a sequential JPEG, but all coefficients of a
    // progressive one.
    let is_sequential = is_sequential(bytes);
    let memory = if is_sequential {
        pixels
    } else {
        pixels * (1 + 2 * u64::from(info.components))
    };
    if memory > MAX_MEMORY {
        return Err(if is_sequential {
            message!("{width} by {height} pixels", width, height)
        } else {
            message!(
                "{width} by {height} pixels, progressive; save it as a plain (baseline) JPEG",
                width,
                height
            )
        });
    }
    let grey = decoder.decode().map_err(|error| error.to_string())?;
    let mut shrink = Reducer::new(size, window)?;
    for row in grey.chunks(width as usize).take(height as usize) {
        shrink.row(row);
    }
    Ok(shrink.finish())
}

/// Decodes a TIFF by strips or rows of tiles.
pub(super) fn tiff(bytes: &[u8], window: Window) -> Result<ReducedImage, RefusalReason> {
    let told = |error: tiff::TiffError| error.to_string();
    let mut limits = tiff::decoder::Limits::default();
    limits.decoding_buffer_size = usize::try_from(MAX_MEMORY).unwrap_or(usize::MAX);
    let decoder = tiff::decoder::Decoder::new(Cursor::new(bytes)).map_err(told)?;
    let mut decoder = decoder.with_limits(limits);
    let (width, height) = decoder.dimensions().map_err(told)?;
    let color = decoder.colortype().map_err(told)?;
    let (samples, inverted) = match color {
        tiff::ColorType::Gray(8 | 16) => (1, false),
        tiff::ColorType::GrayA(8 | 16) => (2, false),
        tiff::ColorType::RGB(8 | 16) => (3, false),
        tiff::ColorType::RGBA(8 | 16) => (4, false),
        tiff::ColorType::CMYK(8 | 16) => (4, true),
        other => {
            let kind = format!("{other:?}");
            return Err(message!("a TIFF of {kind} is not read in this size", kind));
        }
    };
    let has_opacity = has_opacity(samples) && !inverted;
    let mut shrink = GreyAndOpacityReducer::new([width, height], window, has_opacity)?;
    let (across, down) = decoder.chunk_dimensions();
    if across == 0 || down == 0 {
        return Err(message!("its strips have no size"));
    }
    let columns = width.div_ceil(across);
    let mut band = vec![vec![u8::MAX; width as usize]; down.min(height) as usize];
    let mut clear = if has_opacity {
        band.clone()
    } else {
        Vec::new()
    };
    for row in 0..height.div_ceil(down) {
        let mut rows = 0;
        for column in 0..columns {
            let chunk = row * columns + column;
            let (wide, high) = decoder.chunk_data_dimensions(chunk);
            let data = match decoder.read_chunk(chunk).map_err(told)? {
                tiff::decoder::DecodingResult::U8(data) => data,
                tiff::decoder::DecodingResult::U16(data) => {
                    data.into_iter().map(super::to_8_bits).collect()
                }
                _ => return Err(message!("its numbers are of a kind that is not read")),
            };
            let from = (column * across) as usize;
            let lines = data.chunks(wide as usize * samples).take(high as usize);
            rows = rows.max(high as usize);
            for (line, to) in lines.clone().zip(&mut clear) {
                let to = to.get_mut(from..).unwrap_or_default().iter_mut();
                to.zip(opacity_of(line, samples))
                    .for_each(|(to, opacity)| *to = opacity);
            }
            for (line, to) in lines.zip(&mut band) {
                let to = to.get_mut(from..).unwrap_or_default().iter_mut();
                if inverted {
                    to.zip(line.chunks_exact(samples)).for_each(|(to, inks)| {
                        *to = grey_of_cmyk([inks[0], inks[1], inks[2], inks[3]]);
                    });
                } else {
                    to.zip(grey_of(line, samples))
                        .for_each(|(to, grey)| *to = grey);
                }
            }
        }
        for (nth, line) in band.iter().take(rows).enumerate() {
            shrink.row(line, clear.get(nth).map_or(&[], Vec::as_slice));
        }
    }
    Ok(shrink.finish())
}

/// Grey of cyan, magenta, yellow and black ink.
fn grey_of_cmyk(inks: [u8; 4]) -> u8 {
    let [cyan, magenta, yellow, black] = inks.map(|ink| u32::from(255 - ink));
    let shown = [cyan, magenta, yellow].map(|left| (left * black / 255) as u8);
    grey_of(&shown, 3).next().unwrap_or(u8::MAX)
}

/// Scales an image down that was decoded at once.
pub(super) fn decoded(
    grey: &[u8],
    opacity: &[u8],
    size: [u32; 2],
    window: Window,
) -> Result<ReducedImage, RefusalReason> {
    let mut shrink = GreyAndOpacityReducer::new(size, window, !opacity.is_empty())?;
    let width = size[0].max(1) as usize;
    let mut opacity = opacity.chunks(width);
    for row in grey.chunks(width) {
        shrink.row(row, opacity.next().unwrap_or_default());
    }
    Ok(shrink.finish())
}

/// True if the frame of a JPEG is sequential (ITU-T T.81, table B.1: SOF0 and SOF1), not
/// progressive.
fn is_sequential(bytes: &[u8]) -> bool {
    let mut markers = markers(bytes).map(|(kind, _)| kind);
    let frame =
        markers.find(|kind| matches!(kind, 0xC0..=0xC3 | 0xC5..=0xC7 | 0xC9..=0xCB | 0xCD..=0xCF));
    matches!(frame, Some(0xC0 | 0xC1))
}

/// True if a JPEG has no end (EOI). A decoder fills the missing part with grey.
pub(super) fn is_cut_off(bytes: &[u8]) -> bool {
    let scan = markers(bytes).find(|(kind, _)| *kind == 0xDA);
    let Some((_, scan)) = scan else {
        return false;
    };
    // Within a scan 0xFF is never followed by 0xD9. Phones append a video after the end, so the end
    // is not the last pair of bytes.
    !scan.windows(2).any(|pair| pair == [0xFF, 0xD9])
}

/// Iterates over the markers of a JPEG up to its first scan, with the bytes after each.
fn markers(bytes: &[u8]) -> impl Iterator<Item = (u8, &[u8])> {
    let mut rest = bytes.get(2..).unwrap_or_default();
    std::iter::from_fn(move || {
        // Fill bytes may precede a marker.
        while let [0xFF, 0xFF, ..] = rest {
            rest = rest.get(1..).unwrap_or_default();
        }
        let [0xFF, kind, after @ ..] = rest else {
            return None;
        };
        let length = match (kind, after) {
            (0xDA, _) | (_, [] | [_]) => after.len(),
            (_, [high, low, ..]) => usize::from(u16::from_be_bytes([*high, *low])).max(2),
        };
        rest = after.get(length..).unwrap_or_default();
        Some((*kind, after))
    })
}
