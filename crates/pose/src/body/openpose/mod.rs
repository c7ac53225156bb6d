//! Decoding of OpenPose: heatmaps and part-affinity fields to people.
//!
//! * [`OpenPoseModel`]: parts, limbs and channels.
//! * [`OpenPoseDecoder`]: upsampling, peaks, line integrals, greedy assembly, the best person.

mod assembly;
mod connections;
mod model;
mod peaks;
mod upsampling;

use glam::Vec2;

use super::coco::joints_of_coco;
use super::{BODY_JOINTS, BodyJoint};
use assembly::{Assembly, assemble};
use connections::connections;
pub use model::OpenPoseModel;
use peaks::{Peak, peaks};
use upsampling::{FineMap, upsample};

/// Thresholds of the decoding.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OpenPoseOptions {
    /// Pixels of the network's input for each cell of its maps.
    pub stride: usize,
    /// Minimum value of a heatmap's peak.
    pub min_peak: f32,
    /// Minimum component of the field along a line, for a sample to agree with it.
    pub min_field: f32,
    /// Share of samples of a line that must agree.
    pub min_agreement: f32,
    /// Minimum number of parts of a person.
    pub min_parts: usize,
    /// Minimum score of a person, for each of its parts.
    pub min_score: f32,
}

impl Default for OpenPoseOptions {
    /// Those of OpenPose, with whose names they are: `nms_threshold`, `connect_inter_threshold`,
    /// `connect_inter_min_above_threshold`, `connect_min_subset_cnt`, `connect_min_subset_score`.
    fn default() -> Self {
        Self {
            stride: 8,
            min_peak: 0.05,
            min_field: 0.05,
            min_agreement: 0.95,
            min_parts: 3,
            min_score: 0.4,
        }
    }
}

/// A person that was put together.
#[derive(Debug, Clone, PartialEq)]
pub struct OpenPosePerson {
    /// Parts in the order of the model. Positions are relative to the network's input; the score is
    /// that of the heatmap.
    pub parts: Vec<BodyJoint>,
    /// Sum of the scores of parts and of the fields between them.
    pub score: f32,
}

/// Decodes maps of one model and size.
///
/// # Model
/// Maps are upsampled bicubically to the resolution of the network's input. A part's candidates are
/// local maxima of its heatmap. Two candidates of a limb are connected as much as the limb's
/// part-affinity field points along the line between them. Connections are put together greedily,
/// the best first.
///
/// # Source
/// Cao et al.: *OpenPose: Realtime Multi-Person 2D Pose Estimation using Part Affinity Fields*, TPAMI
/// 2019, and its program.
#[derive(Debug, Clone)]
pub struct OpenPoseDecoder {
    model: OpenPoseModel,
    rows: usize,
    columns: usize,
    options: OpenPoseOptions,
}

impl OpenPoseDecoder {
    /// A decoder of maps of `rows` by `columns` cells.
    pub fn new(
        model: OpenPoseModel,
        [rows, columns]: [usize; 2],
        options: OpenPoseOptions,
    ) -> Self {
        Self { model, rows, columns, options }
    }

    /// All people, the one of the highest score first. Heatmaps are `[parts + 1][rows][columns]`,
    /// fields `[2 limbs][rows][columns]`.
    ///
    /// # Panics
    /// If maps are of another size.
    pub fn people(&self, heatmaps: &[f32], fields: &[f32]) -> Vec<OpenPosePerson> {
        let cells = self.rows * self.columns;
        assert_eq!(heatmaps.len(), self.model.heatmap_channels() * cells, "heatmaps of this size");
        assert_eq!(fields.len(), self.model.field_channels() * cells, "fields of this size");
        // Map by map, since they are large at this resolution.
        let fine = |maps: &[f32], channel: usize| -> FineMap {
            let map = &maps[channel * cells..][..cells];
            upsample(map, [self.rows, self.columns], self.options.stride)
        };
        let candidates: Vec<Vec<Peak>> = (0..self.model.parts())
            .map(|part| peaks(&fine(heatmaps, part), self.options.min_peak))
            .collect();
        let mut found = Vec::new();
        for (index, limb) in self.model.limbs().iter().enumerate() {
            // Without a part there is no limb: its fields need not be enlarged.
            if limb.parts.iter().any(|part| candidates[*part].is_empty()) {
                continue;
            }
            let field = [0, 1].map(|axis| fine(fields, limb.channel + axis));
            found.extend(connections((index, limb), &candidates, &field, &self.options));
        }
        let OpenPoseOptions { min_parts, min_score, .. } = self.options;
        let mut people: Vec<OpenPosePerson> = assemble(found, self.model.limbs(), &candidates)
            // Few parts, or weak ones, are no person.
            .iter()
            .filter(|person| person.len() >= min_parts)
            .filter(|person| person.score >= min_score * person.len() as f32)
            .map(|person| self.person(person, &candidates))
            .collect();
        people.sort_by(|a, b| b.score.total_cmp(&a.score));
        people
    }

    /// The thirteen joints, in the order of networks, of the person of the highest score; nothing is
    /// detected where there is nobody. Otherwise as [`people`](Self::people); the head is made as
    /// [`joints_of_coco`] says.
    ///
    /// # Panics
    /// If maps are of another size.
    pub fn joints(&self, heatmaps: &[f32], fields: &[f32]) -> [BodyJoint; BODY_JOINTS] {
        match self.people(heatmaps, fields).first() {
            Some(person) => joints_of_coco(&self.model.coco_parts().map(|part| person.parts[part])),
            None => [BodyJoint { position: None, score: 0.0 }; BODY_JOINTS],
        }
    }

    fn person(&self, person: &Assembly, candidates: &[Vec<Peak>]) -> OpenPosePerson {
        let size_px = Vec2::new(self.columns as f32, self.rows as f32) * self.options.stride as f32;
        let part = |(of_part, chosen): (&Vec<Peak>, &Option<usize>)| match chosen {
            Some(index) => {
                let Peak { at_px, score } = of_part[*index];
                // Pixels count from the middle of the first, relative positions from its edge.
                BodyJoint { position: Some((at_px + 0.5) / size_px), score }
            }
            None => BodyJoint { position: None, score: 0.0 },
        };
        let parts = candidates.iter().zip(&person.parts).map(part).collect();
        OpenPosePerson { parts, score: person.score }
    }
}

#[cfg(test)]
mod tests;
