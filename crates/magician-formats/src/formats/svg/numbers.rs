//! Detection of absurdly large numbers. usvg splits an arc of such a radius into millions of curves
//! before any limit on the result can apply.

use roxmltree::Node;

/// Attributes with positions and sizes.
const MEASURE_ATTRIBUTES: [&str; 21] = [
    "d",
    "points",
    "x",
    "y",
    "width",
    "height",
    "r",
    "rx",
    "ry",
    "cx",
    "cy",
    "x1",
    "y1",
    "x2",
    "y2",
    "viewBox",
    "transform",
    "font-size",
    "dx",
    "dy",
    "markerWidth",
];
/// Power of ten from which a number is refused. A choice far above any sheet in any unit.
const REFUSED_POWER_OF_TEN: i64 = 9;

/// Returns the first such number of an element.
pub(super) fn excessive_number<'a>(node: &Node<'a, '_>) -> Option<&'a str> {
    let measures = MEASURE_ATTRIBUTES
        .iter()
        .filter_map(|name| node.attribute(*name));
    measures.into_iter().find_map(first_excessive_number)
}

fn first_excessive_number(text: &str) -> Option<&str> {
    let bytes = text.as_bytes();
    let mut at = 0;
    while let Some(rest) = bytes.get(at..).filter(|rest| !rest.is_empty()) {
        let (length, power) = number(rest);
        if power > REFUSED_POWER_OF_TEN {
            return text.get(at..at + length.min(40));
        }
        at += length.max(1);
    }
    None
}

/// Returns the length of the number at the start of the text, 0 without one, and a power of ten
/// that is certainly greater.
fn number(text: &[u8]) -> (usize, i64) {
    let digits = |from: usize| {
        let rest = text.get(from..).unwrap_or_default();
        rest.iter().take_while(|byte| byte.is_ascii_digit()).count()
    };
    let whole = digits(0);
    let zeros = text
        .iter()
        .take(whole)
        .take_while(|byte| **byte == b'0')
        .count();
    let mut end = whole;
    if text.get(end) == Some(&b'.') {
        end += 1 + digits(end + 1);
    }
    let mut power = (whole - zeros) as i64;
    if end > 0 && matches!(text.get(end), Some(b'e' | b'E')) {
        let signed = matches!(text.get(end + 1), Some(b'+' | b'-'));
        let from = end + 1 + usize::from(signed);
        let count = digits(from);
        let exponent = text
            .get(from..from + count)
            .and_then(|text| std::str::from_utf8(text).ok());
        // An exponent too long to parse is too large as well.
        let exponent = exponent.map_or(0, |text| {
            if text.is_empty() {
                0
            } else {
                text.parse().unwrap_or(1 << 40)
            }
        });
        power += if text.get(end + 1) == Some(&b'-') {
            -exponent
        } else {
            exponent
        };
        end = from + count;
    }
    (end, power)
}

#[cfg(test)]
mod tests {
    use super::first_excessive_number;

    #[test]
    fn excessive_numbers_are_found() {
        for text in [
            "M0 0a1e10 5 0 0 1 9 9",
            "0,-12345678901.5",
            "scale(.5e+12)",
            "3e99999999999999999999",
            "M1e38",
        ] {
            assert!(first_excessive_number(text).is_some(), "{text}");
        }
        for text in [
            "",
            "M10-20.5.5e-30z",
            "000000000000001",
            "1.00000000000000000001",
            "123456789",
            "1e8",
            "10em",
            "5e",
            "-",
            "é1",
            "1e-99999999999999999999",
            "0.12345678901234",
        ] {
            assert_eq!(first_excessive_number(text), None, "{text}");
        }
    }
}
