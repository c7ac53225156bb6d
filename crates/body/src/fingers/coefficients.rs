//! The articulation coefficients whose hand comes closest to given rotations.

use super::HandRotations;
use crate::HandBasis;
use crate::pose::ARTICULATION;

/// Passes over the components. Of orthogonal ones, as those of the procedural hand and of MANO, the
/// first is exact; files of others may have any.
const PASSES: usize = 16;

impl HandBasis {
    /// The six coefficients with the least sum of squared differences of all axis-angles to
    /// `rotations` (coordinate descent).
    pub fn coefficients(&self, rotations: &HandRotations) -> [f32; ARTICULATION] {
        let angles = rotations.iter().flat_map(|rotation| rotation.to_array());
        let mut rest: Vec<f32> = angles.zip(&self.mean).map(|(angle, mean)| angle - mean).collect();
        let mut coefficients = [0.0; ARTICULATION];
        for _ in 0..PASSES {
            for (coefficient, row) in coefficients.iter_mut().zip(self.components.iter()) {
                let dot = |of: &[f32]| row.iter().zip(of).map(|(a, b)| a * b).sum::<f32>();
                let length = dot(row);
                // A component that moves nothing has no coefficient.
                if length > 0.0 {
                    let change = dot(&rest) / length;
                    *coefficient += change;
                    rest.iter_mut().zip(row).for_each(|(rest, row)| *rest -= change * row);
                }
            }
        }
        coefficients
    }
}

#[cfg(test)]
mod tests {
    use crate::procedural::hands_at_rest;

    #[test]
    fn a_hand_of_the_six_components_has_its_own_coefficients() {
        let (mut left, right) = hands_at_rest();
        // Components that are not orthogonal.
        let first = left.components[0];
        left.components[3].iter_mut().zip(first).for_each(|(to, from)| *to += 0.1 * from);
        for basis in [left, right] {
            let want = [1.5, -0.5, 2.0, 0.0, -1.0, 0.25];
            let rotations = std::array::from_fn(|joint| basis.rotation(joint, &want));
            for (got, want) in basis.coefficients(&rotations).into_iter().zip(want) {
                assert!((got - want).abs() < 1e-3, "{got} for {want}");
            }
        }
    }

    #[test]
    fn what_no_component_can_make_is_missed_by_a_right_angle() {
        let (_, basis) = hands_at_rest();
        // The seventh component is orthogonal to the six.
        let rotations = std::array::from_fn(|joint| {
            let entry =
                |axis: usize| basis.mean[3 * joint + axis] + basis.components[6][3 * joint + axis];
            glam::Vec3::from_array(std::array::from_fn(entry))
        });
        assert!(basis.coefficients(&rotations).iter().all(|value| value.abs() < 1e-4));
    }
}
