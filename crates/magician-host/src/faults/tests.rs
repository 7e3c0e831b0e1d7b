use proptest::prelude::*;

use super::{Faults, Injector, Passed};

const CHUNKS: usize = 4000;

fn faults(text: &str) -> Faults {
    text.parse().unwrap()
}

/// Sends numbered chunks of 8 bytes, one per millisecond, and collects the output.
fn run_line(text: &str, seed: u64) -> (Injector, Vec<(u64, Passed)>) {
    let mut line = Injector::new(faults(text), seed);
    let mut out = Vec::new();
    let mut drain = |line: &mut Injector, end: u64| {
        while let Some(at) = line.poll_timeout().filter(|at| *at <= end) {
            out.extend(line.poll(at).map(|passed| (at, passed)));
        }
    };
    for number in 0..CHUNKS {
        let now = number as u64 * 1000;
        drain(&mut line, now);
        line.push(now, &chunk(number));
    }
    drain(&mut line, u64::MAX);
    assert_eq!(line.poll_timeout(), None);
    (line, out)
}

fn chunk(number: usize) -> [u8; 8] {
    (number as u64).to_be_bytes()
}

fn chunks(out: &[(u64, Passed)]) -> Vec<Vec<u8>> {
    let bytes = out.iter().filter_map(|(_, passed)| match passed {
        Passed::Bytes(bytes) => Some(bytes.clone()),
        _ => None,
    });
    bytes.collect()
}

fn joined(out: &[(u64, Passed)]) -> Vec<u8> {
    chunks(out).concat()
}

fn sent() -> Vec<u8> {
    (0..CHUNKS).flat_map(chunk).collect()
}

/// Asserts a count within a fifth of what the rate promises.
fn assert_near(count: u64, expected: f64) {
    assert!(
        (count as f64 - expected).abs() < expected / 5.0,
        "{count}, not {expected}"
    );
}

#[test]
fn without_faults_nothing_changes() {
    let (line, out) = run_line("", 1);
    assert_eq!(
        chunks(&out),
        (0..CHUNKS).map(|n| chunk(n).to_vec()).collect::<Vec<_>>()
    );
    assert!(
        out.iter()
            .enumerate()
            .all(|(n, (at, _))| *at == n as u64 * 1000)
    );
    assert_eq!(line.tally().total(), 0);
}

#[test]
fn equal_seeds_give_equal_bytes_and_others_differ() {
    let all = "replace=0.01,flip=0.01,drop=0.01,insert=0.01,duplicate=0.01,swap=0.01,drop-chunk=0.01,\
               duplicate-chunk=0.01,swap-chunk=0.05,stall=0.01,rechunk=0.1,reset=0.001";
    let (line, out) = run_line(all, 7);
    assert_eq!(run_line(all, 7).1, out);
    assert_ne!(run_line(all, 8).1, out);
    let tally = line.tally();
    for (count, expected) in [
        (tally.replaced, 320.0),
        (tally.flipped, 320.0),
        (tally.dropped, 320.0),
        (tally.inserted, 320.0),
        (tally.duplicated, 320.0),
        (tally.swapped, 280.0),
    ] {
        assert_near(count, expected);
    }
    assert!(
        out.windows(2).all(|pair| pair[0].0 <= pair[1].0),
        "time goes on"
    );
}

#[test]
fn byte_faults_do_not_depend_on_chunk_faults() {
    let (calm, _) = run_line("flip=0.01,drop=0.01", 3);
    let (rough, out) = run_line("flip=0.01,drop=0.01,stall=0.1,rechunk=0.5", 3);
    assert_eq!(calm.tally().flipped, rough.tally().flipped);
    assert_eq!(joined(&out), joined(&run_line("flip=0.01,drop=0.01", 3).1));
}

#[test]
fn replaced_byte_differs_and_flipped_byte_differs_in_one_bit() {
    for (text, bits) in [("replace=1", 1..=8), ("flip=1", 1..=1)] {
        let received = joined(&run_line(text, 1).1);
        let sent = sent();
        assert_eq!(received.len(), sent.len());
        let differ = |(a, b): (&u8, &u8)| (a ^ b).count_ones();
        assert!(
            received
                .iter()
                .zip(&sent)
                .map(differ)
                .all(|count| bits.contains(&count)),
            "{text}"
        );
    }
}

#[test]
fn bytes_are_lost_added_doubled_and_swapped() {
    assert_eq!(joined(&run_line("drop=1", 1).1), Vec::<u8>::new());
    let double = |bytes: Vec<u8>| {
        bytes
            .into_iter()
            .flat_map(|byte| [byte; 2])
            .collect::<Vec<_>>()
    };
    assert_eq!(joined(&run_line("duplicate=1", 1).1), double(sent()));
    let added = joined(&run_line("insert=1", 1).1);
    assert_eq!(
        added.iter().skip(1).step_by(2).copied().collect::<Vec<_>>(),
        sent()
    );
    let mut line = Injector::new(faults("swap=1"), 1);
    line.push(0, &[1, 2, 3, 4, 5]);
    let Some(Passed::Bytes(bytes)) = line.poll(0) else {
        panic!()
    };
    assert_eq!(
        bytes,
        [2, 1, 4, 3, 5],
        "the last byte of a chunk has none to change with"
    );
}

#[test]
fn datagrams_are_lost_doubled_and_out_of_order() {
    let (line, out) = run_line("drop-chunk=0.1", 1);
    assert_near(line.tally().dropped_chunks, 400.0);
    assert_eq!(
        chunks(&out).len() as u64 + line.tally().dropped_chunks,
        CHUNKS as u64
    );

    let (line, out) = run_line("duplicate-chunk=0.1", 1);
    assert_near(line.tally().duplicated_chunks, 400.0);
    let mut once = chunks(&out);
    once.dedup();
    assert_eq!(once.concat(), sent());

    let (line, out) = run_line("swap-chunk=0.1", 1);
    assert_near(line.tally().swapped_chunks, 400.0);
    let mut received = chunks(&out);
    let late = received.windows(2).filter(|pair| pair[0] > pair[1]).count();
    // The chunk held last may have had no successor that overtook it.
    assert!((late as u64).abs_diff(line.tally().swapped_chunks) <= 1);
    received.sort();
    assert_eq!(received.concat(), sent());
}

#[test]
fn held_chunk_without_successor_is_sent_after_hold_time() {
    let mut line = Injector::new(faults("swap-chunk=1,hold-ms=30"), 1);
    line.push(1000, b"late");
    assert_eq!(line.poll(1000), None);
    assert_eq!(line.poll_timeout(), Some(31_000));
    assert_eq!(line.poll(31_000), Some(Passed::Bytes(b"late".to_vec())));
}

#[test]
fn bytes_sent_during_a_stall_arrive_after_it() {
    let (line, out) = run_line("stall=0.01,stall-ms=20", 5);
    assert_near(line.tally().stalls, 40.0);
    assert_eq!(joined(&out), sent());
    let late = |(n, (at, _)): (usize, &(u64, Passed))| at - n as u64 * 1000;
    let longest = out.iter().enumerate().map(late).max().unwrap();
    assert!((5_000..=40_000).contains(&longest), "{longest}");
}

#[test]
fn rechunking_keeps_every_byte() {
    let (line, out) = run_line("rechunk=1", 1);
    assert_eq!(line.tally().rechunked, CHUNKS as u64);
    assert_eq!(joined(&out), sent());
    let sizes: Vec<usize> = chunks(&out).iter().map(Vec::len).collect();
    assert!(sizes.iter().any(|size| *size < 8) && sizes.iter().any(|size| *size > 8));
}

#[test]
fn unplugging_drops_chunks_under_way() {
    let mut line = Injector::new(faults("stall=1,stall-ms=1000"), 1);
    line.push(0, b"under way");
    line.set_faults(faults("unplug=1"));
    line.push(10, b"too late");
    assert_eq!(line.poll(10), Some(Passed::Unplugged));
    line.set_faults(Faults::default());
    line.push(20, b"nobody hears it");
    assert_eq!((line.poll(2_000_000), line.poll_timeout()), (None, None));
    line.plug_in();
    line.push(30, b"again");
    assert_eq!(line.poll(30), Some(Passed::Bytes(b"again".to_vec())));
    assert_eq!(line.tally().unplugged, 1);
}

#[test]
fn reset_keeps_its_place_in_the_order() {
    let mut line = Injector::new(Faults::default(), 1);
    line.push(0, b"before");
    line.set_faults(faults("reset=1"));
    line.push(0, b"lost");
    line.set_faults(Faults::default());
    line.push(0, b"after");
    let all: Vec<_> = std::iter::from_fn(|| line.poll(0)).collect();
    let bytes = |text: &[u8]| Passed::Bytes(text.to_vec());
    assert_eq!(all, [bytes(b"before"), Passed::Reset, bytes(b"after")]);
}

#[test]
fn unread_line_stays_bounded() {
    let mut line = Injector::new(faults("stall=1,stall-ms=60000,duplicate-chunk=0.5"), 1);
    for now in 0..10_000 {
        line.push(now, &[0; 200]);
    }
    let bytes: usize = std::iter::from_fn(|| line.poll(u64::MAX))
        .map(|passed| match passed {
            Passed::Bytes(bytes) => bytes.len(),
            _ => 0,
        })
        .sum();
    assert!(bytes <= 64 * 1024 + 200 && bytes > 60_000, "{bytes}");
    assert!(line.tally().dropped_chunks > 9_000);
    assert_eq!((line.load, line.poll_timeout()), (0, None));
}

proptest! {
    #[test]
    fn line_drains_for_any_rates_and_times(
        rates in proptest::array::uniform7(0.0f64..=1.0),
        seed: u64,
        pushes in proptest::collection::vec((0u64..1_000_000, proptest::collection::vec(any::<u8>(), 0..80)), 0..60),
    ) {
        let [bytes, lost, double, swap, stall, cut, reset] = rates;
        let faults = Faults {
            insert: bytes, drop_chunk: lost, duplicate_chunk: double, swap_chunk: swap, stall, rechunk: cut, reset,
            ..Faults::default()
        };
        let mut line = Injector::new(faults, seed);
        // Time may even go back.
        for (now, bytes) in pushes {
            line.push(now, &bytes);
            line.poll(now);
        }
        let mut left = 0;
        while let Some(at) = line.poll_timeout() {
            line.poll(at);
            left += 1;
            prop_assert!(left < 10_000);
        }
        prop_assert_eq!(line.load, 0);
    }
}
