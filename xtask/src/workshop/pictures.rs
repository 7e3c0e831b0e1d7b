//! Reduces pictures in size before they are kept.

use std::collections::BTreeMap;
use std::error::Error;

use magician_picture::svg::palette::DRAWN;

use super::pieces::{Input, Piece};
use super::sheet::{Ink, corners_around, draw};

/// Margin around lines, mm.
const MARGIN: f64 = 5.0;
/// Number of grey levels in the picture of a file.
const SHADES: usize = 8;
/// Quantization steps of a PNG's colours: the finest that leaves at most 256 colours is used. All
/// divide 255, so that white stays white.
const STEPS: [u8; 5] = [1, 3, 5, 15, 17];

type Result<T> = std::result::Result<T, Box<dyn Error>>;

/// Returns the picture of a piece's file: its name, and its content unless it exists already.
pub(super) fn input(piece: &Piece, bytes: &[u8]) -> Result<Option<(String, Option<Vec<u8>>)>> {
    Ok(match &piece.input {
        Input::None | Input::Words => None,
        Input::File(file) | Input::Tones(file, _) => Some(own_picture(file, bytes)),
        Input::Lines(file, _) if file.ends_with(".svg") => Some(own_picture(file, bytes)),
        Input::Lines(_, reader) => {
            let lines = reader.lines(bytes)?;
            let frame = corners_around(lines.iter().map(|(_, line)| line.as_slice()), MARGIN);
            let inks = (1..=SHADES).map(|shade| Ink {
                colour: DRAWN,
                width: 0.5,
                opacity: shade as f64 / SHADES as f64,
                round: shade == SHADES,
                lines: lines
                    .iter()
                    .filter(|(dark, _)| (dark * SHADES as f64).ceil() as usize == shade)
                    .map(|(_, line)| line.as_slice())
                    .collect(),
            });
            let inks: Vec<_> = inks.collect();
            Some((
                format!("{}-input.svg", piece.name),
                Some(draw(frame, &inks).into_bytes()),
            ))
        }
    })
}

/// Returns a file that is itself a picture: one beside the page, or a copy of a sample.
fn own_picture(file: &str, bytes: &[u8]) -> (String, Option<Vec<u8>>) {
    let ours =
        std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/evidence/workshop/files");
    if ours.join(file).exists() {
        (format!("files/{file}"), None)
    } else {
        (file.to_owned(), Some(bytes.to_vec()))
    }
}

/// Converts a picture to one byte per pixel, with as many colours as that allows.
pub(super) fn reduced(picture: &[u8]) -> Result<Vec<u8>> {
    if !picture.starts_with(b"\x89PNG") {
        return Ok(picture.to_vec());
    }
    let mut reader = png::Decoder::new(std::io::Cursor::new(picture)).read_info()?;
    let mut pixels = vec![
        0;
        reader
            .output_buffer_size()
            .ok_or("a picture without size")?
    ];
    let info = reader.next_frame(&mut pixels)?;
    let samples = info.color_type.samples();
    let exact = pixels.chunks_exact(samples).map(|pixel| {
        [0, 1, 2].map(|channel| pixel.get(channel).or(pixel.first()).copied().unwrap_or(0))
    });
    let exact: Vec<[u8; 3]> = exact.collect();
    for step in STEPS {
        let mut colours = BTreeMap::new();
        let mut indices = Vec::new();
        for colour in &exact {
            let colour = colour.map(|value| value.saturating_add(step / 2) / step * step);
            let next = colours.len();
            indices.push(*colours.entry(colour).or_insert(next) as u8);
            if colours.len() > 256 {
                break;
            }
        }
        if colours.len() <= 256 {
            return indexed([info.width, info.height], &colours, &indices);
        }
    }
    Ok(picture.to_vec())
}

fn indexed(
    [width, height]: [u32; 2],
    colours: &BTreeMap<[u8; 3], usize>,
    indices: &[u8],
) -> Result<Vec<u8>> {
    let mut palette = vec![0; 3 * colours.len()];
    for (colour, index) in colours {
        if let Some(place) = palette.get_mut(3 * index..3 * index + 3) {
            place.copy_from_slice(colour);
        }
    }
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(png::ColorType::Indexed);
    encoder.set_palette(palette);
    encoder.set_compression(png::Compression::High);
    encoder.set_filter(png::Filter::NoFilter);
    encoder.write_header()?.write_image_data(indices)?;
    Ok(bytes)
}
