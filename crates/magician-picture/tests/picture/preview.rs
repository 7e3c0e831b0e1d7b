//! Previews of plans.

use std::time::Duration;

use magician::build;
use magician_picture::compare::compare;
use magician_picture::{PictureError, Preview, PreviewOptions};
use magician_program::rehearse::{RehearseOptions, rehearse, stage, start_of};
use magician_program::toolpath::DrawnLine;
use magician_program::{
    Action, Format, Origin, Plan, Program, ReadOptions, Setup, Surface, Tool, Travel, check, read,
};

const PAPER: f32 = -60.0;

fn preview(plan: &Plan, options: &PreviewOptions) -> Preview {
    let start = start_of(&stage(plan, &RehearseOptions::default()).unwrap());
    Preview::new(plan, &check(plan, &start), &start, options)
}

fn push_move(plan: &mut Plan, [x, y, z]: [f32; 3], by: Travel) {
    let to = [x, y, z, 0.0];
    plan.push(Action::Move { to, by }, Origin::NONE);
}

fn drawing(segments: u32) -> Plan {
    let mut plan = Plan::new("ring");
    plan.tool = Some(Tool::Pen);
    plan.surface = Some(Surface::level(PAPER.into()));
    let at = |nth: u32| {
        let (sin, cos) = (nth as f32 / segments as f32 * std::f32::consts::TAU).sin_cos();
        [230.0 + 40.0 * cos, 40.0 * sin]
    };
    let [x, y] = at(0);
    push_move(&mut plan, [x, y, PAPER + 10.0], Travel::Joints);
    push_move(&mut plan, [x, y, PAPER], Travel::Line);
    for nth in 1..=segments {
        let [x, y] = at(nth);
        plan.push(Action::Path { to: [x, y, PAPER] }, Origin::NONE);
    }
    push_move(&mut plan, [x, y, PAPER + 10.0], Travel::Line);
    plan
}

/// Returns a plan with every kind of motion.
fn plan_with_every_motion() -> Plan {
    let mut plan = Plan::new("ways");
    plan.tool = Some(Tool::Suction);
    push_move(&mut plan, [200.0, 100.0, -30.0], Travel::Jump);
    plan.push(Action::Suction(true), Origin::NONE);
    plan.push(Action::Wait(200), Origin::NONE);
    push_move(&mut plan, [240.0, -80.0, -30.0], Travel::Jump);
    plan.push(Action::Suction(false), Origin::NONE);
    plan.push(
        build::joint_speed([30.0, 200.0, 90.0, 50.0], [100.0; 4]),
        Origin::NONE,
    );
    push_move(&mut plan, [180.0, 60.0, 60.0], Travel::Joints);
    let (via, to) = ([210.0, 90.0, 50.0, 0.0], [240.0, 60.0, 20.0, 20.0]);
    plan.push(Action::Arc { via, to }, Origin::NONE);
    let to = [20.0, 30.0, 20.0, 0.0];
    let by = Travel::Joints;
    plan.push(Action::Joints { to, by }, Origin::NONE);
    for line in [false, true] {
        let by = [10.0, -20.0, 5.0, 3.0];
        plan.push(Action::Shift { by, line }, Origin::NONE);
    }
    let jump = build::jump_line_to(210.0, 0.0, 10.0, 0.0);
    plan.push(jump, Origin::NONE);
    plan.push(build::path_by(10.0, 5.0, -10.0), Origin::NONE);
    plan.push(
        build::circle([230.0, 20.0, 0.0, 0.0], [240.0, 0.0, 0.0, 0.0], 1),
        Origin::NONE,
    );
    plan
}

#[test]
fn shown_paths_match_the_tool_motion() {
    for plan in [plan_with_every_motion(), drawing(200)] {
        let options = RehearseOptions::default().watch(Duration::from_millis(2));
        let done = rehearse(&plan, &options).unwrap();
        assert!(done.is_good(), "{:?} {:?}", done.alarms, done.log);
        let path: Vec<[f64; 2]> = done.way.iter().map(|[x, y, _]| [*x, *y]).collect();
        let preview = preview(&plan, &PreviewOptions::default());
        let shown: Vec<Vec<[f64; 2]>> = preview.paths().map(<[_]>::to_vec).collect();
        let matched = compare(&[path], &shown, 0.15).matched;
        assert!(matched.is_good(), "{}: {matched:?}", plan.title);
    }
}

#[test]
fn picture_size_is_bounded_for_large_plans() {
    let [small, large] = [400, 40_000].map(|segments| {
        let preview = preview(&drawing(segments), &PreviewOptions::default());
        preview.to_svg().to_owned()
    });
    assert!(
        large.len() < small.len() + 2000,
        "{} {}",
        large.len(),
        small.len()
    );
    assert_eq!(large.matches('<').count(), small.matches('<').count());
}

/// Returns a drawing in which the pen comes down and goes up again at each of these positions.
fn dots(places: &[[f32; 2]]) -> Plan {
    dots_by(places, 10.0, Travel::Line)
}

fn dots_by(places: &[[f32; 2]], height: f32, travel: Travel) -> Plan {
    let mut plan = drawing(12);
    for [x, y] in places {
        push_move(&mut plan, [*x, *y, PAPER + height], travel);
        push_move(&mut plan, [*x, *y, PAPER], travel);
        plan.push(Action::Wait(50), Origin::NONE);
        push_move(&mut plan, [*x, *y, PAPER + height], travel);
    }
    plan
}

#[test]
fn pen_dot_is_shown_as_ink() {
    let inked = |plan: &Plan| {
        let options = PreviewOptions::default();
        let svg = preview(plan, &options).to_svg().to_owned();
        let drawn = svg.lines().find(|line| line.contains(r#"class="drawn""#));
        drawn.expect("something is drawn").to_owned()
    };
    let without = inked(&dots(&[]));
    let with = inked(&dots(&[[240.0, 10.0], [220.0, -10.0]]));
    let subpaths = |path: &str| {
        path.split("class=")
            .next()
            .map_or(0, |data| data.matches('m').count())
    };
    assert_eq!(subpaths(&with), subpaths(&without) + 2, "{with}");
    assert!(with.contains(r#"stroke-width="0.5""#) && with.contains(r#"stroke-linecap="round""#));
    let options = PreviewOptions::default();
    let waits = dots(&[[240.0, 10.0]]);
    // A joint move does not descend straight: its end is a line of some hundredths of a millimetre
    // on the sheet.
    let hops = dots_by(&[[240.0, 10.0]], 3.0, Travel::Joints);
    for dots in [&waits, &hops] {
        assert!(
            !preview(dots, &options).to_svg().contains("waits"),
            "it is no wait"
        );
    }
    assert_eq!(subpaths(&inked(&hops)), subpaths(&without) + 1);
    // The preview agrees with the dots that the virtual arm leaves.
    let plan = dots(&[[240.0, 10.0], [220.0, -10.0]]);
    let done = rehearse(&plan, &RehearseOptions::default()).unwrap();
    assert_eq!(done.drawing.strokes().len(), subpaths(&with));
    // A plan of a single dot draws it, even if the pen stays down.
    let mut dot = Plan::new("dot");
    (dot.tool, dot.surface) = (plan.tool, plan.surface);
    push_move(&mut dot, [240.0, 0.0, PAPER + 10.0], Travel::Joints);
    push_move(&mut dot, [240.0, 0.0, PAPER], Travel::Line);
    assert_eq!(subpaths(&inked(&dot)), 1);
    let lines = DrawnLine::of(
        &dot,
        &start_of(&stage(&dot, &RehearseOptions::default()).unwrap()),
    );
    assert_eq!(
        lines,
        [DrawnLine {
            step: 1,
            from: [240.0, 0.0],
            to: [240.0, 0.0]
        }]
    );
}

#[test]
fn pen_that_stands_on_the_sheet_at_the_start_leaves_no_dot_in_the_picture() {
    let plan = drawing(90);
    let above = start_of(&stage(&plan, &RehearseOptions::default()).unwrap());
    for place in [[150.0, -150.0, PAPER], [180.0, 150.0, PAPER - 0.4]] {
        let mut on_sheet = above.clone();
        let [x, y, z] = place;
        on_sheet.check(&build::line_to(x, y, z, 0.0)).unwrap();
        let lines = |start| DrawnLine::of(&plan, start);
        assert_eq!(lines(&on_sheet), lines(&above), "{place:?}");
        let drawn = |start| {
            let preview = Preview::new(
                &plan,
                &check(&plan, start),
                start,
                &PreviewOptions::default(),
            );
            let svg = preview.to_svg().to_owned();
            let drawn = svg.lines().find(|line| line.contains(r#"class="drawn""#));
            drawn.expect("something is drawn").matches('m').count()
        };
        assert_eq!(drawn(&on_sheet), drawn(&above), "{place:?}");
    }
}

#[test]
fn a_picture_is_in_true_size() {
    let svg = preview(&drawing(90), &PreviewOptions::default());
    let tree = resvg::usvg::Tree::from_str(svg.to_svg(), &resvg::usvg::Options::default()).unwrap();
    let head = svg.to_svg().split('>').next().unwrap();
    let width: f64 = head
        .split("width=\"")
        .nth(1)
        .unwrap()
        .split("mm")
        .next()
        .unwrap()
        .parse()
        .unwrap();
    assert!(head.contains(&format!("viewBox=\"0 0 {width} ")), "{head}");
    assert!((f64::from(tree.size().width()) * 25.4 / 96.0 - width).abs() < 1e-3);
    assert!(svg.to_svg().contains(">80.0 × 80.0 mm  ·  251 mm drawn"));
}

#[test]
fn a_burn_without_a_surface_shows_the_reach_at_its_height() {
    let mut plan = Plan::new("burn");
    plan.tool = Some(Tool::Laser);
    push_move(&mut plan, [220.0, 0.0, -8.5], Travel::Line);
    let (to, power) = ([240.0, 0.0, -8.5], 50.0);
    plan.push(Action::Burn { to, power }, Origin::NONE);
    let svg = preview(&plan, &PreviewOptions::default());
    assert!(svg.to_svg().contains("within reach at z = −8.5 mm"));
}

#[test]
fn refused_steps_are_marked_and_counted() {
    let mut plan = drawing(40);
    for x in [400.0, 10.0, 500.0, f32::NAN, f32::INFINITY] {
        push_move(&mut plan, [x, 0.0, PAPER], Travel::Line);
    }
    let preview = preview(&plan, &PreviewOptions::default());
    let svg = preview.to_svg();
    for part in [
        ">step 44<",
        ">step 45<",
        ">step 46<",
        "and 2 more",
        "5 refused",
    ] {
        assert!(svg.contains(part), "{part}: {svg}");
    }
    assert!(!svg.contains("NaN") && !svg.contains("inf"));
}

#[test]
fn pick_and_place_plan_is_shown_from_the_side() {
    let shows_side_view = |options: PreviewOptions, plan: &Plan| {
        preview(plan, &options)
            .to_svg()
            .contains("distance from the base axis")
    };
    assert!(shows_side_view(
        PreviewOptions::default(),
        &plan_with_every_motion()
    ));
    assert!(!shows_side_view(PreviewOptions::default(), &drawing(9)));
    assert!(!shows_side_view(
        PreviewOptions::default().side(false),
        &plan_with_every_motion()
    ));
    assert!(shows_side_view(
        PreviewOptions::default().side(true),
        &drawing(9)
    ));
    let svg = preview(&plan_with_every_motion(), &PreviewOptions::default());
    for part in ["grips", "releases", "waits", "with something held"] {
        assert!(svg.to_svg().contains(part), "{part}");
    }
}

#[test]
fn any_title_and_an_empty_plan_make_a_picture() {
    let plan = Plan::new("<&\"\u{1}ä 字");
    let preview = preview(&plan, &PreviewOptions::default());
    assert!(preview.to_svg().contains("&lt;&amp;&quot;\\u{1}ä 字"));
    assert!(preview.to_png(1.0).unwrap().starts_with(b"\x89PNG"));
}

#[test]
fn png_has_the_requested_size_or_is_refused() {
    let preview = preview(&drawing(9), &PreviewOptions::default());
    let image = image::load_from_memory(&preview.to_png(2.0).unwrap()).unwrap();
    let twice = image::load_from_memory(&preview.to_png(4.0).unwrap()).unwrap();
    assert!(twice.width().abs_diff(2 * image.width()) <= 2);
    for scale in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let refused = preview.to_png(scale).unwrap_err();
        assert!(matches!(refused, PictureError::Scale(_)), "{refused}");
    }
    let refused = preview.to_png(1e6).unwrap_err();
    assert!(matches!(refused, PictureError::Size(_)), "{refused}");
}

/// Steps keep their numbers when a run begins at a later step: the approach to it has no number.
#[test]
fn refusals_use_step_numbers_of_the_whole_program() {
    let mut plan = drawing(12);
    push_move(&mut plan, [600.0, 0.0, 0.0], Travel::Line);
    let last = plan.steps.len();
    let start = start_of(&stage(&plan, &RehearseOptions::default()).unwrap());
    for from in [0, 5] {
        let program = Program::new(plan.clone(), Some(1));
        let rest = program.remaining(from, start.clone()).unwrap();
        let report = rest.check();
        assert_eq!(report.refused, 1);
        assert_eq!(report.number(report.refused_steps[0].step), last as u64);
        let options = PreviewOptions::default();
        let picture = Preview::new(rest.first(), &report, rest.start_with_settings(), &options);
        let named = picture.to_svg().matches(&format!(">step {last}")).count();
        assert_eq!(named, 2, "{from}");
    }
}

/// Lines and a dot are shown in the colours of the drawing, except black and pale lines.
#[test]
fn preview_of_a_drawing_without_parts_shows_its_colours() {
    let svg = "<svg xmlns='http://www.w3.org/2000/svg' width='60mm' height='40mm' viewBox='0 0 60 40'>\
        <path d='M5 5H25' stroke='red'/><path d='M5 15H25' stroke='blue'/>\
        <path d='M5 25H25' stroke='black'/><path d='M5 35H25' stroke='#f0f0f0'/>\
        <path d='M30 5h0' stroke='lime' stroke-linecap='round'/></svg>";
    let parsed = read(Format::Svg, svg.as_bytes(), &ReadOptions::default()).unwrap();
    let mut setup = Setup::default();
    setup.surface = Some(Surface::level(PAPER.into()));
    let plan = setup.plan(Format::Svg, parsed.content).unwrap().plan;
    let shown = preview(&plan, &PreviewOptions::default());
    let drawn = shown.to_svg().lines().flat_map(|line| line.split("<path"));
    let drawn = drawn.filter(|path| path.contains("class=\"drawn\""));
    let colour = |path: &str| {
        let (_, from) = path.split_once("stroke=\"").unwrap();
        from.split('"').next().unwrap().to_owned()
    };
    let mut colours: Vec<String> = drawn.map(colour).collect();
    colours.sort();
    // Black and pale lines have the default ink colour.
    assert_eq!(colours, ["#0000ff", "#00ff00", "#1a1a1a", "#ff0000"]);
}

#[test]
fn a_preview_has_the_outline_of_the_page_and_its_legend_names_it() {
    let plan = drawing(12);
    let page = [[187.5, -64.0], [292.5, -64.0], [292.5, 84.0], [187.5, 84.0]];
    let drawn = |options: &PreviewOptions| preview(&plan, options).to_svg().to_owned();
    let without = drawn(&PreviewOptions::default());
    let with = drawn(&PreviewOptions::default().page(page));
    assert!(!without.contains(r#"class="page""#) && !without.contains(">page</text>"));
    assert_eq!(with.matches(r#"class="page""#).count(), 1);
    assert!(with.contains(">page</text>"), "the legend names it");
}
