//! Trace files: they read back unchanged, other programs can read them, and garbage does no harm.

use std::io::{self, Write};
use std::sync::{Arc, Mutex};

use magician_protocol::Direction::{self, Reply, Request};
use magician_record::trace::{TraceError, TraceWriter, is_trace, read_trace};
use pcap_file::pcapng::blocks::enhanced_packet::EnhancedPacketOption;
use pcap_file::pcapng::blocks::interface_description::InterfaceDescriptionOption;
use pcap_file::pcapng::{Block, PcapNgReader};
use proptest::prelude::*;

const GET_POSE: [u8; 6] = [0xAA, 0xAA, 0x02, 0x0A, 0x00, 0xF6];
const CLEAR_ALARMS: [u8; 6] = [0xAA, 0xAA, 0x02, 0x14, 0x01, 0xEB];
const NOON: u64 = 1_800_000_000_000_000;

fn written(fill: impl FnOnce(&mut TraceWriter<&mut Vec<u8>>)) -> Vec<u8> {
    let mut file = Vec::new();
    fill(&mut TraceWriter::new(&mut file).unwrap());
    file
}

fn packets(file: &[u8]) -> Vec<(u64, String, Option<Direction>, Vec<u8>)> {
    read_trace(file)
        .map(|packet| {
            let packet = packet.unwrap();
            let name = packet.link_name.into_owned();
            (packet.time, name, packet.direction, packet.bytes.to_vec())
        })
        .collect()
}

#[test]
fn a_packet_is_a_frame_or_a_run_of_bytes_that_belong_to_none() {
    let file = written(|trace| {
        let link = trace.link("./arm").unwrap();
        let stream = [&b"M10\r\n"[..], &GET_POSE, &CLEAR_ALARMS, b"x"].concat();
        for (at, byte) in stream.iter().enumerate() {
            trace
                .record(link, NOON + at as u64, Request, &[*byte])
                .unwrap();
        }
    });
    let arm = || "./arm".to_owned();
    let runs: Vec<_> = packets(&file)
        .into_iter()
        .filter(|packet| packet.3[0] != 0xAA)
        .collect();
    let frames: Vec<_> = packets(&file)
        .into_iter()
        .filter(|packet| packet.3[0] == 0xAA)
        .collect();
    assert_eq!(
        frames,
        [
            (NOON + 10, arm(), Some(Request), GET_POSE.to_vec()),
            (NOON + 16, arm(), Some(Request), CLEAR_ALARMS.to_vec()),
        ]
    );
    let foreign: Vec<u8> = runs.iter().flat_map(|run| run.3.clone()).collect();
    assert_eq!(foreign, b"M10\r\nx");
}

#[test]
fn an_unfinished_frame_is_written_after_a_silence_and_at_the_end() {
    let file = written(|trace| {
        let link = trace.link("arm").unwrap();
        trace.record(link, NOON, Request, &GET_POSE[..3]).unwrap();
        trace
            .record(link, NOON + 60_000, Request, &GET_POSE)
            .unwrap();
        trace
            .record(link, NOON + 70_000, Reply, &GET_POSE[..4])
            .unwrap();
    });
    let bytes: Vec<_> = packets(&file)
        .into_iter()
        .map(|packet| (packet.0, packet.3))
        .collect();
    assert_eq!(
        bytes,
        [
            (NOON, GET_POSE[..3].to_vec()),
            (NOON + 60_000, GET_POSE.to_vec()),
            (NOON + 70_000, GET_POSE[..4].to_vec()),
        ]
    );
}

#[test]
fn other_programs_read_it() {
    let file = written(|trace| {
        let usb = trace.link("./arm").unwrap();
        let wifi = trace.link("udp:10.0.0.7:4000").unwrap();
        trace.record(usb, NOON, Request, &GET_POSE).unwrap();
        trace.record(wifi, NOON + 1, Reply, &CLEAR_ALARMS).unwrap();
    });
    let mut reader = PcapNgReader::new(&file[..]).unwrap();
    let (mut names, mut seen) = (Vec::new(), Vec::new());
    while let Some(block) = reader.next_block() {
        match block.unwrap() {
            Block::InterfaceDescription(link) => {
                assert_eq!(u32::from(link.linktype), 147);
                assert!(
                    link.options
                        .contains(&InterfaceDescriptionOption::IfTsResol(6))
                );
                names.extend(link.options.iter().find_map(|option| match option {
                    InterfaceDescriptionOption::IfName(name) => Some(name.to_string()),
                    _ => None,
                }));
            }
            Block::EnhancedPacket(packet) => {
                // This reader takes every tick for a nanosecond.
                let time = packet.timestamp.as_nanos() as u64;
                let flags = match packet.options[..] {
                    [EnhancedPacketOption::Flags(flags)] => flags,
                    _ => panic!("{:?}", packet.options),
                };
                seen.push((packet.interface_id, time, packet.data.to_vec(), flags));
            }
            other => panic!("{other:?}"),
        }
    }
    assert_eq!(names, ["./arm", "udp:10.0.0.7:4000"]);
    assert_eq!(
        seen,
        [
            (0, NOON, GET_POSE.to_vec(), 2),
            (1, NOON + 1, CLEAR_ALARMS.to_vec(), 1),
        ]
    );
}

/// Forwards to a file that outlives the writer; a kill is simulated by forgetting the writer.
#[derive(Clone, Default)]
struct Shared(Arc<Mutex<Vec<u8>>>, Arc<Mutex<usize>>);

impl Write for Shared {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.lock().unwrap().extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        *self.1.lock().unwrap() = self.0.lock().unwrap().len();
        Ok(())
    }
}

#[test]
fn a_killed_writer_leaves_all_frames() {
    let file = Shared::default();
    let mut trace = TraceWriter::new(file.clone()).unwrap();
    let link = trace.link("arm").unwrap();
    trace.record(link, NOON, Request, &GET_POSE).unwrap();
    trace
        .record(link, NOON, Request, &CLEAR_ALARMS[..4])
        .unwrap();
    std::mem::forget(trace);
    let flushed = *file.1.lock().unwrap();
    let bytes = file.0.lock().unwrap();
    assert_eq!(flushed, bytes.len());
    assert_eq!(packets(&bytes).len(), 1);
}

#[test]
fn a_file_cut_short_gives_its_packets_and_says_so() {
    let file = written(|trace| {
        let link = trace.link("arm").unwrap();
        trace.record(link, NOON, Request, &GET_POSE).unwrap();
        trace.record(link, NOON, Request, &GET_POSE).unwrap();
    });
    for cut in 1..44 {
        let mut trace = read_trace(&file[..file.len() - cut]);
        assert!(trace.next().unwrap().is_ok());
        assert!(
            matches!(trace.next(), Some(Err(TraceError::Truncated { .. }))),
            "{cut}"
        );
        assert_eq!(trace.next(), None);
    }
}

/// A block of another writer: big-endian, any time resolution.
fn big_endian(kind: u32, body: &[u8]) -> Vec<u8> {
    let length = (body.len() as u32 + 12).to_be_bytes();
    [&kind.to_be_bytes()[..], &length, body, &length].concat()
}

#[test]
fn traces_of_other_writers_are_read() {
    let mut file = big_endian(
        0x0A0D_0D0A,
        b"\x1A\x2B\x3C\x4D\0\x01\0\0\xFF\xFF\xFF\xFF\xFF\xFF\xFF\xFF",
    );
    // Link type 147, if_tsresol 9: nanoseconds.
    file.extend(big_endian(
        1,
        b"\0\x93\0\0\0\0\0\0\0\x09\0\x01\x09\0\0\0\0\0\0\0",
    ));
    // An unknown block, then a packet at 0x2_0000_0000 ns after 1970 without a direction.
    file.extend(big_endian(0xBAD, &[1, 2, 3, 4]));
    file.extend(big_endian(
        6,
        b"\0\0\0\0\0\0\0\x02\0\0\0\0\0\0\0\x06\0\0\0\x06\xAA\xAA\x02\x0A\0\xF6\0\0",
    ));
    assert_eq!(
        packets(&file),
        [(8_589_934, String::new(), None, GET_POSE.to_vec())]
    );
}

#[test]
fn a_trace_of_something_else_is_told() {
    let mut file = written(|_| ());
    let ethernet = b"\x01\0\0\0\x14\0\0\0\x01\0\0\0\0\0\0\0\x14\0\0\0";
    file.extend(ethernet);
    let mut trace = read_trace(&file);
    assert_eq!(
        trace.next(),
        Some(Err(TraceError::LinkType {
            link: 0,
            link_type: 1
        }))
    );
    assert_eq!(trace.next(), None);
    assert_eq!(
        read_trace(b"AA AA 02 0A 00 F6").next(),
        Some(Err(TraceError::NotATrace))
    );
    assert_eq!(read_trace(b"").next(), None);
    assert!(is_trace(&file) && !is_trace(b"AA AA"));
}

proptest! {
    #[test]
    fn all_bytes_come_back_in_order(
        pieces in prop::collection::vec(
            (any::<bool>(), any::<bool>(), 0u64..100_000, prop_oneof![
                Just(GET_POSE.to_vec()),
                prop::collection::vec(prop_oneof![Just(0xAA), any::<u8>()], 0..40),
            ]),
            0..30),
    ) {
        let mut expected = [vec![], vec![], vec![], vec![]];
        let file = written(|trace| {
            let links = [trace.link("a").unwrap(), trace.link("b").unwrap()];
            let mut time = NOON;
            for (link, reply, pause, bytes) in &pieces {
                time += pause;
                let direction = if *reply { Reply } else { Request };
                trace.record(links[usize::from(*link)], time, direction, bytes).unwrap();
                expected[usize::from(*link) * 2 + usize::from(*reply)].extend_from_slice(bytes);
            }
        });
        let mut found = [vec![], vec![], vec![], vec![]];
        for (_, name, direction, bytes) in packets(&file) {
            let at = usize::from(name == "b") * 2 + usize::from(direction == Some(Reply));
            found[at].extend(bytes);
        }
        prop_assert_eq!(found, expected);
    }

    #[test]
    fn garbage_is_an_error_and_no_more(
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..20),
        cut in any::<prop::sample::Index>(),
    ) {
        let mut file = written(|trace| {
            let link = trace.link("arm").unwrap();
            trace.record(link, NOON, Request, &GET_POSE).unwrap();
            trace.record(link, NOON, Reply, &[7; 33]).unwrap();
        });
        for (at, byte) in changes {
            let at = at.index(file.len());
            file[at] = byte;
        }
        file.truncate(cut.index(file.len()) + 1);
        let blocks = file.len() / 12 + 2;
        prop_assert!(read_trace(&file).count() <= blocks);
    }
}
