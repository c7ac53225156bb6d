//! Every layout of poses: written, read back, and read as others wrote it.

use std::path::Path;

use evpose_core::Micros;
use evpose_pose::body::BODY_JOINTS;
use evpose_pose::metric::HandPoints;
use evpose_pose::{
    HandParams, JointFrame, PARAMETER_NAMES, PARAMETERS, POSE_LAYOUTS, PoseEstimate, PoseLayout,
    PoseOrigin,
};
use glam::{Vec2, Vec3};

use super::*;
use crate::IoError;

/// A person of two poses: one with a joint that was not detected, and nobody.
fn people() -> PoseSequence {
    let pose = |t: i64, joints_px| {
        let mut scores = [0.5; BODY_JOINTS];
        scores[3] = 0.0;
        let estimate = PoseEstimate::Body { joints_px, scores, score: 0.4615 };
        let pose = TimedPose::new(Micros(t), &estimate).with_origin(PoseOrigin::Network);
        TimedPose { latency_ms: Some(2.5), ..pose }
    };
    let mut joints_px: [_; BODY_JOINTS] =
        std::array::from_fn(|k| Some(Vec2::new(10.0 * k as f32 + 0.5, 20.25)));
    joints_px[3] = None;
    let poses = vec![pose(20_000, joints_px), pose(40_000, [None; BODY_JOINTS])];
    PoseSequence { poses, ..PoseSequence::new(PoseKind::Body) }
}

/// The same in the world, in metres.
fn people_in_the_world() -> PoseSequence {
    let mut sequence = PoseSequence { frame: Some(JointFrame::World), ..people() };
    for (k, joint) in sequence.poses[0].joints.iter_mut().enumerate() {
        joint.position_m = joint.image_px.map(|_| Vec3::new(0.25, 1.5, -0.125 * k as f32));
    }
    sequence
}

/// A hand with a joint that is behind the camera.
fn hand() -> PoseSequence {
    let mut image_px = [Some(Vec2::new(100.125, 50.5)); 21];
    image_px[4] = None;
    let points = Box::new(HandPoints { world_m: [Vec3::ZERO; 21], image_px });
    let params = HandParams::from_array(std::array::from_fn(|k| 0.1 * k as f32));
    let camera_m = Box::new([Vec3::new(0.01, -0.02, 0.5); 21]);
    let estimate = PoseEstimate::Hand { params, points, camera_m, score: None };
    let poses = vec![TimedPose::new(Micros(-7), &estimate)];
    PoseSequence { poses, ..PoseSequence::new(PoseKind::Hand) }
}

fn of(text: &str) -> Result<PoseSequence, IoError> {
    poses_from(Path::new("poses.csv"), text.as_bytes())
}

fn fault(text: &str) -> String {
    of(text).unwrap_err().to_string()
}

/// Writes poses and reads them back, with the format detected.
fn through(sequence: &PoseSequence, format: &str) -> (String, PoseSequence) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("poses");
    write_poses(&path, sequence, POSE_FORMATS.find(format).unwrap()).unwrap();
    let file = if path.is_dir() { path.join("data.log") } else { path.clone() };
    (std::fs::read_to_string(file).unwrap(), read_poses(&path).unwrap())
}

#[test]
fn tables_and_json_hold_all_of_a_pose() {
    for sequence in [people(), people_in_the_world(), hand()] {
        let (text, back) = through(&sequence, "table");
        let mut want = sequence.clone();
        assert_eq!(back, want, "{text}");
        let (text, back) = through(&sequence, "jsonl");
        let (array, same) = through(&sequence, "json");
        assert_eq!(back, same, "{array}");
        let lines = text.lines().collect::<Vec<_>>().join(",\n");
        assert_eq!(array, format!("[\n{lines}\n]\n"));
        for pose in &mut want.poses {
            // A joint without a position is left out.
            let joints = pose.joints.iter_mut();
            joints
                .filter(|joint| joint.image_px.or(joint.position_m.map(|m| m.truncate())).is_none())
                .for_each(|joint| joint.score = None);
        }
        assert_eq!(back, want, "{text}");
    }
}

#[test]
fn columns_are_named_and_cells_of_nobody_are_empty() {
    let (text, _) = through(&people(), "table");
    let mut lines = text.lines();
    let header = lines.next().unwrap();
    assert!(header.starts_with("t_us,origin,latency_ms,score,head_u_px,head_v_px,head_score,"));
    assert!(header.ends_with(",ankle_r_u_px,ankle_r_v_px,ankle_r_score"), "{header}");
    let first = lines.next().unwrap();
    assert!(first.starts_with("20000,network,2.500,0.4615,0.500,20.250,0.5000,"), "{first}");
    let nobody = lines.next().unwrap();
    assert!(nobody.starts_with("40000,nobody,2.500,0.4615,,,0.5000,"), "{nobody}");
    let (text, _) = through(&hand(), "table");
    let header = text.lines().next().unwrap();
    let start = format!("t_us,origin,latency_ms,score,frame,{},", PARAMETER_NAMES.join(","));
    assert!(header.starts_with(&start), "{header}");
    assert!(header.contains(",wrist_u_px,wrist_v_px,wrist_x_m,wrist_y_m,wrist_z_m,"), "{header}");
    assert!(text.lines().nth(1).unwrap().starts_with("-7,,,,camera,0,0.1,0.2,"), "{text}");
    let joints = PoseColumns::of(PoseKind::Hand).without_params().header();
    assert!(joints.starts_with("t_us,origin,latency_ms,score,frame,wrist_u_px,"), "{joints}");
}

#[test]
fn lines_of_json_have_the_names_of_the_table() {
    let (text, _) = through(&people(), "jsonl");
    let first = text.lines().next().unwrap();
    let start = r#"{"t_us":20000,"origin":"network","latency_ms":2.5,"score":0.4615,"joints":{"#;
    assert!(first.starts_with(start), "{first}");
    assert!(first.contains(r#""head":{"u_px":0.5,"v_px":20.25,"score":0.5}"#), "{first}");
    assert!(!first.contains("elbow_l"), "{first}");
    assert!(text.lines().nth(1).unwrap().ends_with(r#""joints":{}}"#), "{text}");
    let (text, _) = through(&hand(), "jsonl");
    assert!(
        text.contains(r#""frame":"camera","params":{"articulation_1":0,"articulation_2":0.1,"#)
    );
    assert!(text.contains(r#""ring_tip":{"x_m":0.01,"y_m":-0.02,"z_m":0.5}"#), "{text}");
}

#[test]
fn layouts_of_other_programs_are_of_people() {
    let sequence = people();
    let joints_px = |sequence: &PoseSequence| -> Vec<_> {
        sequence.poses.iter().map(|pose| (pose.t, pose.body_px())).collect()
    };
    let (text, back) = through(&sequence, "hpe-core");
    assert!(text.starts_with("0.02 0.0025 0.5 20.25 "), "{text}");
    assert_eq!(joints_px(&back), joints_px(&sequence));
    let (text, back) = through(&sequence, "yarp");
    assert!(text.starts_with("0 000.02 SKLT (0 20 20 20 "), "{text}");
    assert!(text.lines().nth(1).unwrap().contains("-1 -1"), "{text}");
    assert_eq!(back.poses[0].joints[0].score, Some(0.5));
    assert_eq!(back.poses[0].joints[3], PoseJoint { score: Some(0.0), ..PoseJoint::default() });
    for format in ["hpe-core", "yarp"] {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("poses");
        let format = POSE_FORMATS.find(format).unwrap();
        assert!(write_poses(&path, &hand(), format).is_err());
        assert!(!path.exists());
    }
}

#[test]
fn poses_of_other_tasks_are_values_of_their_layout() {
    static STICK: PoseLayout =
        PoseLayout { name: "stick", values: &["tip_u_px", "tip_v_px", "angle_deg"] };
    let estimate =
        |values: [f32; 3]| PoseEstimate::Values { layout: &STICK, values: values.into() };
    let pose = |t, values| TimedPose::new(Micros(t), &estimate(values));
    let poses = vec![pose(10, [0.1, -2.5, 90.0]), pose(20, [1.0 / 3.0, 3.0, f32::NAN])];
    let sequence = PoseSequence { poses, ..PoseSequence::new(PoseKind::Values(&STICK)) };
    let table = "t_us,origin,latency_ms,score,tip_u_px,tip_v_px,angle_deg\n10,,,,0.1,-2.5,90\n";
    assert!(of(table).is_err(), "nothing has this layout yet");
    POSE_LAYOUTS.register(&[&STICK]).unwrap();
    for format in ["table", "json", "jsonl"] {
        let (text, back) = through(&sequence, format);
        assert!(format != "table" || text.starts_with(table), "{text}");
        assert_eq!((back.kind, &back.poses[0]), (sequence.kind, &sequence.poses[0]), "{text}");
        let poses = vec![TimedPose::nobody(sequence.kind, Micros(5))];
        let nobody = PoseSequence { poses, ..PoseSequence::new(sequence.kind) };
        assert_eq!(through(&nobody, format).1, nobody);
    }
    assert_eq!(through(&sequence, "table").1.poses[1].values, None, "a cell is empty");
    for format in ["hpe-core", "yarp"] {
        let format = POSE_FORMATS.find(format).unwrap();
        let error = write_poses(Path::new("poses"), &sequence, format).unwrap_err();
        assert!(error.to_string().contains("of stick"), "{error}");
    }
}

#[test]
fn tables_of_parameters_alone_are_of_hands() {
    let names = PARAMETER_NAMES.join(",");
    let values: [String; PARAMETERS] = std::array::from_fn(|k| k.to_string());
    let params = Some(HandParams::from_array(std::array::from_fn(|k| k as f32)));
    let infer = of(&format!("t_us,{names}\n5,{}\n", values.join(","))).unwrap();
    assert_eq!((infer.kind, infer.frame), (PoseKind::Hand, None));
    assert_eq!((infer.poses[0].t, infer.poses[0].params), (Micros(5), params));
}

#[test]
fn columns_may_stand_in_any_order_and_labels_have_only_some() {
    let text =
        "\u{feff}\"head_v_px\",note,t_us,head_u_px,frame\r\n2,a,7,1,world\r\n,b,8,,world\r\n";
    let sequence = of(text).unwrap();
    assert_eq!((sequence.kind, sequence.frame), (PoseKind::Body, Some(JointFrame::World)));
    assert_eq!(sequence.poses[0].joints[0].image_px, Some(Vec2::new(1.0, 2.0)));
    assert_eq!(sequence.poses[1].body_px(), [None; BODY_JOINTS]);
}

#[test]
fn a_mark_of_byte_order_is_no_content_of_any_format() {
    for format in ["table", "json", "jsonl", "hpe-core", "yarp"] {
        let (text, want) = through(&people(), format);
        let marked = of(&format!("\u{feff}{text}"));
        assert_eq!(marked.unwrap(), want, "{format}");
    }
    // It counts among the bytes of the file.
    let message = fault("\u{feff}t_us,head_u_px,head_v_px\n1,2\n");
    assert!(message.contains("line 2 at byte 28"), "{message}");
}

#[test]
fn faults_name_line_and_column() {
    for (text, want) in [
        ("t_us,head_u_px,head_v_px\n1,2\n", "poses.csv: line 2 at byte 25: 2 columns where 3"),
        ("t_us,head_u_px,head_v_px\n1,2,x\n", "line 2 at byte 25: `x` is no number"),
        ("t_us,head_u_px,head_v_px\n1,2,inf\n", "`inf` is no number"),
        ("t_us,head_u_px,head_v_px\n1.5,2,3\n", "`1.5` is no time in microseconds"),
        ("t_us,head_u_px\n1,2\n", "line 1 at byte 0: no column `head_v_px`"),
        ("t_us,head_u_px,head_v_px,tail_u_px\n", "column `tail_u_px`: no such joint of people"),
        ("t_us,head_u_px,head_u_px\n", "column `head_u_px` occurs twice"),
        ("t_us,x\n", "no columns of a pose"),
        ("t_us,articulation_1\n", "no column `articulation_2`"),
        ("t_us,frame,wrist_u_px,wrist_v_px\n1,room,2,3\n", "`room` is neither camera nor world"),
        (
            "t_us,frame,wrist_u_px,wrist_v_px\n1,world,2,3\n2,camera,2,3\n",
            "frame: not that of the line before",
        ),
        ("{\"t_us\":1,\"joints\":{\"tail\":{}}}\n", "neither of a person nor of a hand"),
        ("{\"t_us\":1,\"joints\":{\"head\":{},\"tail\":{}}}\n", "no joint `tail` of people"),
        ("{\"t_us\":1.5,\"joints\":{}}\n", "no `t_us`"),
        ("{\"t_us\":1,\n", "line 1 at byte 0"),
        ("[\n{\"t_us\":1,\"joints\":{}},\n{\"t_us\":2}\n]\n", "line 3 at byte 26: no `joints`"),
        ("something else\n", "no known format (table, json, jsonl, parquet, hpe-core, yarp)"),
    ] {
        let message = fault(text);
        assert!(message.contains(want), "{message}");
    }
}

#[test]
fn a_hand_that_is_not_there_is_a_row_of_every_format_that_hands_have() {
    let mut sequence = hand();
    sequence.poses.insert(0, TimedPose::nobody(PoseKind::Hand, Micros(-9)));
    for format in ["table", "json", "jsonl"] {
        let (text, back) = through(&sequence, format);
        assert_eq!(back.kind, PoseKind::Hand, "{text}");
        assert_eq!(back.poses[0], sequence.poses[0], "{text}");
    }
}

#[test]
fn endings_name_the_format() {
    let of = |name: &str| pose_format_of(Path::new(name)).map(|format| format.name);
    for (name, format) in [
        ("poses.csv", "table"),
        ("poses.JSON", "json"),
        ("poses.jsonl", "jsonl"),
        ("poses.ndjson", "jsonl"),
        ("poses.parquet", "parquet"),
        ("pipe", "table"),
    ] {
        assert_eq!(of(name).unwrap(), format, "{name}");
    }
    let error = of("poses.xlsx").unwrap_err().to_string();
    for known in [".xlsx", ".parquet (parquet)", ".csv (table)", ".json (json)", ".jsonl (jsonl)"] {
        assert!(error.contains(known), "{error}");
    }
}

#[cfg(feature = "parquet")]
#[test]
fn tables_of_parquet_say_what_those_of_text_say() {
    let folder = tempfile::tempdir().unwrap();
    for sequence in [people(), people_in_the_world(), hand()] {
        let read = |name: &str| {
            let path = folder.path().join(name);
            write_poses(&path, &sequence, pose_format_of(&path).unwrap()).unwrap();
            read_poses(&path).unwrap()
        };
        assert_eq!(read("poses.parquet"), read("poses.csv"));
    }
    let cut = std::fs::read(folder.path().join("poses.parquet")).unwrap();
    let error = poses_from(Path::new("cut.parquet"), &cut[..cut.len() / 2]).unwrap_err();
    assert!(error.to_string().starts_with("cut.parquet: "), "{error}");
}
