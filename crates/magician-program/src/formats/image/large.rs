//! Images that are larger than anything that is drawn or burnt: made smaller while they are read.
//!
//! PNG is read row by row, so that memory is bounded whatever its size. Of JPEG only the brightness is decoded (by the weights of
//! Rec. 601, as the file has it), a byte for each pixel. Each pixel of what is kept is the mean of a square of pixels.

use std::io::Cursor;

use zune_core::bytestream::ZCursor;
use zune_core::colorspace::ColorSpace;
use zune_core::options::DecoderOptions;
use zune_jpeg::JpegDecoder;

use super::{MOST_MEMORY, grey_of};

/// As many pixels are kept, at most: a point of 0.1 mm on all that the arm reaches.
const KEPT: u64 = 16_000_000;
/// As many pixels are read, at most: minutes of work.
const MOST_READ: u64 = 4_000_000_000;
/// JPEG itself has no more pixels on a side.
const JPEG_SIDE: usize = 65_535;

/// A grey image that was made smaller.
pub(super) struct Smaller {
    pub(super) width: u32,
    pub(super) height: u32,
    pub(super) grey: Vec<u8>,
}

/// Why one is not read.
pub(super) type Why = String;

/// What becomes of rows.
struct Shrink {
    /// A pixel for each square of so many pixels on a side.
    each: usize,
    width: usize,
    sums: Vec<u32>,
    rows: u32,
    smaller: Smaller,
}

impl Shrink {
    fn new([width, height]: [u32; 2]) -> Result<Self, Why> {
        let pixels = u64::from(width) * u64::from(height);
        if pixels > MOST_READ {
            let most = MOST_READ / 1_000_000;
            return Err(format!("{width} by {height} pixels, limit {most} million"));
        }
        let mut each = 1_u32;
        while u64::from(width.div_ceil(each)) * u64::from(height.div_ceil(each)) > KEPT {
            each += 1;
        }
        let (columns, lines) = (width.div_ceil(each), height.div_ceil(each));
        Ok(Self {
            each: each as usize,
            width: width as usize,
            sums: vec![0; columns as usize],
            rows: 0,
            smaller: Smaller {
                width: columns,
                height: lines,
                grey: Vec::with_capacity(columns as usize * lines as usize),
            },
        })
    }

    fn row(&mut self, row: &[u8]) {
        for (sum, pixels) in self.sums.iter_mut().zip(row.chunks(self.each)) {
            *sum += pixels.iter().map(|grey| u32::from(*grey)).sum::<u32>();
        }
        self.rows += 1;
        if self.rows as usize == self.each {
            self.finish_row();
        }
    }

    fn finish_row(&mut self) {
        let (each, width, rows) = (self.each, self.width, self.rows);
        let means = self.sums.iter().enumerate().map(|(nth, sum)| {
            let across = each.min(width.saturating_sub(nth * each)).max(1);
            let count = u32::try_from(across).unwrap_or(1) * rows.max(1);
            u8::try_from((sum + count / 2) / count).unwrap_or(u8::MAX)
        });
        self.smaller.grey.extend(means);
        self.sums.fill(0);
        self.rows = 0;
    }

    fn finish(mut self) -> Smaller {
        if self.rows > 0 {
            self.finish_row();
        }
        self.smaller
    }
}

/// A PNG, row by row.
pub(super) fn png(bytes: &[u8]) -> Result<Smaller, Why> {
    let told = |error: png::DecodingError| error.to_string();
    let limits = png::Limits {
        bytes: usize::try_from(MOST_MEMORY).unwrap_or(usize::MAX),
    };
    let mut decoder = png::Decoder::new_with_limits(Cursor::new(bytes), limits);
    decoder.set_transformations(png::Transformations::normalize_to_color8());
    let mut reader = decoder.read_info().map_err(told)?;
    let info = reader.info();
    let size @ [width, _] = [info.width, info.height];
    if info.interlaced {
        return Err("it is interlaced; save it without interlacing".to_owned());
    }
    let (color, _) = reader.output_color_type();
    let mut shrink = Shrink::new(size)?;
    let mut grey = Vec::with_capacity(width as usize);
    while let Some(row) = reader.next_row().map_err(told)? {
        grey.clear();
        grey.extend(grey_of(row.data(), color.samples()));
        shrink.row(&grey);
    }
    Ok(shrink.finish())
}

/// A JPEG, of which only the brightness is decoded.
pub(super) fn jpeg(bytes: &[u8]) -> Result<Smaller, Why> {
    let options = DecoderOptions::default()
        .set_max_width(JPEG_SIDE)
        .set_max_height(JPEG_SIDE)
        .jpeg_set_out_colorspace(ColorSpace::Luma);
    let mut decoder = JpegDecoder::new_with_options(ZCursor::new(bytes), options);
    decoder
        .decode_headers()
        .map_err(|error| error.to_string())?;
    let info = decoder.info().ok_or("its header has no size")?;
    let size @ [width, height] = [u32::from(info.width), u32::from(info.height)];
    let pixels = u64::from(width) * u64::from(height);
    // One that comes line by line is kept as a byte for each pixel; of any other all numbers of all colours are.
    let (memory, how) = if comes_line_by_line(bytes) {
        (pixels, "")
    } else {
        let numbers = 2 * u64::from(info.components);
        (
            pixels * (1 + numbers),
            ", progressive; save it as a plain (baseline) JPEG",
        )
    };
    if memory > MOST_MEMORY {
        return Err(format!("{width} by {height} pixels{how}"));
    }
    let grey = decoder.decode().map_err(|error| error.to_string())?;
    let mut shrink = Shrink::new(size)?;
    for row in grey.chunks(width as usize).take(height as usize) {
        shrink.row(row);
    }
    Ok(shrink.finish())
}

/// Whether the frame of a JPEG is sequential (ITU-T T.81, table B.1: SOF0 and SOF1), and not progressive.
fn comes_line_by_line(bytes: &[u8]) -> bool {
    let mut rest = bytes.get(2..).unwrap_or_default();
    while let [0xFF, kind, after @ ..] = rest {
        match kind {
            0xC0 | 0xC1 => return true,
            // A marker may be filled up.
            0xFF => rest = rest.get(1..).unwrap_or_default(),
            // The other frames, and the first scan.
            0xC2 | 0xC3 | 0xC5..=0xC7 | 0xC9..=0xCB | 0xCD..=0xCF | 0xDA => return false,
            _ => {
                let [high, low, ..] = after else {
                    return false;
                };
                let length = usize::from(u16::from_be_bytes([*high, *low]));
                rest = after.get(length.max(2)..).unwrap_or_default();
            }
        }
    }
    false
}
