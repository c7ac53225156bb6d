//! Renderer of a mesh before a backdrop, as luminance for the sensor or as RGB for display.

use evpose_core::Plane;
use glam::{Vec2, Vec3A};

use super::shader::Shader;
use super::{Backdrop, FrameResponse, Lighting, luminance};
use crate::raster::{Camera, Fragment, Mesh, PixelRect, Raster};
use crate::texture::Texture;

/// Everything in a frame except the mesh, constant over an episode.
#[derive(Debug, Clone)]
pub struct Scene {
    /// Camera.
    pub camera: Camera,
    /// Lights on the mesh; the backdrop is unlit.
    pub lighting: Lighting,
    /// Albedo of the mesh; its values are taken as linear.
    pub skin: Texture,
    /// Backdrop behind the mesh.
    pub backdrop: Backdrop,
    /// Clipping and quantisation of the frame buffer.
    pub response: FrameResponse,
}

/// Renderer of one scene, frame by frame.
///
/// The luminance of the backdrop is computed once; a frame restores it and shades the pixels of the
/// mesh, and touches nothing outside the rectangles of this and of the last mesh.
#[derive(Debug, Clone)]
pub struct Renderer {
    scene: Scene,
    /// Whether the meshes are closed, see [`is_closed`](crate::raster::is_closed).
    closed: bool,
    light_level: f32,
    raster: Raster,
    shader: Shader,
    backdrop: Plane<f32>,
    luminance: Plane<f32>,
}

impl Renderer {
    /// Prepares `scene` for meshes that are closed or not. All light is multiplied by `light_level`
    /// behind the frame buffer.
    pub fn new(scene: Scene, closed: bool, light_level: f32) -> Self {
        let raster = Raster::new(scene.camera.sensor());
        let mut backdrop = Plane::for_sensor(scene.camera.sensor(), 0.0);
        for (pixel, rgb) in backdrop.data_mut().iter_mut().zip(scene.backdrop.rgb().data()) {
            *pixel = light_level * luminance(scene.response.apply(*rgb));
        }
        let luminance = backdrop.clone();
        let shader = Shader::default();
        Self { scene, closed, light_level, raster, shader, backdrop, luminance }
    }

    /// Scene that is rendered.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Moves the camera. The caller repaints the backdrop.
    ///
    /// # Panics
    /// If the camera's image has another size.
    pub fn set_camera(&mut self, camera: Camera) {
        assert!(camera.sensor() == self.scene.camera.sensor(), "a camera of another image size");
        self.scene.camera = camera;
    }

    /// Repaints the backdrop: `paint` receives its luminance and must not write outside `rect`.
    pub(crate) fn repaint(&mut self, rect: PixelRect, paint: impl FnOnce(&mut Plane<f32>)) {
        paint(&mut self.backdrop);
        for y in rect.top..rect.bottom {
            let columns = rect.left..rect.right;
            self.luminance.row_mut(y)[columns.clone()]
                .copy_from_slice(&self.backdrop.row(y)[columns]);
        }
    }

    /// Renders the linear luminance of `mesh` in the scene, 1 being reference white.
    pub fn render(&mut self, mesh: &Mesh<'_>) -> &Plane<f32> {
        self.rasterize(mesh);
        self.shade(mesh)
    }

    /// First half of [`Self::render`]: the visibility of every pixel.
    pub fn rasterize(&mut self, mesh: &Mesh<'_>) {
        let PixelRect { left, top, right, bottom } = self.raster.rect();
        for y in top..bottom {
            self.luminance.row_mut(y)[left..right]
                .copy_from_slice(&self.backdrop.row(y)[left..right]);
        }
        self.raster.draw(&self.scene.camera, mesh, self.closed);
    }

    /// Second half of [`Self::render`]: the shading of the rasterised `mesh`.
    pub fn shade(&mut self, mesh: &Mesh<'_>) -> &Plane<f32> {
        let Self { shader, scene, raster, luminance, .. } = self;
        shader.shade(scene, raster, mesh, self.light_level, luminance);
        &self.luminance
    }

    /// Renders the linear RGB of `mesh` in the scene, for display.
    pub fn render_rgb(&mut self, mesh: &Mesh<'_>) -> Plane<Vec3A> {
        self.render(mesh);
        let mut rgb = self.scene.backdrop.rgb().clone();
        let fragments = self.raster.fragments(mesh);
        for (pixel, fragment) in rgb.data_mut().iter_mut().zip(fragments.data()) {
            let rgb = if fragment.is_covered() {
                self.scene.shade(mesh, fragment)
            } else {
                self.scene.response.apply(*pixel)
            };
            *pixel = rgb * self.light_level;
        }
        rgb
    }

    /// Pixels that the mesh covered in the last frame.
    pub fn covered(&self) -> usize {
        self.raster.covered()
    }
}

impl Scene {
    /// Shades a covered pixel: interpolates normal and texture coordinates, then lights them.
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

#[cfg(test)]
mod tests {
    use evpose_core::{LookAt, Pinhole, SensorSize};
    use glam::Vec3;

    use super::*;
    use crate::scene::DirectionalLight;
    use crate::shapes::Shape;

    const SENSOR: SensorSize = SensorSize { width: 96, height: 72 };
    const BEHIND: f32 = 0.3;

    /// At the origin, looking along -z at something white, lit from the upper right.
    fn renderer(response: FrameResponse) -> Renderer {
        renderer_at(response, 1.0)
    }

    fn renderer_at(response: FrameResponse, light_level: f32) -> Renderer {
        let placement = LookAt { eye_m: Vec3::ZERO, centre_m: Vec3::NEG_Z, up: Vec3::Y };
        let pinhole = Pinhole::from_vertical_fov(SENSOR, 45.0);
        let light = DirectionalLight { direction: Vec3A::new(0.6, 0.8, 0.0), colour: Vec3A::ONE };
        let dark = DirectionalLight { colour: Vec3A::ZERO, ..light };
        let scene = Scene {
            camera: Camera::new(SENSOR, pinhole, &placement, 0.1),
            lighting: Lighting { lights: [light, dark], ambient: Vec3A::splat(0.05), gain: 1.4 },
            skin: Texture::from_rgb8(1, 1, &[255; 3]).unwrap(),
            backdrop: Backdrop::uniform(SENSOR, Vec3A::splat(BEHIND)),
            response,
        };
        Renderer::new(scene, true, light_level)
    }

    #[test]
    fn a_sphere_is_shaded_by_lambert_and_has_no_holes() {
        let (centre_m, radius_m) = (Vec3::new(0.1, -0.05, -1.0), 0.3);
        let sphere = Shape::sphere(centre_m, radius_m, 64);
        let mut renderer = renderer(FrameResponse::Linear);
        let pinhole = renderer.scene().camera.pinhole();
        let seen = renderer.render(&sphere.mesh()).clone();
        let mut covered = 0;
        for y in 0..seen.height() {
            for x in 0..seen.width() {
                let offset = Vec2::new(x as f32 + 0.5, y as f32 + 0.5) - pinhole.principal_px;
                let ray = Vec3::new(offset.x, -offset.y, -pinhole.focal_px).normalize();
                let along = ray.dot(centre_m);
                let miss_m = (centre_m - ray * along).length();
                if miss_m < 0.97 * radius_m {
                    let hit = ray * (along - (radius_m.powi(2) - miss_m.powi(2)).sqrt());
                    let normal = (hit - centre_m) / radius_m;
                    let want = 1.4 * (normal.dot(Vec3::new(0.6, 0.8, 0.0)).max(0.0) + 0.05);
                    assert!((seen.at(x, y) - want).abs() < 0.03, "({x}, {y})");
                    covered += 1;
                } else if miss_m > radius_m {
                    assert!((seen.at(x, y) - BEHIND).abs() < 1e-6, "({x}, {y})");
                }
            }
        }
        assert!(covered > 1_000, "{covered}");
    }

    /// A textured surface, many pixels at a time and one by one.
    #[test]
    fn luminance_equals_that_of_the_rgb_frame() {
        let texels: Vec<u8> = (0..3 * 32 * 16).map(|k| (k * 89 % 256) as u8).collect();
        for response in [FrameResponse::Linear, FrameResponse::Clipped, FrameResponse::Rgb8] {
            let mut renderer = renderer(response);
            renderer.scene.skin = Texture::from_rgb8(32, 16, &texels).unwrap();
            // The near plane cuts the second one.
            for (centre_m, radius_m) in [(Vec3::new(0.1, -0.05, -1.0), 0.3), (Vec3::ZERO, 0.13)] {
                let sphere = Shape::sphere(centre_m, radius_m, 24);
                let rgb = renderer.render_rgb(&sphere.mesh());
                let seen = renderer.render(&sphere.mesh());
                let pairs = seen.data().iter().zip(rgb.data());
                // A colour on the border between two codes may be rounded to either.
                let step = if response == FrameResponse::Rgb8 { 1.0 / 255.0 } else { 0.0 };
                for (got, want) in pairs.map(|(&got, &rgb)| (got, luminance(rgb))) {
                    assert!((got - want).abs() < 1e-5 + step, "{response:?}: {got} for {want}");
                }
            }
        }
    }

    #[test]
    fn what_is_brighter_than_white_is_clipped_unless_all_is_kept() {
        // At its brightest 1.4 · (1 + 0.05), where the sphere faces the light.
        let sphere = Shape::sphere(Vec3::NEG_Z, 0.3, 32);
        let brightest = |response| {
            let mut renderer = renderer(response);
            renderer.render(&sphere.mesh()).data().iter().copied().fold(0.0, f32::max)
        };
        assert!((1.3..1.471).contains(&brightest(FrameResponse::Linear)));
        assert!((brightest(FrameResponse::Clipped) - 1.0).abs() < 1e-6);
        assert!((brightest(FrameResponse::Rgb8) - 1.0).abs() < 1e-6);
    }

    #[test]
    fn a_hundredth_of_the_light_is_the_same_frame_a_hundred_times_darker() {
        let sphere = Shape::sphere(Vec3::NEG_Z, 0.3, 24);
        let mut usual = renderer(FrameResponse::Clipped);
        let mut dim = renderer_at(FrameResponse::Clipped, 0.01);
        let near = |a: f32, b: f32| (a - b).abs() <= 1e-6 * b.abs();
        let frames = (usual.render(&sphere.mesh()).clone(), dim.render(&sphere.mesh()).clone());
        for (usual, dim) in frames.0.data().iter().zip(frames.1.data()) {
            assert!(near(*dim, 0.01 * usual), "{dim} of {usual}");
        }
        let colours = (usual.render_rgb(&sphere.mesh()), dim.render_rgb(&sphere.mesh()));
        for (usual, dim) in colours.0.data().iter().zip(colours.1.data()) {
            assert!(near(dim.y, 0.01 * usual.y), "{dim} of {usual}");
        }
    }

    #[test]
    fn a_hand_that_left_leaves_the_backdrop_as_it_was() {
        let mut renderer = renderer(FrameResponse::Clipped);
        let covers = |mesh: &Mesh<'_>, renderer: &mut Renderer| {
            renderer.render(mesh).data().iter().any(|&y| (y - BEHIND).abs() > 1e-6)
        };
        let here = Shape::sphere(Vec3::NEG_Z, 0.2, 12);
        for away in [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z] {
            assert!(covers(&here.mesh(), &mut renderer));
            let gone = Shape::sphere(Vec3::NEG_Z + 9.0 * away, 0.2, 12);
            assert!(!covers(&gone.mesh(), &mut renderer), "{away}");
        }
        assert!(!covers(&Shape::default().mesh(), &mut renderer), "nothing at all");
    }
}
