//! Colours of entities and layers: the AutoCAD Color Index and true colours.

use super::pairs::Record;
use crate::Color;

/// Colours 1 to 9 of the index, which have names.
const NAMED_COLORS: [[u8; 3]; 9] = [
    [255, 0, 0],
    [255, 255, 0],
    [0, 255, 0],
    [0, 255, 255],
    [0, 0, 255],
    [255, 0, 255],
    // Colour 7 is white on a dark screen and black on paper.
    [0, 0, 0],
    [128, 128, 128],
    [192, 192, 192],
];
/// Greys from 250.
const GREY_LEVELS: [u8; 6] = [51, 91, 132, 173, 214, 255];
/// Brightness of the ten shades of a hue in pairs, 0 to 255.
const SHADE_LEVELS: [f64; 5] = [255.0, 165.0, 127.0, 76.0, 38.0];

/// Returns the colour of a record. `None` if it takes the colour of its layer; `Some(None)` if its
/// number is not a colour.
pub(super) fn of(record: &Record<'_>) -> Option<Option<Color>> {
    let number = |code| record.text(code)?.trim().parse::<i64>().ok();
    if let Some(rgb) = number(420) {
        let [.., red, green, blue] = rgb.to_be_bytes();
        return Some(Some(Color([red, green, blue])));
    }
    // The number is negative if the layer is off.
    match number(62)?.unsigned_abs() {
        256 => None,
        index => Some(indexed(index)),
    }
}

fn indexed(index: u64) -> Option<Color> {
    let index = usize::try_from(index).ok()?;
    match index {
        1..=9 => NAMED_COLORS.get(index - 1).copied().map(Color),
        250..=255 => GREY_LEVELS.get(index - 250).map(|grey| Color([*grey; 3])),
        10..250 => {
            let hue = (index / 10 - 1) as f64 * 15.0;
            let bright = *SHADE_LEVELS.get(index % 10 / 2)?;
            let pale = if index % 2 == 1 { 0.5 } else { 0.0 };
            // A channel is full within 60 degrees of its hue, and zero beyond 120.
            let channel = |own: f64| {
                let off = ((hue - own).rem_euclid(360.0)).min((own - hue).rem_euclid(360.0));
                let share = ((120.0 - off) / 60.0).clamp(0.0, 1.0);
                (bright * (pale + (1.0 - pale) * share)) as u8
            };
            Some(Color([channel(0.0), channel(120.0), channel(240.0)]))
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn indices_are_colours() {
        let shown = |index| indexed(index).map(|color| color.to_string());
        for (index, color) in [
            (1, "#ff0000"),
            (7, "#000000"),
            (10, "#ff0000"),
            (11, "#ff7f7f"),
            (30, "#ff7f00"),
            (90, "#00ff00"),
            (170, "#0000ff"),
            (14, "#7f0000"),
            (254, "#d6d6d6"),
        ] {
            assert_eq!(shown(index).as_deref(), Some(color), "{index}");
        }
        assert_eq!((shown(0), shown(300)), (None, None));
    }
}
