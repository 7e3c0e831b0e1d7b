//! Throughput from one arm to many, on one thread and on two.

use std::error::Error;
use std::fs;
use std::path::Path;
use std::thread;
use std::time::{Duration, Instant};

use magician_protocol::{Ctrl, FrameBuf};
use magician_sim::Controller;
use plotters::prelude::*;

use super::figure::Figure;
use super::program::{arm, frame, pick_and_place, stream};

const ARMS: [usize; 13] = [
    1, 2, 5, 10, 20, 50, 100, 200, 500, 1_000, 2_000, 5_000, 10_000,
];
const THREADS: [usize; 2] = [1, 2];
/// Repetitions and duration of each point. The best counts, because other programs run too.
const REPETITIONS: usize = 3;
const POINT_DURATION: Duration = Duration::from_millis(300);
const COLORS: [RGBColor; 2] = [RGBColor(0, 114, 178), RGBColor(213, 94, 0)];
const INK: RGBColor = RGBColor(60, 60, 60);
const FAINT: RGBColor = RGBColor(200, 200, 200);

/// Returns the arm-seconds per second of this many arms on this thread, which take turns with their
/// rounds of commands.
fn rate_on_this_thread(arms: usize, frames: &[FrameBuf]) -> f64 {
    let mut arms: Vec<Controller> = (0..arms).map(|_| arm()).collect();
    let mut done = Duration::ZERO;
    let mut run = |arm: &mut Controller| {
        let began = arm.now();
        stream(arm, frames, |_, _| ());
        done += arm.now() - began;
    };
    // Warms up only one arm: one arm fits into the cache, and ten thousand do not.
    run(&mut arms[0]);
    let began = Instant::now();
    'all: loop {
        for arm in &mut arms {
            run(arm);
            if began.elapsed() > POINT_DURATION {
                break 'all;
            }
        }
    }
    done.as_secs_f64() / began.elapsed().as_secs_f64()
}

fn rate_on_threads(arms: usize, threads: usize, frames: &[FrameBuf]) -> f64 {
    thread::scope(|scope| {
        let workers: Vec<_> = (0..threads)
            .map(|nth| scope.spawn(move || rate_on_this_thread((arms + nth) / threads, frames)))
            .collect();
        let rates = workers.into_iter().map(|worker| worker.join());
        rates.map(|rate| rate.unwrap_or(f64::NAN)).sum()
    })
}

/// Measures, and draws `docs/pictures/scaling.svg`.
pub(super) fn measure(docs: &Path) -> Result<Vec<Figure>, Box<dyn Error>> {
    let moves = pick_and_place();
    let frames: Vec<FrameBuf> = moves
        .iter()
        .map(|command| frame(Ctrl::QUEUED, command))
        .collect();
    let (mut figures, mut lines) = (Vec::new(), Vec::new());
    for threads in THREADS {
        let mut line = Vec::new();
        for arms in ARMS.into_iter().filter(|arms| *arms >= threads) {
            let tries = (0..REPETITIONS).map(|_| rate_on_threads(arms, threads, &frames));
            let rate = tries.fold(0.0, f64::max);
            let name = format!("{arms} arms on {threads} threads");
            figures.push(Figure::new(name, rate, "arm-seconds/s"));
            line.push((arms as f64, rate / 1e6));
        }
        lines.push((threads, line));
    }
    let picture = docs.join("pictures/scaling.svg");
    fs::write(&picture, draw(&lines)?)?;
    Ok(figures)
}

fn draw(lines: &[(usize, Vec<(f64, f64)>)]) -> Result<String, Box<dyn Error>> {
    let points = lines.iter().flat_map(|(_, line)| line);
    let most = points.map(|(_, rate)| *rate).fold(0.0, f64::max);
    let mut text = String::new();
    {
        let root = SVGBackend::with_string(&mut text, (760, 420)).into_drawing_area();
        root.fill(&WHITE)?;
        let mut chart = ChartBuilder::on(&root)
            .caption(
                "Point to point, bytes in and out: all arms of a process together",
                ("sans-serif", 18).into_font().color(&INK),
            )
            .margin(14)
            .margin_right(26)
            .x_label_area_size(42)
            .y_label_area_size(60)
            .build_cartesian_2d((0.9..12_000.0).log_scale(), 0.0..most * 1.15)?;
        chart
            .configure_mesh()
            .x_desc("arms")
            .y_desc("million arm-seconds a second")
            .x_label_formatter(&|arms| format!("{arms:.0}"))
            .y_label_formatter(&|rate| format!("{rate:.1}"))
            .light_line_style(WHITE)
            .bold_line_style(FAINT.mix(0.6))
            .label_style(("sans-serif", 13).into_font().color(&INK))
            .draw()?;
        for ((threads, line), color) in lines.iter().zip(COLORS) {
            let name = if *threads == 1 {
                "1 thread"
            } else {
                "2 threads"
            };
            chart
                .draw_series(LineSeries::new(line.iter().copied(), color.stroke_width(2)))?
                .label(name)
                .legend(move |(x, y)| {
                    PathElement::new([(x, y), (x + 18, y)], color.stroke_width(2))
                });
            chart.draw_series(
                line.iter()
                    .map(|point| Circle::new(*point, 3, color.filled())),
            )?;
        }
        chart
            .configure_series_labels()
            .position(SeriesLabelPosition::LowerRight)
            .background_style(WHITE.mix(0.8))
            .border_style(FAINT)
            .label_font(("sans-serif", 13).into_font().color(&INK))
            .draw()?;
        root.present()?;
    }
    Ok(text)
}
