//! The fields of a command, as Python has them: `int`, `float`, `bool`, `str`, `bytes`, and tuples of numbers, in the order
//! of the protocol's table. Enums are their numbers, alarms the tuple of their codes, outputs tuples of ratio, address, level.

use magician_protocol::{
    AlarmSet, Field, FieldType, FieldValue, LayoutInfo, MAX_PARAMS, PoCmd, PoList, Scalar, Text,
    Wire, Writer,
};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyTuple};

/// The parameters that the values of a layout's fields make.
///
/// # Errors
/// `TypeError` and `ValueError` that name the field.
pub(crate) fn encode(layout: &LayoutInfo, values: &Bound<'_, PyTuple>) -> PyResult<Vec<u8>> {
    if values.len() != layout.fields.len() {
        let (wanted, given) = (layout.fields.len(), values.len());
        return Err(PyTypeError::new_err(format!(
            "{} has {wanted} fields, not {given}",
            layout.name
        )));
    }
    let mut params = [0; MAX_PARAMS];
    let mut writer = Writer::new(&mut params);
    for (field, value) in layout.fields.iter().zip(values.iter()) {
        if value.is_none() && field.optional {
            break;
        }
        put(field, &value, &mut writer)?;
    }
    let count = writer.finish();
    let count = count.map_err(|error| PyValueError::new_err(error.to_string()))?;
    Ok(params.get(..count).unwrap_or_default().to_vec())
}

/// The values of a layout's fields in parameters that came; `None` for a field that was left out.
///
/// # Errors
/// `ValueError` when the parameters fit no form of the layout.
pub(crate) fn decode<'py>(
    py: Python<'py>,
    layout: &'static LayoutInfo,
    params: &[u8],
) -> PyResult<Bound<'py, PyTuple>> {
    let fields = layout.values(params);
    let fields = fields.map_err(|error| PyValueError::new_err(error.to_string()))?;
    let mut values = Vec::with_capacity(layout.fields.len());
    for (_, value) in fields {
        values.push(take(py, &value)?);
    }
    values.resize_with(layout.fields.len(), || py.None());
    PyTuple::new(py, values)
}

fn put(field: &Field, value: &Bound<'_, PyAny>, writer: &mut Writer<'_>) -> PyResult<()> {
    let named = |error: PyErr| name(value.py(), field, &error);
    match field.ty {
        FieldType::Scalar(kind) => scalar(kind, value, writer).map_err(named)?,
        FieldType::Flag | FieldType::Enum(_) => {
            writer.put(&[value.extract::<u8>().map_err(named)?]);
        }
        FieldType::Array(kind, count) => {
            let items: Vec<Bound<'_, PyAny>> = value.extract().map_err(named)?;
            if items.len() != count {
                let message = format!("{} values, not {}", count, items.len());
                return Err(named(PyValueError::new_err(message)));
            }
            for item in &items {
                scalar(kind, item, writer).map_err(named)?;
            }
        }
        FieldType::Text => {
            let text: String = value.extract().map_err(named)?;
            let text = Text::new(&text).ok_or_else(|| {
                named(PyValueError::new_err("text too long, or with a NUL in it"))
            })?;
            text.write(writer);
        }
        FieldType::Bytes => writer.put(&value.extract::<Vec<u8>>().map_err(named)?),
        FieldType::Alarms => {
            let mut alarms = AlarmSet::default();
            for code in value.extract::<Vec<u8>>().map_err(named)? {
                alarms.insert(code);
            }
            alarms.write(writer);
        }
        FieldType::Outputs => {
            let outputs: Vec<(u8, u16, u8)> = value.extract().map_err(named)?;
            let outputs: Vec<PoCmd> = outputs
                .into_iter()
                .map(|(ratio, address, level)| PoCmd {
                    ratio,
                    address,
                    level,
                })
                .collect();
            let list = PoList::new(&outputs)
                .ok_or_else(|| named(PyValueError::new_err("too many outputs")))?;
            list.write(writer);
        }
    }
    Ok(())
}

fn scalar(kind: Scalar, value: &Bound<'_, PyAny>, writer: &mut Writer<'_>) -> PyResult<()> {
    match kind {
        Scalar::U8 => writer.put(&value.extract::<u8>()?.to_le_bytes()),
        Scalar::U16 => writer.put(&value.extract::<u16>()?.to_le_bytes()),
        Scalar::U32 => writer.put(&value.extract::<u32>()?.to_le_bytes()),
        Scalar::U64 => writer.put(&value.extract::<u64>()?.to_le_bytes()),
        Scalar::I32 => writer.put(&value.extract::<i32>()?.to_le_bytes()),
        Scalar::F32 => writer.put(&value.extract::<f32>()?.to_le_bytes()),
    }
    Ok(())
}

/// The same kind of exception, with the name of the field before it.
fn name(py: Python<'_>, field: &Field, error: &PyErr) -> PyErr {
    let message = format!("{}: {}", field.name, error.value(py));
    match error.is_instance_of::<PyTypeError>(py) {
        true => PyTypeError::new_err(message),
        false => PyValueError::new_err(message),
    }
}

fn take(py: Python<'_>, value: &FieldValue<'_>) -> PyResult<Py<PyAny>> {
    Ok(match value {
        FieldValue::Unsigned(number) => number.into_pyobject(py)?.into_any().unbind(),
        FieldValue::Signed(number) => number.into_pyobject(py)?.into_any().unbind(),
        FieldValue::Float(number) => number.into_pyobject(py)?.into_any().unbind(),
        FieldValue::Flag(byte) => (*byte != 0)
            .into_pyobject(py)?
            .to_owned()
            .into_any()
            .unbind(),
        FieldValue::Enum(_, byte) => byte.into_pyobject(py)?.into_any().unbind(),
        FieldValue::Text(bytes) => {
            let text = String::from_utf8_lossy(bytes);
            text.into_pyobject(py)?.into_any().unbind()
        }
        FieldValue::Bytes(bytes) => PyBytes::new(py, bytes).into_any().unbind(),
        FieldValue::Alarms(alarms) => PyTuple::new(py, alarms.codes().collect::<Vec<_>>())?
            .into_any()
            .unbind(),
        FieldValue::Outputs(list) => {
            let outputs = list.as_slice().iter();
            let outputs = outputs.map(|output| (output.ratio, output.address, output.level));
            PyTuple::new(py, outputs.collect::<Vec<_>>())?
                .into_any()
                .unbind()
        }
        FieldValue::Array(kind, bytes) => array(py, *kind, bytes)?,
    })
}

fn array(py: Python<'_>, kind: Scalar, bytes: &[u8]) -> PyResult<Py<PyAny>> {
    let items = bytes.chunks_exact(kind.size());
    let tuple = match kind {
        Scalar::F32 => {
            let number = |item: &[u8]| f32::from_le_bytes(item.try_into().unwrap_or_default());
            PyTuple::new(py, items.map(number).collect::<Vec<_>>())?
        }
        Scalar::I32 => {
            let number = |item: &[u8]| i32::from_le_bytes(item.try_into().unwrap_or_default());
            PyTuple::new(py, items.map(number).collect::<Vec<_>>())?
        }
        _ => {
            let number = |item: &[u8]| {
                item.iter()
                    .rev()
                    .fold(0_u64, |sum, byte| (sum << 8) | u64::from(*byte))
            };
            PyTuple::new(py, items.map(number).collect::<Vec<_>>())?
        }
    };
    Ok(tuple.into_any().unbind())
}
