//! The rasteriser of the crate euc.

use euc::Pipeline;
use euc::buffer::Buffer2d;
use euc::rasterizer::{BackfaceCullingEnabled, Triangles};
use evpose_body::BodyModel;
use evpose_sim::raster::Camera;
use glam::{Mat4, Vec3};

use super::raster::{Draw, clip_from_world};

/// No face.
const NONE: u32 = u32::MAX;

/// Draws flat triangles, one number each.
pub(super) struct Euc<'a> {
    projection: Mat4,
    model: &'a BodyModel,
    /// Corner by corner: clip position and number of the face.
    corners: Vec<([f32; 4], f32)>,
    faces: Buffer2d<u32>,
    depth: Buffer2d<f32>,
}

impl<'a> Euc<'a> {
    pub(super) fn new(camera: Camera, model: &'a BodyModel) -> Self {
        let size = [usize::from(camera.sensor().width), usize::from(camera.sensor().height)];
        Self {
            projection: clip_from_world(&camera),
            model,
            corners: Vec::new(),
            faces: Buffer2d::new(size, NONE),
            depth: Buffer2d::new(size, 1.0),
        }
    }
}

struct Flat;

impl Pipeline for Flat {
    type Vertex = ([f32; 4], f32);
    type VsOut = f32;
    type Pixel = u32;

    #[inline(always)]
    fn vert(&self, vertex: &Self::Vertex) -> ([f32; 4], f32) {
        *vertex
    }

    #[inline(always)]
    fn frag(&self, face: &f32) -> u32 {
        *face as u32
    }
}

impl Draw for Euc<'_> {
    fn draw(&mut self, vertices_m: &[Vec3]) {
        use euc::Target as _;
        // Within the time, since every frame needs it.
        self.faces.clear(NONE);
        self.depth.clear(1.0);
        let positions: Vec<[f32; 4]> = vertices_m
            .iter()
            .map(|vertex_m| (self.projection * vertex_m.extend(1.0)).to_array())
            .collect();
        self.corners.clear();
        for (number, face) in self.model.faces.iter().enumerate() {
            // A corner carries the number of its triangle, which is what is drawn.
            self.corners.extend(face.map(|v| (positions[v as usize], number as f32)));
        }
        Flat.draw::<Triangles<'_, _, BackfaceCullingEnabled>, _>(
            &self.corners,
            &mut self.faces,
            Some(&mut self.depth),
        );
        std::hint::black_box(&self.faces);
    }

    fn covered(&self) -> usize {
        self.faces.as_ref().iter().filter(|&&face| face != NONE).count()
    }
}
