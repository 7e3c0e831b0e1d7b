//! Tests of the setup: from options to a plan.

use magician_host::preflight::Preflight;
use magician_host::{Act, JointAngles, Setting, SettingValue};
use magician_protocol::Set;

use super::*;
use crate::raster::ImageStyle;
use crate::{Action, DiagnosticCode, Origin, Stroke, Travel, check};
use crate::{Artwork, Raster};

fn taught_plan() -> Plan {
    let mut plan = Plan::new("taught");
    for (x, y) in [(200.0, 0.0), (220.0, 0.0), (220.0, 10.0)] {
        let to = [x, y, 20.0, 0.0];
        let by = Travel::Joints;
        plan.push(Action::Move { to, by }, Origin::NONE);
    }
    plan
}

fn line() -> Artwork {
    Artwork {
        strokes: vec![Stroke::new(vec![[0.0, 0.0], [20.0, 0.0]], Origin::NONE)],
        ..Artwork::default()
    }
}

#[test]
fn taught_program_gets_the_named_tool() {
    let tool = |format, setup: &Setup| {
        let made = setup
            .plan(format, Content::Plan(taught_plan()))
            .expect("a plan");
        (made.plan.tool, made.notes.len())
    };
    let mut setup = Setup::default();
    assert_eq!(tool(Format::Gcode, &setup), (None, 0));
    assert_eq!(tool(Format::Playback, &setup), (Some(Tool::Suction), 1));
    setup.default_tool = Some(Tool::Gripper);
    assert_eq!(tool(Format::Playback, &setup), (Some(Tool::Gripper), 0));
    setup.tool = Some(Tool::Pen);
    assert_eq!(tool(Format::Gcode, &setup), (Some(Tool::Pen), 0));
}

#[test]
fn a_plan_is_placed_by_its_middle() {
    let mut setup = Setup::default();
    setup.placement.at = Some([240.0, 50.0]);
    setup.placement.by = [0.0, 0.0, 5.0];
    setup.placement.scale = 2.0;
    let made = setup
        .plan(Format::Plan, Content::Plan(taught_plan()))
        .expect("a plan");
    let points: Vec<_> = made
        .plan
        .steps
        .iter()
        .filter_map(|step| step.action.target())
        .collect();
    assert_eq!(
        points,
        [
            [220.0, 40.0, 25.0],
            [260.0, 40.0, 25.0],
            [260.0, 60.0, 25.0]
        ]
    );
    setup.placement.mirror = true;
    let made = setup.plan(Format::Plan, Content::Plan(taught_plan()));
    let mirrored = made.expect("a plan").plan;
    let points = mirrored.steps.iter();
    let points: Vec<_> = points.filter_map(|step| step.action.target()).collect();
    assert_eq!(
        points,
        [
            [260.0, 40.0, 25.0],
            [220.0, 40.0, 25.0],
            [220.0, 60.0, 25.0]
        ]
    );
}

#[test]
fn drawing_needs_a_surface_and_takes_the_most_specific_one() {
    let mut setup = Setup::default();
    let refused = setup
        .plan(Format::Svg, Content::Artwork(line()))
        .expect_err("no surface");
    assert_eq!(
        refused.remedies[0].act,
        Act::Do(magician_host::Action::CalibrateSurface)
    );
    let height = |setup: &Setup| {
        let made = setup
            .plan(Format::Svg, Content::Artwork(line()))
            .expect("a plan");
        made.plan.surface.map(|surface| surface.height)
    };
    setup.default_surface = Some(Surface::level(-60.0));
    assert_eq!(height(&setup), Some(-60.0));
    setup.sheet = Some(Sheet {
        corner: [200.0, -20.0],
        rotation: 0.0,
        surface: Surface::level(-50.0),
        size: None,
    });
    assert_eq!(height(&setup), Some(-50.0));
    setup.surface = Some(Surface::level(-40.0));
    assert_eq!(height(&setup), Some(-40.0));
}

#[test]
fn an_image_is_engraved_or_outlined() {
    let image = Raster {
        width: 2,
        height: 1,
        grey: vec![0, 255],
        ..Raster::default()
    };
    let mut setup = Setup {
        default_surface: Some(Surface::level(-60.0)),
        size: Size::Width(20.0),
        ..Setup::default()
    };
    let tool = |setup: &Setup| {
        let made = setup.plan(Format::Image, Content::Image(image.clone()));
        made.expect("a plan").plan.tool
    };
    assert_eq!(tool(&setup), Some(Tool::Laser));
    setup.work = Work::Draw(Trace::default());
    assert_eq!(tool(&setup), Some(Tool::Pen));
}

#[test]
fn an_image_made_to_fit_can_be_engraved_with_its_run_up() {
    let start = Preflight::at(JointAngles::HOME, ToolBias::NONE);
    let sheet = Sheet {
        corner: [180.0, -60.0],
        rotation: 10.0,
        surface: Surface::level(-60.0),
        size: Some([90.0, 70.0]),
    };
    for sheet in [None, Some(sheet)] {
        for (size, overscan) in [([500.0, 300.0], None), ([90.0, 700.0], Some(12.0))] {
            let image = Raster {
                width: 40,
                height: 40,
                grey: vec![0; 1600],
                pixel: Some(size.map(|side| side / 40.0)),
                ..Raster::default()
            };
            let mut setup = Setup {
                default_surface: Some(Surface::level(-60.0)),
                sheet,
                ..Setup::default()
            };
            let engrave = Engrave {
                overscan,
                ..Engrave::default()
            };
            setup.work = Work::Engrave(engrave);
            setup.placement.fit = true;
            let made = setup.plan(Format::Image, Content::Image(image)).unwrap();
            let report = check(&made.plan, &start);
            assert!(report.is_good(), "{:?}", report.refused_steps.first());
            let [least, most] = report.bounds.unwrap();
            assert!(most[0] - least[0] > 40.0);
            if sheet.is_some() {
                assert!(least[1] > -63.0 && most[1] < 30.0);
            }
        }
    }
}

#[test]
fn image_is_engraved_at_the_largest_even_speed_and_a_faster_one_is_noted() {
    // All neighbouring pixels differ.
    let image = Raster {
        width: 40,
        height: 1,
        grey: [0, 128].repeat(20),
        ..Raster::default()
    };
    let engraved = |spacing: f64, speed: Option<f32>| {
        let engrave = Engrave {
            spacing,
            ..Engrave::default()
        };
        let setup = Setup {
            default_surface: Some(Surface::level(-60.0)),
            work: Work::Engrave(engrave),
            size: Size::Width(40.0 * spacing),
            speed,
            ..Setup::default()
        };
        let made = setup.plan(Format::Image, Content::Image(image.clone()));
        let made = made.expect("it is engraved");
        let burns = made
            .plan
            .steps
            .iter()
            .filter(|step| matches!(step.action, Action::Burn { .. }));
        assert!(burns.count() >= 39);
        let speed = made.plan.commands().find_map(|command| match command {
            Set::CpParams(path) => Some(path.junction_vel),
            _ => None,
        });
        let note = made
            .notes
            .into_iter()
            .find(|note| note.code == DiagnosticCode::Speed);
        (
            speed.expect("a speed"),
            note.map(|note| note.remedies[0].act.clone()),
        )
    };
    assert_eq!(engraved(0.2, None), (10.0, None));
    assert_eq!(engraved(0.1, None), (5.0, None));
    assert_eq!(engraved(0.5, None), (20.0, None));
    assert_eq!(engraved(0.2, Some(8.0)), (8.0, None));
    let (speed, note) = engraved(0.2, Some(30.0));
    assert_eq!(speed, 30.0);
    assert_eq!(
        note,
        Some(Act::Give(Setting::Speed, SettingValue::Number(10.0)))
    );
    // The advised speed causes no further note, even below a resolution of 0.1 mm/s.
    for spacing in [0.3, 0.07, 0.001] {
        let (_, note) = engraved(spacing, Some(30.0));
        let Some(Act::Give(_, SettingValue::Number(slower))) = note else {
            panic!("{spacing}: {note:?}");
        };
        assert!(slower > 0.0);
        assert_eq!(engraved(spacing, Some(slower as f32)).1, None, "{spacing}");
    }
}

#[test]
fn image_stays_within_its_sheet() {
    let image = Raster {
        width: 4,
        height: 2,
        grey: vec![0; 8],
        ..Raster::default()
    };
    let setup = |width: f64, rotate: f64| Setup {
        sheet: Some(Sheet {
            corner: [200.0, -20.0],
            rotation: 0.0,
            surface: Surface::level(-50.0),
            size: Some([50.0, 40.0]),
        }),
        size: Size::Width(width),
        placement: Placement {
            rotate,
            ..Placement::default()
        },
        ..Setup::default()
    };
    let made = |setup: &Setup| setup.plan(Format::Image, Content::Image(image.clone()));
    let refused = made(&setup(60.0, 0.0)).expect_err("it is wider than the sheet");
    assert!(refused.message.contains("60.0 x 30.0 mm"), "{refused}");
    assert!(made(&setup(45.0, 90.0)).is_err(), "it is higher, turned");
    let plan = made(&setup(30.0, 90.0)).expect("it fits").plan;
    let burnt = plan.steps.iter().filter_map(|step| match step.action {
        Action::Burn { to, power } if power > 0.0 => Some(to),
        _ => None,
    });
    for [x, y, _] in burnt {
        assert!(
            (199.0..=216.0).contains(&x) && (-21.0..=11.0).contains(&y),
            "{x} {y}"
        );
    }
}

#[test]
fn default_tool_is_used_if_it_can_do_the_work() {
    let bias = Tool::Bias([61.5, 0.5, 0.0]);
    for (usual, pen, laser) in [
        (Tool::Suction, Tool::Pen, Tool::Laser),
        (Tool::Pen, Tool::Pen, Tool::Laser),
        (bias, bias, Tool::Laser),
        (Tool::Laser, Tool::Pen, Tool::Laser),
    ] {
        let setup = Setup {
            default_tool: Some(usual),
            ..Setup::default()
        };
        assert_eq!(setup.tool_for(Tool::Pen), pen, "{usual}");
        assert_eq!(setup.tool_for(Tool::Laser), laser, "{usual}");
        let asked = Setup {
            tool: Some(Tool::Gripper),
            ..setup
        };
        assert_eq!(asked.tool_for(Tool::Pen), Tool::Gripper);
    }
}

/// Bounds of the lines of a plan, x and y.
fn marked(plan: &Plan) -> [[f64; 2]; 2] {
    let lines = WorkLines::of(plan, None).unwrap();
    lines.artwork.bounds().unwrap()
}

#[test]
fn shaded_image_is_rendered_at_its_drawn_size() {
    let image = Raster {
        width: 60,
        height: 40,
        grey: vec![100; 2400],
        ..Raster::default()
    };
    let trace = Trace {
        style: ImageStyle::Hatch,
        levels: Some(1),
        ..Trace::default()
    };
    let mut setup = Setup {
        default_surface: Some(Surface::level(-60.0)),
        size: Size::Width(60.0),
        work: Work::Draw(trace),
        ..Setup::default()
    };
    // A layer at 45 degrees, lines 0.5 mm apart: as many lines as width and height allow.
    let lines = |setup: &Setup| {
        let made = setup.plan(Format::Image, Content::Image(image.clone()));
        let made = made.expect("a plan");
        let drawn = WorkLines::of(&made.plan, None).unwrap().artwork;
        let [least, most] = drawn.bounds().unwrap();
        let across: f64 = (0..2).map(|axis| most[axis] - least[axis]).sum();
        let spacing = across / 2.0_f64.sqrt() / drawn.strokes.len() as f64;
        (spacing, made.placed.unwrap().scale)
    };
    let (spacing, _) = lines(&setup);
    assert!((spacing / 0.5 - 1.0).abs() < 0.05, "{spacing}");
    setup.placement.scale = 2.0;
    let (spacing, scale) = lines(&setup);
    assert!(
        (spacing / 0.5 - 1.0).abs() < 0.05 && scale == 2.0,
        "{spacing}"
    );
    setup.placement.scale = 8.0;
    setup.placement.fit = true;
    let (spacing, scale) = lines(&setup);
    assert!(
        (spacing / 0.5 - 1.0).abs() < 0.05 && scale < 8.0,
        "{spacing}, {scale}"
    );
}

#[test]
fn width_applies_to_all_drawn_content() {
    let mut setup = Setup {
        default_surface: Some(Surface::level(-60.0)),
        size: Size::Width(25.0),
        ..Setup::default()
    };
    let mut drawing = line();
    drawing.strokes[0].points = vec![[0.0, 0.0], [10.0, 4.0]];
    let made = |setup: &Setup, drawing: &Artwork| {
        setup.plan(Format::Svg, Content::Artwork(drawing.clone()))
    };
    let side = |plan: &Plan, axis: usize| {
        let [least, most] = marked(plan);
        most[axis] - least[axis]
    };
    let plan = made(&setup, &drawing).unwrap().plan;
    assert!((side(&plan, 0) - 25.0).abs() < 1e-3 && (side(&plan, 1) - 10.0).abs() < 1e-3);
    setup.size = Size::Height(8.0);
    assert!((side(&made(&setup, &drawing).unwrap().plan, 0) - 20.0).abs() < 1e-3);
    setup.placement.frame = Frame::Own;
    let again = setup.plan(Format::Gcode, Content::Plan(plan)).unwrap();
    assert!((side(&again.plan, 1) - 8.0).abs() < 1e-3);
    drawing.strokes[0].points[1][1] = 0.0;
    let why = made(&setup, &drawing).unwrap_err().message;
    assert_eq!(why, "what it draws has no height: it cannot become 8 mm");
}
