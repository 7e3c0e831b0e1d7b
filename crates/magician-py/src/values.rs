//! Conversion of commands between Python objects and wire format.
//!
//! A command is an object of a class in `magician.commands`; there is one class per layout of the
//! protocol's table. `ID` and `LAYOUT` of the class identify the layout. Its attributes are the
//! fields: `int`, `float`, `bool`, `str`, `bytes`, tuples of numbers, enums, codes of alarms, and
//! outputs. A 32-bit float is returned as the shortest decimal with the same bits, so that a
//! program reads back exactly the number that it has set.

use magician::Set;
use magician_protocol::{
    AlarmSet, EnumInfo, Field, FieldType, FieldValue, Layout as _, LayoutInfo, MAX_PARAMS, PoCmd,
    PoList, Row, Scalar, Text, Wire, Writer,
};
use pyo3::exceptions::{PyAttributeError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyBool, PyBytes, PyModule, PyTuple};

use crate::errors;

/// Row and layout of a command class.
pub(crate) struct Kind {
    pub(crate) row: &'static Row,
    pub(crate) layout: &'static LayoutInfo,
}

/// Looks up row and layout of a command or command class.
///
/// # Errors
/// `TypeError` for any other object.
pub(crate) fn kind(command: &Bound<'_, PyAny>) -> PyResult<Kind> {
    let py = command.py();
    let attribute = |name| command.getattr(name);
    let read = || -> PyResult<Option<Kind>> {
        let id = attribute(pyo3::intern!(py, "ID"))?.extract::<u8>()?;
        let name = attribute(pyo3::intern!(py, "LAYOUT"))?;
        let name = name.extract::<std::borrow::Cow<'_, str>>()?;
        let row = Row::with_id(id);
        Ok(row.and_then(|row| {
            let layouts = [row.set, row.value, row.query].into_iter().flatten();
            let layout = layouts.into_iter().find(|layout| layout.name == name)?;
            Some(Kind { row, layout })
        }))
    };
    match read() {
        Ok(Some(kind)) => Ok(kind),
        Ok(None) | Err(_) => {
            let what = command.repr()?;
            let message = format!("{what} is not a command of magician.commands");
            Err(PyTypeError::new_err(message))
        }
    }
}

/// Converts an object to a command that can be set or queued.
///
/// # Errors
/// `TypeError` if it is not a command or has fields of the wrong type;
/// `magician.errors.InvalidInputError` for a read-only command and for values out of range.
pub(crate) fn command(object: &Bound<'_, PyAny>) -> PyResult<Set> {
    let py = object.py();
    let Kind { row, layout } = kind(object)?;
    if row.set != Some(layout) {
        return Err(errors::invalid(
            py,
            layout.name,
            "it cannot be set, only read",
        ));
    }
    let params = encode(row, layout, object)?;
    Set::decode(row.id, &params).map_err(|error| errors::raise(py, &error.into()))
}

/// Converts a command to an object of `magician.commands`.
///
/// # Errors
/// Those of its constructor, which are not expected.
pub(crate) fn object(py: Python<'_>, command: &Set) -> PyResult<Py<PyAny>> {
    let row = command.row();
    let layout = row.set.unwrap_or(magician_protocol::NoArgs::INFO);
    let frame = magician::FrameBuf::set(command, magician::Ctrl::SET);
    let frame = frame.map_err(|error| errors::raise(py, &error.into()))?;
    let class = commands(py)?.getattr(layout.name)?;
    decode(&class, layout, frame.frame().params())
}

/// Returns the module `magician.commands`, imported once.
fn commands(py: Python<'_>) -> PyResult<&Bound<'_, PyModule>> {
    static COMMANDS: PyOnceLock<Py<PyModule>> = PyOnceLock::new();
    let module =
        COMMANDS.get_or_try_init(py, || py.import("magician.commands").map(Bound::unbind))?;
    Ok(module.bind(py))
}

/// Encodes the fields of an object as parameters.
///
/// # Errors
/// Those of [`command`].
pub(crate) fn encode(
    row: &Row,
    layout: &LayoutInfo,
    object: &Bound<'_, PyAny>,
) -> PyResult<Vec<u8>> {
    let py = object.py();
    let mut params = [0; MAX_PARAMS];
    let mut writer = Writer::new(&mut params);
    for field in layout.fields {
        let value = object.getattr(field.name)?;
        // Optional fields come last, so nothing can follow an omitted one.
        if value.is_none() && field.optional {
            break;
        }
        write_value(field, &value, &mut writer)
            .map_err(|error| with_field_name(py, row, field, &error))?;
    }
    let count = writer.finish();
    let count = count.map_err(|error| errors::invalid(py, layout.name, error.to_string()))?;
    Ok(params.get(..count).unwrap_or_default().to_vec())
}

/// Puts the name of the field before an error. A `TypeError` stays one; any other becomes an
/// invalid value.
fn with_field_name(py: Python<'_>, row: &Row, field: &Field, error: &PyErr) -> PyErr {
    let message = format!("{}: {}", field.name, error.value(py));
    if error.is_instance_of::<PyTypeError>(py) || error.is_instance_of::<PyAttributeError>(py) {
        PyTypeError::new_err(format!("{}.{message}", row.name))
    } else {
        errors::invalid(py, row.name, message)
    }
}

fn write_value(field: &Field, value: &Bound<'_, PyAny>, writer: &mut Writer<'_>) -> PyResult<()> {
    match field.ty {
        FieldType::Scalar(kind) => scalar(kind, value, writer)?,
        FieldType::Flag | FieldType::Enum(_) => {
            writer.put(&[whole(value, 0, u8::MAX.into())? as u8])
        }
        FieldType::Array(kind, count) => {
            let items: Vec<Bound<'_, PyAny>> = value.extract()?;
            if items.len() != count {
                let message = format!("{} values, not {count}", items.len());
                return Err(PyValueError::new_err(message));
            }
            for item in &items {
                scalar(kind, item, writer)?;
            }
        }
        FieldType::Text => {
            let text: String = value.extract()?;
            let text = Text::new(&text);
            let text =
                text.ok_or_else(|| PyValueError::new_err("text too long, or with a NUL in it"))?;
            text.write(writer);
        }
        FieldType::Bytes => writer.put(&value.extract::<Vec<u8>>()?),
        FieldType::Alarms => {
            let mut alarms = AlarmSet::default();
            for code in value.try_iter()? {
                alarms.insert(whole(&code?, 0, u8::MAX.into())? as u8);
            }
            alarms.write(writer);
        }
        FieldType::Outputs => outputs(value)?.write(writer),
        #[cfg(not(magician_workspace))]
        _ => unreachable!(),
    }
    Ok(())
}

fn outputs(value: &Bound<'_, PyAny>) -> PyResult<PoList> {
    let mut outputs = Vec::new();
    for output in value.try_iter()? {
        let (ratio, address, level) =
            output?.extract::<(Bound<'_, _>, Bound<'_, _>, Bound<'_, _>)>()?;
        outputs.push(PoCmd {
            ratio: whole(&ratio, 0, u8::MAX.into())? as u8,
            address: whole(&address, 0, u16::MAX.into())? as u16,
            level: whole(&level, 0, u8::MAX.into())? as u8,
        });
    }
    PoList::new(&outputs).ok_or_else(|| {
        let (count, most) = (outputs.len(), PoList::CAPACITY);
        PyValueError::new_err(format!("{count} outputs, at most {most} fit"))
    })
}

fn scalar(kind: Scalar, value: &Bound<'_, PyAny>, writer: &mut Writer<'_>) -> PyResult<()> {
    if value.is_instance_of::<PyBool>() {
        let message = format!("a number, not {}", value.repr()?);
        return Err(PyTypeError::new_err(message));
    }
    match kind {
        Scalar::U8 => writer.put(&[whole(value, 0, u8::MAX.into())? as u8]),
        Scalar::U16 => writer.put(&(whole(value, 0, u16::MAX.into())? as u16).to_le_bytes()),
        Scalar::U32 => writer.put(&(whole(value, 0, u32::MAX.into())? as u32).to_le_bytes()),
        Scalar::U64 => writer.put(&(whole(value, 0, u64::MAX.into())? as u64).to_le_bytes()),
        Scalar::I32 => {
            let number = whole(value, i32::MIN.into(), i32::MAX.into())?;
            writer.put(&(number as i32).to_le_bytes());
        }
        Scalar::F32 => writer.put(&float(value)?.to_le_bytes()),
        #[cfg(not(magician_workspace))]
        _ => unreachable!(),
    }
    Ok(())
}

/// Converts an integer, checked against its inclusive bounds.
fn whole(value: &Bound<'_, PyAny>, least: i128, most: i128) -> PyResult<i128> {
    let number = match value.extract::<i64>() {
        Ok(number) => i128::from(number),
        Err(error) if error.is_instance_of::<PyTypeError>(value.py()) => return Err(error),
        // A number that fits neither type is out of range for every field.
        Err(_) => value.extract::<u64>().map_or(most + 1, i128::from),
    };
    if (least..=most).contains(&number) {
        Ok(number)
    } else {
        Err(PyValueError::new_err(format!(
            "{value} is not from {least} to {most}"
        )))
    }
}

/// Converts a number to 32 bits. Fails for a finite number that would become infinite.
fn float(value: &Bound<'_, PyAny>) -> PyResult<f32> {
    let number = value.extract::<f64>()?;
    let narrow = number as f32;
    if narrow.is_infinite() && number.is_finite() {
        Err(PyValueError::new_err(format!(
            "{number:e} is beyond the arm's largest number, {:e}",
            f32::MAX
        )))
    } else {
        Ok(narrow)
    }
}

/// Decodes parameters as an object of `class`. Omitted optional fields get the default of the
/// class.
///
/// # Errors
/// `magician.errors.UnexpectedError` if the parameters do not fit the layout.
pub(crate) fn decode(
    class: &Bound<'_, PyAny>,
    layout: &'static LayoutInfo,
    params: &[u8],
) -> PyResult<Py<PyAny>> {
    let py = class.py();
    let fields = layout.values(params);
    let fields = fields.map_err(|error| {
        let error = magician::Error::from(error).with_command(layout.name);
        errors::raise(py, &error)
    })?;
    let mut values = Vec::with_capacity(layout.fields.len());
    for (_, value) in fields {
        values.push(take(py, &value)?);
    }
    // Omit optional fields, so that the class's own defaults apply.
    let missing = layout.fields.iter().skip(values.len());
    values.extend(missing.filter(|field| !field.optional).map(|_| py.None()));
    Ok(class.call1(PyTuple::new(py, values)?)?.unbind())
}

/// Converts the value of a field.
pub(crate) fn take(py: Python<'_>, value: &FieldValue<'_>) -> PyResult<Py<PyAny>> {
    Ok(match value {
        FieldValue::Unsigned(number) => number.into_pyobject(py)?.into_any().unbind(),
        FieldValue::Signed(number) => number.into_pyobject(py)?.into_any().unbind(),
        FieldValue::Float(number) => shortest(*number).into_pyobject(py)?.into_any().unbind(),
        FieldValue::Flag(byte) => (*byte != 0)
            .into_pyobject(py)?
            .to_owned()
            .into_any()
            .unbind(),
        FieldValue::Enum(info, byte) => named_value(py, info, *byte)?,
        FieldValue::Text(bytes) => {
            let text = String::from_utf8_lossy(bytes);
            text.into_pyobject(py)?.into_any().unbind()
        }
        FieldValue::Bytes(bytes) => PyBytes::new(py, bytes).into_any().unbind(),
        FieldValue::Alarms(alarms) => self::alarms(py, alarms)?,
        FieldValue::Outputs(list) => {
            let class = commands(py)?.getattr("Output")?;
            let outputs = list.as_slice().iter();
            let outputs = outputs
                .map(|output| class.call1((output.ratio, output.address, output.level != 0)));
            PyTuple::new(py, outputs.collect::<PyResult<Vec<_>>>()?)?
                .into_any()
                .unbind()
        }
        FieldValue::Array(..) => {
            let items = value.items().map(|item| take(py, &item));
            PyTuple::new(py, items.collect::<PyResult<Vec<_>>>()?)?
                .into_any()
                .unbind()
        }
    })
}

/// Converts a number to the named value of an enum.
fn named_value(py: Python<'_>, info: &EnumInfo, byte: u8) -> PyResult<Py<PyAny>> {
    let class = commands(py)?.getattr(info.name)?;
    Ok(class.call1((byte,))?.unbind())
}

/// Converts active alarms to `magician.alarms`.
pub(crate) fn alarms(py: Python<'_>, alarms: &AlarmSet) -> PyResult<Py<PyAny>> {
    let of = py.import("magician.alarms")?.getattr("Alarm")?;
    let codes = alarms.codes().map(|code| of.call1((code,)));
    let codes = codes.collect::<PyResult<Vec<_>>>()?;
    Ok(PyTuple::new(py, codes)?.into_any().unbind())
}

/// Converts a pose to `magician.commands`.
pub(crate) fn pose(py: Python<'_>, pose: &magician::commands::Pose) -> PyResult<Py<PyAny>> {
    let [j1, j2, j3, j4] = pose.joint_angle.map(shortest);
    let [x, y, z, r] = [pose.x, pose.y, pose.z, pose.r].map(shortest);
    let class = commands(py)?.getattr("Pose")?;
    Ok(class.call1((x, y, z, r, (j1, j2, j3, j4)))?.unbind())
}

/// Returns the shortest decimal number that rounds to this 32-bit float.
pub(crate) fn shortest(number: f32) -> f64 {
    let wide = f64::from(number);
    if wide.fract() == 0.0 || !wide.is_finite() {
        return wide;
    }
    number.to_string().parse().unwrap_or(wide)
}
