//! Digests that tell two contents apart.

/// Returns the 128-bit FNV-1a of `first`, then of the length of each other part and the part, as
/// hexadecimal digits.
///
/// It guards against mix-ups and not against forgery, so a fast hash suffices, which also keeps the
/// station of a page small.
pub(crate) fn digest(first: &[u8], others: &[&[u8]]) -> String {
    // Offset basis and prime of FNV-1a for 128 bits.
    let offset: u128 = 0x6c62_272e_07bb_0142_62b8_2175_6295_c58d;
    let prime = 0x0100_0000_0000_0000_0000_013b;
    let step = |hash: u128, byte: &u8| (hash ^ u128::from(*byte)).wrapping_mul(prime);
    // Stored digests of orders have one part, without a length.
    let hash = first.iter().fold(offset, step);
    let hash = others.iter().fold(hash, |hash, part| {
        let length = (part.len() as u64).to_le_bytes();
        part.iter().fold(length.iter().fold(hash, step), step)
    });
    format!("{hash:032x}")
}
