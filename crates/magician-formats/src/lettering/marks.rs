//! Diacritics as lines around x = 0: those above a letter go up from y = 0, those below go down.
//!
//! Units are those of the Hershey fonts, whose capitals are 21 high.

use super::Glyph;

/// A diacritic.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Mark {
    Grave,
    Acute,
    Circumflex,
    Tilde,
    Diaeresis,
    Ring,
    Macron,
    Breve,
    Dot,
    DoubleAcute,
    Caron,
    /// A caron beside a tall letter, drawn as an apostrophe.
    CaronBeside,
    Cedilla,
    Ogonek,
    CommaBelow,
    /// The comma of a letter without room below (g): turned round and placed above.
    CommaAbove,
}

/// Position of a mark relative to its letter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Position {
    Above,
    Beside,
    /// Below the letter with a gap.
    Below,
    /// Attached where the letter touches the baseline.
    Attached,
}

/// Dot in the style of the fonts.
pub(super) const DOT: [[f64; 2]; 5] = [[0.0, 2.0], [-1.0, 1.0], [0.0, 0.0], [1.0, 1.0], [0.0, 2.0]];

impl Mark {
    pub(super) const fn position(self) -> Position {
        match self {
            Self::CaronBeside => Position::Beside,
            Self::CommaBelow => Position::Below,
            Self::Cedilla | Self::Ogonek => Position::Attached,
            // All remaining marks go above.
            _ => Position::Above,
        }
    }

    /// Returns the mark of a combining character.
    pub(super) const fn combining(character: char) -> Option<Self> {
        Some(match character {
            '\u{300}' => Self::Grave,
            '\u{301}' => Self::Acute,
            '\u{302}' => Self::Circumflex,
            '\u{303}' => Self::Tilde,
            '\u{304}' => Self::Macron,
            '\u{306}' => Self::Breve,
            '\u{307}' => Self::Dot,
            '\u{308}' => Self::Diaeresis,
            '\u{30A}' => Self::Ring,
            '\u{30B}' => Self::DoubleAcute,
            '\u{30C}' => Self::Caron,
            '\u{326}' => Self::CommaBelow,
            '\u{327}' => Self::Cedilla,
            '\u{328}' => Self::Ogonek,
            _ => return None,
        })
    }

    /// Returns its lines.
    pub(super) fn lines(self) -> Glyph {
        let dots = |places: &[f64]| {
            let none = Glyph::default();
            places
                .iter()
                .fold(none, |glyph, at| glyph.line(&DOT.map(|[x, y]| [x + at, y])))
        };
        let line = |line: &[[f64; 2]]| Glyph::new(0.0, &[line]);
        match self {
            Self::Grave => line(&[[-3.0, 5.0], [1.5, 0.0]]),
            Self::Acute => line(&[[-1.5, 0.0], [3.0, 5.0]]),
            Self::Circumflex => line(&[[-4.0, 0.0], [0.0, 5.0], [4.0, 0.0]]),
            Self::Caron => line(&[[-4.0, 5.0], [0.0, 0.0], [4.0, 5.0]]),
            Self::Tilde => line(&[
                [-5.0, 0.5],
                [-4.0, 2.5],
                [-2.5, 3.2],
                [-1.0, 2.8],
                [1.0, 1.2],
                [2.5, 0.8],
                [4.0, 1.5],
                [5.0, 3.5],
            ]),
            Self::Diaeresis => dots(&[-3.5, 3.5]),
            Self::Dot => dots(&[0.0]),
            Self::Ring => Glyph::default().line(&ellipse([0.0, 2.75], [2.75, 2.75])),
            Self::Macron => line(&[[-4.5, 1.5], [4.5, 1.5]]),
            Self::Breve => line(&[
                [-4.5, 4.5],
                [-4.0, 2.5],
                [-2.5, 0.7],
                [0.0, 0.0],
                [2.5, 0.7],
                [4.0, 2.5],
                [4.5, 4.5],
            ]),
            Self::DoubleAcute => Glyph::new(
                0.0,
                &[&[[-4.5, 0.0], [-1.0, 5.0]], &[[1.0, 0.0], [4.5, 5.0]]],
            ),
            Self::CaronBeside => line(&[[1.0, 0.0], [1.0, -2.0], [0.0, -5.0]]),
            Self::Cedilla => line(&[
                [0.0, 0.0],
                [-0.8, -2.0],
                [0.8, -2.3],
                [2.2, -3.2],
                [2.6, -4.6],
                [1.8, -6.0],
                [0.0, -6.6],
                [-2.5, -6.2],
            ]),
            Self::Ogonek => line(&[
                [0.0, 0.0],
                [-1.7, -1.6],
                [-2.5, -3.4],
                [-2.3, -5.0],
                [-1.0, -6.2],
                [0.8, -6.4],
                [2.3, -5.6],
            ]),
            Self::CommaBelow => line(&[[0.8, 0.0], [0.8, -2.0], [-0.8, -5.0]]),
            Self::CommaAbove => line(&[[-0.8, 0.0], [-0.8, 2.0], [0.8, 5.0]]),
        }
    }
}

/// Ellipse about a centre, as a closed polyline.
pub(super) fn ellipse([x, y]: [f64; 2], [rx, ry]: [f64; 2]) -> Vec<[f64; 2]> {
    const CORNERS: u32 = 24;
    let mut corners: Vec<[f64; 2]> = (0..CORNERS)
        .map(|corner| {
            let angle = std::f64::consts::TAU * f64::from(corner) / f64::from(CORNERS);
            [x + rx * libm::sin(angle), y + ry * libm::cos(angle)]
        })
        .collect();
    corners.extend(corners.first().copied());
    corners
}
