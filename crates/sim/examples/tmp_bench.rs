#![allow(missing_docs, clippy::all, clippy::print_stdout, reason="temporary")]
use evpose_core::*;
use evpose_sim::{raster::*, scene::*, texture::*};
use glam::*;
use std::time::Instant;
fn main() {
    for (w, h) in [(120u16, 90u16), (240, 180)] {
        let sensor = SensorSize { width: w, height: h };
        let placement = LookAt { eye_m: Vec3::new(0.0, 0.0, 1.0), centre_m: Vec3::ZERO, up: Vec3::Y };
        let camera = Camera::new(sensor, Pinhole::from_vertical_fov(sensor, 45.0), &placement, 0.1);
        let (bands, around) = (35usize, 70usize);
        let (mut v, mut n, mut uv, mut f) = (vec![], vec![], vec![], vec![]);
        for b in 0..=bands { for s in 0..around {
            let p = std::f32::consts::PI * b as f32 / bands as f32; let a = std::f32::consts::TAU * s as f32 / around as f32;
            let d = Vec3::new(p.sin()*a.sin(), p.cos(), p.sin()*a.cos());
            v.push(d * Vec3::new(0.3, 0.15, 0.2)); n.push(d); uv.push(Vec2::new(s as f32/around as f32, b as f32 / bands as f32));
        } }
        let at = |b: usize, s: usize| (b*around + if b==0||b==bands {0} else {s%around}) as u32;
        for b in 0..bands { for s in 0..around { let q=[at(b,s),at(b+1,s),at(b+1,s+1),at(b,s+1)];
            for t in [[q[0],q[1],q[2]],[q[0],q[2],q[3]]] { if t[0]!=t[1]&&t[1]!=t[2]&&t[0]!=t[2] { f.push(t); } } } }
        let closed = is_closed(&f);
        let img: Vec<u8> = (0..512*512*3).map(|i| (i * 7919 % 251) as u8).collect();
        let skin = Texture::from_rgb8(512, 512, &img).unwrap();
        let l = |d: Vec3A, c| DirectionalLight { direction: d.normalize(), colour: c };
        let lighting = Lighting { lights: [l(Vec3A::new(1.,1.,1.), Vec3A::new(1.,0.7,0.5)), l(Vec3A::new(-1.,1.,0.), Vec3A::new(0.15,0.2,0.3))], ambient: Vec3A::splat(0.05), gain: 1.4 };
        let scene = Scene { camera, lighting, skin, backdrop: Backdrop::uniform(sensor, Vec3A::splat(0.3)), response: FrameResponse::Clipped };
        let mut r = Renderer::new(scene, closed);
        let mut raster = Raster::new(sensor);
        let mesh = Mesh { vertices_m: &v, normals: &n, uvs: &uv, faces: &f };
        let mut best = f64::MAX; let mut best_r = f64::MAX;
        for _ in 0..20 {
            let t = Instant::now();
            for _ in 0..100 { r.render(&mesh); }
            best = best.min(t.elapsed().as_secs_f64() / 100.0);
            let t = Instant::now();
            for _ in 0..100 { raster.draw(&r.scene().camera, &mesh, closed); }
            best_r = best_r.min(t.elapsed().as_secs_f64() / 100.0);
        }
        let cov = r.fragments().data().iter().filter(|f| f.is_covered()).count();
        println!("{w}x{h} V {} F {} closed {closed} covered {cov} render {:.1} us, visibility {:.1} us", v.len(), f.len(), best*1e6, best_r*1e6);
    }
}
