//! Lines of a drawing: tidied, filled, put in order, laid on the sheet.

use magician_host::{Given, Setting};

use super::{Laid, Setup, Work};
use crate::artwork::{Order, Tidy};
use crate::raster::Trace;
use crate::{Artwork, Content, Diagnostic, DiagnosticCode};

impl Setup {
    /// An image that is drawn as its outlines, and lines in the order in which they are drawn.
    pub(super) fn lines_of(
        &self,
        content: Content,
    ) -> Result<(Content, Vec<Diagnostic>), Diagnostic> {
        let mut artwork = match (content, &self.work) {
            (Content::Image(image), Work::Draw(trace)) => image.outlines(&Trace {
                size: self.size,
                ..trace.clone()
            })?,
            (Content::Artwork(artwork), _) => artwork,
            (content, _) => return Ok((content, Vec::new())),
        };
        let mut notes = Vec::new();
        artwork = self.divided(artwork, &mut notes)?;
        // Lengths are those of what is drawn, and not of the file.
        let scale = self.placement.scale;
        let tidy = Tidy {
            merge: self.tidy.merge / scale,
            simplify: self.tidy.simplify / scale,
            ..self.tidy
        };
        let repeated = artwork.tidy(&tidy).repeated;
        if repeated > 0 {
            let lines = if repeated == 1 { "line" } else { "lines" };
            let what = format!("drawn once, though it is there twice: {repeated} {lines}");
            let note = Diagnostic::of_file(what).coded(DiagnosticCode::LeftOut);
            notes.push(note.remedy(
                (Setting::Dedupe, Given::Off),
                "draws it as often as it is there",
            ));
        }
        // What is filled has its lines when it is known how large it is.
        if !artwork.areas.is_empty() {
            return Ok((Content::Artwork(artwork), notes));
        }
        let order = self.order_of(&artwork);
        let saving = artwork.put_in_order(&order);
        let reordered = (saving.before_mm - saving.after_mm >= 1.0).then(|| {
            let (before, after) = (saving.before_mm, saving.after_mm);
            let what = format!(
                "drawn in another order: {after:.0} mm of travel between its lines instead of \
                    {before:.0} mm"
            );
            let note = Diagnostic::of_file(what).coded(DiagnosticCode::Reordered);
            note.remedy((Setting::Order, Given::Off), "keeps the order of the file")
        });
        notes.extend(reordered);
        Ok((Content::Artwork(artwork), notes))
    }

    pub(super) fn order_of(&self, artwork: &Artwork) -> Order {
        match self.order && !artwork.in_order {
            true => Order::default(),
            false => Order::OF_FILE,
        }
    }

    /// Lines on a sheet.
    pub(super) fn drawn(
        &self,
        artwork: &Artwork,
        notes: &mut Vec<Diagnostic>,
    ) -> Result<Laid, Diagnostic> {
        let marking = self.marking();
        let (mut placed, misfit) = artwork.laid(&self.layout()?, &marking)?;
        if !artwork.areas.is_empty() {
            let fill = self.filling.fill(matches!(self.work, Work::Engrave(_)));
            let bare = placed.artwork.fill(&fill);
            notes.extend(too_small(bare, fill.spacing));
            if placed.artwork.strokes.is_empty() {
                return Err(
                    Diagnostic::of_file("its shapes are too small to be filled").remedy(
                        (Setting::FillSpacing, Given::Any("MM")),
                        "draws finer lines",
                    ),
                );
            }
            placed.artwork.put_in_order(&self.order_of(artwork));
        }
        let plan = placed.plan(&marking);
        Ok(Laid {
            plan: self.pushed(plan)?,
            scale: placed.scale,
            misfit,
        })
    }
}

/// That some shapes have no lines.
fn too_small(shapes: usize, spacing: f64) -> Option<Diagnostic> {
    let what = match shapes {
        0 => return None,
        1 => "1 shape is".to_owned(),
        shapes => format!("{shapes} shapes are"),
    };
    let message = format!("{what} too small to be filled with lines {spacing} mm apart: left out");
    Some(Diagnostic::of_file(message).coded(DiagnosticCode::LeftOut))
}
