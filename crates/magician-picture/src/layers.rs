//! Style of each kind of line.

use magician_program::toolpath::{Layer, POWER_SHADES, StrokeKind};
use std::borrow::Cow;

use crate::svg::palette::{BURNT, CARRIED, DRAWN, EMPTY, PAPER, UNREACHABLE};
use crate::svg::{Number, Svg};

/// Number of vertices above which travel is drawn solid and thin instead of dashed. Many dashes, or
/// dashes between the lines of an engraving, look like a cloud.
const SOLID_FROM_VERTICES: usize = 600;

/// Kind of picture in which paths are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PathStyle {
    /// A plan: travel is faint.
    Plan,
    /// A run: every path is prominent, because it shows where the tool was.
    Run,
}

/// Draws the layers, marks on top; `data` returns the path data of a layer.
pub(super) fn draw(
    svg: &mut Svg,
    layers: &[Layer],
    path_style: PathStyle,
    data: impl Fn(&Layer) -> String,
) {
    let burns = |layer: &Layer| matches!(layer.mark, StrokeKind::Burn(_));
    let burns = layers.iter().any(burns);
    let mut layers: Vec<&Layer> = layers.iter().collect();
    layers.sort_by_key(|layer| match layer.mark {
        StrokeKind::Nothing => 0,
        StrokeKind::Carried => 1,
        StrokeKind::Burn(shade) => 1 + shade,
        StrokeKind::Ink(_) => 2 + POWER_SHADES,
        StrokeKind::Unreachable => 3 + POWER_SHADES,
    });
    for layer in layers {
        let data = data(layer);
        let (colour, width, opacity, dashes) = style_of(layer.mark, path_style);
        let has_many_lines = burns || layer.above.len() > SOLID_FROM_VERTICES;
        let is_travel = layer.mark == StrokeKind::Nothing && path_style == PathStyle::Plan;
        let crowded = is_travel && has_many_lines;
        let (width, opacity) = if crowded {
            (0.1, 0.3)
        } else {
            (width, opacity)
        };
        let [width, opacity] = [width, opacity].map(|value| Number(value).to_string());
        if layer.mark == StrokeKind::Unreachable {
            draw_casing(svg, &data);
        }
        let mut attributes = vec![
            ("class", css_class(layer.mark)),
            ("fill", "none"),
            ("stroke", &*colour),
            ("stroke-width", &width),
            ("stroke-linecap", line_cap(layer.mark)),
            ("stroke-linejoin", "round"),
        ];
        if opacity != "1" {
            attributes.push(("stroke-opacity", &opacity));
        }
        if let Some(dashes) = dashes.filter(|_| !crowded) {
            attributes.push(("stroke-dasharray", dashes));
        }
        svg.path(&data, &attributes);
    }
}

/// Line cap. Burns have none: where the power changes, overlapping round caps would be darker.
fn line_cap(mark: StrokeKind) -> &'static str {
    match mark {
        StrokeKind::Burn(_) => "butt",
        _ => "round",
    }
}

/// Returns colour, width in mm, opacity and dashes.
pub(super) fn style_of(
    mark: StrokeKind,
    path_style: PathStyle,
) -> (Cow<'static, str>, f64, f64, Option<&'static str>) {
    let (colour, width, opacity, dashes) = match mark {
        StrokeKind::Nothing if path_style == PathStyle::Run => (EMPTY, 0.6, 1.0, None),
        StrokeKind::Nothing => (EMPTY, 0.25, 0.9, Some("1.4 1.2")),
        StrokeKind::Carried => (CARRIED, 0.6, 1.0, None),
        StrokeKind::Ink(Some(color)) => return (color.to_string().into(), 0.5, 1.0, None),
        StrokeKind::Ink(None) => (DRAWN, 0.5, 1.0, None),
        StrokeKind::Burn(shade) => (BURNT, 0.2, shade as f64 / POWER_SHADES as f64, None),
        StrokeKind::Unreachable => (UNREACHABLE, 0.5, 1.0, Some("2 1.2")),
    };
    (colour.into(), width, opacity, dashes)
}

/// CSS class by which programs find the layer.
fn css_class(mark: StrokeKind) -> &'static str {
    match mark {
        StrokeKind::Nothing | StrokeKind::Carried => "travel",
        StrokeKind::Ink(_) => "drawn",
        StrokeKind::Burn(_) => "burnt",
        StrokeKind::Unreachable => "unreachable",
    }
}

/// Draws a white casing, so that the dashes are visible on anything.
pub(super) fn draw_casing(svg: &mut Svg, data: &str) {
    let look = [
        ("fill", "none"),
        ("stroke", PAPER),
        ("stroke-width", "1.1"),
        ("stroke-linecap", "round"),
        ("stroke-linejoin", "round"),
    ];
    svg.path(data, &look);
}
