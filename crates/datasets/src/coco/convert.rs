//! COCO into images of persons.

use std::path::Path;

use evpose_pose::body::{BODY_JOINTS, Visibility, number};

use super::file::{self, CocoPerson};
use super::keypoint::NamedKeypoint;
use crate::DatasetError;
use crate::stills::{
    self, Converted, Joint, Person, PersonFault, Photograph, SkipReason, StillOptions, StillSet,
    leave_out_exchanged,
};

/// Converts the photographs of a file of keypoints, which is `options.annotations`.
///
/// Crowds are left out, and persons whose left and right seem to be exchanged.
///
/// # Errors
/// As [`stills`](crate::stills) has them.
pub fn convert(
    options: &StillOptions,
    progress: &(dyn Fn(u64, u64) + Sync),
) -> Result<Converted, DatasetError> {
    let read = |path: &Path, bytes: &[u8]| {
        let images = file::parse(path, bytes)?.into_iter().enumerate();
        let mut photographs: Vec<Photograph> = images
            .map(|(index, image)| Photograph {
                index,
                name: image.file_name,
                persons: image.persons.iter().map(person).collect(),
            })
            .collect();
        leave_out_exchanged(&mut photographs);
        Ok(StillSet { name: "coco", photographs, not_for_training: 0 })
    };
    stills::convert(options, read, progress)
}

/// A person of keypoints; the head is visible where any point of the face is.
fn person(person: &CocoPerson) -> Result<Person, PersonFault> {
    if person.is_crowd {
        return Err(PersonFault { reason: SkipReason::Crowd, detail: None });
    }
    let seen = |joint: usize| {
        let is_of = |name: NamedKeypoint| match name {
            NamedKeypoint::Joint(index) => index == joint,
            NamedKeypoint::Face => joint == number::HEAD,
        };
        let keypoints = &person.keypoints;
        keypoints.iter().any(|(name, _, seen)| is_of(*name) && *seen == Visibility::Visible)
    };
    let joints_px = person.joints_px();
    let joints: [Option<Joint>; BODY_JOINTS] = std::array::from_fn(|joint| {
        let visibility = if seen(joint) { Visibility::Visible } else { Visibility::Hidden };
        Some(Joint { at: joints_px[joint]?.as_dvec2(), visibility: Some(visibility) })
    });
    let points = person.keypoints.iter().map(|(_, at_px, _)| at_px.as_dvec2()).collect();
    Ok(Person::of_joints(points, joints))
}
