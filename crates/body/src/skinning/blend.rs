//! The blended transform of every vertex, and what it moves.

use evpose_cpu::{Kernel8, LANES_8, Lanes8, dispatch};
use glam::{Affine3A, Vec3};

use crate::normals::normalise;
use crate::{BodyModel, FurtherWeight};

/// The columns of a transform, each with a fourth number that means nothing: two vectors.
type Columns = [[f32; LANES_8]; 2];

fn columns(transform: &Affine3A) -> Columns {
    let [x, y, z, t] = [
        transform.matrix3.x_axis,
        transform.matrix3.y_axis,
        transform.matrix3.z_axis,
        transform.translation,
    ];
    [[x.x, x.y, x.z, 0.0, y.x, y.y, y.z, 0.0], [z.x, z.y, z.z, 0.0, t.x, t.y, t.z, 0.0]]
}

impl BodyModel {
    /// Moves vertices and normals by `Σ wⱼ·Aⱼ`.
    pub(super) fn blend(
        &self,
        world_from_rest: &[Affine3A],
        rest_m: &[Vec3],
        rest_normals: &[Vec3],
        vertices_m: &mut Vec<Vec3>,
        normals: &mut Vec<Vec3>,
    ) {
        let transforms = world_from_rest.iter().map(columns).collect();
        vertices_m.resize(rest_m.len(), Vec3::ZERO);
        normals.resize(rest_m.len(), Vec3::ZERO);
        let rest = (rest_m, rest_normals);
        dispatch(Blend { model: self, transforms, rest, posed: (vertices_m, normals) });
    }
}

struct Blend<'a> {
    model: &'a BodyModel,
    transforms: Vec<Columns>,
    rest: (&'a [Vec3], &'a [Vec3]),
    posed: (&'a mut [Vec3], &'a mut [Vec3]),
}

impl Kernel8 for Blend<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes8>(self, l: L) {
        let Self { model, transforms, rest, posed } = self;
        let mut further = model.further_weights.as_slice();
        let vertices = posed.0.iter_mut().zip(rest.0);
        let normals = posed.1.iter_mut().zip(rest.1);
        for (vertex, ((skin, (posed_m, rest_m)), (posed_normal, rest_normal))) in
            model.skin.iter().zip(vertices).zip(normals).enumerate()
        {
            // Weights descend: without a third there is no fourth.
            let [first, second, third, fourth] = skin.joints.map(|j| &transforms[usize::from(j)]);
            let [of_first, of_second, of_third, of_fourth] = skin.weights;
            let mut sum = [l.splat(0.0); 2];
            add(l, &mut sum, first, of_first);
            add(l, &mut sum, second, of_second);
            if of_third > 0.0 {
                add(l, &mut sum, third, of_third);
                add(l, &mut sum, fourth, of_fourth);
            }
            // In the order of the vertices, so that one pass over both is enough.
            while let [FurtherWeight { vertex: of, joint, weight }, others @ ..] = further
                && *of as usize == vertex
            {
                add(l, &mut sum, &transforms[usize::from(*joint)], *weight);
                further = others;
            }
            *posed_m = apply(l, sum, *rest_m, 1.0);
            // Normals turn, but do not move.
            *posed_normal = apply(l, sum, *rest_normal, 0.0);
        }
        normalise(l, posed.1);
    }
}

#[inline(always)]
fn add<L: Lanes8>(l: L, sum: &mut [L::F; 2], transform: &Columns, weight: f32) {
    let weight = l.splat(weight);
    sum[0] = l.add(sum[0], l.mul(l.load(transform[0]), weight));
    sum[1] = l.add(sum[1], l.mul(l.load(transform[1]), weight));
}

/// The transform of a point (`one` = 1) or of a direction (`one` = 0).
#[inline(always)]
fn apply<L: Lanes8>(l: L, sum: [L::F; 2], v: Vec3, one: f32) -> Vec3 {
    let moved = l.add(l.mul(sum[0], both(l, v.x, v.y)), l.mul(sum[1], both(l, v.z, one)));
    let [x, y, z, _, more_x, more_y, more_z, _] = l.store(moved);
    Vec3::new(x + more_x, y + more_y, z + more_z)
}

/// A factor for the first column of two, and one for the second.
#[inline(always)]
fn both<L: Lanes8>(l: L, first: f32, second: f32) -> L::F {
    let is_first = l.load_i([-1, -1, -1, -1, 0, 0, 0, 0]);
    l.from_bits(l.select(is_first, l.to_bits(l.splat(first)), l.to_bits(l.splat(second))))
}
