//! Letters and signs absent from the font files, built from existing glyphs where possible.
//!
//! Units are those of the Hershey fonts, whose capitals are 21 high.

use super::BundledFont;
use super::glyph::Glyph;
use super::hershey::{CAP_HEIGHT, Hershey};
use super::marks::{DOT, Mark, ellipse};

/// Scale of superscripts.
const SUPERSCRIPT_SCALE: f64 = 0.55;
/// Tail of an eng, relative to the end of its letter.
const ENG_TAIL: [[f64; 2]; 5] = [
    [0.0, 0.0],
    [0.0, -3.5],
    [-1.0, -6.0],
    [-3.0, -7.0],
    [-5.0, -6.5],
];

/// Returns the glyph of a letter or a sign.
pub(super) fn glyph(font: &Hershey, character: char) -> Option<Glyph> {
    letter(font, character).or_else(|| sign(font, character))
}

fn letter(font: &Hershey, character: char) -> Option<Glyph> {
    let plain = |letter| font.plain(letter);
    let (x_height, slant) = (font.x_height(), font.slant());
    let sans = font.style == BundledFont::Sans;
    Some(match character {
        'ı' => dotless(plain('i')?, x_height),
        'ȷ' => dotless(plain('j')?, x_height),
        'Æ' if sans => Glyph::new(
            22.0,
            &[
                &[[1.0, 0.0], [11.0, 21.0]],
                &[[20.0, 21.0], [11.0, 21.0], [11.0, 0.0], [20.0, 0.0]],
                &[[4.3, 7.0], [11.0, 7.0]],
                &[[11.0, 11.0], [17.5, 11.0]],
            ],
        ),
        'Æ' => plain('A')?.then(plain('E')?, 5.0),
        'Œ' => plain('O')?.then(plain('E')?, if sans { 7.0 } else { 4.0 }),
        'æ' => overlapped(plain('a')?, plain('e')?, font),
        'œ' => overlapped(plain('o')?, plain('e')?, font),
        'Ĳ' => plain('I')?.then(plain('J')?, 0.0),
        'ĳ' => plain('i')?.then(plain('j')?, 0.0),
        'ŉ' => plain('\'')?.then(plain('n')?, 2.0),
        'ſ' => long_s(font)?,
        'ß' | 'ẞ' if font.style != BundledFont::Gothic => sharp_s(slant),
        'ß' | 'ẞ' => long_s(font)?.then(plain('s')?, 3.0),
        'ø' | 'Ø' => {
            let letter = plain(if character == 'ø' { 'o' } else { 'O' })?;
            let [least, most] = letter.bounds()?;
            letter.line(&[
                [least[0] - 0.5, least[1] - 1.5],
                [most[0] + 0.5, most[1] + 1.5],
            ])
        }
        'ł' | 'Ł' => {
            let letter = plain(if character == 'ł' { 'l' } else { 'L' })?;
            let at = stem(&letter, CAP_HEIGHT / 2.0);
            letter.line(&[
                [at - 3.5, CAP_HEIGHT / 2.0 - 2.5],
                [at + 4.0, CAP_HEIGHT / 2.0 + 3.0],
            ])
        }
        'đ' | 'ħ' => {
            let letter = plain(if character == 'đ' { 'd' } else { 'h' })?;
            let height = (x_height + CAP_HEIGHT) / 2.0;
            let crossings = letter.crossings(height);
            let (left, right) = (crossings.first()?, crossings.last()?);
            let bar = [[left - 3.5, height], [right + 3.5, height]];
            letter.line(&bar)
        }
        'Đ' | 'Ð' => {
            let letter = plain('D')?;
            let at = stem(&letter, CAP_HEIGHT / 2.0);
            letter.line(&[[at - 3.5, CAP_HEIGHT / 2.0], [at + 5.0, CAP_HEIGHT / 2.0]])
        }
        'Ħ' => {
            let letter = plain('H')?;
            let crossings = letter.crossings(16.0);
            let (left, right) = (crossings.first()?, crossings.last()?);
            let bar = [[left - 2.5, 16.0], [right + 2.5, 16.0]];
            letter.line(&bar)
        }
        'ŧ' | 'Ŧ' => {
            let (letter, height) = match character {
                'ŧ' => (plain('t')?, x_height / 2.0),
                _ => (plain('T')?, CAP_HEIGHT / 2.0),
            };
            let at = stem(&letter, height);
            letter.line(&[[at - 3.5, height], [at + 3.5, height]])
        }
        'ð' => {
            let round = plain('o')?;
            let [least, most] = round.bounds()?;
            let middle = round.middle();
            let lean = |[x, y]: [f64; 2]| [x + slant * (y - x_height), y];
            let above = |y: f64| x_height + y;
            let right = most[0] - 0.15 * (most[0] - least[0]);
            round
                .line(&[
                    lean([middle - 3.0, above(7.0)]),
                    lean([middle, above(4.8)]),
                    lean([middle + 2.5, above(1.5)]),
                    lean([right, above(-2.5)]),
                    [most[0], x_height * 0.6],
                ])
                .line(&[
                    lean([middle - 3.0, above(3.0)]),
                    lean([middle + 4.0, above(7.0)]),
                ])
        }
        'þ' => thorn(font)?,
        'Þ' if sans => {
            let lowered = |line: &Vec<[f64; 2]>| line.iter().map(|[x, y]| [*x, y - 5.0]).collect();
            let mut letter = plain('P')?;
            if let Some(bowl) = letter.lines.get_mut(1) {
                *bowl = lowered(bowl);
            }
            letter
        }
        'Þ' => {
            let small = thorn(font)?;
            let [least, most] = small.bounds()?;
            let scale = CAP_HEIGHT / (most[1] - least[1]);
            small
                .moved([0.0, -least[1]])
                .scaled([scale.max(0.8), scale])
        }
        'ĸ' => plain('K')?.scaled([0.75, x_height / CAP_HEIGHT]),
        'ŋ' | 'Ŋ' => {
            let letter = plain(if character == 'ŋ' { 'n' } else { 'N' })?;
            let low = letter.lines.iter().flatten().filter(|[_, y]| *y <= 1.0);
            let end = low
                .copied()
                .max_by(|one, other| one[0].total_cmp(&other[0]))?;
            letter.line(&ENG_TAIL.map(|[x, y]| [end[0] + x + slant * y, end[1] + y]))
        }
        'ŀ' | 'Ŀ' => {
            let letter = plain(if character == 'ŀ' { 'l' } else { 'L' })?;
            let at = match character {
                'ŀ' => letter.advance + 1.0,
                _ => stem(&letter, CAP_HEIGHT / 2.0) + 6.0,
            };
            let advance = letter.advance.max(at + 4.0);
            let letter = letter.line(&DOT.map(|[x, y]| [x + at, y + CAP_HEIGHT / 2.0 - 1.0]));
            Glyph { advance, ..letter }
        }
        _ => return None,
    })
}

fn sign(font: &Hershey, character: char) -> Option<Glyph> {
    let plain = |sign| font.plain(sign);
    let x_height = font.x_height();
    let apart = |mark: Mark| {
        let advance = 16.0;
        let lines = mark.lines().moved([advance / 2.0, 16.0]);
        Glyph { advance, ..lines }
    };
    let lines = |advance: f64, lines: &[&[[f64; 2]]]| Glyph::new(advance, lines);
    Some(match character {
        '¡' | '¿' => {
            let sign = plain(if character == '¡' { '!' } else { '?' })?;
            let advance = sign.advance;
            let height = 14.0;
            sign.mapped(|[x, y]| [advance - x, height - y])
        }
        '¢' => {
            let letter = plain('c')?;
            let at = letter.middle();
            letter.line(&[[at, -3.0], [at, x_height + 3.0]])
        }
        '£' => lines(
            20.0,
            &[
                &[
                    [16.0, 17.0],
                    [15.0, 19.5],
                    [12.5, 21.0],
                    [10.0, 21.0],
                    [7.5, 19.5],
                    [6.5, 17.0],
                    [6.7, 14.0],
                    [8.0, 9.0],
                    [8.0, 5.0],
                    [6.5, 1.5],
                    [4.0, 0.0],
                    [16.5, 0.0],
                ],
                &[[3.5, 10.5], [13.0, 10.5]],
            ],
        ),
        '€' => lines(
            21.0,
            &[
                &[
                    [18.0, 17.5],
                    [16.5, 19.7],
                    [14.0, 21.0],
                    [11.0, 21.0],
                    [8.0, 19.5],
                    [6.0, 16.5],
                    [5.0, 12.5],
                    [5.0, 8.5],
                    [6.0, 4.5],
                    [8.0, 1.5],
                    [11.0, 0.0],
                    [14.0, 0.0],
                    [16.5, 1.3],
                    [18.0, 3.5],
                ],
                &[[2.5, 12.5], [14.0, 12.5]],
                &[[2.5, 8.5], [13.0, 8.5]],
            ],
        ),
        '¤' => {
            let ring = Glyph {
                advance: 20.0,
                ..Glyph::default().line(&ellipse([10.0, 9.5], [5.0, 5.0]))
            };
            let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
            corners.iter().fold(ring, |sign, [x, y]| {
                sign.line(&[
                    [10.0 + 3.5 * x, 9.5 + 3.5 * y],
                    [10.0 + 6.5 * x, 9.5 + 6.5 * y],
                ])
            })
        }
        '¥' => {
            let letter = plain('Y')?;
            let at = letter.middle_at(3.0);
            letter
                .line(&[[at - 5.0, 9.0], [at + 5.0, 9.0]])
                .line(&[[at - 5.0, 5.0], [at + 5.0, 5.0]])
        }
        '¦' => lines(
            8.0,
            &[&[[4.0, 25.0], [4.0, 11.5]], &[[4.0, 6.5], [4.0, -7.0]]],
        ),
        '§' => {
            let upper = [
                [12.5, 18.0],
                [11.5, 20.2],
                [9.5, 21.0],
                [7.5, 20.5],
                [6.0, 18.7],
                [6.3, 16.7],
                [8.0, 15.0],
                [11.5, 12.0],
                [13.0, 9.7],
                [12.7, 7.5],
                [10.5, 5.5],
            ];
            let lower = upper.map(|[x, y]| [18.0 - x, 17.0 - y]);
            lines(18.0, &[&upper, &lower])
        }
        '¨' => apart(Mark::Diaeresis),
        '´' => apart(Mark::Acute),
        '¯' => apart(Mark::Macron),
        '¸' => Mark::Cedilla.lines().moved([8.0, 0.0]).widened(16.0),
        '©' | '®' => {
            let (letter, scale) = match character {
                '©' => (plain('C')?, 0.52),
                _ => (plain('R')?, 0.48),
            };
            let letter = letter.scaled([scale; 2]);
            let [least, most] = letter.bounds()?;
            let at = [0, 1].map(|axis| (least[axis] + most[axis]) / 2.0);
            let letter = letter.moved([13.0 - at[0], 10.5 - at[1]]);
            let ring = Glyph::default().line(&ellipse([13.0, 10.5], [10.5, 10.5]));
            ring.with(letter).widened(26.0)
        }
        '™' => {
            let raised = |letter| {
                Some(
                    plain(letter)?
                        .scaled([0.45; 2])
                        .moved([0.0, 0.55 * CAP_HEIGHT]),
                )
            };
            raised('T')?.then(raised('M')?, 0.0)
        }
        'ª' | 'º' => {
            let letter = plain(if character == 'ª' { 'a' } else { 'o' })?.scaled([0.65; 2]);
            let [least, most] = letter.bounds()?;
            let raised = letter.moved([0.0, CAP_HEIGHT - most[1]]);
            let height = CAP_HEIGHT - (most[1] - least[1]) - 3.0;
            raised.line(&[[least[0], height], [most[0], height]])
        }
        '«' | '‹' | '»' | '›' => {
            let one = [[9.0, 12.0], [4.0, 7.0], [9.0, 2.0]];
            let other = one.map(|[x, y]| [x + 6.0, y]);
            let (sign, advance) = match character {
                '«' | '»' => (lines(19.0, &[&one, &other]), 19.0),
                _ => (lines(13.0, &[&one]), 13.0),
            };
            match character {
                '»' | '›' => sign.mapped(|[x, y]| [advance - x, y]),
                _ => sign,
            }
        }
        '¬' => lines(24.0, &[&[[4.0, 12.0], [20.0, 12.0], [20.0, 6.0]]]),
        '°' => Glyph::default()
            .line(&ellipse([6.0, 18.0], [3.0, 3.0]))
            .widened(12.0),
        '±' => lines(
            26.0,
            &[
                &[[13.0, 19.0], [13.0, 3.0]],
                &[[5.0, 11.0], [21.0, 11.0]],
                &[[5.0, 0.0], [21.0, 0.0]],
            ],
        ),
        '×' => lines(
            22.0,
            &[&[[5.0, 15.0], [17.0, 3.0]], &[[5.0, 3.0], [17.0, 15.0]]],
        ),
        '÷' => {
            let dots = [3.0, 13.0].map(|y| DOT.map(|[x, dy]| [x + 13.0, y + dy]));
            lines(26.0, &[&dots[1], &[[4.0, 9.0], [22.0, 9.0]], &dots[0]])
        }
        'µ' => {
            let letter = plain('u')?;
            let least = *letter.crossings(x_height / 2.0).first()?;
            letter.line(&[
                [least - font.slant() * x_height / 2.0, 0.0],
                [least - font.slant() * (x_height / 2.0 + 7.0), -7.0],
            ])
        }
        '¶' => lines(
            19.0,
            &[
                &[
                    [9.5, 12.0],
                    [7.0, 12.0],
                    [4.5, 13.0],
                    [3.2, 15.0],
                    [3.2, 18.0],
                    [4.5, 20.0],
                    [7.0, 21.0],
                    [15.0, 21.0],
                    [15.0, -4.0],
                ],
                &[[9.5, 21.0], [9.5, -4.0]],
            ],
        ),
        '·' | '•' => {
            let radius = if character == '•' { 3.0 } else { 1.0 };
            Glyph::default()
                .line(&DOT.map(|[x, y]| [4.0 + radius * x, 9.0 + radius * (y - 1.0)]))
                .moved([radius - 1.0, 0.0])
                .widened(6.0 + 2.0 * radius)
        }
        '¹' | '²' | '³' => raised(plain(digit(character)?)?),
        '¼' => fraction(plain('1')?, plain('4')?),
        '½' => fraction(plain('1')?, plain('2')?),
        '¾' => fraction(plain('3')?, plain('4')?),
        '\u{AD}' | '‐' | '‑' | '–' => lines(18.0, &[&[[3.0, 9.0], [15.0, 9.0]]]),
        '—' => lines(30.0, &[&[[3.0, 9.0], [27.0, 9.0]]]),
        '−' => plain('-')?,
        '‘' | '’' | '‚' => quotes(character, 1),
        '“' | '”' | '„' => quotes(character, 2),
        '…' => {
            let dot = plain('.')?;
            dot.clone().then(dot.clone(), 0.0).then(dot, 0.0)
        }
        _ => return None,
    })
}

impl Glyph {
    /// Sets the advance.
    fn widened(self, advance: f64) -> Self {
        Self { advance, ..self }
    }
}

fn dotless(letter: Glyph, x_height: f64) -> Glyph {
    letter.without(|line| line.iter().all(|[_, y]| *y > x_height + 1.0))
}

/// X at which the leftmost stem of a letter crosses a height.
fn stem(letter: &Glyph, height: f64) -> f64 {
    let crossings = letter.crossings(height);
    crossings
        .first()
        .copied()
        .unwrap_or_else(|| letter.middle())
}

/// Ligature of two small letters that share a line.
fn overlapped(left: Glyph, right: Glyph, font: &Hershey) -> Glyph {
    let edges = left.bounds().zip(right.bounds());
    let meet = edges.map_or(0.0, |([_, most], [least, _])| {
        left.advance - most[0] + least[0]
    });
    let nearer = match font.style {
        // Joined letters already overlap by their connecting stroke.
        BundledFont::Script => 0.0,
        BundledFont::Sans => meet,
        BundledFont::Gothic => meet + 1.0,
    };
    left.then(right, nearer)
}

/// Long s: an f without its bar, or in script without the loop from its foot.
fn long_s(font: &Hershey) -> Option<Glyph> {
    let x_height = font.x_height();
    let mut letter = font.plain('f')?;
    if font.style == BundledFont::Script {
        for line in &mut letter.lines {
            let lowest = line
                .iter()
                .enumerate()
                .min_by(|(_, one), (_, other)| one[1].total_cmp(&other[1]));
            let kept = lowest.map_or(0, |(at, _)| at + 1);
            line.truncate(kept);
        }
    }
    let is_bar = |line: &[[f64; 2]]| line.len() == 2 && line.iter().all(|[_, y]| *y == x_height);
    Some(letter.without(is_bar))
}

fn sharp_s(slant: f64) -> Glyph {
    let letter = Glyph::new(
        19.0,
        &[&[
            [4.0, 0.0],
            [4.0, 15.0],
            [4.7, 18.0],
            [6.3, 20.2],
            [8.8, 21.0],
            [11.3, 20.4],
            [12.8, 18.6],
            [13.0, 16.5],
            [12.0, 14.2],
            [9.8, 12.8],
            [8.0, 12.4],
            [11.3, 11.8],
            [14.0, 10.0],
            [15.3, 7.3],
            [15.2, 4.5],
            [13.8, 1.8],
            [11.2, 0.2],
            [8.3, 0.0],
        ]],
    );
    // Slanted letters are also narrower.
    letter
        .scaled([1.0 - 0.6 * slant, 1.0])
        .mapped(|[x, y]| [x + slant * (y - 10.0), y])
}

/// Small thorn: a p with its stem extended upwards.
fn thorn(font: &Hershey) -> Option<Glyph> {
    let letter = font.plain('p')?;
    let at = *letter.crossings(0.0).first()?;
    let foot = letter.bounds()?[0][1];
    match font.style {
        BundledFont::Sans => Some(letter.line(&[[at, font.x_height()], [at, CAP_HEIGHT]])),
        BundledFont::Script => {
            let lean = |y: f64| at + font.slant() * y;
            Some(letter.line(&[
                [lean(foot / 2.0), foot / 2.0],
                [lean(CAP_HEIGHT), CAP_HEIGHT],
            ]))
        }
        BundledFont::Gothic => {
            let tall = font.plain('b')?;
            Some(tall.with(letter.without(|line| line.iter().all(|[_, y]| *y > 0.0))))
        }
    }
}

const fn digit(character: char) -> Option<char> {
    match character {
        '¹' => Some('1'),
        '²' => Some('2'),
        '³' => Some('3'),
        _ => None,
    }
}

fn raised(digit: Glyph) -> Glyph {
    digit
        .scaled([SUPERSCRIPT_SCALE; 2])
        .moved([0.0, CAP_HEIGHT * (1.0 - SUPERSCRIPT_SCALE)])
}

fn fraction(upper: Glyph, lower: Glyph) -> Glyph {
    let upper = raised(upper);
    let slash = Glyph::new(8.0, &[&[[-1.0, 0.0], [9.0, CAP_HEIGHT]]]);
    upper
        .then(slash, 0.0)
        .then(lower.scaled([SUPERSCRIPT_SCALE; 2]), 0.0)
}

fn quotes(character: char, count: u8) -> Glyph {
    let one = [[1.0, 21.0], [1.0, 19.0], [-0.5, 16.0]];
    let one = match character {
        '‚' | '„' => one.map(|[x, y]| [x, y - 18.5]),
        '‘' | '“' => one.map(|[x, y]| [-x, 37.0 - y]),
        _ => one,
    };
    let nth = |nth: u8| one.map(|[x, y]| [x + 4.0 + 5.0 * f64::from(nth), y]);
    let lines = (0..count).fold(Glyph::default(), |glyph, each| glyph.line(&nth(each)));
    lines.widened(3.0 + 5.0 * f64::from(count))
}
