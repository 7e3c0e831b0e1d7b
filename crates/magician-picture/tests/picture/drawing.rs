//! Pictures of drawings that pen and laser left.

use magician_picture::{DrawingOptions, PictureError, drawing_png, drawing_svg};
use magician_sim::world::{Drawing, Stroke, StrokeKind};
use resvg::tiny_skia::Pixmap;

fn stroke(kind: StrokeKind, power: f64, points: &[[f64; 2]]) -> Stroke {
    Stroke {
        kind,
        power,
        points: points.to_vec(),
    }
}

fn ink(points: &[[f64; 2]]) -> Drawing {
    Drawing::from(vec![stroke(StrokeKind::Ink, 100.0, points)])
}

fn svg(drawing: &Drawing) -> String {
    drawing_svg(drawing, &DrawingOptions::default())
}

#[test]
fn a_square_is_drawn_in_true_size_with_sheet_and_base_on_demand() {
    let square = [
        [200.0, 0.0],
        [240.0, 0.0],
        [240.0, 40.0],
        [200.0, 40.0],
        [200.0, 0.0],
    ];
    let drawing = ink(&square);
    let plain = svg(&drawing);
    assert!(
        plain.contains("d=\"M200 0L240 0L240 -40L200 -40L200 0\""),
        "{plain}"
    );
    assert!(
        plain.contains("width=\"50mm\" height=\"50mm\" viewBox=\"195 -45 50 50\""),
        "{plain}"
    );
    assert!(!plain.contains("circle"), "the base is far away: {plain}");
    let view = |options: DrawingOptions| {
        let svg = drawing_svg(&drawing, &options);
        let view = svg.split("viewBox=\"").nth(1).unwrap();
        let told = (svg.contains("<circle"), svg.contains("class=\"sheet\""));
        (view.split('"').next().unwrap().to_owned(), told)
    };
    let options = DrawingOptions::default;
    let sheet = [[150.0, -30.0], [250.0, -30.0], [250.0, 60.0], [150.0, 60.0]];
    let (cropped, on_sheet, whole, both) = (
        view(options()),
        view(options().sheet(sheet)),
        view(options().whole(true)),
        view(options().sheet(sheet).whole(true)),
    );
    assert_eq!(cropped, ("195 -45 50 50".to_owned(), (false, false)));
    assert_eq!(on_sheet, ("145 -65 110 100".to_owned(), (false, true)));
    assert_eq!(whole, ("-8 -45 253 53".to_owned(), (true, false)));
    assert_eq!(both, ("-8 -65 263 100".to_owned(), (true, true)));
    // An empty drawing shows the base of the arm instead.
    assert!(svg(&Drawing::default()).contains("<circle"));
}

#[test]
fn single_touch_is_drawn_as_a_dot() {
    assert!(svg(&ink(&[[200.0, 0.0]])).contains("M200 0h0"));
}

#[test]
fn opacity_of_a_burn_follows_its_power() {
    let burn = stroke(StrokeKind::Burn, 50.0, &[[210.0, 0.0], [220.0, 0.0]]);
    assert!(svg(&Drawing::from(vec![burn])).contains("stroke-opacity=\"0.5\""));
}

#[test]
fn burnt_lines_have_flat_ends_and_dots_are_round() {
    let ends = [[200.0, 0.0], [220.0, 0.0]];
    let is_cut_off = |kind, points: &[[f64; 2]]| {
        let svg = svg(&Drawing::from(vec![stroke(kind, 50.0, points)]));
        svg.contains("stroke-linecap=\"butt\"")
    };
    assert!(is_cut_off(StrokeKind::Burn, &ends));
    assert!(!is_cut_off(StrokeKind::Burn, &ends[..1]));
    assert!(!is_cut_off(StrokeKind::Ink, &ends));
}

#[test]
fn power_changes_leave_no_darker_spot() {
    let burn = |power, from, to| stroke(StrokeKind::Burn, power, &[[from, 0.0], [to, 0.0]]);
    let drawing = Drawing::from(vec![burn(50.0, 200.0, 201.0), burn(51.0, 201.0, 202.0)]);
    let png = drawing_png(&drawing, 20.0, &DrawingOptions::default()).unwrap();
    let picture = Pixmap::decode_png(&png).unwrap();
    let row = picture.height() / 2;
    let reds = (0..picture.width()).map(|x| picture.pixel(x, row).unwrap().red());
    let darkest = reds.min().unwrap();
    assert!((160..=166).contains(&darkest), "{darkest}");
}

#[test]
fn picture_has_ink_along_the_pen_path() {
    let drawing = ink(&[[200.0, 20.0], [240.0, 20.0]]);
    let pixels = |options: &DrawingOptions| {
        let png = drawing_png(&drawing, 4.0, options).unwrap();
        Pixmap::decode_png(&png).unwrap()
    };
    let picture = pixels(&DrawingOptions::default());
    // The picture covers 195 to 245 mm in X and 15 to 25 mm in Y.
    assert_eq!((picture.width(), picture.height()), (50 * 4, 10 * 4));
    let whole = pixels(&DrawingOptions::default().whole(true));
    assert_eq!((whole.width(), whole.height()), (253 * 4, 33 * 4));
    let dark = |x: f64, y: f64| {
        let (column, row) = ((x - 195.0) * 4.0, (25.0 - y) * 4.0);
        picture.pixel(column as u32, row as u32).unwrap().red() < 128
    };
    assert!(dark(210.0, 20.0) && dark(239.0, 20.0));
    assert!(!dark(210.0, 18.0) && !dark(197.0, 20.0) && !dark(242.0, 20.0));
}

#[test]
fn picture_of_invalid_size_is_refused() {
    let png = |scale| drawing_png(&Drawing::default(), scale, &DrawingOptions::default());
    for scale in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(png(scale), Err(PictureError::Scale(_))), "{scale}");
    }
    assert!(matches!(png(1e6), Err(PictureError::Size(_))));
    assert!(png(1.0).is_ok());
}
