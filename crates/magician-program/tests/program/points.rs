//! Lists of points: CSV, JSON, text.

use magician_program::rehearse::{RehearseOptions, rehearse, stage, start_of};
use magician_program::{
    Action, Content, Diagnostic, Format, Grip, Plan, ReadOptions, Tool, Travel, check, read,
};

fn points(text: &str) -> Result<(Plan, Vec<String>), Diagnostic> {
    resampled(text, None)
}

fn resampled(text: &str, resample: Option<f64>) -> Result<(Plan, Vec<String>), Diagnostic> {
    let mut options = ReadOptions::default();
    options.resample = resample;
    let reading = read(Format::Points, text.as_bytes(), &options)?;
    let Content::Plan(plan) = reading.content else {
        panic!("points are a plan");
    };
    Ok((
        plan,
        reading.notes.iter().map(ToString::to_string).collect(),
    ))
}

fn actions(text: &str) -> Vec<Action> {
    let (plan, _) = points(text).unwrap();
    plan.steps.into_iter().map(|step| step.action).collect()
}

fn go(to: [f32; 4], by: Travel) -> Action {
    Action::Move { to, by }
}

fn refused(text: &str) -> String {
    points(text).unwrap_err().to_string()
}

#[test]
fn csv_made_of_a_playback_file() {
    let text = "X,Y,Z,R,Velocity,Acceleration,Suction\n\
                200.5,0,20,0,0.0,0.0,0\n\
                200.5,0,-10,0,2.0,2.0,1\n\
                \n\
                210,50,20,15,0.0,0.0,1\n";
    let (plan, notes) = points(text).unwrap();
    assert_eq!(plan.tool, Some(Tool::Suction));
    let joints = Travel::Joints;
    assert_eq!(
        actions(text),
        [
            go([200.5, 0.0, 20.0, 0.0], joints),
            Action::Suction(false),
            go([200.5, 0.0, -10.0, 0.0], joints),
            Action::Suction(true),
            go([210.0, 50.0, 20.0, 15.0], joints),
        ]
    );
    assert_eq!(plan.steps[2].origin.line, 3);
    assert_eq!(notes.len(), 1);
    assert!(notes[0].contains("pauses of a playback"), "{notes:?}");
    assert!(
        check(
            &plan,
            &start_of(&stage(&plan, &RehearseOptions::default()).unwrap())
        )
        .is_good()
    );
    assert!(
        rehearse(&plan, &RehearseOptions::default())
            .unwrap()
            .is_good()
    );
}

#[test]
fn csv_with_pauses_names_styles_and_other_signs() {
    let text = "Name; MotionStyle; X (mm); Y; Z; Gripper; Pause\r\n\
                \"first; place\"; MOVL; 200,5; 0; 20; 1; 0,5\r\n\
                ; JUMP; 210; 0; 20; closed;\r\n";
    let (plan, notes) = points(text).unwrap();
    assert_eq!(notes, [""; 0]);
    assert_eq!(plan.tool, Some(Tool::Gripper));
    assert_eq!(plan.name_of(&plan.steps[0].origin), Some("first; place"));
    assert_eq!(
        actions(text),
        [
            go([200.5, 0.0, 20.0, 0.0], Travel::Line),
            Action::Gripper(Grip::Open),
            Action::Wait(500),
            go([210.0, 0.0, 20.0, 0.0], Travel::Jump),
            Action::Gripper(Grip::Close),
        ]
    );
}

#[test]
fn converted_file_reads_back() {
    let text = "step,action,x,y,z,r,line,name\n\
                1,movj,200,0,0,0,4,\n\
                2,path,220,0,0,,5,\"a \"\"b\"\"\"\n\
                3,wait,,,,,6,\n";
    let (plan, notes) = points(text).unwrap();
    assert_eq!(plan.steps.len(), 2);
    assert_eq!(
        plan.steps[1].action,
        Action::Path {
            to: [220.0, 0.0, 0.0]
        }
    );
    assert_eq!(plan.name_of(&plan.steps[1].origin), Some("a \"b\""));
    assert!(
        notes[0].contains("line 4") && notes[0].contains("without a position"),
        "{notes:?}"
    );
}

#[test]
fn json_rows_in_the_order_of_their_numbers() {
    let rows = "\"row10\": {\"MotionStyle\": \"MOVJ\", \"X\": 210, \"Y\": 1, \"Z\": 2, \"R\": 3, \"PauseTime\": 0},\n\
                \"row2\": {\"MotionStyle\": \"ARC\", \"X\": \"220\", \"Y\": \"10\", \"Z\": \"0\", \"R\": \"0\", \"_X\": \"230\", \
                \"_Y\": \"0\", \"_Z\": \"0\", \"_R\": \"0\", \"PauseTime\": \"1.5\"},\n\
                \"row1\": {\"MotionStyle\": \"MOVL\", \"X\": 200.25, \"Y\": 0, \"Z\": 0, \"R\": null, \"Colour\": 1}";
    for text in [format!("{{\"rows\": {{{rows}}}}}"), format!("{{{rows}}}")] {
        assert_eq!(Format::of("a.json", text.as_bytes()), Some(Format::Points));
        let (_, notes) = points(&text).unwrap();
        assert_eq!(notes.len(), 1);
        assert!(notes[0].contains("Colour"), "{notes:?}");
        assert_eq!(
            actions(&text),
            [
                go([200.25, 0.0, 0.0, 0.0], Travel::Line),
                Action::Arc {
                    via: [220.0, 10.0, 0.0, 0.0],
                    to: [230.0, 0.0, 0.0, 0.0]
                },
                Action::Wait(1500),
                go([210.0, 1.0, 2.0, 3.0], Travel::Joints),
            ]
        );
    }
}

#[test]
fn strokes_of_a_text() {
    let text = "200, 0, -60\n210, 0, -60\n210, 10, -60\n\n220 20 -60\n230\t20\t-60\n";
    assert_eq!(Format::of("a.txt", text.as_bytes()), Some(Format::Points));
    let path = |to| Action::Path { to };
    assert_eq!(
        actions(text),
        [
            go([200.0, 0.0, -50.0, 0.0], Travel::Joints),
            go([200.0, 0.0, -60.0, 0.0], Travel::Line),
            path([210.0, 0.0, -60.0]),
            path([210.0, 10.0, -60.0]),
            go([210.0, 10.0, -50.0, 0.0], Travel::Line),
            go([220.0, 20.0, -50.0, 0.0], Travel::Joints),
            go([220.0, 20.0, -60.0, 0.0], Travel::Line),
            path([230.0, 20.0, -60.0]),
            go([230.0, 20.0, -50.0, 0.0], Travel::Line),
        ]
    );
    let (plan, _) = points(text).unwrap();
    let done = rehearse(&plan, &RehearseOptions::default()).unwrap();
    assert!(done.is_good(), "{:?}", done.log);
    assert_eq!(done.drawing.strokes().len(), 2);
}

#[test]
fn refusal_has_origin_and_reason() {
    for (text, hints) in [
        ("X,Y,Z\n200,0,x\n", ["line 2, column 7", "'x'"]),
        ("X,Y,Z\n200,0,nan\n", ["line 2, column 7", "number"]),
        ("X,Y,Z\n200,0,1e39\n", ["line 2, column 7", "number"]),
        ("X,Y,Z\n200,0\n", ["line 2", "has no z"]),
        ("X,Y,Z\n1,2,3,4\n", ["line 2, column 7", "more than the 3"]),
        ("X,Y,R\n200,0,0\n", ["line 1", "there is no column Z"]),
        ("X,Y,Z,X\n", ["line 1, column 7", "another column"]),
        (
            "X,Y,Z,Pause\n1,2,3,-1\n",
            ["line 2, column 7", "must be 0 to"],
        ),
        ("X,Y,Z,Mode\n1,2,3,FLY\n", ["line 2, column 7", "'FLY'"]),
        ("X,Y,Z,Gripper\n1,2,3,9\n", ["line 2, column 7", "'9'"]),
        ("X,Y,Z,Gripper,Suction\n1,2,3,1,1\n", ["line 2", "one tool"]),
        ("X,Y,Z\n", ["no points", ""]),
        ("", ["empty", ""]),
        ("1 2 3\n4 5 6\n4 5\n", ["line 3, column 1", "x,y,z"]),
        ("{\"row0\": {\"X\": 1, \"Y\": 2}}", ["line 1", "has no z"]),
        (
            "{\"row0\": {\"X\": [1]}}",
            ["line 1, column 16", "number or a string"],
        ),
        ("{\"row0\": 5}", ["line 1, column 10", "object"]),
        ("{\"row1\": {}, \"row01\": {}}", ["line 1", "twice"]),
        (
            "{\"row0\": {\"MotionStyle\": \"ARC\", \"X\": 1, \"Y\": 2, \"Z\": 3}}",
            ["line 1", "no end"],
        ),
        ("{\"rows\": {\"point\": {}}}", ["line 1", "'point'"]),
        ("{\"row0\": ", ["line 1", "JSON"]),
    ] {
        let said = refused(text);
        for hint in hints {
            assert!(said.contains(hint), "{text:?}: {said}");
        }
    }
}

#[test]
fn other_texts_are_not_detected_as_points() {
    for text in [
        "1 2 3",
        "x marks the spot",
        "{}",
        "{\"rows\": 3}",
        "1,2\n3,4\n",
        "a,b,c\n1,2,3\n",
    ] {
        assert_eq!(Format::of("a.txt", text.as_bytes()), None, "{text}");
    }
}

#[test]
fn many_rows_in_one_line_take_linear_time() {
    let rows = (0..20_000).map(|nth| {
        format!(
            "\"row{nth}\":{{\"X\":200,\"Y\":{},\"Z\":0,\"名\":\"é\"}}",
            nth % 90
        )
    });
    let text = format!("{{{}}}", rows.collect::<Vec<_>>().join(","));
    assert_eq!(actions(&text).len(), 20_000);
}

/// Motion of some seconds with a pause, sampled at `rate` Hz: a figure of eight at varying speed.
fn recording(seconds: f64, rate: f64) -> String {
    let rows = (0..=(seconds * rate) as u32).map(|nth| {
        let t = f64::from(nth) / rate;
        // From rest to rest, with a pause in the middle.
        let share = match t / seconds {
            share if share < 0.4 => share / 0.8,
            share if share < 0.6 => 0.5,
            share => (share - 0.2) / 0.8,
        };
        let part = (share * 2.0).fract();
        let eased = (share * 2.0).floor() + part * part * (3.0 - 2.0 * part);
        let turn = eased / 2.0 * std::f64::consts::TAU;
        let (x, y) = (220.0 + 30.0 * turn.cos(), 40.0 * (2.0 * turn).sin());
        format!("{t:.3},{x:.4},{y:.4},10,0,0,0,45,0,7,30,,\n")
    });
    let header = "t,x,y,z,r,j1,j2,j3,j4,index,left_space,alarms,step\n";
    header.to_owned() + &rows.collect::<String>()
}

#[test]
fn recording_keeps_its_duration() {
    for (seconds, rate, resample) in [
        (7.7, 20.0, None),
        (7.7, 10.0, None),
        (7.7, 50.0, None),
        (7.7, 240.0, None),
        (12.0, 20.0, None),
        (7.7, 50.0, Some(0.5)),
        (7.7, 20.0, Some(0.1)),
    ] {
        let (plan, notes) = resampled(&recording(seconds, rate), resample).unwrap();
        let told = 1 + usize::from(resample.is_some());
        assert_eq!(notes.len(), told, "its own columns are known: {notes:?}");
        // From its start.
        let mut there = Plan::new("there");
        there.push(plan.steps[0].action.clone(), magician_program::Origin::NONE);
        let begun = start_of(&stage(&there, &RehearseOptions::default()).unwrap());
        let way = check(&there, &begun).time.unwrap();
        let report = check(&plan, &begun);
        assert!(report.is_good(), "{:?}", report.refused_steps.first());
        let taken = (report.time.unwrap() - way).as_secs_f64();
        assert!(
            (taken - seconds).abs() < 0.02 * seconds,
            "{taken} s for {seconds} s at {rate} Hz"
        );
        let done = rehearse(&plan, &RehearseOptions::default()).unwrap();
        assert!(done.is_good(), "{:?}", done.alarms);
        let waits = (plan.steps.iter()).filter(|step| matches!(step.action, Action::Wait(_)));
        assert!(waits.count() >= 1, "it rests in its middle");
    }
}

/// Arm whose motion ends at the end of a period of 20 ms. Periods start 7 ms after the recording,
/// and readings are at other times.
#[test]
fn recording_of_an_arm_with_periods_keeps_its_duration() {
    let seconds = 7.7;
    let even = recording(seconds, 1000.0);
    let mut rows = even.lines();
    let header = rows.next().unwrap();
    let rows: Vec<&str> = rows.collect();
    for rate in [20.0, 33.0, 40.0, 50.0, 120.0] {
        let readings = (0..=(seconds * rate) as u32).map(|nth| {
            let read = (f64::from(nth) * 1000.0 / rate).round() as usize;
            let came = if read < 7 { 0 } else { read - (read - 7) % 20 };
            let (_, place) = rows[came].split_once(',').unwrap();
            format!("{:.3},{place}\n", read as f64 / 1000.0)
        });
        let text = format!("{header}\n{}", readings.collect::<String>());
        let (plan, _) = points(&text).unwrap();
        let begun = start_of(&stage(&plan, &RehearseOptions::default()).unwrap());
        let mut there = Plan::new("there");
        there.push(plan.steps[0].action.clone(), magician_program::Origin::NONE);
        let way = check(&there, &begun).time.unwrap();
        let taken = (check(&plan, &begun).time.unwrap() - way).as_secs_f64();
        assert!(
            (taken - seconds).abs() < 0.02 * seconds,
            "{taken} s for {seconds} s at {rate} Hz"
        );
    }
}

/// Sides of a square of 30 mm, each from rest to rest at up to 50 mm/s, sampled every 50 ms. The
/// time of each row is late by up to `late`, s. The tool does not turn, so J4 does.
fn square(sides: u8, late: f64) -> (String, f64) {
    const SIDE: f64 = 30.0;
    const SPEED: f64 = 50.0;
    const ACCELERATION: f64 = 100.0;
    let ramp = SPEED / ACCELERATION;
    let side = SIDE / SPEED + ramp;
    let along = |t: f64| match t {
        t if t < ramp => 0.5 * ACCELERATION * t * t,
        t if t < side - ramp => SPEED * (t - 0.5 * ramp),
        t => SIDE - 0.5 * ACCELERATION * (side - t).powi(2),
    };
    let corners = [[200.0, -15.0], [230.0, -15.0], [230.0, 15.0], [200.0, 15.0]];
    let mut rows = String::from("t,x,y,z,r,j4\n");
    let seconds = f64::from(sides) * side;
    let count = (seconds / 0.05).round() as u32;
    let mut random: u32 = 1;
    for nth in 0..=count {
        let t = f64::from(nth) * 0.05;
        let nth_side = ((t / side) as usize).min(usize::from(sides) - 1);
        let share = along(t - nth_side as f64 * side) / SIDE;
        let [from, to] = [nth_side, nth_side + 1].map(|at| corners[at % 4]);
        let [x, y] = [0, 1].map(|axis| from[axis] + share * (to[axis] - from[axis]));
        random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let late = match nth {
            0 => 0.0,
            nth if nth == count => 0.0,
            _ => late * f64::from(random >> 16) / 65536.0,
        };
        let j4 = -y.atan2(x).to_degrees();
        rows += &format!("{:.4},{x:.4},{y:.4},10,0,{j4:.4}\n", t + late);
    }
    (rows, seconds)
}

#[test]
fn recording_with_sharp_corners_or_jitter_keeps_its_duration() {
    for (sides, late) in [(4, 0.0), (4, 0.01), (4, 0.04), (3, 0.0)] {
        let (rows, seconds) = square(sides, late);
        let (plan, _) = points(&rows).unwrap();
        let mut there = Plan::new("there");
        there.push(plan.steps[0].action.clone(), magician_program::Origin::NONE);
        let begun = start_of(&stage(&there, &RehearseOptions::default()).unwrap());
        let way = check(&there, &begun).time.unwrap();
        let report = check(&plan, &begun);
        assert!(report.is_good(), "{:?}", report.refused_steps.first());
        let taken = (report.time.unwrap() - way).as_secs_f64();
        // Rows that are late by nearly the sampling interval make the speed jump. If a jump costs
        // the arm half a period, it loses a whole one, and cannot catch up before the turn of J4.
        let jumps = if sides == 3 && late > 0.02 {
            10.0 * 0.02
        } else {
            0.0
        };
        assert!(
            (taken - seconds).abs() < 0.02 * seconds + jumps,
            "{taken} s for {seconds} s, {sides} sides, rows late by up to {late} s"
        );
    }
}

#[test]
fn resampling_drops_near_points_and_keeps_the_times() {
    // Along a line with a trembling hand, and a pause on it.
    let mut rows = String::from("t,x,y,z\n");
    for nth in 0..=200 {
        let t = f64::from(nth) * 0.05;
        let way = 10.0 * (t.min(4.0) + (t - 6.0).max(0.0));
        let trembles = if nth % 2 == 0 { 0.1 } else { -0.1 };
        rows += &format!("{t:.2},{:.4},{trembles},10\n", 180.0 + way);
    }
    let (plan, notes) = resampled(&rows, Some(0.3)).unwrap();
    assert!(
        notes[1].ends_with(
            "of 201 points are left out: they are closer than 0.3 mm to the line; a step between \
             the others still takes a period, so that the number of steps stays"
        ),
        "{notes:?}"
    );
    let waits = plan.steps.iter().filter_map(|step| match step.action {
        Action::Wait(milliseconds) => Some(milliseconds),
        _ => None,
    });
    let waits: Vec<u32> = waits.collect();
    assert!(
        matches!(waits[..], [rest] if rest.abs_diff(2000) <= 60),
        "{waits:?}"
    );
    let across = plan.steps.iter().filter_map(|step| match step.action {
        Action::Path { to: [_, y, _] } => Some(y),
        _ => None,
    });
    let across: Vec<f32> = across.collect();
    let turns = across.windows(3);
    let turns = turns.filter(|three| (three[1] - three[0]) * (three[2] - three[1]) < 0.0);
    assert!(
        across.len() > 200 && turns.count() < 5,
        "it trembles no more"
    );
    // Without times, thinning cannot preserve them.
    for other in ["x,y,z\n200,0,0\n", "{}"] {
        let diagnostic = resampled(other, Some(0.5)).unwrap_err();
        assert!(
            diagnostic.to_string().contains("recording"),
            "{other}: {diagnostic}"
        );
    }
}

#[test]
fn truncated_or_backward_recording_is_reported() {
    let whole = recording(2.0, 20.0);
    let cut = &whole[..whole.len() - 30];
    let (plan, notes) = points(cut).unwrap();
    assert!(plan.steps.len() > 10);
    assert!(
        notes[0].contains("without a time or a position are left out: 1"),
        "{notes:?}"
    );
    let back = "t,x,y,z\n0,200,0,0\n1,210,0,0\n0.5,220,0,0\n";
    assert_eq!(
        refused(back),
        "line 4, column 1: the time goes back from 1 to 0.5 s"
    );
    assert!(refused("t,x,y,z\n").contains("no rows"));
    assert!(refused("t,x,y,z\n0,200,0,0\n1e9,210,0,0\n").contains("too long"));
    // Two rows a fortnight apart take no memory for the time between.
    assert!(refused("t,x,y,z\n0,200,0,0\n1e6,210,0,0\n").contains("too long"));
    assert!(refused("t,x,y,z\nnan,200,0,0\n").contains("a time must be a number"));
}
