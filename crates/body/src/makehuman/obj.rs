//! The base mesh: vertices, and quadrilaterals in named groups.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use glam::Vec3;

use crate::folder_error::{FolderError, read_text};

/// MakeHuman's base mesh, in its unit.
pub(super) struct BaseMesh {
    pub(super) path: PathBuf,
    pub(super) vertices: Vec<Vec3>,
    groups: BTreeMap<String, Vec<[u32; 3]>>,
}

impl BaseMesh {
    /// Reads a Wavefront OBJ file; of a face, only the indices of its vertices.
    pub(super) fn read(path: &Path) -> Result<Self, FolderError> {
        let (mut vertices, mut groups) = (Vec::new(), BTreeMap::<String, Vec<[u32; 3]>>::new());
        let mut group = String::new();
        for (line, text) in read_text(path)?.lines().enumerate() {
            let mut words = text.split_whitespace();
            match words.next() {
                Some("v") => {
                    let vertex = vector(words)
                        .ok_or_else(|| FolderError::line(path, line, "`v x y z` expected"))?;
                    vertices.push(vertex);
                }
                Some("g") => group = words.next().unwrap_or_default().to_owned(),
                Some("f") => {
                    let index = |word: &str| {
                        // Corners are `vertex/texture/normal`, counted from 1.
                        let number: u32 = word.split('/').next()?.parse().ok()?;
                        number.checked_sub(1).filter(|&v| (v as usize) < vertices.len())
                    };
                    let corners: Option<Vec<u32>> = words.map(index).collect();
                    let Some([first, rest @ ..]) = corners.as_deref() else {
                        let reason = "a face of vertices above it expected";
                        return Err(FolderError::line(path, line, reason));
                    };
                    // A fan: quadrilaterals become two triangles.
                    let triangles = rest.windows(2).map(|pair| [*first, pair[0], pair[1]]);
                    groups.entry(group.clone()).or_default().extend(triangles);
                }
                _ => {}
            }
        }
        Ok(Self { path: path.to_owned(), vertices, groups })
    }

    /// Triangles of a group, none if there is no such group.
    pub(super) fn faces(&self, group: &str) -> &[[u32; 3]] {
        self.groups.get(group).map_or(&[], Vec::as_slice)
    }

    /// Vertices of a group, ascending.
    pub(super) fn group(&self, group: &str) -> Vec<u32> {
        let mut vertices: Vec<u32> = self.faces(group).iter().flatten().copied().collect();
        vertices.sort_unstable();
        vertices.dedup();
        vertices
    }
}

/// Three finite values.
pub(super) fn vector<'a>(words: impl Iterator<Item = &'a str>) -> Option<Vec3> {
    let values: Option<Vec<f32>> = words.map(|word| word.parse().ok()).collect();
    let vector = Vec3::from_array(values?.try_into().ok()?);
    vector.is_finite().then_some(vector)
}
