//! Rail positions of taught points: the arm goes there or refuses; they are never dropped.

use magician_host::preflight::Preflight;
use magician_host::{Action, JointAngles, Set, ToolBias};
use magician_program::formats::playback::Playback;
use magician_program::rehearse::{RehearseOptions, rehearse, stage, start_of};
use magician_program::{Content, Diagnostic, Format, Plan, ReadOptions, check, point_list, read};
use magician_protocol::PtpMode;

fn row(number: u32, style: u8, x: u32, rail: &str) -> String {
    format!(
        "<row{number}><item_0>{style}</item_0><item_1 /><item_2>{x}.0</item_2><item_3>20.0</item_3><item_4>40.0</item_4>\
        <item_5>0.0</item_5>{rail}<item_10>0.0</item_10><item_12>0</item_12></row{number}>"
    )
}

fn file(rows: &[String]) -> String {
    format!(
        "<root><DobotType><item_0>Magician</item_0></DobotType><row_StudioVersion><item_0>Ver-194</item_0>\
        </row_StudioVersion>{}</root>",
        rows.concat()
    )
}

fn at(l: f32) -> String {
    format!("<item_36>{l:?}</item_36>")
}

fn taught(format: Format, text: &str) -> Result<(Plan, Vec<Diagnostic>), Diagnostic> {
    let parsed = read(format, text.as_bytes(), &ReadOptions::default())?;
    match parsed.content {
        Content::Plan(plan) => Ok((plan, parsed.notes)),
        _ => panic!("it is a plan"),
    }
}

/// Mode, x, and rail position of each move with the rail.
fn along(plan: &Plan) -> Vec<(PtpMode, f32, f32)> {
    let moves = plan.commands().filter_map(|command| match command {
        Set::PtpWithLCmd(ptp) => Some((ptp.ptp_mode, ptp.x, ptp.l)),
        _ => None,
    });
    moves.collect()
}

fn on_rail() -> String {
    file(&[
        row(0, 1, 220, &at(500.0)),
        row(1, 2, 230, &at(0.0)),
        row(2, 0, 240, ""),
    ])
}

#[test]
fn rail_positions_of_a_playback_move_the_rail() {
    let (plan, notes) = taught(Format::Playback, &on_rail()).unwrap();
    assert_eq!(
        along(&plan),
        [
            (PtpMode::MovjXyz, 220.0, 500.0),
            (PtpMode::MovlXyz, 230.0, 0.0),
            (PtpMode::JumpXyz, 240.0, 0.0),
        ]
    );
    let told: Vec<_> = notes.iter().map(|note| note.message.as_str()).collect();
    assert_eq!(
        told,
        ["it moves along the rail, from 0 to 500 mm: the arm has to be on one"]
    );
    assert_eq!(notes[0].remedies[0].act.to_string(), "use-rail");
    let stage = stage(&plan, &RehearseOptions::default()).unwrap();
    let report = check(&plan, &start_of(&stage));
    assert!(report.is_good(), "{:?}", report.refused_steps);
    let done = rehearse(&plan, &RehearseOptions::default()).unwrap();
    assert!(done.is_good(), "{:?}", done.log);
    // 500 mm at 100 mm/s there, and back.
    assert!(done.time.as_secs() >= 10, "{:?}", done.time);
    assert_eq!(report.time, Some(done.time));
}

#[test]
fn rail_column_of_zeros_is_ignored() {
    let text = file(&[row(0, 1, 220, &at(0.0)), row(1, 2, 230, &at(0.0))]);
    let (plan, notes) = taught(Format::Playback, &text).unwrap();
    assert!(along(&plan).is_empty() && notes.is_empty(), "{notes:?}");
}

#[test]
fn moves_along_an_unconfigured_rail_are_refused() {
    let (plan, _) = taught(Format::Playback, &on_rail()).unwrap();
    let start = Preflight::at(JointAngles::HOME, ToolBias::SUCTION);
    let report = check(&plan, &start);
    assert_eq!(report.refused, 3);
    let error = &report.refused_steps[0].error;
    assert_eq!(
        error.to_string(),
        "SetPTPWithLCmd: needs a rail, for its place at 500 mm, and the arm is not told of one"
    );
    let remedy = error.remedies().first().map(|remedy| remedy.act.clone());
    assert_eq!(remedy, Some(Action::UseRail.into()));
    assert!(check(&plan, &start.on_rail(0.0)).is_good());
}

#[test]
fn rail_does_not_move_on_an_arc() {
    let second = "<item_6>250</item_6><item_7>0</item_7><item_8>40</item_8><item_9>0</item_9>";
    let arc = |l: f32| row(1, 3, 240, &format!("{second}{}", at(l)));
    let same = file(&[row(0, 1, 220, &at(500.0)), arc(500.0)]);
    let (plan, _) = taught(Format::Playback, &same).unwrap();
    assert_eq!((along(&plan).len(), plan.steps.len()), (1, 3));
    let other = file(&[row(0, 1, 220, &at(500.0)), arc(400.0)]);
    let refused = taught(Format::Playback, &other).unwrap_err();
    assert!(
        refused
            .message
            .starts_with("the rail moves to 400 mm on an arc"),
        "{refused}"
    );
    assert_eq!(refused.name.as_deref(), Some("row1"));
}

#[test]
fn playback_that_is_written_keeps_the_rail() {
    let text = on_rail();
    let read_back = Playback::read(text.as_bytes()).unwrap();
    assert_eq!(
        read_back.to_xml(),
        text,
        "unchanged, it has the text that it had"
    );
    let (plan, _) = taught(Format::Playback, &text).unwrap();
    let written = Playback::from_plan(&plan).unwrap();
    let rails: Vec<_> = written.rows.iter().map(|row| row.point().rail).collect();
    assert_eq!(rails, [Some(500.0), Some(0.0), Some(0.0)]);
    assert_eq!(written.rows[0].item(36), Some("500.0"));
    let (again, _) = taught(Format::Playback, &written.to_xml()).unwrap();
    assert_eq!(along(&again), along(&plan));
}

#[test]
fn changing_unknown_item_is_noted_as_possible_motion() {
    let other = |value: u32| format!("<item_37>{value}</item_37>");
    let text = file(&[row(0, 1, 220, &other(3)), row(1, 1, 230, &other(4))]);
    let (_, notes) = taught(Format::Playback, &text).unwrap();
    let told: Vec<_> = notes.iter().map(|note| note.message.as_str()).collect();
    assert_eq!(
        told,
        [
            "rows have unknown items (item_37): they are kept but not played",
            "item_37 is unknown and changes from row to row: if it is a motion, that is not played",
        ]
    );
    let text = file(&[row(0, 1, 220, &other(3)), row(1, 1, 230, &other(3))]);
    assert_eq!(taught(Format::Playback, &text).unwrap().1.len(), 1);
}

#[test]
fn points_with_a_column_for_the_rail_move_the_rail() {
    for name in ["L", "rail (mm)"] {
        let text = format!("x,y,z,{name}\n220,0,40,300\n230,0,40,\n240,0,40,100\n");
        let (plan, notes) = taught(Format::Points, &text).unwrap();
        let rails: Vec<_> = along(&plan).iter().map(|(_, _, l)| *l).collect();
        assert_eq!(rails, [300.0, 300.0, 100.0], "{name}");
        assert_eq!(notes.len(), 1, "{notes:?}");
    }
    let (plan, _) = taught(Format::Points, "x,y,z,l\n220,0,40,0\n230,0,40,0\n").unwrap();
    assert!(along(&plan).is_empty());
    let refused = taught(
        Format::Points,
        "x,y,z,l,motion\n220,0,40,1,movj\n230,0,40,2,path\n",
    );
    assert!(refused.unwrap_err().message.contains("on an arc or a path"));
    let refused = taught(
        Format::Points,
        "t,x,y,z,l\n0,220,0,40,0\n0.1,221,0,40,5\n0.2,222,0,40,9\n",
    );
    assert!(
        refused
            .unwrap_err()
            .message
            .contains("the rail moves in this recording")
    );
}

#[test]
fn list_of_points_keeps_the_rail() {
    let (plan, _) = taught(Format::Playback, &on_rail()).unwrap();
    let text = point_list(&plan);
    assert!(
        text.starts_with("step,action,x,y,z,r,line,name,l\n"),
        "{text}"
    );
    let (again, _) = taught(Format::Points, &text).unwrap();
    assert_eq!(along(&again), along(&plan));
}
