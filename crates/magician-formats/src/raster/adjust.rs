//! The greys of an image before anything is made of them.

use super::Raster;

/// How the greys of an image are changed before it is drawn or burnt.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Adjust {
    /// -100 makes all of it black, 100 all of it white.
    pub brightness: f64,
    /// About the middle grey: -100 makes all of it that grey, 100 black and white.
    pub contrast: f64,
    /// White becomes black and black white.
    pub invert: bool,
    /// Exponent of the darkness (0 to 1); above 1 spares the light parts.
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
    /// What becomes of each grey: brightness, then contrast, then the other way round, then gamma.
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

/// The darkness of a pixel of this opacity that shows so dark over white.
pub(super) fn own_darkness(seen: u8, opacity: u8) -> u8 {
    let (seen, opacity) = (u32::from(seen), u32::from(opacity));
    let own = (seen * 255 + opacity / 2).checked_div(opacity).unwrap_or(0);
    u8::try_from(own).unwrap_or(u8::MAX)
}

/// How dark a pixel of this opacity shows over white that is so dark itself.
pub(super) fn seen(own: u8, opacity: u8) -> u8 {
    u8::try_from((u32::from(own) * u32::from(opacity) + 127) / 255).unwrap_or(u8::MAX)
}

impl Raster {
    /// The image with other greys.
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
