//! Filled shapes: the drawn length is proportional to the filled area.

use std::f64::consts::PI;

use magician_host::JointAngles;
use magician_host::preflight::Preflight;
use magician_motion::ToolBias;
use magician_program::fill::FillMode;
use magician_program::{FontChoice, Format, SetupDefaults, SetupOptions, Surface, check, read};
use serde_json::{Value, json};

/// Drawn length of these shapes, mm.
fn drawn(shapes: &str, options: &Value) -> f64 {
    let svg = format!(
        r#"<svg xmlns="http://www.w3.org/2000/svg" width="90mm" height="90mm" viewBox="0 0 90 90">{shapes}</svg>"#
    );
    let options = SetupOptions::from_fields(options.as_object().unwrap()).unwrap();
    let mut defaults = SetupDefaults::default();
    defaults.surface = Some(Surface::level(-60.0));
    let setup = options.setup(&defaults);
    let content = read(Format::Svg, svg.as_bytes(), &options.reading(&setup)).unwrap();
    let plan = setup.plan(Format::Svg, content.content).unwrap().plan;
    let report = check(&plan, &Preflight::at(JointAngles::HOME, ToolBias::PEN));
    assert!(report.is_good(), "{:?}", report.refused_steps);
    report.drawn
}

fn assert_filled(shapes: &str, options: &Value, mm2: f64) {
    let spacing = options["fill_spacing"].as_f64().unwrap_or(0.8);
    let filled = drawn(shapes, options) * spacing;
    assert!(
        (filled / mm2 - 1.0).abs() < 0.06,
        "{filled:.0} mm2, not {mm2:.0}"
    );
}

const DISC: &str = r#"<circle cx="45" cy="45" r="30"/>"#;

#[test]
fn filled_shape_has_an_edge_only_if_it_is_stroked() {
    let edge = 2.0 * PI * 30.0;
    assert!((drawn(DISC, &json!({})) - edge).abs() < 0.5);
    for fill in ["hatch", "contour"] {
        assert_filled(DISC, &json!({ "fill": fill }), PI * 900.0);
    }
    assert_filled(DISC, &json!({"fill": "cross"}), 2.0 * PI * 900.0);
    let lined = DISC.replace("/>", r#" stroke="black"/>"#);
    let more = drawn(&lined, &json!({"fill": "hatch"})) - drawn(DISC, &json!({"fill": "hatch"}));
    assert!((more - edge).abs() < 0.5, "{more}");
}

#[test]
fn fill_spacing_on_the_surface_is_independent_of_scale() {
    let half = json!({"fill": "hatch", "scale": 0.5, "fill_spacing": 0.4});
    assert_filled(DISC, &half, PI * 225.0);
    let turned = json!({"fill": "hatch", "rotate": 30, "mirror": true, "fill_angle": 10});
    assert_filled(DISC, &turned, PI * 900.0);
}

#[test]
fn fill_rules_clip_paths_and_white_on_top_are_followed() {
    let hatch = json!({"fill": "hatch"});
    let ring = r#"<path d="M10 10h60v60h-60z M30 30h20v20h-20z" fill-rule="evenodd"/>"#;
    assert_filled(ring, &hatch, 3200.0);
    assert_filled(&ring.replace("evenodd", "nonzero"), &hatch, 3600.0);
    let clipped = format!(
        r#"<clipPath id="c"><rect width="45" height="90"/></clipPath><g clip-path="url(#c)">{DISC}</g>"#
    );
    assert_filled(&clipped, &hatch, PI * 450.0);
    let hole = format!(r#"{DISC}<circle cx="45" cy="45" r="15" fill="white"/>"#);
    assert_filled(&hole, &hatch, PI * 675.0);
    let below = format!(r#"<circle cx="45" cy="45" r="15" fill="white"/>{DISC}"#);
    assert_filled(&below, &hatch, PI * 900.0);
}

#[test]
fn letters_are_filled() {
    let text = r#"<text x="5" y="60" font-size="60" font-family="Roboto">Lo</text>"#;
    let outlined = drawn(text, &json!({}));
    let filled = drawn(text, &json!({"fill": "hatch", "fill_spacing": 0.3}));
    assert!(filled > 3.0 * outlined, "{filled} {outlined}");
}

#[test]
fn text_of_an_outline_font_is_filled_and_single_lines_stay() {
    let font = include_bytes!("../../../magician-formats/fonts/Roboto-Regular.ttf");
    let mut options =
        SetupOptions::from_fields(json!({"fill": "hatch", "size": 30}).as_object().unwrap())
            .unwrap();
    let length = |options: &SetupOptions| {
        let mut defaults = SetupDefaults::default();
        defaults.surface = Some(Surface::level(-60.0));
        let setup = options.setup(&defaults);
        let content = read(Format::Text, b"Lo", &options.reading(&setup)).unwrap();
        let plan = setup.plan(Format::Text, content.content).unwrap().plan;
        check(&plan, &Preflight::at(JointAngles::HOME, ToolBias::PEN)).drawn
    };
    let single = length(&options);
    options.fill = None;
    assert!((length(&options) - single).abs() < 0.01);
    options.font = Some(FontChoice::file("Roboto-Regular.ttf", font.to_vec()));
    let outlined = length(&options);
    options.fill = Some(FillMode::Hatch);
    options.fill_spacing = Some(0.3);
    assert!(length(&options) > 2.0 * outlined);
}

#[test]
fn clipped_areas_are_not_filled_beyond_the_page() {
    let half = r#"<rect x="60" y="20" width="60" height="50"/>"#;
    assert_filled(half, &json!({"fill": "hatch", "clip_page": true}), 1500.0);
}
