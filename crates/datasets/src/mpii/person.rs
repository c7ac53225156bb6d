//! A person as MPII annotates it.

use evpose_containers::mat::{MatClass, MatError, MatValue};
use evpose_pose::body::{BODY_JOINTS, Visibility};
use glam::DVec2;

use crate::stills::{self, Joint, SkipReason};

/// MPII's indices of the ends of the head.
const UPPER_NECK: i64 = 8;
const HEAD_TOP: i64 = 9;
/// MPII's indices of the joints after the head, in the order of networks. The head has none: it is the
/// middle of the head's box.
pub const MPII_INDEX: [usize; BODY_JOINTS - 1] = [13, 12, 14, 11, 15, 10, 3, 2, 4, 1, 5, 0];

/// MPII's index of a joint.
fn part(joint: usize) -> Option<i64> {
    Some(MPII_INDEX[joint.checked_sub(1)?] as i64)
}

/// The field `is_visible` of a point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum VisibleField {
    /// A number.
    Number(bool),
    /// The same as a text.
    Text(bool),
    /// An empty field.
    Empty,
    /// No field.
    Missing,
}

impl VisibleField {
    /// Visibility of the point: without a statement it is labelled, and no more than that.
    /// The published program takes texts for hidden, and fails where there is no field.
    pub(super) fn visibility(self, parity: bool) -> Option<Visibility> {
        match self {
            Self::Number(true) => Some(Visibility::Visible),
            Self::Text(true) if !parity => Some(Visibility::Visible),
            Self::Missing if parity => None,
            _ => Some(Visibility::Hidden),
        }
    }
}

/// A point of a person, in pixels of the photograph.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Point {
    pub(super) part: i64,
    pub(super) at: DVec2,
    pub(super) is_visible: VisibleField,
}

/// A person, in pixels of the photograph.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Person {
    /// Two corners of the head's box.
    pub(super) head: Option<[DVec2; 2]>,
    pub(super) points: Vec<Point>,
    /// Rough position of the person.
    pub(super) center: Option<DVec2>,
}

impl Person {
    /// Reads one element of `annorect`.
    pub(super) fn read(rect: MatValue<'_>) -> Result<Self, MatError> {
        let mut corners = [0.0; 4];
        let mut has_head = true;
        for (corner, name) in corners.iter_mut().zip(["x1", "y1", "x2", "y2"]) {
            match rect.filled_field(name)? {
                Some(value) => *corner = value.scalar()?,
                None => has_head = false,
            }
        }
        let [x1, y1, x2, y2] = corners;
        let head = has_head.then_some([DVec2::new(x1, y1), DVec2::new(x2, y2)]);
        let points = match rect.filled_field("annopoints")? {
            Some(annopoints) => match annopoints.filled_field("point")? {
                Some(points) => points.elements()?.map(point).collect::<Result<_, _>>()?,
                None => Vec::new(),
            },
            None => Vec::new(),
        };
        let center = rect.filled_field("objpos")?.map(position).transpose()?;
        Ok(Self { head, points, center })
    }

    /// The first point of a part.
    pub(super) fn point(&self, part: i64) -> Option<&Point> {
        self.points.iter().find(|point| point.part == part)
    }

    /// The middle of the head's box, or without one that between upper neck and top of the head.
    pub(super) fn head_center(&self) -> Option<DVec2> {
        let ends =
            self.head.or_else(|| Some([self.point(UPPER_NECK)?.at, self.point(HEAD_TOP)?.at]));
        ends.map(|[a, b]| (a + b) / 2.0)
    }

    /// Position of a joint.
    pub(super) fn joint(&self, joint: usize) -> Option<DVec2> {
        match part(joint) {
            None => self.head_center(),
            Some(part) => self.point(part).map(|point| point.at),
        }
    }

    /// The person as all sets have it; without a head or a middle it is none to cut out, with `parity`
    /// neither without the head's box, as published.
    pub(super) fn to_still(&self, parity: bool) -> stills::Person {
        let joint = |joint: usize| {
            let visibility = match part(joint) {
                // The head is no annotated point: no flag says that it is hidden.
                None => Some(Visibility::Visible),
                Some(part) => self.point(part)?.is_visible.visibility(parity),
            };
            Some(Joint { at: self.joint(joint)?, visibility })
        };
        // The published program knows no head but that of the box.
        let head = if parity { self.head.map(|[a, b]| (a + b) / 2.0) } else { self.head_center() };
        let fault = match (head, self.center) {
            (None, _) => Some(SkipReason::NoHeadBox),
            (_, None) => Some(SkipReason::NoCenter),
            (Some(head), Some(center)) => {
                let is_finite = head.is_finite() && center.is_finite();
                (!is_finite).then_some(SkipReason::PointsOutside)
            }
        };
        stills::Person {
            points: self.points.iter().map(|point| point.at).collect(),
            joints: std::array::from_fn(joint),
            head_box: self.head,
            center: self.center,
            fault,
        }
    }
}

fn position(value: MatValue<'_>) -> Result<DVec2, MatError> {
    Ok(DVec2::new(value.field("x")?.scalar()?, value.field("y")?.scalar()?))
}

fn point(value: MatValue<'_>) -> Result<Point, MatError> {
    let is_visible = if !value.field_names().iter().any(|name| name == "is_visible") {
        VisibleField::Missing
    } else {
        match value.filled_field("is_visible")? {
            None => VisibleField::Empty,
            // The release has this flag as text in some entries and as a number in others.
            Some(seen) if seen.class() == MatClass::Char => {
                VisibleField::Text(seen.text()?.trim() == "1")
            }
            Some(seen) => VisibleField::Number(seen.scalar()? == 1.0),
        }
    };
    Ok(Point { part: value.field("id")?.integer()?, at: position(value)?, is_visible })
}
