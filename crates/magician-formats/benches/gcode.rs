//! Benchmark: time to read a million lines of G-code.

use std::fmt::Write;

use divan::counter::ItemsCount;
use magician_formats::{Format, ReadOptions, read};

const LINES: usize = 1_000_000;

fn main() {
    divan::main();
}

/// Returns a laser raster: rows of short segments with changing power.
fn raster() -> String {
    let mut text = String::from("G21\nG90\nG0 X200 Y-50 Z0\nM3 S0\nG1 F3000\n");
    for nth in 0..LINES {
        let (row, column) = (nth / 1000, nth % 1000);
        let (x, y) = (200.0 + column as f64 * 0.1, -50.0 + row as f64 * 0.1);
        writeln!(text, "G1 X{x:.3} Y{y:.3} S{}", nth % 256).expect("a string takes all");
    }
    text.push_str("M5\n");
    text
}

#[divan::bench(sample_count = 5, sample_size = 1)]
fn a_million_lines(bencher: divan::Bencher<'_, '_>) {
    let text = raster();
    let options = ReadOptions::default();
    bencher
        .counter(ItemsCount::new(LINES))
        .bench_local(|| read(Format::Gcode, text.as_bytes(), &options).expect("it is all right"));
}
