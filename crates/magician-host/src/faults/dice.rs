//! Deterministic random numbers.

/// Random numbers from a seed (SplitMix64), the same on every platform.
#[derive(Clone, Debug)]
pub struct Dice(u64);

impl Dice {
    /// Creates the generator of a seed.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// Returns the next 64 random bits.
    pub fn number(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        // Constants of SplitMix64.
        let mixed = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        mixed ^ (mixed >> 31)
    }

    /// Returns a number from 0 to below 1, in steps that `f64` represents exactly.
    pub fn share(&mut self) -> f64 {
        const STEP: f64 = 1.0 / (1u64 << 53) as f64;
        // 53 bits, the precision of `f64`.
        (self.number() >> 11) as f64 * STEP
    }

    /// Returns true with this probability, 0 to 1.
    pub fn chance(&mut self, rate: f64) -> bool {
        self.share() < rate
    }

    /// Returns a number from 0 to below `end`; 0 if `end` is 0.
    pub fn below(&mut self, end: u64) -> u64 {
        // The bias of the remainder is negligible for such small ranges.
        self.number().checked_rem(end).unwrap_or(0)
    }

    /// Returns a random byte.
    pub fn byte(&mut self) -> u8 {
        (self.number() >> 56) as u8
    }
}
