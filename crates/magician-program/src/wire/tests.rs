use std::path::Path;

use super::*;
use crate::formats::GcodeOptions;

fn samples() -> Vec<(Format, Vec<u8>)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("samples");
    let mut all = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let bytes = std::fs::read(&path).unwrap();
        if let Some(format) = Format::of(&path.to_string_lossy(), &bytes) {
            all.push((format, bytes));
        }
    }
    assert!(all.len() >= 10);
    all
}

fn request(format: Format, bytes: &[u8]) -> FileRequest {
    FileRequest {
        format,
        options: ReadOptions {
            title: "größe".to_owned(),
            resample: None,
            gcode: GcodeOptions {
                start: Some([200.0, -0.0, 5.5]),
                surface: Some(Surface::level(-60.0)),
                ..GcodeOptions::default()
            },
            ..ReadOptions::default()
        },
        bytes: bytes.into(),
    }
}

#[test]
fn what_is_read_from_a_sample_comes_back_as_it_was() {
    for (format, bytes) in samples() {
        let request = request(format, &bytes);
        let read = crate::read(format, &bytes, &request.options);
        let answered = answer(&request.to_bytes());
        assert_eq!(answer_from(&answered), Ok(read), "{format}");
    }
}

#[test]
fn an_error_comes_back_with_its_place_and_its_advice() {
    for (format, text) in [
        (Format::Gcode, "G1 X10 F600\nG91\nG1 X5 Y5\n"),
        (Format::Gcode, "G90\nG1 X10 Y%\n"),
        (Format::Svg, "<svg width='-3'"),
        (Format::Points, "x,y\n1,oops\n"),
        (Format::Image, "no image"),
    ] {
        let options = ReadOptions::default();
        let read = crate::read(format, text.as_bytes(), &options);
        let request = FileRequest {
            format,
            options,
            bytes: text.as_bytes().into(),
        };
        assert_eq!(
            answer_from(&answer(&request.to_bytes())),
            Ok(read),
            "{text}"
        );
    }
    let given = Diagnostic::of_file("all kinds of advice")
        .named("rect7")
        .help("save it as UTF-8")
        .remedy(Deed::Home, "homes it")
        .remedy((Setting::Scale, Given::Number(f64::INFINITY)), "")
        .remedy((Setting::At, Given::Point(200.0, -5.5)), "places it")
        .remedy((Setting::White, Given::Word("draw")), "keeps it")
        .remedy((Setting::Fit, Given::On), "shrinks it")
        .with(Remedy::without(Setting::Raw))
        .with_missing(Some(Missing::Feature("text")));
    assert_eq!(
        answer_from(&answer_bytes(&Err(given.clone()))),
        Ok(Err(given))
    );
}

#[test]
fn what_another_build_wrote_is_refused_and_not_misread() {
    let mut request = request(Format::Gcode, b"G90\n").to_bytes();
    let mut answered = answer(&request);
    request[3] ^= 1;
    assert_eq!(answer(&request), FORM);
    assert_eq!(answer_from(&FORM), Err(WireError::Malformed));
    answered[7] ^= 0x80;
    assert_eq!(answer_from(&answered), Err(WireError::OtherBuild));
    assert!(
        WireError::OtherBuild
            .to_string()
            .contains("reload the page")
    );
}

#[test]
fn no_bytes_are_taken_for_an_answer_that_is_not_whole() {
    for (format, bytes) in samples() {
        let request = request(format, &bytes);
        let whole = answer(&request.to_bytes());
        let step = (whole.len() / 200).max(1);
        for count in (0..whole.len()).step_by(step) {
            assert!(answer_from(&whole[..count]).is_err(), "{format} {count}");
        }
        let longer = [&whole[..], &[0]].concat();
        assert_eq!(answer_from(&longer), Err(WireError::Malformed));
        // Damaged ones are an answer or none: that they come to an end is all.
        let mut seed = 1_u32;
        for _ in 0..300 {
            let mut damaged = whole.clone();
            for _ in 0..3 {
                seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                let at = 8 + (seed as usize >> 3) % (damaged.len() - 8);
                damaged[at] = (seed >> 24) as u8;
            }
            let _ = answer_from(&damaged);
            let _ = answer(&damaged);
        }
    }
    // Counts that no memory has room for.
    let huge = [&FORM[..], &[0, 0, 0, 0, 0], &[0xFF; 9], &[1]].concat();
    assert_eq!(answer_from(&huge), Err(WireError::Malformed));
}

#[test]
fn requests_are_the_same_where_all_of_them_is() {
    let one = request(Format::Gcode, b"G90\n");
    assert!(one.is_same(&request(Format::Gcode, b"G90\n")));
    assert!(!one.is_same(&request(Format::Gcode, b"G91\n")));
    assert!(!one.is_same(&request(Format::Hpgl, b"G90\n")));
    let mut other = one.clone();
    other.options.gcode.start = None;
    assert!(!one.is_same(&other));
}
