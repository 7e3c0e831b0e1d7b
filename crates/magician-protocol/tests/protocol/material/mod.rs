//! Recorded frames shared by the tests, and comparison of their values.
#![allow(unreachable_pub)]

use magician_protocol::{
    Ctrl, DecodeError, Deframer, Direction, Event, FieldValue, Frame, FrameBuf, Get, Layout,
    QueuedCmdIndex, Readable, Request, Set, Writer, commands, describe,
};
use toml::{Table, Value};

pub const VECTORS: &str = include_str!("../../data/vectors.toml");
pub const GOLDEN: &str = include_str!("../../data/golden.toml");

/// A frame recorded from another program, and its values.
pub struct Recorded {
    pub id: String,
    pub bytes: Vec<u8>,
    pub direction: Direction,
    pub fields: Table,
}

impl Recorded {
    fn new(id: String, fields: Table) -> Self {
        let direction = match fields["direction"].as_str().unwrap() {
            "host_to_device" => Direction::Request,
            "device_to_host" => Direction::Reply,
            other => panic!("direction {other}"),
        };
        Self {
            id,
            bytes: hex(fields["hex"].as_str().unwrap()),
            direction,
            fields,
        }
    }

    pub fn valid(&self) -> bool {
        self.fields
            .get("frame_valid")
            .is_none_or(|valid| valid.as_bool().unwrap())
    }

    pub fn number(&self, key: &str) -> u8 {
        u8::try_from(self.fields[key].as_integer().unwrap()).unwrap()
    }

    /// True if a strict sender writes the frame like this.
    pub fn canonical(&self) -> bool {
        self.fields
            .get("semantic")
            .is_none_or(|semantic| semantic.as_str() == Some("ok"))
    }

    pub fn frame(&self) -> Frame<'_> {
        Frame::new(&self.bytes).unwrap_or_else(|| panic!("{}: no frame", self.id))
    }
}

pub fn vectors() -> Vec<Recorded> {
    let table: Table = toml::from_str(VECTORS).unwrap();
    let vectors = table["vector"].as_array().unwrap();
    let recorded = |vector: &Value| {
        let fields = vector.as_table().unwrap().clone();
        Recorded::new(fields["id"].as_str().unwrap().into(), fields)
    };
    vectors.iter().map(recorded).collect()
}

pub fn golden() -> Vec<Recorded> {
    let table: Table = toml::from_str(GOLDEN).unwrap();
    let frames = table["frame"].as_array().unwrap();
    let recorded = |frame: &Value| {
        let fields = frame.as_table().unwrap().clone();
        let id = format!("{} ({})", fields["command"], fields["source"]);
        Recorded::new(id, fields)
    };
    frames.iter().map(recorded).collect()
}

/// All valid recorded frames.
pub fn frames() -> Vec<Recorded> {
    let all = vectors().into_iter().chain(golden());
    all.filter(Recorded::valid).collect()
}

pub fn hex(text: &str) -> Vec<u8> {
    text.split_whitespace()
        .map(|byte| u8::from_str_radix(byte, 16).unwrap())
        .collect()
}

/// Asserts that a valid frame decodes to the recorded values and, if canonical, encodes to the same
/// bytes.
pub fn check(recorded: &Recorded) {
    let id = &recorded.id;
    let mut deframer = Deframer::new();
    let mut input = &recorded.bytes[..];
    let Some(Event::Frame { offset: 0, frame }) = deframer.next(&mut input) else {
        panic!("{id}: not deframed");
    };
    assert_eq!(frame.bytes(), recorded.bytes, "{id}");
    assert_eq!(frame.id(), recorded.number("cmd_id"), "{id}");
    assert_eq!(frame.ctrl().0, recorded.number("ctrl"), "{id}");

    let description = describe(&frame, recorded.direction).unwrap_or_else(|e| panic!("{id}: {e}"));
    assert_eq!(
        Some(description.name),
        recorded.fields["command"].as_str(),
        "{id}"
    );
    let mut expected = recorded.fields["decoded"].as_table().unwrap().clone();
    let extra = expected.remove("_extra_hex");
    let truncated = expected.remove("_truncated");
    let lenient = extra.is_some() || truncated.is_some();
    if lenient {
        assert!(description.notes().count() > 0, "{id}: a leniency, unsaid");
    }
    let values: Vec<_> = description.values().unwrap().collect();
    let names: Vec<_> = values.iter().map(|(field, _)| field.name).collect();
    let keys: Vec<_> = expected.keys().map(String::as_str).collect();
    let sorted = |mut names: Vec<&str>| {
        names.sort_unstable();
        names.join(" ")
    };
    assert_eq!(sorted(names), sorted(keys), "{id}: fields");
    for (field, value) in values {
        let wanted = &expected[field.name];
        assert!(
            same(&value, wanted),
            "{id}: {} {value} {wanted}",
            field.name
        );
    }
    if recorded.canonical() && !lenient {
        let reencoded = reencode(&frame, recorded.direction);
        assert_eq!(reencoded, recorded.bytes, "{id}: encoded again");
    }
}

/// True if a value equals the recorded one.
pub fn same(value: &FieldValue<'_>, written: &Value) -> bool {
    match (value, written) {
        (FieldValue::Float(x), written) => {
            let number = match written {
                Value::Integer(number) => *number as f64,
                other => other.as_float().unwrap(),
            };
            x.to_bits() == (number as f32).to_bits()
        }
        (FieldValue::Unsigned(x), Value::Integer(n)) => i128::from(*x) == i128::from(*n),
        (FieldValue::Signed(x), Value::Integer(n)) => i64::from(*x) == *n,
        (FieldValue::Flag(x) | FieldValue::Enum(_, x), Value::Integer(n)) => i64::from(*x) == *n,
        (FieldValue::Array(..), Value::Array(items)) => {
            value.items().count() == items.len()
                && value.items().zip(items).all(|(item, w)| same(&item, w))
        }
        (FieldValue::Text(bytes), Value::String(text)) => *bytes == text.as_bytes(),
        (FieldValue::Alarms(set), Value::Array(items)) => {
            let written = items.iter().map(|item| item.as_integer().unwrap());
            set.as_bytes().iter().map(|b| i64::from(*b)).eq(written)
        }
        (FieldValue::Outputs(list), Value::Array(items)) => {
            let written = items
                .iter()
                .map(|item| ["ratio", "address", "level"].map(|key| item[key].as_integer()));
            let read = list
                .as_slice()
                .iter()
                .map(|item| [item.ratio.into(), item.address.into(), item.level.into()].map(Some));
            read.eq(written)
        }
        _ => false,
    }
}

/// Decodes a frame to typed values and encodes them again.
pub fn reencode(frame: &Frame<'_>, direction: Direction) -> Vec<u8> {
    let mut params = [0; magician_protocol::MAX_PARAMS];
    let mut writer = Writer::new(&mut params);
    let request = Request::decode(frame);
    match (direction, request) {
        (Direction::Request, Ok(Request::Get(get))) => get.encode(&mut writer),
        (Direction::Request, Ok(Request::Set(set) | Request::Queue(set))) => {
            set.encode(&mut writer);
        }
        (Direction::Reply, _) => encode_reply(frame, &mut writer),
        (_, other) => panic!("{other:?}"),
    }
    let count = writer.finish().unwrap();
    let reencoded = FrameBuf::new(frame.id(), frame.ctrl(), &params[..count]).unwrap();
    reencoded.bytes().to_vec()
}

fn encode_reply(frame: &Frame<'_>, writer: &mut Writer<'_>) {
    match (frame.ctrl().write(), frame.ctrl().queued()) {
        (true, true) => frame.read::<QueuedCmdIndex>().unwrap().encode(writer),
        (true, false) => {}
        (false, _) => reencode_value(frame.id(), frame.params(), writer).unwrap(),
    }
}

macro_rules! reencode_value {
    ($($name:ident)+) => {
        /// Decodes the reply to a get of `id` and encodes it again.
        pub fn reencode_value(
            id: u8,
            params: &[u8],
            writer: &mut Writer<'_>,
        ) -> Result<(), DecodeError> {
            $(
                if id == <commands::$name as Readable>::ROW.id {
                    commands::$name::decode(params)?.encode(writer);
                    return Ok(());
                }
            )+
            Err(DecodeError::NoSuchForm(id))
        }
    };
}

magician_protocol::for_each_readable!(reencode_value);

/// Bytes that `encode` writes.
pub fn bytes_of(encode: impl FnOnce(&mut Writer<'_>)) -> Vec<u8> {
    let mut params = [0; magician_protocol::MAX_PARAMS];
    let mut writer = Writer::new(&mut params);
    encode(&mut writer);
    let count = writer.finish().unwrap();
    params[..count].to_vec()
}

pub fn reencode_get(id: u8, params: &[u8]) -> Result<Vec<u8>, DecodeError> {
    Get::decode(id, params).map(|get| bytes_of(|writer| get.encode(writer)))
}

pub fn reencode_set(id: u8, params: &[u8]) -> Result<Vec<u8>, DecodeError> {
    Set::decode(id, params).map(|set| bytes_of(|writer| set.encode(writer)))
}

pub fn frame(id: u8, ctrl: u8, params: &[u8]) -> FrameBuf {
    FrameBuf::new(id, Ctrl(ctrl), params).unwrap()
}

pub fn request(id: u8, ctrl: u8, params: &[u8]) -> Result<Request, DecodeError> {
    Request::decode(&frame(id, ctrl, params).frame())
}

pub fn notes(id: u8, ctrl: u8, params: &[u8], direction: Direction) -> Vec<&'static str> {
    let frame = frame(id, ctrl, params);
    describe(&frame.frame(), direction)
        .unwrap()
        .notes()
        .collect()
}

/// Asserts that a request has exactly one note, which names the erratum.
pub fn assert_single_note(id: u8, ctrl: u8, params: &[u8], erratum: &str) {
    let notes = notes(id, ctrl, params, Direction::Request);
    assert!(notes.len() == 1 && notes[0].contains(erratum), "{notes:?}");
}

pub fn fields(id: u8, ctrl: u8, params: &[u8], direction: Direction) -> String {
    let frame = frame(id, ctrl, params);
    let description = describe(&frame.frame(), direction).unwrap();
    let values = description.values().unwrap();
    let list: Vec<_> = values.map(|(f, v)| format!("{}={v}", f.name)).collect();
    list.join(" ")
}
