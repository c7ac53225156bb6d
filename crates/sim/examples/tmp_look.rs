#![allow(missing_docs, clippy::all, clippy::print_stdout, reason="temporary")]
use evpose_core::*; use evpose_sim::{*, raster::*, scene::*, texture::*}; use evpose_body::*; use glam::*; use std::time::Instant;
use image::{RgbImage, Rgb};
fn main() {
    let body = BodyModel::procedural_arm();
    let (w, h) = (400u16, 300u16);
    let mut sheet = RgbImage::new(w as u32 * 4, h as u32 * 5);
    let poses: [[f32; 6]; 5] = [[0.0; 6], [2.0, 0., 0., 0., 0., 0.], [-2.0, 0., 0., 0., 0., 0.], [0., 2.0, -1.5, 1., 0., 0.], [1.0, -2.0, 1.5, 0., 1., -1.]];
    for (r, art) in poses.iter().enumerate() {
        let mut rng = CounterRng::new(r as u64, "look", 0);
        let betas: Vec<f32> = (0..body.shape_directions_m.len()).map(|_| if r == 0 {0.} else {rng.uniform(-2., 2.)}).collect();
        let shaped = body.shaped(&betas);
        let mut pose = BodyPose::rest(&body); pose.set_hand(&body.right_hand, art);
        let mut posed = PosedBody::default(); body.pose(&shaped, &pose, &mut posed);
        let wrist: Vec3 = posed.joints[body.wrist].translation.into();
        let centre = wrist + Vec3::new(-0.09, 0.0, 0.0);
        let skin = if r == 0 { SkinCoefficients::default() } else { SkinCoefficients::draw(&mut rng, 2.0) };
        for (k, dir) in [Vec3::new(-0.2, 1.0, 0.1), Vec3::new(-0.2, -1.0, 0.1), Vec3::new(-0.1, 0.1, 1.0), Vec3::new(-1.0, 0.3, 0.5)].into_iter().enumerate() {
            let sensor = SensorSize { width: w, height: h };
            let up = if k < 2 { Vec3::Z } else { Vec3::Y };
            let camera = Camera::new(sensor, Pinhole::from_vertical_fov(sensor, 45.0), &LookAt { eye_m: centre + dir.normalize() * 0.33, centre_m: centre, up }, 0.05);
            let mut lighting = config::LightConfig { random: false, ..Default::default() }.draw(&mut rng);
            lighting.lights[0].direction = (Vec3A::from(dir) + Vec3A::new(-0.6, 0.6, 0.3)).normalize();
            let scene = Scene { camera, lighting, skin: paint_skin(512, &skin, &mut CounterRng::new(r as u64, "m", 0)), backdrop: Backdrop::uniform(sensor, Vec3A::splat(0.1)), response: FrameResponse::Clipped };
            let mut ren = Renderer::new(scene, true);
            let p = ren.render_rgb(&Mesh { vertices_m: &posed.vertices_m, normals: &posed.normals, uvs: &body.uvs, faces: &body.faces });
            for y in 0..h as u32 { for x in 0..w as u32 { let v = p.at(x as usize, y as usize).to_array().map(|v| (v.clamp(0.,1.).powf(1./2.2)*255.) as u8); sheet.put_pixel(k as u32 * w as u32 + x, r as u32 * h as u32 + y, Rgb(v)); } }
        }
    }
    sheet.save("/tmp/sim_poses.png").unwrap();

    println!("V {} F {} closed {}", body.template_m.len(), body.faces.len(), raster::is_closed(&body.faces));
    for scale in [0.5f32, 1.0] {
        let mut c = SimulationConfig::default(); c.image_scale = scale;
        let t = Instant::now(); let simu = Simulation::new(&c, 1).unwrap(); println!("run setup {:?}", t.elapsed());
        let t = Instant::now(); let mut s = simu.sequence(0).unwrap(); println!("sequence setup {:?}", t.elapsed());
        let mut best = f64::MAX; let mut ev = 0;
        for _ in 0..20 { let n = 400; let t = Instant::now();
        for _ in 0..n { ev += s.advance().unwrap().events.len(); }
        best = best.min(t.elapsed().as_secs_f64() / n as f64); }
        println!("scale {scale}: best {:.0} steps/s, {:.1} events/step", 1.0 / best, ev as f64 / 8000.0);
    }
}
