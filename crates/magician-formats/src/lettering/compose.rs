//! Letters composed of a base letter and a diacritic.
//!
//! The Hershey fonts have only ASCII. Accented letters are built from a base letter and a [`Mark`],
//! which is centred on the top or foot of the base and leans with the font.

use super::drawn;
use super::hershey::{CAP_HEIGHT, Hershey};
use super::marks::{Mark, Position};
use super::{BundledFont, Glyph};

/// Gap between a letter and its mark, in units of the font.
const MARK_GAP: f64 = 3.0;
/// Letters by mark, and the base of each.
const COMPOSED_LETTERS: [(Mark, &str, &str); 17] = [
    (Mark::Grave, "ÀÈÌÒÙàèìòùǸǹ", "AEIOUaeıouNn"),
    (
        Mark::Acute,
        "ÁÉÍÓÚÝáéíóúýĆćĹĺŃńŔŕŚśŹź",
        "AEIOUYaeıouyCcLlNnRrSsZz",
    ),
    (
        Mark::Circumflex,
        "ÂÊÎÔÛâêîôûĈĉĜĝĤĥĴĵŜŝŴŵŶŷ",
        "AEIOUaeıouCcGgHhJȷSsWwYy",
    ),
    (Mark::Tilde, "ÃÑÕãñõĨĩŨũ", "ANOanoIıUu"),
    (Mark::Diaeresis, "ÄËÏÖÜäëïöüÿŸ", "AEIOUaeıouyY"),
    (Mark::Ring, "ÅåŮů", "AaUu"),
    (Mark::Macron, "ĀāĒēĪīŌōŪū", "AaEeIıOoUu"),
    (Mark::Breve, "ĂăĔĕĞğĬĭŎŏŬŭ", "AaEeGgIıOoUu"),
    (Mark::Dot, "ĊċĖėĠġİŻż", "CcEeGgIZz"),
    (Mark::DoubleAcute, "ŐőŰű", "OoUu"),
    (Mark::Caron, "ČčĎĚěŇňŘřŠšŤŽž", "CcDEeNnRrSsTZz"),
    (Mark::CaronBeside, "ďĽľť", "dLlt"),
    (Mark::Cedilla, "ÇçŞşŢţ", "CcSsTt"),
    (Mark::Ogonek, "ĄąĘęĮįŲų", "AaEeIiUu"),
    (Mark::CommaBelow, "ĢĶķĻļŅņŖŗȘșȚț", "GKkLlNnRrSsTt"),
    (Mark::CommaAbove, "ģ", "g"),
    (Mark::Dot, "Ḃḃ", "Bb"),
];

/// Returns the mark and the base of a letter.
fn parts(character: char) -> Option<(Mark, char)> {
    COMPOSED_LETTERS.iter().find_map(|(mark, letters, bases)| {
        let mut both = letters.chars().zip(bases.chars());
        let (_, base) = both.find(|(letter, _)| *letter == character)?;
        Some((*mark, base))
    })
}

/// Returns the glyph of a character: from the font file, composed, or drawn.
pub(super) fn glyph(font: &Hershey, character: char) -> Option<Glyph> {
    if let Some((mark, base)) = parts(character) {
        return Some(marked(font, glyph(font, base)?, mark));
    }
    match character {
        '\u{A0}' | '\u{202F}' => font.plain(' '),
        // The script file has an arrow in this place.
        '^' if font.style == BundledFont::Script => Hershey::of(BundledFont::Sans).plain('^'),
        ' '..='~' => font.plain(character),
        _ => drawn::glyph(font, character),
    }
}

/// Returns the letter that a base and a combining mark form, because other programs write accents
/// decomposed: `e` followed by U+0301.
pub(super) fn precomposed(base: char, mark: char) -> Option<char> {
    let mark = Mark::combining(mark)?;
    COMPOSED_LETTERS.iter().find_map(|(known, letters, bases)| {
        let same = *known == mark
            || *known == Mark::CaronBeside && mark == Mark::Caron
            || matches!(*known, Mark::CommaBelow | Mark::CommaAbove) && mark == Mark::Cedilla;
        let mut both = letters.chars().zip(bases.chars()).filter(|_| same);
        let is_base =
            |letter| letter == base || letter == 'ı' && base == 'i' || letter == 'ȷ' && base == 'j';
        both.find_map(|(letter, its_base)| is_base(its_base).then_some(letter))
    })
}

/// Adds a mark to a letter.
fn marked(font: &Hershey, letter: Glyph, mark: Mark) -> Glyph {
    let Some([least, most]) = letter.bounds() else {
        return letter;
    };
    let slant = match mark.position() {
        Position::Beside => 0.0,
        // A mark above or below shifts with the slant of the letter.
        _ => font.slant(),
    };
    let lines = mark.lines().mapped(|[x, y]| [x + slant * y, y]);
    let mut advance = letter.advance;
    let at = match mark.position() {
        Position::Above => [
            top(&letter, least, most) + slant * MARK_GAP,
            most[1] + MARK_GAP,
        ],
        Position::Below => [
            letter.middle_at(least[1].max(0.0) + 1.0),
            least[1].min(0.0) - MARK_GAP,
        ],
        Position::Attached => {
            let (x, y) = foot(&letter, mark == Mark::Ogonek);
            [x, y]
        }
        Position::Beside => {
            let heights = (0..=6).map(|down| CAP_HEIGHT - f64::from(down));
            let right = heights.flat_map(|height| letter.crossings(height));
            let x = right.fold(letter.middle(), f64::max) + MARK_GAP;
            advance = advance.max(x + MARK_GAP);
            [x, CAP_HEIGHT]
        }
    };
    let glyph = letter.with(lines.moved(at));
    Glyph { advance, ..glyph }
}

/// X of the top of a letter, where a mark goes: halfway between the middle of its upper third and
/// the middle of the whole letter.
fn top(letter: &Glyph, least: [f64; 2], most: [f64; 2]) -> f64 {
    let from = most[1] - (most[1] - least[1].max(0.0)) / 3.0;
    let upper = letter.lines.iter().flatten().filter(|[_, y]| *y >= from);
    let xs = upper.map(|[x, _]| *x);
    let (left, right) = xs.fold((f64::INFINITY, f64::NEG_INFINITY), |(left, right), x| {
        (left.min(x), right.max(x))
    });
    ((left + right) / 2.0 + (least[0] + most[0]) / 2.0) / 2.0
}

/// Point where a letter stands on the baseline: the rightmost one, or the one nearest to its
/// middle.
fn foot(letter: &Glyph, right: bool) -> (f64, f64) {
    let middle = letter.middle();
    let points = letter.lines.iter().flatten();
    let lowest = points
        .clone()
        .fold(f64::INFINITY, |least, [_, y]| least.min(*y));
    let near = points.filter(|[_, y]| *y <= lowest.max(0.0) + 0.5);
    let value = |at: &[f64; 2]| {
        if right {
            -at[0]
        } else {
            (at[0] - middle).abs()
        }
    };
    let nearest = near.min_by(|one, other| value(one).total_cmp(&value(other)));
    nearest.map_or((middle, 0.0), |[x, y]| (*x, *y))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_composed_letter_has_a_base() {
        for (mark, letters, bases) in COMPOSED_LETTERS {
            assert_eq!(letters.chars().count(), bases.chars().count(), "{mark:?}");
        }
    }

    /// Smallest distance between two sets of lines.
    fn distance(one: &[Vec<[f64; 2]>], other: &[Vec<[f64; 2]>]) -> f64 {
        let points = |lines: &[Vec<[f64; 2]>]| -> Vec<[f64; 2]> {
            let pieces = lines.iter().flat_map(|line| line.windows(2));
            let along = |piece: &[[f64; 2]]| {
                let [[x, y], [to_x, to_y]] = [piece[0], piece[1]];
                (0..=20).map(move |nth| {
                    let share = f64::from(nth) / 20.0;
                    [x + (to_x - x) * share, y + (to_y - y) * share]
                })
            };
            pieces.flat_map(along).collect()
        };
        let (one, other) = (points(one), points(other));
        let pairs = one.iter().flat_map(|from| {
            other
                .iter()
                .map(move |to| crate::artwork::distance(*from, *to))
        });
        pairs.fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn marks_keep_clear_of_their_letters_and_tails_grow_from_them() {
        for style in BundledFont::ALL {
            let font = Hershey::of(style);
            for (mark, letters, bases) in COMPOSED_LETTERS {
                for (letter, base) in letters.chars().zip(bases.chars()) {
                    let base = glyph(font, base).unwrap();
                    let whole = glyph(font, letter).unwrap();
                    let (below, above) = whole.lines.split_at(base.lines.len());
                    assert_eq!(below, base.lines, "{style} {letter}");
                    let near = distance(below, above);
                    let what = format!("{style} {letter}: {near}");
                    match mark.position() {
                        Position::Attached => assert!(near < 0.1, "{what}"),
                        _ => assert!(near >= 2.0, "{what}"),
                    }
                    let lines = above.to_vec();
                    let box_of_mark = Glyph {
                        lines,
                        ..Glyph::default()
                    }
                    .bounds()
                    .unwrap();
                    let box_of_base = base.bounds().unwrap();
                    match mark.position() {
                        Position::Above => {
                            assert!(box_of_mark[0][1] >= box_of_base[1][1] + 2.0, "{what}");
                        }
                        Position::Below => {
                            assert!(box_of_mark[1][1] <= box_of_base[0][1] - 2.0, "{what}");
                        }
                        Position::Attached | Position::Beside => {}
                    }
                }
            }
        }
    }
}
