//! The part of a video that becomes the image of the event camera.
//!
//! # Model
//! 1. The box of all joints of all frames of a clip: one part for the whole clip, lest it jump.
//! 2. 10 pixels more on each side.
//! 3. If that fits into 640x480 pixels, those around its middle; else the least part of that shape around
//!    it, at most as wide and as high as the frame.
//! 4. Moved back into the frame where it sticks out.
//!
//! A part that is higher than 3/4 of the frame's width is as wide as the frame and then narrower than that
//! shape: it is stretched where it is resized.
//!
//! # Variants
//! The published program adds the 20 pixels of a margin at the right and the bottom, drops fractions on the
//! way, takes every frame to be of 1000x1000 pixels, and leaves parts of 640x480 where they stick out.
//!
//! # Source
//! Goyal et al., *MoveEnet*, CVPRW 2023, Algorithm 1; hpe-core, `datasets/h36m/Run_v2e_on_h36m.py` and
//! `export_to_yarp.py`.

use std::fmt;

use glam::{DVec2, IVec2, Vec2};

use super::SENSOR;

/// Pixels around the joints.
const MARGIN_PX: f32 = 10.0;
/// Size that the published program assumes for each frame.
const PUBLISHED_FRAME: i32 = 1000;

/// How parts are chosen, and joints placed in them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum CropRule {
    /// As the paper says.
    #[default]
    Paper,
    /// As the published program does it.
    Published,
}

/// Margins that are cropped from a frame, in pixels. Displayed as in the published list: `left,right,top,bottom`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Crop {
    /// At the left.
    pub left: i32,
    /// At the right.
    pub right: i32,
    /// At the top.
    pub top: i32,
    /// At the bottom.
    pub bottom: i32,
}

impl Crop {
    /// The part of frames of `frame_px` columns and rows that holds these joints; none if there are none
    /// or one is nowhere.
    pub fn around(
        joints_px: impl IntoIterator<Item = Vec2>,
        frame_px: IVec2,
        rule: CropRule,
    ) -> Option<Self> {
        let mut joints_px = joints_px.into_iter();
        let first = joints_px.next()?;
        // `min` and `max` pass over NaN: it is looked for by itself.
        let mut are_finite = first.is_finite();
        let (least, most) = joints_px.fold((first, first), |(least, most), joint| {
            are_finite &= joint.is_finite();
            (least.min(joint), most.max(joint))
        });
        are_finite.then(|| match rule {
            CropRule::Paper => paper(least - MARGIN_PX, most + MARGIN_PX, frame_px),
            CropRule::Published => published(least, most),
        })
    }

    /// Columns and rows that are left of a frame.
    pub fn size(&self, frame_px: IVec2) -> IVec2 {
        frame_px - IVec2::new(self.left + self.right, self.top + self.bottom)
    }

    /// Whether all of it is inside the frame and it holds a pixel.
    pub fn is_inside(&self, frame_px: IVec2) -> bool {
        let cuts = [self.left, self.right, self.top, self.bottom];
        cuts.iter().all(|cut| *cut >= 0) && self.size(frame_px).cmpgt(IVec2::ZERO).all()
    }

    /// Maps a point of a frame to the event camera. The published program crops another column
    /// and another row before it measures the rest, and rounds to whole pixels, halves to even.
    pub fn place(&self, point_px: Vec2, frame_px: IVec2, rule: CropRule) -> Vec2 {
        let sensor = Vec2::new(SENSOR.width.into(), SENSOR.height.into());
        let corner = Vec2::new(self.left as f32, self.top as f32);
        let rest = self.size(frame_px);
        match rule {
            CropRule::Paper => (point_px - corner) * sensor / rest.as_vec2(),
            CropRule::Published => {
                let at = (point_px - corner) * sensor / (rest - 1).as_vec2();
                Vec2::new(at.x.round_ties_even(), at.y.round_ties_even())
            }
        }
    }
}

impl fmt::Display for Crop {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { left, right, top, bottom } = self;
        f.pad(&format!("{left},{right},{top},{bottom}"))
    }
}

fn paper(least: Vec2, most: Vec2, frame_px: IVec2) -> Crop {
    let sensor = Vec2::new(SENSOR.width.into(), SENSOR.height.into());
    let size = most - least;
    let aspect = sensor.x / sensor.y;
    // A person smaller than the sensor is not enlarged.
    let size = if size.cmple(sensor).all() {
        sensor
    } else {
        Vec2::new(size.x.max(size.y * aspect), size.y.max(size.x / aspect))
    };
    let middle = 0.5 * (least + most);
    // Along one axis: the first pixel, and the first behind.
    let span = |middle: f32, size: f32, frame: i32| {
        let size = (size.ceil() as i32).min(frame);
        let first = (middle - 0.5 * size as f32).round_ties_even() as i32;
        let first = first.clamp(0, frame - size);
        (first, frame - first - size)
    };
    let (left, right) = span(middle.x, size.x, frame_px.x.max(0));
    let (top, bottom) = span(middle.y, size.y, frame_px.y.max(0));
    Crop { left, right, top, bottom }
}

/// In the precision that NumPy had it: the extent in 32 bits, all else in 64.
fn published(least: Vec2, most: Vec2) -> Crop {
    let sensor = DVec2::new(SENSOR.width.into(), SENSOR.height.into());
    let mut size = (most - least).as_dvec2() + 2.0 * f64::from(MARGIN_PX);
    let mut middle = (least.as_dvec2() + 0.5 * size).as_ivec2();
    // The shorter side grows to 4 to 3, so that no joint is cut off.
    let is_small = size.cmplt(sensor).all();
    if is_small {
        size = sensor;
    } else if 0.75 * size.x > size.y {
        size.y = 0.75 * size.x;
    } else {
        size.x = size.y / 0.75;
    }
    let frame = f64::from(PUBLISHED_FRAME);
    for axis in [0, 1] {
        if size[axis] > frame {
            size[axis] = frame;
            middle[axis] = PUBLISHED_FRAME / 2;
        }
    }
    // Along one axis: what is cut off before and behind.
    let cuts = |axis: usize| {
        let mut before = middle[axis] - (0.5 * size[axis]) as i32;
        let mut behind = PUBLISHED_FRAME - (f64::from(middle[axis]) + 0.5 * size[axis]) as i32;
        // As published, small crops may reach beyond the frame.
        if before < 0 && !is_small {
            (before, behind) = (0, behind + before);
        }
        if behind < 0 && !is_small {
            (before, behind) = (before + behind, 0);
        }
        (before, behind)
    };
    let ((left, right), (top, bottom)) = (cuts(0), cuts(1));
    Crop { left, right, top, bottom }
}

#[cfg(test)]
mod tests;
