//! Images, and how they become laser power.

/// A grey image.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Raster {
    /// What it is called.
    pub title: String,
    /// Pixels across.
    pub width: usize,
    /// Pixels down.
    pub height: usize,
    /// Row by row from the top, 0 black to 255 white; what is transparent is white.
    pub grey: Vec<u8>,
}
