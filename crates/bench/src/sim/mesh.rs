//! A mesh as fine as the published one.

use std::collections::{BinaryHeap, HashMap};

use evpose_body::{BodyModel, SkinWeights};
use glam::{Vec2, Vec3};

/// Vertices of SMPL+H; a closed surface of as many has its 13,776 triangles.
pub(super) const SMPLH_VERTICES: usize = 6_890;

/// `model` with its longest edges halved until it has `vertices` vertices.
pub(super) fn refined(mut model: BodyModel, vertices: usize) -> BodyModel {
    let mut around: HashMap<(u32, u32), [usize; 2]> = HashMap::new();
    for (number, face) in model.faces.iter().enumerate() {
        for edge in edges(*face) {
            around.entry(edge).and_modify(|faces| faces[1] = number).or_insert([number; 2]);
        }
    }
    let mut longest: BinaryHeap<(u64, (u32, u32))> =
        around.keys().map(|&edge| (length(&model, edge), edge)).collect();
    while model.template_m.len() < vertices
        && let Some((_, edge)) = longest.pop()
    {
        // Halved before: its pieces are in the queue.
        let Some([one, other]) = around.remove(&edge) else { continue };
        let middle = halve(&mut model, edge);
        for number in [one, other] {
            let face = model.faces[number];
            let added = model.faces.len();
            // One part keeps the number and its first end, the other is new.
            model.faces[number] = face.map(|v| if v == edge.1 { middle } else { v });
            model.faces.push(face.map(|v| if v == edge.0 { middle } else { v }));
            let opposite = face.into_iter().find(|v| *v != edge.0 && *v != edge.1);
            let opposite = opposite.unwrap_or(middle);
            // The outer edge at the replaced end borders the new face from here on.
            let outer = ordered(edge.1, opposite);
            if let Some(faces) = around.get_mut(&outer) {
                faces.iter_mut().filter(|face| **face == number).for_each(|face| *face = added);
            }
            around.insert(ordered(middle, opposite), [number, added]);
            longest.push((length(&model, ordered(middle, opposite)), ordered(middle, opposite)));
        }
        let added = model.faces.len();
        around.insert(ordered(edge.0, middle), [one, other]);
        // Both faces were split by now, and their new halves are the last two of the list.
        around.insert(ordered(edge.1, middle), [added - 2, added - 1]);
        for half in [ordered(edge.0, middle), ordered(edge.1, middle)] {
            longest.push((length(&model, half), half));
        }
    }
    model
}

fn ordered(a: u32, b: u32) -> (u32, u32) {
    (a.min(b), a.max(b))
}

fn edges([a, b, c]: [u32; 3]) -> [(u32, u32); 3] {
    [ordered(a, b), ordered(b, c), ordered(c, a)]
}

/// Squared, in whole picometres squared, so that it can be compared.
fn length(model: &BodyModel, (a, b): (u32, u32)) -> u64 {
    let [a, b] = [a, b].map(|v| model.template_m[v as usize].as_dvec3());
    (a.distance_squared(b) * 1e15) as u64
}

/// A vertex in the middle of an edge, with the mean of all its ends have.
fn halve(model: &mut BodyModel, (a, b): (u32, u32)) -> u32 {
    let (a, b) = (a as usize, b as usize);
    let middle = |values: &mut Vec<Vec3>| values.push(0.5 * (values[a] + values[b]));
    middle(&mut model.template_m);
    model.shape_directions_m.iter_mut().for_each(middle);
    let uv: Vec2 = 0.5 * (model.uvs[a] + model.uvs[b]);
    model.uvs.push(uv);
    // Weights of both ends are summed, and `strongest` scales the sum to one.
    let mut shares = vec![0.0; model.parents.len()];
    for (joint, weight) in model.skin[a].iter().chain(model.skin[b].iter()) {
        shares[joint] += weight;
    }
    model.skin.push(SkinWeights::strongest(shares.into_iter().enumerate()));
    (model.template_m.len() - 1) as u32
}

#[cfg(test)]
mod tests {
    use evpose_sim::raster::is_closed;

    use super::*;

    #[test]
    fn a_finer_arm_is_closed_and_has_the_published_number_of_triangles() {
        let arm = refined(BodyModel::procedural_arm(), SMPLH_VERTICES);
        assert_eq!((arm.template_m.len(), arm.faces.len()), (SMPLH_VERTICES, 13_776));
        assert!(is_closed(&arm.faces));
        let shaped = arm.shaped(&[1.0; 10]);
        assert_eq!(shaped.normals.len(), SMPLH_VERTICES);
    }
}
