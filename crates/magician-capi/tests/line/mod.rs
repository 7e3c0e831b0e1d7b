//! Test bench for the exported functions of a family: a virtual arm behind a socket that records
//! all frames, the expected frames, and memory as a C program has it.
// Each test binary uses only a part of it.
#![allow(dead_code, unreachable_pub)]

use std::collections::{BTreeMap, BTreeSet};
use std::ffi::{CString, c_char, c_int};
use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::ptr;
use std::sync::{Arc, Condvar, Mutex};
use std::thread;
use std::time::Duration;

use magician_capi::pointer::{Buffer, In, Out, Plain, Text};
use magician_capi::{FUNCTIONS, Family, Kind};
use magician_sim::{Controller, LinkId, Profile};

/// Initial bytes of memory for results.
const UNTOUCHED: u8 = 0xEE;
/// Guard bytes after a result, which must stay untouched.
const GUARD: usize = 16;
/// Step of the arm's clock between two requests: long enough that the first one has finished.
const CLOCK_STEP: Duration = Duration::from_secs(60);
/// Ids that the driver reads on its own: the queue, once per connection and after a slow reply.
const HOUSEKEEPING: [[u8; 2]; 2] = [[246, 0], [247, 0]];
/// Requests of the driver itself a tenth of a second after connecting: serial number and clock.
const INTRODUCTION: [[u8; 6]; 2] = [[0xAA, 0xAA, 2, 0, 0, 0], [0xAA, 0xAA, 2, 4, 0, 0xFC]];
/// Timeout of every wait. Long, for a machine under load.
const WAIT_TIMEOUT: Duration = Duration::from_secs(120);
/// Pin of a `GetIODO` that serves as a barrier: no call under test uses it, and once it is answered
/// everything sent before has arrived.
const BARRIER_PIN: u8 = 20;
const BARRIER: [u8; 7] = [0xAA, 0xAA, 3, 131, 0, BARRIER_PIN, 0x69];

/// A request frame and its reply frame.
#[derive(Clone, Debug)]
pub struct Exchange {
    pub request: Vec<u8>,
    pub reply: Vec<u8>,
}

/// A virtual arm behind a socket, with a record of all frames.
pub struct Line {
    port: u16,
    seen: Arc<SeenFrames>,
    get_io_do: Box<dyn Fn(&mut Slot) -> c_int>,
}

/// Recorded exchanges, with a notification.
#[derive(Default)]
struct SeenFrames {
    exchanges: Mutex<Vec<Exchange>>,
    more: Condvar,
}

impl SeenFrames {
    fn add(&self, exchange: Exchange) {
        let mut exchanges = self.exchanges.lock().expect("no test panics with it");
        exchanges.push(exchange);
        self.more.notify_all();
    }

    /// Waits until these requests have arrived, in this order.
    fn wait_for(&self, requests: &[[u8; 6]]) {
        let exchanges = self.exchanges.lock().expect("no test panics with it");
        let missing = |all: &mut Vec<Exchange>| {
            let mut came = all.iter();
            !(requests.iter()).all(|request| came.any(|e| e.request == *request))
        };
        // With a timeout, so that the test fails instead of hanging.
        let waited = self
            .more
            .wait_timeout_while(exchanges, WAIT_TIMEOUT, missing);
        let (exchanges, over) = waited.expect("no test panics with it");
        assert!(!over.timed_out(), "{requests:02X?} not in {exchanges:02X?}");
    }

    fn take(&self) -> Vec<Exchange> {
        std::mem::take(&mut *self.exchanges.lock().expect("no test panics with it"))
    }
}

impl Line {
    fn open(get_io_do: Box<dyn Fn(&mut Slot) -> c_int>) -> Self {
        let listener = TcpListener::bind(("127.0.0.1", 0)).expect("a port");
        let port = listener.local_addr().expect("an address").port();
        let seen = Arc::<SeenFrames>::default();
        let book = Arc::clone(&seen);
        thread::spawn(move || {
            let mut arm = Controller::new(Profile::default());
            for stream in listener.incoming().flatten() {
                // The arm survives the end of a connection.
                drop(serve(&mut arm, stream, &book));
            }
        });
        Self {
            port,
            seen,
            get_io_do,
        }
    }

    /// Connects the library to a virtual arm. `connect` calls the family's `ConnectDobot` with a
    /// port name, `get_io_do` its `GetIODO`.
    pub fn connected(
        connect: impl FnOnce(Text) -> c_int,
        get_io_do: impl Fn(&mut Slot) -> c_int + 'static,
    ) -> Self {
        let line = Self::open(Box::new(get_io_do));
        let port = format!("tcp:127.0.0.1:{}", line.port);
        assert_eq!(connect(text(port.as_bytes())), 0);
        // Wait for the driver's own requests, so that they do not mix with those under test.
        line.seen.wait_for(&INTRODUCTION);
        line
    }

    /// Returns all exchanges since the last call. Identical copies count as one: on a slow machine
    /// the driver retransmits.
    pub fn take_exchanges(&self) -> Vec<Exchange> {
        let mut pin = Slot::with(&[BARRIER_PIN, 0]);
        assert_eq!((self.get_io_do)(&mut pin), 0);
        let mut exchanges = self.seen.take();
        exchanges.retain(|exchange| exchange.request != BARRIER);
        exchanges.dedup_by(|again, first| again.request == first.request && may_be_repeated(first));
        exchanges
    }

    /// Like [`take_exchanges`](Self::take_exchanges), without the driver's own requests.
    pub fn take_call_exchanges(&self) -> Vec<Exchange> {
        let mut exchanges = self.take_exchanges();
        exchanges.retain(|exchange| !is_housekeeping(exchange));
        exchanges
    }
}

fn is_housekeeping(exchange: &Exchange) -> bool {
    HOUSEKEEPING.contains(&[exchange.request[3], exchange.request[4]])
}

/// True if the request may be retransmitted: queued commands never are.
fn may_be_repeated(exchange: &Exchange) -> bool {
    exchange.request[4] & 2 == 0
}

fn serve(arm: &mut Controller, mut stream: TcpStream, book: &SeenFrames) -> std::io::Result<()> {
    let link = LinkId(1);
    let mut waiting = Vec::new();
    let mut bytes = [0; 1024];
    loop {
        let count = stream.read(&mut bytes)?;
        if count == 0 {
            return Ok(());
        }
        waiting.extend_from_slice(&bytes[..count]);
        while let Some(request) = first_frame(&mut waiting) {
            let replies = arm.exchange(link, &request);
            let reply: Vec<u8> = replies
                .iter()
                .flat_map(|frame| frame.bytes())
                .copied()
                .collect();
            // Record before the reply is sent, because the receiver may look at the record at once.
            let exchange = Exchange {
                request,
                reply: reply.clone(),
            };
            book.add(exchange);
            stream.write_all(&reply)?;
            arm.advance(arm.now() + CLOCK_STEP);
        }
    }
}

/// Takes the first frame off `waiting`, which must contain nothing else.
fn first_frame(waiting: &mut Vec<u8>) -> Option<Vec<u8>> {
    let [first, second, length, ..] = waiting[..] else {
        return None;
    };
    assert_eq!([first, second], [0xAA, 0xAA], "{waiting:02X?}");
    let whole = usize::from(length) + 4;
    (waiting.len() >= whole).then(|| waiting.drain(..whole).collect())
}

/// Memory for results, followed by a guard.
pub struct Slot(Box<[u8]>);

impl Slot {
    pub fn new(size: usize) -> Self {
        Self::with(&vec![UNTOUCHED; size])
    }

    pub fn with(bytes: &[u8]) -> Self {
        Self([bytes, &[UNTOUCHED; GUARD]].concat().into())
    }

    pub fn out<T: Plain>(&mut self) -> Out<T> {
        assert_eq!(size_of::<T>(), self.0.len() - GUARD);
        self.first()
    }

    /// Pointer to the first of several results.
    #[allow(unsafe_code)]
    pub fn first<T: Plain>(&mut self) -> Out<T> {
        // SAFETY: as many bytes are there, and they live as long as the slot.
        unsafe { Out::new(self.0.as_mut_ptr().cast()) }
    }

    #[allow(unsafe_code)]
    pub fn text(&mut self) -> Buffer {
        // SAFETY: as above.
        unsafe { Buffer::new(self.0.as_mut_ptr().cast::<c_char>()) }
    }

    /// Returns the bytes of the result, after a check that the guard is untouched.
    pub fn bytes(&self) -> &[u8] {
        let (bytes, guard) = self.0.split_at(self.0.len() - GUARD);
        assert_eq!(guard, [UNTOUCHED; GUARD], "written past the end");
        bytes
    }

    pub fn is_untouched(&self) -> bool {
        self.bytes().iter().all(|byte| *byte == UNTOUCHED)
    }
}

/// Leaks one or several structures and returns a pointer to them.
#[allow(unsafe_code)]
pub fn give<T: Plain>(bytes: &[u8]) -> In<T> {
    assert_eq!(bytes.len() % size_of::<T>(), 0);
    let bytes: &'static [u8] = bytes.to_vec().leak();
    // SAFETY: it is never freed.
    unsafe { In::new(bytes.as_ptr().cast()) }
}

/// A null pointer for text.
#[allow(unsafe_code)]
pub const fn none() -> Buffer {
    // SAFETY: null is allowed.
    unsafe { Buffer::new(ptr::null_mut()) }
}

/// A null pointer for a value.
#[allow(unsafe_code)]
pub const fn null_in<T: Plain>() -> In<T> {
    // SAFETY: null is allowed.
    unsafe { In::new(ptr::null()) }
}

/// An invalid pointer for a result.
#[allow(unsafe_code)]
pub const fn invalid_out<T: Plain>() -> Out<T> {
    // SAFETY: only for what must not be looked at.
    unsafe { Out::new(ptr::dangling_mut()) }
}

/// Leaks a C string and returns a pointer to it.
#[allow(unsafe_code)]
pub fn text(bytes: &[u8]) -> Text {
    let text = CString::new(bytes).expect("no NUL inside");
    // SAFETY: it is never freed.
    unsafe { Text::new(text.into_raw()) }
}

/// Bytes of numbers in memory.
pub fn floats(numbers: &[f32]) -> Vec<u8> {
    numbers
        .iter()
        .flat_map(|number| number.to_le_bytes())
        .collect()
}

/// A call: name of its frame in the golden list, and the function to run.
pub struct Call {
    pub name: &'static str,
    pub make: Box<dyn Fn() -> CallResult>,
}

/// Result of a call: return code, and the results as they should appear in the reply.
pub type CallResult = (c_int, Vec<u8>);

impl Call {
    pub fn new(name: &'static str, make: impl Fn() -> CallResult + 'static) -> Self {
        let make = Box::new(make);
        Self { name, make }
    }

    /// Function that the call concerns.
    fn function(&self) -> &'static str {
        let words = self.name.split(' ');
        let mut words = words.filter(|word| !matches!(*word, "v1" | "v2" | "v3"));
        words.next().expect("a name")
    }
}

/// Expected frames by name.
fn golden() -> BTreeMap<&'static str, Vec<u8>> {
    let lines = include_str!("golden.txt").lines();
    let lines = lines.filter(|line| !line.starts_with('#'));
    let entries = lines.map(|line| {
        let (name, frame) = line.split_once(": ").expect("NAME: FRAME");
        let frame = frame.split('#').next().unwrap_or_default();
        let bytes = frame.split_whitespace();
        let bytes = bytes.map(|byte| u8::from_str_radix(byte, 16).expect("hexadecimal"));
        (name, bytes.collect())
    });
    entries.collect()
}

/// Functions whose set and get concern different things: set switches a sensor, get reads it.
const ASYMMETRIC: [&str; 2] = ["ColorSensor", "InfraredSensor"];

/// Makes every call. Compares its frame with the golden list, and its results with the arm's reply
/// and with the values set before. Guarded functions are refused first, without sending anything.
pub fn check_golden(line: &Line, family: Family, calls: &[Call], allow: impl Fn(Text) -> c_int) {
    let golden = golden();
    let mut written = BTreeMap::new();
    for call in calls {
        let name = call.name;
        let frame = golden
            .get(name)
            .unwrap_or_else(|| panic!("no frame of {name}"));
        line.take_exchanges();
        if kind(family, call.function()) == Kind::Guarded {
            assert_eq!((call.make)().0, 3, "{name} before it was allowed");
            assert!(
                line.take_call_exchanges().is_empty(),
                "{name} before it was allowed"
            );
            assert_eq!(allow(text(call.function().as_bytes())), 0, "{name}");
        }
        let (code, given) = (call.make)();
        let exchanges = line.take_exchanges();
        assert_eq!(code, 0, "{name}: {exchanges:02X?}");
        let (meant, else_): (Vec<_>, Vec<_>) =
            exchanges.into_iter().partition(|e| e.request == *frame);
        let [exchange] = &meant[..] else {
            panic!("{name} sent {else_:02X?}, not once {frame:02X?}");
        };
        for exchange in &else_ {
            assert!(is_housekeeping(exchange), "{name} sent {exchange:02X?}");
        }
        let answer = &exchange.reply[5..exchange.reply.len() - 1];
        assert!(
            answer.starts_with(&given),
            "{name}: {given:02X?} of {answer:02X?}"
        );
        let writes = frame[4] & 1 == 1 || frame[3] == 160;
        assert!(writes || !given.is_empty(), "{name} gave nothing");
        if let Some(what) = call.function().strip_prefix("Set") {
            written.insert(what, frame[5..frame.len() - 1].to_vec());
        }
        let what = call
            .function()
            .strip_prefix("Get")
            .filter(|what| !ASYMMETRIC.contains(what));
        if let Some(set) = what.and_then(|what| written.get(what)) {
            assert!(
                set.starts_with(&given),
                "{name}: {given:02X?} of {set:02X?}"
            );
            assert!(given.iter().any(|byte| *byte != 0), "{name}");
        }
    }
    let called: BTreeSet<&str> = calls.iter().map(Call::function).collect();
    let sending: BTreeSet<&str> = FUNCTIONS
        .iter()
        .filter(|function| function.families.contains(&family))
        .filter(|function| matches!(function.kind, Kind::Command | Kind::Guarded))
        .map(|function| function.name)
        .collect();
    assert_eq!(called, sending);
}

fn kind(family: Family, name: &str) -> Kind {
    let mut all = FUNCTIONS.iter();
    let function = all.find(|f| f.name == name && f.families.contains(&family));
    function
        .unwrap_or_else(|| panic!("no {name} in {family:?}"))
        .kind
}
