//! Layouts of the poses of other tasks than those of hands and bodies.

use evpose_core::{Registry, registry_entry};
use glam::Vec2;

/// Endings of the two values that are a position on the sensor.
const PIXELS: [&str; 2] = ["_u_px", "_v_px"];

/// The values that a pose consists of.
#[derive(Debug, PartialEq, Eq, Hash)]
pub struct PoseLayout {
    /// The name of the task.
    pub name: &'static str,
    /// The names of its values with their units: columns of tables. `NAME_u_px` and, next, `NAME_v_px`
    /// are the position of a point on the sensor, from the outer corner of the top left pixel.
    pub values: &'static [&'static str],
}

registry_entry!(PoseLayout, "layout of poses");

/// The layouts that tasks of other crates have registered: tables of them can be read.
pub static POSE_LAYOUTS: Registry<PoseLayout> = Registry::new(&[]);

impl PoseLayout {
    /// The points, by name and index of their first value.
    pub fn points(&self) -> impl Iterator<Item = (&'static str, usize)> {
        let point = |(index, names): (usize, &[&'static str])| {
            let point = names[0].strip_suffix(PIXELS[0])?;
            (names[1].strip_suffix(PIXELS[1]) == Some(point)).then_some((point, index))
        };
        self.values.windows(2).enumerate().filter_map(point)
    }

    /// The positions of the points, in pixels of the sensor.
    pub fn points_px(&self, values: &[f32]) -> Vec<Option<Vec2>> {
        let at = |index: usize| Some(Vec2::new(*values.get(index)?, *values.get(index + 1)?));
        self.points().map(|(_, index)| at(index)).collect()
    }

    /// The registered layout all of whose values have a name for which `has` holds.
    pub fn of_names(has: impl Fn(&str) -> bool) -> Option<&'static Self> {
        POSE_LAYOUTS.iter().find(|layout| layout.values.iter().all(|name| has(name))).copied()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_are_pairs_of_values_in_pixels() {
        let values = &["size_px", "tip_u_px", "tip_v_px", "end_u_px", "other_v_px"];
        let layout = PoseLayout { name: "stick", values };
        assert_eq!(layout.points().collect::<Vec<_>>(), [("tip", 1)]);
        let at = layout.points_px(&[9.0, 1.0, 2.0, 3.0, 4.0]);
        assert_eq!(at, [Some(Vec2::new(1.0, 2.0))]);
        assert_eq!(layout.points_px(&[9.0]), [None]);
    }
}
