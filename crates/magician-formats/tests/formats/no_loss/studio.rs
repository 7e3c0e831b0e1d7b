//! Files of DobotStudio, DobotLab and other programs.

use magician_formats::{Action, Content, Format, Grip, ReadOptions, Tool, Travel, foreign, read};
use magician_host::Set;

use super::{content, data, note_text, plan};

#[test]
fn rail_positions_of_a_playback_move_the_rail() {
    let (plan, notes) = plan("rail.playback");
    let rails: Vec<f32> = plan
        .commands()
        .filter_map(|command| match command {
            Set::PtpWithLCmd(ptp) => Some(ptp.l),
            _ => None,
        })
        .collect();
    assert_eq!(rails, [500.0, 0.0]);
    assert!(
        note_text(&notes).contains("moves along the rail"),
        "{notes:?}"
    );
}

fn list(entries: &str) -> Result<magician_formats::Parsed, magician_formats::Diagnostic> {
    read(
        Format::Playback,
        format!("[{entries}]").as_bytes(),
        &ReadOptions::default(),
    )
}

const MOVE_BLOCK: &str = r#"{"key":1,"type":"move","device":"Magician","params":{"moveType":"WAY","pointName":"P","point":[220,0,40,0],"slide":SLIDE,"slideL":120}}"#;

#[test]
fn playback_of_dobotlab_is_played() {
    let (plan, notes) = plan("dobotlab.playback");
    let actions: Vec<&Action> = plan.steps.iter().map(|step| &step.action).collect();
    let to = [220.0, 0.0, 40.0, 0.0];
    let expected = [
        Action::Move {
            to,
            by: Travel::Joints,
        },
        Action::Suction(true),
    ];
    assert_eq!(actions, expected.iter().collect::<Vec<_>>());
    assert_eq!(
        (plan.tool, note_text(&notes).as_str()),
        (Some(Tool::Suction), "")
    );
    assert_eq!(plan.name_of(&plan.steps[0].origin), Some("P"));
    assert_eq!(
        Format::of("a", &data("dobotlab.playback")),
        Some(Format::Playback)
    );
    let moves =
        |way: &str, slide: &str| list(&MOVE_BLOCK.replace("WAY", way).replace("SLIDE", slide));
    for (way, by) in [("moveL", Travel::Line), ("jump", Travel::Jump)] {
        let Content::Plan(plan) = moves(way, "false").unwrap().content else {
            panic!("{way}")
        };
        assert_eq!(plan.steps[0].action, Action::Move { to, by });
    }
    let Content::Plan(plan) = moves("moveJ", "true").unwrap().content else {
        panic!("no plan")
    };
    assert!(
        plan.commands()
            .any(|command| matches!(command, Set::PtpWithLCmd(ptp) if ptp.l == 120.0))
    );
    let grip = r#"{"type":"endtool","params":{"name":"gripper","status":"close"}}"#;
    let Content::Plan(plan) = list(grip).unwrap().content else {
        panic!("no plan")
    };
    assert_eq!(plan.steps[0].action, Action::Gripper(Grip::Close));
}

#[test]
fn unsupported_entries_of_dobotlab_are_refused_by_name_and_line() {
    for (entries, says) in [
        (
            MOVE_BLOCK
                .replace("WAY", "moveJ")
                .replace("\"Magician\"", "\"MagicianLite\""),
            "taught on a MagicianLite",
        ),
        (MOVE_BLOCK.replace("WAY", "arc"), "'arc' is not known"),
        (
            r#"{"type":"delay","params":{"time":1}}"#.to_owned(),
            "'delay' is not known",
        ),
        (
            r#"{"type":"endtool","params":{"name":"laser","status":"on"}}"#.to_owned(),
            "'laser'",
        ),
        (
            r#"{"type":"move","params":{"moveType":"moveJ","point":[1,2]}}"#.to_owned(),
            "no point",
        ),
        (
            r#"{"type":"move","params":{"moveType":"moveJ","point":[1,2,3,4],"slide":true}}"#
                .to_owned(),
            "slideL",
        ),
        ("1".to_owned(), "expected an object"),
        (String::new(), "no entries"),
    ] {
        let refused = list(&format!("\n{}", entries.replace("SLIDE", "false"))).unwrap_err();
        assert!(refused.message.contains(says), "{refused}");
        assert!(entries.is_empty() || refused.origin.line == 2, "{refused}");
    }
}

#[test]
fn blocks_of_dobotlab_are_named_with_what_runs_them() {
    let refused = content("dobotlab.blockly", &ReadOptions::default()).unwrap_err();
    assert!(
        refused
            .message
            .contains("'Magician_SetPTPCmd' is a block of DobotLab"),
        "{refused}"
    );
    assert!(refused.help.unwrap_or_default().contains("Python"));
}

#[test]
fn foreign_files_are_named_with_advice() {
    for (name, what, way) in [
        ("x.pdf", "a PDF document", "SVG"),
        ("x.eps", "a PostScript drawing", "SVG"),
        ("x.dwg", "a DWG drawing", "DXF"),
        ("studio.script", "a program in Python", "Python"),
    ] {
        let found = foreign(name, &data(name)).unwrap();
        assert!(
            found.message.contains(what) && found.help.unwrap().contains(way),
            "{name}"
        );
    }
    let heic = b"\0\0\0\x18ftypheic\0\0\0\0";
    let avif = b"\0\0\0\x1cftypavif\0\0\0\0";
    let lightburn = b"<?xml version=\"1.0\"?>\n<LightBurnProject AppVersion=\"1.7\">";
    for (name, bytes, what, way) in [
        ("photo.heic", &heic[..], "HEIC", "JPEG"),
        ("photo", heic, "HEIC", "JPEG"),
        ("photo.avif", avif, "AVIF", "JPEG"),
        ("sign.lbrn2", lightburn, "LightBurn", "G-code"),
        ("sign", lightburn, "LightBurn", "G-code"),
        ("part.STL", b"solid part", "three dimensions", "DXF"),
        ("logo.ai", b"", "Illustrator", "SVG"),
        ("part.3mf", b"PK\x03\x04", "three dimensions", "DXF"),
    ] {
        let found = foreign(name, bytes).unwrap();
        assert!(
            found.message.contains(what) && found.help.unwrap().contains(way),
            "{name}"
        );
        assert_eq!(Format::of(name, bytes), None, "{name}");
    }
    assert_eq!(foreign("house.svg", b"<svg/>"), None);
    // Content with the signature of a foreign format is refused in every format, whatever its name.
    for (format, bytes) in [
        (Format::Svg, data("x.pdf")),
        (Format::Image, heic.to_vec()),
        (Format::Dxf, data("x.dwg")),
    ] {
        let refused = read(format, &bytes, &ReadOptions::default()).unwrap_err();
        assert!(refused.message.contains("which is not read"), "{refused}");
    }
}

#[test]
fn netpbm_images_are_read_and_animated_ones_name_their_frame() {
    for name in ["i.pgm", "i_1bit.pbm"] {
        let Content::Image(raster) = content(name, &ReadOptions::default()).unwrap().content else {
            panic!("{name}");
        };
        assert_eq!((raster.width, raster.height), (80, 60), "{name}");
        assert_eq!(Format::of("a", &data(name)), Some(Format::Image));
    }
    let animated = content("i_anim_blankfirst.gif", &ReadOptions::default()).unwrap();
    assert!(
        note_text(&animated.notes).contains("only the first of its 3 pictures")
            || note_text(&animated.notes).contains("only the first of its 2 pictures"),
        "{:?}",
        animated.notes
    );
    // TIFF with fax compression or with floating-point samples is refused with a reason in our own
    // words.
    let tiff = |bits: u16, compression: u16, format: u16| {
        let entries: [(u16, u16, u32); 9] = [
            (256, 3, 1),
            (257, 3, 1),
            (258, 3, bits.into()),
            (259, 3, compression.into()),
            (262, 3, 1),
            (273, 4, 8),
            (277, 3, 1),
            (278, 3, 1),
            (339, 3, format.into()),
        ];
        let mut file = b"II*\0\x10\0\0\0\0\0\0\0\0\0\0\0".to_vec();
        file.extend((entries.len() as u16).to_le_bytes());
        file.extend(
            [&entries[..5], &entries[5..6], &entries[6..8]]
                .concat()
                .iter()
                .chain(&[(279, 4, 8)])
                .chain(&entries[8..])
                .take(9)
                .flat_map(|(tag, kind, value): &(u16, u16, u32)| {
                    [
                        tag.to_le_bytes().to_vec(),
                        kind.to_le_bytes().to_vec(),
                        1_u32.to_le_bytes().to_vec(),
                        value.to_le_bytes().to_vec(),
                    ]
                    .concat()
                }),
        );
        file.extend([0; 4]);
        file
    };
    for file in [tiff(1, 3, 1), tiff(32, 1, 3)] {
        let refused = read(Format::Image, &file, &ReadOptions::default());
        if let Err(refused) = refused {
            assert!(!refused.message.contains("Unknown("), "{refused}");
        }
    }
}
