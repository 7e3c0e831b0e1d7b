//! Transparent pixels are never burnt or drawn, with any options.

use std::io::Cursor;

use image::{DynamicImage, ImageFormat, Rgba, RgbaImage};
use magician_program::{
    Action, Diagnostic, Format, Plan, Preparation, PrepareRequest, SetupDefaults, SetupOptions,
    Surface,
};
use proptest::prelude::*;
use serde_json::{Map, Value, json};

/// Side of the image, pixels.
const SIDE: u32 = 30;
/// Width of its transparent border, pixels.
const BORDER: u32 = 10;
/// Width and height on the table, mm.
const SIZE: f64 = 30.0;
/// Centre on the table, mm.
const CENTRE: [f64; 2] = [250.0, 0.0];
/// Height of the table, mm.
const TABLE_HEIGHT: f64 = -60.0;

fn encoded(image: impl Into<DynamicImage>, format: ImageFormat) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    image.into().write_to(&mut bytes, format).unwrap();
    bytes.into_inner()
}

/// Image with a transparent border of one colour around a square of another.
fn framed(border: [u8; 3], inside: [u8; 4]) -> RgbaImage {
    RgbaImage::from_fn(SIDE, SIDE, |x, y| {
        let is_inside = |at: u32| (BORDER..SIDE - BORDER).contains(&at);
        if is_inside(x) && is_inside(y) {
            Rgba(inside)
        } else {
            Rgba([border[0], border[1], border[2], 0])
        }
    })
}

/// PNG with a palette whose border entry is transparent by its tRNS chunk.
fn palette(border: [u8; 3], inside: [u8; 4]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, SIDE, SIDE);
    encoder.set_color(png::ColorType::Indexed);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_palette([border, [inside[0], inside[1], inside[2]]].concat());
    encoder.set_trns(vec![0, inside[3]]);
    let image = framed(border, inside);
    let indices: Vec<u8> = image
        .pixels()
        .map(|pixel| u8::from(pixel.0[3] > 0))
        .collect();
    let mut writer = encoder.write_header().unwrap();
    writer.write_image_data(&indices).unwrap();
    drop(writer);
    bytes
}

/// Encodes the framed image in format number `kind` (0 to 7) of those with transparency.
fn file(format_number: usize, border: [u8; 3], inside: [u8; 4]) -> Vec<u8> {
    let image = DynamicImage::from(framed(border, inside));
    match format_number {
        0 => encoded(image, ImageFormat::Png),
        1 => encoded(DynamicImage::from(image.to_luma_alpha8()), ImageFormat::Png),
        2 => encoded(DynamicImage::from(image.to_rgba16()), ImageFormat::Png),
        3 => palette(border, inside),
        4 => encoded(image, ImageFormat::Gif),
        5 => encoded(image, ImageFormat::WebP),
        6 => encoded(image, ImageFormat::Tiff),
        _ => encoded(image, ImageFormat::Bmp),
    }
}

fn prepared_plan(bytes: &[u8], options: Value) -> Result<Plan, Diagnostic> {
    let Value::Object(mut fields) = options else {
        panic!("{options}");
    };
    let own = json!({"at": CENTRE, "width": SIZE});
    fields.extend(own.as_object().cloned().unwrap_or_default());
    let mut file = PrepareRequest::new(Format::Image, bytes);
    file.options = SetupOptions::from_fields(&fields).unwrap();
    file.defaults = SetupDefaults::default();
    file.defaults.surface = Some(Surface::level(TABLE_HEIGHT));
    match file.prepare()? {
        Preparation::Done(laid) => Ok(laid.program.plan().clone()),
        Preparation::NeedsStart => panic!("an image begins anywhere"),
    }
}

/// Burnt or drawn segments: both ends, and the power (percent; 255 for a pen line).
fn marks(plan: &Plan) -> Vec<([f64; 2], [f64; 2], f64)> {
    let (mut at, mut marks) = ([0.0; 3], Vec::new());
    for step in &plan.steps {
        let (to, power) = match step.action {
            Action::Burn { to, power } => (to.map(f64::from), f64::from(power)),
            Action::Path { to } => (to.map(f64::from), f64::from(u8::MAX)),
            Action::Move {
                to: [x, y, z, _], ..
            } => ([x, y, z].map(f64::from), f64::from(u8::MAX)),
            _ => continue,
        };
        let burns = matches!(step.action, Action::Burn { .. });
        let down = [at[2], to[2]]
            .iter()
            .all(|z| (z - TABLE_HEIGHT).abs() < 1e-3);
        if (burns && power > 0.0) || (!burns && down && !plan.burns()) {
            marks.push(([at[0], at[1]], [to[0], to[1]], power));
        }
        at = to;
    }
    marks
}

/// Distance of a position from the opaque square, mm; 0 within it.
fn distance_outside([x, y]: [f64; 2]) -> f64 {
    let half = SIZE * f64::from(SIDE - 2 * BORDER) / f64::from(SIDE) / 2.0;
    let off = [x - CENTRE[0], y - CENTRE[1]].map(|off| (off.abs() - half).max(0.0));
    off[0].max(off[1])
}

/// Burnt length, weighted by its share of the full power.
fn burnt_length(plan: &Plan) -> f64 {
    let length = |from: [f64; 2], to: [f64; 2]| (to[0] - from[0]).hypot(to[1] - from[1]);
    let marks = marks(plan);
    marks
        .iter()
        .map(|(from, to, power)| length(*from, *to) * power / 100.0)
        .sum()
}

#[test]
fn inverted_engraving_burns_a_white_logo_on_transparent() {
    let logo = file(0, [255; 3], [255; 4]);
    let nothing = prepared_plan(&logo, json!({"work": "engrave"})).unwrap_err();
    assert_eq!(nothing.message, "nothing to burn: all of it is white");
    let remedies: Vec<_> = nothing
        .remedies
        .iter()
        .map(|remedy| &*remedy.effect)
        .collect();
    assert!(
        remedies.contains(&"burns the white parts, and nothing where it is transparent"),
        "{remedies:?}"
    );
    let plan = prepared_plan(&logo, json!({"work": "engrave", "invert": true})).unwrap();
    // Lines 0.2 mm apart on 10 by 10 mm.
    assert!(
        (burnt_length(&plan) - 500.0).abs() < 15.0,
        "{}",
        burnt_length(&plan)
    );
    let clear = prepared_plan(
        &file(0, [0; 3], [0; 4]),
        json!({"work": "engrave", "invert": true}),
    );
    assert_eq!(
        clear.unwrap_err().message,
        "nothing to burn: all of it is transparent"
    );
}

#[test]
fn half_transparent_pixels_burn_in_proportion() {
    for (options, inside) in [
        (json!({"work": "engrave"}), [0, 0, 0, 255]),
        (json!({"work": "engrave", "mode": "dither"}), [0, 0, 0, 255]),
        (
            json!({"work": "engrave", "invert": true}),
            [255, 255, 255, 255],
        ),
        (json!({"work": "engrave", "gamma": 2.0}), [0, 0, 0, 255]),
        (
            json!({"work": "engrave", "brightness": -40}),
            [102, 102, 102, 255],
        ),
    ] {
        let whole =
            burnt_length(&prepared_plan(&file(0, [9; 3], inside), options.clone()).unwrap());
        for opacity in [64_u8, 128, 191] {
            let [red, green, blue, _] = inside;
            let glass = file(0, [9; 3], [red, green, blue, opacity]);
            let share = burnt_length(&prepared_plan(&glass, options.clone()).unwrap()) / whole;
            let expected = f64::from(opacity) / 255.0;
            assert!(
                (share - expected).abs() < 0.03,
                "{options} {opacity}: {share}"
            );
        }
    }
}

/// Image options, and the largest allowed distance of a mark from opaque pixels, mm: half the width
/// of a line or a dot, or the blur of a shaded style.
fn image_options() -> impl Strategy<Value = (Map<String, Value>, f64)> {
    let engrave = prop_oneof![Just("grey"), Just("threshold"), Just("dither")]
        .prop_map(|mode| (json!({"work": "engrave", "mode": mode}), 0.35));
    let draw = prop_oneof![
        Just(("outline", 0.6)),
        Just(("centerline", 0.6)),
        Just(("halftone", 1.2)),
        Just(("squiggle", 1.6)),
        Just(("hatch", 0.6)),
    ];
    let draw = draw.prop_map(|(image, blur)| (json!({"work": "draw", "image": image}), blur));
    let kind = prop_oneof![engrave, draw];
    let greys = (
        -100..=100_i32,
        -100..=100_i32,
        prop_oneof![Just(0.4), Just(1.0), Just(2.2)],
        any::<bool>(),
        any::<bool>(),
    );
    (kind, greys, 1..=255_u8, 3..=8_u8).prop_map(|((options, blur), greys, threshold, levels)| {
        let mut options = options.as_object().cloned().unwrap();
        let (brightness, contrast, gamma, invert, fine) = greys;
        options.insert("brightness".into(), brightness.into());
        options.insert("contrast".into(), contrast.into());
        options.insert("gamma".into(), gamma.into());
        options.insert("invert".into(), invert.into());
        match (
            options.get("mode"),
            options.get("image").and_then(Value::as_str),
        ) {
            (Some(mode), _) => {
                if mode == "threshold" {
                    options.insert("threshold".into(), threshold.into());
                }
                let spacing = if fine { 0.15 } else { 0.7 };
                options.insert("spacing".into(), spacing.into());
            }
            (_, Some("outline" | "centerline")) => {
                options.insert("threshold".into(), threshold.into());
            }
            (_, Some("halftone" | "hatch")) => {
                options.insert("levels".into(), levels.into());
            }
            _ => {}
        }
        (options, if fine { blur } else { blur + 0.5 })
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    #[test]
    fn transparent_border_is_never_burnt_nor_drawn(
        (options, blur) in image_options(),
        kind in 0..8_usize,
        border in any::<[u8; 3]>(),
        inside in any::<[u8; 3]>(),
        opacity in prop_oneof![Just(255_u8), 1..255_u8],
        crop in any::<bool>(),
    ) {
        // A GIF pixel is either transparent or opaque.
        let opacity = if kind == 4 { 255 } else { opacity };
        let [red, green, blue] = inside;
        let mut options = options;
        if crop {
            options.insert("crop".into(), json!([0, 0, SIDE, SIDE]));
        }
        let bytes = file(kind, border, [red, green, blue, opacity]);
        // A refusal is allowed: there may be nothing to draw.
        if let Ok(plan) = prepared_plan(&bytes, Value::Object(options.clone())) {
            for (from, to, power) in marks(&plan) {
                for place in [from, to] {
                    let off = distance_outside(place);
                    prop_assert!(off <= blur, "{options:?}: {off:.2} mm beyond, {power} %");
                }
            }
        }
    }
}

/// Images that are reduced while they are read keep their opacity.
#[test]
fn large_image_keeps_its_opacity() {
    let side = 32_000;
    let image = RgbaImage::from_fn(side, 60, |x, _| {
        Rgba([255, 255, 255, if x < side / 2 { 0 } else { 255 }])
    });
    let image = DynamicImage::from(image);
    for format in [ImageFormat::Png, ImageFormat::Tiff, ImageFormat::Bmp] {
        let bytes = encoded(image.clone(), format);
        let size = Cursor::new(&bytes).get_ref().len();
        let options = json!({"work": "engrave", "invert": true, "width": 100.0});
        let plan = prepared_plan(&bytes, options)
            .unwrap_or_else(|error| panic!("{format:?} {size}: {error}"));
        let marks = marks(&plan);
        assert!(!marks.is_empty(), "{format:?}");
        for (from, to, _) in marks {
            for [x, _] in [from, to] {
                assert!(x >= CENTRE[0] - 0.3, "{format:?}: {x}");
            }
        }
    }
}
