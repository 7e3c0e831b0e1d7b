//! Meaning of the words, one by one.

use magician::build;
use magician_formats::{Action, Surface, Travel};

use super::{actions, actions_with, motions, notes, path, travel, try_read, try_with};

#[test]
fn equivalent_spellings_give_the_same_program() {
    let expected = [
        travel(220.0, 0.0, 10.0),
        path(220.0, 0.0, 0.0),
        path(240.0, -20.5, 0.0),
    ];
    for text in [
        "G0 X220 Y0 Z10\nG1 Z0\nG1 X240 Y-20.5\n",
        "%\nO0001\nN10G00X220.Y0.Z10.\r\nN20 G1Z0\r\nN30X240Y-20.5\r\nM30\r\n%\nG1 X0\n",
        "g0x220y0z10 ; there\ng1z0(down)\n x 240 (across) y -20.50\nm2\n",
        "N1 G0 X220 Y0 Z10*105\nN2 G1 Z0*77\nN3 G1 X240 Y-20.5*12\n",
        "G17 G21 G40 G49 G54 G80 G90 G94\nG0 X220 Y0 Z10\nG91 G1 Z-10\nX20 Y-20.5\n",
        "G20\nG0 X8.66141732283465 Y0 Z0.393700787401575\nG1 Z0\nG21\nX240 Y-20.5\n",
        "G0 X220 Y0 Z10\nG92 X0 Y0 Z0\nG1 Z-10\nX20 Y-20.5\n",
        "G0 X220 Y0 Z10\nG92\nG1 Z-10\nG53 X240 Y-20.5 Z0\n",
        "G0 X220 Y0 Z10\nG92 X5\nG92.1\nG1 Z0\nX240 Y-20.5\n",
        "G0 X220 Y0 Y0 Z10\nG1 Z0 Z0\nG96 S10 D20\nX240 Y-20.5\n",
        "G55\nG0 X220 Y0 Z10\nG1 Z0\nX240 Y-20.5\n",
        "G10 L2 P1 X200 Z-1\nG0 X20 Y0 Z11\nG1 Z1\nX40 Y-20.5\n",
        "G10 L2 P2 X200\nG55 G0 X20 Y0 Z10\nG1 Z0\nG54 X240 Y-20.5\n",
        "G10 L2 P9 X200\nG59.3 G0 X20 Y0 Z10\nG1 Z0\nG53 X240 Y-20.5\n",
        "G59\nG20 G10 L2 Y1\nG21 G0 X220 Y-25.4 Z10\nG1 Z0\nG10 L2 P0 Y0\nX240 Y-20.5\n",
        "G0 X220 Y0 Z10\nG10 L20 P1 X0 Y0 Z0\nG1 Z-10\nX20 Y-20.5\n",
        "G0 X220 Y0 Z10\nG92 X7\nG10 L20 X1 Y0 Z0\nG1 Z-10\nX21 Y-20.5\n",
        "G0 X220 Y0 Z10\nG52 X220 Y1\nG1 Z0\nX20 Y-21.5\n",
        "G0 X220 Y0 Z10\nG52 X220 Y1\nG52 X0 Y0\nG1 Z0\nX240 Y-20.5\n",
        "G10 L2 X200\nG0 X20 Y0 Z10\nG92 X5\nG1 Z0\nX25 Y-20.5\n",
        "G0 X220 Y0 Z10\nG92 X0 Y0\nG92.2\nG1 X220 Y0 Z0\nG92.3\nX20 Y-20.5\n",
        "G10 L1 P1 Z30\nG0 G80 X220 Y0 Z10 G40\nG1 G80 Z0\nX240 Y-20.5\nG28.1 X1\nG30\n",
        "/G0 X1\n$X\nG0 X220 Y0 Z10 F3000 T1\nM6 T2\nM8\nG1 Z0 E5\nM84 X Y E\nG1 X240 Y-20.5 A90\nM117 Hello (X1) World\n",
    ] {
        assert_eq!(motions(text), expected, "{text}");
    }
    // Moves along single axes give the same once the arm's position is known.
    let by_axis = actions_with("G0 Z10\nX220\nY0\nG1 Z0\nX240 Y-20.5\n", |options| {
        options.start = Some([200.0, 10.0, 5.0]);
    });
    let moves = by_axis
        .into_iter()
        .filter(|action| action.target().is_some());
    assert_eq!(moves.skip(2).collect::<Vec<_>>(), expected);
    // Invalid UTF-8 is allowed in comments.
    let latin = b"; gr\xf6\xdfer\nG0 X220 Y0 Z10\n(\xe4) G1 Z0\nX240 Y-20.5\n";
    let options = magician_formats::ReadOptions::default();
    let read = magician_formats::read(magician_formats::Format::Gcode, latin, &options);
    let magician_formats::Content::Plan(plan) = read.expect("it is all right").content else {
        panic!("a plan")
    };
    assert_eq!(plan.steps.len(), 4);
    assert_eq!(
        (plan.steps[2].origin.line, plan.steps[2].origin.column),
        (3, 5)
    );
}

#[test]
fn speed_is_set_when_it_changes() {
    let program = "G0 X220 Y0 Z0\nG1 X221 F600\nX222 F600\nX223\nX224 F1200\nG20 G91\nX0.1 F60\nG1 F120\nG0 Y0.1\n";
    let speeds: Vec<_> = actions(program)
        .into_iter()
        .filter(|action| matches!(action, Action::Command(_)))
        .collect();
    let expected = [
        build::line_speed(200.0, 200.0),
        build::path_speed(10.0, 100.0),
        build::path_speed(20.0, 100.0),
        build::path_speed(25.4, 100.0),
    ];
    assert_eq!(speeds, expected.map(Action::from));

    let fast = "G0 X220 Y0 Z0\nG1 X221 F30000\nG1 X222 F60000\n";
    assert!(actions(fast).contains(&build::path_speed(300.0, 100.0).into()));
    assert_eq!(
        notes(fast),
        [
            "line 2, column 1: speeds above 300 mm/s (F18000) are reduced to 300 mm/s: the arm is \
                not faster (2 times)"
        ]
    );
    let set = actions_with("G0 X220 Y0 Z0\nG1 X221 F600", |options| {
        (options.travel_speed, options.travel_acceleration) = (150.0, 120.0);
        options.acceleration = 80.0;
    });
    assert_eq!(set[0], build::line_speed(150.0, 120.0).into());
    assert_eq!(set[2], build::path_speed(10.0, 80.0).into());
}

#[test]
fn pauses_are_waits() {
    assert_eq!(
        actions("G4 P150\nG4 S2\nG4 S0.25\nG4 P0\n"),
        [
            Action::Wait(150),
            Action::Wait(2000),
            Action::Wait(250),
            Action::Wait(0)
        ]
    );
}

#[test]
fn undefined_second_coordinate_system_is_noted() {
    assert_eq!(
        notes("G54\nG0 X220 Y0 Z0\nG55\nG0 X230\nG10 L2 P3 X1\nG56\nG0 X231\n"),
        [
            "line 3, column 1: the zero of G55 is stored in a controller and unknown here: the machine's zero is used"
        ]
    );
    assert_eq!(notes("G58\nG0 X220 Y0 Z0\nG58\nG0 X230\n"), [""; 0]);
}

#[test]
fn machine_coordinates_of_a_placed_program_lift_the_pen_and_draw_nothing() {
    let placed = |text: &str| {
        let all = actions_with(text, |options| options.placed = true);
        let all = all.into_iter().filter(|action| action.target().is_some());
        all.collect::<Vec<_>>()
    };
    for away in [
        "G53 G0 Z0",
        "G28",
        "G91 G28 Z0\nG90",
        "G30 Z0",
        "G53 G0 X-300 Y-200 Z-1",
    ] {
        let text = format!("G0 X10 Y10 Z5\nG1 Z-1 F600\nX20\n{away}\nG0 X5 Y5\nG1 Z-1\nX6\n");
        assert_eq!(
            placed(&text),
            [
                travel(10.0, 10.0, 5.0),
                path(10.0, 10.0, -1.0),
                path(20.0, 10.0, -1.0),
                travel(20.0, 10.0, 5.0),
                travel(5.0, 5.0, 5.0),
                path(5.0, 5.0, -1.0),
                path(6.0, 5.0, -1.0),
            ],
            "{away}"
        );
    }
    let fed = try_with("G0 X1 Y1 Z1\nG53 G1 X5\n", |options| options.placed = true);
    let fed = fed.expect_err("it is not known where that is").to_string();
    assert!(
        fed.starts_with("line 2, column 1: G53 uses machine coordinates"),
        "{fed}"
    );
}

#[test]
fn known_arm_position_is_used() {
    let from = |text: &str| {
        let all = actions_with(text, |options| options.start = Some([200.0, 10.0, 30.0]));
        let all = all.into_iter().filter(|action| action.target().is_some());
        all.collect::<Vec<_>>()
    };
    assert_eq!(
        from("G0 Z40\nX220\n"),
        [travel(200.0, 10.0, 40.0), travel(220.0, 10.0, 40.0)]
    );
    // The tool may be elsewhere when the program starts, so it returns to this position before it
    // draws.
    let there = travel(200.0, 10.0, 30.0);
    let drawn = [there.clone(), path(205.0, 10.0, 0.0)];
    assert_eq!(from("G91\nG1 X5 Z-30\n"), drawn);
    assert_eq!(from("G92 X0 Y0 Z0\nG1 X5 Z-30\n"), drawn);
    assert_eq!(
        from("G92\nG90\nG1Z0\nG0 Y1\n"),
        [there, path(200.0, 10.0, 30.0), travel(200.0, 11.0, 30.0)]
    );
    // Without a known position G92 cannot be applied.
    assert_eq!(
        notes("G92\nG90\nG1 Z0\nG0 X220 Y0\n")[..1],
        [
            "line 1, column 1: G92 is left out where the arm's position is unknown: coordinates \
                stay the arm's (3 times)"
        ]
    );
    // Before the first Z word, the highest Z of the program is assumed.
    let to = [220.0, 0.0, 15.0, 0.0];
    let by = Travel::Joints;
    assert_eq!(
        motions("G0 X220 Y0\nG0 Z5\nG0 Z15\n"),
        [
            Action::Move { to, by },
            travel(220.0, 0.0, 5.0),
            travel(220.0, 0.0, 15.0)
        ]
    );
}

#[test]
fn homing_is_done_only_on_request() {
    let program = "G28\nG28 X Y\nG28 X0 Y0\nG0 X220 Y0 Z10\n";
    assert_eq!(motions(program), [travel(220.0, 0.0, 10.0)]);
    assert_eq!(
        notes(program),
        ["line 1, column 1: homing (G28) is left out: the arm stays where it is (3 times)"]
    );
    let homed = actions_with(program, |options| options.home = true);
    assert_eq!(homed[..3], [Action::Home, Action::Home, Action::Home]);
}

#[test]
fn a_servo_lifts_the_pen_to_the_heights_of_the_surface() {
    let program = "M300 S50\nG4 P150\nG1 X220 Y0 F3500\nM300 S30 (pen down)\nG4 P150\nG1 X240 Y0\nM300 S50.00\nG1 X220 Y0 Z150\nM300 S255\n";
    let (plan, notes) = try_with(program, |options| {
        options.surface = Some(Surface {
            height: -100.0,
            slope: [0.25, 0.0],
        });
        options.lift = 8.0;
    })
    .expect("it is all right");
    let all: Vec<_> = plan.steps.into_iter().map(|step| step.action).collect();
    let expected = [
        Action::Wait(150),
        build::line_speed(200.0, 200.0).into(),
        Action::Move {
            to: [220.0, 0.0, -37.0, 0.0],
            by: Travel::Joints,
        },
        travel(220.0, 0.0, -45.0),
        Action::Wait(150),
        build::path_speed((3500.0 / 60.0) as f32, 100.0).into(),
        path(240.0, 0.0, -40.0),
        travel(240.0, 0.0, -32.0),
        path(220.0, 0.0, -37.0),
    ];
    assert_eq!(all, expected);
    let notes: Vec<_> = notes.iter().map(ToString::to_string).collect();
    assert_eq!(
        notes,
        [
            "line 8, column 1: Z is left out: a servo lifts the pen, to the heights of the surface",
            "line 9, column 1: M300 (a tone, a servo that is switched off) is left out",
        ]
    );
    let unknown = try_read(program).expect_err("no surface");
    assert!(unknown.message.contains("the surface height is unknown"));
}

#[test]
fn omission_is_noted_once() {
    let program = "G0 X220 Y0 Z0\nM104 S200\nM104 S210\nM82\nG1 X221 E1\nG1 X222 E2\nG92 E0\nM106 S255\nM107\nM0\nT1\nG61.2\nM2\nG1 X1\n\nG1 X2\n";
    assert_eq!(
        notes(program),
        [
            "line 2, column 1: M104 is left out (2 times)",
            "line 4, column 1: M82 is left out",
            "line 5, column 1: E words are left out: nothing is extruded (3 times)",
            "line 8, column 1: M106 is left out",
            "line 9, column 1: M107 is left out",
            "line 12, column 1: G61.2 is left out",
            "2 lines after the end of the program are left out",
        ]
    );
    // The fan of a printer is not a laser, so nothing burns.
    assert_eq!(motions(program).last(), Some(&path(222.0, 0.0, 0.0)));
}
