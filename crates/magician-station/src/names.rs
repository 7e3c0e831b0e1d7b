//! Names of arms, sites and machines.

/// Most characters of a name.
pub const MAX_NAME_LENGTH: usize = 32;

/// True if the text matches `[a-z0-9][a-z0-9_-]{0,31}`.
#[must_use]
pub fn is_name(text: &str) -> bool {
    let sign = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_' || c == '-';
    !text.is_empty()
        && text.len() <= MAX_NAME_LENGTH
        && !text.starts_with(['_', '-'])
        && text.chars().all(sign)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn name_is_lower_case_and_starts_with_a_letter_or_digit() {
        for name in ["a", "0", "a1_-", &"x".repeat(32)] {
            assert!(is_name(name), "{name}");
        }
        let long = "x".repeat(33);
        for wrong in [
            "", "A", "_a", "-a", "a/b", "*", "a*", "ä", "a b", "$*", &long,
        ] {
            assert!(!is_name(wrong), "{wrong}");
        }
    }
}
