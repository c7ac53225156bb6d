//! From labels to the target maps of the network.

mod blob;

use evpose_pose::body::{BodyDecoder, BodyLabel, BodyMaps, DEFAULT_THRESHOLD, Keypoint};
use glam::Vec2;

use blob::Blobs;

/// Pixels of the network's input for each cell, along either side.
const CELL_PX: usize = 4;
/// Distance from the cell of the centre up to which regressions are written, in cells.
const REG_REACH: usize = 2;
/// Extra rows and columns of the blobs of body centres, as published.
const CENTER_SIZE: usize = 2;

/// Makes the targets of training, for maps of one size.
///
/// # Model
/// A joint is in the cell that its position falls into.
/// - Heatmaps have a blob at the cell of the joint and at those of other persons' joints, or
///   nothing at all if the joint is not known. The map of centres has larger blobs at the middles
///   of all. The more of the image the person fills, the larger are blobs.
/// - Regressions are read where [`BodyDecoder`] finds the middle on the map of this person alone,
///   at most a cell from it. At all cells up to two from the middle, they lead from that cell to
///   the joint's.
/// - Offsets, at the joint's cell, are from its corner to the joint.
///
/// Joints outside of the image are not known.
///
/// With `parity` targets are as published, for comparisons:
/// - blobs lack their last column and row;
/// - offsets are those of the pixel's corner: 0, 1/4, 1/2 or 3/4;
/// - regressions beside the middle's cell have the wrong sign left of column 23 and above row 23 of
///   48;
/// - regressions are read where a decoder finds the middle among all persons: at that of another,
///   they are 0;
/// - joints outside of the image count as known: their heatmap is empty, their regression 0, and
///   their offset is that from the body's middle.
///
/// # Source
/// Goyal et al.: *MoveEnet*, CVPRW 2023, and its published code.
#[derive(Debug, Clone)]
pub struct BodyGrid {
    side: usize,
    parity: bool,
    blobs: Blobs,
    decoder: BodyDecoder,
}

/// Memory for the targets of one sample: see [`evpose_nn::BodyTargets`].
#[derive(Debug)]
pub struct BodyTargetSlices<'a> {
    /// `[joints][side][side]`.
    pub heatmaps: &'a mut [f32],
    /// `[side][side]`.
    pub centers: &'a mut [f32],
    /// The cell at which regressions are read, row by row.
    pub center_cell: &'a mut i32,
    /// The cells at which offsets are read.
    pub joint_cells: &'a mut [i32],
    /// `[joints][x, y]`, in cells.
    pub regs: &'a mut [[f32; 2]],
    /// `[joints][x, y]`, in cells.
    pub offsets: &'a mut [[f32; 2]],
    /// 1 for joints that are known, 0 for others.
    pub known: &'a mut [f32],
}

/// Column and row.
type Cell = [usize; 2];

#[derive(Debug, Clone, Copy)]
struct JointTarget {
    /// The cell it is in; none if it is not known, or outside of the image.
    cell: Option<Cell>,
    offset_cell: Cell,
    offset: [f32; 2],
    is_known: bool,
}

impl BodyGrid {
    /// For maps of `side` rows and columns: a quarter of the network's input.
    ///
    /// # Panics
    /// If `side` is zero.
    pub fn new(side: usize, parity: bool) -> Self {
        assert!(side > 0, "maps without cells");
        let decoder = BodyDecoder::new([side; 2], DEFAULT_THRESHOLD);
        let decoder = if parity { decoder.as_published() } else { decoder };
        Self { side, parity, blobs: Blobs::new(side, parity), decoder }
    }

    /// Rows and columns of maps.
    pub fn side(&self) -> usize {
        self.side
    }

    /// Writes the targets of a label.
    ///
    /// # Panics
    /// If slices are not of this size, or of another number of joints than the label.
    pub fn write(&self, label: &BodyLabel, out: &mut BodyTargetSlices<'_>) {
        let joints = label.keypoints.len();
        assert_eq!(out.joint_cells.len(), joints, "a cell for each joint");
        assert_eq!([out.regs.len(), out.offsets.len()], [joints; 2], "two values for each joint");
        assert_eq!(out.known.len(), joints, "a value for each joint");
        let middle = self.middle(label);
        let read_at = self.likelihoods(label, middle, out.heatmaps, out.centers);
        *out.center_cell = self.index(read_at) as i32;
        for (joint, keypoint) in label.keypoints.iter().enumerate() {
            let target = self.joint(keypoint, middle);
            // Where the published loss looks for offsets is what regressions there say.
            let reg = self.reg(&target, middle, read_at);
            let at = std::array::from_fn(|axis| {
                (read_at[axis] as f32 + reg[axis]).clamp(0.0, (self.side - 1) as f32) as usize
            });
            out.regs[joint] = reg;
            out.offsets[joint] = if at == target.offset_cell { target.offset } else { [0.0; 2] };
            out.joint_cells[joint] = self.index(at) as i32;
            out.known[joint] = f32::from(target.is_known);
        }
    }

    /// Writes whole maps, `[channels][side][side]` each: the output of a perfect network, at the
    /// cells that the loss reads.
    ///
    /// # Panics
    /// If slices are not of this size.
    pub fn write_maps(&self, label: &BodyLabel, maps: &mut BodyMaps<&mut [f32]>) {
        let cells = self.side * self.side;
        let joints = label.keypoints.len();
        assert_eq!(maps.regs.len(), 2 * joints * cells, "two regressions for each joint");
        assert_eq!(maps.offsets.len(), 2 * joints * cells, "two offsets for each joint");
        let middle = self.middle(label);
        self.likelihoods(label, middle, maps.heatmaps, maps.centers);
        maps.regs.fill(0.0);
        maps.offsets.fill(0.0);
        let around = |at: usize| at.saturating_sub(REG_REACH)..(at + REG_REACH + 1).min(self.side);
        for (joint, keypoint) in label.keypoints.iter().enumerate() {
            let target = self.joint(keypoint, middle);
            for y in around(middle[1]) {
                for x in around(middle[0]) {
                    let reg = self.reg(&target, middle, [x, y]);
                    for (axis, value) in reg.into_iter().enumerate() {
                        maps.regs[(2 * joint + axis) * cells + self.index([x, y])] = value;
                    }
                }
            }
            for (axis, value) in target.offset.into_iter().enumerate() {
                let cell = self.index(target.offset_cell);
                maps.offsets[(2 * joint + axis) * cells + cell] = value;
            }
        }
    }

    /// Writes both maps of likelihoods; where regressions are read.
    fn likelihoods(
        &self,
        label: &BodyLabel,
        middle: Cell,
        heatmaps: &mut [f32],
        centers: &mut [f32],
    ) -> Cell {
        let cells = self.side * self.side;
        assert_eq!(heatmaps.len(), label.keypoints.len() * cells, "a heatmap for each joint");
        assert_eq!(centers.len(), cells, "one map of centres");
        heatmaps.fill(0.0);
        centers.fill(0.0);
        let size = blob::size(label);
        for (joint, heatmap) in heatmaps.chunks_exact_mut(cells).enumerate() {
            let keypoint = &label.keypoints[joint];
            let Some(cell) = self.cell(keypoint.position).filter(|_| keypoint.is_labelled()) else {
                continue;
            };
            self.blobs.add(heatmap, cell, size);
            // Joints of other people are joints: a network must not learn to suppress them.
            let others = label.other_keypoints.get(joint).into_iter().flatten();
            others.filter_map(|&at| self.cell(at)).for_each(|at| self.blobs.add(heatmap, at, size));
        }
        // Where nobody is, there is no middle.
        if self.parity || label.keypoints.iter().any(Keypoint::is_labelled) {
            self.blobs.add(centers, middle, size + CENTER_SIZE);
        }
        // Found before others are added: the regressions are those of this person.
        let alone = self.decoder.center_cell(centers);
        for at in label.other_centers.iter().filter_map(|&at| self.cell(at)) {
            self.blobs.add(centers, at, size + CENTER_SIZE);
        }
        let read_at = if self.parity { self.decoder.center_cell(centers) } else { alone };
        [read_at % self.side, read_at / self.side]
    }

    fn joint(&self, keypoint: &Keypoint, middle: Cell) -> JointTarget {
        let cell = self.cell(keypoint.position).filter(|_| keypoint.is_labelled());
        let is_known = cell.is_some() || (self.parity && keypoint.is_labelled());
        let offset_cell = cell.unwrap_or(middle);
        let offset = |axis: usize| {
            let position = f64::from(keypoint.position[axis]) * self.side as f64;
            let pixels = position * CELL_PX as f64;
            let position = if self.parity { pixels.trunc() / CELL_PX as f64 } else { position };
            (position - offset_cell[axis] as f64) as f32
        };
        let offset = if is_known { [offset(0), offset(1)] } else { [0.0; 2] };
        JointTarget { cell, offset_cell, offset, is_known }
    }

    /// The regression from a cell to a joint.
    fn reg(&self, target: &JointTarget, middle: Cell, at: Cell) -> [f32; 2] {
        let is_near = (0..2).all(|axis| at[axis].abs_diff(middle[axis]) <= REG_REACH);
        let Some(cell) = target.cell.filter(|_| is_near) else {
            return [0.0; 2];
        };
        std::array::from_fn(|axis| {
            let [cell, at, middle] = [cell[axis], at[axis], middle[axis]].map(|i| i as f32);
            // There the published program subtracts the way to the middle where it should add it.
            let is_turned = self.parity && middle < self.side as f32 / 2.0 - 1.0;
            if is_turned { (cell - middle) - (middle - at) } else { cell - at }
        })
    }

    /// The cell of a person's middle, the nearest one if that is outside.
    fn middle(&self, label: &BodyLabel) -> Cell {
        // Casts saturate at zero.
        label
            .center
            .to_array()
            .map(|at| ((f64::from(at) * self.side as f64).floor() as usize).min(self.side - 1))
    }

    /// The cell that a position falls into; none if that is outside of the image.
    fn cell(&self, position: Vec2) -> Option<Cell> {
        let along = |at: f32| {
            // The border belongs to the last cell; as published, so does a cell's width beyond it.
            let at = f64::from(at) * self.side as f64;
            let last = if self.parity { at.floor() } else { at };
            (at >= 0.0 && last <= self.side as f64).then(|| (at as usize).min(self.side - 1))
        };
        Some([along(position.x)?, along(position.y)?])
    }

    fn index(&self, [x, y]: Cell) -> usize {
        y * self.side + x
    }
}

#[cfg(test)]
mod tests;
