//! Synthetic TrueType fonts with advances and no visible glyphs.

use std::collections::BTreeMap;

use crate::font::SPECK_GLYPH;
use crate::lettering::SvgFont;

/// Units per em: the largest value that the format allows.
pub(super) const UNITS_PER_EM: f64 = 16384.0;
/// Ascent, in these units.
const ASCENT: i16 = 13107;
/// Descent, in these units.
const DESCENT: i16 = -3277;
/// Size of a glyph in `glyf`, bytes. It is a speck, because usvg drops a text without any outline.
/// Glyphs are aligned to four bytes.
const GLYPH_SIZE: usize = SPECK_GLYPH.len().next_multiple_of(4);

/// Builds a font with the characters and advances of another one. `None` if that has no characters.
pub(super) fn of(font: &SvgFont) -> Option<Vec<u8>> {
    let scale = UNITS_PER_EM / font.em();
    let known = font.advances();
    let advances = known.map(|(character, advance)| {
        let advance = (advance * scale).round().clamp(0.0, f64::from(u16::MAX));
        (u32::from(character), advance as u16)
    });
    let mut advances: BTreeMap<u32, u16> = advances.collect();
    // Glyph 0 is reserved for missing characters, so the largest code points must go.
    while advances.len() >= usize::from(u16::MAX) {
        advances.pop_last();
    }
    let count = u16::try_from(advances.len()).ok()?.checked_add(1)?;
    let widest = advances.values().copied().max()?;

    let mut cmap = Table::default();
    cmap.words(&[0, 1, 3, 10]).long(12);
    let groups = u32::from(count) - 1;
    cmap.words(&[12, 0])
        .long(16 + 12 * groups)
        .long(0)
        .long(groups);
    for (glyph, character) in (1..).zip(advances.keys()) {
        cmap.long(*character).long(*character).long(glyph);
    }

    let mut glyf = Table::default();
    let mut loca = Table::default();
    for glyph in 0..u32::from(count) {
        loca.long(glyph * GLYPH_SIZE as u32);
        glyf.0.extend(SPECK_GLYPH);
        glyf.0.resize((glyph as usize + 1) * GLYPH_SIZE, 0);
    }
    loca.long(u32::from(count) * GLYPH_SIZE as u32);

    let mut head = Table::default();
    head.long(0x1_0000).long(0x1_0000).long(0).long(0x5F0F_3CF5);
    head.words(&[0, UNITS_PER_EM as u16])
        .long(0)
        .long(0)
        .long(0)
        .long(0);
    head.words(&[0, 0, 1, 1, 0, 8, 2, 1, 0]);

    let mut hhea = Table::default();
    hhea.long(0x1_0000);
    hhea.words(&[ASCENT as u16, DESCENT as u16, 0, widest, 0, 0, 1, 1, 0, 0]);
    hhea.words(&[0, 0, 0, 0, 0, count]);

    let mut hmtx = Table::default();
    hmtx.words(&[0, 0]);
    for advance in advances.values() {
        hmtx.words(&[*advance, 0]);
    }

    let mut maxp = Table::default();
    maxp.long(0x1_0000).words(&[count, 3, 1, 0, 0, 1]);
    maxp.words(&[0; 8]);

    Some(file(&[
        (*b"cmap", cmap),
        (*b"glyf", glyf),
        (*b"head", head),
        (*b"hhea", hhea),
        (*b"hmtx", hmtx),
        (*b"loca", loca),
        (*b"maxp", maxp),
    ]))
}

#[derive(Default)]
struct Table(Vec<u8>);

impl Table {
    fn words(&mut self, words: &[u16]) -> &mut Self {
        self.0
            .extend(words.iter().flat_map(|word| word.to_be_bytes()));
        self
    }

    fn long(&mut self, long: u32) -> &mut Self {
        self.0.extend(long.to_be_bytes());
        self
    }
}

/// Builds a font file. Tables must be sorted by tag.
fn file(tables: &[([u8; 4], Table)]) -> Vec<u8> {
    let mut head = Table::default();
    // Parameters of a binary search that today's readers ignore.
    head.long(0x1_0000).words(&[tables.len() as u16, 64, 2, 48]);
    let mut at = 12 + 16 * tables.len();
    let mut body = Vec::new();
    for (tag, table) in tables {
        head.0.extend(tag);
        head.long(0).long(at as u32).long(table.0.len() as u32);
        let padded = table.0.len().next_multiple_of(4);
        body.extend(&table.0);
        body.resize(body.len() + padded - table.0.len(), 0);
        at += padded;
    }
    head.0.extend(body);
    head.0
}
