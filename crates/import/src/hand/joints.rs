//! Joints of a hand as CSV: `t_us` or `t_s`, then `index_tip_x_m`, `index_tip_y_m`, `index_tip_z_m`
//! in metres or `index_tip_u_px`, `index_tip_v_px` in pixels of the sensor, of any of the 21 joints.
//!
//! The columns are those of `evpose infer --joints`, in any order. Empty cells, or `nan`,
//! are joints that are not labelled.

use evpose_core::Micros;
use evpose_pose::EVALUATION_JOINTS;
use glam::{DVec3, Vec2};

use super::format::{HandJoints, HandLabelFormat, HandLabels, LabelChoice, LabelledHand};
use crate::ImportError;
use crate::table::Table;

/// Suffixes of columns in metres.
const METRES: [&str; 3] = ["_x_m", "_y_m", "_z_m"];
/// Suffixes of columns in pixels.
const PIXELS: [&str; 2] = ["_u_px", "_v_px"];

/// The format.
pub(super) static FORMAT: HandLabelFormat = HandLabelFormat {
    name: "joints",
    summary: "JOINT_x_m, JOINT_y_m, JOINT_z_m or JOINT_u_px, JOINT_v_px",
    detect: |columns| {
        columns.iter().any(|name| joint_of(name, &METRES).or(joint_of(name, &PIXELS)).is_some())
    },
    read,
};

/// The joint of a column and the index of its coordinate; none if the column is of no joint.
fn joint_of<'a>(name: &'a str, suffixes: &[&str]) -> Option<(&'a str, usize)> {
    let mut suffixes = suffixes.iter().enumerate();
    let (joint, index) =
        suffixes.find_map(|(index, suffix)| Some((name.strip_suffix(suffix)?, index)))?;
    EVALUATION_JOINTS.contains(&joint).then_some((joint, index))
}

fn read(table: &Table, choice: LabelChoice) -> Result<HandLabels, ImportError> {
    check_names(table)?;
    let has =
        |suffixes: &[&str]| table.columns().iter().any(|name| joint_of(name, suffixes).is_some());
    let in_pixels = choice.on_image || !has(&METRES);
    if in_pixels && !has(&PIXELS) {
        let reason = "no joint on the image: expected columns such as `wrist_u_px`";
        return Err(table.fault_of_header(reason));
    }
    let columns_m = if in_pixels { [None; 21] } else { columns(table, METRES)? };
    let columns_px = if in_pixels { columns(table, PIXELS)? } else { [None; 21] };
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
            HandJoints::Metres(joints_m, choice.frame)
        };
        Ok(LabelledHand { t, label })
    };
    Ok(HandLabels::Joints(table.rows()?.into_iter().map(label).collect::<Result<_, _>>()?))
}

/// Indices of the columns of each joint; none for joints that the table does not have.
fn columns<const N: usize>(
    table: &Table,
    suffixes: [&str; N],
) -> Result<[Option<[usize; N]>; 21], ImportError> {
    let mut columns = [None; 21];
    for (columns, joint) in columns.iter_mut().zip(EVALUATION_JOINTS) {
        let names = suffixes.map(|suffix| format!("{joint}{suffix}"));
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
        if is_coordinate && joint_of(name, &METRES).or(joint_of(name, &PIXELS)).is_none() {
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
    #![allow(clippy::unwrap_used, reason = "tests")]
    use glam::Vec3;

    use super::super::format::JointFrame;
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
