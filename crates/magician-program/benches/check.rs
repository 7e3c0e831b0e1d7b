//! Cost of a check: `cargo bench -p magician-program --bench check`.

use divan::Bencher;
use divan::counter::ItemsCount;
use magician::build;
use magician::preflight::Preflight;
use magician::{JointAngles, ToolBias};
use magician_program::{Action, Origin, Plan, Tool, Travel, check};

fn main() {
    divan::main();
}

/// Random numbers from a seed (xorshift64*), from 0 to 1.
struct RandomSource(u64);

impl RandomSource {
    fn next(&mut self) -> f64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// Drawing of `segments` segments of 0.2 to 1 mm: a random walk with bends, on a sheet of 100 mm.
fn drawing(segments: usize) -> Plan {
    let mut chance = RandomSource(20_260_801);
    let mut plan = Plan::new("a walk");
    plan.tool = Some(Tool::Pen);
    plan.push(build::path_speed(100.0, 200.0), Origin::NONE);
    let (mut at, mut heading) = ([0.0f64; 2], 0.0f64);
    plan.push(
        Action::Move {
            to: [240.0, 0.0, -40.0, 0.0],
            by: Travel::Line,
        },
        Origin::NONE,
    );
    for _ in 0..segments {
        heading += 0.6 * (chance.next() - 0.5);
        if at[0].abs().max(at[1].abs()) > 48.0 {
            heading = (-at[1]).atan2(-at[0]);
        }
        let step = 0.2 + 0.8 * chance.next();
        at = [at[0] + step * heading.cos(), at[1] + step * heading.sin()];
        let to = [(240.0 + at[0]) as f32, at[1] as f32, -40.0];
        plan.push(Action::Path { to }, Origin::NONE);
    }
    plan
}

fn start() -> Preflight {
    Preflight::at(JointAngles::HOME, ToolBias::PEN)
}

#[divan::bench(args = [10_000, 1_000_000], sample_count = 3, sample_size = 1)]
fn check_a_drawing(bencher: Bencher, segments: usize) {
    let plan = drawing(segments);
    let start = start();
    let report = check(&plan, &start);
    assert!(report.is_good(), "{:?}", report.refused_steps.first());
    bencher
        .counter(ItemsCount::new(segments))
        .bench_local(|| check(&plan, &start).time);
}

/// Duration of each segment, as a stream needs it.
#[divan::bench(sample_count = 3, sample_size = 1)]
fn estimate_a_drawing(bencher: Bencher) {
    let plan = drawing(1_000_000);
    let commands: Vec<_> = plan.commands().collect();
    let start = start();
    bencher
        .counter(ItemsCount::new(commands.len()))
        .bench_local(|| start.estimate(&commands));
}

#[divan::bench(sample_count = 3, sample_size = 1)]
fn write_a_plan_file(bencher: Bencher) {
    let plan = drawing(1_000_000);
    bencher
        .counter(ItemsCount::new(plan.steps.len()))
        .bench_local(|| plan.to_json().len());
}

#[divan::bench(sample_count = 3, sample_size = 1)]
fn read_a_plan_file(bencher: Bencher) {
    let text = drawing(1_000_000).to_json();
    bencher.bench_local(|| Plan::from_json(text.as_bytes()).map(|plan| plan.steps.len()));
}
