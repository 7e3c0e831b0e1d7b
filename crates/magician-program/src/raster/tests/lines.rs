//! Images as pen lines: their grey levels, and the centre lines of scans.

use crate::artwork::{Tidy, distance};
use crate::raster::{ImageStyle, Raster, Size, Trace};
use crate::{Artwork, Content, Format, ReadOptions, Stroke, read};

/// Ink on paper from a pen of a certain width.
struct Paper {
    width: usize,
    height: usize,
    /// Cells per mm.
    cells_per_mm: f64,
    ink: Vec<bool>,
}

impl Paper {
    fn with(artwork: &Artwork, [width, height]: [f64; 2], pen: f64, cells_per_mm: f64) -> Self {
        let [width, height] = [width, height].map(|side| (side * cells_per_mm).round() as usize);
        let mut paper = Self {
            width,
            height,
            cells_per_mm,
            ink: vec![false; width * height],
        };
        for [from, to] in pieces(&artwork.strokes) {
            paper.line(from, to, pen / 2.0);
        }
        paper
    }

    fn line(&mut self, from: [f64; 2], to: [f64; 2], radius: f64) {
        let cell = |at: f64, most: usize| {
            (at * self.cells_per_mm).floor().clamp(0.0, most as f64) as usize
        };
        let span = |axis: usize, most: usize| {
            let [low, high] = [from[axis].min(to[axis]), from[axis].max(to[axis])];
            cell(low - radius, most)..cell(high + radius + 1.0 / self.cells_per_mm, most)
        };
        for y in span(1, self.height) {
            for x in span(0, self.width) {
                let at = [x, y].map(|cell| (cell as f64 + 0.5) / self.cells_per_mm);
                if distance_to_segment(at, from, to) <= radius {
                    self.ink[y * self.width + x] = true;
                }
            }
        }
    }

    /// Share of ink between two x positions, mm.
    fn share(&self, from: f64, to: f64) -> f64 {
        let columns = (from * self.cells_per_mm) as usize
            ..((to * self.cells_per_mm) as usize).min(self.width);
        let rows = (0..self.height).map(|row| row * self.width);
        let cells = rows.flat_map(|row| columns.clone().map(move |column| row + column));
        let (inked, all) = cells.fold((0.0, 0.0), |(inked, all), cell| {
            (inked + f64::from(u8::from(self.ink[cell])), all + 1.0)
        });
        inked / all
    }
}

/// Straight pieces of lines; a dot is one piece.
fn pieces(strokes: &[Stroke]) -> impl Iterator<Item = [[f64; 2]; 2]> {
    strokes.iter().flat_map(|stroke| {
        let last = stroke.points.last();
        let next = stroke.points.iter().skip(1).chain(last);
        stroke
            .points
            .iter()
            .zip(next)
            .map(|(from, to)| [*from, *to])
    })
}

fn distance_to_segment(at: [f64; 2], from: [f64; 2], to: [f64; 2]) -> f64 {
    let way = [to[0] - from[0], to[1] - from[1]];
    let length = (way[0] * way[0] + way[1] * way[1]).max(1e-12);
    let along = ((at[0] - from[0]) * way[0] + (at[1] - from[1]) * way[1]) / length;
    let along = along.clamp(0.0, 1.0);
    distance(at, [from[0] + along * way[0], from[1] + along * way[1]])
}

/// Wedge of steps from white to black, and the darkness of each.
fn wedge(steps: usize) -> (Raster, Vec<f64>) {
    let each = 40;
    let darkness: Vec<f64> = { 0..steps }
        .map(|nth| nth as f64 / (steps - 1) as f64)
        .collect();
    let row: Vec<u8> = { darkness.iter() }
        .flat_map(|dark| vec![(255.0 * (1.0 - dark)).round() as u8; each])
        .collect();
    let image = Raster {
        width: row.len(),
        height: 100,
        grey: row.repeat(100),
        ..Raster::default()
    };
    (image, darkness)
}

/// Share of ink minus darkness, for each step of a wedge with steps of 12 mm.
fn errors(trace: &Trace) -> Vec<f64> {
    let (image, darkness) = wedge(11);
    let trace = Trace {
        size: Size::Width(132.0),
        ..trace.clone()
    };
    let artwork = trace.lines(&image).unwrap().artwork;
    let page = artwork.page.unwrap();
    let paper = Paper::with(&artwork, page, trace.pen_width, 20.0);
    let shares = darkness.iter().enumerate().map(|(nth, dark)| {
        let from = nth as f64 * 12.0;
        paper.share(from, from + 12.0) - dark
    });
    shares.collect()
}

#[test]
fn ink_of_each_grey_step_matches_its_tone() {
    for style in [
        ImageStyle::Halftone,
        ImageStyle::Squiggle,
        ImageStyle::Hatch,
    ] {
        for pen_width in [0.35, 0.5] {
            let trace = Trace {
                style,
                pen_width,
                ..Trace::default()
            };
            let off = errors(&trace);
            let mean = off.iter().map(|off| off.abs()).sum::<f64>() / off.len() as f64;
            assert!(
                mean < 0.05,
                "{style} with {pen_width}: {mean:.3}, {off:.3?}"
            );
            // A layer of hatching is present or absent: the error is at most half a layer.
            let most = if style == ImageStyle::Hatch {
                0.09
            } else {
                0.05
            };
            assert!(
                off.iter().all(|off| off.abs() < most),
                "{style} with {pen_width}: {off:.3?}"
            );
        }
    }
}

/// Drawing as scanned at 300 dpi, with lines of this width.
fn scanned(artwork: &Artwork, page: [f64; 2], pen: f64) -> Raster {
    const DPI: f64 = 300.0;
    const OVERSAMPLING: usize = 3;
    let pixels_per_mm = DPI / 25.4;
    let paper = Paper::with(artwork, page, pen, pixels_per_mm * OVERSAMPLING as f64);
    let [width, height] = page.map(|side| (side * pixels_per_mm) as usize);
    let grey = (0..width * height).map(|at| {
        let [x, y] = [at % width, height - 1 - at / width];
        let cells = (0..OVERSAMPLING * OVERSAMPLING).map(|nth| {
            [
                x * OVERSAMPLING + nth % OVERSAMPLING,
                y * OVERSAMPLING + nth / OVERSAMPLING,
            ]
        });
        let inked = cells
            .filter(|[x, y]| paper.ink[y * paper.width + x])
            .count();
        255 - (inked * 255 / (OVERSAMPLING * OVERSAMPLING)) as u8
    });
    Raster {
        width,
        height,
        grey: grey.collect(),
        pixel: Some([1.0 / pixels_per_mm; 2]),
        ..Raster::default()
    }
}

/// Largest distance of a point on `lines` from the lines in `from`, and that point.
fn farthest(lines: &[Stroke], from: &[Stroke]) -> (f64, [f64; 2]) {
    let mut far = (0.0, [0.0; 2]);
    for pair in pieces(lines) {
        let steps = (distance(pair[0], pair[1]) / 0.1).ceil().max(1.0);
        for step in 0..=steps as usize {
            let share = step as f64 / steps;
            let at = [0, 1].map(|axis| pair[0][axis] + share * (pair[1][axis] - pair[0][axis]));
            let near = pieces(from).map(|[from, to]| distance_to_segment(at, from, to));
            let near = near.fold(f64::INFINITY, f64::min);
            if near > far.0 {
                far = (near, at);
            }
        }
    }
    far
}

fn text(words: &str, size: f64) -> (Artwork, [f64; 2]) {
    let mut options = ReadOptions::default();
    options.text.size = size;
    let Content::Artwork(mut artwork) = read(Format::Text, words.as_bytes(), &options)
        .unwrap()
        .content
    else {
        panic!("text is lines")
    };
    let [least, most] = artwork.bounds().unwrap();
    for point in artwork
        .strokes
        .iter_mut()
        .flat_map(|stroke| &mut stroke.points)
    {
        *point = [0, 1].map(|axis| point[axis] - least[axis] + 3.0);
    }
    (artwork, [0, 1].map(|axis| most[axis] - least[axis] + 6.0))
}

#[test]
fn a_scanned_text_is_traced_along_its_lines() {
    let words =
        "The quick brown fox\njumps over the lazy dog\nABCDEFGHIJKLM\nNOPQRSTUVWXYZ\n0123456789";
    for (size, pen) in [(8.0, 0.3), (8.0, 0.5), (14.0, 0.5)] {
        let (mut drawn, page) = text(words, size);
        let image = scanned(&drawn, page, pen);
        let trace = Trace {
            style: ImageStyle::Centerline,
            ..Trace::default()
        };
        let mut traced = trace.lines(&image).unwrap().artwork;
        drawn.tidy(&Tidy::default());
        traced.tidy(&Tidy::default());
        let (extra, extra_at) = farthest(&traced.strokes, &drawn.strokes);
        let (missing, missing_at) = farthest(&drawn.strokes, &traced.strokes);
        let count = drawn.strokes.len();
        let what = format!("{size} mm with a pen of {pen} mm");
        // If lines meet at an acute angle, their centres cannot be separated within the pen width.
        assert!(
            extra < f64::max(0.15, pen / 2.0),
            "{what}: {extra:.3} at {extra_at:.2?}"
        );
        assert!(
            missing < 0.7,
            "{what}: {missing:.3} at {missing_at:.2?} is not traced"
        );
        assert!(
            traced.strokes.len().abs_diff(count) * 10 <= count,
            "{what}: {} strokes of {count}",
            traced.strokes.len()
        );
        // A spur is a short stroke where nothing short was drawn.
        let short = |strokes: &[Stroke], most: f64| {
            let short = strokes.iter().filter(|stroke| stroke.length() < most);
            short.count()
        };
        let [dots, spurs] = [short(&drawn.strokes, 3.0), short(&traced.strokes, 1.0)];
        assert!(
            spurs <= dots,
            "{what}: {spurs} strokes below 1 mm, and {dots} dots"
        );
    }
}

#[test]
fn a_diagonal_as_thin_as_two_pixels_and_a_dot_are_traced() {
    let (width, height) = (60, 60);
    let grey = (0..width * height).map(|at| {
        let (x, y) = (at % width, at / width);
        let line = (10..50).contains(&x) && (y == x || y == x + 1);
        let block = (50..52).contains(&x) && (5..7).contains(&y);
        if line || block { 0 } else { 255 }
    });
    let image = Raster {
        width,
        height,
        grey: grey.collect(),
        pixel: Some([0.1; 2]),
        ..Raster::default()
    };
    let trace = Trace {
        style: ImageStyle::Centerline,
        despeckle: 0.0,
        ..Trace::default()
    };
    let lines = trace.lines(&image).unwrap();
    let lengths: Vec<f64> = lines.artwork.strokes.iter().map(Stroke::length).collect();
    let [line, dot] = lengths.as_slice() else {
        panic!("{lengths:?}")
    };
    assert!(*line > 5.0 && *dot < 0.3, "{lengths:?}");
    let trace = Trace {
        despeckle: 0.3,
        ..trace
    };
    let lines = trace.lines(&image).unwrap();
    assert_eq!((lines.artwork.strokes.len(), lines.specks), (1, 1));
}

#[test]
fn any_image_becomes_lines_or_is_refused() {
    let plain = |grey: u8, [width, height]: [usize; 2]| Raster {
        width,
        height,
        grey: vec![grey; width * height],
        ..Raster::default()
    };
    for style in ImageStyle::ALL {
        for size in [[1, 1], [1, 300], [300, 1], [90, 60]] {
            for grey in [0, 100, 255] {
                for width in [0.3, 30.0] {
                    let trace = Trace {
                        style,
                        size: Size::Width(width),
                        ..Trace::default()
                    };
                    match trace.lines(&plain(grey, size)) {
                        Ok(lines) => {
                            assert!(grey < 255, "{style} draws white");
                            let page = lines.artwork.page.unwrap();
                            let [least, most] = lines.artwork.bounds().unwrap();
                            let inside = (0..2).all(|axis| {
                                least[axis] >= -1e-9 && most[axis] <= page[axis] + 1e-9
                            });
                            assert!(inside, "{style} {size:?} {least:?} {most:?} {page:?}");
                            assert!(lines.artwork.strokes.iter().all(Stroke::is_finite));
                        }
                        Err(error) => {
                            let why = &error.message;
                            let told =
                                why.starts_with("nothing to draw") || why.contains("too many");
                            assert!(told, "{style} {size:?} {grey} {width}: {error}");
                            assert!(
                                grey > 0 || width < 1.0 || size[0] == 1,
                                "{style} {size:?}: {error}"
                            );
                        }
                    }
                }
            }
        }
    }
}

#[test]
fn invalid_trace_options_are_refused() {
    let (image, _) = wedge(3);
    for (wrong, why) in [
        (
            Trace {
                despeckle: -1.0,
                ..Trace::default()
            },
            "size of a speck",
        ),
        (
            Trace {
                pen_width: 0.0,
                ..Trace::default()
            },
            "width of the pen",
        ),
        (
            Trace {
                style: ImageStyle::Hatch,
                spacing: Some(0.2),
                ..Trace::default()
            },
            "closer together than the pen is wide",
        ),
        (
            Trace {
                style: ImageStyle::Halftone,
                size: Size::Width(9000.0),
                ..Trace::default()
            },
            "too many dots",
        ),
    ] {
        let error = wrong.lines(&image).unwrap_err();
        assert!(error.message.contains(why), "{error}");
    }
}

#[test]
fn levels_set_the_number_of_hatchings_and_dot_sizes() {
    let (image, _) = wedge(11);
    let trace = |style, levels| Trace {
        style,
        levels: Some(levels),
        size: Size::Width(132.0),
        ..Trace::default()
    };
    let hatched = trace(ImageStyle::Hatch, 4).lines(&image).unwrap().artwork;
    let angle = |stroke: &Stroke| {
        let (from, to) = (stroke.points[0], stroke.points[stroke.points.len() - 1]);
        let angle = libm::atan2(to[1] - from[1], to[0] - from[0]).to_degrees();
        angle.rem_euclid(180.0).round() as i64 % 180
    };
    let lines = hatched
        .strokes
        .iter()
        .filter(|stroke| stroke.length() > 1.0);
    let angles: std::collections::BTreeSet<i64> = lines.map(angle).collect();
    assert_eq!(angles, [0, 45, 90, 135].into());
    let dotted = trace(ImageStyle::Halftone, 3)
        .lines(&image)
        .unwrap()
        .artwork;
    let inside = |stroke: &&Stroke| {
        let page = dotted.page.unwrap();
        let mut points = stroke.points.iter();
        points.all(|[x, y]| *x > 0.0 && *x < page[0] && *y > 0.0 && *y < page[1])
    };
    let sizes = dotted.strokes.iter().filter(inside);
    let sizes: std::collections::BTreeSet<i64> = sizes
        .map(|stroke| (stroke.length() * 100.0).round() as i64)
        .collect();
    assert_eq!(sizes.len(), 3, "{sizes:?}");
}

#[test]
fn photo_is_drawn_in_few_long_lines() {
    let side = 200;
    let grey = (0..side * side).map(|at| {
        let [x, y] = [at % side, at / side].map(|at| at as f64 / side as f64 - 0.5);
        (255.0 * (libm::hypot(x, y) * 1.4).min(0.9)) as u8
    });
    let image = Raster {
        width: side,
        height: side,
        grey: grey.collect(),
        ..Raster::default()
    };
    let trace = Trace {
        style: ImageStyle::Squiggle,
        size: Size::Width(100.0),
        ..Trace::default()
    };
    let strokes = trace.lines(&image).unwrap().artwork.strokes;
    assert!(strokes.len() <= 100, "{} strokes in 50 rows", strokes.len());
}
