//! Report of a check.

use std::time::Duration;

use magician::build;
use magician::preflight::Preflight;
use magician::{ErrorKind, JointAngles, ToolBias};
use magician_program::{Action, Diagnostic, Origin, Surface, Tool, Travel, check};

use super::{line, plan_of};

fn start() -> Preflight {
    Preflight::at(JointAngles::HOME, ToolBias::NONE)
}

#[test]
fn a_drawing_with_a_pen() {
    let mut plan = plan_of([
        line([220.0, 0.0, 10.0]),
        line([220.0, 0.0, 0.0]),
        Action::Path {
            to: [240.0, 0.0, 0.0],
        },
        Action::Path {
            to: [240.0, 30.0, 0.0],
        },
        line([240.0, 30.0, 10.0]),
        Action::Wait(2500),
        line([200.0, 0.0, 10.0]),
    ]);
    plan.surface = Some(Surface::level(0.0));
    let report = check(&plan, &start());
    assert!(report.is_good());
    assert_eq!(report.drawn, 50.0);
    let begun = start().arm().unwrap().pose;
    let lead = ((220.0 - begun.x).powi(2) + (10.0 - begun.z).powi(2)).sqrt();
    assert!(
        (report.travelled - (lead + 10.0 + 10.0 + 50.0)).abs() < 1e-9,
        "{report:?}"
    );
    assert_eq!(report.steps, 7);
    let counts: Vec<_> = report
        .counts
        .iter()
        .map(|(kind, count)| (*kind, *count))
        .collect();
    assert_eq!(counts, [("move", 4), ("path", 2), ("wait", 1)]);
    assert_eq!(report.longest_time, Some((5, Duration::from_millis(2500))));
    assert_eq!(report.longest_motion, Some((6, 50.0)));
    // Bounds of the drawing, and of all targets.
    assert_eq!(report.bounds, Some([[220.0, 0.0, 0.0], [240.0, 30.0, 0.0]]));
    assert_eq!(
        report.travel_bounds,
        Some([[200.0, 0.0, 0.0], [240.0, 30.0, 10.0]])
    );
}

#[test]
fn arcs_and_circles_have_their_true_length_and_draw_on_the_surface() {
    let circle = build::circle([230.0, 10.0, 0.0, 0.0], [240.0, 0.0, 0.0, 0.0], 2);
    let mut plan = plan_of([
        Action::Move {
            to: [220.0, 0.0, 0.0, 0.0],
            by: Travel::Joints,
        },
        Action::Arc {
            via: [230.0, 10.0, 0.0, 0.0],
            to: [240.0, 0.0, 0.0, 0.0],
        },
        Action::Arc {
            via: [230.0, -10.0, 0.0, 0.0],
            to: [220.0, 0.0, 0.0, 0.0],
        },
        Action::from(circle),
    ]);
    plan.surface = Some(Surface::level(0.0));
    let report = check(&plan, &start());
    assert!(report.is_good());
    let turns = 3.0 * std::f64::consts::TAU * 10.0;
    assert!((report.drawn - turns).abs() < 1e-9, "{report:?}");
    plan.surface = None;
    assert_eq!(check(&plan, &start()).drawn, 0.0);
}

#[test]
fn a_laser_draws_where_it_is_lit() {
    let mut plan = plan_of([
        line([220.0, 0.0, 0.0]),
        Action::Burn {
            to: [230.0, 0.0, 0.0],
            power: 50.0,
        },
        Action::Burn {
            to: [240.0, 0.0, 0.0],
            power: 0.0,
        },
        Action::Burn {
            to: [240.0, 5.0, 0.0],
            power: 10.0,
        },
        Action::Laser(false),
        line([220.0, 5.0, 0.0]),
        Action::Laser(true),
        line([220.0, 0.0, 0.0]),
        Action::Laser(false),
    ]);
    plan.tool = Some(Tool::Laser);
    let report = check(&plan, &start());
    assert!(report.is_good(), "{:?}", report.refused_steps);
    assert!((report.drawn - 20.0).abs() < 1e-9, "{report:?}");
}

#[test]
fn refusals_have_origin_step_and_distance() {
    let mut plan = plan_of([
        line([220.0, 0.0, 0.0]),
        line([420.0, 0.0, 0.0]),
        Action::Path {
            to: [f32::NAN, 0.0, 0.0],
        },
        Action::Burn {
            to: [230.0, 0.0, 0.0],
            power: 50.0,
        },
    ]);
    let name = plan.name("far corner");
    plan.steps[1].origin = plan.steps[1].origin.named(name);
    let report = check(&plan, &start());
    assert_eq!(report.refused, 3);
    let [far, nan, lit] = &report.refused_steps[..] else {
        panic!("{report:?}");
    };
    assert_eq!(
        (far.step, far.origin.line, far.error.kind()),
        (1, 2, ErrorKind::Unreachable)
    );
    assert!(far.error.value() > far.error.limit());
    let diagnostic = Diagnostic::from(far).to_string();
    assert!(
        diagnostic.starts_with("line 2, column 1 (far corner): x "),
        "{diagnostic}"
    );
    assert_eq!((nan.step, nan.error.kind()), (2, ErrorKind::InvalidInput));
    assert_eq!((lit.step, lit.origin), (4, Origin::NONE));
    assert!(lit.error.to_string().contains("laser"));
}

#[test]
fn unqueueable_command_is_refused() {
    let name = magician::commands::DeviceName {
        device_name: magician::protocol::Text::new("x").unwrap(),
    };
    let plan = plan_of([Action::Command(Box::new(name.into()))]);
    let report = check(&plan, &start());
    assert_eq!(report.refused, 1);
    assert!(
        report.refused_steps[0]
            .error
            .to_string()
            .contains("cannot be queued")
    );
}

#[test]
fn refusals_beyond_the_first_hundred_are_counted() {
    let far = std::iter::repeat_with(|| line([900.0, 0.0, 0.0]));
    let report = check(&plan_of(far.take(250)), &start());
    assert_eq!((report.refused_steps.len(), report.refused), (100, 250));
    assert!(!report.is_good());
}

#[test]
fn endless_plan_has_no_duration() {
    for action in [Action::Home, Action::from(build::wait_for_level(19, true))] {
        let report = check(
            &plan_of([Action::Wait(100), action, Action::Wait(100)]),
            &start(),
        );
        assert!(report.is_good());
        assert_eq!(report.time, None);
        assert_eq!(report.longest_time, Some((0, Duration::from_millis(100))));
    }
    assert_eq!(check(&plan_of([]), &start()).time, Some(Duration::ZERO));
}
