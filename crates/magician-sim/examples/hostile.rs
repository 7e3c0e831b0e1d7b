//! Runs a hostile host against the virtual arm:
//! `cargo run --release -p magician-sim --example hostile -- --steps 10000000 --seed 1`.
//!
//! A step is an action of the host: it sends a frame or garbage, lets time pass, falls silent, or
//! leaves. The arm is checked after each step. After some thousand steps it must come to rest and
//! accept commands. Each run is repeated with time in small pieces and must give the same result
//! bit for bit. The seed of a failing run is printed.

use std::time::Instant;

#[path = "../tests/virtual_arm/host/mod.rs"]
mod host;

/// Number of bytes that drive one run.
const LIFE: usize = 32 * 1024;

fn argument(name: &str, default: u64) -> u64 {
    let mut arguments = std::env::args().skip_while(|argument| argument != name);
    match arguments.nth(1) {
        Some(number) => number.parse().expect("a number"),
        None => default,
    }
}

/// Random bytes from a seed (SplitMix64).
fn script(mut seed: u64) -> Vec<u8> {
    let mut next = || {
        seed = seed.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut bits = seed;
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        bits ^ (bits >> 31)
    };
    (0..LIFE / 8).flat_map(|_| next().to_le_bytes()).collect()
}

fn main() {
    let (wanted, first) = (argument("--steps", 1_000_000), argument("--seed", 1));
    let began = Instant::now();
    let (mut steps, mut lives, mut finished, mut seconds) = (0, 0, 0, 0);
    while steps < wanted {
        let seed = first.wrapping_add(lives);
        let life = std::panic::catch_unwind(|| {
            let mut life = host::Life::default();
            let script = script(seed.wrapping_mul(0xD134_2543_DE82_EF95));
            life.live(&script);
            let mut pieces = host::Life::in_pieces();
            pieces.live(&script);
            assert_eq!(life.story, pieces.story, "cuts of time change nothing");
            let seconds = life.arm.now().as_micros() / 1_000_000;
            life.end();
            (life.steps, life.arm.state().queue.current_index, seconds)
        });
        let Ok((took, index, lasted)) = life else {
            eprintln!("it was --seed {seed}");
            std::process::exit(1);
        };
        lives += 1;
        steps += took;
        finished += index;
        seconds += lasted;
    }
    let wall = began.elapsed().as_secs_f64();
    println!(
        "{steps} steps in {lives} lives, indices up to {finished} in all, {seconds} s of arm time; {wall:.1} s, {:.0} steps/s",
        steps as f64 / wall
    );
}
