//! How far the arm reaches at a height.

use magician_motion::{Geometry, Limits};

/// The section of the reach in a plane through the base axis: radius and z of the tool, all round.
pub(super) fn section(arm: &Geometry, limits: &Limits) -> Vec<(f64, f64)> {
    let section = magician_picture::section(arm, limits);
    section.into_iter().map(|[radius, z]| (radius, z)).collect()
}

/// Smallest and largest radius at a height, `None` where the arm cannot be.
pub(super) fn radii_at(section: &[(f64, f64)], z: f64) -> Option<(f64, f64)> {
    let next = section.iter().cycle().skip(1);
    let crossings = section
        .iter()
        .zip(next)
        .filter(|(a, b)| (a.1 < z) != (b.1 < z));
    let radii = crossings.map(|(a, b)| a.0 + (b.0 - a.0) * (z - a.1) / (b.1 - a.1));
    radii.fold(None, |range: Option<(f64, f64)>, radius| match range {
        None => Some((radius, radius)),
        Some((low, high)) => Some((low.min(radius), high.max(radius))),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use magician_motion::ArmModel;
    use magician_motion::ToolBias;

    #[test]
    fn a_height_beyond_the_section_has_no_radii() {
        let section = section(
            &Geometry::magician(ToolBias::SUCTION),
            &ArmModel::MAGICIAN.certain,
        );
        assert!(radii_at(&section, 0.0).is_some());
        assert_eq!(radii_at(&section, 500.0), None);
    }
}
