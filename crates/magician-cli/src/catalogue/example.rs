//! Example command lines for a command of the protocol, made from its row.

use magician_protocol::{Field, FieldType, LayoutInfo, Range, Row, Scalar};

/// Returns command lines that use this command, ready to be copied.
pub(super) fn lines(row: &Row) -> Vec<String> {
    let mut lines = Vec::new();
    if row.value.is_some() {
        let query = row.query.map(arguments).unwrap_or_default();
        lines.push(format!("magician get {}{query}", row.name));
    }
    if let Some(set) = row.set {
        let yes = if row.dangerous { " --yes" } else { "" };
        let values = arguments(set);
        lines.push(format!("magician set {}{values}{yes}", row.name));
        if row.queueable {
            lines.push(format!("magician enqueue {}{values}{yes}", row.name));
        }
    }
    lines
}

fn arguments(info: &LayoutInfo) -> String {
    let given = info.fields.iter().filter(|field| !field.optional);
    given
        .map(|field| format!(" {}={}", field.name, value(field)))
        .collect()
}

/// Returns a plausible value of a field, in the notation that the command line parses.
fn value(field: &Field) -> String {
    match field.ty {
        FieldType::Scalar(scalar) => number(field, scalar),
        FieldType::Array(scalar, count) => vec![number(field, scalar); count].join(","),
        FieldType::Flag => "1".to_owned(),
        // 0 ends a jog. The raw verbs refuse any other value, since nothing would hold the jog.
        FieldType::Enum(info) if info.name == "JogCommand" => "0".to_owned(),
        FieldType::Enum(info) => {
            let variant = info.variants.get(1).or(info.variants.first());
            variant.map_or(0, |variant| variant.value).to_string()
        }
        FieldType::Text => "Magician".to_owned(),
        FieldType::Bytes => "00FF".to_owned(),
        FieldType::Alarms => "0".to_owned(),
        FieldType::Outputs => "50:4:1,75:5:0".to_owned(),
        #[cfg(not(magician_workspace))]
        _ => unreachable!(),
    }
}

fn number(field: &Field, scalar: Scalar) -> String {
    let value = match (field.name, field.unit) {
        ("x", _) => 200,
        ("z", _) => 20,
        (_, "percent") => 50,
        (_, "EIO address") => 4,
        (_, "ms") => 500,
        (_, "Hz") => 1000,
        ("to_point", _) => 200,
        _ if matches!(field.range, Range::Above(_)) => 100,
        _ if scalar == Scalar::I32 => 10_000,
        _ => 0,
    };
    value.to_string()
}

#[cfg(test)]
mod tests {
    use super::*;
    use magician_protocol::{Layout, MAX_PARAMS, NoArgs, TABLE, Writer, encode_text};

    #[test]
    fn every_example_is_accepted() {
        for row in TABLE {
            for line in lines(row) {
                let words: Vec<_> = line.split(' ').collect();
                let layout = match words[1] {
                    "get" => row.query,
                    _ => row.set,
                };
                let pairs: Vec<_> = words[3..]
                    .iter()
                    .filter_map(|word| word.split_once('='))
                    .collect();
                let mut params = [0; MAX_PARAMS];
                let mut writer = Writer::new(&mut params);
                let encoded = encode_text(layout.unwrap_or(NoArgs::INFO), &pairs, &mut writer);
                assert_eq!(encoded, Ok(()), "{line}");
            }
        }
    }
}
