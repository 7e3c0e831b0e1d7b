//! Parameters from `key=value` arguments, and the errors for arguments that do not fit.

use magician_protocol::{
    DecodeError, FieldType, Flag, LayoutInfo, MAX_PARAMS, PoList, Row, Scalar, TABLE, Text, Wire,
    Writer, encode_text,
};

/// Parameters of the set of a command.
fn set(name: &str, arguments: &[(&str, &str)]) -> Result<Vec<u8>, String> {
    written(Row::find(name).unwrap().set.unwrap(), arguments)
}

fn written(info: &LayoutInfo, arguments: &[(&str, &str)]) -> Result<Vec<u8>, String> {
    let mut params = [0xEE; MAX_PARAMS];
    let mut writer = Writer::new(&mut params);
    encode_text(info, arguments, &mut writer).map_err(|error| error.to_string())?;
    let count = writer.finish().expect("it fits");
    Ok(params[..count].to_vec())
}

#[test]
fn omitted_field_is_encoded_as_its_default() {
    // The default is one turn; the points are as given.
    let circle = set(
        "CircleCmd",
        &[("cir_point", "1,0,0,0"), ("to_point", "0,2,0,0")],
    )
    .unwrap();
    assert_eq!(circle.len(), 36);
    assert_eq!(circle[32..], 1_u32.to_le_bytes());
    assert_eq!(circle[..4], 1_f32.to_le_bytes());
    // The default is 0 for both angles, in the arm's own form of nine bytes.
    assert_eq!(
        set("ResetPose", &[("manual", "1")]).unwrap(),
        [1, 0, 0, 0, 0, 0, 0, 0, 0]
    );
    assert_eq!(set("HOMECmd", &[]).unwrap(), [0; 4]);
}

#[test]
fn missing_field_error_names_field_and_values() {
    for row in TABLE {
        for info in [row.query, row.set].into_iter().flatten() {
            let Some(field) = info.fields.iter().find(|field| !field.optional) else {
                assert!(written(info, &[]).is_ok(), "{}", info.name);
                continue;
            };
            let error = written(info, &[]).unwrap_err();
            assert!(
                error.starts_with(&format!("'{}' is missing: ", field.name)),
                "{error}"
            );
        }
    }
    assert_eq!(
        set("PTPCmd", &[]).unwrap_err(),
        "'ptp_mode' is missing: 0 (JumpXyz), 1 (MovjXyz), 2 (MovlXyz), 3 (JumpAngle), 4 (MovjAngle), 5 (MovlAngle), \
         6 (MovjAngleInc), 7 (MovlXyzInc), 8 (MovjXyzInc), 9 (JumpMovlXyz)"
    );
    assert_eq!(
        set("WAITCmd", &[("timeout", "soon")]).unwrap_err(),
        "'timeout=soon': expected a whole number from 0 to 4294967295 (ms)"
    );
}

#[test]
fn a_list_of_outputs_fills_a_frame_and_no_more() {
    assert_eq!(PoList::CAPACITY, 57);
    // A mode and four numbers come before the list; each output is four bytes.
    assert_eq!(17 + 4 * PoList::CAPACITY, 245);
    const { assert!(17 + 4 * (PoList::CAPACITY + 1) > MAX_PARAMS) };
    let mut bytes = vec![1, 50, 4, 0, 1];
    let read = |bytes: &[u8]| PoList::read(&mut magician_protocol::Reader::new(bytes)).unwrap();
    assert!(read(&bytes).counted(), "a count came first");
    assert!(!read(&bytes.split_off(1)).counted());
}

#[test]
fn a_flag_is_on_or_off_and_says_which_byte_it_is() {
    assert_eq!((Flag::from(true), Flag::from(false)), (Flag::ON, Flag::OFF));
    assert_eq!((Flag::from(true).0, Flag::from(false).0), (1, 0));
    let said = [Flag(0), Flag(1), Flag(7)].map(|flag| format!("{flag:?}"));
    assert_eq!(said, ["off", "on", "on(7)"]);
}

#[test]
fn decode_error_states_byte_count() {
    let said = [
        (DecodeError::UnknownId(77), "unknown command id 77"),
        (
            DecodeError::NoSuchForm(31),
            "command id 31 has no such form",
        ),
        (
            DecodeError::List { found: 6 },
            "6 bytes of output list, expected a multiple of 4, or one more with a count first",
        ),
    ];
    for (error, message) in said {
        assert_eq!(error.to_string(), message);
    }
    assert_eq!(FieldType::Scalar(Scalar::F32), f32::TYPE);
}

#[test]
fn text_fills_a_frame_with_its_nul_and_no_more() {
    assert_eq!(Text::CAPACITY, 247);
    let longest = "x".repeat(247);
    assert_eq!(
        Text::new(&longest).map(|text| text.as_bytes().len()),
        Some(247)
    );
    assert_eq!(Text::new(&"x".repeat(248)), None);
    assert_eq!(Text::new("a\0b"), None);
    assert_eq!(Text::new("Dobot").unwrap().as_str(), Ok("Dobot"));
}

/// Bytes after a field left out would be decoded as that field.
#[test]
fn field_after_an_omitted_field_is_refused() {
    for row in TABLE {
        for info in [row.query, row.set].into_iter().flatten() {
            let left_out =
                |field: &magician_protocol::Field| field.optional && field.default.is_none();
            let Some(at) = info.fields.iter().position(left_out) else {
                continue;
            };
            let text = |field: &magician_protocol::Field| match field.ty {
                FieldType::Array(_, count) => vec!["0"; count].join(","),
                _ => "0".to_owned(),
            };
            let others = info
                .fields
                .iter()
                .enumerate()
                .filter(|(other, _)| *other != at);
            let texts: Vec<_> = others.map(|(_, field)| (field.name, text(field))).collect();
            let arguments: Vec<_> = texts
                .iter()
                .map(|(name, text)| (*name, text.as_str()))
                .collect();
            let outcome = written(info, &arguments);
            assert_eq!(
                outcome.is_ok(),
                at + 1 == info.fields.len(),
                "{}: {outcome:?}",
                info.name
            );
        }
    }
}
