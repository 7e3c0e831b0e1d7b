//! Comparison of secrets: resume secrets of sessions, digests of tokens and codes.

/// Compares two secrets in a time that does not depend on where they differ.
pub(crate) fn same_secret(one: &str, other: &str) -> bool {
    // `==` stops at the first difference, which can be measured over the network.
    let bytes = one.bytes().zip(other.bytes());
    let differ = bytes.fold(0, |sum, (a, b)| sum | (a ^ b));
    one.len() == other.len() && differ == 0
}
