//! The font that texts are written with, so that a drawing is the same on every machine; and those that are installed, for a
//! drawing that names one of them.

use std::sync::{Arc, LazyLock};

#[cfg(feature = "system-fonts")]
use usvg::FontFamily;
use usvg::FontResolver;
use usvg::fontdb::{Database, ID};
#[cfg(feature = "system-fonts")]
use usvg::fontdb::{Family, Query, Weight};

/// Family of the font that is built in.
pub(crate) const NAME: &str = "Roboto";
static ROBOTO: &[u8] = include_bytes!("../fonts/Roboto-Regular.ttf");

static DATABASE: LazyLock<Arc<Database>> = LazyLock::new(|| Arc::new(bundled()));

#[cfg(feature = "system-fonts")]
static INSTALLED: LazyLock<Arc<Database>> = LazyLock::new(|| {
    let mut database = bundled();
    database.load_system_fonts();
    Arc::new(database)
});

/// With our font alone, which comes first.
fn bundled() -> Database {
    let mut database = Database::new();
    let mut font = ROBOTO.to_vec();
    let shrunk = shrink_notdef(&mut font);
    debug_assert!(shrunk.is_some(), "the tables of the font");
    database.load_font_data(font);
    database
}

/// The glyph `.notdef` as it lies in `glyf`: a triangle of one unit, too small to be seen. One contour, its box, its last point, no
/// instructions, three points of the curve whose steps are a byte each and positive.
pub(crate) const SPECK: [u8; 23] = [
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
    let place = |nth: usize| {
        if halved {
            Some(2 * usize::from(word(font, places + 2 * nth)?))
        } else {
            long(font, places + 4 * nth)
        }
    };
    let (from, to) = (place(0)?, place(1)?);
    let glyphs = table(font, b"glyf")?;
    let glyph = font.get_mut(glyphs + from..glyphs + to)?;
    glyph.get_mut(..SPECK.len())?.copy_from_slice(&SPECK);
    Some(())
}

/// Database with the font that is built in, and no other.
pub(crate) fn database() -> Arc<Database> {
    Arc::clone(&DATABASE)
}

/// Returns the options with which usvg reads an SVG: our font and no other, so that a picture is the
/// same on every machine.
#[must_use]
pub fn svg_options() -> usvg::Options<'static> {
    usvg::Options {
        font_family: NAME.to_owned(),
        font_resolver: resolver(),
        fontdb: database(),
        ..usvg::Options::default()
    }
}

/// Resolver that takes the font that is built in for every family.
pub(crate) fn resolver() -> FontResolver<'static> {
    FontResolver {
        select_font: Box::new(|_, database| first(database)),
        select_fallback: Box::new(|_, _, _| None),
    }
}

/// Our font, which comes first.
pub(crate) fn first(database: &Database) -> Option<ID> {
    database.faces().next().map(|face| face.id)
}

/// Our font and the installed ones.
#[cfg(feature = "system-fonts")]
pub(crate) fn installed() -> Arc<Database> {
    Arc::clone(&INSTALLED)
}

/// The first family that is installed; ours for what is asked for in general, such as `sans-serif`.
#[cfg(feature = "system-fonts")]
pub(crate) fn installed_resolver() -> FontResolver<'static> {
    FontResolver {
        select_font: Box::new(|font, database| {
            let ours = first(database);
            for family in font.families() {
                let FontFamily::Named(name) = family else {
                    return ours;
                };
                let style = match font.style() {
                    usvg::FontStyle::Normal => usvg::fontdb::Style::Normal,
                    usvg::FontStyle::Italic => usvg::fontdb::Style::Italic,
                    usvg::FontStyle::Oblique => usvg::fontdb::Style::Oblique,
                };
                let found = database.query(&Query {
                    families: &[Family::Name(name)],
                    weight: Weight(font.weight()),
                    style,
                    ..Query::default()
                });
                if found.is_some() {
                    return found;
                }
            }
            ours
        }),
        // To look into every installed font for a character takes minutes where there are many.
        select_fallback: Box::new(|_, used, database| {
            first(database).filter(|ours| !used.contains(ours))
        }),
    }
}

/// Whether a font of a database is ours.
pub(crate) fn is_bundled(database: &Database, font: ID) -> bool {
    first(database) == Some(font)
}

#[cfg(all(test, feature = "system-fonts"))]
mod tests {
    use std::collections::{BTreeSet, HashMap};
    use std::sync::Arc;

    use usvg::fontdb::ID;

    use crate::{Content, Format, ReadOptions, SystemFonts, TextLines, read};

    /// Height in mm of an H of 60 units that is written in single lines in a family, and what is noted.
    fn height_in_single_lines(family: &str) -> (f64, String) {
        let options = ReadOptions {
            system_fonts: SystemFonts::On,
            text_lines: TextLines::Stroke,
            ..ReadOptions::default()
        };
        let svg = format!(
            r#"<svg xmlns="http://www.w3.org/2000/svg" width="90mm" height="90mm" viewBox="0 0 90 90"><text y="80" font-size="60" font-family="'{family}'">H</text></svg>"#
        );
        let parsed = read(Format::Svg, svg.as_bytes(), &options).unwrap();
        let Content::Artwork(artwork) = parsed.content else {
            panic!("no drawing");
        };
        let notes: Vec<_> = parsed.notes.iter().map(ToString::to_string).collect();
        let heights = artwork.strokes.iter().flat_map(|stroke| &stroke.points);
        let range = heights.fold([f64::MAX, f64::MIN], |[least, most], at| {
            [least.min(at[1]), most.max(at[1])]
        });
        ((range[1] - range[0]).max(0.0), notes.join("\n"))
    }

    #[test]
    fn every_installed_family_is_written_in_single_lines_as_high_as_its_own_capitals() {
        let installed = super::installed();
        let ours = super::first(&installed);
        let mut files: HashMap<ID, f64> = HashMap::new();
        let mut families = BTreeSet::new();
        let faces = installed.faces().filter(|face| Some(face.id) != ours);
        for (name, _) in faces.filter_map(|face| face.families.first()) {
            families.insert(name.clone());
        }
        if families.is_empty() {
            eprintln!("skipped: no font is installed");
            return;
        }
        for family in &families {
            let (height, notes) = height_in_single_lines(family);
            let query = usvg::fontdb::Query {
                families: &[usvg::fontdb::Family::Name(family)],
                ..usvg::fontdb::Query::default()
            };
            let Some(face) = installed.query(&query) else {
                continue;
            };
            let own = *files.entry(face).or_insert_with(|| {
                let database = Arc::clone(&installed);
                let height = database.with_face_data(face, |data, index| {
                    let font = skrifa::FontRef::from_index(data, index).ok()?;
                    let units = skrifa::MetadataProvider::metrics(
                        &font,
                        skrifa::instance::Size::unscaled(),
                        skrifa::instance::LocationRef::default(),
                    );
                    let cap = crate::lettering::cap_height(&font);
                    Some(60.0 * cap / f64::from(units.units_per_em))
                });
                height.flatten().unwrap_or_default()
            });
            // A family without an H is written in our font, which a note says.
            let written = (height - own).abs() < 0.01 * own || notes.contains("instead of");
            assert!(
                height > 10.0 && written,
                "{family}: {height} mm of {own}; {notes}"
            );
        }
    }

    /// How many points the letters have, and what is noted.
    fn written(family: &str, text: &str, fonts: SystemFonts) -> (usize, String) {
        let options = ReadOptions {
            system_fonts: fonts,
            ..ReadOptions::default()
        };
        let svg = format!(
            r#"<svg xmlns="http://www.w3.org/2000/svg" width="90mm" height="90mm"><text y="90" font-size="60" font-family="{family}">{text}</text></svg>"#
        );
        let parsed = read(Format::Svg, svg.as_bytes(), &options).unwrap();
        let Content::Artwork(artwork) = parsed.content else {
            panic!("no drawing");
        };
        let notes: Vec<_> = parsed.notes.iter().map(ToString::to_string).collect();
        let points = artwork.strokes.iter().map(|stroke| stroke.points.len());
        (points.sum(), notes.join("\n"))
    }

    #[test]
    fn a_family_that_is_installed_is_used_and_others_are_ours() {
        let (ours, note) = written("No Such Family", "Rag", SystemFonts::On);
        assert!(note.contains("instead of No Such Family"), "{note}");
        assert_eq!(
            written("sans-serif", "Rag", SystemFonts::On),
            (ours, String::new())
        );
        // Where there is one with Latin letters at all.
        let installed = super::installed();
        let serif = |family: &&str| family.contains("Serif") && !family.contains("CJK");
        let families = installed.faces().filter_map(|face| face.families.first());
        let Some(family) = families.map(|(name, _)| name.as_str()).find(serif) else {
            return;
        };
        let (own, note) = written(family, "Rag", SystemFonts::On);
        assert!(own != ours && note.is_empty(), "{own} {note}");
        let (off, note) = written(family, "Rag", SystemFonts::Off);
        assert!(off == ours && note.contains("instead of"), "{note}");
        // No box is drawn for what no font has.
        let (lacking, note) = written(family, "Rag\u{E0FF}", SystemFonts::On);
        assert!(lacking == ours && note.contains("U+E0FF"), "{note}");
    }
}
