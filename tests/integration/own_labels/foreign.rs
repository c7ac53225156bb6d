//! Simulated recordings as somebody else's program would deliver them: events as `.npz`, joints of
//! people as COCO's JSON and as CSV, joints of hands as CSV.

use std::fmt::Write as _;
use std::path::Path;

use anyhow::{Context, Result};
use evpose_camera::{Calibration, ViewAdaptor};
use evpose_io::{MetaReader, OpenOptions};
use evpose_pose::EVALUATION_JOINTS;
use evpose_pose::body::{BodyPoints, JOINT_NAMES};
use evpose_sim::SequenceInfo;
use evpose_sim::person::{PersonInfo, PoseTable};
use evpose_task::Experiment as _;
use evpose_task::hand::{HandConfig, HandView, canonical_view};
use serde_json::{Value, json};

/// COCO's keypoints after the face, by index in the order of networks.
const COCO_BODY: [usize; 12] = [1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12];
const COCO_FACE: usize = 5;
/// Frames between labels of hands.
const HAND_STEP: u64 = 10;

/// Exports every sequence of a directory of `evpose simulate`; returns the count.
pub(crate) fn export(directory: &Path, out: &Path) -> Result<usize> {
    std::fs::create_dir_all(out)?;
    let mut names: Vec<String> = Vec::new();
    for entry in std::fs::read_dir(directory)? {
        names.extend(entry?.file_name().into_string().ok());
    }
    // In order of names, so that failures are the same on every machine.
    names.sort();
    let mut count = 0;
    for name in &names {
        if let Some(stem) = name.strip_suffix(".poses.csv") {
            person(directory, stem, out).with_context(|| format!("exporting {stem}"))?;
            count += 1;
        } else if let Some(stem) = name.strip_suffix(".meta") {
            hand(directory, stem, out).with_context(|| format!("exporting {stem}"))?;
            count += 1;
        }
    }
    Ok(count)
}

/// Writes `STEM.npz`, `STEM.coco.json` and `STEM.csv` of a simulated person.
fn person(directory: &Path, stem: &str, out: &Path) -> Result<()> {
    let table = PoseTable::read(&directory.join(format!("{stem}.poses.csv")))?;
    let info = std::fs::read_to_string(directory.join(format!("{stem}.toml")))?;
    let info: PersonInfo = toml::from_str(&info)?;
    let events = evpose_io::open(directory.join(format!("{stem}.raw")))?.stream;
    evpose_io::format_for("a.npz")?.write(out.join(format!("{stem}.npz")), &events)?;

    let [mut images, mut annotations]: [Vec<Value>; 2] = Default::default();
    let mut csv = "t_s".to_owned();
    // Another order than ours.
    for joint in JOINT_NAMES.iter().rev() {
        let _ = write!(csv, ",{joint}_v_px,{joint}_u_px");
    }
    for (id, row) in table.rows.iter().enumerate() {
        images.push(json!({
            "id": id, "file_name": format!("frame_{id:05}.png"), "t_us": row.t.0,
            "width": info.sensor.width, "height": info.sensor.height,
        }));
        annotations.push(json!({
            "id": id, "image_id": id, "category_id": 1, "keypoints": coco_keypoints(&row.joints_px),
        }));
        let _ = write!(csv, "\n{}", row.t.as_seconds());
        for joint in row.joints_px.iter().rev() {
            let _ = match joint {
                Some(at) => write!(csv, ",{},{}", at.y, at.x),
                None => write!(csv, ",,"),
            };
        }
    }
    let coco = json!({"images": images, "annotations": annotations, "categories": [{"id": 1, "name": "person"}]});
    std::fs::write(out.join(format!("{stem}.coco.json")), coco.to_string())?;
    std::fs::write(out.join(format!("{stem}.csv")), csv)?;
    Ok(())
}

/// COCO's 17 keypoints; the points of the face are all in the middle of the head.
fn coco_keypoints(joints_px: &BodyPoints) -> Vec<f32> {
    let joints = [0; COCO_FACE].into_iter().chain(COCO_BODY);
    joints.flat_map(|joint| joints_px[joint].map_or([0.0; 3], |at| [at.x, at.y, 2.0])).collect()
}

/// Writes `STEM.npz` and `STEM.joints.csv` of a simulated hand: joints every 10 ms in pixels of
/// the sensor and in metres in the frame of the camera.
fn hand(directory: &Path, stem: &str, out: &Path) -> Result<()> {
    let config = HandConfig::read(&directory.join("config.toml"))?;
    let info = SequenceInfo::beside(&directory.join(stem))?.context("no description")?;
    let options = OpenOptions { sensor: Some(info.sensor), ..OpenOptions::default() };
    let events = evpose_io::open_as(directory.join(format!("{stem}.evc")), &options)?.stream;
    evpose_io::format_for("a.npz")?.write(out.join(format!("{stem}.npz")), &events)?;

    let fov_deg = config.simulation.camera.vertical_fov_deg.into();
    let camera = Calibration::from_vertical_fov(info.sensor, fov_deg);
    let adaptor = ViewAdaptor::new(&camera, &canonical_view(&config));
    let view = HandView::new(&config)?.seen_by(&adaptor);
    let meta = MetaReader::open(directory.join(format!("{stem}.meta")))?;
    let mut csv = "t_us".to_owned();
    for joint in EVALUATION_JOINTS {
        let _ = write!(csv, ",{joint}_u_px,{joint}_v_px,{joint}_x_m,{joint}_y_m,{joint}_z_m");
    }
    for frame in (0..meta.records()).step_by(HAND_STEP as usize) {
        let betas = info.betas(info.episode_of(frame));
        let points = view.points(info.hand, &meta.read_hand(frame)?, betas);
        let _ = write!(csv, "\n{}", 1000 * frame);
        for (px, at_m) in points.image_px.iter().zip(view.camera_points(&points.world_m)) {
            let px = px.context("a joint behind the camera")?;
            // From y up, looking along -z, to y down, looking along z.
            let _ = write!(csv, ",{},{},{},{},{}", px.x, px.y, at_m.x, -at_m.y, -at_m.z);
        }
    }
    std::fs::write(out.join(format!("{stem}.joints.csv")), csv)?;
    Ok(())
}
