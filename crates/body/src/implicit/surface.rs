//! A mesh of triangles: polygonised, evened out, drawn back onto the surface, cut into triangles.

use std::collections::BTreeSet;

use glam::Vec3;

use super::polygonise::{Grid, QuadMesh, polygonise};

/// How often vertices are evened out.
const ROUNDS: usize = 12;
/// How far a vertex moves towards the mean of its neighbours in a round.
const STEP: f32 = 0.5;
/// Step of the numerical gradient of the distance.
const PROBE_M: f32 = 1e-4;

/// Vertices and outward-facing triangles of the surface where `distance` is zero.
pub(crate) fn surface(distance: impl Fn(Vec3) -> f32, grid: &Grid) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let QuadMesh { mut vertices_m, quads } = polygonise(&distance, grid);
    let neighbours = neighbours(vertices_m.len(), &quads);
    for _ in 0..ROUNDS {
        vertices_m = neighbours
            .iter()
            .zip(&vertices_m)
            .map(|(around, &vertex_m)| {
                let mean_m = around.iter().map(|&i| vertices_m[i as usize]).sum::<Vec3>()
                    / around.len() as f32;
                // Means shrink a body: every round puts vertices back onto its surface.
                onto_surface(&distance, vertex_m.lerp(mean_m, STEP))
            })
            .collect();
    }
    let faces = triangles(&vertices_m, &quads);
    (vertices_m, faces)
}

/// One Newton step towards the zero of `distance` along its gradient.
fn onto_surface(distance: impl Fn(Vec3) -> f32, point_m: Vec3) -> Vec3 {
    let here_m = distance(point_m);
    let gradient = Vec3::from_array(
        Vec3::AXES.map(|axis| (distance(point_m + axis * PROBE_M) - here_m) / PROBE_M),
    );
    // A distance that blends has a gradient near one; a much smaller one is a ridge to stay off.
    point_m - gradient * (here_m / gradient.length_squared().max(0.25))
}

/// The vertices that share an edge with each vertex, in ascending order.
fn neighbours(vertices: usize, quads: &[[u32; 4]]) -> Vec<Vec<u32>> {
    let mut around = vec![Vec::new(); vertices];
    for quad in quads {
        for k in 0..4 {
            around[quad[k] as usize].extend([quad[(k + 1) % 4], quad[(k + 3) % 4]]);
        }
    }
    for list in &mut around {
        list.sort_unstable();
        list.dedup();
    }
    around
}

/// Cuts quadrilaterals along their shorter diagonals.
///
/// At a pinched surface the shorter diagonal can be an edge already; cutting along the
/// other one keeps every edge between two faces.
fn triangles(vertices_m: &[Vec3], quads: &[[u32; 4]]) -> Vec<[u32; 3]> {
    let edge = |i: u32, j: u32| (i.min(j), i.max(j));
    let length_sq =
        |i: u32, j: u32| vertices_m[i as usize].distance_squared(vertices_m[j as usize]);
    let mut edges: BTreeSet<(u32, u32)> =
        quads.iter().flat_map(|quad| (0..4).map(|k| edge(quad[k], quad[(k + 1) % 4]))).collect();
    quads
        .iter()
        .flat_map(|&[a, b, c, d]| {
            let shorter_first = length_sq(a, c) <= length_sq(b, d);
            let taken = |i, j| edges.contains(&edge(i, j));
            let along_ac = if shorter_first { !taken(a, c) } else { taken(b, d) };
            edges.insert(if along_ac { edge(a, c) } else { edge(b, d) });
            if along_ac { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] }
        })
        .collect()
}
