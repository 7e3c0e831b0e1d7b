//! Paints, widths, layers and images of SVG.

use magician_formats::{Content, Diagnostic, Format, Parsed, ReadOptions, read};

use super::{artwork, length, near, note_text};

fn svg(inside: &str) -> (magician_formats::Artwork, Vec<Diagnostic>) {
    let svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"50mm\" height=\"50mm\" viewBox=\"0 0 50 50\">\n{inside}</svg>"
    );
    match read(Format::Svg, svg.as_bytes(), &ReadOptions::default()) {
        Ok(Parsed {
            content: Content::Artwork(artwork),
            notes,
        }) => (artwork, notes),
        other => panic!("{inside}: {other:?}"),
    }
}

/// Returns the colour of the only line of a drawing, and the notes.
fn colors_and_notes_of(inside: &str) -> (String, String) {
    let (artwork, notes) = svg(inside);
    assert_eq!(artwork.strokes.len(), 1, "{inside}: {notes:?}");
    (artwork.colors[0].to_string(), note_text(&notes))
}

#[test]
fn lines_with_css_4_paints_are_drawn() {
    for (name, expected) in [
        ("currentcolor.svg", 160.0),
        ("mixed_colours.svg", 160.0),
        ("oklch.svg", 160.0),
        ("variable.svg", 160.0),
    ] {
        let (artwork, notes) = artwork(name, &ReadOptions::default());
        near(length(&artwork), expected, 1e-3);
        assert_eq!(note_text(&notes), "", "{name}");
    }
}

#[test]
fn custom_properties_come_from_the_nearest_element_then_the_style_sheet() {
    for (inside, color) in [
        (
            "<style>:root{--x:#f00}</style><path d='M1 1H5' stroke='var(--x)'/>",
            "#ff0000",
        ),
        (
            "<style><![CDATA[:root { --x : RED; --y: var(--x) }\n.a{stroke:var(--y)}]]></style><path class='a' d='M1 1H5'/>",
            "#ff0000",
        ),
        (
            "<style>:root{--x:#f00} @media (prefers-color-scheme: dark){:root{--x:#fff}}</style><path d='M1 1H5' stroke='var(--x)'/>",
            "#ff0000",
        ),
        (
            "<style>:root{--x:#f00}</style><g style='--x: #00f'><path d='M1 1H5' style='stroke:var(--x)'/></g>",
            "#0000ff",
        ),
        (
            "<path d='M1 1H5' stroke='var(--no, var(--none, rgb(0 0 255 / 50%)))'/>",
            "#0000ff",
        ),
        (
            "<g color='var(--no, #00f)'><path d='M1 1H5' stroke='CURRENTCOLOR'/></g>",
            "#0000ff",
        ),
        (
            "<path d='M1 1H5' stroke='#f00' stroke-width='var(--w, 2)'/>",
            "#ff0000",
        ),
    ] {
        assert_eq!(
            colors_and_notes_of(inside),
            (color.to_owned(), String::new()),
            "{inside}"
        );
    }
}

#[test]
fn paint_that_cannot_be_read_is_a_black_line_with_a_note() {
    for (paint, says) in [
        ("huh", "'huh' cannot be read"),
        ("var(--no)", "--no is not set"),
        ("color(display-p3 1 0 0)", "cannot be read"),
        ("context-stroke", "outside of markers"),
        ("rgb(1,2", "cannot be read"),
    ] {
        for inside in [
            format!("<path id='it' d='M1 1H5' stroke='{paint}'/>"),
            format!("<path id='it' d='M1 1H5' style='fill:none;stroke:{paint}'/>"),
        ] {
            let (color, notes) = colors_and_notes_of(&inside);
            assert_eq!(color, "#000000", "{inside}");
            assert!(
                notes.contains("line 2") && notes.contains("it") && notes.contains(says),
                "{notes}"
            );
        }
    }
    let circle =
        "<style>:root{--a:var(--b);--b:var(--a)}</style><path d='M1 1H5' stroke='var(--a)'/>";
    let (color, notes) = colors_and_notes_of(circle);
    assert!(
        color == "#000000" && notes.contains("--a is not set"),
        "{notes}"
    );
    // Shapes that are explicitly unpainted are not drawn.
    for none in ["none", "NONE", "transparent"] {
        let (artwork, _) = svg(&format!(
            "<path d='M1 1H5' stroke='{none}'/><path d='M1 9H5' stroke='red'/>"
        ));
        assert_eq!(artwork.strokes.len(), 1, "{none}");
    }
}

#[test]
fn line_of_width_0_is_a_hairline() {
    let (drawn, notes) = artwork("hairline.svg", &ReadOptions::default());
    near(length(&drawn), 60.0, 1e-3);
    assert!(note_text(&notes).contains("width 0"), "{notes:?}");
    for width in ["0", "0px", "-1", "thin", "calc(1px)"] {
        let (_, notes) = colors_and_notes_of(&format!(
            "<path d='M1 1H5' stroke='red' stroke-width='{width}'/>"
        ));
        assert!(notes.contains("hairline"), "{width}: {notes}");
        let (_, notes) = colors_and_notes_of(&format!(
            "<style>path{{stroke-width:{width}}}</style><path d='M1 1H5' stroke='red'/>"
        ));
        assert!(notes.contains("hairline"), "{width}: {notes}");
    }
}

#[test]
fn empty_drawing_states_the_reason() {
    let (drawn, notes) = artwork("only-image.svg", &ReadOptions::default());
    assert!(drawn.strokes.is_empty());
    assert!(
        notes[0]
            .help
            .as_deref()
            .is_some_and(|help| help.contains("save the image as a file")),
        "{notes:?}"
    );
    for (inside, says) in [
        ("<path d='M1 1H5'/>", "invisible"),
        (
            "<path d='M1 1H5' stroke='none' fill='none'/>",
            "no visible line or fill",
        ),
        (
            "<g display='none'><path d='M1 1H5' stroke='red'/></g>",
            "hidden",
        ),
        (
            "<g opacity='0'><path d='M1 1H5' stroke='red'/></g>",
            "hidden",
        ),
        (
            "<path d='M1 1H5' stroke='red' stroke-opacity='0'/>",
            "invisible",
        ),
        ("", "no shapes"),
    ] {
        let (drawn, notes) = svg(inside);
        assert!(
            drawn.strokes.is_empty() && note_text(&notes).contains(says),
            "{inside}: {notes:?}"
        );
    }
}

#[test]
fn single_outer_group_without_a_name_is_looked_through() {
    let (drawn, _) = artwork("outer-group.svg", &ReadOptions::default());
    let names: Vec<_> = drawn
        .layers
        .iter()
        .filter_map(|layer| layer.name.as_deref())
        .collect();
    assert_eq!(names, ["red", "blue"]);
    let names = |inside: &str| {
        let (drawn, _) = svg(inside);
        let names = drawn
            .layers
            .into_iter()
            .map(|layer| layer.name.unwrap_or_default());
        names.collect::<Vec<_>>()
    };
    let red = "<g id='red'><path d='M1 1H5' stroke='red'/></g>";
    let blue = "<g id='blue'><path d='M1 5H5' stroke='blue'/></g>";
    assert_eq!(
        names(&format!("<defs/><g><g><title>x</title>{red}{blue}</g></g>")),
        ["red", "blue"]
    );
    // A group with a name, or with a line beside it, is not a mere wrapper.
    assert_eq!(names(&format!("<g id='all'>{red}{blue}</g>")), ["all"]);
    assert_eq!(
        names(&format!(
            "<g>{red}{blue}</g><path d='M1 9H5' stroke='#000'/>"
        )),
        [""; 0]
    );
}
