//! The visibility pass against closed forms.

use evpose_core::{LookAt, Pinhole, SensorSize};
use evpose_cpu::{Kernel8, Lanes8, dispatch};
use glam::{Vec2, Vec3};
use proptest::prelude::*;

use super::narrow::Eight;
use super::project::ScreenVertex;
use super::visibility::VisibilityBuffer;
use super::wide::Wide;
use super::{Camera, Fragment, PixelRect, Raster, is_closed};
use crate::shapes::Shape;

const SENSOR: SensorSize = SensorSize { width: 64, height: 48 };

/// At the origin, looking along -z.
fn camera(near_m: f32) -> Camera {
    let placement = LookAt { eye_m: Vec3::ZERO, centre_m: Vec3::NEG_Z, up: Vec3::Y };
    Camera::new(SENSOR, Pinhole::from_vertical_fov(SENSOR, 45.0), &placement, near_m)
}

/// The point of the plane through `point_m` with normal `normal` that the centre of a pixel sees.
fn seen_point(x: usize, y: usize, point_m: Vec3, normal: Vec3) -> Vec3 {
    let pinhole = camera(0.1).pinhole();
    let offset = Vec2::new(x as f32 + 0.5, y as f32 + 0.5) - pinhole.principal_px;
    let ray = Vec3::new(offset.x, -offset.y, -pinhole.focal_px);
    ray * (point_m.dot(normal) / ray.dot(normal))
}

fn position(shape: &Shape, fragment: &Fragment) -> Vec3 {
    let [a, b, c] = shape.faces[fragment.face as usize].map(|i| shape.vertices_m[i as usize]);
    let [second, third] = fragment.barycentric;
    a * (1.0 - second - third) + b * second + c * third
}

/// The pixels of a triangle, which are the same whichever way it is filled.
fn fill(corners: [(i32, i32); 3]) -> Vec<bool> {
    let corners = corners.map(|(x, y)| ScreenVertex::new(x, y, 1.0));
    let whole = PixelRect::whole(SENSOR);
    let mut by_wide = VisibilityBuffer::new(whole.right, whole.bottom);
    if let Some(set_up) = Wide::new(0, [0, 1, 2], corners, false, whole) {
        by_wide.fill_wide(&set_up, 0);
    }
    let mut by_eight = VisibilityBuffer::new(whole.right, whole.bottom);
    let covered = |visibility: &VisibilityBuffer| -> Vec<bool> {
        let rows = (0..whole.bottom).flat_map(|y| visibility.row(y, whole).0.to_vec());
        rows.map(|inverse_depth| inverse_depth > 0).collect()
    };
    if dispatch(FillOne { visibility: &mut by_eight, corners, whole }) {
        assert_eq!(covered(&by_eight), covered(&by_wide), "{corners:?}");
    }
    covered(&by_wide)
}

/// A triangle set up eight times and filled once; whether it is short enough for it.
struct FillOne<'a> {
    visibility: &'a mut VisibilityBuffer,
    corners: [ScreenVertex; 3],
    whole: PixelRect,
}

impl Kernel8 for FillOne<'_> {
    type Output = bool;

    fn run<L: Lanes8>(self, l: L) -> bool {
        let mut eight = Eight::default();
        let [a, b, c] = self.corners.each_ref().map(|corner| [corner.row(); 8]);
        eight.set_up(l, [a, b, c], false, self.whole);
        assert!([0, 0xff].contains(&eight.may_cover) && [0, 0xff].contains(&eight.is_wide));
        if eight.may_cover != 0 {
            self.visibility.fill(l, &eight, 5, 0);
        }
        eight.is_wide == 0
    }
}

/// Positions that often fall on pixel centres and on each other's rows and columns.
fn corner() -> impl Strategy<Value = (i32, i32)> {
    let coordinate = |pixels: i32| {
        prop_oneof![(0..pixels).prop_map(|p| p * 256 + 128), -2_000..pixels * 256 + 2_000]
    };
    (coordinate(64), coordinate(48))
}

/// Distances that often put corners and edges on pixel centres.
fn spoke() -> impl Strategy<Value = i32> {
    prop_oneof![(1..30).prop_map(|p| p * 128), 1..6_000]
}

proptest! {
    #[test]
    fn triangles_around_a_point_cover_each_pixel_of_their_union_exactly_once(
        centre in corner(), spokes in prop::collection::vec((spoke(), spoke()), 4),
    ) {
        // One corner strictly inside each quadrant around the centre: no two neighbours are half a
        // turn apart, so the triangles do not overlap.
        let turned = |quadrant: usize, (u, v): (i32, i32)| match quadrant {
            0 => (u, -v),
            1 => (v, u),
            2 => (-u, v),
            _ => (-v, -u),
        };
        let ring: Vec<_> = spokes
            .iter()
            .enumerate()
            .map(|(i, &offset)| turned(i, offset))
            .map(|(x, y)| (centre.0 + x, centre.1 + y))
            .collect();
        let n = ring.len();
        let mut times = vec![0; SENSOR.pixels()];
        for i in 0..n {
            for (count, covered) in
                times.iter_mut().zip(fill([centre, ring[i], ring[(i + 1) % n]]))
            {
                *count += i32::from(covered);
            }
        }
        prop_assert!(times.iter().all(|&count| count <= 1));
        // The centre of the star lies inside, so a pixel centred there is covered.
        if let (px, 128) = (centre.0.div_euclid(256), centre.0.rem_euclid(256))
            && let (py, 128) = (centre.1.div_euclid(256), centre.1.rem_euclid(256))
            && (0..64).contains(&px) && (0..48).contains(&py)
        {
            prop_assert_eq!(times[py as usize * 64 + px as usize], 1);
        }
    }

    #[test]
    fn the_order_of_the_corners_does_not_change_the_pixels(
        a in corner(), b in corner(), c in corner(),
    ) {
        let once = fill([a, b, c]);
        prop_assert_eq!(&once, &fill([b, c, a]));
        prop_assert_eq!(&once, &fill([c, b, a]));
    }
}

#[test]
fn a_rectangle_with_corners_on_pixel_centres_owns_its_top_and_left_only() {
    let centre = |pixel: i32| pixel * 256 + 128;
    let (left, right, top, bottom) = (centre(3), centre(9), centre(2), centre(7));
    let upper = fill([(left, top), (right, top), (left, bottom)]);
    let lower = fill([(right, top), (right, bottom), (left, bottom)]);
    for y in 0..48 {
        for x in 0..64 {
            let times = u8::from(upper[y * 64 + x]) + u8::from(lower[y * 64 + x]);
            let inside = (3..9).contains(&x) && (2..7).contains(&y);
            assert_eq!(times, u8::from(inside), "({x}, {y})");
        }
    }
}

#[test]
fn the_nearer_surface_is_seen_whatever_is_drawn_first() {
    let near = Shape::quad(Vec3::new(-0.2, -0.2, -1.0), Vec3::X * 0.2, Vec3::Y * 0.4);
    let far = Shape::quad(Vec3::new(-0.2, -0.2, -2.0), Vec3::X * 0.4, Vec3::Y * 0.4);
    for order in [[&near, &far], [&far, &near]] {
        let mut both = order[0].clone();
        let first = both.vertices_m.len() as u32;
        both.vertices_m.extend(&order[1].vertices_m);
        both.faces.extend(order[1].faces.iter().map(|f| f.map(|i| i + first)));
        let mut raster = Raster::new(SENSOR);
        raster.draw(&camera(0.1), &both.mesh(), false);
        // Right of the axis only the far one is there.
        assert!((raster.fragments(&both.mesh()).at(30, 24).inverse_depth - 1.0).abs() < 1e-6);
        assert!((raster.fragments(&both.mesh()).at(33, 24).inverse_depth - 0.5).abs() < 1e-6);
    }
}

#[test]
fn positions_on_a_slanted_plane_are_perspective_correct() {
    let shape = Shape::quad(
        Vec3::new(-1.0, -0.8, -1.0),
        Vec3::new(3.0, 0.0, -4.0),
        Vec3::new(0.0, 2.0, -0.5),
    );
    let mut raster = Raster::new(SENSOR);
    raster.draw(&camera(0.1), &shape.mesh(), false);
    let fragments = raster.fragments(&shape.mesh());
    let mut covered = 0;
    for y in 0..48 {
        for x in 0..64 {
            let fragment = fragments.at(x, y);
            if fragment.is_covered() {
                covered += 1;
                let got = position(&shape, fragment);
                let want = seen_point(x, y, shape.vertices_m[0], shape.normals[0]);
                // Corners are snapped to 1/256 pixel: half of that at 5 m is 0.2 mm seen face on.
                assert!((got - want).length() < 4e-3, "({x}, {y}): {got} for {want}");
                assert!((fragment.inverse_depth + 1.0 / want.z).abs() < 2e-3);
            }
        }
    }
    assert!(covered > 500, "{covered}");
}

#[test]
fn a_face_through_the_near_plane_shows_its_front_part_without_distortion() {
    // A floor from behind the camera to far ahead.
    let shape = Shape::quad(Vec3::new(-9.0, -0.3, 5.0), Vec3::X * 18.0, Vec3::NEG_Z * 30.0);
    let mut raster = Raster::new(SENSOR);
    raster.draw(&camera(0.1), &shape.mesh(), true);
    let fragments = raster.fragments(&shape.mesh());
    for y in 0..48 {
        for x in 0..64 {
            let fragment = fragments.at(x, y);
            let want = seen_point(x, y, shape.vertices_m[0], Vec3::Y);
            let visible = y > 24 && want.z > -24.5 && want.x.abs() < 8.9;
            if visible {
                assert!(fragment.is_covered(), "({x}, {y})");
                let got = position(&shape, fragment);
                assert!((got - want).length() < 1e-2 * want.length(), "{got} for {want}");
            } else if y < 24 {
                assert!(!fragment.is_covered(), "sky at ({x}, {y})");
            }
        }
    }
}

#[test]
fn a_mesh_behind_the_camera_covers_nothing() {
    let shape = Shape::sphere(Vec3::Z, 0.3, 8);
    let mut raster = Raster::new(SENSOR);
    raster.draw(&camera(0.1), &shape.mesh(), true);
    assert_eq!(raster.covered(), 0);
}

#[test]
fn skipping_faces_that_look_away_changes_nothing_for_a_closed_mesh() {
    let shape = Shape::sphere(Vec3::new(0.05, 0.1, -1.0), 0.31, 24);
    assert!(is_closed(&shape.faces));
    let (mut all, mut front) = (Raster::new(SENSOR), Raster::new(SENSOR));
    all.draw(&camera(0.1), &shape.mesh(), false);
    front.draw(&camera(0.1), &shape.mesh(), true);
    let mesh = shape.mesh();
    assert_eq!(all.fragments(&mesh), front.fragments(&mesh));
}

#[test]
fn a_new_frame_forgets_the_last_one() {
    let mut raster = Raster::new(SENSOR);
    raster.draw(&camera(0.1), &Shape::sphere(Vec3::new(-0.2, 0.0, -1.0), 0.1, 12).mesh(), true);
    let second = Shape::sphere(Vec3::new(0.2, 0.1, -1.0), 0.08, 12);
    let rect = raster.draw(&camera(0.1), &second.mesh(), true);
    let mut fresh = Raster::new(SENSOR);
    fresh.draw(&camera(0.1), &second.mesh(), true);
    let fragments = raster.fragments(&second.mesh());
    assert_eq!(fragments, fresh.fragments(&second.mesh()));
    for y in 0..48 {
        for x in 0..64 {
            let inside =
                (rect.left..rect.right).contains(&x) && (rect.top..rect.bottom).contains(&y);
            assert!(inside || !fragments.at(x, y).is_covered());
        }
    }
}

/// 1/depth of what every pixel sees, by what one writes first: every face at every pixel, in exact
/// integers and double precision.
fn plain(camera: &Camera, shape: &Shape) -> Vec<f64> {
    let mut nearest = vec![0.0; SENSOR.pixels()];
    let screen: Vec<ScreenVertex> = shape
        .vertices_m
        .iter()
        .map(|v| camera.homogeneous_image_from_world() * v.extend(1.0))
        .map(ScreenVertex::from_homogeneous)
        .collect();
    let area = |a: (i64, i64), b: (i64, i64), p: (i64, i64)| {
        (b.0 - a.0) * (p.1 - a.1) - (b.1 - a.1) * (p.0 - a.0)
    };
    for face in &shape.faces {
        let corners = face.map(|v| screen[v as usize]);
        let [a, b, c] = corners.map(|v| (i64::from(v.x()), i64::from(v.y())));
        let whole = area(a, b, c);
        if whole == 0 {
            continue;
        }
        for (pixel, nearest) in nearest.iter_mut().enumerate() {
            let centre = ((pixel as i64 % 64) * 256 + 128, (pixel as i64 / 64) * 256 + 128);
            let mut depth = 0.0;
            let mut is_inside = true;
            for ((from, to), corner) in [(b, c), (c, a), (a, b)].into_iter().zip(corners) {
                // Clockwise, so that the inside is positive.
                let (from, to) = if whole > 0 { (from, to) } else { (to, from) };
                let weight = area(from, to, centre);
                let is_owned = to.1 < from.1 || (to.1 == from.1 && to.0 > from.0);
                is_inside &= weight > 0 || (weight == 0 && is_owned);
                depth += weight as f64 / whole.abs() as f64 * f64::from(corner.inverse_depth());
            }
            if is_inside && depth > *nearest {
                *nearest = depth;
            }
        }
    }
    nearest
}

#[test]
fn every_pixel_sees_what_a_plain_loop_over_all_faces_finds() {
    let mut rng = evpose_core::CounterRng::new(5, "raster", 0);
    let mut point = |spread_m: f32| {
        let mut u = || rng.uniform(-1.0, 1.0);
        Vec3::new(spread_m * u(), spread_m * u(), -1.0 + 0.6 * u())
    };
    for round in 0..60 {
        // Small triangles, ones wider than a vector, and ones wider than 32 bits of area.
        let spread_m = [0.03, 0.3, 4.0][round % 3];
        let mut shape = Shape::default();
        for _ in 0..40 {
            let middle_m = 0.3 * point(1.0) - 0.7 * Vec3::Z;
            for _ in 0..3 {
                let corner_m = middle_m + point(spread_m) + Vec3::Z;
                shape.vertices_m.push(corner_m.with_z(corner_m.z.min(-0.2)));
            }
            let first = shape.vertices_m.len() as u32 - 3;
            shape.faces.push([first, first + 1, first + 2]);
        }
        let mut raster = Raster::new(SENSOR);
        raster.draw(&camera(0.1), &shape.mesh(), false);
        let fragments = raster.fragments(&shape.mesh());
        let mut covered = 0;
        for (fragment, want) in fragments.data().iter().zip(plain(&camera(0.1), &shape)) {
            assert_eq!(fragment.is_covered(), want > 0.0);
            assert!((f64::from(fragment.inverse_depth) - want).abs() < 1e-4 * want.max(1.0));
            covered += usize::from(fragment.is_covered());
        }
        assert!(covered > 10, "{covered}");
    }
}
