//! Parsers for numbers that users type.

/// Parses `N` finite numbers separated by commas.
pub(crate) fn numbers<const N: usize>(text: &str) -> Result<[f64; N], String> {
    let parsed: Result<Vec<f64>, _> = text.split(',').map(|part| part.trim().parse()).collect();
    let parsed = parsed
        .ok()
        .filter(|all| all.iter().all(|number| number.is_finite()));
    parsed
        .and_then(|all| all.try_into().ok())
        .ok_or_else(|| format!("expected {N} comma-separated numbers"))
}

/// Parses a finite number above 0.
pub(crate) fn positive(text: &str) -> Result<f64, String> {
    let value = text
        .parse::<f64>()
        .ok()
        .filter(|value| value.is_finite() && *value > 0.0);
    value.ok_or_else(|| "expected a number above 0".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_commas_between_them() {
        assert_eq!(numbers::<3>("1,-2, 3.5"), Ok([1.0, -2.0, 3.5]));
        for wrong in ["", "1,2", "1,2,3,4", "1,2,inf", "a,b,c"] {
            assert!(numbers::<3>(wrong).is_err(), "{wrong}");
        }
    }
}
