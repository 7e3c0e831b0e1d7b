//! `magician decode` with all golden vectors and streams, by every kind of input.

use std::fs;

use crate::magician::{run, run_with};
use serde_json::{Value, json};

const VECTORS: &str = include_str!("../../../magician-protocol/tests/data/vectors.toml");

fn vectors(kind: &str) -> Vec<toml::Table> {
    let mut data: toml::Table = VECTORS.parse().expect("TOML");
    let Some(toml::Value::Array(items)) = data.remove(kind) else {
        panic!("no {kind}");
    };
    items
        .into_iter()
        .map(|item| item.try_into().expect("table"))
        .collect()
}

fn text<'a>(item: &'a toml::Table, key: &str) -> &'a str {
    item.get(key)
        .and_then(toml::Value::as_str)
        .unwrap_or_default()
}

fn packed(hex: &str) -> String {
    hex.split_whitespace().collect()
}

fn bytes(hex: &str) -> Vec<u8> {
    let pairs = hex.split_whitespace();
    pairs
        .map(|pair| u8::from_str_radix(pair, 16).expect("hex"))
        .collect()
}

/// True if a JSON value equals the value of the vector; floats to the printed digits.
fn same(found: &Value, wanted: &toml::Value) -> bool {
    match wanted {
        toml::Value::Array(items) => {
            let found = found.as_array().map(Vec::as_slice).unwrap_or_default();
            found.len() == items.len() && found.iter().zip(items).all(|(f, w)| same(f, w))
        }
        toml::Value::Table(fields) => fields.iter().all(|(name, value)| same(&found[name], value)),
        toml::Value::Integer(number) => found.as_f64() == Some(*number as f64),
        toml::Value::Float(number) => {
            let found = found.as_f64().unwrap_or(f64::NAN);
            (found - number).abs() <= number.abs() * 2e-7
        }
        toml::Value::String(text) => found.as_str() == Some(text),
        _ => false,
    }
}

#[test]
fn every_vector_is_decoded() {
    let vectors = vectors("vector");
    assert_eq!(vectors.len(), 95);
    for vector in &vectors {
        let (id, hex) = (text(vector, "id"), text(vector, "hex"));
        let from = match text(vector, "direction") {
            "host_to_device" => "host",
            _ => "arm",
        };
        let run = run(&["decode", "--json", "--from", from, hex]);
        if vector["frame_valid"].as_bool() == Some(false) {
            assert_eq!(run.status, 10, "{id}");
            assert_eq!(run.objects()[0]["ok"], false, "{id}");
            assert_eq!(run.error()["kind"], "check-failed", "{id}");
            continue;
        }
        assert_eq!(run.status, 0, "{id}: {run:?}");
        let object = run.object();
        assert_eq!(object["offset"], 0, "{id}");
        assert_eq!(object["hex"], packed(hex), "{id}");
        assert_eq!(object["ok"], true, "{id}");
        assert_eq!(object["id"].as_i64(), vector["cmd_id"].as_integer(), "{id}");
        assert_eq!(object["command"], text(vector, "command"), "{id}");
        let direction = if from == "host" { "request" } else { "reply" };
        assert_eq!(object["direction"], direction, "{id}");
        let decoded = vector["decoded"].as_table().expect("table");
        for (name, value) in decoded.iter().filter(|(name, _)| !name.starts_with('_')) {
            let found = &object["params"][name];
            assert!(same(found, value), "{id} {name}: {found} is not {value}");
        }
        let lenient = text(vector, "semantic") != "ok";
        if lenient {
            assert_ne!(object["notes"], json!([]), "{id}");
        }
    }
}

#[test]
fn detected_direction_matches_unambiguous_vectors() {
    for vector in vectors("vector")
        .iter()
        .filter(|v| v["frame_valid"].as_bool() == Some(true))
    {
        let run = run(&["decode", "--json", text(vector, "hex")]);
        let object = run.object();
        let sent = match text(vector, "direction") {
            "host_to_device" => "request",
            _ => "reply",
        };
        let doubts = object["notes"]
            .as_array()
            .is_some_and(|notes| !notes.is_empty());
        assert!(
            object["direction"] == sent || doubts,
            "{}: {object}",
            text(vector, "id")
        );
    }
}

#[test]
fn every_stream_yields_its_frames() {
    let streams = vectors("stream");
    assert_eq!(streams.len(), 6);
    for stream in &streams {
        let run = run(&["decode", "--json", text(stream, "hex")]);
        let frames: Vec<_> = run.objects();
        let frames: Vec<_> = frames
            .iter()
            .filter(|object| object["ok"] == true)
            .collect();
        let wanted = stream["expect_frames"].as_array().expect("array");
        let wanted: Vec<_> = wanted
            .iter()
            .filter_map(|hex| hex.as_str().map(packed))
            .collect();
        let found: Vec<_> = frames
            .iter()
            .filter_map(|object| object["hex"].as_str())
            .collect();
        assert_eq!(found, wanted, "{}", text(stream, "id"));
    }
}

#[test]
fn arguments_files_and_stdin_say_the_same() {
    let dir = tempfile::tempdir().expect("directory");
    let hex = "AA AA 02 0A 00 F6 AA AA 02 F0 01 0F";
    let (binary, text) = (dir.path().join("bytes.bin"), dir.path().join("hex.txt"));
    fs::write(&binary, bytes(hex)).expect("written");
    fs::write(&text, format!("{}\n", hex.replace(' ', ", "))).expect("written");
    let expected = run(&["decode", "--json", hex]).out;
    assert_eq!(expected.lines().count(), 2);
    let split: Vec<_> = ["decode", "--json"]
        .into_iter()
        .chain(hex.split(' '))
        .collect();
    assert_eq!(run(&split).out, expected);
    for file in [&binary, &text] {
        let run = run(&["decode", "--json", file.to_str().expect("UTF-8")]);
        assert_eq!(run.out, expected, "{file:?}");
    }
    for stdin in [bytes(hex), packed(hex).into_bytes()] {
        assert_eq!(run_with(&["decode", "--json", "-"], &stdin).out, expected);
    }
}

#[test]
fn invalid_bytes_have_an_offset_and_an_error() {
    let input = "4D 31 30 AA AA 02 0A 00 F6 AA AA 01 AA AA 02 0A 00 F5 AA AA 02 FE 00 02 \
                 AA AA 03 54 03 00 A9 AA AA 13 54";
    let run = run(&["decode", "--json", "--from", "host", input]);
    assert_eq!(run.status, 10);
    let told: Vec<_> = run
        .objects()
        .iter()
        .map(|object| {
            (
                object["offset"].as_u64(),
                object["ok"].clone(),
                object["error"].clone(),
            )
        })
        .collect();
    let wanted = [
        (0, false, json!("noise")),
        (3, true, Value::Null),
        (9, false, json!("length")),
        (12, false, json!("checksum")),
        (18, false, json!("unknown")),
        (24, false, json!("length")),
        (31, false, json!("truncated")),
    ];
    let wanted: Vec<_> = wanted
        .into_iter()
        .map(|(o, ok, e)| (Some(o), json!(ok), e))
        .collect();
    assert_eq!(told, wanted);
    let unknown = &run.objects()[4];
    assert_eq!(unknown["command"], Value::Null);
    assert_eq!(unknown["params"], json!({"raw": ""}));
}

#[test]
fn an_unknown_id_keeps_its_bytes() {
    let object = run(&["decode", "--json", "AA AA 04 FE 00 12 34 BC"]).object();
    let wanted = json!({
        "offset": 0, "hex": "AAAA04FE001234BC", "ok": false, "id": 254, "command": null,
        "write": false, "queued": false, "params": {"raw": "1234"}, "error": "unknown",
    });
    assert_eq!(object, wanted);
}

#[test]
fn run_of_noise_is_one_object_of_any_length() {
    let mut input = vec![0x55; 300_000];
    input.extend(bytes("AA AA 02 0A 00 F6"));
    let run = run_with(&["decode", "--json", "-"], &input);
    assert_eq!(run.status, 10);
    let objects = run.objects();
    assert_eq!(objects.len(), 2);
    assert_eq!(objects[0]["error"], "noise");
    assert_eq!(objects[0]["hex"].as_str().map(str::len), Some(600_000));
    assert_eq!(objects[1]["offset"], 300_000);
}

#[test]
fn empty_input_is_no_failure() {
    let run = run_with(&["decode", "-"], b"");
    assert_eq!(
        (run.status, run.out.as_str(), run.err.as_str()),
        (0, "", "")
    );
}

#[test]
fn neither_hex_nor_file_is_invalid_input() {
    for arguments in [
        &["decode", "--json", "no such file"][..],
        &["decode", "--json", "AA", "zz"],
    ] {
        let run = run(arguments);
        assert_eq!(run.status, 3);
        assert_eq!(run.error()["kind"], "invalid-input");
    }
}

#[test]
fn text_output_has_names_units_and_enum_names() {
    let run = run(&[
        "decode",
        "AA AA 13 54 03 01 00 00 7A 43 00 00 00 00 00 00 00 00 00 00 00 00 EB",
    ]);
    assert_eq!(run.status, 0);
    for part in [
        "request  SetPTPCmd  queued",
        "1 (MovjXyz)",
        "x         250 (mm, or deg for J1)",
    ] {
        assert!(run.out.contains(part), "{part} in\n{}", run.out);
    }
    assert!(!run.out.contains('\x1b'), "no colours without a terminal");
}
