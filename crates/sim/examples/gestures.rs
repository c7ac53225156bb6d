//! All gestures of the procedural hand on one sheet, from the palm and from beside the thumb, in the order of their table:
//!
//! ```console
//! $ cargo run -p evpose-sim --example gestures -- gestures.png
//! ```
//!
//! With a number behind the name of the image, as somebody makes them who takes little care: the seed.

use std::error::Error;

use evpose_body::fingers::{FingerAxes, GESTURES};
use evpose_body::{BodyModel, BodyPose, PosedBody};
use evpose_core::{CounterRng, LookAt, Pinhole, SensorSize};
use evpose_pose::HandSide;
use evpose_sim::raster::{Camera, Mesh};
use evpose_sim::scene::{Backdrop, DirectionalLight, FrameResponse, Lighting, Renderer, Scene};
use evpose_sim::texture::Texture;
use glam::{Vec3, Vec3A};
use image::{Rgb, RgbImage};

const SIDE_PX: u16 = 150;
const COLUMNS: usize = 8;
/// From where the hand is seen, in metres from its middle: below the palm, and below and beside the thumb.
const EYES_M: [Vec3; 2] = [Vec3::new(0.0, -0.5, 0.0), Vec3::new(-0.15, -0.35, 0.32)];
/// From the wrist to the middle of the hand; fingers point along -x.
const MIDDLE_M: Vec3 = Vec3::new(-0.09, -0.02, 0.01);

fn renderer(eye_m: Vec3, centre_m: Vec3) -> Result<Renderer, Box<dyn Error>> {
    let sensor = SensorSize { width: SIDE_PX, height: SIDE_PX };
    let placement = LookAt { eye_m: centre_m + eye_m, centre_m, up: Vec3::NEG_X };
    let towards = |at: Vec3, colour: f32| DirectionalLight {
        direction: Vec3A::from(at.normalize()),
        colour: Vec3A::splat(colour),
    };
    let lights = [towards(eye_m + Vec3::NEG_X * 0.4, 0.6), towards(Vec3::new(0.3, -0.2, 1.0), 0.4)];
    let scene = Scene {
        camera: Camera::new(sensor, Pinhole::from_vertical_fov(sensor, 27.0), &placement, 0.1),
        lighting: Lighting { lights, ambient: Vec3A::splat(0.03), gain: 1.0 },
        skin: Texture::from_rgb8(1, 1, &[235, 190, 165]).ok_or("no texture")?,
        backdrop: Backdrop::uniform(sensor, Vec3A::splat(0.02)),
        response: FrameResponse::Clipped,
    };
    Ok(Renderer::new(scene, true, 1.0))
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let path = arguments.next().ok_or("the name of an image is expected: gestures.png")?;
    let seed: Option<u64> = arguments.next().map(|seed| seed.parse()).transpose()?;
    let model = BodyModel::procedural_arm();
    let shaped = model.shaped(&[]);
    let axes = FingerAxes::new(&model, &shaped, HandSide::Right);
    let side = u32::from(SIDE_PX);
    let rows = GESTURES.len().div_ceil(COLUMNS) as u32;
    let mut sheet = RgbImage::new(side * COLUMNS as u32, side * EYES_M.len() as u32 * rows);
    let middle_m = shaped.joints_m[model.wrist] + MIDDLE_M;
    let mut renderers =
        EYES_M.iter().map(|&eye| renderer(eye, middle_m)).collect::<Result<Vec<_>, _>>()?;
    let mut body = PosedBody::default();
    for (number, gesture) in GESTURES.iter().enumerate() {
        let mut angles = gesture.angles();
        if let Some(seed) = seed {
            angles = angles.varied(1.5, &mut CounterRng::new(seed, gesture.name, 0));
        }
        let mut pose = BodyPose::rest(&model);
        pose.set_hand_rotations(&model.right_hand, &axes.rotations(&angles));
        model.pose(&shaped, &pose, &mut body);
        let mesh = Mesh {
            vertices_m: &body.vertices_m,
            normals: &body.normals,
            uvs: &model.uvs,
            faces: &model.faces,
        };
        for (view, renderer) in renderers.iter_mut().enumerate() {
            let light = renderer.render(&mesh);
            let left = side * (number % COLUMNS) as u32;
            let top = side * (EYES_M.len() * (number / COLUMNS) + view) as u32;
            for (y, x) in (0..side).flat_map(|y| (0..side).map(move |x| (y, x))) {
                let grey = light.at(x as usize, y as usize).clamp(0.0, 1.0).powf(1.0 / 2.2);
                sheet.put_pixel(left + x, top + y, Rgb([(255.0 * grey) as u8; 3]));
            }
        }
    }
    Ok(sheet.save(path)?)
}
