//! Models of random values in the published shapes, as files.

use std::io::{Cursor, Write};

use zip::ZipWriter;
use zip::write::SimpleFileOptions;

use crate::skeleton;

/// An array before it is a file.
#[derive(Clone)]
pub(super) struct Field {
    pub(super) name: &'static str,
    pub(super) shape: Vec<usize>,
    /// `f4`, `f8` or `u4`.
    pub(super) kind: &'static str,
    pub(super) values: Vec<f64>,
}

/// Number `index` of the stream `salt`, from -0.5 to 0.5.
pub(super) fn unit(salt: u32, index: usize) -> f64 {
    let mut x = (index as u32).wrapping_mul(747_796_405);
    x = x.wrapping_add(salt.wrapping_mul(2_891_336_453).wrapping_add(1));
    x ^= x >> 16;
    x = x.wrapping_mul(0x7feb_352d);
    x ^= x >> 15;
    x = x.wrapping_mul(0x846c_a68b);
    x ^= x >> 16;
    f64::from(x) / 4_294_967_296.0 - 0.5
}

/// Values of a stream, scaled.
pub(super) fn stream(salt: u32, count: usize, scale: f64) -> Vec<f64> {
    (0..count).map(|index| scale * unit(salt, index)).collect()
}

fn single(values: Vec<f64>) -> Vec<f64> {
    values.into_iter().map(|value| f64::from(value as f32)).collect()
}

/// A hand whose fingers point along the sign of `side`.
pub(super) fn hand(side: f64) -> Vec<Field> {
    let parents: Vec<f64> = (0..16)
        .map(|joint: usize| match joint.checked_sub(1) {
            None => f64::from(u32::MAX),
            Some(k) => {
                if k % 3 == 0 {
                    0.0
                } else {
                    k as f64
                }
            }
        })
        .collect();
    let mut fields = model(&parents, 778, [744, 320, 443, 554, 671], side);
    fields.push(field("hands_components", &[45, 45], "f8", stream(8, 2025, 0.4)));
    fields.push(field("hands_mean", &[45], "f8", stream(9, 45, 0.3)));
    fields
}

/// A body with hands.
pub(super) fn body() -> Vec<Field> {
    let parents = skeleton::parents().map(|p| p.map_or(f64::from(u32::MAX), |p| p as f64));
    let mut fields = model(&parents, 6890, [6207, 5782, 5906, 6017, 6134], -1.0);
    fields.push(field("hands_componentsl", &[45, 45], "f8", stream(8, 2025, 0.4)));
    fields.push(field("hands_meanl", &[45], "f8", stream(9, 45, 0.3)));
    fields.push(field("hands_componentsr", &[45, 45], "f8", stream(10, 2025, 0.4)));
    fields.push(field("hands_meanr", &[45], "f8", stream(11, 45, 0.3)));
    fields
}

fn field(name: &'static str, shape: &[usize], kind: &'static str, values: Vec<f64>) -> Field {
    assert_eq!(shape.iter().product::<usize>(), values.len(), "{name}");
    Field { name, shape: shape.to_vec(), kind, values }
}

fn model(parents: &[f64], vertices: usize, tips: [usize; 5], side: f64) -> Vec<Field> {
    let joints = parents.len();
    let mut template = single(stream(1, 3 * vertices, 0.2));
    for tip in tips {
        template[3 * tip] += 0.25 * side;
    }
    let poses = 9 * (joints - 1);
    let mut regressor = vec![0.0; joints * vertices];
    for joint in 0..joints {
        let weight = |k: usize| unit(5, 8 * joint + k) + 0.6;
        let sum: f64 = (0..8).map(weight).sum();
        for k in 0..8 {
            let vertex = ((unit(4, 8 * joint + k) + 0.5) * vertices as f64) as usize;
            regressor[joint * vertices + vertex] += weight(k) / sum;
        }
    }
    let mut weights = vec![0.0; vertices * joints];
    for row in 0..vertices {
        let weight = |k: usize| unit(6, 6 * row + k) + 0.6;
        let sum: f64 = (0..6).map(weight).sum();
        for k in 0..6 {
            let joint = ((unit(7, 6 * row + k) + 0.5) * joints as f64) as usize;
            weights[row * joints + joint] += weight(k) / sum;
        }
    }
    let tree = parents.iter().copied().chain((0..joints).map(|j| j as f64)).collect();
    let faces = (0..3 * (vertices - 2)).map(|k| (k / 3 + k % 3) as f64).collect();
    vec![
        field("v_template", &[vertices, 3], "f8", template),
        field("shapedirs", &[vertices, 3, 10], "f8", single(stream(2, 30 * vertices, 0.02))),
        field("posedirs", &[vertices, 3, poses], "f4", stream(3, 3 * poses * vertices, 0.02)),
        field("J_regressor", &[joints, vertices], "f8", regressor),
        field("weights", &[vertices, joints], "f8", weights),
        field("kintree_table", &[2, joints], "u4", tree),
        field("f", &[vertices - 2, 3], "u4", faces),
    ]
}

fn bytes(field: &Field) -> Vec<u8> {
    let values = field.values.iter();
    match field.kind {
        "f8" => values.flat_map(|value| value.to_le_bytes()).collect(),
        "f4" => values.flat_map(|&value| (value as f32).to_le_bytes()).collect(),
        _ => values.flat_map(|&value| (value as u32).to_le_bytes()).collect(),
    }
}

/// The archive that NumPy writes.
pub(super) fn npz(fields: &[Field]) -> Vec<u8> {
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    let options = SimpleFileOptions::default().compression_method(zip::CompressionMethod::Stored);
    for field in fields {
        zip.start_file(format!("{}.npy", field.name), options).unwrap();
        let shape: String = field.shape.iter().map(|length| format!("{length}, ")).collect();
        let text = format!(
            "{{'descr': '<{}', 'fortran_order': False, 'shape': ({shape}), }}\n",
            field.kind
        );
        zip.write_all(b"\x93NUMPY\x01\x00").unwrap();
        zip.write_all(&(text.len() as u16).to_le_bytes()).unwrap();
        zip.write_all(text.as_bytes()).unwrap();
        zip.write_all(&bytes(field)).unwrap();
    }
    zip.finish().unwrap().into_inner()
}

/// The pickle that Python 2 writes, the template a constant of chumpy and the regressor a matrix of
/// compressed columns, as in the distributed files.
pub(super) fn pkl(fields: &[Field]) -> Vec<u8> {
    let mut out = b"\x80\x02}(".to_vec();
    for field in fields {
        text(&mut out, field.name);
        match field.name {
            "v_template" => object(&mut out, "chumpy.ch", "Ch", |out| {
                text(out, "x");
                array(out, &field.shape, field.kind, &bytes(field));
            }),
            "J_regressor" if field.shape.len() == 2 => compressed(&mut out, field),
            _ => array(&mut out, &field.shape, field.kind, &bytes(field)),
        }
    }
    out.extend(b"u.");
    out
}

fn text(out: &mut Vec<u8>, text: &str) {
    out.extend([b'U', text.len() as u8]);
    out.extend(text.bytes());
}

fn tuple(out: &mut Vec<u8>, values: &[usize]) {
    out.push(b'(');
    for &number in values {
        out.push(b'J');
        out.extend((number as u32).to_le_bytes());
    }
    out.push(b't');
}

fn object(out: &mut Vec<u8>, module: &str, class: &str, state: impl FnOnce(&mut Vec<u8>)) {
    let call =
        format!("ccopy_reg\n_reconstructor\n(c{module}\n{class}\nc__builtin__\nobject\nNtR}}(");
    out.extend(call.bytes());
    state(out);
    out.extend(b"ub");
}

fn array(out: &mut Vec<u8>, shape: &[usize], kind: &str, bytes: &[u8]) {
    out.extend(b"cnumpy.core.multiarray\n_reconstruct\ncnumpy\nndarray\nK\0\x85U\x01b\x87R(K\x01");
    tuple(out, shape);
    out.extend(b"cnumpy\ndtype\n");
    text(out, kind);
    out.extend(b"K\0K\x01\x87R(K\x03U\x01<NNNJ\xff\xff\xff\xffJ\xff\xff\xff\xffK\0tb\x89T");
    out.extend((bytes.len() as u32).to_le_bytes());
    out.extend(bytes);
    out.extend(b"tb");
}

fn compressed(out: &mut Vec<u8>, field: &Field) {
    let (rows, columns) = (field.shape[0], field.shape[1]);
    let (mut starts, mut indices, mut data) = (vec![0u32], Vec::new(), Vec::new());
    for column in 0..columns {
        for row in 0..rows {
            let value = field.values[row * columns + column];
            if value != 0.0 {
                indices.push(row as u32);
                data.push(value);
            }
        }
        starts.push(indices.len() as u32);
    }
    let whole = |values: &[u32]| values.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>();
    object(out, "scipy.sparse.csc", "csc_matrix", |out| {
        text(out, "_shape");
        tuple(out, &[rows, columns]);
        text(out, "indptr");
        array(out, &[starts.len()], "i4", &whole(&starts));
        text(out, "indices");
        array(out, &[indices.len()], "i4", &whole(&indices));
        text(out, "data");
        let data: Vec<u8> = data.iter().flat_map(|value| value.to_le_bytes()).collect();
        array(out, &[data.len() / 8], "f8", &data);
    });
}
