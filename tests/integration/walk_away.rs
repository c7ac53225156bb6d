//! A person who walks away is not held for as tall as the trail that an EROS keeps.

use std::path::Path;

use burn::tensor::Device;
use evpose_camera::Calibration;
use evpose_core::{Event, EventStream, Micros};
use evpose_io::Windows;
use evpose_pose::body::BodyPoints;
use evpose_pose::stream::InferenceSchedule;
use evpose_sim::person::PoseTable;
use evpose_task::RecordingStream;
use evpose_task::body::{BodyCheckpoint, BodyPredictor, BodyPredictorOptions, body_stream};
use glam::Vec2;

use crate::harness::Sandbox;

/// The point that the person walks to, relative to the image.
const VANISHING: Vec2 = Vec2::new(0.5, 0.45);

/// Size of the person at a time, relative to the one at the beginning: distance grows to the threefold.
fn size_at(t: Micros) -> f32 {
    (1.0 - (t.as_seconds() as f32 - 0.4)).clamp(1.0 / 3.0, 1.0)
}

fn height(joints: &BodyPoints) -> Option<f32> {
    let rows = || joints.iter().flatten().map(|joint| joint.y);
    let (low, high) = (rows().reduce(f32::min)?, rows().reduce(f32::max)?);
    Some(high - low)
}

/// Heights of the poses of somebody at an activity, relative to the truth, in order: those at sizes below `far`
/// of a recording that shrinks as `size_at` says.
fn ratios(activity: &str, size_at: fn(Micros) -> f32, far: f32) -> Vec<f32> {
    let shrunk = |at_px: Vec2, image_px: Vec2, t: Micros| {
        let from_px = VANISHING * image_px;
        from_px + size_at(t) * (at_px - from_px)
    };
    let sandbox = Sandbox::new();
    let simulate = "simulate finetune --held-out --sequences 1 --seconds 1.6 --out data --seed 5";
    let mut changes = Vec::new();
    for change in [
        &format!("activities=[\"{activity}\"]"),
        "step_hz=250",
        "label_hz=50",
        "moving_cameras=0.0",
        "height_share=[0.8,0.9]",
        "stillness=0.0",
        "companions=0",
        "surroundings.moving=0.0",
    ] {
        changes.extend(["--set".to_owned(), format!("simulation.{change}")]);
    }
    sandbox.run(simulate, &changes.iter().map(String::as_str).collect::<Vec<_>>());
    let near = evpose_io::open(sandbox.path("data/0000.raw")).unwrap().stream;
    let sensor = near.sensor();
    let image_px = Vec2::new(f32::from(sensor.width), f32::from(sensor.height));
    let mut events = EventStream::empty(sensor);
    for (index, event) in near.iter().enumerate() {
        // Outlines are shorter, and have fewer events.
        if (index as f32 * 0.618_034).fract() < size_at(event.t) {
            let at_px = Vec2::new(f32::from(event.x), f32::from(event.y)) + 0.5;
            let Vec2 { x, y } = shrunk(at_px, image_px, event.t);
            events.push(Event { x: x as u16, y: y as u16, ..event }).unwrap();
        }
    }
    let path = sandbox.path("far.raw");
    evpose_io::FORMATS.find("evt3").unwrap().write(&path, &events).unwrap();
    let labels = PoseTable::read(&sandbox.path("data/0000.poses.csv")).unwrap();

    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("checkpoints/body.bpk");
    let checkpoint = BodyCheckpoint::load(&shipped, &Device::flex()).unwrap();
    let predictor = BodyPredictor::new(&checkpoint, BodyPredictorOptions::default(), None).unwrap();
    let windows = Windows::open(&path, &evpose_io::OpenOptions::default()).unwrap();
    let camera = Calibration::guessed(sensor);
    let stream = body_stream(&checkpoint, &camera, None, predictor).unwrap();
    let every = InferenceSchedule::Every(Micros(20_000));
    let mut ratios = Vec::new();
    for inferred in RecordingStream::new(windows, stream, every) {
        for (t, pose) in inferred.unwrap().poses {
            let label = labels.rows.iter().min_by_key(|row| (row.t.0 - t.0).abs()).unwrap();
            let place = |joint: Option<Vec2>| joint.map(|at_px| shrunk(at_px, image_px, label.t));
            let truth = label.joints_px.map(place);
            if t.0 > 400_000 && size_at(t) <= far {
                let both = height(&pose.detection.points).zip(height(&truth));
                ratios.extend(both.map(|(found, truth)| found / truth));
            }
        }
    }
    ratios.sort_by(f32::total_cmp);
    assert!(ratios.len() > 20, "{ratios:?}");
    ratios
}

#[test]
fn somebody_far_is_as_small_as_the_latest_events() {
    let ratios = ratios("walking", size_at, 0.5);
    let median = ratios[ratios.len() / 2];
    assert!((0.7..1.35).contains(&median), "{median} of {ratios:?}");
}

/// Most of their latest events are of an arm.
#[test]
fn somebody_who_stands_and_waves_is_no_arm() {
    let ratios = ratios("waving", |_| 1.0, 1.0);
    let small = ratios.iter().filter(|ratio| **ratio < 0.7).count();
    assert!(20 * small <= ratios.len(), "{small} of {ratios:?}");
}
