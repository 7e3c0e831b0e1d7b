//! The view from above.

use magician::Geometry;

use super::marks::MarkKind;
use super::panel::Panel;
use super::svg::{Anchor, Svg, Type, path};
use super::symbols;
use super::trip::{Layer, Leaves, Trip};
use super::{BASE, FAINT, INK, PreviewOptions, REACH, REACH_EDGE, layers};
use crate::{Reach, Surface};

/// What is left free round what is shown, mm.
const MARGIN: f64 = 12.0;
/// The base is 158 mm square; so much of it is shown at least.
const HALF_BASE: f64 = 79.0;
const SHOWN_BEHIND: f64 = 30.0;
/// The view goes no farther than this from the base, mm.
const FARTHEST: f64 = 420.0;

/// Which part of the plane the view shows: the base, all ways, the sheet.
pub(super) fn part(trip: &mut Trip, options: &PreviewOptions) -> [[f64; 2]; 2] {
    let mut low = [-SHOWN_BEHIND, -HALF_BASE - 6.0];
    let mut high = [120.0, HALF_BASE + 6.0];
    let mut show = |[x, y]: [f64; 2]| {
        low = [low[0].min(x - MARGIN), low[1].min(y - MARGIN)];
        high = [high[0].max(x + MARGIN), high[1].max(y + MARGIN)];
    };
    for layer in &mut trip.layers {
        layer.above.lines().flatten().copied().for_each(&mut show);
    }
    trip.ends
        .into_iter()
        .flatten()
        .for_each(|[x, y, _]| show([x, y]));
    options.sheet.iter().flatten().copied().for_each(&mut show);
    let rounded =
        |value: f64, up: fn(f64) -> f64| (up(value / 10.0) * 10.0).clamp(-FARTHEST, FARTHEST);
    [
        low.map(|value| rounded(value, f64::floor)),
        high.map(|value| rounded(value, f64::ceil)),
    ]
}

/// Draws it.
pub(super) fn draw(
    svg: &mut Svg,
    panel: &Panel,
    trip: &mut Trip,
    options: &PreviewOptions,
    arm: &Geometry,
) {
    panel.begin(svg);
    reach(svg, panel, arm, trip.work.surface());
    base(svg, panel);
    if let Some(sheet) = &options.sheet {
        let data = path(sheet.iter().map(|corner| panel.at(*corner)), true);
        let look = [("fill", "#fff"), ("stroke", FAINT), ("stroke-width", "0.3")];
        svg.path(&data, &look);
    }
    panel.grid(svg);
    let look = |layer: &mut Layer| super::svg::tracks(&mut layer.above, |point| panel.at(point));
    layers::draw(svg, &mut trip.layers, look);
    for mark in &trip.marks {
        let [x, y, _] = mark.at;
        symbols::marks(svg, panel.at([x, y]), mark, true);
    }
    if let Some([start, end]) = trip.ends {
        symbols::ends(svg, [start, end].map(|[x, y, _]| panel.at([x, y])));
    }
    for (step, at) in &trip.complaints {
        if let Some([x, y, _]) = at {
            symbols::complaint(svg, panel, [*x, *y], step + 1);
        }
    }
    panel.end(svg, "X / mm", "Y / mm");
}

/// What the tool can reach on the surface.
fn reach(svg: &mut Svg, panel: &Panel, arm: &Geometry, surface: Option<Surface>) {
    let Some(surface) = surface else {
        return;
    };
    let look = [
        ("fill", REACH),
        ("stroke", REACH_EDGE),
        ("stroke-width", "0.3"),
    ];
    for ring in Reach::new(arm.tool, surface, 0.0).outline() {
        let ring = ring.into_iter().map(|point| panel.at(point));
        svg.path(&path(ring, true), &look);
    }
}

/// The base's footprint and its axis.
fn base(svg: &mut Svg, panel: &Panel) {
    let corners = [[-HALF_BASE, -HALF_BASE], [HALF_BASE, HALF_BASE]];
    let look = [
        ("fill", BASE),
        ("rx", "5"),
        ("stroke", FAINT),
        ("stroke-width", "0.3"),
    ];
    svg.rectangle(corners.map(|corner| panel.at(corner)), &look);
    let axis = panel.at([0.0, 0.0]);
    svg.circle(
        axis,
        5.0,
        &[("fill", "#fff"), ("stroke", FAINT), ("stroke-width", "0.3")],
    );
    svg.circle(axis, 0.8, &[("fill", INK)]);
    let label = Type {
        size: 3.0,
        colour: INK,
        bold: false,
        anchor: Anchor::Middle,
        rim: false,
    };
    svg.text([axis[0], axis[1] + 10.0], "base", &label);
}

/// Which kinds of marks there are.
pub(super) fn kinds(trip: &Trip) -> Vec<MarkKind> {
    let mut kinds: Vec<_> = trip
        .marks
        .iter()
        .flat_map(|mark| mark.kinds.clone())
        .collect();
    kinds.sort();
    kinds.dedup();
    kinds
}

/// Whether there is anything of a sort.
pub(super) fn has(trip: &Trip, sort: impl Fn(Leaves) -> bool) -> bool {
    trip.layers
        .iter()
        .any(|layer| sort(layer.leaves) && !layer.above.is_empty())
}
