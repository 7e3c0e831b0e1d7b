//! Fonts for texts in drawings: the bundled font, and the installed ones.
//!
//! By default every text uses the bundled Roboto, so that a drawing looks the same on every
//! machine. The installed fonts are loaded only on request (feature `system-fonts`).

use std::sync::{Arc, LazyLock};

#[cfg(feature = "system-fonts")]
use usvg::FontFamily;
use usvg::FontResolver;
use usvg::fontdb::{Database, ID};
#[cfg(feature = "system-fonts")]
use usvg::fontdb::{Family, Query, Weight};

/// Family of the bundled font.
pub(crate) const BUNDLED_FAMILY: &str = "Roboto";
static BUNDLED_FONT: &[u8] = include_bytes!("../fonts/Roboto-Regular.ttf");

static BUNDLED_DATABASE: LazyLock<Arc<Database>> = LazyLock::new(|| Arc::new(bundled()));

#[cfg(feature = "system-fonts")]
static INSTALLED_DATABASE: LazyLock<Arc<Database>> = LazyLock::new(|| {
    let mut database = bundled();
    database.load_system_fonts();
    Arc::new(database)
});

/// Creates a database whose first and only font is ours.
fn bundled() -> Database {
    let mut database = Database::new();
    let mut font = BUNDLED_FONT.to_vec();
    let shrunk = shrink_notdef(&mut font);
    debug_assert!(shrunk.is_some(), "the tables of the font");
    database.load_font_data(font);
    database
}

/// Replacement for the glyph `.notdef` as stored in `glyf`: a triangle of one unit, too small to be
/// seen.
///
/// The bytes are one contour, its bounding box, its last point, no instructions, and three on-curve
/// points with positive one-byte steps.
pub(crate) const SPECK_GLYPH: [u8; 23] = [
    0, 1, 0, 0, 0, 0, 0, 1, 0, 1, 0, 2, 0, 0, 0x37, 0x37, 0x37, 0, 1, 0, 0, 0, 1,
];

/// Replaces `.notdef` (glyph 0) by a [`SPECK_GLYPH`]. `None` if the font's tables are damaged.
///
/// `.notdef` stands for every character that the font lacks, and Roboto draws it as a box. usvg's
/// text layout cannot skip a glyph, and silently drops a text whose glyphs have no outline at all,
/// so the glyph must stay and must not be visible.
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
    // `indexToLocFormat`: 0 stores offsets into `glyf` halved in 2 bytes, 1 stores them in 4.
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
    glyph
        .get_mut(..SPECK_GLYPH.len())?
        .copy_from_slice(&SPECK_GLYPH);
    Some(())
}

/// Database with only the bundled font.
pub(crate) fn database() -> Arc<Database> {
    Arc::clone(&BUNDLED_DATABASE)
}

/// Returns the options for reading an SVG with usvg: only the bundled font, so that a picture is
/// the same on every machine.
#[must_use]
pub fn svg_options() -> usvg::Options<'static> {
    usvg::Options {
        font_family: BUNDLED_FAMILY.to_owned(),
        font_resolver: resolver(),
        fontdb: database(),
        ..usvg::Options::default()
    }
}

/// Creates a resolver that maps every family to the bundled font.
pub(crate) fn resolver() -> FontResolver<'static> {
    FontResolver {
        select_font: Box::new(|_, database| first_face(database)),
        select_fallback: Box::new(|_, _, _| None),
    }
}

/// The bundled font, which is the first face of every database here.
pub(crate) fn first_face(database: &Database) -> Option<ID> {
    database.faces().next().map(|face| face.id)
}

/// Database with the bundled font and the installed ones.
#[cfg(feature = "system-fonts")]
pub(crate) fn installed() -> Arc<Database> {
    Arc::clone(&INSTALLED_DATABASE)
}

/// Creates a resolver that takes the first installed family. Generic families such as `sans-serif`
/// become the bundled font.
#[cfg(feature = "system-fonts")]
pub(crate) fn installed_resolver() -> FontResolver<'static> {
    FontResolver {
        select_font: Box::new(|font, database| {
            let ours = first_face(database);
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
        // No search through all installed fonts for a missing character: with many fonts it takes
        // minutes.
        select_fallback: Box::new(|_, used, database| {
            first_face(database).filter(|ours| !used.contains(ours))
        }),
    }
}

/// True if a font of a database is the bundled one.
pub(crate) fn is_bundled(database: &Database, font: ID) -> bool {
    first_face(database) == Some(font)
}

#[cfg(all(test, feature = "system-fonts"))]
mod tests {
    use std::collections::{BTreeSet, HashMap};
    use std::sync::Arc;

    use usvg::fontdb::ID;

    use crate::{Content, Format, ReadOptions, SystemFonts, TextLines, read};

    /// Height in mm of an H of 60 units written in single lines, and the notes.
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
    fn single_line_text_has_the_capital_height_of_its_installed_family() {
        let installed = super::installed();
        let ours = super::first_face(&installed);
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
            // A family without an H falls back to the bundled font, with a note.
            let written = (height - own).abs() < 0.01 * own || notes.contains("instead of");
            assert!(
                height > 10.0 && written,
                "{family}: {height} mm of {own}; {notes}"
            );
        }
    }

    /// Number of points of the letters, and the notes.
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
    fn installed_family_is_used_and_others_fall_back_to_the_bundled_font() {
        let (ours, note) = written("No Such Family", "Rag", SystemFonts::On);
        assert!(note.contains("instead of No Such Family"), "{note}");
        assert_eq!(
            written("sans-serif", "Rag", SystemFonts::On),
            (ours, String::new())
        );
        // Only if an installed family has Latin letters.
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
        // Characters that no font has draw no box.
        let (lacking, note) = written(family, "Rag\u{E0FF}", SystemFonts::On);
        assert!(lacking == ours && note.contains("U+E0FF"), "{note}");
    }
}
