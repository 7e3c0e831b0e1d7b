//! Without the font: texts are left out, and that is said.

use usvg::{Options, Text};

use super::collector::{NodeContext, StrokeCollector};
use super::notes::Notes;
use super::source::Element;
use crate::{Diagnostic, DiagnosticCode, Missing};

/// The fonts of a drawing: none is used.
#[derive(Clone, Copy)]
pub(super) struct FileFonts;

impl FileFonts {
    #[expect(clippy::unnecessary_wraps, reason = "as where there is a font")]
    pub(super) fn of(_text: &str, _notes: &mut Notes) -> Result<Self, Diagnostic> {
        Ok(Self)
    }
}

/// What texts are laid out with: nothing.
#[derive(Clone, Copy)]
pub(super) struct LaidFonts;

pub(super) fn fonts(_of_file: &FileFonts, _installed: bool) -> LaidFonts {
    LaidFonts
}

pub(super) fn set_up(_options: &mut Options<'_>, _fonts: &LaidFonts, _installed: bool) {}

/// Whether texts may name fonts that are installed.
pub(super) fn names_fonts(_text: &str) -> bool {
    false
}

/// True if a text runs along a path.
pub(super) fn runs_along_paths(_group: &usvg::Group) -> bool {
    false
}

/// Whether a text has characters that no font has.
pub(super) fn lacks_glyphs(_group: &usvg::Group) -> bool {
    false
}

/// What is to be said of a text in the source.
pub(super) fn left_out(text: &Element) -> Option<Diagnostic> {
    let note = text.diagnostic("text is left out: this build has no font (feature text)");
    Some(
        note.coded(DiagnosticCode::LeftOut)
            .with_missing(Some(Missing::Feature("text"))),
    )
}

impl StrokeCollector<'_> {
    /// The library has left it out.
    #[expect(
        clippy::unused_self,
        clippy::unnecessary_wraps,
        reason = "as where there is a font"
    )]
    pub(super) fn text(&mut self, _text: &Text, _outer: &NodeContext) -> Result<(), Diagnostic> {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use crate::{Content, DiagnosticCode, Format, Missing, ReadOptions, read};

    #[test]
    fn lines_are_drawn_and_texts_are_left_out_with_a_note() {
        let svg = r#"<svg xmlns="http://www.w3.org/2000/svg" width="20mm" height="20mm" viewBox="0 0 20 20">
<path d="M1 1h5" stroke="black"/>
<text id="word" x="1" y="9">word</text></svg>"#;
        let reading = read(Format::Svg, svg.as_bytes(), &ReadOptions::default()).unwrap();
        let Content::Artwork(artwork) = reading.content else {
            panic!("a drawing");
        };
        assert_eq!(artwork.strokes.len(), 1);
        let [note] = reading.notes.as_slice() else {
            panic!("{:?}", reading.notes);
        };
        assert_eq!(
            (note.code, note.missing),
            (DiagnosticCode::LeftOut, Some(Missing::Feature("text")))
        );
        assert_eq!((note.origin.line, note.name.as_deref()), (3, Some("word")));
    }
}
