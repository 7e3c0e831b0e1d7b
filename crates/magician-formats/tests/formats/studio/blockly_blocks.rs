//! The blocks of the robot and the actions that they become.

use magician::build;
use magician::protocol::{IoFunction, Port, SensorVersion, Stepper};
use magician_formats::{Action, Format, Tool};
use magician_motion::{Geometry, JointAngles, ToolBias};

use super::blockly::{block, chain, field, number, steps, value, wait, workspace};
use super::machine::{plan, plan_text, run};

fn place(kind: &str, [x, y, z]: [f64; 3]) -> String {
    let inputs = [number("xBias", x), number("yBias", y), number("zBias", z)];
    block(kind, &inputs.concat())
}

fn joints([a, b, c]: [f64; 3]) -> String {
    let inputs = [
        number("Joint1", a),
        number("Joint2", b),
        number("Joint3", c),
    ];
    block("dobot_setjointangle", &inputs.concat())
}

/// Returns the actions of a single block, and the notes.
fn one(kind: &str, body: &str) -> (Vec<Action>, Vec<String>) {
    let (plan, notes) = plan(Format::Blockly, &workspace(&block(kind, body)));
    let notes = notes.iter().filter_map(|note| note.split_once("): "));
    (
        plan.steps.into_iter().map(|step| step.action).collect(),
        notes.map(|(_, note)| note.to_owned()).collect(),
    )
}

fn fields(fields: &[(&str, &str)]) -> String {
    fields
        .iter()
        .map(|(name, text)| field(name, text))
        .collect()
}

#[test]
fn r_is_kept_on_lines_and_zero_after_jumps() {
    let blocks = [
        place("dobot_goto", [220.0, 0.0, 50.0]),
        block("dobot_setr", &number("R", 30.0)),
        place("dobot_goto", [200.0, 100.0, 20.0]),
        place("dobot_move", [5.0, 0.0, -5.0]),
        place("dobot_goto", [210.0, 0.0, 20.0]),
        place("dobot_jumpto", [220.0, 10.0, 20.0]),
        place("dobot_goto", [210.0, 0.0, 20.0]),
    ];
    let (said, notes) = steps(&chain(&blocks));
    assert_eq!(
        said,
        "line 220 0 50 0, joints 220 0 50 30, line 200 100 20 30, shift 5 0 -5 0 line, line 210 0 20 30, jump 220 10 20 0, line 210 0 20 0"
    );
    assert_eq!(notes.len(), 1, "{notes:?}");
}

/// The block of the studio turns J4, while r is the sum of J1 and J4.
#[test]
fn setr_turns_joint_4() {
    let blocks = [
        place("dobot_jumpto", [200.0, 200.0, 50.0]),
        block("dobot_setr", &number("R", -20.0)),
    ];
    assert_eq!(
        steps(&chain(&blocks)).0,
        "jump 200 200 50 0, joints 200 200 50 25"
    );
    let blocks = [
        joints([10.0, 20.0, 30.0]),
        block("dobot_setr", &number("R", -20.0)),
    ];
    assert_eq!(
        steps(&chain(&blocks)).0,
        "angles 10 20 30 0 Joints, angles 10 20 30 -20 Joints"
    );
    let blocks = [
        place("dobot_jumpto", [200.0, 200.0, 50.0]),
        joints([10.0, 20.0, 30.0]),
    ];
    assert_eq!(
        steps(&chain(&blocks)).0,
        "jump 200 200 50 0, angles 10 20 30 -45 Joints"
    );
}

#[test]
fn known_arm_position_is_readable() {
    let read = |kind: &str, nth: u8| wait(&block(kind, &field("value", &nth.to_string())));
    let coordinate = |nth| read("dobot_get_current_coordinate", nth);
    let angle = |nth| read("dobot_get_joint_angle", nth);
    let select = block("dobot_selectendtype", &field("type", "59.7"));
    let blocks = [
        select,
        place("dobot_jumpto", [200.0, 200.0, 50.0]),
        place("dobot_move", [0.0, 0.0, 5.0]),
        coordinate(1),
        coordinate(3),
        angle(5),
        angle(6),
        block("dobot_setl", &number("L", 300.0)),
        angle(0),
    ];
    let (plan, notes) = plan(Format::Blockly, &workspace(&chain(&blocks)));
    assert!(notes.is_empty(), "{notes:?}");
    assert_eq!(plan.tool, Some(Tool::Suction));
    let geometry = Geometry::magician(ToolBias::SUCTION);
    let there = geometry.inverse(&[200.0, 200.0, 55.0, 0.0].into()).unwrap();
    let waits: Vec<_> = (plan.steps.iter())
        .filter_map(|step| match step.action {
            Action::Wait(milliseconds) => Some(milliseconds),
            _ => None,
        })
        .collect();
    assert_eq!(
        waits,
        [
            200_000,
            55_000,
            45_000,
            (there.j2 * 1000.0).round() as u32,
            300_000
        ]
    );
    let rail = build::move_with_rail(200.0, 200.0, 55.0, 0.0, 300.0);
    assert!(
        plan.steps
            .iter()
            .any(|step| step.action.command() == Some(rail)),
        "{}",
        plan_text(&plan)
    );
}

/// Joint angles of a program are converted with the tool that the program selected.
#[test]
fn joint_program_ends_at_its_joint_angles() {
    let blocks = [
        block("dobot_selectendtype", &field("type", "61")),
        joints([20.0, 30.0, 20.0]),
        block("dobot_setr", &number("R", 10.0)),
        place("dobot_move", [0.0, -20.0, 10.0]),
    ];
    let (plan, _) = plan(Format::Blockly, &workspace(&chain(&blocks)));
    assert_eq!(plan.tool, Some(Tool::Pen));
    let end = run(&plan, Tool::None);
    let pose =
        Geometry::magician(ToolBias::PEN).forward(&JointAngles::from([20.0, 30.0, 20.0, 10.0]));
    let expected = [pose.x, pose.y - 20.0, pose.z + 10.0, 30.0];
    for (end, expected) in end.into_iter().zip(expected) {
        assert!(
            (f64::from(end) - expected).abs() < 1e-3,
            "{end} for {expected}"
        );
    }
}

#[test]
fn tools_are_selected_by_their_bias() {
    for (out, tool) in [
        ("59.7", Tool::Suction),
        ("59.701", Tool::Gripper),
        ("70", Tool::Laser),
        ("61", Tool::Pen),
    ] {
        let blocks = block("dobot_selectendtype", &field("type", out));
        let (plan, _) = plan(Format::Blockly, &workspace(&blocks));
        assert_eq!(plan.tool, Some(tool));
        assert_eq!(
            plan.steps[0].action.command(),
            Some(build::tool(tool.bias()))
        );
    }
}

#[test]
fn blocks_drive_gripper_suction_and_laser() {
    let is = |kind: &str, body: &[(&str, &str)], word| {
        assert_eq!(
            one(kind, &fields(body)).0,
            [Action::from(word)],
            "{kind} {body:?}"
        );
    };
    is("dobot_pump", &[("io", "1")], build::suction(true));
    is("dobot_pump", &[("io", "0")], build::suction(false));
    is("dobot_gripper", &[("io", "1")], build::grip());
    is("dobot_gripper", &[("io", "2")], build::release());
    is("dobot_gripper", &[("io", "0")], build::pump_off());
    is("dobot_laser", &[("enable", "0")], build::laser(false));
    let (actions, notes) = one(
        "dobot_laser",
        &[field("enable", "1"), number("power", 40.0)].concat(),
    );
    assert_eq!(actions, [Action::Laser(true)]);
    assert_eq!(
        notes,
        ["the laser is only switched on or off: its power is left out"]
    );
}

#[test]
fn speeds_and_heights_are_set() {
    let rates = [number("Velocity", 40.0), number("Acceleration", 60.0)].concat();
    let is = |kind: &str, body: &str, word| {
        let (actions, notes) = one(kind, body);
        assert_eq!(actions, [Action::from(word)], "{kind}");
        assert!(notes.is_empty(), "{notes:?}");
    };
    is("dobot_setlinearspeed", &rates, build::speed(40.0, 60.0));
    is(
        "dobot_setptpjointparams",
        &rates,
        build::joint_speed([40.0; 4], [60.0; 4]),
    );
    is("dobot_setptplparams", &rates, build::rail_speed(40.0, 60.0));
    let rail = [number("lVelocity", 40.0), number("lAcceleration", 60.0)].concat();
    is("dobot_setptplparams", &rail, build::rail_speed(40.0, 60.0));
    is(
        "dobot_setjumpheight",
        &number("height", 30.0),
        build::jump_height(30.0, 100.0),
    );
    let (actions, _) = one("dobot_setptpoordinateparams", &rates);
    let magician::Set::PtpCoordinateParams(params) = actions[0].command().expect("it has one")
    else {
        panic!("{actions:?}");
    };
    assert_eq!([params.xyz_velocity, params.r_velocity], [40.0; 2]);
    assert_eq!([params.xyz_acceleration, params.r_acceleration], [60.0; 2]);
    let bias = [
        number("xBias", 10.0),
        number("yBias", -5.0),
        number("zBias", 2.5),
    ]
    .concat();
    is(
        "dobot_SetEndEffectorParams",
        &bias,
        build::tool(ToolBias::new(10.0, -5.0, 2.5)),
    );
}

#[test]
fn pins_motors_and_sensors_are_driven() {
    let is = |kind: &str, body: &str, word| {
        assert_eq!(one(kind, body).0, [Action::from(word)], "{kind} {body}");
    };
    for (code, function) in [
        ("1", IoFunction::DigitalInput),
        ("3", IoFunction::AnalogInput),
        ("4", IoFunction::DigitalOutput),
        ("5", IoFunction::DigitalOutput),
        ("6", IoFunction::DigitalOutput),
        ("7", IoFunction::Pwm),
    ] {
        let body = fields(&[("value", code), ("io", "14")]);
        is(
            "dobot_setiomultiplexing",
            &body,
            build::multiplex(14, function),
        );
    }
    is(
        "dobot_set_output",
        &fields(&[("io", "18"), ("value", "1")]),
        build::output(18, true),
    );
    is(
        "dobot_set_output5V",
        &fields(&[("io", "10"), ("enable", "1")]),
        build::output(10, true),
    );
    is(
        "dobot_set_output12V",
        &fields(&[("io", "17"), ("enable", "0")]),
        build::output(17, false),
    );
    let pwm = [
        field("io", "4"),
        number("frequency", 50.0),
        number("dutyCycle", 7.5),
    ]
    .concat();
    is("dobot_setiopwm", &pwm, build::pwm(4, 50.0, 7.5));
    let motor = [field("io", "1"), number("speed", -500.0)].concat();
    is(
        "dobot_setemotor",
        &motor,
        build::motor(Stepper::Stepper2, -500),
    );
    let far = [
        field("io", "0"),
        number("speed", 500.0),
        number("distance", 2000.0),
    ]
    .concat();
    is(
        "dobot_setemotors",
        &far,
        build::motor_by(Stepper::Stepper1, 500, 2000),
    );
    let belt = [field("io", "0"), number("speed", 50.0)].concat();
    is(
        "dobot_conveyor",
        &belt,
        build::motor(Stepper::Stepper1, 14_147),
    );
    let sensor = fields(&[("io", "1"), ("version", "1"), ("port", "2")]);
    is(
        "dobot_set_colorseneor",
        &sensor,
        build::color_sensor(Port::Gp4, true, SensorVersion::V2),
    );
    is(
        "dobot_SetInfraredSensor",
        &sensor,
        build::infrared(Port::Gp4, true, SensorVersion::V2),
    );
    is("dobot_SetLostStepCmd", "", build::check_lost_steps());
    let (actions, notes) = one("dobot_SetLostStepParams", &number("threshold", 3.0));
    assert!(actions.is_empty());
    assert_eq!(
        notes,
        [
            "SetLostStepParams cannot be queued: it is left out; set it separately before the \
                run, with the value 3"
        ]
    );
    let (actions, _) = one(
        "dobot_linearRail",
        &fields(&[("enable", "1"), ("version", "1")]),
    );
    assert_eq!(
        actions[0].command().expect("it has one").row().set_name,
        "SetDeviceWithL"
    );
}

#[test]
fn printed_text_is_noted_once() {
    let print = block(
        "text_print",
        &value("TEXT", &block("text", &field("TEXT", "round we go"))),
    );
    let twice = [
        number("TIMES", 2.0),
        format!("<statement name=\"DO\">{print}</statement>"),
    ]
    .concat();
    let (_, notes) = steps(&block("controls_repeat_ext", &twice));
    assert_eq!(notes.len(), 1);
    assert!(
        notes[0].ends_with("(text_print): it prints: round we go"),
        "{notes:?}"
    );
}

/// Every block of the studio is converted or refused by its name; no block is skipped.
#[test]
fn every_known_block_is_executed_or_refused_by_name() {
    let followed = [
        "dobot_home",
        "dobot_goto",
        "dobot_jumpto",
        "dobot_move",
        "dobot_setjointangle",
        "dobot_setjumpheight",
        "dobot_setptpjointparams",
        "dobot_setptpoordinateparams",
        "dobot_setptplparams",
        "dobot_setlinearspeed",
        "dobot_selectendtype",
        "dobot_SetEndEffectorParams",
        "dobot_pump",
        "dobot_gripper",
        "dobot_laser",
        "dobot_delaytime",
        "dobot_setiomultiplexing",
        "dobot_set_output",
        "dobot_set_output5V",
        "dobot_set_output12V",
        "dobot_setiopwm",
        "dobot_conveyor",
        "dobot_setemotor",
        "dobot_setemotors",
        "dobot_set_colorseneor",
        "dobot_SetInfraredSensor",
        "dobot_linearRail",
        "dobot_SetLostStepCmd",
    ];
    for kind in followed {
        let (actions, _) = one(kind, "");
        assert_eq!(actions.len(), 1, "{kind}");
    }
    let at = place("dobot_jumpto", [220.0, 0.0, 20.0]);
    for kind in ["dobot_setr", "dobot_setl"] {
        let (plan, _) = plan(
            Format::Blockly,
            &workspace(&chain(&[at.clone(), block(kind, "")])),
        );
        assert_eq!(plan.steps.len(), 2, "{kind}");
    }
    let refused = [
        ("dobot_time", "gives another value each time"),
        ("dobot_get_input", "asks the arm while it runs"),
        ("dobot_get_adc", "asks the arm while it runs"),
        ("dobot_getiopwm", "asks the arm while it runs"),
        ("dobot_get_colorseneor", "asks the arm while it runs"),
        ("dobot_GetInfraredSensor", "asks the arm while it runs"),
        ("dobot_SetArmSpeedRatio", "is for a MagicBox"),
        ("dobot_GetArmSpeedRatio", "is for a MagicBox"),
        ("dobot_SetLSpeedRatio", "is for a MagicBox"),
        ("dobot_GetLSpeedRatio", "is for a MagicBox"),
        ("dobot_SetServoAngle", "is for a MagicBox"),
        ("dobot_SetSeeedColorSensor", "is for a MagicBox"),
        ("dobot_set_armori", "is for the M1"),
        ("dobot_nonlinear_movement", "is for the M1"),
        ("dobot_nonlinear_movement_joint", "is for the M1"),
        ("dobot_nonlinear_movement_movj", "is for the M1"),
        ("dobot_nonlinear_movement_descartes_movj", "is for the M1"),
        ("dobot_linear_movement_movl", "is for the M1"),
        ("procedures_callnoreturn", "is an unknown block"),
    ];
    for (kind, why) in refused {
        for blocks in [block(kind, ""), wait(&block(kind, ""))] {
            let diagnostic =
                magician_formats::read(Format::Blockly, &workspace(&blocks), &Default::default());
            let diagnostic = diagnostic.unwrap_err();
            assert!(
                diagnostic.message.starts_with(&format!("'{kind}' {why}")),
                "{diagnostic}"
            );
            assert_eq!(diagnostic.name.as_deref(), Some(kind));
            assert!(diagnostic.origin.column > 40, "{diagnostic:?}");
        }
    }
}
