//! Models that are small enough to be changed byte by byte.

use std::io::{Cursor, Read, Write};
use std::path::Path;

use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipArchive, ZipWriter};

use crate::synthetic::{Field, body, hand, npz, pkl};
use crate::{Result, glb, put};

pub(crate) fn write(folder: &Path) -> Result<()> {
    let whole = small();
    // Read up to the first shape that is wrong, and so of a few hundred bytes.
    let tiny: Vec<Field> = whole.iter().cloned().map(cut).collect();
    for (name, fields) in [("whole", &whole), ("tiny", &tiny)] {
        put(folder, "model-pickle", name, &pkl(fields))?;
        put(folder, "model-npz", name, &deflated(&npz(fields))?)?;
    }
    put(folder, "model-npz", "stored", &npz(&tiny))?;
    let whole_body: Vec<Field> = body().into_iter().map(cut).collect();
    put(folder, "model-npz", "body", &npz(&whole_body))?;
    put(folder, "model-glb", "hand", &glb::hand())?;
    put(folder, "pickle", "tiny", &pkl(&tiny))?;
    let plain = b"(dp0\nS'a'\np1\nI7\nsS'b'\np2\n(lp3\nF1.5\naL12L\na(I1\nI2\ntp4\naVtext\np5\nas.";
    put(folder, "pickle", "protocol-0", plain)?;
    let new =
        b"\x80\x04\x95\x15\0\0\0\0\0\0\0}\x94\x8c\x01a\x94]\x94(K\x01M\x02\x01J\x03\0\0\0\x88Nes.";
    put(folder, "pickle", "protocol-4", new)?;
    Ok(())
}

/// A hand that is mostly zeros: each vertex follows one joint.
fn small() -> Vec<Field> {
    let mut fields = hand(-1.0);
    fields.retain(|field| field.name != "posedirs");
    for field in &mut fields {
        match field.name {
            "shapedirs" | "hands_components" => field.values.fill(0.0),
            "weights" => {
                let joints = field.shape[1];
                let rows = field.values.chunks_exact_mut(joints);
                rows.enumerate().for_each(|(vertex, row)| {
                    row.fill(0.0);
                    row[vertex % joints] = 1.0;
                });
            }
            _ => {}
        }
        if field.kind == "f8" {
            field.kind = "f4";
        }
    }
    fields
}

/// The first few rows.
fn cut(field: Field) -> Field {
    let mut field = field;
    let row: usize = field.shape[1..].iter().product();
    field.shape[0] = field.shape[0].min(2);
    field.values.truncate(field.shape[0] * row);
    if row > 16 {
        (field.shape, field.values) = (vec![2], vec![0.0; 2]);
    }
    field
}

/// The same archive, compressed.
fn deflated(archive: &[u8]) -> Result<Vec<u8>> {
    let mut from = ZipArchive::new(Cursor::new(archive))?;
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    let options = SimpleFileOptions::default().compression_method(CompressionMethod::Deflated);
    for k in 0..from.len() {
        let mut entry = from.by_index(k)?;
        let mut bytes = Vec::new();
        entry.read_to_end(&mut bytes)?;
        zip.start_file(entry.name()?.to_string(), options)?;
        zip.write_all(&bytes)?;
    }
    Ok(zip.finish()?.into_inner())
}
