//! Colours of objects, by name or code.

/// A colour: red, green and blue from 0 to 255.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Color(pub [u8; 3]);

impl Color {
    /// Colour of an object without one in the file.
    pub const GREY: Self = Self([128, 128, 128]);

    /// Named colours.
    pub const NAMED: [(&'static str, Self); 10] = [
        ("red", Self([255, 0, 0])),
        ("green", Self([0, 255, 0])),
        ("blue", Self([0, 0, 255])),
        ("yellow", Self([255, 255, 0])),
        ("orange", Self([255, 128, 0])),
        ("purple", Self([128, 0, 128])),
        ("black", Self([0, 0, 0])),
        ("white", Self([255, 255, 255])),
        ("grey", Self::GREY),
        ("gray", Self::GREY),
    ];

    /// Parses a colour name or `#rrggbb`.
    #[must_use]
    pub fn parse(text: &str) -> Option<Self> {
        if let Some(hex) = text.strip_prefix('#') {
            // `from_str_radix` alone would accept a sign and fewer digits.
            let digits = hex.len() == 6 && hex.bytes().all(|byte| byte.is_ascii_hexdigit());
            let [_, r, g, b] = u32::from_str_radix(hex, 16)
                .ok()
                .filter(|_| digits)?
                .to_be_bytes();
            return Some(Self([r, g, b]));
        }
        Self::NAMED
            .iter()
            .find(|(name, _)| *name == text)
            .map(|(_, color)| *color)
    }

    pub(super) fn names() -> String {
        Self::NAMED.map(|(name, _)| name).join(", ")
    }
}
