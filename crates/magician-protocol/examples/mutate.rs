//! Fuzzes the codec with damaged recorded frames for a given number of cases: `cargo run --release
//! -p magician-protocol --example mutate -- --cases 100000000 --seed 1`.
//!
//! Each case damages one frame and deframes it in two pieces. A frame that the deframer accepts is
//! decoded as a request. Every fourth request is encoded again; every 64th is also described, and
//! its values are printed and encoded from the text.

use std::time::Instant;

use magician_protocol::{
    Deframer, Description, Event, Frame, Get, MAX_PARAMS, Request, Set, Writer, checksum,
    encode_text,
};

/// Small fast random generator (xorshift64*).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        self.0.wrapping_mul(0x2545_F491_4F6C_DD1D)
    }

    fn below(&mut self, bound: usize) -> usize {
        (((self.next() >> 32) * bound as u64) >> 32) as usize
    }
}

/// Recorded frames of both data files.
fn seeds() -> Vec<Vec<u8>> {
    let data = [
        include_str!("../tests/data/vectors.toml"),
        include_str!("../tests/data/golden.toml"),
    ];
    let lines = data.iter().flat_map(|text| text.lines());
    let hex = lines.filter_map(|line| line.split_once(" hex = \"").or(line.split_once("hex = \"")));
    hex.filter_map(|(_, rest)| {
        let bytes = rest.split('"').next()?.split(' ');
        bytes
            .map(|byte| u8::from_str_radix(byte, 16).ok())
            .collect()
    })
    .collect()
}

fn damage(frame: &mut Vec<u8>, random: &mut Random) {
    const INTERESTING_BYTES: [u8; 8] = [0xAA, 0x00, 0xFF, 0x02, 0xFA, 0x80, 0x7F, 0x01];
    for _ in 0..random.below(4) {
        let at = random.below(frame.len().max(1));
        let bits = random.next();
        let random_byte = (bits >> 8) as u8;
        if bits & 7 == 0 && frame.len() < 250 {
            frame.insert(at, random_byte);
        } else if at >= frame.len() {
            continue;
        }
        match bits & 7 {
            0 => {}
            1 => drop(frame.remove(at)),
            2 => frame[at] = INTERESTING_BYTES[usize::from(random_byte % 8)],
            3 => frame[at] = frame[at].wrapping_add(random_byte | 1),
            4 => frame[at] ^= 1 << (random_byte & 7),
            5 => frame.truncate(at),
            _ => frame[at] = random_byte,
        }
    }
    // In half of the cases length and checksum are repaired, so that the damage reaches the
    // decoder.
    if random.next() & 1 == 0
        && let [a, b, len, body @ .., sum] = &mut frame[..]
        && body.len() >= 2
        && body.len() <= 250
    {
        (*a, *b, *len) = (0xAA, 0xAA, body.len() as u8);
        *sum = checksum(body);
    }
}

#[derive(Default)]
struct MutationCount {
    frames: u64,
    rejected: u64,
    noise: u64,
    requests: u64,
}

impl MutationCount {
    fn count_event(&mut self, event: Event<'_>) {
        match event {
            Event::Frame { frame, .. } => {
                self.frames += 1;
                assert!(Frame::new(frame.bytes()).is_some(), "{frame:?}");
                self.read(&frame);
            }
            Event::Rejected { bytes, .. } => {
                self.rejected += 1;
                assert!(!bytes.is_empty());
            }
            Event::Noise { bytes, .. } => {
                self.noise += 1;
                assert!(!bytes.is_empty());
            }
        }
    }

    fn read(&mut self, frame: &Frame<'_>) {
        let Ok(request) = Request::decode(frame) else {
            return;
        };
        self.requests += 1;
        if self.requests.is_multiple_of(4) {
            check_round_trip(frame, &request);
        }
        if self.requests.is_multiple_of(64) {
            describe_and_encode_text(frame);
        }
    }
}

/// Asserts that the bytes of an encoded request decode to a request with the same bytes.
fn check_round_trip(frame: &Frame<'_>, request: &Request) {
    let mut first = [0; MAX_PARAMS];
    let mut writer = Writer::new(&mut first);
    match request {
        Request::Get(get) => get.encode(&mut writer),
        Request::Set(set) | Request::Queue(set) => set.encode(&mut writer),
        Request::Nothing => {}
    }
    let count = writer.finish().expect("what came in a frame fits a frame");
    let params = &first[..count];
    let mut second = [0; MAX_PARAMS];
    let mut writer = Writer::new(&mut second);
    match request {
        Request::Get(_) => Get::decode(frame.id(), params)
            .expect("ours")
            .encode(&mut writer),
        Request::Set(_) | Request::Queue(_) => {
            Set::decode(frame.id(), params)
                .expect("ours")
                .encode(&mut writer);
        }
        Request::Nothing => {}
    }
    let count = writer.finish().expect("as long as the first");
    assert_eq!(params, &second[..count], "{frame:?}");
}

fn describe_and_encode_text(frame: &Frame<'_>) {
    let Ok(description) = Description::guess(frame) else {
        return;
    };
    let values = description.values().expect("it was tried");
    let printed: Vec<_> = values
        .map(|(field, value)| (field.name, value.to_string()))
        .collect();
    let arguments: Vec<_> = printed
        .iter()
        .map(|(name, text)| (*name, text.as_str()))
        .collect();
    let mut params = [0; MAX_PARAMS];
    let _ = encode_text(
        description.layout,
        &arguments,
        &mut Writer::new(&mut params),
    );
}

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    let option = |name: &str, default: u64| {
        let at = arguments.iter().position(|argument| argument == name);
        let value = at.and_then(|at| arguments.get(at + 1));
        value.map_or(default, |text| {
            text.replace('_', "").parse().expect("a whole number")
        })
    };
    let (cases, seed) = (option("--cases", 1_000_000), option("--seed", 1));
    let seeds = seeds();
    let mut random = Random(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1);
    let (mut deframer, mut tally) = (Deframer::new(), MutationCount::default());
    let mut frame = Vec::with_capacity(256);
    let start = Instant::now();
    for case in 0..cases {
        frame.clear();
        frame.extend_from_slice(&seeds[random.below(seeds.len())]);
        damage(&mut frame, &mut random);
        let (one, two) = frame.split_at(random.below(frame.len() + 1));
        for mut piece in [one, two] {
            while let Some(event) = deframer.next(&mut piece) {
                tally.count_event(event);
            }
        }
        if case.is_multiple_of(16) {
            deframer.expire();
        }
    }
    let seconds = start.elapsed().as_secs_f64();
    let MutationCount {
        frames,
        rejected,
        noise,
        requests,
    } = tally;
    println!(
        "{cases} executions in {seconds:.1} s: {:.2} M/s",
        cases as f64 / seconds / 1e6
    );
    println!("{frames} frames, {requests} of them requests, {rejected} rejected, {noise} noise");
}
