//! Lines of a drawing: tidied, filled, ordered, and placed on the sheet.

use magician_host::message;
use magician_host::{Setting, SettingValue};

use super::work_lines::WorkLines;
use super::{LaidPlan, Setup, Work};
use crate::artwork::Order;
use crate::raster::{ImageLines, Size, Trace};
use crate::{Artwork, Content, Diagnostic, DiagnosticCode, Format, Plan, Raster};

/// Search effort for a better order of a shaded image's rows, which are in good order already.
const SHADED_ORDER_EFFORT: u64 = 20_000_000;
/// Longest side of anything the arm can draw, rounded up generously, mm.
const MAX_DRAWN_SIDE: f64 = 1000.0;
/// Accuracy of the first estimate of a fitting size, mm.
const ESTIMATE_ACCURACY: f64 = 0.1;
/// Largest number of times that a file is read: finer chords change the size a little, which in
/// turn changes the chords needed.
const MAX_READINGS: usize = 4;

impl Setup {
    /// Returns the setup with the requested width or height converted to a scale. An image already
    /// has the requested size.
    pub(super) fn with_size_as_scale(&self, content: &Content) -> Result<Self, Diagnostic> {
        let mut setup = self.clone();
        let (axis, wanted) = match self.size {
            Size::Width(width) => (0, width),
            Size::Height(height) => (1, height),
            Size::Natural | Size::Pixel(_) => return Ok(setup),
            #[cfg(not(magician_workspace))]
            _ => unreachable!(),
        };
        let bounds = match content {
            // An image was read at its requested size.
            Content::Image(_) => return Ok(setup),
            Content::TestGrid(grid) => Some([[0.0; 2], grid.size]),
            Content::Artwork(artwork) => artwork.bounds(),
            Content::Plan(plan) => {
                let lines = WorkLines::of(plan, self.placement.pen_z)?;
                lines.artwork.bounds()
            }
            #[cfg(not(magician_workspace))]
            _ => unreachable!(),
        };
        let side = bounds.map_or(0.0, |[least, most]| most[axis] - least[axis]);
        let scale = wanted / side;
        // A horizontal line has height 0, and a division by 0 gives no scale.
        if !(scale > 0.0 && scale.is_finite()) {
            let name = [message!("width"), message!("height")][axis].clone();
            let message = message!(
                "what it draws has no {name}: it cannot become {wanted} mm",
                name,
                wanted
            );
            return Err(Diagnostic::of_file(message));
        }
        setup.placement.scale *= scale;
        // The size is now part of the scale: applying it twice would square it.
        setup.size = Size::Natural;
        Ok(setup)
    }

    /// Returns the content with curves approximated as closely as its drawn size requires. The file
    /// is read again if its chords are too coarse, or far too fine.
    pub(crate) fn with_adequate_curves(
        &self,
        format: Format,
        mut content: Content,
    ) -> Result<Content, Diagnostic> {
        for _ in 0..MAX_READINGS {
            // Content without curves is the same at every size.
            let Some(file) = content.take_curves() else {
                break;
            };
            let scale = self.scale_of(format, &content)?;
            let size = content.longest_side();
            // The arm can draw no larger than this, so no finer chords are needed.
            let scale = if size > 0.0 {
                scale.min(MAX_DRAWN_SIDE / size)
            } else {
                scale
            };
            if !file.is_unfit_for(scale) {
                content.put_curves(file);
                break;
            }
            content = file.read(scale)?;
        }
        Ok(content)
    }

    /// Converts an image to outlines, and puts lines in drawing order.
    pub(super) fn prepare_lines(
        &self,
        content: Content,
    ) -> Result<(Content, Vec<Diagnostic>), Diagnostic> {
        let mut notes = Vec::new();
        let mut artwork = match (content, &self.work) {
            // Shaded styles are drawn later, when the size is known.
            (Content::Image(image), Work::Draw(trace)) if !trace.style.is_shaded() => {
                let image = image.adjusted(&self.adjust);
                let lines_for = |scale| self.trace(trace, scale).lines(&image);
                let mut lines = lines_for(self.placement.scale)?;
                let scale = self.fitted_scale(&lines.artwork);
                // Specks and tolerance refer to the drawn size, so trace again at the smaller
                // scale.
                if scale < self.placement.scale {
                    lines = lines_for(scale)?;
                }
                notes.extend(specks_note(lines.specks, trace.despeckle));
                lines.artwork
            }
            (Content::Image(image), _) => {
                return Ok((Content::Image(image.adjusted(&self.adjust)), notes));
            }
            (Content::Artwork(artwork), _) => artwork,
            (content, _) => return Ok((content, notes)),
        };
        artwork = self.divide(artwork, &mut notes)?;
        let scale = self.fitted_scale(&artwork);
        let repeated = artwork.tidy_to_draw(&self.tidy, scale).repeated;
        notes.extend(duplicates_note(repeated));
        // Filled areas get their lines later, when the size is known.
        if !artwork.areas.is_empty() {
            return Ok((Content::Artwork(artwork), notes));
        }
        let order = self.order_of(&artwork).to_draw(scale);
        let saving = artwork.put_in_order(&order);
        let [before, after] = [saving.before_mm, saving.after_mm].map(|way| way * scale);
        // Less than a millimetre is not worth a note.
        let reordered = (before - after >= 1.0).then(|| {
            let what = message!(
                "drawn in another order: {after:.0} mm of travel between its lines instead of \
                    {before:.0} mm",
                after,
                before
            );
            let note = Diagnostic::of_file(what).coded(DiagnosticCode::Reordered);
            note.remedy(
                (Setting::Order, SettingValue::Off),
                "keeps the order of the file",
            )
        });
        notes.extend(reordered);
        Ok((Content::Artwork(artwork), notes))
    }

    /// Options for drawing an image at this scale: lengths refer to the drawing, not to the file.
    fn trace(&self, trace: &Trace, scale: f64) -> Trace {
        Trace {
            size: self.size,
            ..trace.at_scale(scale)
        }
    }

    /// Scale of the lines, which fitting may make smaller than requested.
    fn fitted_scale(&self, artwork: &Artwork) -> f64 {
        let wanted = self.placement.scale;
        if !self.placement.fit {
            return wanted;
        }
        let marking = self.marking();
        let thinned = artwork.thinned(ESTIMATE_ACCURACY / wanted);
        let largest_scale = |setup: &Self| thinned.largest(&setup.layout().ok()?, &marking);
        match largest_scale(self) {
            Some(scale) if scale >= wanted || !self.placement.turn => scale,
            straight => {
                let turned = largest_scale(&self.turned(90.0)).filter(|_| self.placement.turn);
                straight
                    .into_iter()
                    .chain(turned)
                    .reduce(f64::max)
                    .unwrap_or(wanted)
            }
        }
    }

    /// Tidies the lines of a placed program, if requested.
    pub(super) fn tidied_program(&self, mut plan: Plan, notes: &mut Vec<Diagnostic>) -> Plan {
        if self.tidy_programs {
            notes.extend(duplicates_note(plan.tidy(&self.tidy).repeated));
        }
        plan
    }

    /// Draws an image in a shaded style. The lines are made for the drawn size, because the pen
    /// width does not scale.
    pub(super) fn draw_shaded(
        &self,
        image: &Raster,
        trace: &Trace,
        notes: &mut Vec<Diagnostic>,
    ) -> Result<LaidPlan, Diagnostic> {
        let marking = self.marking();
        let mut layout = self.layout()?;
        if layout.fit {
            let frame = Artwork::frame(image.size(self.size)?);
            layout.scale = frame.placed_with_misfit(&layout, &marking)?.0.scale;
        }
        let scale = layout.scale;
        let trace = self.trace(trace, scale);
        let ImageLines {
            mut artwork,
            specks,
            ..
        } = trace.lines(image)?;
        notes.extend(specks_note(specks, trace.despeckle * scale));
        artwork.tidy_to_draw(&self.tidy, scale);
        if self.order {
            let order = Order {
                effort: SHADED_ORDER_EFFORT,
                ..Order::default()
            };
            artwork.put_in_order(&order.to_draw(scale));
        }
        let (placed, misfit) = artwork.placed_with_misfit(&layout, &marking)?;
        let plan = placed.plan(&marking);
        Ok(LaidPlan {
            plan: self.with_offset(plan, notes)?,
            scale: placed.scale,
            misfit,
        })
    }

    pub(super) fn order_of(&self, artwork: &Artwork) -> Order {
        if self.order && !artwork.in_order {
            Order {
                inside_first: matches!(self.work, Work::Engrave(_)),
                ..Order::default()
            }
        } else {
            Order::OF_FILE
        }
    }

    /// Places lines on a sheet.
    pub(super) fn draw_lines(
        &self,
        artwork: &Artwork,
        notes: &mut Vec<Diagnostic>,
    ) -> Result<LaidPlan, Diagnostic> {
        let marking = self.marking();
        let (mut placed, misfit) = artwork.placed_with_misfit(&self.layout()?, &marking)?;
        if !artwork.areas.is_empty() {
            let fill = self.filling.fill(matches!(self.work, Work::Engrave(_)));
            let unfilled = placed.artwork.fill(&fill);
            notes.extend(too_small_note(unfilled, fill.spacing));
            if placed.artwork.strokes.is_empty() {
                return Err(
                    Diagnostic::of_file(message!("its shapes are too small to be filled")).remedy(
                        (Setting::FillSpacing, SettingValue::Any("MM")),
                        "draws finer lines",
                    ),
                );
            }
            placed.artwork.put_in_order(&self.order_of(artwork));
        }
        let plan = placed.plan(&marking);
        Ok(LaidPlan {
            plan: self.with_offset(plan, notes)?,
            scale: placed.scale,
            misfit,
        })
    }
}

/// Returns the note about duplicate lines, which are drawn once. `None` without any.
fn duplicates_note(repeated: usize) -> Option<Diagnostic> {
    let what = match repeated {
        0 => return None,
        1 => message!("drawn once, though it is there twice: 1 line"),
        count => message!("drawn once, though it is there twice: {count} lines", count),
    };
    let note = Diagnostic::of_file(what).coded(DiagnosticCode::LeftOut);
    let effect = "draws it as often as it is there";
    Some(note.remedy((Setting::Dedupe, SettingValue::Off), effect))
}

/// Returns the note about shapes without fill lines. `None` without any.
fn too_small_note(shapes: usize, spacing: f64) -> Option<Diagnostic> {
    let message = match shapes {
        0 => return None,
        1 => message!(
            "1 shape is too small to be filled with lines {spacing} mm apart: left out",
            spacing
        ),
        shapes => message!(
            "{shapes} shapes are too small to be filled with lines {spacing} mm apart: left out",
            shapes,
            spacing
        ),
    };
    Some(Diagnostic::of_file(message).coded(DiagnosticCode::LeftOut))
}

/// Returns the note about specks of an image, which are not drawn. `None` without any.
fn specks_note(specks: usize, size: f64) -> Option<Diagnostic> {
    let size = (size * 1e6).round() / 1e6;
    let message = match specks {
        0 => return None,
        1 => message!(
            "left out of the image: 1 speck smaller than {size} mm",
            size
        ),
        specks => message!(
            "left out of the image: {specks} specks smaller than {size} mm",
            specks,
            size
        ),
    };
    let note = Diagnostic::of_file(message).coded(DiagnosticCode::LeftOut);
    Some(note.remedy(
        (Setting::Despeckle, SettingValue::Number(0.0)),
        "draws them too",
    ))
}
