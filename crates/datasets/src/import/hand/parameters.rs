//! The 12 parameters of a hand as CSV, as `evpose infer --out` writes them.

use evpose_pose::{HandParams, PARAMETER_NAMES, PARAMETERS};

use super::format::{HandLabelFormat, HandLabels, LabelChoice, LabelledHand};
use crate::import::ImportError;
use crate::import::table::Table;

pub(super) static FORMAT: HandLabelFormat = HandLabelFormat {
    name: "parameters",
    summary: "articulation_1 to articulation_6, translation_x_m, …, rotation_x_rad, …",
    detect: |columns| columns.iter().any(|name| name == PARAMETER_NAMES[0]),
    read,
};

fn read(table: &Table, _: LabelChoice) -> Result<HandLabels, ImportError> {
    let mut columns = [0; PARAMETERS];
    for (column, name) in columns.iter_mut().zip(PARAMETER_NAMES) {
        *column = table.required(name)?;
    }
    let mut labels = Vec::new();
    for (t, row) in table.rows()? {
        if let Some(values) = table.values(row, columns)? {
            let label = HandParams::from_f64(values);
            labels.push(LabelledHand { t, label });
        }
    }
    Ok(HandLabels::Parameters(labels))
}

#[cfg(test)]
mod tests {
    use evpose_core::Micros;
    use glam::Vec3;

    use super::super::registry::read_hand_labels;
    use super::*;

    #[test]
    fn parameters_are_read_and_a_missing_one_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("p.csv");
        let header = format!("t_us,{}", PARAMETER_NAMES.join(","));
        let read = |text: &str| {
            std::fs::write(&path, text).unwrap();
            read_hand_labels(&path, LabelChoice::default())
        };
        let labels = read(&format!("{header}\n5,1,2,3,4,5,6,7,8,9,0,0,1\n9{}\n", ",".repeat(12)));
        let HandLabels::Parameters(labels) = labels.unwrap() else { panic!("not parameters") };
        assert_eq!(labels.len(), 1);
        assert_eq!(labels[0].t, Micros(5));
        assert_eq!(labels[0].label.translation_m, Vec3::new(7.0, 8.0, 9.0));
        let message = read(&header.replace("rotation_y_rad", "ry")).unwrap_err().to_string();
        assert!(message.contains("no labels"), "{message}");
        let renamed = format!("{header}\n5{}\n", ",1".repeat(12)).replace("rotation_y_rad", "ry");
        let message = read(&renamed).unwrap_err().to_string();
        assert!(message.contains("p.csv: line 1: no column `rotation_y_rad`"), "{message}");
        let message = read("t_us,a\n1,2\n").unwrap_err().to_string();
        assert!(message.contains("parameters") && message.contains("joints"), "{message}");
        assert!(message.ends_with("its columns are t_us, a"), "{message}");
    }
}
