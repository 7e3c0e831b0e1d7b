//! Playback files written again, and plans written as playback files.

use magician::build;
use magician_formats::formats::playback::Playback;
use magician_formats::{Action, Format, Grip, Origin, Plan, Tool, Travel};
use proptest::prelude::*;

use super::machine::{plan, plan_text, sample};

/// Unchanged files are written byte for byte as the studio wrote them.
#[test]
fn unchanged_file_is_written_byte_for_byte() {
    for name in [
        "arc_movl_v1412",
        "gripper_pick_v194",
        "jump_suction_named_v170",
        "suction_points_v194",
    ] {
        let bytes = sample(&format!("{name}.playback"));
        let playback = Playback::read(&bytes).unwrap();
        assert_eq!(playback.to_xml().as_bytes(), bytes, "{name}");
    }
}

#[test]
fn plan_round_trips_through_its_file() {
    for name in [
        "arc_movl_v1412",
        "gripper_pick_v194",
        "jump_suction_named_v170",
        "suction_points_v194",
    ] {
        let (read, _) = plan(Format::Playback, &sample(&format!("{name}.playback")));
        let written = Playback::from_plan(&read).unwrap();
        assert!(written.notes().is_empty(), "{:?}", written.notes());
        let (again, _) = plan(Format::Playback, written.to_xml().as_bytes());
        assert_eq!(plan_text(&again), plan_text(&read), "{name}");
        assert_eq!(again.tool, read.tool);
    }
}

fn of(actions: impl IntoIterator<Item = Action>) -> Plan {
    let mut plan = Plan::new("test");
    for action in actions {
        plan.push(action, Origin::NONE);
    }
    plan
}

const MOVE_HERE: Action = Action::Move {
    to: [220.0, 0.0, 50.5, -7.25],
    by: Travel::Line,
};

#[test]
fn a_row_has_the_items_of_studio_1_9() {
    let arc = Action::Arc {
        via: [230.0, 10.0, 50.0, 0.0],
        to: [240.0, 0.0, 50.0, 0.0],
    };
    let mut plan = of([MOVE_HERE, Action::Suction(true), Action::Wait(1250), arc]);
    let index = plan.name("A & B");
    plan.steps[0].origin = Origin::NONE.named(index);
    let expected = "<root><DobotType><item_0>Magician</item_0></DobotType><row_StudioVersion><item_0>Ver-194</item_0></row_StudioVersion>\
        <row0><item_0>2</item_0><item_1>A &amp; B</item_1><item_2>220.0</item_2><item_3>0.0</item_3><item_4>50.5</item_4><item_5>-7.25</item_5>\
        <item_6 /><item_7 /><item_8 /><item_9 /><item_10>1.25</item_10><item_12>1</item_12></row0>\
        <row1><item_0>3</item_0><item_1 /><item_2>230.0</item_2><item_3>10.0</item_3><item_4>50.0</item_4><item_5>0.0</item_5>\
        <item_6>240.0</item_6><item_7>0.0</item_7><item_8>50.0</item_8><item_9>0.0</item_9><item_10>0.0</item_10><item_12>1</item_12></row1></root>";
    assert_eq!(Playback::from_plan(&plan).unwrap().to_xml(), expected);
}

/// A row is a move, a tool and a pause in this order; any other order needs another row.
#[test]
fn a_tool_after_a_pause_has_a_row_of_its_own() {
    let plan = of([
        MOVE_HERE,
        Action::Gripper(Grip::Open),
        Action::Wait(500),
        Action::Gripper(Grip::Close),
        Action::Wait(300),
        Action::Wait(200),
        Action::Gripper(Grip::Close),
        MOVE_HERE,
    ]);
    let written = Playback::from_plan(&plan).unwrap();
    let expected = "
        row0: line 220 0 50.5 -7.25
        row0: gripper Open
        row0: wait 500
        row1: joints 220 0 50.5 -7.25
        row1: gripper Close
        row1: wait 500
        row2: line 220 0 50.5 -7.25";
    assert_eq!(plan_text(&written.to_plan().content), expected);
}

#[test]
fn unstorable_steps_are_noted_or_refused() {
    let command = |set| Action::Command(Box::new(set));
    let settings = [
        command(build::speed(50.0, 50.0)),
        command(build::line_speed(100.0, 100.0)),
        command(build::jump_height(20.0, 100.0)),
    ];
    let mut plan = of(settings.into_iter().chain([MOVE_HERE]));
    plan.tool = Some(Tool::Pen);
    let written = Playback::from_plan(&plan).unwrap();
    let notes: Vec<_> = written.notes().iter().map(ToString::to_string).collect();
    assert_eq!(
        notes,
        [
            "the file cannot store that its points are for the tool 'pen'",
            "the speeds are left out: a playback file does not have them",
            "the heights of jumps are left out: a playback file does not have them",
        ]
    );

    let refusals = [
        (
            of([MOVE_HERE, Action::Home]),
            "step 2 is a SetHOMECmd, which a playback file cannot store",
        ),
        (
            of([MOVE_HERE, Action::Path { to: [1.0; 3] }]),
            "step 2 is a SetCPCmd, which a playback file cannot store",
        ),
        (
            of([
                MOVE_HERE,
                Action::Shift {
                    by: [1.0; 4],
                    line: true,
                },
            ]),
            "step 2 is a SetPTPCmd, which a playback file cannot store",
        ),
        (
            of([Action::Suction(true), MOVE_HERE]),
            "step 1 comes before the first move, which a playback file cannot store",
        ),
        (
            of([
                MOVE_HERE,
                Action::Suction(true),
                Action::Gripper(Grip::Open),
            ]),
            "step 3 uses the gripper, an earlier one the suction cup, which a playback file cannot store",
        ),
        (
            of([MOVE_HERE, Action::Wait(u32::MAX), Action::Wait(1)]),
            "step 3 waits for more than 49 days, which a playback file cannot store",
        ),
        (
            of([Action::Move {
                to: [f32::NAN; 4],
                by: Travel::Jump,
            }]),
            "step 1 leads to a coordinate that is not a number, which a playback file cannot store",
        ),
        (of([]), "there is no move to a pose to store"),
    ];
    for (plan, expected) in refusals {
        assert_eq!(
            Playback::from_plan(&plan).unwrap_err().to_string(),
            expected
        );
    }
}

/// The file keeps the tool of a plan even if the plan never uses it.
#[test]
fn a_tool_that_rests_is_off_from_the_first_row_on() {
    for tool in [Tool::Suction, Tool::Gripper] {
        let plan = Plan {
            tool: Some(tool),
            ..of([MOVE_HERE])
        };
        let written = Playback::from_plan(&plan).unwrap();
        assert_eq!(written.tool(), Some(tool));
        assert_eq!(written.to_plan().content.steps.len(), 2);
    }
}

fn number() -> impl Strategy<Value = f32> {
    prop_oneof![
        -400.0..400.0f32,
        Just(0.0f32),
        Just(-0.0f32),
        any::<f32>().prop_filter("finite", |x| x.is_finite())
    ]
}

fn pose() -> impl Strategy<Value = [f32; 4]> {
    [number(), number(), number(), number()]
}

fn action() -> impl Strategy<Value = Action> {
    let travel = prop_oneof![Just(Travel::Joints), Just(Travel::Line), Just(Travel::Jump)];
    prop_oneof![
        4 => (pose(), travel).prop_map(|(to, by)| Action::Move { to, by }),
        1 => any::<bool>().prop_map(Action::Suction),
        1 => (1..u32::MAX / 100).prop_map(Action::Wait),
    ]
}

/// Returns the states of the suction cup and the arm with the time spent in each, however they are
/// divided into rows.
fn suction_timeline(plan: &Plan) -> Vec<(Option<[f32; 4]>, bool, u64)> {
    let (mut at, mut sucks) = (None, false);
    let mut story: Vec<(_, _, u64)> = Vec::new();
    for step in &plan.steps {
        let mut time = 0;
        match &step.action {
            Action::Move { to, .. } => at = Some(*to),
            Action::Suction(on) => sucks = *on,
            Action::Wait(milliseconds) => time = u64::from(*milliseconds),
            other => panic!("{other:?}"),
        }
        match story.last_mut() {
            Some(last) if (last.0, last.1) == (at, sucks) => last.2 += time,
            _ => story.push((at, sucks, time)),
        }
    }
    story
}

proptest! {
    #[test]
    fn plan_reads_back_from_its_file(first in pose(), actions in proptest::collection::vec(action(), 0..20)) {
        let start = [Action::Move { to: first, by: Travel::Joints }, Action::Suction(false)];
        let plan = of(start.into_iter().chain(actions));
        let playback = Playback::from_plan(&plan).unwrap();
        let read = Playback::read(playback.to_xml().as_bytes()).unwrap();
        prop_assert_eq!(&read, &playback);
        prop_assert_eq!(suction_timeline(&read.to_plan().content), suction_timeline(&plan));
    }
}
