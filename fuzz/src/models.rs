//! Files of body models, and the Python pickles that some of them are.

use std::path::Path;

use evpose_body::files::ModelFile;
use evpose_body::{BodyPose, PosedBody};
use evpose_containers::pickle::{Array, Pickle, Sparse};

/// Reads a model from a pickle, a NumPy archive or a glTF file, whichever `bytes` are, and poses it.
///
/// # Panics
/// If a model that was accepted cannot be posed.
pub fn model(bytes: &[u8]) {
    let Ok(file) = ModelFile::from_bytes(Path::new("MODEL"), bytes.to_vec()) else { return };
    let model = file.model;
    let shaped = model.shaped(&[]);
    let mut posed = PosedBody::default();
    model.pose(&shaped, &BodyPose::rest(&model), &mut posed);
    assert_eq!(posed.vertices_m.len(), model.template_m.len());
}

/// Reads a pickle, and whatever in it can be arrays.
///
/// # Panics
/// If the place of a fault is none of the pickle.
pub fn pickle(bytes: &[u8]) {
    let pickle = match Pickle::read(bytes, 0) {
        Ok(pickle) => pickle,
        Err(error) => {
            assert!(error.byte <= bytes.len(), "beyond the end: {error}");
            return;
        }
    };
    assert!(pickle.end() <= bytes.len());
    // Arrays may share what they are made of: a file of a few bytes can name one many times over.
    for (_, id) in pickle.entries(pickle.root()).iter().take(64) {
        let _ = (Array::read(&pickle, *id), Sparse::read(&pickle, *id));
        let _ = (pickle.class(*id), pickle.text(*id), pickle.sizes(*id));
    }
    let _ = Array::read(&pickle, pickle.root());
}
