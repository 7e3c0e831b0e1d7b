//! Speed of the codec: `cargo bench -p magician-protocol`.
//!
//! The first lines compare decoding with a bare sum of the same bytes in the same run. Targets are
//! a ratio of 3, 10 M frames/s byte by byte, and 15 ns to encode.

use std::hint::black_box;
use std::time::{Duration, Instant};

use divan::counter::{BytesCount, ItemsCount};
use divan::{Bencher, bench};
use magician_protocol::commands::{
    AlarmsState, CpCmd, GetIoAdc, IoAdc, IoDi, Pose, PtpCmd, PtpCommonParams,
    QueuedCmdCurrentIndex, QueuedCmdLeftSpace,
};
use magician_protocol::{
    Ctrl, Deframer, Event, Frame, FrameBuf, Layout, NoArgs, PtpMode, QueuedCmdIndex, Readable, Set,
    Writable,
};

/// Replies of an arm that streams a path while its state is polled.
fn replies() -> Vec<FrameBuf> {
    let mut replies = Vec::new();
    let mut reply = |id, ctrl, params: &[u8]| {
        replies.push(FrameBuf::new(id, ctrl, params).expect("short"));
    };
    for index in 0..64u64 {
        let pose: Vec<u8> = (0..8)
            .flat_map(|axis| (index as f32 * 1.25 + axis as f32).to_le_bytes())
            .collect();
        reply(91, Ctrl::QUEUED, &index.to_le_bytes());
        reply(91, Ctrl::QUEUED, &(index + 1).to_le_bytes());
        reply(10, Ctrl::GET, &pose);
        reply(246, Ctrl::GET, &index.to_le_bytes());
        reply(247, Ctrl::GET, &[32, 0, 0, 0]);
        reply(20, Ctrl::GET, &[0; 16]);
        reply(134, Ctrl::GET, &[12, 0xFF, 0x0F]);
        reply(133, Ctrl::GET, &[15, 1]);
        reply(83, Ctrl::GET, &pose[..8]);
    }
    replies
}

fn stream(frames: &[FrameBuf]) -> Vec<u8> {
    frames
        .iter()
        .flat_map(|frame| frame.bytes().to_vec())
        .collect()
}

fn sum(frames: &[Frame<'_>]) {
    for frame in frames {
        let payload = black_box(frame.params());
        black_box(payload.iter().map(|byte| u32::from(*byte)).sum::<u32>());
    }
}

#[inline]
fn decode(frame: &Frame<'_>) {
    let params = black_box(frame.params());
    if frame.ctrl().queued() {
        black_box(QueuedCmdIndex::decode(params).ok());
        return;
    }
    match frame.id() {
        10 => drop(black_box(Pose::decode(params))),
        246 => drop(black_box(QueuedCmdCurrentIndex::decode(params))),
        247 => drop(black_box(QueuedCmdLeftSpace::decode(params))),
        20 => drop(black_box(AlarmsState::decode(params))),
        134 => drop(black_box(IoAdc::decode(params))),
        133 => drop(black_box(IoDi::decode(params))),
        83 => drop(black_box(PtpCommonParams::decode(params))),
        id => panic!("id {id}"),
    }
}

fn deframe(deframer: &mut Deframer, mut input: &[u8]) -> u32 {
    let mut count = 0;
    while let Some(event) = deframer.next(&mut input) {
        if let Event::Frame { frame, .. } = event {
            decode(&frame);
            count += 1;
        }
    }
    count
}

/// Minimum of many runs, because the machine is shared.
fn least(mut run: impl FnMut()) -> Duration {
    let time = |_| {
        let start = Instant::now();
        run();
        start.elapsed()
    };
    (0..3000).map(time).min().expect("some runs")
}

fn ratio() {
    let replies = replies();
    let stream = stream(&replies);
    let frames: Vec<Frame<'_>> = replies.iter().map(FrameBuf::frame).collect();
    let mut deframer = Deframer::new();
    let each = |time: Duration| time.as_secs_f64() * 1e9 / frames.len() as f64;
    let sum = each(least(|| sum(&frames)));
    let typed = each(least(|| frames.iter().for_each(decode)));
    let whole = each(least(|| {
        black_box(deframe(&mut deframer, &stream));
    }));
    println!("byte sum of the payload   {sum:6.2} ns a frame");
    println!(
        "decode to typed values    {typed:6.2} ns a frame, ratio {:.2}",
        typed / sum
    );
    println!(
        "deframe and decode        {whole:6.2} ns a frame, ratio {:.2}",
        whole / sum
    );
}

fn main() {
    ratio();
    divan::main();
}

#[bench]
fn deframe_and_decode(bencher: Bencher<'_, '_>) {
    let replies = replies();
    let stream = stream(&replies);
    let mut deframer = Deframer::new();
    bencher
        .counter(ItemsCount::new(replies.len()))
        .counter(BytesCount::new(stream.len()))
        .bench_local(|| deframe(&mut deframer, black_box(&stream)));
}

/// Input byte by byte, as from an interrupt handler.
#[bench(args = ["mixed replies", "index replies", "short requests"])]
fn push(bencher: Bencher<'_, '_>, what: &str) {
    let frames = match what {
        "mixed replies" => replies(),
        "index replies" => (0..500u64)
            .map(|index| FrameBuf::new(84, Ctrl::QUEUED, &index.to_le_bytes()).expect("short"))
            .collect(),
        _ => vec![FrameBuf::new(10, Ctrl::GET, &[]).expect("short"); 500],
    };
    let stream = stream(&frames);
    let mut deframer = Deframer::new();
    bencher
        .counter(ItemsCount::new(frames.len()))
        .counter(BytesCount::new(stream.len()))
        .bench_local(|| {
            let mut count = 0;
            for byte in black_box(&stream) {
                let mut input = std::slice::from_ref(byte);
                while let Some(event) = deframer.next(&mut input) {
                    count += u32::from(matches!(event, Event::Frame { .. }));
                }
            }
            count
        });
}

#[bench]
fn worst_input(bencher: Bencher<'_, '_>) {
    let stream = [0xAA; 4096];
    let mut deframer = Deframer::new();
    bencher
        .counter(BytesCount::new(stream.len()))
        .bench_local(|| deframe(&mut deframer, black_box(&stream)));
}

#[bench]
fn encode_pose_request() -> FrameBuf {
    FrameBuf::get(&black_box(NoArgs), Pose::ROW).expect("short")
}

#[bench]
fn encode_get() -> FrameBuf {
    FrameBuf::get(&black_box(GetIoAdc { address: Some(12) }), IoAdc::ROW).expect("short")
}

#[bench]
fn encode_ptp() -> FrameBuf {
    let move_to = PtpCmd {
        ptp_mode: PtpMode::MovlXyz,
        x: 200.0,
        y: 10.5,
        z: -20.25,
        r: 0.0,
    };
    FrameBuf::encode(PtpCmd::ROW.id, Ctrl::QUEUED, &black_box(move_to)).expect("short")
}

#[bench]
fn encode_cp() -> FrameBuf {
    let segment = CpCmd {
        cp_mode: 1.into(),
        x: 200.0,
        y: 10.5,
        z: -20.25,
        velocity_or_power: 0.0,
    };
    FrameBuf::encode(CpCmd::ROW.id, Ctrl::QUEUED, &black_box(segment)).expect("short")
}

/// Range check of the segments of a large drawing.
#[bench]
fn check_cp(bencher: Bencher<'_, '_>) {
    let segments: Vec<Set> = (0..100_000u32)
        .map(|nth| {
            Set::from(CpCmd {
                cp_mode: 1.into(),
                x: 200.0 + (nth % 77) as f32,
                y: (nth % 91) as f32,
                z: -20.25,
                velocity_or_power: 0.0,
            })
        })
        .collect();
    bencher
        .counter(ItemsCount::new(segments.len()))
        .bench_local(|| {
            let sound = |segment: &&Set| black_box(segment).check().is_ok();
            segments.iter().filter(sound).count()
        });
}
