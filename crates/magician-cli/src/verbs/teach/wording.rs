//! Wording of results of teaching.

use magician_job::teach::TeachError;

/// Returns the reason why nothing was changed.
pub(super) const fn refusal(error: TeachError) -> &'static str {
    match error {
        TeachError::Empty => "no points yet: Enter stores the arm's position",
        TeachError::NoTarget => "this row has no position to teach",
        TeachError::IsArc => "an arc keeps its motion; teach it again to change it",
        TeachError::NotAMove => "this row is not a move to a point",
        TeachError::Moving => "the arm is moving: wait until it stops",
        TeachError::NoAnswer => "the arm does not answer: its position is unknown",
        _ => "this cannot be taught",
    }
}

/// Parses a pause in seconds. Returns milliseconds.
pub(super) fn pause(text: &str) -> Result<u32, &'static str> {
    let text = text.trim().trim_end_matches('s').trim_end();
    let seconds = if text.is_empty() {
        Ok(0.0)
    } else {
        text.parse::<f64>()
    };
    let seconds = seconds.ok().filter(|seconds| (0.0..=4e6).contains(seconds));
    let seconds = seconds.ok_or("enter seconds, such as 0.5")?;
    Ok((seconds * 1000.0).round() as u32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pauses_are_seconds() {
        for (text, wanted) in [
            ("2", 2000),
            ("0.25s", 250),
            ("1.25 s", 1250),
            ("", 0),
            ("1e3", 1_000_000),
        ] {
            assert_eq!(pause(text), Ok(wanted));
        }
        for wrong in ["-1", "nan", "inf", "soon", "1e9"] {
            assert!(pause(wrong).is_err(), "{wrong}");
        }
    }
}
