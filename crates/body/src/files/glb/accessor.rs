//! Values of a glTF accessor, with every offset checked against the length of the buffer.

use gltf::Accessor;
use gltf::accessor::DataType;

use crate::files::FieldFault;
use evpose_containers::pickle::{Array, ArrayError, Element};

/// Reads the values of an accessor as `[count, components]`; normalised integers as fractions.
///
/// # Errors
/// If they lie outside of the file's binary part.
pub(super) fn read(accessor: &Accessor<'_>, blob: &[u8]) -> Result<Array, FieldFault> {
    const OUTSIDE: ArrayError = ArrayError::Damaged("it lies outside of the file's binary part");
    if accessor.sparse().is_some() {
        return Err(ArrayError::Damaged("it is sparse; export it as plain values").into());
    }
    let (name, most) = match accessor.data_type() {
        DataType::I8 => ("i1", 127.0),
        DataType::U8 => ("u1", 255.0),
        DataType::I16 => ("i2", 32_767.0),
        DataType::U16 => ("u2", 65_535.0),
        DataType::U32 => ("u4", 1.0),
        DataType::F32 => ("f4", 1.0),
    };
    let element = Element::parse(name).ok_or_else(|| ArrayError::Type(name.to_owned()))?;
    let components = accessor.dimensions().multiplicity();
    let view = accessor.view().ok_or(OUTSIDE)?;
    // Bounds are checked part by part: any offset or length may be wrong.
    let part = blob.get(view.offset()..).and_then(|rest| rest.get(..view.length()));
    let part = part.and_then(|part| part.get(accessor.offset()..)).ok_or(OUTSIDE)?;
    let width = components * element.size();
    // Attributes may be interleaved.
    let stride = view.stride().unwrap_or(width).max(1);
    // Rows packed without gaps, as an array has them.
    let mut packed = Vec::new();
    for row in 0..accessor.count() {
        let start = row.checked_mul(stride).ok_or(OUTSIDE)?;
        let row = part.get(start..).and_then(|rest| rest.get(..width)).ok_or(OUTSIDE)?;
        packed.extend_from_slice(row);
    }
    let shape = vec![accessor.count(), components];
    let mut array = Array::from_bytes(shape, element, false, &packed)?;
    if accessor.normalized() {
        array.values.iter_mut().for_each(|value| *value /= most);
    }
    Ok(array)
}
