//! Masks as regions.
//!
//! The arm cannot draw faintly: anything painted or shown at all is drawn in full. So a mask
//! becomes a [`Region`] if each of its shapes either shows (any colour but black) or hides (black).
//! A mask with a shape that does both, such as a gradient to black, is not a region.

use kurbo::Affine;
use usvg::{Group, Mask, MaskType, Node, Paint, Path, Stop};

use super::clip::{Region, Shape};
use super::collector::matrix;
use super::lines::{Closeness, LINE_TOLERANCE, curves, flatten};

/// Opacity below which paint is invisible.
const INVISIBLE_OPACITY: f32 = 1e-3;
/// Opacity above which paint hides everything below. Just below 1, because products of opacities
/// are rounded.
const OPAQUE_OPACITY: f32 = 0.999;

impl Region {
    /// Creates the region of a mask, for content with this transform. `None` if the mask is
    /// gradual.
    pub(super) fn of_mask(mask: &Mask, to: Affine, close: Closeness) -> Option<Self> {
        let mut shapes = Vec::new();
        let how = MaskSettings {
            kind: mask.kind(),
            close,
            solid: true,
        };
        painted(mask.root(), to, &[], how, &mut shapes)?;
        let rect = mask.rect();
        let corners = [
            [rect.left(), rect.top()],
            [rect.right(), rect.top()],
            [rect.right(), rect.bottom()],
            [rect.left(), rect.bottom()],
        ];
        let corners = corners.map(|[x, y]| {
            let at = to * kurbo::Point::new(x.into(), y.into());
            [at.x, at.y]
        });
        let mut also = vec![Self::inside(&corners, close.near)];
        if let Some(outer) = mask.mask() {
            also.push(Self::of_mask(outer, to, close)?);
        }
        Some(Self::painted(shapes, also))
    }
}

#[derive(Clone, Copy)]
struct MaskSettings {
    kind: MaskType,
    close: Closeness,
    /// True while all enclosing groups are fully opaque.
    solid: bool,
}

/// Effect of a paint in a mask.
#[derive(Clone, Copy, PartialEq)]
enum PaintEffect {
    Nothing,
    Show,
    Hide,
}

fn painted(
    group: &Group,
    to: Affine,
    within: &[Region],
    how: MaskSettings,
    shapes: &mut Vec<(Shape, bool)>,
) -> Option<()> {
    for node in group.children() {
        match node {
            Node::Group(group) => {
                if group.opacity().get() < INVISIBLE_OPACITY {
                    continue;
                }
                let own = to * matrix(group.transform());
                let mut inner = within.to_vec();
                if let Some(clip) = group.clip_path() {
                    inner.push(Region::of(clip, own, how.close));
                }
                if let Some(mask) = group.mask() {
                    inner.push(Region::of_mask(mask, own, how.close)?);
                }
                // Below a translucent or masked group black does not hide what is under it.
                let how = MaskSettings {
                    solid: how.solid
                        && group.opacity().get() > OPAQUE_OPACITY
                        && group.mask().is_none(),
                    ..how
                };
                painted(group, own, &inner, how, shapes)?;
            }
            Node::Path(path) => path_of(path, to, within, how, shapes)?,
            Node::Text(text) => painted(text.flattened(), to, within, how, shapes)?,
            Node::Image(_) => return None,
        }
    }
    Some(())
}

fn path_of(
    path: &Path,
    to: Affine,
    within: &[Region],
    how: MaskSettings,
    shapes: &mut Vec<(Shape, bool)>,
) -> Option<()> {
    if !path.is_visible() {
        return Some(());
    }
    let fill = path
        .fill()
        .map(|fill| (fill.paint(), fill.opacity().get(), fill.rule()));
    if let Some((paint, opacity, rule)) = fill {
        let does = effect_of(paint, opacity, how)?;
        if does != PaintEffect::Nothing {
            let outline = flatten(&curves(path.data(), to), how.close.tolerance, true);
            shapes.push((
                Shape::new(&outline, rule, within, how.close.near),
                does == PaintEffect::Show,
            ));
        }
    }
    if let Some(stroke) = path.stroke() {
        let does = effect_of(stroke.paint(), stroke.opacity().get(), how)?;
        if does != PaintEffect::Nothing {
            // tiny-skia flattens caps and joins, so ask for the precision that they need on the
            // sheet.
            let [a, b, c, d, ..] = to.as_coeffs();
            let scale = libm::hypot(a, b).max(libm::hypot(c, d)).max(1.0);
            let scale = (scale * LINE_TOLERANCE / how.close.near) as f32;
            let outline = path.data().stroke(&stroke.to_tiny_skia(), scale)?;
            let outline = flatten(&curves(&outline, to), how.close.tolerance, true);
            let rule = usvg::FillRule::NonZero;
            shapes.push((
                Shape::new(&outline, rule, within, how.close.near),
                does == PaintEffect::Show,
            ));
        }
    }
    Some(())
}

/// Returns the effect of a paint; `None` if it differs from place to place.
fn effect_of(paint: &Paint, opacity: f32, how: MaskSettings) -> Option<PaintEffect> {
    match paint {
        Paint::Color(color) => Some(effect_of_color(*color, opacity, how)),
        Paint::LinearGradient(gradient) => effect_of_stops(gradient.stops(), opacity, how),
        Paint::RadialGradient(gradient) => effect_of_stops(gradient.stops(), opacity, how),
        Paint::Pattern(_) => None,
    }
}

fn effect_of_stops(stops: &[Stop], opacity: f32, how: MaskSettings) -> Option<PaintEffect> {
    let mut does = stops
        .iter()
        .map(|stop| effect_of_color(stop.color(), opacity * stop.opacity().get(), how));
    let first = does.next()?;
    does.all(|other| other == first).then_some(first)
}

fn effect_of_color(color: usvg::Color, opacity: f32, how: MaskSettings) -> PaintEffect {
    let light = match how.kind {
        MaskType::Alpha => 1.0,
        MaskType::Luminance => {
            let [red, green, blue] = [color.red, color.green, color.blue].map(f32::from);
            (0.2125 * red + 0.7154 * green + 0.0721 * blue) / 255.0
        }
    };
    if opacity < INVISIBLE_OPACITY {
        PaintEffect::Nothing
    } else if light > INVISIBLE_OPACITY {
        PaintEffect::Show
    } else if opacity > OPAQUE_OPACITY && how.solid {
        PaintEffect::Hide
    } else {
        PaintEffect::Nothing
    }
}
