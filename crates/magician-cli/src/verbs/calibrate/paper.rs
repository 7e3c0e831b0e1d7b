//! Common paper sizes.

/// Names with shorter and longer side, mm (ISO 216; ANSI/ASME Y14.1).
const PAPER_SIZES: [(&str, [f64; 2]); 9] = [
    ("A6", [105.0, 148.0]),
    ("A5", [148.0, 210.0]),
    ("A4", [210.0, 297.0]),
    ("A3", [297.0, 420.0]),
    ("B5", [176.0, 250.0]),
    ("Letter", [215.9, 279.4]),
    ("Legal", [215.9, 355.6]),
    ("a postcard of 100 by 150", [100.0, 150.0]),
    ("an index card of 3 by 5 in", [76.2, 127.0]),
];
/// Largest deviation of a side from a known size, mm. A choice: corners touched by hand are a few
/// millimetres off, and the sizes differ by more.
const SIZE_TOLERANCE: f64 = 6.0;

/// Known paper size that a sheet resembles.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub(super) struct Paper {
    pub(super) name: &'static str,
    /// True if the paper lies on its longer side.
    pub(super) landscape: bool,
    /// Deviation of the worse side, mm.
    pub(super) off: f64,
}

impl Paper {
    /// Returns the most similar paper size; `None` if none is similar.
    pub(super) fn most_similar([width, height]: [f64; 2]) -> Option<Self> {
        let landscape = width > height;
        let sides = [width.min(height), width.max(height)];
        let off = |known: [f64; 2]| (sides[0] - known[0]).abs().max((sides[1] - known[1]).abs());
        let papers = PAPER_SIZES.into_iter().map(|(name, known)| Self {
            name,
            landscape,
            off: (off(known) * 10.0).round() / 10.0,
        });
        let near = papers.filter(|paper| paper.off <= SIZE_TOLERANCE);
        near.min_by(|one, other| one.off.total_cmp(&other.off))
    }
}

/// Formats as `A4, landscape, 0.8 mm off`.
impl std::fmt::Display for Paper {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let lies = if self.landscape { ", landscape" } else { "" };
        write!(f, "{}{lies}, {} mm off", self.name, self.off)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paper_is_known_by_its_size() {
        let most_similar = |size| Paper::most_similar(size).map(|paper| paper.to_string());
        assert_eq!(
            most_similar([210.4, 296.2]),
            Some("A4, 0.8 mm off".to_owned())
        );
        let lying = Some("A5, landscape, 1 mm off".to_owned());
        assert_eq!(most_similar([211.0, 148.0]), lying);
        assert_eq!(
            most_similar([216.0, 279.0]),
            Some("Letter, 0.4 mm off".to_owned())
        );
        assert_eq!(most_similar([120.0, 90.0]), None);
    }
}
