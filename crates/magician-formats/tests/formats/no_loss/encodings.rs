//! Encodings, line endings, and numbers as programs of any country write them.

use magician_formats::{Action, Content, Diagnostic, Format, ReadOptions, read};

use super::{artwork, data, length, near, note_text, plan, utf16};

fn reading(format: Format, bytes: &[u8]) -> Result<(Content, String), Diagnostic> {
    let parsed = read(format, bytes, &ReadOptions::default())?;
    Ok((parsed.content, note_text(&parsed.notes)))
}

#[test]
fn drawing_in_a_declared_encoding_is_read() {
    let (artwork, notes) = artwork("latin1.svg", &ReadOptions::default());
    near(length(&artwork), 160.0, 1e-3);
    assert_eq!(note_text(&notes), "");
    assert!(
        artwork
            .names
            .iter()
            .all(|name| name.is_ascii() || name.contains('ä'))
    );
}

#[test]
fn every_text_format_is_read_in_utf_16_and_with_lone_carriage_returns() {
    let (taught, _) = plan("utf16.nc");
    assert!(!taught.steps.is_empty());
    let samples = [
        ("house.svg", Format::Svg),
        ("pen_outline.gcode", Format::Gcode),
        ("star.plt", Format::Hpgl),
        ("arc_movl_v1412.playback", Format::Playback),
        ("example_loop.blockly", Format::Blockly),
    ];
    let mut files: Vec<(String, Format, Vec<u8>)> = Vec::new();
    let folder =
        std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../magician-program/samples");
    for (name, format) in samples {
        files.push((
            name.to_owned(),
            format,
            std::fs::read(folder.join(name)).unwrap(),
        ));
    }
    files.push(("comma.dxf".to_owned(), Format::Dxf, data("comma.dxf")));
    let points = b"X,Y,Z,R\n200,0,10,0\n210,5,10,0\n".to_vec();
    files.push(("points.csv".to_owned(), Format::Points, points));
    files.push(("text".to_owned(), Format::Text, b"one\ntwo\n".to_vec()));
    for (name, format, bytes) in files {
        let plain = String::from_utf8(bytes).unwrap().replace("\r\n", "\n");
        let expected = reading(format, plain.as_bytes()).unwrap();
        for (kind, other) in [
            ("UTF-16", utf16(&plain)),
            ("CR", plain.replace('\n', "\r").into_bytes()),
            ("byte order mark", format!("\u{FEFF}{plain}").into_bytes()),
        ] {
            let found =
                reading(format, &other).unwrap_or_else(|error| panic!("{name} {kind}: {error}"));
            assert_eq!(found, expected, "{name} {kind}");
            assert_eq!(
                Format::of("", &other),
                Format::of("", plain.as_bytes()),
                "{name} {kind}"
            );
        }
    }
}

#[test]
fn bytes_of_no_known_encoding_are_read_as_windows_1252_with_a_note() {
    let text = b"<svg xmlns='http://www.w3.org/2000/svg' width='9mm' height='9mm'>\n<g id='Tr\xE4ger'><path d='M1 1H5' stroke='#000'/></g></svg>";
    let (content, notes) = reading(Format::Svg, text).unwrap();
    let Content::Artwork(artwork) = content else {
        panic!("no drawing")
    };
    assert_eq!(artwork.layers[0].name.as_deref(), Some("Träger"));
    assert!(
        notes.contains("line 2, column 10") && notes.contains("Windows-1252"),
        "{notes}"
    );
}

#[test]
fn names_of_a_dxf_code_page_are_decoded() {
    let file = b"0\nSECTION\n2\nHEADER\n9\n$DWGCODEPAGE\n3\nANSI_1251\n0\nENDSEC\n0\nSECTION\n2\nENTITIES\n0\nLINE\n8\n\xC4\xE0\n10\n0\n20\n0\n11\n5\n21\n0\n0\nENDSEC\n0\nEOF\n";
    let (content, _) = reading(Format::Dxf, file).unwrap();
    let Content::Artwork(artwork) = content else {
        panic!("no drawing")
    };
    assert_eq!(artwork.layers[0].name.as_deref(), Some("Да"));
}

#[test]
fn carriage_return_alone_ends_a_line() {
    let (taught, _) = plan("maccr.nc");
    let last = taught.steps.iter().rfind(|step| step.action.marks());
    assert_eq!(last.map(|step| step.origin.line), Some(3));
    let (drawn, _) = artwork("cr.dxf", &ReadOptions::default());
    near(length(&drawn), 500.0_f64.sqrt(), 1e-6);
    // In a label of a plot a carriage return moves to the margin without a line feed.
    let label = |text: &str| reading(Format::Hpgl, text.as_bytes()).unwrap().0;
    assert_ne!(
        label("IN;SP1;PA0,0;LBab\rcd\u{3};"),
        label("IN;SP1;PA0,0;LBab\ncd\u{3};")
    );
}

#[test]
fn localised_numbers_are_read_where_unambiguous() {
    let (drawn, _) = artwork("comma.dxf", &ReadOptions::default());
    near(length(&drawn), 20.0_f64.hypot(10.0), 1e-6);
    let (small, _) = plan("expo.nc");
    let ends = { small.steps.iter() }.filter_map(|step| match step.action {
        Action::Path { to: [x, y, _] } => Some([x, y]),
        _ => None,
    });
    assert_eq!(ends.collect::<Vec<_>>(), [[10.0, 1.2e-12], [20.0, 10.0]]);
    // Without blanks between the words, E may be a separate word, as for a printer's extruder.
    for text in ["G0X0Y0\nG1X10Y1.2E-12F600\n", "G0 X0 Y0\nG1 X10 Y1E2\n"] {
        let refused = reading(Format::Gcode, text.as_bytes()).unwrap_err();
        let what = "one number or a number and a word E";
        assert!(refused.message.contains(what), "{refused}");
    }
    let plain = reading(Format::Gcode, b"G21 G90\nG0 X0 Y0\nG1 X10.5 Y-2.25 F600\n").unwrap();
    let commas = reading(Format::Gcode, b"G21,G90\nG0 X0,Y0\nG1 X10,5,Y-2,25 F600\n").unwrap();
    let steps = |content: Content| match content {
        Content::Plan(plan) => plan
            .steps
            .into_iter()
            .map(|step| step.action)
            .collect::<Vec<_>>(),
        other => panic!("{other:?}"),
    };
    assert_eq!(steps(plain.0), steps(commas.0));
}
