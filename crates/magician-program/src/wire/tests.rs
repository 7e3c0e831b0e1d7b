//! Tests of serialisation: round trips, other builds, damaged input.

use std::path::Path;

use serde_json::json;

use super::*;

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

fn file(format: Format, bytes: &[u8]) -> PrepareRequest {
    let options = json!({
        "at": [230, -0.5], "fit": true, "surface": -60, "start": [200, -0.0, 5.5], "speed": 20.1,
    });
    let keep_out = Cuboid {
        min: [0.0, 200.0, -100.0],
        max: [50.0, 250.0, 0.1],
    };
    PrepareRequest {
        title: "größe".to_owned(),
        surface_slope: [0.01, -0.02],
        preset_note: Some(Diagnostic::of_file("of a preset")),
        rest: 250,
        tool: Some(Tool::Laser),
        options: SetupOptions::from_fields(options.as_object().unwrap()).unwrap(),
        defaults: SetupDefaults {
            tool: Some(Tool::Bias([61.0, 0.5, -2.0])),
            engrave_power: Some(Power::new(5.0, 80.0).unwrap()),
            ..SetupDefaults::default()
        },
        fence: Fence::default().with_keep_out(keep_out).ok(),
        ..PrepareRequest::new(format, bytes)
    }
}

#[test]
fn request_round_trips() {
    let mut asked = file(Format::Gcode, b"G90\n");
    let all = Fence::default().with_floor(-70.0).unwrap();
    let all = all.with_top_speed(80.0).unwrap().with_strongest_laser(40.0);
    let within = Cuboid {
        min: [100.0, -200.0, -70.0],
        max: [300.0, 200.0, 100.0],
    };
    asked.fence = Some(all.unwrap().with_box(within).unwrap());
    for begins in [
        StartPosition::Unread,
        StartPosition::At([200.0, 0.1, -3.0]),
        StartPosition::Unknown,
        StartPosition::Staged,
    ] {
        asked.start = begins;
        assert_eq!(
            PrepareRequest::from_bytes(&asked.to_bytes()),
            Ok(asked.clone())
        );
    }
    let plain = PrepareRequest::new(Format::Svg, b"");
    assert_eq!(PrepareRequest::from_bytes(&plain.to_bytes()), Ok(plain));
}

#[test]
fn prepared_program_round_trips() {
    for (format, bytes) in samples() {
        for mut file in [file(format, &bytes), PrepareRequest::new(format, &bytes)] {
            file.start = StartPosition::Staged;
            let laid = file.prepare();
            let answered = answer(&file.to_bytes());
            assert_eq!(answer_from(&file, &answered), Ok(laid), "{format}");
        }
    }
}

#[test]
fn needs_start_round_trips() {
    let file = PrepareRequest::new(Format::Gcode, b"G91\nG1 X5 Y5 F600\n");
    assert_eq!(file.prepare(), Ok(Preparation::NeedsStart));
    let answered = answer(&file.to_bytes());
    assert_eq!(
        answer_from(&file, &answered),
        Ok(Ok(Preparation::NeedsStart))
    );
}

#[test]
fn error_round_trips_with_origin_and_advice() {
    for (format, text) in [
        (Format::Gcode, "G90\nG1 X10 Y%\n"),
        (Format::Svg, "<svg width='-3'"),
        (
            Format::Svg,
            "<svg xmlns='http://www.w3.org/2000/svg'><path d='M0 0L9 9'/></svg>",
        ),
        (Format::Points, "x,y\n1,oops\n"),
        (Format::Image, "no image"),
    ] {
        let mut file = PrepareRequest::new(format, text.as_bytes());
        file.start = StartPosition::Staged;
        let laid = file.prepare();
        assert!(laid.is_err(), "{text}");
        let answered = answer(&file.to_bytes());
        assert_eq!(answer_from(&file, &answered), Ok(laid), "{text}");
    }
    let given = Diagnostic::of_file("all kinds of advice")
        .named("rect7")
        .help("save it as UTF-8")
        .remedy(Deed::Home, "homes it")
        .remedy((Setting::Scale, SettingValue::Number(f64::INFINITY)), "")
        .remedy((Setting::At, SettingValue::Point(200.0, -5.5)), "places it")
        .remedy(
            (Setting::Start, SettingValue::Position([200.0, -0.0, 5.5])),
            "begins there",
        )
        .remedy((Setting::White, SettingValue::Word("draw")), "keeps it")
        .remedy((Setting::Fit, SettingValue::On), "shrinks it")
        .with(Remedy::without(Setting::Raw))
        .with_missing(Some(Missing::Feature("drawings")));
    let given = PrepareError::new(
        PrepareStage::Place,
        given,
        vec![Diagnostic::of_file("a note")],
    );
    let request = PrepareRequest::new(Format::Svg, b"");
    let answered = answer_bytes(&Err(given.clone()));
    assert_eq!(answer_from(&request, &answered), Ok(Err(given)));
}

#[test]
fn bytes_of_another_build_are_refused() {
    let request = PrepareRequest::new(Format::Gcode, b"G90\nG1 X220 Y0 Z20 F600\n");
    let mut bytes = request.to_bytes();
    let mut answered = answer(&bytes);
    bytes[3] ^= 1;
    assert_eq!(answer(&bytes), FORMAT_ID);
    assert_eq!(answer_from(&request, &FORMAT_ID), Err(WireError::Malformed));
    answered[7] ^= 0x80;
    assert_eq!(answer_from(&request, &answered), Err(WireError::OtherBuild));
    assert!(
        WireError::OtherBuild
            .to_string()
            .contains("reload the page")
    );
}

#[test]
fn truncated_answers_are_refused() {
    for (format, bytes) in samples() {
        let request = file(format, &bytes);
        let whole = answer(&request.to_bytes());
        let step = (whole.len() / 200).max(1);
        for count in (0..whole.len()).step_by(step) {
            assert!(
                answer_from(&request, &whole[..count]).is_err(),
                "{format} {count}"
            );
        }
        let longer = [&whole[..], &[0]].concat();
        assert_eq!(answer_from(&request, &longer), Err(WireError::Malformed));
        // Damaged input may decode or not: it must only terminate.
        let mut seed = 1_u32;
        for _ in 0..300 {
            let mut damaged = whole.clone();
            for _ in 0..3 {
                seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                let at = 8 + (seed as usize >> 3) % (damaged.len() - 8);
                damaged[at] = (seed >> 24) as u8;
            }
            let _ = answer_from(&request, &damaged);
            let _ = answer(&damaged);
        }
    }
    // Counts larger than any memory.
    let huge = [&FORMAT_ID[..], &[0, 0, 0, 0, 0], &[0xFF; 9], &[1]].concat();
    let request = PrepareRequest::new(Format::Svg, b"");
    assert_eq!(answer_from(&request, &huge), Err(WireError::Malformed));
}
