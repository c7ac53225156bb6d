//! A set in two: for training and for validation.

use std::collections::BTreeSet;

use evpose_core::seed_for;

use crate::Annotation;

/// A set in two.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Split {
    /// To train on.
    pub training: Vec<Annotation>,
    /// Group for the evaluation.
    pub validation: Vec<Annotation>,
}

/// Splits a set by groups, so that what belongs together stays together: persons of one photograph,
/// frames of one recording, recordings of one subject. `group` names the group of an annotation.
///
/// `validation_share` of the groups, rounded to a whole number of them, is for validation; which
/// ones depends on the seed and their names, not on the order of the annotations.
pub fn split_by_group<'a>(
    annotations: &'a [Annotation],
    validation_share: f64,
    seed: u64,
    group: impl Fn(&'a Annotation) -> &'a str,
) -> Split {
    let groups: BTreeSet<&str> = annotations.iter().map(&group).collect();
    let mut drawn: Vec<(u64, &str)> =
        groups.into_iter().map(|name| (seed_for(seed, name, 0), name)).collect();
    drawn.sort_unstable();
    let count = (validation_share.clamp(0.0, 1.0) * drawn.len() as f64).round() as usize;
    let chosen: BTreeSet<&str> = drawn.iter().take(count).map(|&(_, name)| name).collect();
    let mut split = Split::default();
    for annotation in annotations {
        let is_chosen = chosen.contains(group(annotation));
        let part = if is_chosen { &mut split.validation } else { &mut split.training };
        part.push(annotation.clone());
    }
    split
}

#[cfg(test)]
mod tests {
    use evpose_pose::body::BodyLabel;

    use super::*;
    use crate::stills::photograph_of_crop;

    fn annotations() -> Vec<Annotation> {
        let names =
            (0..40).flat_map(|image| (0..=image % 3).map(move |i| format!("p_{image}_{i}.png")));
        names.map(|image| Annotation { image, t_s: None, label: BodyLabel::default() }).collect()
    }

    fn photographs(annotations: &[Annotation]) -> BTreeSet<&str> {
        annotations.iter().map(|annotation| photograph_of_crop(&annotation.image)).collect()
    }

    #[test]
    fn nobody_is_on_both_sides_and_the_share_is_that_of_groups() {
        let annotations = annotations();
        let split = split_by_group(&annotations, 0.2, 7, |a| photograph_of_crop(&a.image));
        let (training, validation) = (photographs(&split.training), photographs(&split.validation));
        assert!(training.is_disjoint(&validation));
        assert_eq!((training.len(), validation.len()), (32, 8));
        assert_eq!(split.training.len() + split.validation.len(), annotations.len());
    }

    #[test]
    fn the_choice_depends_on_the_seed_and_not_on_the_order() {
        let mut annotations = annotations();
        let chosen = |annotations: &[Annotation], seed| {
            let split = split_by_group(annotations, 0.25, seed, |a| photograph_of_crop(&a.image));
            photographs(&split.validation).into_iter().map(str::to_owned).collect::<BTreeSet<_>>()
        };
        let first = chosen(&annotations, 1);
        assert_ne!(first, chosen(&annotations, 2));
        annotations.reverse();
        assert_eq!(first, chosen(&annotations, 1));
    }

    #[test]
    fn no_share_takes_more_than_there_is() {
        let annotations = annotations();
        for (share, count) in [(-1.0, 0), (f64::NAN, 0), (0.0, 0), (1.0, 40), (9.0, 40)] {
            let split = split_by_group(&annotations, share, 0, |a| photograph_of_crop(&a.image));
            assert_eq!(photographs(&split.validation).len(), count, "{share}");
        }
    }
}
