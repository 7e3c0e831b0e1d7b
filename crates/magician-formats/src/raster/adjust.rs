//! Brightness, contrast, inversion and gamma of images.

use super::Raster;

/// Adjustment of the grey values of an image.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Adjust {
    /// Brightness: -100 is all black, 100 all white.
    pub brightness: f64,
    /// Contrast about middle grey: -100 is all grey, 100 black and white only.
    pub contrast: f64,
    /// True to swap black and white.
    pub invert: bool,
    /// Exponent applied to the darkness (0 to 1). Above 1 it lightens the light parts.
    pub gamma: f64,
}

impl Default for Adjust {
    fn default() -> Self {
        Self {
            brightness: 0.0,
            contrast: 0.0,
            invert: false,
            gamma: 1.0,
        }
    }
}

impl Adjust {
    /// Lookup table per grey value: brightness, contrast, inversion, gamma, in this order.
    fn table(&self) -> [u8; 256] {
        let steepness = match self.contrast / 100.0 {
            flat if flat <= 0.0 => 1.0 + flat,
            steep => 1.0 / (1.0 - steep).max(1e-6),
        };
        let mut table = [0; 256];
        for (grey, made) in table.iter_mut().enumerate() {
            let light = grey as f64 / 255.0 + self.brightness / 100.0;
            let light = ((light - 0.5) * steepness + 0.5).clamp(0.0, 1.0);
            let darkness = if self.invert { light } else { 1.0 - light };
            let light = 1.0 - libm::pow(darkness, self.gamma);
            *made = (light * 255.0).round() as u8;
        }
        table
    }
}

/// Darkness of a pixel itself, from its darkness composed over white paper.
pub(super) fn own_darkness(seen: u8, opacity: u8) -> u8 {
    let (seen, opacity) = (u32::from(seen), u32::from(opacity));
    let own = (seen * 255 + opacity / 2).checked_div(opacity).unwrap_or(0);
    u8::try_from(own).unwrap_or(u8::MAX)
}

/// Darkness of a pixel composed over white paper.
pub(super) fn seen(own: u8, opacity: u8) -> u8 {
    u8::try_from((u32::from(own) * u32::from(opacity) + 127) / 255).unwrap_or(u8::MAX)
}

impl Raster {
    /// Returns the image with adjusted greys. Transparency is kept: the pixel's own grey is
    /// adjusted and composed over white again.
    ///
    /// ```
    /// use magician_formats::Raster;
    /// use magician_formats::raster::Adjust;
    ///
    /// let image = Raster { width: 3, height: 1, grey: vec![0, 100, 255], ..Raster::default() };
    /// let mut adjust = Adjust::default();
    /// adjust.brightness = 20.0;
    /// assert_eq!(image.clone().adjusted(&adjust).grey, [51, 151, 255]);
    /// adjust.invert = true;
    /// assert_eq!(image.adjusted(&adjust).grey, [204, 104, 0]);
    /// ```
    #[must_use]
    pub fn adjusted(mut self, adjust: &Adjust) -> Self {
        if *adjust == Adjust::default() {
            return self;
        }
        let table = adjust.table();
        let Self { grey, opacity, .. } = &mut self;
        if opacity.is_empty() {
            grey.iter_mut()
                .for_each(|grey| *grey = table[usize::from(*grey)]);
        }
        for (grey, opacity) in grey.iter_mut().zip(opacity) {
            let own = 255 - own_darkness(255 - *grey, *opacity);
            *grey = 255 - seen(255 - table[usize::from(own)], *opacity);
        }
        self
    }
}
