//! Picture of a run: where the tool really was, and what it moved.

use magician_host::Geometry;
use magician_motion::{ArmModel, Pose};
use magician_program::toolpath::{Layer, StrokeKind, Track};
use magician_program::{Reach, Surface};
use magician_sim::scenario::Color;

use super::{ArmView, BASE_BODY, Body, BodyState, HEAD_HEIGHT, above, draw_header, side};
use crate::layers::PathStyle;
use crate::legend::{Legend, Sign};
use crate::panel::{Extent, MARGIN, Panel, TICK_SPACE};
use crate::svg::palette::{CARGO, INK, PAPER};
use crate::svg::{Anchor, Svg, TextStyle, lines, path, signed};
use crate::{ground, layers, section};

/// Scale of both views.
const SCALE: f64 = 0.37;
/// Smallest part shown from above, mm, without its margin. Runs beyond it widen the view.
const MIN_ABOVE_PART: [[f64; 2]; 2] = [[-78.0, -228.0], [328.0, 228.0]];
/// Smallest part shown from the side, mm, likewise.
const MIN_SIDE_PART: [[f64; 2]; 2] = [[12.0, -158.0], [338.0, 228.0]];
/// Height of the name of a view, mm.
const VIEW_NAME_HEIGHT: f64 = 4.0;
/// Tolerance for simplifying the tool's path, mm: a fifth of its line width.
const PATH_TOLERANCE: f64 = 0.1;

/// A run to draw.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct RunView {
    /// Positions of the tool, in order of time.
    pub readings: Vec<RunReading>,
    /// Objects that were moved.
    pub objects: Vec<MovedObject>,
    /// Height at which the tool touches the table, mm; `None` without a table.
    pub table: Option<f64>,
    /// Name of the arm's final position.
    pub place: String,
}

/// Position of the tool at an instant, as the arm reported it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RunReading {
    /// X, y and z, mm.
    pub at: [f64; 3],
    /// True if it held something.
    pub holds: bool,
}

/// A box that a run has moved.
#[derive(Clone, Debug, PartialEq)]
pub struct MovedObject {
    /// Name, one or two letters.
    pub name: String,
    /// Length, width and height, mm.
    pub size: [f64; 3],
    /// Middle of its underside before the run: x, y and z, mm.
    pub from: [f64; 3],
    /// Middle of its underside after the run: x, y and z, mm.
    pub to: [f64; 3],
}

impl MovedObject {
    /// Returns the object before and after.
    fn bodies(&self) -> [Body; 2] {
        let cargo = Color::parse(CARGO).unwrap_or(Color::GREY);
        let states = [
            (self.from, Color([255; 3]), BodyState::Stands),
            (self.to, cargo, BodyState::Moved),
        ];
        states.map(|([x, y, z], color, state)| Body {
            name: self.name.clone(),
            size: self.size,
            place: [x, y, z, 0.0],
            color,
            state,
        })
    }
}

/// Draws the picture.
pub(super) fn draw(view: &ArmView, run: &RunView) -> String {
    let [left, top] = [
        MARGIN + TICK_SPACE[0],
        MARGIN + HEAD_HEIGHT + VIEW_NAME_HEIGHT,
    ];
    let panel = |part, corner, id| Panel {
        part,
        corner,
        scale: SCALE,
        id,
    };
    let mut extents = [MIN_ABOVE_PART, MIN_SIDE_PART].map(|corners| {
        let mut extent = Extent::default();
        for corner in corners {
            extent.show(corner);
        }
        extent
    });
    let readings = run.readings.iter().map(|reading| reading.at);
    let objects = { run.objects.iter() }.flat_map(|object| [object.from, object.to]);
    for [x, y, z] in readings.chain(objects) {
        extents[0].show([x, y]);
        extents[1].show([libm::hypot(x, y), z]);
    }
    let [ground, plane] = extents.map(Extent::part);
    let from_above = panel(ground, [left, top], "above");
    let [width, height] = from_above.size();
    let aside = panel(plane, [left + width + MARGIN + TICK_SPACE[0], top], "side");
    let right = aside.corner[0] + aside.size()[0];
    let foot = top + height.max(aside.size()[1]) + TICK_SPACE[1] + 2.0;
    let highest = { run.objects.iter() }.map(|object| object.to[2] + object.size[2]);
    let height = highest.reduce(f64::max);
    let legend = Legend::new(entries(run, height), &[], right - left);
    let size = [right + MARGIN, foot + legend.height() + MARGIN - 2.0];

    let mut svg = Svg::page(size, "mm", &view.title);
    let arm = Geometry::magician(view.tool);
    let pose = arm.forward(&view.joints);
    draw_header(&mut svg, left, view, &pose);
    let bodies: Vec<[Body; 2]> = run.objects.iter().map(MovedObject::bodies).collect();
    let layers = layers_of(&run.readings);
    let shown = Shown {
        view,
        run,
        arm: &arm,
        pose,
        bodies: &bodies,
        layers: &layers,
    };
    shown.above(&mut svg, &from_above, height);
    shown.side(&mut svg, &aside);
    legend.draw(&mut svg, [left, foot]);
    svg.finish()
}

/// Contents of both views.
struct Shown<'r> {
    view: &'r ArmView,
    run: &'r RunView,
    arm: &'r Geometry,
    pose: Pose,
    bodies: &'r [[Body; 2]],
    layers: &'r [Layer],
}

impl Shown<'_> {
    /// Iterates over all objects before, then all after.
    fn all_bodies(&self) -> impl Iterator<Item = &Body> {
        let [before, after] = [0, 1].map(|nth| self.bodies.iter().map(move |both| &both[nth]));
        before.chain(after)
    }

    fn above(&self, svg: &mut Svg, panel: &Panel, height: Option<f64>) {
        name(svg, panel, "From above");
        panel.begin(svg);
        let anywhere = section::sector(self.arm, &ArmModel::MAGICIAN.certain);
        ground::reach(svg, panel, &[anywhere]);
        if let Some(height) = height {
            for ring in Reach::new(self.arm.tool, Surface::level(height), 0.0).outline() {
                let ring = ring.into_iter().map(|point| panel.at(point));
                svg.path(&path(ring, true), &ground::OUTLINE_ATTRIBUTES);
            }
        }
        panel.grid(svg);
        ground::base(svg, panel);
        text(
            svg,
            panel.at([0.0, -BASE_BODY[0] + 12.0]),
            "base",
            Anchor::Middle,
        );
        for body in self.all_bodies() {
            above::body(svg, panel, body);
        }
        above::links(svg, panel, self.arm, &self.view.joints);
        let data = |layer: &Layer| lines(layer.above.lines(), |point| panel.at(point));
        layers::draw(svg, self.layers, PathStyle::Run, data);
        for body in self.all_bodies() {
            let [x, y, ..] = body.place;
            let [dx, dy] = [body.size[0], body.size[1]].map(|side| side / 4.0);
            text(
                svg,
                panel.at([x - dx, y + dy - 3.0]),
                &body.name,
                Anchor::Middle,
            );
        }
        self.tip(svg, panel.at([self.pose.x, self.pose.y]));
        panel.end(svg);
        panel.draw_labels(svg, "X / mm", "Y / mm");
    }

    fn side(&self, svg: &mut Svg, panel: &Panel) {
        name(svg, panel, "From the side");
        panel.begin(svg);
        section::draw(svg, panel, self.arm);
        panel.grid(svg);
        side::foot(svg, panel);
        if let Some(height) = self.run.table {
            side::table(svg, panel, height, f64::INFINITY);
            let [right, _] = panel.part[1];
            let label = [f64::midpoint(BASE_BODY[0], right), height - 22.0];
            let what = "table, where the tool touches it";
            text(svg, panel.at(label), what, Anchor::Middle);
        }
        for body in self.all_bodies() {
            side::body(svg, panel, body);
        }
        side::links(svg, panel, self.arm, &self.view.joints);
        let data = |layer: &Layer| lines(layer.side.lines(), |point| panel.at(point));
        layers::draw(svg, self.layers, PathStyle::Run, data);
        let Pose { x, y, z, .. } = self.pose;
        self.tip(svg, panel.at([libm::hypot(x, y), z]));
        panel.end(svg);
        panel.draw_labels(svg, "distance from the base axis / mm", "Z / mm");
    }

    /// Draws the tip of the tool on top of its path, with the name of the position.
    fn tip(&self, svg: &mut Svg, [x, y]: [f64; 2]) {
        above::tip(svg, [x, y]);
        text(svg, [x + 2.6, y - 2.2], &self.run.place, Anchor::Start);
    }
}

/// Returns the path of the tool in two layers, empty and holding. Each stretch begins where the
/// previous one ended.
fn layers_of(readings: &[RunReading]) -> [Layer; 2] {
    let mut layers = [StrokeKind::Nothing, StrokeKind::Carried].map(|mark| Layer {
        mark,
        above: Track::new(PATH_TOLERANCE),
        side: Track::new(PATH_TOLERANCE),
    });
    let [empty, carried] = &mut layers;
    for (from, to) in readings.iter().zip(readings.iter().skip(1)) {
        let layer = if to.holds { &mut *carried } else { &mut *empty };
        let [from, to] = [from.at, to.at];
        layer.above.begin([from[0], from[1]]);
        layer.above.line_to([to[0], to[1]]);
        let side_view = |[x, y, z]: [f64; 3]| [libm::hypot(x, y), z];
        layer.side.begin(side_view(from));
        layer.side.line_to(side_view(to));
    }
    for layer in &mut layers {
        layer.above.settle();
        layer.side.settle();
    }
    layers
}

fn entries(run: &RunView, height: Option<f64>) -> Vec<(Sign, String)> {
    let line = |mark| Sign::Line(mark, PathStyle::Run);
    let mut entries = vec![
        (line(StrokeKind::Nothing), "with nothing held".to_owned()),
        (line(StrokeKind::Carried), "with something held".to_owned()),
    ];
    if let Some(object) = run.objects.first() {
        let [before, after] = object.bodies().map(|body| body.edge());
        entries.push((Sign::Object(PAPER, before), "object, before".to_owned()));
        entries.push((Sign::Object(CARGO, after), "object, after".to_owned()));
    }
    entries.push((Sign::Area, "within reach at some height".to_owned()));
    entries.extend(height.map(|height| {
        let label = format!("within reach at z = {} mm", signed(height));
        (Sign::Outline, label)
    }));
    entries
}

/// Writes the name of a view above its frame.
fn name(svg: &mut Svg, panel: &Panel, name: &str) {
    let style = TextStyle {
        size: 3.6,
        colour: INK,
        anchor: Anchor::Start,
        rim: false,
    };
    let [left, top] = panel.corner;
    svg.text([left, top - 1.6], name, &style);
}

/// Writes a word in a view, legible on lines.
fn text(svg: &mut Svg, at: [f64; 2], text: &str, anchor: Anchor) {
    let style = TextStyle {
        size: 2.8,
        colour: INK,
        anchor,
        rim: true,
    };
    svg.text(at, text, &style);
}

#[cfg(test)]
mod tests {
    use magician_host::{JointAngles, ToolBias};

    use super::*;
    use crate::Snapshot;

    fn reading(at: [f64; 3], holds: bool) -> RunReading {
        RunReading { at, holds }
    }

    #[test]
    fn stretch_begins_at_the_end_of_the_previous_one() {
        let readings = [
            reading([200.0, 0.0, 0.0], false),
            reading([220.0, 0.0, 0.0], false),
            reading([220.0, 30.0, 0.0], true),
            reading([240.0, 30.0, 0.0], false),
        ];
        let [empty, carried] = layers_of(&readings);
        let lines = |track: &Track| -> Vec<_> { track.lines().map(<[_]>::to_vec).collect() };
        assert_eq!(
            lines(&empty.above),
            [
                vec![[200.0, 0.0], [220.0, 0.0]],
                vec![[220.0, 30.0], [240.0, 30.0]]
            ]
        );
        assert_eq!(lines(&carried.above), [vec![[220.0, 0.0], [220.0, 30.0]]]);
        assert_eq!(lines(&empty.side).len(), 2);
    }

    #[test]
    fn a_run_beyond_the_usual_view_widens_it() {
        let mut view = ArmView::default();
        (view.joints, view.tool) = (JointAngles::HOME, ToolBias::SUCTION);
        let mut run = RunView {
            readings: vec![reading([0.0, 200.0, 0.0], false)],
            ..RunView::default()
        };
        let height = |run: &RunView| -> f64 {
            let svg = Snapshot::of_run(&view, run).to_svg().to_owned();
            let height = svg.split("height=\"").nth(1).unwrap();
            height.split("mm").next().unwrap().parse().unwrap()
        };
        let usual = height(&run);
        run.readings.push(reading([0.0, 300.0, 0.0], false));
        // To 320 mm instead of 240.
        assert!((height(&run) - usual - 80.0 * SCALE).abs() < 0.02);
    }

    #[test]
    fn a_run_without_objects_and_table_has_neither_in_its_legend() {
        let svg = Snapshot::of_run(&ArmView::default(), &RunView::default())
            .to_svg()
            .to_owned();
        assert!(!svg.contains("object") && !svg.contains("table") && !svg.contains("NaN"));
        assert!(svg.contains("within reach at some height"));
    }
}
