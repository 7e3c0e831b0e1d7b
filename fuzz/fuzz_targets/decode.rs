#![no_main]
//! Frame of any id, Ctrl and parameters: decoded, described, encoded, printed and parsed again.

use libfuzzer_sys::fuzz_target;
use magician_protocol::{
    Ctrl, Description, Direction, FieldValue, Frame, FrameBuf, Get, MAX_NOTES, MAX_PARAMS, Request,
    Set, Writer, describe, encode_text,
};

fn written(encode: impl FnOnce(&mut Writer<'_>)) -> Vec<u8> {
    let mut params = [0; MAX_PARAMS];
    let mut writer = Writer::new(&mut params);
    encode(&mut writer);
    let count = writer.finish().expect("what came in a frame fits a frame");
    params[..count].to_vec()
}

fn write_back(frame: &Frame<'_>) {
    let id = frame.id();
    match Request::decode(frame) {
        Ok(Request::Get(get)) => {
            let first = written(|writer| get.encode(writer));
            let again = Get::decode(id, &first).expect("our own form");
            assert_eq!(first, written(|writer| again.encode(writer)));
        }
        Ok(Request::Set(set) | Request::Queue(set)) => {
            let first = written(|writer| set.encode(writer));
            let again = Set::decode(id, &first).expect("our own form");
            assert_eq!(first, written(|writer| again.encode(writer)));
            assert_eq!(set.row().id, id);
        }
        Ok(Request::Nothing) | Err(_) => {}
    }
}

/// Returns a value in the command line's notation; `None` if its text does not contain all of it.
fn argument(value: &FieldValue<'_>) -> Option<String> {
    let plain = |value: &FieldValue<'_>| !matches!(value, FieldValue::Float(x) if x.is_nan());
    match value {
        FieldValue::Enum(_, byte) => Some(byte.to_string()),
        FieldValue::Text(bytes) => std::str::from_utf8(bytes).ok().map(str::to_owned),
        FieldValue::Alarms(_) => None,
        value => {
            (plain(value) && value.items().all(|item| plain(&item))).then(|| value.to_string())
        }
    }
}

fn explain(frame: &Frame<'_>, direction: Direction) {
    let Ok(description) = describe(frame, direction) else {
        return;
    };
    assert!(description.notes().count() <= MAX_NOTES);
    serde_json::to_string(&description).expect("every value has a JSON form");
    let values: Vec<_> = description.values().expect("it was tried").collect();
    let all = values.len() == description.layout.fields.len();
    let printed: Option<Vec<_>> = values.iter().map(|(_, value)| argument(value)).collect();
    let (true, true, Some(printed)) = (description.exact(), all, printed) else {
        return;
    };
    let names = values.iter().map(|(field, _)| field.name);
    let arguments: Vec<_> = names.zip(printed.iter().map(String::as_str)).collect();
    let mut result = Ok(());
    let mut params = [0; MAX_PARAMS];
    let mut writer = Writer::new(&mut params);
    if encode_text(description.layout, &arguments, &mut writer).is_err() {
        result = Err(());
    }
    let count = writer.finish().expect("it came in a frame");
    let padded = |field: &magician_protocol::Field| field.ty.size().is_none();
    // A text may have come without its NUL or with several.
    if !description.layout.fields.iter().any(padded) {
        assert_eq!((result, &params[..count]), (Ok(()), frame.params()));
    }
}

fuzz_target!(|data: &[u8]| {
    let [id, ctrl, params @ ..] = data else {
        return;
    };
    let Ok(frame) = FrameBuf::new(*id, Ctrl(*ctrl), params) else {
        assert!(params.len() > MAX_PARAMS);
        return;
    };
    let frame = frame.frame();
    write_back(&frame);
    explain(&frame, Direction::Request);
    explain(&frame, Direction::Reply);
    let guess = Description::guess(&frame);
    let either = [Direction::Request, Direction::Reply].map(|d| describe(&frame, d).is_ok());
    assert_eq!(guess.is_ok(), either.contains(&true));
});
