//! Pins, sensors and steppers, described from the protocol's table, so that a page needs no
//! knowledge of commands.

use magician::commands::{GetIoDo, GetIoMultiplexing, GetIoPwm, IoDo, IoMultiplexing, IoPwm};
use magician::{Arm, build};
use magician_protocol::{
    Chapter, Effect, Field, FieldType, IoFunction, LayoutInfo, Port, Row, TABLE, Writable,
};
use serde_json::{Value, json};

use crate::api::RpcError;
use crate::reading::short;

// EIO addresses of the Magician are 1 to 20.
const PINS: u8 = 20;

/// Returns the role of a command on the I/O page, derived from its row. `None` if it has no role.
fn role(row: &Row) -> Option<&'static str> {
    let sets_port = |layout: &LayoutInfo| {
        let is_port = |field: &Field| field.ty == FieldType::Enum(Port::INFO);
        layout.fields.iter().any(is_port)
    };
    match row.id {
        id if id == <IoMultiplexing as Writable>::ROW.id => Some("function"),
        id if id == <IoDo as Writable>::ROW.id => Some("output"),
        id if id == <IoPwm as Writable>::ROW.id => Some("signal"),
        // By effect, not by id, so that a new motor command is included automatically.
        _ if row.effect == Effect::Motor => Some("stepper"),
        _ if row.chapter == Chapter::Io && row.set.is_some_and(sets_port) => Some("sensor"),
        _ => None,
    }
}

/// Returns descriptions of pins, sensors and steppers, and the current levels of outputs.
pub(super) async fn io(arm: &Arm) -> Result<Value, RpcError> {
    let mut pins = Vec::new();
    for number in 1..=PINS {
        let address = Some(number);
        let asked = GetIoMultiplexing { address };
        let function = arm.get_with::<IoMultiplexing>(&asked).await?.multiplex;
        let mut pin = json!({
            "address": address,
            "function": u8::from(function),
            "can": abilities(arm, number),
            "level": null,
            "frequency": null,
            "duty_cycle": null,
        });
        match function {
            IoFunction::DigitalOutput => {
                let output = arm.get_with::<IoDo>(&GetIoDo { address }).await?;
                pin["level"] = json!(u8::from(output.level.is_on()));
            }
            IoFunction::Pwm => {
                let signal = arm.get_with::<IoPwm>(&GetIoPwm { address }).await?;
                pin["frequency"] = json!(signal.frequency);
                pin["duty_cycle"] = json!(signal.duty_cycle);
            }
            // Inputs are not read here: a subscription watches them.
            _ => {}
        }
        pins.push(pin);
    }
    let rows = TABLE.iter().filter_map(|row| {
        // Rows without a role on the page are skipped.
        Some(json!({
            "role": role(row)?,
            "command": row.name,
            "about": row.doc,
            "asks": row.query.map(fields),
            "tells": row.value.map(fields),
            "sets": row.set.map(fields),
        }))
    });
    let functions = IoFunction::INFO.variants.iter().map(|function| {
        json!({
            "value": function.value,
            "name": function.name,
            "about": function.doc.trim_end_matches('.'),
            "watch": watch(IoFunction::from(function.value)),
        })
    });
    Ok(json!({
        "analog": {"counts": build::ANALOG_COUNTS, "volts": short(build::ANALOG_VOLTS)},
        "functions": functions.collect::<Vec<_>>(),
        "pins": pins,
        "rows": rows.collect::<Vec<_>>(),
    }))
}

/// Returns the name under which a subscription watches a pin with this function. `None` if the
/// function has no level.
fn watch(function: IoFunction) -> Option<&'static str> {
    match function {
        IoFunction::DigitalOutput => Some("output"),
        IoFunction::DigitalInput
        | IoFunction::DigitalInputPullUp
        | IoFunction::DigitalInputPullDown => Some("input"),
        IoFunction::AnalogInput => Some("analog"),
        _ => None,
    }
}

fn fields(layout: &LayoutInfo) -> Vec<Value> {
    layout.fields.iter().map(field).collect()
}

fn field(field: &Field) -> Value {
    let bounds = field.range.bounds();
    let (kind, choices) = match field.ty {
        FieldType::Flag => ("switch", Vec::new()),
        FieldType::Enum(info) => {
            let named = info.variants.iter().map(|variant| {
                json!({"value": variant.value, "name": variant.doc.trim_end_matches('.')})
            });
            ("choice", named.collect())
        }
        // Every other type of the protocol is a number.
        _ => ("number", Vec::new()),
    };
    json!({
        "name": field.name,
        "about": field.doc.trim_end_matches('.'),
        "unit": field.unit,
        "kind": kind,
        "least": bounds.minimum,
        "most": bounds.maximum,
        "choices": choices,
    })
}

/// Returns the functions that the connector of a pin supports. `None` if unknown.
#[cfg(feature = "sim")]
fn abilities(_: &Arm, address: u8) -> Option<Vec<u8>> {
    // The virtual arm models the connectors of the real one.
    let profile = magician::sim::Profile::default();
    let pin = profile.io.pins.get(usize::from(address).checked_sub(1)?)?;
    let functions = IoFunction::INFO.variants.iter();
    let able = functions.filter(|function| match IoFunction::from(function.value) {
        IoFunction::None => true,
        IoFunction::DigitalOutput => pin.digital_output,
        IoFunction::Pwm => pin.pwm,
        IoFunction::AnalogInput => pin.analog_input,
        IoFunction::DigitalInput
        | IoFunction::DigitalInputPullUp
        | IoFunction::DigitalInputPullDown => pin.digital_input,
        IoFunction::Unknown(_) => false,
    });
    Some(able.map(|function| function.value).collect())
}

#[cfg(not(feature = "sim"))]
fn abilities(_: &Arm, _: u8) -> Option<Vec<u8>> {
    None
}
