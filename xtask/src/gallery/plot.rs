//! Picture of a run: from above, from the side, and joint speeds.

use std::error::Error;
use std::ops::Range;

use magician_motion::{ArmModel, Geometry, JointAngles, TopView};
use plotters::coord::Shift;
use plotters::prelude::*;

use super::modes::Mode;
use super::run::{Run, Sample};

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type DrawResult = Result<(), Box<dyn Error>>;

const SIZE: (u32, u32) = (1320, 420);
const INK: RGBColor = RGBColor(31, 41, 51);
const FAINT: RGBColor = RGBColor(203, 210, 217);
const TRACK: RGBColor = RGBColor(59, 125, 216);
const AXES: [(&str, RGBColor); 5] = [
    ("J1", RGBColor(59, 125, 216)),
    ("J2", RGBColor(232, 89, 12)),
    ("J3", RGBColor(47, 158, 68)),
    ("J4", RGBColor(156, 54, 181)),
    ("rail, mm/s", RGBColor(134, 142, 150)),
];

/// Draws a run.
pub(super) fn draw(mode: &Mode, run: &Run) -> Result<String, Box<dyn Error>> {
    let mut text = String::new();
    {
        let root = SVGBackend::with_string(&mut text, SIZE).into_drawing_area();
        root.fill(&WHITE)?;
        let root = root.titled(mode.title, ("sans-serif", 20).into_font().color(&INK))?;
        let (above, rest) = root.split_horizontally(430);
        let (side, speeds) = rest.split_horizontally(400);
        from_above(&above, &run.samples)?;
        from_the_side(&side, &run.samples)?;
        joint_speeds(&speeds, &run.samples)?;
        root.present()?;
    }
    Ok(text)
}

/// Extends the ranges to equal scales on both axes.
fn with_equal_scales(x: Range<f64>, y: Range<f64>, aspect: f64) -> (Range<f64>, Range<f64>) {
    let (width, height) = (x.end - x.start, y.end - y.start);
    let width_wanted = width.max(height * aspect);
    let height_wanted = width_wanted / aspect;
    let widen = |range: Range<f64>, to: f64| {
        let more = 0.5 * (to - (range.end - range.start));
        range.start - more..range.end + more
    };
    (widen(x, width_wanted), widen(y, height_wanted))
}

fn panel(
    area: &Area<'_>,
    caption: &str,
    names: (&str, &str),
    ranges: (Range<f64>, Range<f64>),
    ground: Vec<(f64, f64)>,
    track: Vec<(f64, f64)>,
) -> DrawResult {
    let mut chart = ChartBuilder::on(area)
        .caption(caption, ("sans-serif", 15).into_font().color(&INK))
        .margin(8)
        .x_label_area_size(36)
        .y_label_area_size(48)
        .build_cartesian_2d(ranges.0, ranges.1)?;
    chart
        .configure_mesh()
        .x_desc(names.0)
        .y_desc(names.1)
        .x_label_formatter(&|value| format!("{value:.0}"))
        .y_label_formatter(&|value| format!("{value:.0}"))
        .max_light_lines(0)
        .bold_line_style(FAINT.mix(0.6))
        .label_style(("sans-serif", 12).into_font().color(&INK))
        .draw()?;
    chart.draw_series(std::iter::once(Polygon::new(
        ground,
        RGBColor(225, 230, 236).mix(0.6).filled(),
    )))?;
    let ends = (track.first().copied(), track.last().copied());
    chart.draw_series(LineSeries::new(track, TRACK.stroke_width(2)))?;
    if let (Some(start), Some(end)) = ends {
        chart.draw_series([Circle::new(start, 4, INK.filled())])?;
        chart.draw_series([Circle::new(end, 7, INK.stroke_width(2))])?;
    }
    Ok(())
}

/// Projects a position on the ground as on paper: X to the right, Y up.
fn to_view(place: [f64; 2]) -> (f64, f64) {
    let [right, up] = TopView::PAPER.project(place);
    (right, up)
}

fn from_above(area: &Area<'_>, samples: &[Sample]) -> DrawResult {
    let (inner_radius, outer_radius) = (46.2, 269.0);
    let turn = ArmModel::MAGICIAN.limits.j1;
    let arc = |radius: f64| {
        (0..=90).map(move |step| {
            let angle = turn.min + (turn.max - turn.min) * f64::from(step) / 90.0;
            let (sin, cos) = angle.to_radians().sin_cos();
            to_view([radius * cos, radius * sin])
        })
    };
    let inner: Vec<_> = arc(inner_radius).collect();
    let ground = arc(outer_radius).chain(inner.into_iter().rev()).collect();
    let track = samples
        .iter()
        .map(|sample| to_view([sample.pose.x, sample.pose.y]))
        .collect();
    let ranges = with_equal_scales(-210.0..290.0, -290.0..290.0, 1.12);
    panel(
        area,
        "from above",
        ("x / mm", "y / mm"),
        ranges,
        ground,
        track,
    )
}

fn from_the_side(area: &Area<'_>, samples: &[Sample]) -> DrawResult {
    let track = samples
        .iter()
        .map(|sample| (sample.pose.x.hypot(sample.pose.y), sample.pose.z))
        .collect();
    let ranges = with_equal_scales(30.0..290.0, -160.0..190.0, 1.04);
    let names = ("distance from the axis / mm", "z / mm");
    panel(area, "from the side", names, ranges, section(), track)
}

/// Returns the outline of the area that the wrist reaches in a plane through the base's axis: J2
/// and J3 along their limits.
fn section() -> Vec<(f64, f64)> {
    let (limits, arm) = (ArmModel::MAGICIAN.limits, Geometry::default());
    let mut outline = Vec::new();
    let mut add = |j2: f64, j3: f64| {
        let pose = arm.forward(&JointAngles::from([0.0, j2, j3, 0.0]));
        outline.push((pose.x, pose.z));
    };
    let (coupled, steps) = (limits.j2_minus_j3, 60);
    let between =
        |from: f64, to: f64, step: i32| from + (to - from) * f64::from(step) / f64::from(steps);
    let lowest = |j2: f64| limits.j3.min.max(j2 - coupled.max);
    let highest = |j2: f64| limits.j3.max.min(j2 - coupled.min);
    for step in 0..=steps {
        let j2 = between(limits.j2.min, limits.j2.max, step);
        add(j2, lowest(j2));
    }
    for step in 0..=steps {
        add(
            limits.j2.max,
            between(lowest(limits.j2.max), highest(limits.j2.max), step),
        );
    }
    for step in (0..=steps).rev() {
        let j2 = between(limits.j2.min, limits.j2.max, step);
        add(j2, highest(j2));
    }
    for step in (0..=steps).rev() {
        add(
            limits.j2.min,
            between(lowest(limits.j2.min), highest(limits.j2.min), step),
        );
    }
    outline
}

fn joint_speeds(area: &Area<'_>, samples: &[Sample]) -> DrawResult {
    let axes = |sample: &Sample| {
        let [j1, j2, j3, j4] = sample.joints.to_array();
        [j1, j2, j3, j4, sample.rail]
    };
    let speeds: Vec<(f64, [f64; 5])> = samples
        .windows(2)
        .filter_map(|pair| match pair {
            [a, b] if b.at > a.at => {
                let (from, to) = (axes(a), axes(b));
                let speed = std::array::from_fn(|axis| (to[axis] - from[axis]) / (b.at - a.at));
                Some((0.5 * (a.at + b.at), speed))
            }
            _ => None,
        })
        .collect();
    let end = samples.last().map_or(1.0, |sample| sample.at).max(0.01);
    let all = || speeds.iter().flat_map(|(_, speed)| speed.iter().copied());
    let (least, most) = (all().fold(-1.0, f64::min), all().fold(1.0, f64::max));
    let mut chart = ChartBuilder::on(area)
        .caption("joint speeds", ("sans-serif", 15).into_font().color(&INK))
        .margin(8)
        .margin_right(20)
        .x_label_area_size(36)
        .y_label_area_size(48)
        .build_cartesian_2d(0.0..end * 1.14, least * 1.1..most * 1.1)?;
    chart
        .configure_mesh()
        .x_desc("t / s")
        .y_desc("deg/s")
        .max_light_lines(0)
        .bold_line_style(FAINT.mix(0.6))
        .label_style(("sans-serif", 12).into_font().color(&INK))
        .draw()?;
    let with_rail = speeds.iter().any(|(_, speed)| speed[4] != 0.0);
    for (axis, (name, color)) in AXES
        .into_iter()
        .enumerate()
        .take(4 + usize::from(with_rail))
    {
        let line = speeds.iter().map(|(at, speed)| (*at, speed[axis]));
        chart
            .draw_series(LineSeries::new(line, color.stroke_width(2)))?
            .label(name)
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 16, y)], color.stroke_width(2)));
    }
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::UpperRight)
        .background_style(WHITE.mix(0.8))
        .border_style(FAINT)
        .label_font(("sans-serif", 12).into_font().color(&INK))
        .draw()?;
    Ok(())
}
