//! The visibility pass: from a mesh to the triangle that each pixel sees.

use evpose_core::{LANES, LaneWork, Lanes, Plane, SensorSize, in_lanes};
use glam::Vec3;

use super::clip::{Corner, clip_to_near_plane};
use super::project::{ScreenVertex, project};
use super::triangle::{SetUp, Triangle, may_cover};
use super::visibility::{Fill, Visibility};
use super::{Camera, Fragment, Mesh, PixelRect};

/// Scratch memory and result of the visibility pass.
#[derive(Debug, Clone)]
pub struct Raster {
    sensor: SensorSize,
    visibility: Visibility,
    /// The vertices of the mesh, and behind them those that clipping made.
    pub(super) screen: Vec<ScreenVertex>,
    /// Barycentric coordinates, in their faces, of the vertices that clipping made.
    pub(super) cuts: Vec<Cut>,
    pub(super) triangles: Vec<Triangle>,
    /// Faces that may be seen.
    candidates: Vec<u32>,
    rect: PixelRect,
}

/// A vertex that clipping made.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Cut {
    pub(super) face: u32,
    pub(super) in_face: Vec3,
}

/// A pixel and the triangle it sees.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct SeenPixel {
    pub(crate) x: u16,
    pub(crate) y: u16,
    pub(crate) triangle: u32,
}

impl Raster {
    /// A raster that sees nothing yet.
    pub fn new(sensor: SensorSize) -> Self {
        Self {
            sensor,
            visibility: Visibility::new(usize::from(sensor.width), usize::from(sensor.height)),
            screen: Vec::new(),
            cuts: Vec::new(),
            triangles: Vec::new(),
            candidates: Vec::new(),
            rect: PixelRect::EMPTY,
        }
    }

    /// Draws `mesh` alone: what was drawn before is forgotten. Returns the rectangle outside which
    /// nothing is covered.
    ///
    /// With `closed` (see [`is_closed`](super::is_closed)) the faces that look away are skipped
    /// where that cannot show: when the near plane cuts nothing open.
    ///
    /// # Panics
    /// If the camera's image is not the size this raster was made for, or a face names a vertex
    /// that the mesh does not have.
    pub fn draw(&mut self, camera: &Camera, mesh: &Mesh<'_>, closed: bool) -> PixelRect {
        assert!(camera.sensor() == self.sensor, "a raster made for another image size");
        self.visibility.clear(self.rect);
        self.triangles.clear();
        self.cuts.clear();
        let extent = project(camera, mesh.vertices_m, &mut self.screen);
        self.rect = extent.rect;
        if !self.rect.is_empty() {
            let cull = closed && extent.wholly_in_front;
            self.find_candidates(mesh.faces, cull);
            in_lanes(DrawFaces { raster: self, faces: mesh.faces, cull });
            if !extent.wholly_in_front {
                self.draw_cut_faces(camera, mesh);
            }
        }
        self.rect
    }

    /// Lists the faces wholly in front of the near plane that may be seen. Without a branch: which
    /// they are is hard to foresee.
    fn find_candidates(&mut self, faces: &[[u32; 3]], cull: bool) {
        self.candidates.resize(faces.len(), 0);
        let mut count = 0;
        for (face, &[a, b, c]) in faces.iter().enumerate() {
            let [a, b, c] =
                [self.screen[a as usize], self.screen[b as usize], self.screen[c as usize]];
            let is_seen =
                (a.inverse_depth > 0.0) & (b.inverse_depth > 0.0) & (c.inverse_depth > 0.0);
            self.candidates[count] = face as u32;
            count += usize::from(is_seen & may_cover(a, b, c, cull));
        }
        self.candidates.truncate(count);
    }

    /// The parts of faces that the near plane leaves.
    fn draw_cut_faces(&mut self, camera: &Camera, mesh: &Mesh<'_>) {
        let whole = PixelRect::whole(self.sensor);
        for (face, corners) in mesh.faces.iter().enumerate() {
            let hidden =
                corners.iter().filter(|&&v| self.screen[v as usize].inverse_depth <= 0.0).count();
            if hidden == 0 || hidden == 3 {
                continue;
            }
            let face = face as u32;
            let corners_m = corners.map(|v| mesh.vertices_m[v as usize]);
            clip_to_near_plane(camera, corners_m, |part| {
                let first = self.screen.len() as u32;
                self.screen.extend(part.map(|Corner { on_screen, .. }| on_screen));
                self.cuts.extend(part.map(|Corner { in_face, .. }| Cut { face, in_face }));
                let corners = [first, first + 1, first + 2];
                let on_screen = part.map(|Corner { on_screen, .. }| on_screen);
                if let Some(set_up) = SetUp::new(face, corners, on_screen, false, whole) {
                    let number = self.triangles.len() as u32;
                    let visibility = &mut self.visibility;
                    in_lanes(Fill { visibility, set_up: &set_up, number });
                    self.triangles.push(set_up.triangle);
                }
            });
        }
    }

    /// The rectangle outside which nothing is covered.
    pub fn rect(&self) -> PixelRect {
        self.rect
    }

    /// Pixels that see a surface.
    pub fn covered(&self) -> usize {
        let rows = self.rect.top..self.rect.bottom;
        rows.flat_map(|y| self.visibility.row(y, self.rect).0).filter(|&&bits| bits > 0).count()
    }

    /// Lists the pixels that see a surface, row by row, at the beginning of `out`. Gives their number.
    pub(crate) fn seen_pixels(&self, out: &mut Vec<SeenPixel>) -> usize {
        let pixels = usize::from(self.sensor.width) * usize::from(self.sensor.height);
        out.resize(pixels, SeenPixel::default());
        let mut count = 0;
        for y in self.rect.top..self.rect.bottom {
            let (inverse_depth, triangles) = self.visibility.row(y, self.rect);
            let chunks = inverse_depth.chunks(LANES).zip(triangles.chunks(LANES));
            for (chunk, (inverse_depth, triangles)) in chunks.enumerate() {
                if inverse_depth.iter().fold(0, |any, bits| any | bits) == 0 {
                    continue;
                }
                let first = self.rect.left + chunk * LANES;
                for (k, (&bits, &triangle)) in inverse_depth.iter().zip(triangles).enumerate() {
                    let (x, triangle) = ((first + k) as u16, triangle as u32);
                    out[count] = SeenPixel { x, y: y as u16, triangle };
                    count += usize::from(bits > 0);
                }
            }
        }
        count
    }

    /// What each pixel sees.
    pub fn fragments(&self, mesh: &Mesh<'_>) -> Plane<Fragment> {
        let mut fragments = Plane::for_sensor(self.sensor, Fragment::NONE);
        let mut seen = Vec::new();
        let count = self.seen_pixels(&mut seen);
        for pixel in &seen[..count] {
            let (x, y) = (usize::from(pixel.x), usize::from(pixel.y));
            *fragments.at_mut(x, y) = self.fragment(mesh, x, y, pixel.triangle);
        }
        fragments
    }

    fn fragment(&self, mesh: &Mesh<'_>, x: usize, y: usize, triangle: u32) -> Fragment {
        let triangle = &self.triangles[triangle as usize];
        let [second, third] = triangle.affine(x, y);
        let weights = [1.0 - second - third, second, third];
        let (mut inverse_depth, mut in_face) = (0.0, Vec3::ZERO);
        for (&corner, weight) in triangle.corners.iter().zip(weights) {
            let corner = corner as usize;
            let weight = weight * self.screen[corner].inverse_depth;
            inverse_depth += weight;
            in_face += weight
                * match corner.checked_sub(mesh.vertices_m.len()) {
                    Some(cut) => self.cuts[cut].in_face,
                    None => {
                        let face = mesh.faces[triangle.face as usize];
                        let is_at = face.map(|v| if v as usize == corner { 1.0 } else { 0.0 });
                        Vec3::from_array(is_at)
                    }
                };
        }
        in_face /= inverse_depth;
        Fragment { inverse_depth, face: triangle.face, barycentric: [in_face.y, in_face.z] }
    }
}

/// The faces that are wholly in front of the near plane.
struct DrawFaces<'a> {
    raster: &'a mut Raster,
    faces: &'a [[u32; 3]],
    cull: bool,
}

impl LaneWork for DrawFaces<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) {
        let Raster { sensor, visibility, screen, triangles, candidates, .. } = self.raster;
        let whole = PixelRect::whole(*sensor);
        for &face in candidates.iter() {
            let corners = self.faces[face as usize];
            let [a, b, c] = corners;
            let on_screen = [screen[a as usize], screen[b as usize], screen[c as usize]];
            if let Some(set_up) = SetUp::new(face, corners, on_screen, self.cull, whole) {
                visibility.fill(l, &set_up, triangles.len() as u32);
                triangles.push(set_up.triangle);
            }
        }
    }
}
