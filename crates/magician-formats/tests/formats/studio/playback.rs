//! Samples of playback files: the steps, the final pose, and no alarm on the way.

use magician_formats::formats::playback::Playback;
use magician_formats::{Format, Tool};

use super::machine::{plan, plan_text, run, sample};

#[test]
fn suction_cup_points_are_played_in_order() {
    let (plan, notes) = plan(Format::Playback, &sample("suction_points_v194.playback"));
    let expected = "
        row0: joints 127.2309 37.1679 -27.9548 16.2846
        row0: suction off
        row1: joints 217.7928 63.6237 112.7849 16.2846
        row2: joints 157.6585 163.1732 112.7849 45.9847
        row3: joints 217.7928 63.6237 112.7849 16.2846
        row4: joints 127.2309 37.1679 -27.9548 16.2846";
    assert_eq!(plan_text(&plan), expected);
    assert!(notes.is_empty(), "{notes:?}");
    assert_eq!(plan.tool, Some(Tool::Suction));
    assert_eq!(
        run(&plan, Tool::None),
        [127.2309, 37.1679, -27.9548, 16.2846]
    );
}

#[test]
fn jumps_names_and_pauses_are_those_of_the_file() {
    let (plan, notes) = plan(
        Format::Playback,
        &sample("jump_suction_named_v170.playback"),
    );
    let expected = "
        Home: joints 220 0 60 0
        Home: suction off
        Pick: jump 240 -60 -20 0
        Pick: suction on
        Pick: wait 500
        Place: jump 200 120 -10 30
        row3: line 200 120 -20 30
        row3: suction off
        row3: wait 250
        Home2: joints 220 0 60 0";
    assert_eq!(plan_text(&plan), expected);
    assert!(notes.is_empty(), "{notes:?}");
    assert_eq!(run(&plan, Tool::None), [220.0, 0.0, 60.0, 0.0]);
}

#[test]
fn gripper_command_is_sent_only_on_change() {
    let (plan, notes) = plan(Format::Playback, &sample("gripper_pick_v194.playback"));
    let expected = "
        row0: joints 166.5096 -8.6768 -50.3821 37.917
        row0: gripper Off
        row1: joints 166.5088 -8.6768 45.8103 37.917
        row2: joints 136.5861 95.6279 45.8103 75.897
        row3: joints 140.8202 99.1645 11.3106 76.0529
        row4: joints 140.8202 99.1645 11.3106 76.0529
        row4: gripper Open
        row5: joints 140.8202 99.1645 11.3106 76.0529
        row5: gripper Close
        row6: joints 140.8202 99.1644 35.4546 76.0529
        row7: joints 172.1055 -6.6028 35.4546 38.7029
        row8: joints 172.1055 -6.6028 35.4546 -146.4771
        row9: joints 158.0942 -68.3383 35.4546 -167.6571
        row10: joints 179.6473 -77.6549 32.6332 -167.6571
        row11: joints 181.9947 -81.3655 7.1658 -168.3683
        row12: joints 181.9947 -81.3655 7.1658 -168.3683
        row12: gripper Open
        row13: joints 167.7602 -75.0016 12.511 -168.3683
        row14: joints 167.7605 -75.0017 35.359 -168.3683
        row15: joints 183.3615 -12.1413 35.359 -148.0683
        row16: joints 166.5096 -8.6768 -50.3821 37.917
        row16: gripper Off";
    assert_eq!(plan_text(&plan), expected);
    assert!(notes.is_empty(), "{notes:?}");
    assert_eq!(plan.tool, Some(Tool::Gripper));
    assert_eq!(
        run(&plan, Tool::None),
        [166.5096, -8.6768, -50.3821, 37.917]
    );
}

/// The arcs of rows 10 and 11 start at the point through which they should go.
#[test]
fn degenerate_arcs_become_straight_lines() {
    let (plan, notes) = plan(Format::Playback, &sample("arc_movl_v1412.playback"));
    let expected = "
        Init: line 250 0 0 0
        row1: line 250.3231 -110.9432 10 0
        row2: joints 250 -100 -60 0
        row3: joints 250 -110 -55 0
        row4: arc 250 -110 -60 0 to 220 -110 -55 0
        row5: arc 220 -110 -60 0 to 250 -110 -55 0
        row6: arc 250 -110 -60 0 to 220 -110 -55 0
        row7: joints 250 -100 0 0
        row8: arc 250 140 5 0 to 250 140 -10 0
        row9: joints 250 140 -60 0
        row10: line 220 140 -60 0
        row11: line 250 120 -60 0
        row12: arc 250 140 -60 0 to 220 140 -60 0
        Init: line 250 0 0 0";
    assert_eq!(plan_text(&plan), expected);
    let why = "two of its three points are the same, so it is not an arc: it is played as a straight line to its end";
    let rows = ["line 1, column 2288 (row10)", "line 1, column 2525 (row11)"];
    assert_eq!(notes, rows.map(|row| format!("{row}: {why}")));
    assert_eq!(plan.tool, None, "files of 1.4 do not say it");
    assert_eq!(run(&plan, Tool::Suction), [250.0, 0.0, 0.0, 0.0]);
}

/// Returns a file with a start and an arc.
fn arc(from: [f32; 3], via: [f32; 3], to: [f32; 3]) -> String {
    let items = |first: u32, point: [f32; 3]| -> String {
        let numbers = (first..).zip(point);
        numbers
            .map(|(n, value)| format!("<item_{n}>{value}</item_{n}>"))
            .collect()
    };
    let r = |n: u32, r: f32| format!("<item_{n}>{r}</item_{n}>");
    format!(
        "<root><row0><item_0>1</item_0>{}{}</row0><row1><item_0>3</item_0>{}{}{}{}</row1></root>",
        items(2, from),
        r(5, 10.0),
        items(2, via),
        r(5, 99.0),
        items(6, to),
        r(9, 40.0),
    )
}

#[test]
fn points_on_a_line_are_lines_through_all_of_them() {
    let told_for = |from, via, to| {
        let (plan, notes) = plan(Format::Playback, arc(from, via, to).as_bytes());
        assert_eq!(
            notes.len(),
            plan.steps[1..]
                .iter()
                .filter(|step| matches!(step.action, magician_formats::Action::Move { .. }))
                .count()
                .min(1)
        );
        run(&plan, Tool::Suction);
        plan_text(&plan)
            .lines()
            .skip(2)
            .map(str::trim)
            .collect::<Vec<_>>()
            .join(", ")
    };
    let a = [220.0, 0.0, 0.0];
    let between = told_for(a, [230.0, 0.0, 0.0], [260.0, 0.0, 0.0]);
    assert_eq!(between, "row1: line 260 0 0 40");
    let beyond = told_for(a, [260.0, 0.0, 0.0], [240.0, 0.0, 0.0]);
    assert_eq!(beyond, "row1: line 260 0 0 30, row1: line 240 0 0 40");
    let behind = told_for(a, [210.0, 0.0, 0.0], [240.0, 0.0, 0.0]);
    assert_eq!(behind, "row1: line 210 0 0 17.5, row1: line 240 0 0 40");
    let there_and_back = told_for(a, [220.0, 40.0, 0.0], a);
    assert_eq!(
        there_and_back,
        "row1: line 220 40 0 25, row1: line 220 0 0 40"
    );
    let nowhere = told_for(a, a, a);
    assert_eq!(nowhere, "row1: line 220 0 0 40");
    let bent = told_for(a, [230.0, 1.0, 0.0], [240.0, 0.0, 0.0]);
    assert_eq!(bent, "row1: arc 230 1 0 99 to 240 0 0 40");
}

/// The origin of a step leads to the text of its items.
#[test]
fn step_origins_are_their_items() {
    let bytes = sample("jump_suction_named_v170.playback");
    let text = std::str::from_utf8(&bytes).unwrap();
    let (plan, _) = plan(Format::Playback, &bytes);
    let lines = magician_formats::Lines::new(text);
    let shown: Vec<_> = (plan.steps[2..5].iter())
        .map(|step| &text[lines.range(&step.origin).unwrap()])
        .collect();
    let coordinates =
        "<item_2>240.0</item_2><item_3>-60.0</item_3><item_4>-20.0</item_4><item_5>0.0</item_5>";
    assert_eq!(
        shown,
        [
            coordinates,
            "<item_12>1</item_12>",
            "<item_10>0.5</item_10>"
        ]
    );
}

/// Indentation, a declaration, and renamed or reordered items do not change the points.
#[test]
fn item_order_whitespace_and_unknown_items_are_ignored() {
    let file = r#"<?xml version="1.0" encoding="utf-8"?>
<root>
  <row_StudioVersion><item_0>Ver-170</item_0></row_StudioVersion>
  <row0 note="mine">
    <!-- the first -->
    <item_12> 1 </item_12>
    <item_5> 0 </item_5> <item_4>50</item_4> <item_3>1e1</item_3> <item_2>+220</item_2>
    <item_13>left &amp; right</item_13>
    <joints unit="deg"><j1>1</j1></joints>
    <item_0>2.0</item_0>
  </row0>
  <Loops><item_0>3</item_0></Loops>
</root>
"#;
    let (plan, notes) = plan(Format::Playback, file.as_bytes());
    assert_eq!(
        plan_text(&plan),
        "
        row0: line 220 10 50 0
        row0: suction on"
    );
    assert_eq!(
        notes,
        [
            "line 12, column 3: 'Loops' is unknown: it is kept but not played",
            "rows have unknown items (item_13, joints): they are kept but not played",
        ]
    );
    let playback = Playback::read(file.as_bytes()).unwrap();
    assert_eq!(playback.rows[0].item(13), Some("left & right"));
    let written = playback.to_xml();
    assert!(
        written.contains("<Loops><item_0>3</item_0></Loops>"),
        "{written}"
    );
    assert!(
        written.contains(
            "<item_13>left &amp; right</item_13><joints unit=\"deg\"><j1>1</j1></joints>"
        )
    );
    assert_eq!(Playback::read(written.as_bytes()).unwrap(), playback);
}

#[test]
fn tool_is_inferred_from_the_used_column() {
    let tool = |items: &str| {
        let file = format!(
            "<root><row0><item_0>1</item_0><item_2>220</item_2><item_3>0</item_3><item_4>0</item_4><item_5>0</item_5>{items}</row0></root>"
        );
        let playback = Playback::read(file.as_bytes()).unwrap();
        (playback.tool(), playback.to_plan().content.steps.len())
    };
    let both = |grip, suck| format!("<item_11>{grip}</item_11><item_12>{suck}</item_12>");
    assert_eq!(tool(""), (None, 1));
    assert_eq!(tool("<item_11>0</item_11>"), (Some(Tool::Gripper), 2));
    assert_eq!(tool("<item_12>0</item_12>"), (Some(Tool::Suction), 2));
    assert_eq!(tool(&both(2, 0)), (Some(Tool::Gripper), 2));
    assert_eq!(tool(&both(0, 1)), (Some(Tool::Suction), 2));
    assert_eq!(tool(&both(0, 0)), (None, 3));
}
