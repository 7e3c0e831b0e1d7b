//! Placement of drawings, and the motion that draws them.

use magician::preflight::Preflight;
use magician::{Act, JointAngles, Setting, SettingValue, ToolBias};
use magician_motion::{
    ArmModel, ArmState, Ceilings, Geometry, Move, MoveKind, Planner, Pose, Target,
};
use magician_program::artwork::{Layout, Marking, Sheet};
use magician_program::{Action, Artwork, Origin, Stroke, Surface, Tool, Travel, check};

const PAPER: Surface = Surface::level(-60.0);

fn artwork(lines: &[&[[f64; 2]]]) -> Artwork {
    let strokes = lines.iter().enumerate().map(|(nth, points)| {
        let origin = Origin {
            line: nth as u32 + 1,
            column: 1,
            length: 1,
            name: 0,
        };
        Stroke::new(points.to_vec(), origin)
    });
    Artwork {
        title: "test".into(),
        strokes: strokes.collect(),
        ..Artwork::default()
    }
}

fn rectangle(width: f64, height: f64) -> Artwork {
    let corners = [
        [0.0, 0.0],
        [width, 0.0],
        [width, height],
        [0.0, height],
        [0.0, 0.0],
    ];
    artwork(&[&corners])
}

fn homed() -> Preflight {
    Preflight::at(JointAngles::HOME, ToolBias::NONE)
}

#[test]
fn drawing_is_placed_at_true_size_in_the_middle_of_the_reach() {
    let placed = rectangle(80.0, 60.0)
        .placed(&Layout::on(PAPER), &Marking::pen())
        .unwrap();
    let [least, most] = placed.artwork.bounds().unwrap();
    assert!((most[0] - least[0] - 80.0).abs() < 1e-9);
    assert!((most[1] - least[1] - 60.0).abs() < 1e-9);
    assert_eq!(placed.middle[1], 0.0);
    assert_eq!(placed.scale, 1.0);
    let report = check(&placed.plan(&Marking::pen()), &homed());
    assert!(report.is_good(), "{:?}", report.refused_steps.first());
    assert!((report.drawn - 280.0).abs() < 1e-2, "{}", report.drawn);
    let [least, _] = report.bounds.unwrap();
    assert_eq!(least[2], -60.0);
}

#[test]
fn rotation_mirror_and_scale_are_applied_in_this_order() {
    let arrow = artwork(&[&[[0.0, 0.0], [20.0, 0.0], [20.0, 5.0]]]);
    let layout = Layout {
        at: Some([220.0, 10.0]),
        mirror: true,
        rotate: 90.0,
        scale: 2.0,
        ..Layout::on(PAPER)
    };
    let placed = arrow.placed(&layout, &Marking::pen()).unwrap();
    // Mirrored: 0,0 -20,0 -20,5; turned: 0,0 0,-20 -5,-20; doubled, with the middle of -5..0 by
    // -20..0 at 220, 10.
    let expected = vec![[225.0, 30.0], [225.0, -10.0], [215.0, -10.0]];
    assert_eq!(placed.artwork.strokes[0].points, expected);
}

#[test]
fn on_a_sheet_the_page_lies_corner_on_corner() {
    let mut drawing = artwork(&[&[[10.0, 20.0], [40.0, 20.0]]]);
    drawing.page = Some([100.0, 80.0]);
    let sheet = Sheet {
        corner: [200.0, -50.0],
        rotation: 0.0,
        surface: PAPER,
        size: Some([100.0, 80.0]),
    };
    let put = |sheet, rotate| {
        let layout = Layout {
            rotate,
            ..Layout::on_sheet(sheet)
        };
        let placed = drawing
            .placed(&layout, &Marking::pen())
            .map_err(|diagnostic| diagnostic.to_string());
        placed.map(|placed| placed.artwork.strokes[0].points.clone())
    };
    assert_eq!(put(sheet, 0.0), Ok(vec![[210.0, -30.0], [240.0, -30.0]]));
    // The page turned to the left has its old upper left corner at the sheet's.
    let wide = Sheet {
        size: None,
        ..sheet
    };
    assert_eq!(put(wide, 90.0), Ok(vec![[260.0, -40.0], [260.0, -10.0]]));
    // A sheet turned by 90 degrees: its x runs along the arm's Y.
    let across = Sheet {
        rotation: 90.0,
        corner: [300.0, -50.0],
        ..sheet
    };
    assert_eq!(put(across, 0.0), Ok(vec![[280.0, -40.0], [280.0, -10.0]]));
    let small = Sheet {
        size: Some([50.0, 80.0]),
        ..sheet
    };
    let refusal = put(small, 0.0).unwrap_err();
    assert!(
        refusal.contains("the drawing is 30 by 0 mm, at most 15 by 0 mm"),
        "{refusal}"
    );
    let fitted = drawing.placed(
        &Layout {
            fit: true,
            ..Layout::on_sheet(small)
        },
        &Marking::pen(),
    );
    assert!((fitted.unwrap().scale - 0.51).abs() < 0.001);
}

#[test]
fn oversize_drawing_is_refused_with_both_sizes() {
    let page = rectangle(210.0, 297.0);
    let diagnostic = page
        .placed(&Layout::on(PAPER), &Marking::pen())
        .unwrap_err();
    assert!(
        diagnostic
            .message
            .starts_with("the drawing is 210 by 297 mm, at most "),
        "{diagnostic}"
    );
    let [fit, smaller] = &diagnostic.remedies[..] else {
        panic!("{diagnostic:?}")
    };
    assert_eq!(fit.act, Act::Give(Setting::Fit, SettingValue::On));
    let Act::Give(Setting::Scale, SettingValue::Number(scale)) = smaller.act else {
        panic!("{smaller:?}")
    };
    let layout = Layout {
        fit: true,
        ..Layout::on(PAPER)
    };
    let placed = page.placed(&layout, &Marking::pen()).unwrap();
    assert!((0.3..1.0).contains(&placed.scale), "{}", placed.scale);
    let report = check(&placed.plan(&Marking::pen()), &homed());
    assert!(report.is_good(), "{:?}", report.refused_steps.first());
    let layout = Layout {
        scale,
        ..Layout::on(PAPER)
    };
    assert!(page.placed(&layout, &Marking::pen()).is_ok());
}

#[test]
fn unplaceable_drawing_is_refused_with_an_explanation() {
    let pen = Marking::pen();
    let refusal =
        |artwork: &Artwork, layout: &Layout| artwork.placed(layout, &pen).unwrap_err().to_string();
    let square = rectangle(10.0, 10.0);
    assert!(refusal(&Artwork::default(), &Layout::on(PAPER)).contains("nothing to draw"));
    assert!(refusal(&square, &Layout::on(Surface::level(-300.0))).contains("z = -300.0 cannot"));
    let nan = Layout {
        rotate: f64::NAN,
        ..Layout::on(PAPER)
    };
    assert!(refusal(&square, &nan).contains("finite numbers"));
    let none = Layout {
        scale: 0.0,
        ..Layout::on(PAPER)
    };
    assert!(refusal(&square, &none).contains("above 0"));
    let behind = Layout {
        at: Some([0.0, 0.0]),
        ..Layout::on(PAPER)
    };
    assert!(refusal(&square, &behind).contains("around x = 0.0, y = 0.0"));
    let beyond = Layout {
        at: Some([320.0, 0.0]),
        scale: 20.0,
        ..Layout::on(PAPER)
    };
    assert!(refusal(&square, &beyond).starts_with("line 1, column 1: the drawing is 200 by 200"));
}

#[test]
fn a_laser_is_dark_between_lines_and_at_the_end() {
    let drawing = artwork(&[
        &[[0.0, 0.0], [30.0, 0.0]],
        &[[0.0, 9.0]],
        &[[0.0, 20.0], [30.0, 20.0]],
    ]);
    let laser = Marking::laser(40.0);
    let plan = drawing
        .placed(&Layout::on(PAPER), &laser)
        .unwrap()
        .plan(&laser);
    assert_eq!(plan.tool, Some(Tool::Laser));
    let report = check(&plan, &homed());
    assert!(report.is_good(), "{:?}", report.refused_steps.first());
    let dark = plan
        .steps
        .iter()
        .filter(|step| step.action == Action::Laser(false))
        .count();
    let lit = plan
        .steps
        .iter()
        .filter(|step| matches!(step.action, Action::Burn { .. }))
        .count();
    assert_eq!((dark, lit), (3, 3));
    let last = plan.steps.last().unwrap().action.target().unwrap();
    assert_eq!(last[2], -50.0);
}

#[test]
fn travel_goes_around_the_base() {
    // Two lines to the left and right of the arm.
    let drawing = artwork(&[
        &[[0.0, 230.0], [20.0, 230.0]],
        &[[0.0, -230.0], [20.0, -230.0]],
    ]);
    let layout = Layout {
        at: Some([10.0, 0.0]),
        ..Layout::on(PAPER)
    };
    let pen = Marking::pen();
    let plan = drawing.placed(&layout, &pen).unwrap().plan(&pen);
    let report = check(&plan, &homed());
    assert!(report.is_good(), "{:?}", report.refused_steps.first());
    // To the first line and to the second; a vertical lift may be a joint move.
    let mut at = None;
    let across = plan.steps.iter().filter(|step| {
        let to = step.action.target().map(|[x, y, _]| [x, y]);
        let moved = to.is_some() && to != at;
        at = to.or(at);
        let by = Travel::Joints;
        moved && matches!(step.action, Action::Move { by: way, .. } if way == by)
    });
    assert_eq!(across.count(), 2);
}

#[test]
fn a_tilted_surface_is_followed() {
    let tilted = Surface {
        height: -60.0,
        slope: [0.05, -0.02],
    };
    let pen = Marking::pen();
    let placed = rectangle(60.0, 60.0)
        .placed(&Layout::on(tilted), &pen)
        .unwrap();
    let plan = placed.plan(&pen);
    assert!(check(&plan, &homed()).is_good());
    for step in &plan.steps {
        if let Action::Path { to: [x, y, z] } = step.action {
            let height = tilted.at([x.into(), y.into()]);
            assert!((f64::from(z) - height).abs() < 1e-4);
        }
    }
}

/// Basis for planning the first move: from a tool 3 mm above the surface, a joint move that ends 50
/// mm above travel height never leads below the surface.
#[test]
fn first_move_never_crosses_the_paper() {
    let geometry = Geometry::magician(ToolBias::PEN);
    let planner = Planner {
        geometry,
        limits: ArmModel::MAGICIAN.limits,
        ceilings: Ceilings::default(),
        law: ArmModel::MAGICIAN.law,
        speeds: ArmModel::MAGICIAN.power_up.speeds(),
    };
    let mut tried = 0;
    for surface in [-100.0, -60.0, -30.0, 0.0, 40.0] {
        let at = |radius: f64, angle: f64, z: f64| {
            let pose = Pose::new(
                radius * angle.cos(),
                radius * angle.sin(),
                z,
                angle.to_degrees(),
            );
            ArmState::at_pose(&geometry, &pose, &ArmModel::MAGICIAN.limits).ok()
        };
        let radii = || (100..350).step_by(10).map(f64::from);
        for (from, to) in radii().flat_map(|from| radii().map(move |to| (from, to))) {
            for angle in [0.0, 1.0] {
                let (Some(from), Some(end)) =
                    (at(from, 0.0, surface + 3.0), at(to, angle, surface + 60.0))
                else {
                    continue;
                };
                let request = Move {
                    target: Target::Joints(end.joints),
                    kind: MoveKind::Joint,
                };
                let plan = planner.plan(&from, &request).unwrap();
                let way = plan.trajectory;
                tried += 1;
                for nth in 0..=200 {
                    let state = way.sample(way.duration_us() * nth / 200);
                    assert!(
                        state.pose.z > surface,
                        "{surface} {from:?} {to} {}",
                        state.pose.z
                    );
                }
            }
        }
    }
    assert!(tried > 500, "{tried}");
}
