//! Resampling of an image to the pixels that the laser burns.

use super::Raster;

/// Part of the source covered by one target pixel, in source pixels.
#[derive(Clone, Copy)]
struct SourceSpan {
    from: f64,
    to: f64,
    first: usize,
    last: usize,
}

impl SourceSpan {
    fn new(nth: usize, target: usize, source: usize) -> Self {
        let edge = |nth: usize| nth as f64 * source as f64 / target as f64;
        let (from, to) = (edge(nth), edge(nth + 1));
        let most = source - 1;
        Self {
            from,
            to,
            first: (from as usize).min(most),
            last: ((to.ceil() as usize).saturating_sub(1)).min(most),
        }
    }

    /// Share of its length within this source pixel.
    fn share(&self, pixel: usize) -> f64 {
        let overlap = self.to.min((pixel + 1) as f64) - self.from.max(pixel as f64);
        (overlap / (self.to - self.from)).max(0.0)
    }
}

/// Resamples the image to this many columns and rows. Each cell is the mean of the grey values (as
/// stored) in its area.
pub(super) fn resample(image: &Raster, columns: usize, rows: usize) -> Vec<u8> {
    resample_plane(&image.grey, image, columns, rows)
}

/// Opacity of the same cells; empty if the image is opaque. Grey values are those over white, so a
/// pixel already counts by its opacity.
pub(super) fn resample_opacity(image: &Raster, columns: usize, rows: usize) -> Vec<u8> {
    if image.opacity.is_empty() {
        Vec::new()
    } else {
        resample_plane(&image.opacity, image, columns, rows)
    }
}

fn resample_plane(plane: &[u8], image: &Raster, columns: usize, rows: usize) -> Vec<u8> {
    if (columns, rows) == (image.width, image.height) {
        return plane.to_vec();
    }
    let spans: Vec<SourceSpan> = (0..columns)
        .map(|nth| SourceSpan::new(nth, columns, image.width))
        .collect();
    let mut cells = Vec::with_capacity(columns * rows);
    let mut line = SampledRow::default();
    let mut sums = vec![0.0; columns];
    for row in 0..rows {
        let span = SourceSpan::new(row, rows, image.height);
        sums.fill(0.0);
        for source in span.first..=span.last {
            let share = span.share(source);
            let narrowed = line.of((plane, image.width), source, &spans);
            for (sum, value) in sums.iter_mut().zip(narrowed) {
                *sum += value * share;
            }
        }
        cells.extend(sums.iter().map(|sum| sum.round().clamp(0.0, 255.0) as u8));
    }
    cells
}

/// Source row that was reduced last: adjacent target rows share one.
#[derive(Default)]
struct SampledRow {
    row: Option<usize>,
    narrowed: Vec<f64>,
}

impl SampledRow {
    fn of(&mut self, (plane, width): (&[u8], usize), row: usize, spans: &[SourceSpan]) -> &[f64] {
        if self.row != Some(row) {
            let start = row * width;
            let source = plane.get(start..start + width).unwrap_or_default();
            self.narrowed.clear();
            self.narrowed
                .extend(spans.iter().map(|span| mean(source, span)));
            self.row = Some(row);
        }
        &self.narrowed
    }
}

fn mean(source: &[u8], span: &SourceSpan) -> f64 {
    let covered = source.get(span.first..=span.last).unwrap_or_default();
    match covered {
        [one] => f64::from(*one),
        [one, inner @ .., other] => {
            let inner: u32 = inner.iter().map(|value| u32::from(*value)).sum();
            f64::from(*one) * span.share(span.first)
                + f64::from(inner) / (span.to - span.from)
                + f64::from(*other) * span.share(span.last)
        }
        [] => 0.0,
    }
}
