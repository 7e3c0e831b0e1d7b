//! Single-line fonts of A. V. Hershey, in the format of James Hurt.
//!
//! Each line of a file is a glyph, in the order of ASCII from the space on. It has the number of
//! the glyph in a field of 5 characters, the number of coordinate pairs in a field of 3, and the
//! pairs, each of 2 characters. A coordinate is the character code minus that of `R`. The first
//! pair is the left and right edge; ` R` lifts the pen. y grows downwards, the baseline is at 9,
//! and capitals begin at -12.

use std::collections::HashMap;
use std::sync::LazyLock;

use super::{BundledFont, Glyph, Glyphs, compose};

/// Y of the baseline in the files.
const BASELINE: f64 = 9.0;
/// Height of a capital.
pub(super) const CAP_HEIGHT: f64 = 21.0;

/// A Hershey font.
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

    /// Returns the glyph that the file has for a character. `None` if it has none.
    pub(super) fn plain(&self, character: char) -> Option<Glyph> {
        self.plain.get(&character).cloned()
    }

    /// Height of lower-case letters without ascenders.
    pub(super) fn x_height(&self) -> f64 {
        match self.style {
            BundledFont::Sans | BundledFont::Gothic => 14.0,
            BundledFont::Script => 9.0,
        }
    }

    /// Slant of the letters: x per unit of y.
    pub(super) fn slant(&self) -> f64 {
        match self.style {
            BundledFont::Sans | BundledFont::Gothic => 0.0,
            BundledFont::Script => 0.35,
        }
    }
}

impl Glyphs for &Hershey {
    fn cap_height(&self) -> f64 {
        CAP_HEIGHT
    }

    fn glyph(&self, character: char, _tolerance: f64) -> Option<Glyph> {
        compose::glyph(self, character)
    }
}

/// Parses a line of the file.
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
