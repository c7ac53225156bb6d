//! Time of the rasteriser alone, compared with a plain loop, on the same posed mesh and one core.

use std::hint::black_box;
use std::time::Instant;

use evpose_body::{BodyModel, BodyPose, PosedBody};
use evpose_core::{CounterRng, SensorSize};
use evpose_sim::SimulationConfig;
use evpose_sim::raster::{Camera, Mesh, Raster, is_closed};
use glam::{Mat4, Vec3, Vec4};
use serde::Serialize;

use evpose_core::stats::quantile::nearest_rank;

/// Renderings of one measurement: the hand turns a little in each.
const POSES: usize = 32;
const ROUNDS: usize = 30;

/// One rasteriser's median.
#[derive(Debug, Serialize)]
pub(super) struct RasterTime {
    pub(super) name: &'static str,
    pub(super) median_us: f64,
    /// Its time over ours.
    pub(super) ratio: f64,
    /// Pixels it covered on average: all draw the same image.
    pub(super) covered: f64,
}

/// Every rasteriser at hand on `model`, ours first. Rounds alternate, so that all see the same
/// machine.
pub(super) fn measure(config: &SimulationConfig, model: &BodyModel) -> Vec<RasterTime> {
    let camera = config.camera();
    let views = poses(model);
    let mut contestants: Vec<(&'static str, Box<dyn Draw + '_>)> = vec![
        ("evpose", Box::new(Ours::new(camera, model))),
        ("plain scalar loop", Box::new(Plain::new(camera, model))),
    ];
    let mut times_us = vec![Vec::new(); contestants.len()];
    let mut covered = vec![0; contestants.len()];
    for round in 0..=ROUNDS {
        for (who, (_, contestant)) in contestants.iter_mut().enumerate() {
            let begin = Instant::now();
            for vertices_m in &views {
                contestant.draw(vertices_m);
            }
            let us = begin.elapsed().as_secs_f64() * 1e6 / POSES as f64;
            // The first round warms up.
            if round > 0 {
                times_us[who].push(us);
            } else {
                // Counting draws every pose once more, and must not disturb a timed round.
                covered[who] = views
                    .iter()
                    .map(|vertices_m| {
                        contestant.draw(vertices_m);
                        contestant.covered()
                    })
                    .sum();
            }
        }
    }
    let medians: Vec<f64> = times_us
        .iter_mut()
        .map(|times_us| {
            times_us.sort_by(f64::total_cmp);
            nearest_rank(times_us, 0.5)
        })
        .collect();
    contestants
        .iter()
        .enumerate()
        .map(|(who, (name, _))| RasterTime {
            name,
            median_us: medians[who],
            ratio: medians[who] / medians[0],
            covered: covered[who] as f64 / POSES as f64,
        })
        .collect()
}

/// Something that finds the nearest face of every pixel.
trait Draw {
    /// Draws a frame into a cleared buffer.
    fn draw(&mut self, vertices_m: &[Vec3]);
    /// Pixels of the last frame that see the mesh.
    fn covered(&self) -> usize;
}

/// Vertices of the hand in poses around the middle of the published distribution.
fn poses(model: &BodyModel) -> Vec<Vec<Vec3>> {
    let shaped = model.shaped(&[]);
    // Of a fixed seed: runs of all versions draw the same frames.
    let mut rng = CounterRng::new(1, "bench poses", 0);
    (0..POSES)
        .map(|_| {
            let hand = evpose_pose::HandParams {
                articulation: std::array::from_fn(|_| rng.uniform(-1.0, 1.0)),
                ..Default::default()
            };
            let pose = BodyPose::for_playback(model, &hand);
            let mut posed = PosedBody::default();
            model.pose(&shaped, &pose, &mut posed);
            posed.vertices_m
        })
        .collect()
}

struct Ours<'a> {
    camera: Camera,
    model: &'a BodyModel,
    closed: bool,
    raster: Raster,
}

impl<'a> Ours<'a> {
    fn new(camera: Camera, model: &'a BodyModel) -> Self {
        let (closed, raster) = (is_closed(&model.faces), Raster::new(camera.sensor()));
        Self { camera, model, closed, raster }
    }
}

impl Draw for Ours<'_> {
    fn draw(&mut self, vertices_m: &[Vec3]) {
        let faces = &self.model.faces;
        let mesh = Mesh { vertices_m, normals: &[], uvs: &[], faces };
        black_box(self.raster.draw(&self.camera, &mesh, self.closed));
    }

    fn covered(&self) -> usize {
        self.raster.covered()
    }
}

/// The straightforward rasteriser: project, cull, walk the bounding box with edge functions in
/// `f32`, compare depths, keep the number of the face.
struct Plain<'a> {
    projection: Mat4,
    size: SensorSize,
    model: &'a BodyModel,
    screen: Vec<Vec3>,
    faces: Vec<u32>,
    depth: Vec<f32>,
}

impl<'a> Plain<'a> {
    fn new(camera: Camera, model: &'a BodyModel) -> Self {
        let size = camera.sensor();
        Self {
            projection: clip_from_world(&camera),
            size,
            model,
            screen: Vec::new(),
            faces: vec![u32::MAX; size.pixels()],
            depth: vec![0.0; size.pixels()],
        }
    }
}

impl Draw for Plain<'_> {
    fn draw(&mut self, vertices_m: &[Vec3]) {
        let (width, height) = (f32::from(self.size.width), f32::from(self.size.height));
        self.faces.fill(u32::MAX);
        // The value 0 is 1/w of an infinitely far point, and everything is nearer.
        self.depth.fill(0.0);
        self.screen.clear();
        self.screen.extend(vertices_m.iter().map(|&vertex_m| {
            let clip = self.projection * vertex_m.extend(1.0);
            let inverse = 1.0 / clip.w;
            Vec3::new(
                (clip.x * inverse + 1.0) * 0.5 * width,
                (1.0 - clip.y * inverse) * 0.5 * height,
                // 1/w is linear in the image, so that it can be interpolated as depth.
                inverse,
            )
        }));
        for (number, face) in self.model.faces.iter().enumerate() {
            let [a, b, c] = face.map(|v| self.screen[v as usize]);
            let edge = |p: Vec3, q: Vec3, x: f32, y: f32| {
                (q.x - p.x) * (y - p.y) - (q.y - p.y) * (x - p.x)
            };
            let area = edge(a, b, c.x, c.y);
            // It faces away.
            if area >= 0.0 {
                continue;
            }
            // Corners may lie outside of the image.
            let least = a.min(b).min(c).max(Vec3::ZERO);
            let most = a.max(b).max(c);
            let right = (most.x.ceil().max(0.0) as usize).min(usize::from(self.size.width));
            let bottom = (most.y.ceil().max(0.0) as usize).min(usize::from(self.size.height));
            for y in least.y as usize..bottom {
                for x in least.x as usize..right {
                    let (px, py) = (x as f32 + 0.5, y as f32 + 0.5);
                    let (wa, wb, wc) = (edge(b, c, px, py), edge(c, a, px, py), edge(a, b, px, py));
                    if wa <= 0.0 && wb <= 0.0 && wc <= 0.0 {
                        let depth = (wa * a.z + wb * b.z + wc * c.z) / area;
                        let pixel = y * usize::from(self.size.width) + x;
                        // Larger 1/w is nearer.
                        if depth > self.depth[pixel] {
                            self.depth[pixel] = depth;
                            self.faces[pixel] = number as u32;
                        }
                    }
                }
            }
        }
        black_box(&self.faces);
    }

    fn covered(&self) -> usize {
        self.faces.iter().filter(|&&face| face != u32::MAX).count()
    }
}

/// OpenGL's clip coordinates.
fn clip_from_world(camera: &Camera) -> Mat4 {
    let (near, far) = (camera.near_m(), 10.0);
    let pinhole = camera.pinhole();
    let (width, height) = (f32::from(camera.sensor().width), f32::from(camera.sensor().height));
    let clip_from_camera = Mat4::from_cols(
        Vec4::new(2.0 * pinhole.focal_px / width, 0.0, 0.0, 0.0),
        Vec4::new(0.0, 2.0 * pinhole.focal_px / height, 0.0, 0.0),
        Vec4::new(0.0, 0.0, (far + near) / (near - far), -1.0),
        Vec4::new(0.0, 0.0, 2.0 * far * near / (near - far), 0.0),
    );
    clip_from_camera * camera.camera_from_world()
}
