//! Contour filling: rings from the edge inwards, joined to one line where the next ring is near.

use super::region::Region;
use crate::artwork::distance;

/// Largest distance of rings that are joined, in spacings. The next ring is one spacing away along
/// an edge, and farther at corners.
const MAX_JOIN_DISTANCE: f64 = 1.5;

/// Insets at which a part narrower than twice the first is tested for its middle line, in spacings.
const THIN_INSETS: [f64; 5] = [0.16, 0.12, 0.08, 0.04, 0.0];
/// Insets at which the middle of the rest between two rings is searched, in spacings.
const MIDDLE_INSETS: [f64; 6] = [0.95, 0.85, 0.75, 0.65, 0.55, 0.5];

/// Returns the rings of a region, from its edge inwards.
pub(super) fn lines(region: &Region, spacing: f64) -> Vec<Vec<[f64; 2]>> {
    let mut lines: Vec<Vec<[f64; 2]>> = Vec::new();
    let mut layer = region.clone();
    // Each ring is narrower than the one before, so this bounds their number even if rounding goes
    // wrong.
    let most = (region.size() / spacing) as usize + 1;
    for nth in 1..=most {
        if layer.is_empty() {
            break;
        }
        for part in layer.parts() {
            // In a thin part the ring of a hole would repeat the middle line.
            let mut inner = THIN_INSETS
                .iter()
                .map(|share| part.offset(-spacing * share));
            let middle = match inner.next() {
                Some(inner) if !inner.is_empty() => None,
                _ => inner.find(|inner| !inner.is_empty()),
            };
            let once = middle.iter().flat_map(Region::outlines);
            let rings = part.rings().filter(|_| middle.is_none());
            for ring in once.chain(rings) {
                add(&mut lines, ring, spacing);
            }
        }
        // Offset from the edge itself, not from the last ring, so that rounding errors do not
        // accumulate.
        let next = region.offset(-spacing * nth as f64);
        // Parts too narrow for another ring get a line along their middle. The factor 1.02 covers
        // slivers that rounding leaves.
        let passed = next.offset(spacing * 1.02);
        let mut narrow = layer.without(&passed, spacing);
        for share in MIDDLE_INSETS {
            if narrow.is_empty() {
                break;
            }
            let middle = narrow.offset(-spacing * share);
            // The middle of a narrow part is thin too.
            for ring in middle.outlines() {
                add(&mut lines, ring, spacing);
            }
            narrow = narrow.without(&middle.offset(spacing * share * 1.02), spacing);
        }
        layer = next;
    }
    lines
}

/// Appends a ring to the line that ends near it, or starts a new line.
fn add(lines: &mut Vec<Vec<[f64; 2]>>, ring: &[[f64; 2]], spacing: f64) {
    let ends = lines.iter().enumerate().filter_map(|(which, line)| {
        let (far, begun) = rotated_to_start_near(ring, *line.last()?)?;
        (far <= MAX_JOIN_DISTANCE * spacing).then_some((which, far, begun))
    });
    let near = ends.min_by(|one, other| one.1.total_cmp(&other.1));
    match near {
        Some((which, _, begun)) => lines[which].extend(begun),
        // At a sharp corner the next ring is too far to be joined.
        None => lines
            .extend(rotated_to_start_near(ring, middle_of_longest(ring)).map(|(_, begun)| begun)),
    }
}

/// Rotates a ring to start at its point nearest to `to`, and returns the distance.
fn rotated_to_start_near(ring: &[[f64; 2]], to: [f64; 2]) -> Option<(f64, Vec<[f64; 2]>)> {
    let next = ring.iter().cycle().skip(1);
    let edges = ring.iter().zip(next).enumerate();
    let nearest = edges.map(|(which, (a, b))| {
        let way = [b[0] - a[0], b[1] - a[1]];
        let length = way[0] * way[0] + way[1] * way[1];
        let share = ((to[0] - a[0]) * way[0] + (to[1] - a[1]) * way[1]) / length;
        let share = share.clamp(0.0, 1.0);
        let at = [0, 1].map(|side| a[side] + way[side] * share);
        (distance(at, to), which, at)
    });
    let (far, which, at) = nearest.min_by(|one, other| one.0.total_cmp(&other.0))?;
    let (before, behind) = ring.split_at_checked(which + 1)?;
    let corners = behind.iter().chain(before);
    let whole = [at].into_iter().chain(corners.copied()).chain([at]);
    Some((far, whole.collect()))
}

fn middle_of_longest(ring: &[[f64; 2]]) -> [f64; 2] {
    let next = ring.iter().cycle().skip(1);
    let edges = ring.iter().zip(next);
    let longest = edges
        .max_by(|one, other| distance(*one.0, *one.1).total_cmp(&distance(*other.0, *other.1)));
    longest.map_or([0.0; 2], |(a, b)| {
        [0, 1].map(|side| f64::midpoint(a[side], b[side]))
    })
}
