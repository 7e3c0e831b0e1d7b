//! The single-line fonts of A. V. Hershey, in the format of James Hurt.
//!
//! A line of the file is a character, from the space on: its number (5 characters), how many pairs follow (3), then the pairs, two
//! characters each, whose coordinates are their codes less that of `R`. The first pair is where it begins and where the next one
//! does; ` R` lifts the pen. y grows downwards, the baseline is at 9, capitals begin at -12.

use std::collections::HashMap;
use std::sync::LazyLock;

use super::{BundledFont, Glyph, Glyphs, compose};

/// What is above the baseline in the files, in their units.
const BASELINE: f64 = 9.0;
/// How high a capital is.
pub(super) const CAP: f64 = 21.0;

/// One of them.
pub(crate) struct Hershey {
    pub(super) style: BundledFont,
    plain: HashMap<char, Glyph>,
}

static SANS: LazyLock<Hershey> = LazyLock::new(|| {
    let file = include_str!("../../fonts/hershey/futural.jhf");
    Hershey::new(BundledFont::Sans, file)
});
static SCRIPT: LazyLock<Hershey> = LazyLock::new(|| {
    let file = include_str!("../../fonts/hershey/scripts.jhf");
    Hershey::new(BundledFont::Script, file)
});
static GOTHIC: LazyLock<Hershey> = LazyLock::new(|| {
    let file = include_str!("../../fonts/hershey/gothiceng.jhf");
    Hershey::new(BundledFont::Gothic, file)
});

impl Hershey {
    pub(super) fn of(style: BundledFont) -> &'static Self {
        match style {
            BundledFont::Sans => &SANS,
            BundledFont::Script => &SCRIPT,
            BundledFont::Gothic => &GOTHIC,
        }
    }

    fn new(style: BundledFont, file: &str) -> Self {
        let glyphs = file.lines().filter_map(glyph);
        Self {
            style,
            plain: (' '..).zip(glyphs).collect(),
        }
    }

    /// A character that the file has.
    pub(super) fn plain(&self, character: char) -> Option<Glyph> {
        self.plain.get(&character).cloned()
    }

    /// The height of small letters without what goes above.
    pub(super) fn x_height(&self) -> f64 {
        match self.style {
            BundledFont::Sans | BundledFont::Gothic => 14.0,
            BundledFont::Script => 9.0,
        }
    }

    /// How far its letters lean to the right for each unit upwards.
    pub(super) fn slant(&self) -> f64 {
        match self.style {
            BundledFont::Sans | BundledFont::Gothic => 0.0,
            BundledFont::Script => 0.35,
        }
    }
}

impl Glyphs for &Hershey {
    fn cap_height(&self) -> f64 {
        CAP
    }

    fn glyph(&self, character: char, _tolerance: f64) -> Option<Glyph> {
        compose::glyph(self, character)
    }
}

/// A line of the file.
fn glyph(line: &str) -> Option<Glyph> {
    let value = |byte: &u8| f64::from(*byte) - f64::from(b'R');
    let pairs: Vec<&[u8]> = line.as_bytes().get(8..)?.chunks_exact(2).collect();
    let (extent, points) = pairs.split_first()?;
    let [left, right] = [extent.first(), extent.last()].map(|side| side.map_or(0.0, value));
    let mut lines = vec![Vec::new()];
    for pair in points {
        match (*pair, lines.last_mut()) {
            ([b' ', b'R'], _) => lines.push(Vec::new()),
            ([x, y], Some(line)) => line.push([value(x) - left, BASELINE - value(y)]),
            _ => {}
        }
    }
    lines.retain(|line| !line.is_empty());
    Some(Glyph {
        advance: right - left,
        lines,
    })
}
