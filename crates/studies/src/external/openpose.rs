//! Networks of OpenPose.

use std::path::Path;

use anyhow::Result;
use evpose_core::Plane;
use evpose_pose::body::{BODY_JOINTS, BodyJoint, OpenPoseDecoder, OpenPoseModel, OpenPoseOptions};

use crate::external::runtime::OnnxModel;
use crate::external::{ImageNetwork, Letterbox};

/// Width and height of an input whose size the file leaves open, in pixels: OpenPose's height, for
/// images of four to three.
const OPEN_SIZE_PX: [usize; 2] = [496, 368];
/// Greys are divided by this, and centred.
const GREY_SCALE: f32 = 256.0;
/// Shapes of outputs, in words.
const NEEDED: &str = "heatmaps of 19 (COCO) or 26 (BODY_25) channels and fields of 38 or 52, or both in one \
                      output of 57 or 78";

/// A network of OpenPose, COCO or BODY_25, or of lightweight OpenPose.
///
/// # Model
/// Input: blue, green and red, `grey / 256 - 0.5`, the image in the middle and black around it.
/// Outputs: heatmaps and part-affinity fields, of several stages the last; one output of both has
/// heatmaps first, as Caffe's.
///
/// # Source
/// Cao et al., TPAMI 2019; Osokin: *Real-time 2D Multi-Person Pose Estimation on CPU: Lightweight OpenPose*,
/// 2018, which has the same parts, limbs and channels.
pub struct OpenPose {
    model: OnnxModel,
    kind: OpenPoseModel,
    maps: Maps,
    decoder: OpenPoseDecoder,
}

/// Outputs that hold heatmaps and fields.
#[derive(Debug, Clone, Copy)]
enum Maps {
    /// Heatmaps, then fields.
    Together(MapShape),
    Apart {
        heatmaps: MapShape,
        fields: MapShape,
    },
}

/// An output of maps, `[1, channels, rows, columns]` or `[1, rows, columns, channels]`.
#[derive(Debug, Clone, Copy)]
struct MapShape {
    output: usize,
    channels: usize,
    rows: usize,
    columns: usize,
    is_channels_last: bool,
}

impl OpenPose {
    /// Opens an ONNX file.
    ///
    /// # Errors
    /// If it cannot be read, is another network, or there is no runtime.
    pub fn open(path: &Path) -> Result<Self> {
        let model = OnnxModel::open(path, OPEN_SIZE_PX)?;
        let found = OpenPoseModel::ALL
            .into_iter()
            .find_map(|kind| Some((kind, Maps::of(kind, model.output_shapes())?)));
        let Some((kind, maps)) = found else {
            return Err(model.other_outputs("OpenPose", NEEDED));
        };
        let (Maps::Together(shape) | Maps::Apart { heatmaps: shape, .. }) = maps;
        // Maps may be a pixel larger or smaller than the input over the stride.
        let stride = model.input_px()[1].div_ceil(shape.rows).next_power_of_two();
        let options = OpenPoseOptions { stride, ..OpenPoseOptions::default() };
        let decoder = OpenPoseDecoder::new(kind, [shape.rows, shape.columns], options);
        Ok(Self { model, kind, maps, decoder })
    }
}

impl ImageNetwork for OpenPose {
    fn joints(&self, image: &Plane<u8>) -> Result<[BodyJoint; BODY_JOINTS]> {
        let input_px = self.model.input_px();
        let letterbox = Letterbox::new([image.width(), image.height()], input_px);
        let mut input = letterbox.input(image, input_px);
        // As OpenPose scales its input.
        input.iter_mut().for_each(|grey| *grey = *grey / GREY_SCALE - 0.5);
        let outputs = self.model.run(&input)?;
        let of = |shape: MapShape| shape.planes(&outputs[shape.output]);
        let (heatmaps, fields) = match self.maps {
            Maps::Apart { heatmaps, fields } => (of(heatmaps), of(fields)),
            Maps::Together(shape) => {
                let mut heatmaps = of(shape);
                let cells = shape.rows * shape.columns;
                let fields = heatmaps.split_off(self.kind.heatmap_channels() * cells);
                (heatmaps, fields)
            }
        };
        Ok(letterbox.joints(self.decoder.joints(&heatmaps, &fields)))
    }

    fn description(&self) -> String {
        let [width, height] = self.model.input_px();
        format!("OpenPose, {} parts, {width}x{height} px", self.kind.parts())
    }
}

impl Maps {
    /// The outputs of a model among these; none if they are of another.
    fn of(kind: OpenPoseModel, shapes: &[Vec<usize>]) -> Option<Self> {
        let (parts, fields) = (kind.heatmap_channels(), kind.field_channels());
        // Of several stages the last.
        let last = |channels: usize| {
            let of = |(output, shape): (usize, &Vec<usize>)| MapShape::new(output, shape, channels);
            shapes.iter().enumerate().rev().find_map(of)
        };
        if let Some(together) = last(parts + fields) {
            return Some(Self::Together(together));
        }
        let (heatmaps, fields) = (last(parts)?, last(fields)?);
        // The decoder reads a part and its limbs at the same cell.
        let are_equal = [heatmaps.rows, heatmaps.columns] == [fields.rows, fields.columns];
        are_equal.then_some(Self::Apart { heatmaps, fields })
    }
}

impl MapShape {
    /// The shape of an output if it is of maps with so many channels.
    fn new(output: usize, shape: &[usize], channels: usize) -> Option<Self> {
        let &[1, a, b, c] = shape else { return None };
        let (rows, columns, is_channels_last) = match channels {
            // Channels first is ONNX's own order, and wins where both would fit.
            _ if a == channels => (b, c, false),
            _ if c == channels => (a, b, true),
            _ => return None,
        };
        Some(Self { output, channels, rows, columns, is_channels_last })
    }

    /// The values of an output, channel by channel.
    fn planes(&self, values: &[f32]) -> Vec<f32> {
        if !self.is_channels_last {
            return values.to_vec();
        }
        let channel = |channel| values.iter().skip(channel).step_by(self.channels);
        (0..self.channels).flat_map(channel).copied().collect()
    }
}
