use std::path::Path;

use proptest::prelude::*;

use super::*;

const FRAME: IVec2 = IVec2::splat(1000);

/// See `tests/golden/h36m`.
#[test]
fn published_parts_are_those_of_the_published_rules_in_python() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden/h36m/crop.csv");
    let table = std::fs::read_to_string(path).unwrap();
    let mut rows = 0;
    for line in table.lines().skip(1) {
        let values: Vec<f32> = line.split(',').map(|value| value.parse().unwrap()).collect();
        let [x0, y0, x1, y1, left, right, top, bottom, x, y, u, v] = values.try_into().unwrap();
        let joints = [Vec2::new(x0, y1), Vec2::new(x1, y0)];
        let crop = Crop::around(joints, FRAME, CropRule::Published).unwrap();
        let [left, right, top, bottom] = [left, right, top, bottom].map(|cut| cut as i32);
        assert_eq!(crop, Crop { left, right, top, bottom }, "{line}");
        let placed = crop.place(Vec2::new(x, y), FRAME, CropRule::Published);
        assert_eq!(placed, Vec2::new(u, v), "{line}");
        rows += 1;
    }
    assert_eq!(rows, 60);
}

fn around(least: [f32; 2], most: [f32; 2]) -> Crop {
    Crop::around([least.into(), most.into()], FRAME, CropRule::Paper).unwrap()
}

#[test]
fn a_small_box_has_the_sensors_size_around_it() {
    let crop = around([400.0, 300.0], [500.0, 600.0]);
    assert_eq!(crop, Crop { left: 130, right: 230, top: 210, bottom: 310 });
    assert_eq!(crop.to_string(), "130,230,210,310");
    // With its margin it fits exactly.
    let crop = around([200.0, 300.0], [820.0, 760.0]);
    assert_eq!(crop, Crop { left: 190, right: 170, top: 290, bottom: 230 });
    // At the edge of the frame.
    let crop = around([0.0, 900.0], [100.0, 990.0]);
    assert_eq!(crop, Crop { left: 0, right: 360, top: 520, bottom: 0 });
}

#[test]
fn a_large_box_keeps_the_sensors_shape_as_far_as_the_frame_goes() {
    // 580 high with its margin, so 773 and a third wide.
    let crop = around([450.0, 200.0], [550.0, 760.0]);
    assert_eq!(crop.size(FRAME), IVec2::new(774, 580));
    assert_eq!((crop.left, crop.top), (113, 190));
    // 700 wide, so 525 high.
    assert_eq!(around([100.0, 500.0], [780.0, 520.0]).size(FRAME), IVec2::new(700, 525));
    // Higher than three quarters of the frame's width.
    let crop = around([450.0, 50.0], [550.0, 930.0]);
    assert_eq!(crop, Crop { left: 0, right: 0, top: 40, bottom: 60 });
}

#[test]
fn joints_are_placed_where_their_pixels_go() {
    let crop = around([450.0, 200.0], [550.0, 760.0]);
    let corner = Vec2::new(crop.left as f32, crop.top as f32);
    assert_eq!(crop.place(corner, FRAME, CropRule::Paper), Vec2::ZERO);
    let end = corner + crop.size(FRAME).as_vec2();
    assert!(crop.place(end, FRAME, CropRule::Paper).distance(Vec2::new(640.0, 480.0)) < 1e-3);
}

#[test]
fn there_is_no_part_around_nothing() {
    assert_eq!(Crop::around([], FRAME, CropRule::Paper), None);
    for rule in [CropRule::Paper, CropRule::Published] {
        assert_eq!(Crop::around([Vec2::ONE, Vec2::new(f32::NAN, 1.0)], FRAME, rule), None);
        assert_eq!(Crop::around([Vec2::new(f32::NAN, 1.0), Vec2::ONE], FRAME, rule), None);
    }
}

proptest! {
    #[test]
    fn a_part_is_inside_its_frame_and_holds_every_joint_that_is(
        joints in prop::collection::vec((0.0..1000.0_f32, 0.0..990.0_f32), 1..20),
        frame in prop::sample::select(vec![(1000, 1000), (1002, 1000), (1000, 1002), (500, 300)]),
    ) {
        let frame_px = IVec2::new(frame.0, frame.1);
        let last = frame_px.as_vec2();
        let joints: Vec<Vec2> = joints.into_iter().map(|(x, y)| Vec2::new(x, y).min(last)).collect();
        let crop = Crop::around(joints.clone(), frame_px, CropRule::Paper).unwrap();
        prop_assert!(crop.is_inside(frame_px), "{crop}");
        for joint in joints {
            let at = crop.place(joint, frame_px, CropRule::Paper);
            prop_assert!(at.cmpge(Vec2::ZERO).all(), "{joint} at {at}");
            prop_assert!(at.cmple(Vec2::new(640.001, 480.001)).all(), "{joint} at {at}");
        }
    }
}
