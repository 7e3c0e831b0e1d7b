//! Files refused as playback files, and the positions of the refusals.

use magician_formats::formats::playback::Playback;
use magician_formats::{Format, ReadOptions, read};
use proptest::prelude::*;

use super::machine::sample;

/// Returns the message for a file whose only row has these items.
fn refusal(items: &str) -> String {
    whole(&format!("<root>\n<row0>{items}</row0></root>"))
}

fn whole(file: &str) -> String {
    let diagnostic = Playback::read(file.as_bytes()).unwrap_err();
    match &diagnostic.help {
        Some(help) => format!("{diagnostic} [{help}]"),
        None => diagnostic.to_string(),
    }
}

const POSE: &str = "<item_2>1</item_2><item_3>2</item_3><item_4>3</item_4><item_5>4</item_5>";

#[test]
fn other_xml_is_not_a_playback_file() {
    assert_eq!(
        whole("<svg/>"),
        "line 1, column 1: this is not a playback file of DobotStudio: its outermost element is \
            'svg' [this looks like a drawing: rename it to '.svg']"
    );
    assert_eq!(
        whole("<xml><block/></xml>"),
        "line 1, column 1: this is not a playback file of DobotStudio: its outermost element is \
            'xml' [this looks like a DobotBlockly workspace: rename it to '.blockly']"
    );
    assert_eq!(
        whole("<root><a/></root>"),
        "line 1, column 1: this is not a playback file of DobotStudio: it has no rows [its points \
            are in elements called row0, row1 and so on]"
    );
    let no_xml = whole("G1 X20");
    assert!(
        no_xml.starts_with("line 1, column 1: this is not XML: "),
        "{no_xml}"
    );
    let diagnostic = Playback::read(b"<root>\n \xff\0</root>").unwrap_err();
    assert_eq!(
        diagnostic.to_string(),
        "line 2, column 2: this is not UTF-8 text"
    );
    let m1 = "<root><DobotType><item_0>M1</item_0></DobotType></root>";
    assert_eq!(
        whole(m1),
        "line 1, column 26: this was taught on a M1, and its points are other positions here [teach the points again on a Magician]"
    );
}

#[test]
fn row_needs_a_position_and_a_motion() {
    let cases = [
        (
            POSE.to_owned(),
            "line 2, column 1 (row0): it has no item_0 (motion style)",
        ),
        (
            "<item_0>1</item_0><item_2>1</item_2><item_3 />".to_owned(),
            "line 2, column 43 (row0): it has no item_3 (Y)",
        ),
        (
            format!("<item_0>7</item_0>{POSE}"),
            "line 2, column 15 (row0): item_0 (motion style) is 7; known are 0 JUMP, 1 MOVJ, 2 MOVL, 3 or 4 ARC",
        ),
        (
            format!("<item_0>1.5</item_0>{POSE}"),
            "line 2, column 15 (row0): item_0 (motion style) is 1.5; known are 0 JUMP, 1 MOVJ, 2 MOVL, 3 or 4 ARC",
        ),
        (
            "<item_0>1</item_0><item_2>12,5</item_2>".to_owned(),
            "line 2, column 33 (row0): item_2 (X) is '12,5', which is not a number [numbers are written with a decimal point]",
        ),
        (
            "<item_0>1</item_0><item_2>NaN</item_2>".to_owned(),
            "line 2, column 33 (row0): item_2 (X) is NaN, which is out of range",
        ),
        (
            "<item_0>1</item_0><item_2>1e39</item_2>".to_owned(),
            "line 2, column 33 (row0): item_2 (X) is 1e39, which is out of range",
        ),
        (
            format!("<item_0>1</item_0>{POSE}<item_10>-1</item_10>"),
            "line 2, column 106 (row0): it pauses for -1 s, it must be 0 to 4294967.295 s",
        ),
        (
            format!("<item_0>1</item_0>{POSE}<item_10>5e6</item_10>"),
            "line 2, column 106 (row0): it pauses for 5000000 s, it must be 0 to 4294967.295 s",
        ),
        (
            format!("<item_0>1</item_0>{POSE}<item_11>3</item_11>"),
            "line 2, column 106 (row0): item_11 (gripper) is 3; known are 0 off, 1 open, 2 closed",
        ),
        (
            format!("<item_0>1</item_0>{POSE}<item_12>2</item_12>"),
            "line 2, column 106 (row0): item_12 (suction cup) is 2; known are 0 off, 1 on",
        ),
        (
            format!("<item_0>1</item_0>{POSE}<item_2>1</item_2>"),
            "line 2, column 105 (row0): item_2 appears twice",
        ),
        (
            format!("<item_0>1</item_0>{POSE}<item_11>1</item_11><item_12>1</item_12>"),
            "line 2, column 117 (row0): row0 uses the gripper and row0 the suction cup; the arm has one tool",
        ),
    ];
    for (items, expected) in cases {
        assert_eq!(refusal(&items), expected, "{items}");
    }
}

/// Styles 3 and 4 are an arc only with a second point.
#[test]
fn an_arc_without_a_second_point_is_refused() {
    for (style, second) in [
        (3, ""),
        (4, ""),
        (3, "<item_6 /><item_7 />"),
        (4, "<item_6>0.0</item_6><item_7>0</item_7>"),
    ] {
        let said = refusal(&format!("<item_0>{style}</item_0>{POSE}{second}"));
        assert_eq!(
            said,
            format!(
                "line 2, column 15 (row0): motion style {style} is an arc, but items 6 to 9 have \
                    no second point; another meaning is unknown [teach this point again, or give \
                it style 0 (JUMP), 1 (MOVJ) or 2 (MOVL)]"
            )
        );
    }
    let half = refusal(&format!(
        "<item_0>3</item_0>{POSE}<item_6>200</item_6><item_7>10</item_7>"
    ));
    assert_eq!(half, "line 2, column 1 (row0): it has no item_8 (second Z)");
}

#[test]
fn skipped_items_are_noted() {
    let row = |n: u32| {
        format!(
            "<row{n}><item_0>1</item_0><item_2>1</item_2><item_3>2</item_3><item_4>3</item_4></row{n}>"
        )
    };
    let playback = Playback::read(format!("<root>{}{}</root>", row(1), row(0)).as_bytes()).unwrap();
    let notes: Vec<_> = playback.notes().iter().map(ToString::to_string).collect();
    assert_eq!(
        notes,
        [
            "line 1, column 7 (row1): it has no R: 0 is used",
            "line 1, column 92 (row0): it has no R: 0 is used",
            "line 1, column 31: row1 found where row0 is expected; rows are played in the order of the file",
        ]
    );
    assert_eq!(playback.rows[0].number(), 1, "the order of the file");
}

fn assert_read_or_refused(bytes: &[u8]) {
    if read(Format::Playback, bytes, &ReadOptions::default()).is_ok() {
        let playback = Playback::read(bytes).unwrap();
        let again = Playback::read(playback.to_xml().as_bytes()).unwrap();
        assert_eq!(again, playback);
    }
}

proptest! {
    #[test]
    fn arbitrary_bytes_are_read_or_refused(bytes in proptest::collection::vec(any::<u8>(), 0..400)) {
        assert_read_or_refused(&bytes);
    }

    #[test]
    fn damaged_files_are_read_or_refused(
        nth in 0..4usize,
        at in any::<prop::sample::Index>(),
        length in 0..40usize,
        other in "[0-9a-z<>/&;_ .\"=-]{0,12}",
    ) {
        let names = ["arc_movl_v1412", "gripper_pick_v194", "jump_suction_named_v170", "suction_points_v194"];
        let mut bytes = sample(&format!("{}.playback", names[nth]));
        let at = at.index(bytes.len());
        let end = (at + length).min(bytes.len());
        bytes.splice(at..end, other.bytes());
        assert_read_or_refused(&bytes);
    }
}
