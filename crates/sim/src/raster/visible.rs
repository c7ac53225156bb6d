//! The visibility pass: from a mesh to the nearest triangle of each pixel.

use evpose_core::{Plane, SensorSize};
use evpose_cpu::{Kernel8, LANES_8, Lanes8, dispatch};
use glam::Vec3;

use super::clip::{Corner, clip_to_near_plane};
use super::narrow::{Eight, EightCorners};
use super::project::{ScreenVertex, project};
use super::triangle::Triangle;
use super::visibility::VisibilityBuffer;
use super::wide::Wide;
use super::{Camera, Fragment, Mesh, PixelRect};

/// Scratch memory and result of the visibility pass.
#[derive(Debug, Clone)]
pub struct Raster {
    pub(super) sensor: SensorSize,
    pub(super) visibility: VisibilityBuffer,
    /// The vertices of the mesh, and behind them those that clipping made.
    pub(super) screen: Vec<ScreenVertex>,
    /// Barycentric coordinates, in their faces, of the vertices that clipping made.
    pub(super) cuts: Vec<Cut>,
    /// The triangles of this frame, and behind them what is left of others.
    pub(super) triangles: Vec<Triangle>,
    count: usize,
    pub(super) rect: PixelRect,
}

/// A vertex that clipping made.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Cut {
    pub(super) face: u32,
    pub(super) in_face: Vec3,
}

impl Raster {
    /// An empty raster.
    pub fn new(sensor: SensorSize) -> Self {
        Self {
            sensor,
            visibility: VisibilityBuffer::new(
                usize::from(sensor.width),
                usize::from(sensor.height),
            ),
            screen: Vec::new(),
            cuts: Vec::new(),
            triangles: Vec::new(),
            count: 0,
            rect: PixelRect::EMPTY,
        }
    }

    /// Draws `mesh` into a cleared raster. Returns the rectangle outside which
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
        self.count = 0;
        self.cuts.clear();
        let extent = project(camera, mesh.vertices_m, &mut self.screen);
        self.rect = extent.rect;
        if !self.rect.is_empty() {
            // Cut open by the near plane, a closed mesh shows its inside.
            let cull = closed && extent.wholly_in_front;
            dispatch(DrawFaces { raster: self, faces: mesh.faces, cull });
            if !extent.wholly_in_front {
                self.draw_cut_faces(camera, mesh);
            }
        }
        self.rect
    }

    /// The parts of faces that the near plane leaves.
    fn draw_cut_faces(&mut self, camera: &Camera, mesh: &Mesh<'_>) {
        let whole = PixelRect::whole(self.sensor);
        for (face, corners) in mesh.faces.iter().enumerate() {
            // An inverse depth of zero marks a vertex behind the near plane.
            let hidden =
                corners.iter().filter(|&&v| self.screen[v as usize].inverse_depth() <= 0.0).count();
            // Whole faces are drawn already; those behind the plane are never seen.
            if hidden == 0 || hidden == 3 {
                continue;
            }
            let face = face as u32;
            let corners_m = corners.map(|v| mesh.vertices_m[v as usize]);
            clip_to_near_plane(camera, corners_m, |part| {
                // Corners of a cut are vertices of their own, numbered behind those of the mesh.
                let first = self.screen.len() as u32;
                self.screen.extend(part.map(|Corner { on_screen, .. }| on_screen));
                self.cuts.extend(part.map(|Corner { in_face, .. }| Cut { face, in_face }));
                let corners = [first, first + 1, first + 2];
                let on_screen = part.map(|Corner { on_screen, .. }| on_screen);
                if let Some(set_up) = Wide::new(face, corners, on_screen, false, whole) {
                    self.visibility.fill_wide(&set_up, self.count as u32);
                    // Triangles behind the count are left over from an earlier frame.
                    self.triangles.truncate(self.count);
                    self.triangles.push(set_up.triangle);
                    self.count += 1;
                }
            });
        }
    }

    /// The rectangle outside which nothing is covered.
    pub fn rect(&self) -> PixelRect {
        self.rect
    }

    /// Number of covered pixels.
    pub fn covered(&self) -> usize {
        let rows = self.rect.top..self.rect.bottom;
        rows.flat_map(|y| self.visibility.row(y, self.rect).0).filter(|&&bits| bits > 0).count()
    }

    /// Visible surface of each pixel.
    pub fn fragments(&self, mesh: &Mesh<'_>) -> Plane<Fragment> {
        let mut fragments = Plane::for_sensor(self.sensor, Fragment::NONE);
        for y in self.rect.top..self.rect.bottom {
            let (inverse_depth, triangles) = self.visibility.row(y, self.rect);
            let pixels = (self.rect.left..).zip(inverse_depth.iter().zip(triangles));
            for (x, (_, &triangle)) in pixels.filter(|(_, (bits, _))| **bits > 0) {
                *fragments.at_mut(x, y) = self.fragment(mesh, x, y, triangle);
            }
        }
        fragments
    }

    fn fragment(&self, mesh: &Mesh<'_>, x: usize, y: usize, triangle: i32) -> Fragment {
        let triangle = &self.triangles[triangle as usize];
        let [second, third] = triangle.affine(x, y);
        let weights = [1.0 - second - third, second, third];
        let (mut inverse_depth, mut in_face) = (0.0, Vec3::ZERO);
        for (&corner, weight) in triangle.corners.iter().zip(weights) {
            let corner = corner as usize;
            let weight = weight * self.screen[corner].inverse_depth();
            inverse_depth += weight;
            in_face += weight
                // Beyond the mesh's vertices are those of cuts, which know their place.
                * match corner.checked_sub(mesh.vertices_m.len()) {
                    Some(cut) => self.cuts[cut].in_face,
                    None => {
                        let face = mesh.faces[triangle.face as usize];
                        let is_at = face.map(|v| if v as usize == corner { 1.0 } else { 0.0 });
                        Vec3::from_array(is_at)
                    }
                };
        }
        // Weights were divided by depth, as perspective asks for: their sum takes that out again.
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

impl Kernel8 for DrawFaces<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes8>(self, l: L) {
        let Raster { sensor, visibility, screen, triangles, count, .. } = self.raster;
        let (whole, cull) = (PixelRect::whole(*sensor), self.cull);
        let mut eight = Eight::default();
        for (batch, faces) in self.faces.chunks(LANES_8).enumerate() {
            // The last batch is padded with its first face.
            let padded;
            let faces = match faces.first_chunk() {
                Some(faces) => faces,
                None => {
                    padded = std::array::from_fn(|k| *faces.get(k).unwrap_or(&faces[0]));
                    &padded
                }
            };
            let known = self.faces.len() - batch * LANES_8;
            let known = if known < LANES_8 { (1 << known) - 1 } else { u32::MAX };
            if triangles.len() < *count + LANES_8 {
                triangles.resize(*count + LANES_8, Triangle::default());
            }
            let corners =
                [corners(screen, faces, 0), corners(screen, faces, 1), corners(screen, faces, 2)];
            eight.set_up(l, corners, cull, whole);
            // In the order of the faces, which decides between equal depths.
            let mut left = (eight.may_cover | eight.is_wide) & known;
            while left != 0 {
                let (k, bit) =
                    (left.trailing_zeros() as usize % LANES_8, left & left.wrapping_neg());
                left ^= bit;
                let (face, [a, b, c]) = ((batch * LANES_8 + k) as u32, faces[k]);
                let number = *count as u32;
                if eight.is_wide & bit == 0 {
                    visibility.fill(l, &eight, k, number);
                    let corners = if eight.is_turned & bit == 0 { [a, b, c] } else { [a, c, b] };
                    // Field by field: a struct expression would be built on the stack and copied.
                    let triangle = &mut triangles[*count];
                    triangle.second = eight.second[k];
                    triangle.third = eight.third[k];
                    triangle.corners = corners;
                    triangle.face = face;
                    *count += 1;
                } else {
                    let on_screen = [a, b, c].map(|v| screen[v as usize]);
                    if let Some(set_up) = Wide::new(face, [a, b, c], on_screen, cull, whole) {
                        visibility.fill_wide(&set_up, number);
                        triangles[*count] = set_up.triangle;
                        *count += 1;
                    }
                }
            }
        }
    }
}

#[inline(always)]
fn corners<'a>(
    screen: &'a [ScreenVertex],
    faces: &[[u32; 3]; LANES_8],
    i: usize,
) -> EightCorners<'a> {
    // Spelled out: a map would go through memory.
    let [a, b, c, d, e, f, g, h] = faces;
    [
        corner(screen, a[i]),
        corner(screen, b[i]),
        corner(screen, c[i]),
        corner(screen, d[i]),
        corner(screen, e[i]),
        corner(screen, f[i]),
        corner(screen, g[i]),
        corner(screen, h[i]),
    ]
}

#[inline(always)]
fn corner(screen: &[ScreenVertex], vertex: u32) -> &[i32; 4] {
    screen[vertex as usize].row()
}
