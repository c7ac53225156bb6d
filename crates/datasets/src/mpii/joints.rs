//! Joints of the persons on annotated images, without the images.

use std::path::Path;

use evpose_pose::body::BodyPoints;

use super::release::Release;
use crate::DatasetError;
use crate::open::open_mat;

/// An annotated image.
#[derive(Debug, Clone, PartialEq)]
pub struct MpiiImage {
    /// Name of the file in the folder of images.
    pub name: String,
    /// Joints of each person in pixels, in the order of networks; none where not annotated.
    pub persons: Vec<BodyPoints>,
}

/// Reads the joints of a MAT-file in MPII's layout. Images without a flag in `img_train` are
/// skipped: their joints are not published.
///
/// # Errors
/// If the file cannot be read, or an annotation is damaged.
pub fn read_joints(path: &Path) -> Result<Vec<MpiiImage>, DatasetError> {
    let release = Release::read(path, &open_mat(path)?)?;
    let image = |photograph: super::release::MpiiPhotograph| {
        let persons = photograph.persons.into_iter().map(|person| {
            let person = person.map_err(DatasetError::mat(path))?;
            Ok(std::array::from_fn(|joint| person.joint(joint).map(|at| at.as_vec2())))
        });
        let persons = persons.collect::<Result<_, DatasetError>>()?;
        Ok(MpiiImage { name: photograph.name, persons })
    };
    release.photographs.into_iter().map(image).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn joints_of_an_image_are_in_its_pixels() {
        let golden = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden/mpii/release.mat");
        let Ok(images) = read_joints(&golden) else {
            // One of the persons in it is damaged on purpose, which is an error here.
            let message = read_joints(&golden).unwrap_err().to_string();
            assert!(message.contains("release.mat"), "{message}");
            return;
        };
        assert_eq!(images[0].name, "a.png");
        assert!(images[0].persons[0].iter().flatten().count() > 8);
    }
}
