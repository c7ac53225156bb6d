//! Joints as CSV: `t_us` or `t_s`, then `wrist_l_u_px` and `wrist_l_v_px` of any of the joints.
//!
//! Columns stand in any order. Empty cells, or `nan`, are joints that are not labelled; a line of
//! them is an image without a person. Other columns are ignored, so tables of `evpose simulate` can be
//! read.

use std::path::Path;

use crate::coco::{NamedKeypoint, keypoint_by_name};
use evpose_core::Micros;
use evpose_pose::body::{BODY_JOINTS, JOINT_NAMES};
use glam::Vec2;

use super::format::{BodyLabelFormat, LabelledImage, has_ending};
use crate::import::ImportError;
use crate::import::clock::ImageTime;
use crate::import::table::Table;

/// Suffixes of the columns of a joint.
const SUFFIXES: [&str; 2] = ["_u_px", "_v_px"];

pub(super) static FORMAT: BodyLabelFormat = BodyLabelFormat {
    name: "csv",
    summary: "t_us or t_s, JOINT_u_px, JOINT_v_px",
    detect: |path, _| has_ending(path, "csv"),
    read,
};

fn read(path: &Path) -> Result<Vec<LabelledImage>, ImportError> {
    let table = Table::read(path)?;
    let columns = columns(&table)?;
    let image = |(t, row): (Micros, _)| {
        let mut joints_px = [None; BODY_JOINTS];
        for (joint, columns) in &columns {
            let at_px = table.values(row, *columns)?;
            joints_px[*joint] = at_px.map(|[u, v]| Vec2::new(u as f32, v as f32));
        }
        Ok(LabelledImage { time: ImageTime::Stamp(t), size_px: None, persons: vec![joints_px] })
    };
    table.rows()?.into_iter().map(image).collect()
}

/// Joints with the indices of their columns.
fn columns(table: &Table) -> Result<Vec<(usize, [usize; 2])>, ImportError> {
    let mut columns = Vec::new();
    for name in table.columns() {
        let Some(joint) = SUFFIXES.iter().find_map(|suffix| name.strip_suffix(suffix)) else {
            continue;
        };
        let Some(NamedKeypoint::Joint(index)) = keypoint_by_name(joint) else {
            let reason = format!(
                "column `{name}`: no joint `{joint}`; there are {}",
                JOINT_NAMES.join(", ")
            );
            return Err(table.fault_of_header(reason));
        };
        let [u, v] = SUFFIXES.map(|suffix| table.required(&format!("{joint}{suffix}")));
        // A joint is added by its u; a v without it is a fault as well.
        if name.ends_with(SUFFIXES[0]) {
            if columns.iter().any(|(known, _)| *known == index) {
                return Err(table.fault_of_header(format!("joint `{joint}` occurs twice")));
            }
            columns.push((index, [u?, v?]));
        } else {
            u?;
        }
    }
    if columns.is_empty() {
        let reason = format!("no joint: expected columns such as `{}_u_px`", JOINT_NAMES[1]);
        return Err(table.fault_of_header(reason));
    }
    Ok(columns)
}

#[cfg(test)]
mod tests {
    use evpose_pose::body::number;

    use super::*;

    fn of(text: &str) -> Result<Vec<LabelledImage>, ImportError> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("walk.csv");
        std::fs::write(&path, text).unwrap();
        read(&path)
    }

    #[test]
    fn some_joints_in_any_order_are_read() {
        let images =
            of("left_hip_v_px,head_u_px,t_s,left_hip_u_px,head_v_px,note\n2,3,0.5,1,4,a\nnan,,1,nan,,\n")
                .unwrap();
        assert_eq!(images[0].time, ImageTime::Stamp(Micros(500_000)));
        let joints_px = images[0].persons[0];
        assert_eq!(joints_px[number::HIP_L], Some(Vec2::new(1.0, 2.0)));
        assert_eq!(joints_px[number::HEAD], Some(Vec2::new(3.0, 4.0)));
        assert_eq!(joints_px.iter().flatten().count(), 2);
        assert_eq!(images[1].persons, [[None; BODY_JOINTS]]);
    }

    #[test]
    fn a_joint_that_is_not_known_or_incomplete_is_named() {
        for (text, want) in [
            ("t_us,tail_u_px,tail_v_px\n1,2,3\n", "walk.csv: line 1: column `tail_u_px`: no joint"),
            ("t_us,head_u_px\n1,2\n", "no column `head_v_px`; there are t_us, head_u_px"),
            ("t_us,head_v_px\n1,2\n", "no column `head_u_px`"),
            ("t_us,hip_l_u_px,hip_l_v_px,left_hip_u_px,left_hip_v_px\n1,2,3,4,5\n", "twice"),
            ("t_us,x\n1,2\n", "no joint: expected columns such as `shoulder_l_u_px`"),
            ("t_us,head_u_px,head_v_px\n1,2,\n", "line 2: head_v_px: missing"),
        ] {
            let message = of(text).unwrap_err().to_string();
            assert!(message.contains(want), "{message}");
        }
    }
}
