//! A mesh before a backdrop, as luminance for the sensor or as colour for people.

use evpose_core::Plane;
use glam::{Vec2, Vec3A};

use super::{Backdrop, FrameResponse, Lighting, luminance};
use crate::raster::{Camera, Fragment, Mesh, PixelRect, Raster};
use crate::texture::Texture;

/// Everything in a picture but the mesh, fixed for an episode.
#[derive(Debug, Clone)]
pub struct Scene {
    /// Where the picture is taken from.
    pub camera: Camera,
    /// Lights on the mesh.
    pub lighting: Lighting,
    /// Albedo of the mesh; its values are taken as linear.
    pub skin: Texture,
    /// What is behind the mesh.
    pub backdrop: Backdrop,
    /// What the frame buffer keeps.
    pub response: FrameResponse,
}

/// Renders one scene, frame after frame.
///
/// The luminance of the backdrop is computed once; a frame restores it and shades the pixels of the
/// mesh, and touches nothing outside the rectangles of this and of the last mesh.
#[derive(Debug, Clone)]
pub struct Renderer {
    scene: Scene,
    /// Whether the meshes are closed, see [`is_closed`](crate::raster::is_closed).
    closed: bool,
    raster: Raster,
    backdrop: Plane<f32>,
    luminance: Plane<f32>,
}

impl Renderer {
    /// Prepares `scene` for meshes that are closed or not.
    pub fn new(scene: Scene, closed: bool) -> Self {
        let raster = Raster::new(scene.camera.sensor());
        let mut backdrop = Plane::for_sensor(scene.camera.sensor(), 0.0);
        for (pixel, rgb) in backdrop.data_mut().iter_mut().zip(scene.backdrop.rgb().data()) {
            *pixel = luminance(scene.response.apply(*rgb));
        }
        let luminance = backdrop.clone();
        Self { scene, closed, raster, backdrop, luminance }
    }

    /// The scene.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Linear luminance of `mesh` in the scene, 1 being reference white.
    pub fn render(&mut self, mesh: &Mesh<'_>) -> &Plane<f32> {
        let PixelRect { left, top, right, bottom } = self.raster.rect();
        for y in top..bottom {
            self.luminance.row_mut(y)[left..right]
                .copy_from_slice(&self.backdrop.row(y)[left..right]);
        }
        let rect = self.raster.draw(&self.scene.camera, mesh, self.closed);
        for y in rect.top..rect.bottom {
            let fragments = &self.raster.fragments().row(y)[rect.left..rect.right];
            let pixels = &mut self.luminance.row_mut(y)[rect.left..rect.right];
            for (pixel, fragment) in pixels.iter_mut().zip(fragments) {
                if fragment.is_covered() {
                    *pixel = luminance(self.scene.shade(mesh, fragment));
                }
            }
        }
        &self.luminance
    }

    /// Linear RGB of `mesh` in the scene, for pictures.
    pub fn render_rgb(&mut self, mesh: &Mesh<'_>) -> Plane<Vec3A> {
        self.render(mesh);
        let mut rgb = self.scene.backdrop.rgb().clone();
        for (pixel, fragment) in rgb.data_mut().iter_mut().zip(self.raster.fragments().data()) {
            *pixel = if fragment.is_covered() {
                self.scene.shade(mesh, fragment)
            } else {
                self.scene.response.apply(*pixel)
            };
        }
        rgb
    }

    /// What each pixel saw in the last frame.
    pub fn fragments(&self) -> &Plane<Fragment> {
        self.raster.fragments()
    }
}

impl Scene {
    /// The colour of a covered pixel: normal and texture coordinates interpolated, then lit.
    #[inline]
    fn shade(&self, mesh: &Mesh<'_>, fragment: &Fragment) -> Vec3A {
        let [a, b, c] = mesh.faces[fragment.face as usize];
        let (a, b, c) = (a as usize, b as usize, c as usize);
        let [second, third] = fragment.barycentric;
        let first = 1.0 - second - third;
        let normal = Vec3A::from(mesh.normals[a]) * first
            + Vec3A::from(mesh.normals[b]) * second
            + Vec3A::from(mesh.normals[c]) * third;
        let uv: Vec2 = mesh.uvs[a] * first + mesh.uvs[b] * second + mesh.uvs[c] * third;
        let albedo = self.skin.sample(uv);
        let normal = normal.normalize_or_zero();
        self.response.apply(self.lighting.radiance(normal, albedo))
    }
}
