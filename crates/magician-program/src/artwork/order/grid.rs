//! Points in cells, to find the nearest.

use super::super::distance;

/// Points of some owners, sorted into square cells.
pub(super) struct Grid {
    least: [f64; 2],
    cell: f64,
    across: usize,
    down: usize,
    cells: Vec<Vec<Entry>>,
}

/// A point, and whose it is.
#[derive(Clone, Copy, Debug)]
pub(super) struct Entry {
    pub(super) at: [f64; 2],
    pub(super) owner: usize,
    /// Which of the owner's points.
    pub(super) which: usize,
}

impl Grid {
    /// About two points go into each cell.
    pub(super) fn new(entries: impl Iterator<Item = Entry> + Clone) -> Self {
        let (mut least, mut most, mut count) =
            ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2], 0_usize);
        for entry in entries.clone() {
            count += 1;
            for axis in 0..2 {
                least[axis] = least[axis].min(entry.at[axis]);
                most[axis] = most[axis].max(entry.at[axis]);
            }
        }
        let [width, height] = [0, 1].map(|axis| (most[axis] - least[axis]).max(0.0));
        let area = (width * height).max(width.max(height) * 1e-3);
        let cell = (2.0 * area / count.max(1) as f64).sqrt().max(1e-6);
        let cell = cell.max(width.max(height) / 4000.0);
        let fit = |side: f64| (side / cell) as usize + 1;
        let (across, down) = (fit(width), fit(height));
        let mut grid = Self {
            least,
            cell,
            across,
            down,
            cells: vec![Vec::new(); across * down],
        };
        for entry in entries {
            let [i, j] = grid.place(entry.at);
            let at = grid.index(i, j);
            if let Some(cell) = at.and_then(|at| grid.cells.get_mut(at)) {
                cell.push(entry);
            }
        }
        grid
    }

    /// Entries in cells around a point, one ring of cells after the other, as long as `go_on` wants with the distance that all
    /// that follow have at least. Those that `keep` does not want are dropped for good.
    pub(super) fn around(
        &mut self,
        at: [f64; 2],
        keep: impl Fn(&Entry) -> bool,
        mut go_on: impl FnMut(&[Entry], f64) -> bool,
    ) {
        let [i, j] = self.place(at);
        for ring in 0..self.across.max(self.down) as i64 {
            for (x, y) in ring_cells(i, j, ring) {
                let Some(cell) = self.index(x, y).and_then(|at| self.cells.get_mut(at)) else {
                    continue;
                };
                cell.retain(&keep);
                if !go_on(cell, 0.0) {
                    return;
                }
            }
            if !go_on(&[], ring as f64 * self.cell) {
                return;
            }
        }
    }

    /// The cell of a point, the nearest one of a point outside.
    fn place(&self, at: [f64; 2]) -> [i64; 2] {
        let last = [self.across, self.down].map(|count| count as i64 - 1);
        [0, 1].map(|axis| {
            let cell = (at[axis] - self.least[axis]) / self.cell;
            (cell as i64).clamp(0, last[axis])
        })
    }

    fn index(&self, i: i64, j: i64) -> Option<usize> {
        let (i, j) = (usize::try_from(i).ok()?, usize::try_from(j).ok()?);
        (i < self.across && j < self.down).then_some(j * self.across + i)
    }

    /// The nearest entry that is to be kept.
    pub(super) fn nearest(&mut self, at: [f64; 2], keep: impl Fn(&Entry) -> bool) -> Option<Entry> {
        let mut best: Option<(f64, Entry)> = None;
        self.around(at, keep, |entries, least| {
            for entry in entries {
                let way = distance(at, entry.at);
                if best.is_none_or(|(known, _)| way < known) {
                    best = Some((way, *entry));
                }
            }
            // A ring of cells away, nothing is nearer than the ring.
            best.is_none_or(|(known, _)| known > least)
        });
        best.map(|(_, entry)| entry)
    }

    /// The nearest entries, but those of one owner.
    pub(super) fn neighbours(&mut self, at: [f64; 2], but: usize, count: usize) -> Vec<Entry> {
        let mut found: Vec<(f64, Entry)> = Vec::new();
        self.around(
            at,
            |_| true,
            |entries, least| {
                let others = entries.iter().filter(|entry| entry.owner != but);
                found.extend(others.map(|entry| (distance(at, entry.at), *entry)));
                found.iter().filter(|(way, _)| *way <= least).count() < count
            },
        );
        found.sort_by(|one, other| one.0.total_cmp(&other.0));
        found.truncate(count);
        found.into_iter().map(|(_, entry)| entry).collect()
    }
}

/// The cells so many steps away from one.
fn ring_cells(i: i64, j: i64, ring: i64) -> impl Iterator<Item = (i64, i64)> {
    let rows = (-ring..=ring).flat_map(move |x| [(i + x, j - ring), (i + x, j + ring)]);
    let columns = (1 - ring..ring).flat_map(move |y| [(i - ring, j + y), (i + ring, j + y)]);
    // The innermost ring is one cell, not two.
    rows.chain(columns)
        .take(if ring == 0 { 1 } else { usize::MAX })
}
