//! Tests of the image reader, including large, turned, cropped and damaged images.

use ::image::{DynamicImage, GenericImage, Luma, Rgba};
use proptest::prelude::*;

use super::*;
use crate::formats::image::crop::Window;
use crate::{Format, read};

fn raster(bytes: &[u8]) -> Raster {
    let read = read(Format::Image, bytes, &ReadOptions::default()).unwrap();
    match read.content {
        Content::Image(image) => image,
        other => panic!("{other:?}"),
    }
}

fn refusal(bytes: &[u8]) -> String {
    let diagnostic = read(Format::Image, bytes, &ReadOptions::default()).unwrap_err();
    diagnostic.message.into()
}

fn encoded(image: impl Into<DynamicImage>, format: ImageFormat) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    image.into().write_to(&mut bytes, format).unwrap();
    bytes.into_inner()
}

/// Four pixels of a palette (black, red, blue, transparent), 0.1 by 0.2 mm each.
const PALETTE: &[u8] = &[
    0x89, 0x50, 0x4E, 0x47, 0x0D, 0x0A, 0x1A, 0x0A, 0x00, 0x00, 0x00, 0x0D, 0x49, 0x48, 0x44, 0x52,
    0x00, 0x00, 0x00, 0x04, 0x00, 0x00, 0x00, 0x01, 0x02, 0x03, 0x00, 0x00, 0x00, 0x84, 0x52, 0xE7,
    0x5E, 0x00, 0x00, 0x00, 0x0C, 0x50, 0x4C, 0x54, 0x45, 0x00, 0x00, 0x00, 0xFF, 0x00, 0x00, 0x00,
    0x00, 0xFF, 0xFF, 0xFF, 0xFF, 0xA2, 0x1D, 0x1B, 0x3E, 0x00, 0x00, 0x00, 0x04, 0x74, 0x52, 0x4E,
    0x53, 0xFF, 0xFF, 0xFF, 0x00, 0x40, 0x2A, 0xA9, 0xF4, 0x00, 0x00, 0x00, 0x09, 0x70, 0x48, 0x59,
    0x73, 0x00, 0x00, 0x27, 0x10, 0x00, 0x00, 0x13, 0x88, 0x01, 0x0E, 0x93, 0x1C, 0x47, 0x00, 0x00,
    0x00, 0x0A, 0x49, 0x44, 0x41, 0x54, 0x78, 0x9C, 0x63, 0x90, 0x06, 0x00, 0x00, 0x1D, 0x00, 0x1C,
    0x8E, 0xF4, 0xF5, 0x21, 0x00, 0x00, 0x00, 0x00, 0x49, 0x45, 0x4E, 0x44, 0xAE, 0x42, 0x60, 0x82,
];

#[test]
fn colours_become_grey_by_weight_and_transparent_pixels_white() {
    let image = raster(PALETTE);
    assert_eq!((image.width, image.height), (4, 1));
    assert_eq!(image.grey, [0, 54, 18, 255]);
    assert_eq!(image.pixel, Some([0.1, 0.2]));

    let mut glass = DynamicImage::new_rgba8(3, 1);
    glass.put_pixel(0, 0, Rgba([0, 0, 0, 51]));
    glass.put_pixel(1, 0, Rgba([0, 255, 0, 255]));
    glass.put_pixel(2, 0, Rgba([9, 9, 9, 0]));
    for format in [ImageFormat::Png, ImageFormat::Bmp] {
        assert_eq!(
            raster(&encoded(glass.clone(), format)).grey,
            [204, 182, 255]
        );
    }
}

#[test]
fn sixteen_bits_are_rounded() {
    let wide = |values: [u16; 4]| {
        let image = ::image::ImageBuffer::<Luma<u16>, _>::from_raw(4, 1, values.to_vec());
        raster(&encoded(image.unwrap(), ImageFormat::Png)).grey
    };
    assert_eq!(wide([0, 128, 129, 65_535]), [0, 0, 1, 255]);
    let half = ::image::ImageBuffer::<Rgba<u16>, _>::from_raw(1, 1, vec![0, 0, 0, 32_768]);
    assert_eq!(
        raster(&encoded(half.unwrap(), ImageFormat::Png)).grey,
        [127]
    );
}

/// A JPEG with a black and a white half, a JFIF density and an EXIF orientation.
fn photo(turn: u8) -> Vec<u8> {
    let mut image = DynamicImage::new_luma8(16, 8);
    for at in 0..64 {
        image.put_pixel(8 + at % 8, at / 8, Rgba([255; 4]));
    }
    let plain = encoded(image, ImageFormat::Jpeg);
    // Inserted after the start of the image: JFIF with 254 by 127 dots per inch, and EXIF with one
    // entry.
    let jfif = b"\xFF\xE0\x00\x10JFIF\0\x01\x02\x01\x00\xFE\x00\x7F\0\0";
    let entry = [0x12, 0x01, 3, 0, 1, 0, 0, 0, turn, 0, 0, 0];
    let tiff = [&b"II*\0\x08\0\0\0\x01\0"[..], &entry, &[0; 4]].concat();
    let length = (2 + 6 + tiff.len()) as u8;
    let exif = [&[0xFF, 0xE1, 0, length][..], b"Exif\0\0", &tiff].concat();
    [&plain[..2], jfif, &exif, &plain[2..]].concat()
}

#[test]
fn photo_is_upright_with_its_declared_pixel_size() {
    let plain = raster(&photo(1));
    assert_eq!((plain.width, plain.height), (16, 8));
    assert!(plain.grey[0] < 10 && plain.grey[15] > 245);
    let [x, y] = plain.pixel.unwrap();
    assert!((x - 0.1).abs() < 1e-12 && (y - 0.2).abs() < 1e-12);

    // Orientation 6 turns the image clockwise: its right side becomes the bottom.
    let upright = raster(&photo(6));
    assert_eq!((upright.width, upright.height), (8, 16));
    assert!(upright.grey[0] < 10 && upright.grey[127] > 245);
    let [x, y] = upright.pixel.unwrap();
    assert!((x - 0.2).abs() < 1e-12 && (y - 0.1).abs() < 1e-12);
}

#[test]
fn bitmap_density_is_read_in_pixels_per_metre() {
    let mut bytes = encoded(DynamicImage::new_luma8(3, 2), ImageFormat::Bmp);
    assert_eq!(raster(&bytes).pixel, None);
    bytes[38..42].copy_from_slice(&4000_u32.to_le_bytes());
    bytes[42..46].copy_from_slice(&2000_u32.to_le_bytes());
    assert_eq!(raster(&bytes).pixel, Some([0.25, 0.5]));
    bytes[38..42].copy_from_slice(&(-1_i32).to_le_bytes());
    assert_eq!(raster(&bytes).pixel, None);
}

#[test]
fn oversize_and_non_image_files_are_refused() {
    let unknown = "this is not a PNG, JPEG, BMP, WebP, GIF, TIFF or PNM image";
    assert_eq!(refusal(b""), "the file is empty");
    assert_eq!(refusal(b"\x8aMNG"), unknown);
    assert!(refusal(b"GIF89a").starts_with("the image cannot be decoded"));
    assert!(refusal(&PALETTE[..60]).starts_with("the image cannot be decoded"));
    // A bitmap's header is trusted before any pixels are read.
    let sized = |width: u32, height: u32| {
        let mut bytes = encoded(DynamicImage::new_luma8(1, 1), ImageFormat::Bmp);
        bytes[18..22].copy_from_slice(&width.to_le_bytes());
        bytes[22..26].copy_from_slice(&height.to_le_bytes());
        bytes
    };
    let bomb = sized(30_000, 30_000);
    let why = refusal(&bomb);
    assert!(why.starts_with("the image is too large"), "{why}");
}

#[test]
fn webp_gif_and_tiff_are_read() {
    let mut image = DynamicImage::new_rgb8(3, 2);
    image.put_pixel(1, 0, Rgba([255; 4]));
    for format in [ImageFormat::WebP, ImageFormat::Gif, ImageFormat::Tiff] {
        let bytes = encoded(image.clone(), format);
        assert_eq!(raster(&bytes).grey, [0, 255, 0, 0, 0, 0], "{format:?}");
        assert_eq!(Format::of("a", &bytes), Some(Format::Image), "{format:?}");
    }
}

/// A PNG that is black on the left and white in the right tenth.
fn wide_png(width: u32, height: u32) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(png::BitDepth::One);
    encoder.set_compression(png::Compression::Fastest);
    let mut header = encoder.write_header().unwrap();
    let mut writer = header.stream_writer().unwrap();
    let side = width.div_ceil(8) as usize;
    let row: Vec<u8> = (0..side)
        .map(|at| if at >= side * 9 / 10 { 255 } else { 0 })
        .collect();
    for _ in 0..height {
        std::io::Write::write_all(&mut writer, &row).unwrap();
    }
    writer.finish().unwrap();
    drop(header);
    bytes
}

#[test]
fn large_images_are_reduced_while_decoding() {
    let reading = read(
        Format::Image,
        &wide_png(40_000, 500),
        &ReadOptions::default(),
    )
    .unwrap();
    let told: Vec<&str> = reading
        .notes
        .iter()
        .map(|note| note.message.as_str())
        .collect();
    assert_eq!(
        told,
        ["the image has 40000 by 500 pixels: it is scaled down to 20000 by 250 on reading"]
    );
    let Content::Image(image) = reading.content else {
        panic!("no image");
    };
    assert_eq!((image.width, image.height), (20_000, 250));
    assert_eq!(image.grey.len(), 20_000 * 250);
    assert_eq!((image.grey[0], image.grey[19_999]), (0, 255));
    // The size on paper is unchanged.
    let [width, height] = image.size(crate::raster::Size::Natural).unwrap();
    assert!(
        (width - 8000.0).abs() < 1e-6 && (height - 100.0).abs() < 1e-6,
        "{width} {height}"
    );
    let too_many = refusal(&wide_png(200_000, 1)[..40]);
    assert!(too_many.starts_with("the image"), "{too_many}");
}

fn all(size: [u32; 2]) -> Window {
    Window::new(size, Orientation::NoTransforms, None).unwrap()
}

#[test]
fn only_the_brightness_of_a_large_jpeg_is_decoded() {
    let small = large::jpeg(&photo(1), all([16, 8])).unwrap();
    assert_eq!((small.width, small.height), (16, 8));
    assert!(small.grey[0] < 10 && small.grey[15] > 245);
    assert!(large::png(PALETTE, all([4, 1])).unwrap().grey == [0, 54, 18, 255]);
    assert!(large::jpeg(&photo(1)[..200], all([16, 8])).is_err());
}

fn cropped(bytes: &[u8], crop: [u32; 4]) -> Result<Raster, Diagnostic> {
    let options = ReadOptions {
        crop: Some(crop),
        ..ReadOptions::default()
    };
    let Content::Image(image) = read(Format::Image, bytes, &options)?.content else {
        panic!("no image");
    };
    Ok(image)
}

#[test]
fn crop_uses_pixels_of_the_upright_image() {
    // Dark except for one light pixel, in any orientation.
    for turn in 1..=8_u8 {
        let photo = raster(&photo(turn));
        let whole = [photo.width, photo.height];
        let [x, y] = [whole[0] / 4, whole[1] / 2];
        let [across, down] = [whole[0] / 2, whole[1] / 4];
        let kept = cropped(
            &self::photo(turn),
            [x as u32, y as u32, across as u32, down as u32],
        )
        .unwrap();
        assert_eq!([kept.width, kept.height], [across, down], "turn {turn}");
        let expected = (y..y + down).flat_map(|row| &photo.grey[row * whole[0]..][x..x + across]);
        assert!(kept.grey.iter().eq(expected), "turn {turn}");
        assert_eq!(kept.pixel, photo.pixel, "turn {turn}");
    }
}

#[test]
fn a_crop_of_a_large_image_keeps_its_pixels() {
    let large = wide_png(40_000, 2000);
    let kept = cropped(&large, [35_000, 10, 2000, 100]).unwrap();
    assert_eq!((kept.width, kept.height, kept.pixel), (2000, 100, None));
    assert_eq!((kept.grey[0], kept.grey[999], kept.grey[1001]), (0, 0, 255));
}

#[test]
fn crop_beyond_the_image_or_of_a_non_image_is_refused() {
    for crop in [
        [0, 0, 17, 8],
        [16, 0, 1, 1],
        [0, 8, 1, 1],
        [0, 0, 0, 1],
        [u32::MAX, 0, 2, 1],
    ] {
        let why = cropped(&photo(1), crop).unwrap_err().message;
        assert!(
            why.ends_with("is not within the image of 16 by 8 pixels"),
            "{why}"
        );
    }
    let options = ReadOptions {
        crop: Some([0, 0, 1, 1]),
        ..ReadOptions::default()
    };
    let drawing = br#"<svg xmlns="http://www.w3.org/2000/svg"><path d="M0 0L9 9"/></svg>"#;
    let why = read(Format::Svg, drawing, &options).unwrap_err().message;
    assert_eq!(why, "only an image can be cropped");
}

#[test]
fn a_large_tiff_is_read_strip_by_strip() {
    let mut gray = ::image::GrayImage::new(31_000, 600);
    for (x, _, pixel) in gray.enumerate_pixels_mut() {
        pixel.0 = [if x >= 15_500 { 255 } else { 20 }];
    }
    let image = raster(&encoded(gray, ImageFormat::Tiff));
    assert_eq!((image.width, image.height), (15_500, 300));
    assert_eq!((image.grey[0], image.grey[15_499]), (20, 255));
    let window = all([6, 4]);
    let wide = ::image::ImageBuffer::from_fn(6, 4, |x, _| ::image::Rgb([(x as u16) * 13_000; 3]));
    let wide = encoded(wide, ImageFormat::Tiff);
    let rows = large::tiff(&wide, window).unwrap();
    assert_eq!(rows.grey[..6], raster(&wide).grey[..6]);
    assert!(large::tiff(&wide[..100], window).is_err());
}

#[test]
fn other_formats_are_decoded_whole_and_reduced() {
    let mut bytes = encoded(DynamicImage::new_luma8(31_000, 600), ImageFormat::Bmp);
    let image = raster(&bytes);
    assert_eq!((image.width, image.height), (15_500, 300));
    bytes.truncate(500);
    assert!(refusal(&bytes).starts_with("the image"));
}

/// White on the left and black on the right, in CMYK.
const CMYK: &[u8] = &[
    0xFF, 0xD8, 0xFF, 0xEE, 0x00, 0x0E, 0x41, 0x64, 0x6F, 0x62, 0x65, 0x00, 0x64, 0x00, 0x00, 0x00,
    0x00, 0x02, 0xFF, 0xDB, 0x00, 0x43, 0x00, 0x03, 0x02, 0x02, 0x03, 0x02, 0x02, 0x03, 0x03, 0x03,
    0x03, 0x04, 0x03, 0x03, 0x04, 0x05, 0x08, 0x05, 0x05, 0x04, 0x04, 0x05, 0x0A, 0x07, 0x07, 0x06,
    0x08, 0x0C, 0x0A, 0x0C, 0x0C, 0x0B, 0x0A, 0x0B, 0x0B, 0x0D, 0x0E, 0x12, 0x10, 0x0D, 0x0E, 0x11,
    0x0E, 0x0B, 0x0B, 0x10, 0x16, 0x10, 0x11, 0x13, 0x14, 0x15, 0x15, 0x15, 0x0C, 0x0F, 0x17, 0x18,
    0x16, 0x14, 0x18, 0x12, 0x14, 0x15, 0x14, 0xFF, 0xDB, 0x00, 0x43, 0x01, 0x03, 0x04, 0x04, 0x05,
    0x04, 0x05, 0x09, 0x05, 0x05, 0x09, 0x14, 0x0D, 0x0B, 0x0D, 0x14, 0x14, 0x14, 0x14, 0x14, 0x14,
    0x14, 0x14, 0x14, 0x14, 0x14, 0x14, 0x14, 0x14, 0x14, 0x14, 0x14, 0x14, 0x14, 0x14, 0x14, 0x14,
    0x14, 0x14, 0x14, 0x14, 0x14, 0x14, 0x14, 0x14, 0x14, 0x14, 0x14, 0x14, 0x14, 0x14, 0x14, 0x14,
    0x14, 0x14, 0x14, 0x14, 0x14, 0x14, 0x14, 0x14, 0x14, 0x14, 0x14, 0x14, 0xFF, 0xC0, 0x00, 0x14,
    0x08, 0x00, 0x08, 0x00, 0x10, 0x04, 0x01, 0x11, 0x00, 0x02, 0x11, 0x01, 0x03, 0x11, 0x01, 0x04,
    0x11, 0x00, 0xFF, 0xC4, 0x00, 0x16, 0x00, 0x01, 0x01, 0x01, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,
    0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x09, 0x00, 0x0A, 0xFF, 0xC4, 0x00, 0x14, 0x10, 0x01,
    0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,
    0xFF, 0xC4, 0x00, 0x14, 0x01, 0x01, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,
    0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0xFF, 0xC4, 0x00, 0x14, 0x11, 0x01, 0x00, 0x00, 0x00, 0x00,
    0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0xFF, 0xDA, 0x00, 0x0E,
    0x04, 0x01, 0x00, 0x02, 0x11, 0x03, 0x11, 0x04, 0x00, 0x00, 0x3F, 0x00, 0x2A, 0x80, 0xA9, 0xA0,
    0x65, 0x5D, 0xFF, 0xD9,
];

/// A JPEG for print: cyan, magenta, yellow and black, inverted as Adobe stores them.
#[test]
fn cmyk_jpeg_is_read() {
    let image = raster(CMYK);
    assert_eq!((image.width, image.height), (16, 8));
    assert!(
        image.grey[0] > 240 && image.grey[15] < 20,
        "{:?}",
        &image.grey[..16]
    );
    // CMYK has no luma plane, so a large image is decoded with its colours.
    assert!(!large::has_separate_luma(CMYK) && large::has_separate_luma(&photo(1)));
}

#[test]
fn truncated_jpeg_is_noted() {
    let whole = photo(1);
    let notes = |bytes: &[u8]| {
        let reading = read(Format::Image, bytes, &ReadOptions::default());
        reading.map(|reading| reading.notes.len())
    };
    assert_eq!(notes(&whole).unwrap(), 0);
    let behind = [&whole[..], b"a film of the same moment"].concat();
    assert_eq!(notes(&behind).unwrap(), 0);
    // The remainder may be too little for any image.
    if let Ok(notes) = notes(&whole[..whole.len() - 4]) {
        assert_eq!(notes, 1);
    }
    assert!(large::is_cut_off(&whole[..whole.len() - 4]));
    assert!(!large::is_cut_off(&whole[..20]));
}

/// Only the first frame of an animated GIF counts.
#[test]
fn first_frame_of_an_animated_gif_is_read() {
    let mut bytes = Vec::new();
    let mut encoder = ::image::codecs::gif::GifEncoder::new(&mut bytes);
    for grey in [255, 0] {
        let picture = ::image::RgbaImage::from_pixel(4, 4, Rgba([grey, grey, grey, 255]));
        encoder.encode_frame(::image::Frame::new(picture)).unwrap();
    }
    drop(encoder);
    assert_eq!(raster(&bytes).grey, [255; 16]);
}

proptest! {
    #[test]
    fn damaged_images_are_refused_or_read_whole(
        which in 0..8_usize,
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..12),
        cut in any::<prop::sample::Index>(),
        whole in any::<bool>(),
    ) {
        let mut bytes = match which {
            0 => PALETTE.to_vec(),
            1 => photo(8),
            2 => encoded(DynamicImage::new_rgb8(5, 4), ImageFormat::Bmp),
            3 => encoded(DynamicImage::new_rgb8(5, 4), ImageFormat::Gif),
            4 => encoded(DynamicImage::new_rgb8(5, 4), ImageFormat::Tiff),
            5 => encoded(DynamicImage::new_rgb8(5, 4), ImageFormat::WebP),
            6 => wide_png(30_100, 3),
            _ => encoded(DynamicImage::new_rgba16(5, 4), ImageFormat::Png),
        };
        for (at, value) in changes {
            let at = at.index(bytes.len());
            bytes[at] = value;
        }
        if !whole {
            bytes.truncate(cut.index(bytes.len()));
        }
        if let Ok(reading) = read(Format::Image, &bytes, &ReadOptions::default()) {
            let Content::Image(image) = reading.content else {
                panic!("no image");
            };
            prop_assert_eq!(image.grey.len(), image.width * image.height);
        }
    }
}
