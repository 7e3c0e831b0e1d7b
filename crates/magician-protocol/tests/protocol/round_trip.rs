//! Bytes to values and back, for every layout and arbitrary bytes.

use crate::material::{bytes_of, reencode_get, reencode_set, reencode_value};
use magician_protocol::{
    AlarmSet, Ctrl, DecodeError, Description, Direction, Field, FieldType, FieldValue, FrameBuf,
    LayoutInfo, PoList, Request, Row, Scalar, TABLE, describe, encode_text,
};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

fn config(cases: u32) -> ProptestConfig {
    ProptestConfig {
        cases,
        rng_seed: RngSeed::Fixed(0xD0B07),
        failure_persistence: None,
        ..ProptestConfig::default()
    }
}

type ReEncode = fn(u8, &[u8]) -> Result<Vec<u8>, DecodeError>;

fn reencode_reply(id: u8, params: &[u8]) -> Result<Vec<u8>, DecodeError> {
    let mut result = Ok(());
    let bytes = bytes_of(|writer| result = reencode_value(id, params, writer));
    result.map(|()| bytes)
}

/// All layouts, each with its typed decode and encode.
fn forms() -> Vec<(&'static Row, &'static LayoutInfo, ReEncode)> {
    let mut forms = Vec::new();
    for row in TABLE {
        forms.extend(row.query.map(|info| (row, info, reencode_get as ReEncode)));
        forms.extend(
            row.value
                .map(|info| (row, info, reencode_reply as ReEncode)),
        );
        forms.extend(row.set.map(|info| (row, info, reencode_set as ReEncode)));
    }
    forms
}

/// Parameters that a strict sender could write, from arbitrary bytes.
fn canonical(info: &LayoutInfo, noise: &[u8]) -> Vec<u8> {
    let mut noise = noise.iter().copied();
    let mut params = Vec::new();
    for field in info.fields {
        let count = usize::from(noise.next().unwrap());
        match field.ty {
            ty if ty.size().is_some() => {
                let left_out = field.optional && field.default.is_none() && count % 2 == 0;
                params.extend(
                    noise
                        .by_ref()
                        .take(if left_out { 0 } else { ty.size().unwrap() }),
                );
            }
            FieldType::Text => {
                let text = noise.by_ref().filter(|byte| *byte != 0).take(count % 60);
                params.extend(text);
                params.push(0);
            }
            FieldType::Alarms => {
                params.extend(noise.by_ref().take(count % AlarmSet::CAPACITY + 1));
            }
            FieldType::Outputs => params.extend(noise.by_ref().take(count % PoList::CAPACITY * 4)),
            _ => params.extend(noise.by_ref().take(count % 60)),
        }
    }
    params
}

/// Wire bytes of a value that was decoded through the layout description.
fn write_back(field: &Field, value: &FieldValue<'_>) -> Vec<u8> {
    let scalar = |scalar: Scalar, value: &FieldValue<'_>| match value {
        FieldValue::Unsigned(number) => number.to_le_bytes()[..scalar.size()].to_vec(),
        FieldValue::Signed(number) => number.to_le_bytes().to_vec(),
        FieldValue::Float(number) => number.to_bits().to_le_bytes().to_vec(),
        other => panic!("{other:?}"),
    };
    match (field.ty, value) {
        (FieldType::Scalar(ty), value) => scalar(ty, value),
        (FieldType::Array(ty, count), value) => {
            assert_eq!(value.items().count(), count);
            value.items().flat_map(|item| scalar(ty, &item)).collect()
        }
        (FieldType::Flag, FieldValue::Flag(byte)) => vec![*byte],
        (FieldType::Enum(info), FieldValue::Enum(same, byte)) if info == *same => vec![*byte],
        (FieldType::Text, FieldValue::Text(bytes)) => [bytes, &[0][..]].concat(),
        (FieldType::Bytes, FieldValue::Bytes(bytes)) => bytes.to_vec(),
        (FieldType::Alarms, FieldValue::Alarms(set)) => set.as_bytes().to_vec(),
        (FieldType::Outputs, FieldValue::Outputs(list)) => {
            let item = |item: &magician_protocol::PoCmd| {
                let [low, high] = item.address.to_le_bytes();
                [item.ratio, low, high, item.level]
            };
            list.as_slice().iter().flat_map(item).collect()
        }
        other => panic!("{other:?}"),
    }
}

/// Text, as a command-line argument, of a value that was decoded through the layout description.
fn argument(value: &FieldValue<'_>) -> String {
    match value {
        FieldValue::Enum(_, byte) => byte.to_string(),
        FieldValue::Alarms(set) => {
            let bytes: Vec<_> = set.as_bytes().iter().map(u8::to_string).collect();
            bytes.join(",")
        }
        value => value.to_string(),
    }
}

proptest! {
    #![proptest_config(config(100))]

    #[test]
    fn canonical_bytes_come_back(noise in prop::collection::vec(any::<u8>(), 300)) {
        for (row, info, reencode) in forms() {
            let params = canonical(info, &noise);
            prop_assert_eq!(reencode(row.id, &params), Ok(params.clone()), "{}", info.name);
        }
    }

    #[test]
    fn reflection_agrees_with_the_typed_decode(
        noise in prop::collection::vec(any::<u8>(), 0..=248),
    ) {
        for (row, info, reencode) in forms() {
            let values = info.values(&noise);
            let typed = reencode(row.id, &noise);
            prop_assert_eq!(values.is_ok(), typed.is_ok(), "{}", info.name);
            let (Ok(values), Ok(typed)) = (values, typed) else { continue };
            let written: Vec<u8> = values.flat_map(|(f, v)| write_back(f, &v)).collect();
            // A short form is padded; text that fills the frame has no room for its NUL.
            let same = typed.starts_with(&written) || written.starts_with(&typed);
            prop_assert!(same, "{}: {written:?} {typed:?}", info.name);
            if info.min_size() < noise.len() && info.forms.is_empty() {
                prop_assert!(typed.len().abs_diff(written.len()) <= 1, "{}", info.name);
            }
        }
    }

    #[test]
    fn printed_values_are_read_back(noise in prop::collection::vec(any::<u8>(), 300)) {
        for (_, info, _) in forms() {
            let mut params = canonical(info, &noise);
            if info.fields.iter().any(|field| field.ty == FieldType::Text) {
                params.retain(u8::is_ascii_graphic);
                params.push(0);
            }
            let values: Vec<_> = info.values(&params).unwrap().collect();
            let special = |value: FieldValue<'_>| {
                let nan = |v: &FieldValue<'_>| matches!(v, FieldValue::Float(x) if x.is_nan());
                nan(&value) || value.items().any(|item| nan(&item))
            };
            // NaN prints as one word whatever its payload.
            if values.iter().any(|(_, value)| special(*value)) {
                continue;
            }
            let printed: Vec<_> = values.iter().map(|(f, v)| (f.name, argument(v))).collect();
            let arguments: Vec<_> = printed.iter().map(|(n, t)| (*n, t.as_str())).collect();
            let mut result = Ok(());
            let read = bytes_of(|writer| result = encode_text(info, &arguments, writer));
            prop_assert_eq!(result, Ok(()), "{}", info.name);
            prop_assert_eq!(read, params, "{}", info.name);
        }
    }

    #[test]
    fn deframer_returns_framed_bytes(
        noise in prop::collection::vec(any::<u8>(), 300),
        queued in any::<bool>(),
    ) {
        for (row, info, _) in forms() {
            let params = canonical(info, &noise);
            let ctrl = if queued { Ctrl::QUEUED } else { Ctrl::GET };
            let frame = FrameBuf::new(row.id, ctrl, &params).unwrap();
            let mut deframer = magician_protocol::Deframer::new();
            let mut input = frame.bytes();
            let event = deframer.next(&mut input);
            let found = matches!(
                event,
                Some(magician_protocol::Event::Frame { frame: f, .. }) if f.bytes() == frame.bytes()
            );
            prop_assert!(found && input.is_empty(), "{frame:?}");
        }
    }
}

proptest! {
    #![proptest_config(config(5_000))]

    #[test]
    fn nothing_panics(
        id in any::<u8>(),
        ctrl in any::<u8>(),
        params in prop::collection::vec(any::<u8>(), 0..=248),
    ) {
        let frame = FrameBuf::new(id, Ctrl(ctrl), &params).unwrap();
        let frame = frame.frame();
        prop_assert_eq!((frame.id(), frame.ctrl().0, frame.params()), (id, ctrl, &params[..]));
        let request = Request::decode(&frame);
        let expected = request_by_row(id, Ctrl(ctrl), &params);
        // Compared as text, since NaN is not equal to itself.
        prop_assert_eq!(format!("{request:?}"), format!("{expected:?}"));
        for direction in [Direction::Request, Direction::Reply] {
            if let Ok(description) = describe(&frame, direction) {
                let values = description.values().unwrap();
                for (_, value) in values {
                    let _ = value.to_string();
                }
                prop_assert!(description.notes().count() <= magician_protocol::MAX_NOTES);
            }
        }
        let guess = Description::guess(&frame);
        prop_assert_eq!(guess.is_ok(), [Direction::Request, Direction::Reply]
            .into_iter()
            .any(|direction| describe(&frame, direction).is_ok()));
    }

    #[test]
    fn text_arguments_never_panic(
        id in 0usize..90,
        texts in prop::collection::vec((0usize..8, "\\PC{0,40}"), 0..8),
    ) {
        let row = &TABLE[id];
        for info in [row.query, row.value, row.set].into_iter().flatten() {
            let name = |at: usize| info.fields.get(at).map_or("other", |field| field.name);
            let list: Vec<_> = texts.iter().map(|(at, text)| (name(*at), text.as_str())).collect();
            let mut params = [0; 248];
            let mut writer = magician_protocol::Writer::new(&mut params);
            if let Err(error) = encode_text(info, &list, &mut writer) {
                prop_assert!(!error.to_string().is_empty());
            }
        }
    }
}

/// Second implementation of errata E07 and E12, independent of the code.
fn request_by_row(id: u8, ctrl: Ctrl, params: &[u8]) -> Result<Request, DecodeError> {
    use magician_protocol::{Get, Set};
    let row = Row::with_id(id).ok_or(DecodeError::UnknownId(id))?;
    if row.set.is_none() {
        return Get::decode(id, params).map(Request::Get);
    }
    let queued = ctrl.0 & 2 != 0 && !(240..=245).contains(&id);
    let written = ctrl.0 & 1 != 0;
    match (queued, written, row.value.is_some()) {
        (true, ..) => Set::decode(id, params).map(Request::Queue),
        (false, true, _) => Set::decode(id, params).map(Request::Set),
        (false, false, true) => Get::decode(id, params).map(Request::Get),
        (false, false, false) => Ok(Request::Nothing),
    }
}
