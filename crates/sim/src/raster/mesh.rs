//! A triangle mesh as the rasteriser reads it.

use std::collections::HashMap;

use glam::{Vec2, Vec3};

/// Borrowed slices of a posed mesh. Faces are counter-clockwise seen from outside.
#[derive(Debug, Clone, Copy)]
pub struct Mesh<'a> {
    /// Vertex positions in world metres.
    pub vertices_m: &'a [Vec3],
    /// Vertex normals in the world; unit length not required.
    pub normals: &'a [Vec3],
    /// Texture coordinates of each vertex.
    pub uvs: &'a [Vec2],
    /// Three vertex indices a face.
    pub faces: &'a [[u32; 3]],
}

/// Whether `faces` bound a solid: every edge is walked once in each direction.
///
/// The nearest surface of a solid seen from outside faces the viewer, so the faces that look away
/// need not be drawn.
pub fn is_closed(faces: &[[u32; 3]]) -> bool {
    let mut balance: HashMap<(u32, u32), i32> = HashMap::with_capacity(faces.len() * 2);
    for &[a, b, c] in faces {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            // In a closed mesh each edge is passed once in both directions.
            let (edge, step) = if from < to { ((from, to), 1) } else { ((to, from), -1) };
            *balance.entry(edge).or_default() += step;
        }
    }
    !faces.is_empty() && balance.values().all(|&sum| sum == 0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tetrahedron_is_closed_and_loses_that_with_any_face() {
        let faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
        assert!(is_closed(&faces));
        for skipped in 0..4 {
            let rest: Vec<_> =
                faces.iter().enumerate().filter(|(i, _)| *i != skipped).map(|(_, f)| *f).collect();
            assert!(!is_closed(&rest));
        }
        assert!(!is_closed(&[]));
    }
}
