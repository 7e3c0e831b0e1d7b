//! Reads the lines of a file in the simplest way, without the readers that are to be verified.

use std::error::Error;

use magician_picture::compare::svg_lines;

/// Line as a list of its corners.
pub(crate) type Line = Vec<[f64; 2]>;

/// Angle of an arc per corner, deg.
const ARC_STEP_DEG: f64 = 1.0;
/// Size of an HPGL unit, mm.
const HPGL_UNIT_MM: f64 = 0.025;

/// Returns the lines of an SVG on its sheet.
pub(crate) fn svg(bytes: &[u8]) -> Result<Vec<Line>, Box<dyn Error>> {
    Ok(svg_lines(bytes)?)
}

/// Returns the lines of a plot that uses only PU and PD with absolute positions.
pub(crate) fn hpgl(text: &str) -> Vec<Line> {
    let mut lines: Vec<Line> = Vec::new();
    let mut at = [0.0, 0.0];
    for word in text.split(';').map(str::trim) {
        let Some((verb, rest)) = word.split_at_checked(2) else {
            continue;
        };
        let numbers: Vec<f64> = (rest.split([' ', ',']))
            .filter_map(|number| number.parse().ok())
            .collect();
        for place in numbers.chunks_exact(2) {
            let to = [place[0] * HPGL_UNIT_MM, place[1] * HPGL_UNIT_MM];
            match verb {
                "PD" => add_segment(&mut lines, at, to),
                "PU" => {}
                _ => continue,
            }
            at = to;
        }
    }
    lines
}

/// Returns the drawn lines of G-code in millimetres with arc centres by I and J: those with Z at or
/// below 0 if the file has a Z, otherwise those with S above 0. Each has its S as a share of the
/// largest.
pub(crate) fn gcode(text: &str) -> Vec<(f64, Line)> {
    let mut lines: Vec<Line> = Vec::new();
    let mut powers: Vec<f64> = Vec::new();
    let has_z = text
        .lines()
        .any(|line| without_comments(line).contains('Z'));
    let ([mut x, mut y, mut z, mut s], mut mode) = ([0.0, 0.0, 0.0, 0.0], 0);
    let mut relative = false;
    for line in text.lines().map(without_comments) {
        let mut centre = None;
        let [from_x, from_y] = [x, y];
        let mut moves = false;
        for (letter, number) in gcode_words(line) {
            let base = |from: f64| if relative { from } else { 0.0 };
            match letter {
                'G' if number <= 3.0 => mode = number as u8,
                'G' if number == 90.0 || number == 91.0 => relative = number > 90.5,
                'X' => (x, moves) = (base(from_x) + number, true),
                'Y' => (y, moves) = (base(from_y) + number, true),
                'Z' => z = number,
                'S' => s = number,
                'I' => centre.get_or_insert([from_x, from_y])[0] += number,
                'J' => centre.get_or_insert([from_x, from_y])[1] += number,
                _ => {}
            }
        }
        let down = if has_z { z <= 0.0 } else { s > 0.0 };
        if !moves || mode == 0 || !down {
            continue;
        }
        let mut at = [from_x, from_y];
        if powers.last() != Some(&s) {
            lines.push(vec![at]);
            powers.push(s);
        }
        let centre = centre.filter(|_| mode > 1);
        for to in arc(at, [x, y], centre, mode == 2) {
            add_segment(&mut lines, at, to);
            at = to;
        }
        powers.resize(lines.len(), s);
    }
    let most = powers.iter().copied().fold(0.0, f64::max);
    let shades = powers
        .iter()
        .map(|s| if most > 0.0 { s / most } else { 1.0 });
    shades.zip(lines).collect()
}

/// Returns the words of a line, with or without spaces between them.
fn gcode_words(line: &str) -> impl Iterator<Item = (char, f64)> {
    let starts = line
        .char_indices()
        .filter(|(_, letter)| letter.is_ascii_alphabetic());
    starts.filter_map(move |(at, letter)| {
        let rest = line.get(at + 1..)?.trim_start();
        let end = rest.find(|c: char| !c.is_ascii_digit() && !".-+".contains(c));
        let number = rest.get(..end.unwrap_or(rest.len()))?;
        Some((letter, number.parse().ok()?))
    })
}

/// Removes comments.
fn without_comments(line: &str) -> &str {
    line.split(';').next().unwrap_or_default()
}

/// Returns the corners of an arc after its start; only its end if there is no centre.
fn arc(from: [f64; 2], to: [f64; 2], centre: Option<[f64; 2]>, clockwise: bool) -> Line {
    let Some([cx, cy]) = centre else {
        return vec![to];
    };
    let angle = |[x, y]: [f64; 2]| (y - cy).atan2(x - cx);
    let radius = (from[0] - cx).hypot(from[1] - cy);
    let turn = (angle(to) - angle(from)).rem_euclid(std::f64::consts::TAU);
    let turn = if clockwise {
        turn - std::f64::consts::TAU
    } else {
        turn
    };
    let pieces = (turn.abs().to_degrees() / ARC_STEP_DEG).ceil().max(1.0);
    let corner = |nth: u32| {
        let at = angle(from) + turn * f64::from(nth) / pieces;
        [cx + radius * at.cos(), cy + radius * at.sin()]
    };
    (1..=pieces as u32).map(corner).collect()
}

/// Adds a segment to the last line, or begins a new line.
fn add_segment(lines: &mut Vec<Line>, from: [f64; 2], to: [f64; 2]) {
    match lines.last_mut() {
        Some(line) if line.last() == Some(&from) => line.push(to),
        _ => lines.push(vec![from, to]),
    }
}
