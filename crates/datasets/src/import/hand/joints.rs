//! Joints of a hand as CSV: `t_us` or `t_s`, then `index_tip_x_m`, `index_tip_y_m`, `index_tip_z_m`
//! in metres or `index_tip_u_px`, `index_tip_v_px` in pixels of the sensor, of any of the 21 joints.
//!
//! The columns are those of [`evpose_io::poses`], in any order: `frame` says whether metres are in the frame
//! of the `camera` or of the `world`. Empty cells, or `nan`, are joints that are not labelled.

use evpose_core::Micros;
use evpose_pose::{EVALUATION_JOINTS, JointFrame};
use glam::{DVec3, Vec2, Vec3};

use super::format::{HandJoints, HandLabelFormat, HandLabels, LabelChoice, LabelledHand};
use crate::import::ImportError;
use crate::import::table::{Row, Table};

/// Column of the frame of metres.
const FRAME: &str = "frame";
/// Suffixes of columns in metres.
const METRES: [&str; 3] = ["_x_m", "_y_m", "_z_m"];
/// Suffixes of columns in pixels.
const PIXELS: [&str; 2] = ["_u_px", "_v_px"];

pub(super) static FORMAT: HandLabelFormat = HandLabelFormat {
    name: "joints",
    summary: "JOINT_x_m, JOINT_y_m, JOINT_z_m or JOINT_u_px, JOINT_v_px",
    detect: |columns| {
        columns.iter().any(|name| is_of_joint(name, &METRES) || is_of_joint(name, &PIXELS))
    },
    read,
};

/// Whether a column is of a joint.
fn is_of_joint(name: &str, suffixes: &[&str]) -> bool {
    let mut joints = suffixes.iter().filter_map(|suffix| name.strip_suffix(suffix));
    joints.any(|joint| EVALUATION_JOINTS.contains(&joint))
}

fn read(table: &Table, choice: LabelChoice) -> Result<HandLabels, ImportError> {
    check_names(table)?;
    let has = |suffixes: &[&str]| table.columns().iter().any(|name| is_of_joint(name, suffixes));
    // Positions in space say more: pixels are used if asked for, or if there is nothing else.
    let in_pixels = choice.on_image || !has(&METRES);
    if in_pixels && !has(&PIXELS) {
        let reason = "no joint on the image: expected columns such as `wrist_u_px`";
        return Err(table.fault_of_header(reason));
    }
    let columns_m = if in_pixels { [None; 21] } else { columns(table, METRES)? };
    let columns_px = if in_pixels { columns(table, PIXELS)? } else { [None; 21] };
    let frame_column = table.column(FRAME);
    let label = |(t, row): (Micros, _)| -> Result<_, ImportError> {
        let label = if in_pixels {
            let mut joints_px = [None; 21];
            for (joint, columns) in joints_px.iter_mut().zip(columns_px) {
                let at_px = columns.map(|columns| table.values(row, columns)).transpose()?;
                *joint = at_px.flatten().map(|[u, v]| Vec2::new(u as f32, v as f32));
            }
            HandJoints::Pixels(joints_px)
        } else {
            let mut joints_m = [None; 21];
            for (joint, columns) in joints_m.iter_mut().zip(columns_m) {
                let at_m = columns.map(|columns| table.values(row, columns)).transpose()?;
                *joint = at_m.flatten().map(|at_m| DVec3::from(at_m).as_vec3());
            }
            let frame = match frame_column {
                Some(column) => stated_frame(table, row, column, choice.frame)?,
                None => choice.frame.unwrap_or_default(),
            };
            // Behind the camera a projection is meaningless: the frame is likely another.
            if frame == JointFrame::Camera
                && let Some(joint) = behind_camera(&joints_m)
            {
                let column = table.required(&format!("{joint}{}", METRES[2]))?;
                let reason =
                    "not in front of the camera: are joints in the world's frame (--frame world)?";
                return Err(table.fault(row, column, reason));
            }
            HandJoints::Metres(joints_m, frame)
        };
        Ok(LabelledHand { t, label })
    };
    Ok(HandLabels::Joints(table.rows()?.into_iter().map(label).collect::<Result<_, _>>()?))
}

/// The frame that a line states, which must be the one that was asked for.
fn stated_frame(
    table: &Table,
    row: &Row,
    column: usize,
    asked: Option<JointFrame>,
) -> Result<JointFrame, ImportError> {
    let name = table.text(row, column);
    let Some(stated) = JointFrame::ALL.into_iter().find(|frame| frame.name() == name) else {
        return Err(table.fault(row, column, &format!("`{name}` is neither camera nor world")));
    };
    match asked.filter(|asked| *asked != stated) {
        None => Ok(stated),
        Some(asked) => {
            let reason = format!("`{name}`, but --frame {} was given", asked.name());
            Err(table.fault(row, column, &reason))
        }
    }
}

/// The first joint that cannot be in the camera's frame, whose z points forwards.
fn behind_camera(joints_m: &[Option<Vec3>; 21]) -> Option<&'static str> {
    let mut joints = EVALUATION_JOINTS.iter().zip(joints_m);
    joints.find(|(_, at_m)| at_m.is_some_and(|at_m| at_m.z <= 0.0)).map(|(name, _)| *name)
}

/// Indices of the columns of each joint; none for joints that the table does not have.
fn columns<const N: usize>(
    table: &Table,
    suffixes: [&str; N],
) -> Result<[Option<[usize; N]>; 21], ImportError> {
    let mut columns = [None; 21];
    for (columns, joint) in columns.iter_mut().zip(EVALUATION_JOINTS) {
        let names = suffixes.map(|suffix| format!("{joint}{suffix}"));
        // One column makes all of its joint required: half a position would be ignored silently.
        if names.iter().any(|name| table.column(name).is_some()) {
            let mut indices = [0; N];
            for (index, name) in indices.iter_mut().zip(&names) {
                *index = table.required(name)?;
            }
            *columns = Some(indices);
        }
    }
    Ok(columns)
}

/// Refuses columns with the suffix of a joint's that name none: they would be ignored.
fn check_names(table: &Table) -> Result<(), ImportError> {
    for name in table.columns() {
        let is_coordinate = METRES.iter().chain(&PIXELS).any(|suffix| name.ends_with(suffix));
        if is_coordinate && !is_of_joint(name, &METRES) && !is_of_joint(name, &PIXELS) {
            let reason = format!(
                "column `{name}`: no such joint; there are {}",
                EVALUATION_JOINTS.join(", ")
            );
            return Err(table.fault_of_header(reason));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::super::registry::read_hand_labels;
    use super::*;

    fn of(text: &str, choice: LabelChoice) -> Result<Vec<HandJoints>, ImportError> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("j.csv");
        std::fs::write(&path, text).unwrap();
        match read_hand_labels(&path, choice)? {
            HandLabels::Joints(labels) => Ok(labels.into_iter().map(|label| label.label).collect()),
            HandLabels::Parameters(_) => panic!("not joints"),
        }
    }

    const BOTH: &str =
        "wrist_v_px,wrist_u_px,t_us,wrist_x_m,wrist_y_m,wrist_z_m\n2,1,0,3,4,5\n,,1,,,\n";

    #[test]
    fn joints_are_read_in_metres_or_in_pixels() {
        let HandJoints::Metres(joints_m, frame) = of(BOTH, LabelChoice::default()).unwrap()[0]
        else {
            panic!("not metres")
        };
        assert_eq!((joints_m[0], joints_m[1]), (Some(Vec3::new(3.0, 4.0, 5.0)), None));
        assert_eq!(frame, JointFrame::Camera);
        let choice = LabelChoice { on_image: true, ..LabelChoice::default() };
        let labels = of(BOTH, choice).unwrap();
        let HandJoints::Pixels(joints_px) = labels[0] else { panic!("not pixels") };
        assert_eq!(joints_px[0], Some(Vec2::new(1.0, 2.0)));
        assert_eq!(labels[1], HandJoints::Pixels([None; 21]));
    }

    #[test]
    fn joints_that_are_nan_are_not_labelled() {
        let text = "t_us,wrist_u_px,wrist_v_px,thumb1_u_px,thumb1_v_px\n0,nan,NaN,3,4\n";
        let labels = of(text, LabelChoice::default()).unwrap();
        let HandJoints::Pixels(joints_px) = labels[0] else { panic!("not pixels") };
        assert_eq!(joints_px[0], None);
        assert_eq!(joints_px[18], Some(Vec2::new(3.0, 4.0)));
    }

    #[test]
    fn the_frame_that_a_table_states_counts() {
        let text = "t_us,frame,wrist_x_m,wrist_y_m,wrist_z_m\n0,world,3,4,-5\n";
        let frame = |text: &str, frame| match of(text, LabelChoice { frame, ..Default::default() })
        {
            Ok(labels) => match labels[0] {
                HandJoints::Metres(_, frame) => Ok(frame),
                HandJoints::Pixels(_) => panic!("not metres"),
            },
            Err(error) => Err(error.to_string()),
        };
        assert_eq!(frame(text, None), Ok(JointFrame::World));
        assert_eq!(frame(text, Some(JointFrame::World)), Ok(JointFrame::World));
        let message = frame(text, Some(JointFrame::Camera)).unwrap_err();
        assert!(message.contains("line 2: frame: `world`, but --frame camera"), "{message}");
        let message = frame(&text.replace("world", "room"), None).unwrap_err();
        assert!(message.contains("`room` is neither"), "{message}");
        let silent = text.replace(",frame", "").replace(",world", "");
        let message = frame(&silent, None).unwrap_err();
        assert!(message.contains("wrist_z_m") && message.contains("--frame world"), "{message}");
        assert_eq!(frame(&silent, Some(JointFrame::World)), Ok(JointFrame::World));
    }

    #[test]
    fn faults_name_line_and_column() {
        let default = LabelChoice::default();
        let on_image = LabelChoice { on_image: true, ..default };
        for (text, choice, want) in [
            (
                "t_us,wrist_u_px\n0,1\n",
                default,
                "j.csv: line 1: no column `wrist_v_px`; there are t_us, wrist_u_px",
            ),
            (
                "t_us,wrist_u_px,wrist_v_px,tip_u_px\n0,1,2,3\n",
                default,
                "column `tip_u_px`: no such",
            ),
            ("t_us,wrist_u_px,wrist_v_px\n0,1,\n", default, "line 2: wrist_v_px: missing"),
            ("t_us,wrist_x_m,wrist_y_m,wrist_z_m\n0,1,1,1\n", on_image, "no joint on the image"),
        ] {
            let message = of(text, choice).unwrap_err().to_string();
            assert!(message.contains(want), "{message}");
        }
    }
}
