//! The one font that texts are written with, so that a drawing is the same on every machine.

use std::sync::{Arc, LazyLock};

use usvg::FontResolver;
use usvg::fontdb::{Database, ID};

/// Its name.
pub(crate) const NAME: &str = "Roboto";
static ROBOTO: &[u8] = include_bytes!("../fonts/Roboto-Regular.ttf");

static DATABASE: LazyLock<Arc<Database>> = LazyLock::new(|| {
    let mut database = Database::new();
    let mut font = ROBOTO.to_vec();
    let shrunk = shrink_notdef(&mut font);
    debug_assert!(shrunk.is_some(), "the tables of the font");
    database.load_font_data(font);
    Arc::new(database)
});

/// The glyph `.notdef` as it lies in `glyf`: a triangle of one unit, too small to be seen. One contour, its box, its last point, no
/// instructions, three points of the curve whose steps are a byte each and positive.
const SPECK: [u8; 23] = [
    0, 1, 0, 0, 0, 0, 0, 1, 0, 1, 0, 2, 0, 0, 0x37, 0x37, 0x37, 0, 1, 0, 0, 0, 1,
];

/// Replaces `.notdef` (glyph 0) by a [`SPECK`]. It stands for every character that the font lacks, and is a box that must not
/// be drawn. usvg's text layout cannot leave it out, and drops a text without any outline without a word.
fn shrink_notdef(font: &mut [u8]) -> Option<()> {
    let word = |font: &[u8], at: usize| {
        let bytes = font.get(at..at.checked_add(2)?)?;
        Some(u16::from_be_bytes(bytes.try_into().ok()?))
    };
    let long = |font: &[u8], at: usize| {
        let bytes = font.get(at..at.checked_add(4)?)?;
        Some(u32::from_be_bytes(bytes.try_into().ok()?) as usize)
    };
    let table = |font: &[u8], tag: &[u8; 4]| {
        let count = usize::from(word(font, 4)?);
        let mut records = (0..count).map(|record| 12 + 16 * record);
        let record = records.find(|at| font.get(*at..at + 4) == Some(tag))?;
        long(font, record + 8)
    };
    // Whether places in `glyf` are told in 4 bytes, or halved in 2.
    let halved = word(font, table(font, b"head")? + 50)? == 0;
    let places = table(font, b"loca")?;
    let place = |nth: usize| match halved {
        true => Some(2 * usize::from(word(font, places + 2 * nth)?)),
        false => long(font, places + 4 * nth),
    };
    let (from, to) = (place(0)?, place(1)?);
    let glyphs = table(font, b"glyf")?;
    let glyph = font.get_mut(glyphs + from..glyphs + to)?;
    glyph.get_mut(..SPECK.len())?.copy_from_slice(&SPECK);
    Some(())
}

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
