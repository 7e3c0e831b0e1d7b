//! The one font that texts are written with, so that a drawing is the same on every machine.

use std::sync::{Arc, LazyLock};

use usvg::fontdb::{Database, ID};
use usvg::{FontFamily, FontResolver, FontStyle, Text};

/// Its name.
pub(crate) const NAME: &str = "Roboto";
static ROBOTO: &[u8] = include_bytes!("../../../fonts/Roboto-Regular.ttf");

static DATABASE: LazyLock<Arc<Database>> = LazyLock::new(|| {
    let mut database = Database::new();
    database.load_font_data(ROBOTO.to_vec());
    Arc::new(database)
});

pub(crate) fn database() -> Arc<Database> {
    Arc::clone(&DATABASE)
}

/// Whatever is asked for, it is this one.
pub(crate) fn resolver() -> FontResolver<'static> {
    FontResolver {
        select_font: Box::new(|_, database| only(database)),
        select_fallback: Box::new(|_, _, _| None),
    }
}

fn only(database: &Database) -> Option<ID> {
    database.faces().next().map(|face| face.id)
}

/// The characters of a text that the font does not have, each once.
pub(super) fn missing(text: &Text) -> String {
    let mut missing = String::new();
    let spans = text.layouted().iter().filter(|span| span.visible);
    for glyph in spans.flat_map(|span| &span.positioned_glyphs) {
        if glyph.id.0 == 0 {
            for character in glyph.text.chars() {
                if !missing.contains(character) {
                    missing.push(character);
                }
            }
        }
    }
    missing
}

/// How a text was to look and does not: another font, bold, italic.
pub(super) fn differences(text: &Text) -> Vec<String> {
    let mut asked = Vec::new();
    let spans = text.chunks().iter().flat_map(|chunk| chunk.spans());
    for font in spans.map(|span| span.font()) {
        let other = match font.families().first() {
            Some(FontFamily::Named(name)) if !name.eq_ignore_ascii_case(NAME) => Some(name.clone()),
            _ => None,
        };
        let bold = (font.weight() >= 600).then(|| "bold".to_owned());
        let italic = (font.style() != FontStyle::Normal).then(|| "italic".to_owned());
        for wish in [other, bold, italic].into_iter().flatten() {
            if !asked.contains(&wish) {
                asked.push(wish);
            }
        }
    }
    asked
}
