//! Compares the command table with `commands.toml`, and checks rules within the table.

use std::collections::BTreeMap;

use magician_protocol::{
    Confidence, Ctrl, Effect, Field, FieldType, LayoutInfo, NameError, Row, Scalar, Source, TABLE,
};
use toml::{Table, Value};

/// Commands of the Magician in `commands.toml`, by id.
fn documented() -> BTreeMap<u8, Table> {
    let table: Table = toml::from_str(include_str!("../data/commands.toml")).unwrap();
    let commands = table["command"].as_array().unwrap().iter();
    let magician = commands.filter(|c| c["device_family"].as_str() == Some("Magician"));
    magician
        .map(|c| {
            (
                c["id"].as_integer().unwrap() as u8,
                c.as_table().unwrap().clone(),
            )
        })
        .collect()
}

#[test]
fn rows_are_those_of_the_magician() {
    assert_eq!(TABLE.len(), 90);
    assert!(TABLE.is_sorted_by(|a, b| a.id < b.id));
    let ids: Vec<u8> = TABLE.iter().map(|row| row.id).collect();
    assert!(ids.iter().eq(documented().keys()));
    let count = |source| TABLE.iter().filter(|row| row.source == source).count();
    assert_eq!(count(Source::Document), 70);
    assert_eq!(count(Source::Addition), 4);
    assert_eq!(count(Source::Header), 16);
}

#[test]
fn rows_match_commands_toml() {
    for (row, command) in TABLE.iter().zip(documented().values()) {
        let text = |key: &str| command[key].as_str().unwrap();
        assert_eq!(row.name, text("name"));
        assert_eq!(row.section, text("section"), "{}", row.name);
        let access = match (row.value, row.set) {
            (Some(_), Some(_)) => "both",
            (Some(_), None) => "get",
            (None, _) => "set",
        };
        assert_eq!(access, text("access"), "{}", row.name);
        // For a get-only command `commands.toml` has the text "always immediate" here, not a flag.
        let queueable = command["queueable"].as_bool().unwrap_or(false);
        assert_eq!(row.queueable, queueable, "{}", row.name);
        let source = match row.source {
            Source::Document => "v1.1.3",
            Source::Addition => "v1.1.5-addition",
            Source::Header => "vendor header only",
        };
        assert_eq!(source, text("source"), "{}", row.name);
        let confidence = match row.confidence {
            Confidence::High => "high",
            Confidence::Medium => "medium",
            Confidence::Low => "low",
        };
        assert_eq!(confidence, text("confidence"), "{}", row.name);
    }
}

#[test]
fn layouts_match_commands_toml() {
    for (row, command) in TABLE.iter().zip(documented().values()) {
        if let Some(get) = command.get("get") {
            assert_eq!(row.get_name, get["name"].as_str().unwrap());
            assert_eq!(
                table_fields(row.query),
                documented_fields(row, "query", &get["request"])
            );
            assert_eq!(
                table_fields(row.value),
                documented_fields(row, "value", &get["response"])
            );
        }
        if let Some(set) = command.get("set") {
            assert_eq!(row.set_name, set["name"].as_str().unwrap());
            assert_eq!(
                table_fields(row.set),
                documented_fields(row, "set", &set["request"])
            );
            assert_eq!(row.queueable, set["returns_queue_index"].as_bool().unwrap());
        }
    }
}

/// Intended differences between the table and `commands.toml`.
const DIFFERENCES: &[(u8, &str, &str)] = &[
    // E20: one type covers both the Magician's 16 bytes and the rule "accept any length".
    (20, "value", "alarms_state alarms"),
    // E23: the document itself allows hosts to leave the angles out.
    (
        11,
        "set",
        "manual u8, rear_arm_angle f32?, front_arm_angle f32?",
    ),
    // For ids 161 and 191 model section 15a takes precedence over commands.toml.
    (161, "value", "mode u8, ctl u8?"),
    (161, "set", "mode u8, ctl u8?"),
    (
        191,
        "value",
        "j1 f32, j2 f32, j3 f32, j4 f32, e1 f32, e2 f32",
    ),
    (191, "set", "j1 f32, j2 f32, j3 f32, j4 f32, e1 f32, e2 f32"),
];

fn documented_fields(row: &Row, form: &str, list: &Value) -> String {
    if let Some((.., text)) = DIFFERENCES
        .iter()
        .find(|(id, name, _)| (*id, *name) == (row.id, form))
    {
        return (*text).into();
    }
    let field = |field: &Value| {
        let ty = match field["type"].as_str().unwrap() {
            "char[n]" => "text",
            "u8[0..]" => "bytes",
            "PoCmd[n]" => "outputs",
            other => other,
        };
        let optional = field.get("optional").is_some_and(|o| o.as_bool().unwrap());
        let mark = if optional { "?" } else { "" };
        format!("{} {ty}{mark}", field["name"].as_str().unwrap())
    };
    let list: Vec<_> = list.as_array().unwrap().iter().map(field).collect();
    list.join(", ")
}

fn table_fields(info: Option<&LayoutInfo>) -> String {
    let field = |field: &Field| {
        let mark = if field.optional { "?" } else { "" };
        format!("{} {}{mark}", field.name, type_name(field.ty))
    };
    let list: Vec<_> = info.unwrap().fields.iter().map(field).collect();
    list.join(", ")
}

fn type_name(ty: FieldType) -> String {
    match ty {
        FieldType::Scalar(scalar) => scalar_name(scalar).into(),
        FieldType::Array(scalar, count) => format!("[{};{count}]", scalar_name(scalar)),
        FieldType::Flag | FieldType::Enum(_) => "u8".into(),
        FieldType::Text => "text".into(),
        FieldType::Bytes => "bytes".into(),
        FieldType::Alarms => "alarms".into(),
        FieldType::Outputs => "outputs".into(),
    }
}

fn scalar_name(scalar: Scalar) -> &'static str {
    match scalar {
        Scalar::U8 => "u8",
        Scalar::U16 => "u16",
        Scalar::U32 => "u32",
        Scalar::U64 => "u64",
        Scalar::I32 => "i32",
        Scalar::F32 => "f32",
    }
}

fn layouts(row: &Row) -> impl Iterator<Item = &'static LayoutInfo> {
    [row.query, row.value, row.set].into_iter().flatten()
}

#[test]
fn every_row_field_and_enum_value_is_documented() {
    let sentence = |text: &str| {
        text.starts_with(|c: char| c.is_uppercase() || c.is_ascii_digit()) && text.ends_with('.')
    };
    for row in TABLE {
        assert!(sentence(row.doc), "{}: {}", row.name, row.doc);
        for info in layouts(row) {
            for field in info.fields {
                let place = format!("{} {}", info.name, field.name);
                assert!(!field.unit.is_empty(), "{place}: no unit");
                assert!(sentence(field.doc), "{place}: {}", field.doc);
                let snake = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_';
                assert!(field.name.chars().all(snake), "{place}");
                if let FieldType::Enum(info) = field.ty {
                    assert!(info.variants.iter().all(|v| sentence(v.doc)), "{place}");
                }
            }
        }
    }
}

#[test]
fn only_last_field_is_open_ended_and_omittable_fields_come_last() {
    for row in TABLE {
        for info in layouts(row) {
            let name = info.name;
            let sizes: Vec<_> = info.fields.iter().map(|field| field.ty.size()).collect();
            let open = sizes.iter().position(Option::is_none);
            assert!(open.is_none_or(|at| at + 1 == sizes.len()), "{name}: open");
            let omittable = info.fields.iter().map(|field| field.omittable);
            assert!(
                omittable.is_sorted(),
                "{name}: an omittable field in the middle"
            );
            for form in info.forms {
                assert_ne!(Some(form.len), info.size(), "{name}: {}", form.note);
                assert!(form.note.contains("(E") || row.id == 191, "{name}");
            }
            assert!(info.size().unwrap_or(0) <= 248, "{name}: too long");
        }
    }
}

#[test]
fn only_speeds_are_signed() {
    // `describe` treats every signed number as a stepper's speed (E41).
    let speeds = TABLE.iter().flat_map(layouts).flat_map(|info| info.fields);
    let signed = speeds.filter(|field| field.ty == FieldType::Scalar(Scalar::I32));
    assert!(signed.map(|field| field.name).eq(["speed", "speed"]));
}

fn normalised(name: &str) -> String {
    name.replace(['-', '_'], "").to_lowercase()
}

#[test]
fn names_are_unique_except_clear_all_alarms_state() {
    let mut owners: BTreeMap<String, Vec<u8>> = BTreeMap::new();
    for row in TABLE {
        let mut names = vec![normalised(row.name)];
        names.extend(row.value.map(|_| normalised(row.get_name)));
        names.extend(row.set.map(|_| normalised(row.set_name)));
        names.extend(layouts(row).map(|info| normalised(info.name)));
        names.retain(|name| name != "noargs");
        names.sort();
        names.dedup();
        for name in names {
            owners.entry(name).or_default().push(row.id);
        }
    }
    owners.retain(|_, ids| ids.len() > 1);
    let shared = [("clearallalarmsstate".to_owned(), vec![20, 21])];
    assert_eq!(owners, BTreeMap::from(shared));
}

#[test]
fn rows_are_found_by_any_of_their_names() {
    for row in TABLE {
        let mut names = vec![row.id.to_string(), format!("{:#04x}", row.id)];
        if row.id != 21 {
            names.push(row.name.into());
            names.push(row.name.to_lowercase());
            names.push(format!("Set{}", row.name));
        }
        if row.value.is_some() {
            names.push(row.get_name.to_uppercase());
            names.push(format!("get-{}", row.name));
        }
        if row.set.is_some() && row.id != 21 {
            names.push(row.set_name.into());
            names.push(format!("set_{}", row.name));
        }
        names.extend(layouts(row).map(|info| info.name.to_owned()));
        names.retain(|name| name != "NoArgs" && (row.set.is_some() || !name.starts_with("Set")));
        if row.id == 21 {
            names.retain(|name| name != "ClearAllAlarmsState");
        }
        for name in names {
            let found = Row::find(&name).map(|found| found.id);
            assert_eq!(found, Ok(row.id), "{name}");
        }
    }
}

#[test]
fn clearing_alarms_is_id_20() {
    // E19: hosts send 20 with rw = 1.
    let id = |row: Result<&Row, NameError>| row.map(|row| row.id);
    assert_eq!(id(Row::find_writable("ClearAllAlarmsState")), Ok(20));
    assert_eq!(id(Row::find("clear-all-alarms-state")), Ok(20));
    assert_eq!(id(Row::find_writable("20")), Ok(20));
    assert_eq!(id(Row::find_writable("21")), Ok(21));
    assert_eq!(id(Row::find_readable("AlarmsState")), Ok(20));
}

#[test]
fn unknown_names_are_refused() {
    for name in [
        "",
        "Get",
        "Set",
        "GetPTPCmd",
        "SetPose",
        "7",
        "256",
        "+10",
        "0x",
        "-1",
        "NoArg",
    ] {
        assert_eq!(
            Row::find(name).map(|row| row.name),
            Err(NameError),
            "{name}"
        );
    }
    assert!(Row::find_readable("PTPCmd").is_err());
    assert!(Row::find_writable("Pose").is_err());
    assert_eq!(Row::find("ptp-joint-params").unwrap().id, 80);
    assert_eq!(Row::find("PTPJointParams").unwrap().id, 80);
}

#[test]
fn dangerous_commands_are_listed_and_explained() {
    let dangerous: Vec<u8> = TABLE.iter().filter(|r| r.dangerous).map(|r| r.id).collect();
    assert_eq!(
        dangerous,
        [
            0, 11, 140, 141, 142, 150, 151, 152, 153, 154, 155, 156, 160, 161, 230, 243
        ]
    );
    for row in TABLE {
        assert_eq!(row.danger().is_some(), row.dangerous, "{}", row.name);
    }
    // A command that moves the arm, waits for an input or checks for lost steps must not run
    // twice.
    for row in TABLE.iter().filter(|row| row.name.ends_with("Cmd")) {
        assert!(!row.resendable || row.name == "WAITCmd", "{}", row.name);
    }
    assert!(TABLE.iter().all(|row| row.set.is_some() || row.resendable));
}

/// The effect agrees with the forms of a row and with its other columns.
#[test]
fn effects_agree_with_the_rest_of_the_row() {
    for row in TABLE {
        let (name, effect) = (row.name, row.effect);
        let reads = matches!(effect, Effect::Look | Effect::Consume);
        assert_eq!(reads, row.set.is_none(), "{name}");
        assert!(!effect.moves() || !row.resendable, "{name}");
        assert!(
            effect != Effect::Store || row.dangerous || row.name == "DeviceName",
            "{name}"
        );
        assert!(!row.may_burn || row.queueable, "{name}");
        assert_eq!(row.steers_queue(), (240..=245).contains(&row.id), "{name}");
        let acts = ["Cmd", "Motor", "MotorS"]
            .iter()
            .any(|end| row.name.ends_with(end));
        assert!(
            effect != Effect::Setting || !acts || row.name == "LostStepCmd",
            "{name}"
        );
    }
    let of = |effect| -> Vec<u8> {
        let rows = TABLE.iter().filter(|row| row.effect == effect);
        rows.map(|row| row.id).collect()
    };
    assert_eq!(
        of(Effect::Motion),
        [31, 32, 84, 86, 88, 89, 91, 92, 101, 102, 230]
    );
    assert_eq!(of(Effect::Jog), [73]);
    assert_eq!(of(Effect::Motor), [135, 136]);
    assert_eq!(of(Effect::Laser), [61]);
    assert_eq!(of(Effect::Wait), [110, 120]);
    assert_eq!(of(Effect::Queue), [20, 21, 240, 241, 242, 243, 244, 245]);
    assert_eq!(of(Effect::Consume), [42]);
}

/// A plain read can be shared by several hosts. A read of the hand-teaching trigger may clear what
/// it reports (errata, open question 11).
#[test]
fn all_gets_but_teach_trigger_are_plain_reads() {
    for row in TABLE {
        let readable = row.value.is_some();
        let looks = readable && row.id != 42;
        assert_eq!(row.only_looks(Ctrl::GET), looks, "{}", row.name);
        assert_eq!(
            row.only_looks(Ctrl::SET),
            looks && row.set.is_none(),
            "{}",
            row.name
        );
    }
    let elsewhere = Ctrl(Ctrl::GET.0 | 1 << 4);
    assert_ne!(elsewhere.destination(), 0);
    let pose = Row::with_id(10).unwrap();
    assert!(pose.only_looks(Ctrl::GET) && !pose.only_looks(elsewhere));
}
