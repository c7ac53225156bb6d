use std::fs;

use evpose_core::Micros;

use super::*;
use crate::IoError;
use crate::npz::NpzFault;

const SHAPE: StackShape = [3, 2, 4, 5];

fn window(k: usize) -> Vec<f32> {
    (0..40).map(|i| (k * 40 + i) as f32 * 0.25 - 7.0).collect()
}

fn written(path: &std::path::Path) {
    let mut writer = TensorWriter::create(path, SHAPE).unwrap();
    for k in 0..3 {
        writer.write(Micros(10_000 * k as i64 - 5), &window(k)).unwrap();
    }
    writer.finish().unwrap();
}

#[test]
fn stacks_are_read_back() {
    let directory = tempfile::tempdir().unwrap();
    let values: Vec<f32> = (0..3).flat_map(window).collect();
    let ends = [-5, 9_995, 19_995].map(Micros).to_vec();
    for (name, ends) in [("a.npy", None), ("a.npz", Some(ends))] {
        let path = directory.path().join(name);
        written(&path);
        let stack = TensorStack::read(&path).unwrap();
        assert_eq!(stack, TensorStack { shape: SHAPE.to_vec(), values: values.clone(), ends });
    }
    let path = directory.path().join("one.npy");
    write_window(&path, [2, 4, 5], &window(1)).unwrap();
    let stack = TensorStack::read(&path).unwrap();
    assert_eq!((stack.shape, stack.values), (vec![2, 4, 5], window(1)));
}

#[test]
fn a_file_cut_at_any_byte_is_a_typed_error_with_what_is_before() {
    let directory = tempfile::tempdir().unwrap();
    for name in ["a.npy", "a.npz"] {
        let path = directory.path().join(name);
        written(&path);
        let bytes = fs::read(&path).unwrap();
        for cut in 0..bytes.len() {
            fs::write(&path, &bytes[..cut]).unwrap();
            match TensorStack::read(&path).unwrap_err() {
                IoError::Npz { fault: NpzFault::Unreadable(_), values, .. } if name == "a.npy" => {
                    assert_eq!(values, cut.saturating_sub(128) / 4, "{cut}");
                }
                IoError::Npz { .. } => {}
                other => panic!("{name} cut at {cut}: {other}"),
            }
        }
    }
}

#[test]
fn windows_of_another_shape_too_many_and_too_few_are_refused_and_leave_no_file() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("a.npy");
    let mut writer = TensorWriter::create(&path, [1, 1, 2, 2]).unwrap();
    let message = writer.write(Micros(0), &[0.0; 3]).unwrap_err().to_string();
    assert!(message.contains("3 values of window 0, in a stack of 1 windows"), "{message}");
    let message = writer.finish().unwrap_err().to_string();
    assert!(message.contains("0 of its 1 windows are there"), "{message}");
    let mut writer = TensorWriter::create(&path, [1, 1, 2, 2]).unwrap();
    writer.write(Micros(0), &[0.0; 4]).unwrap();
    assert!(writer.write(Micros(1), &[0.0; 4]).is_err());
    drop(writer);
    assert_eq!(fs::read_dir(directory.path()).unwrap().count(), 0);
    let message = TensorWriter::create("a.csv", SHAPE).err().unwrap().to_string();
    assert!(message.contains("should end in .npy, .npz"), "{message}");
}
