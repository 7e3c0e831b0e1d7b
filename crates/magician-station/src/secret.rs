//! Secrets: the session's to come back with, and digests of tokens and codes.

/// Whether two secrets are the same, in a time that does not tell where they differ.
pub(crate) fn same_secret(one: &str, other: &str) -> bool {
    let bytes = one.bytes().zip(other.bytes());
    let differ = bytes.fold(0, |sum, (a, b)| sum | (a ^ b));
    one.len() == other.len() && differ == 0
}
