//! The rows of a study, by the names that the user gives.

use evpose_nn::backbone_by_name;
use evpose_task::hand::HandConfig;

use super::rows::{FULL, Group, ROWS, Row};

/// Name that selects every row of another network.
pub(super) const BACKBONES: &str = "backbones";

/// The rows of these names, or all where there are none, in the order of the registry; the full
/// method is always among them. Rows that are not named by themselves are left out if their network
/// takes larger images than those of `base`; the second list has them.
pub(super) fn selected(
    names: &[String],
    base: &HandConfig,
) -> (Vec<&'static Row>, Vec<&'static Row>) {
    let is_named = |row: &Row| row.name == FULL || names.iter().any(|name| name == row.name);
    let is_in_group = |row: &Row| {
        let of_backbones = row.group == Group::Backbone && names.iter().any(|n| n == BACKBONES);
        names.is_empty() || of_backbones
    };
    let asked = ROWS.iter().filter(|row| is_named(row) || is_in_group(row));
    asked.partition(|row| is_named(row) || fits(row, base))
}

/// Whether the network of a row takes images as small as those of `base`.
fn fits(row: &Row, base: &HandConfig) -> bool {
    let size = base.network_size();
    backbone_by_name(&row.config(base).network.backbone)
        .is_ok_and(|backbone| usize::from(size.width.min(size.height)) >= backbone.smallest_px)
}

#[cfg(test)]
mod tests {
    use anyhow::Result;
    use evpose_cli::configs;
    use evpose_task::Experiment as _;

    use super::*;

    #[test]
    fn the_full_method_is_always_chosen() {
        let names = |chosen: Vec<&Row>| chosen.into_iter().map(|row| row.name).collect::<Vec<_>>();
        let base = HandConfig::default();
        let asked = ["no-filter".to_owned(), "eoi".to_owned()];
        assert_eq!(names(selected(&asked, &base).0), [FULL, "eoi", "no-filter"]);
        assert_eq!(selected(&[], &base).0.len(), ROWS.len());
    }

    #[test]
    fn networks_of_larger_images_are_left_out_unless_they_are_named() -> Result<()> {
        let names = |rows: Vec<&Row>| rows.into_iter().map(|row| row.name).collect::<Vec<_>>();
        let small = configs::load("ablation", &[])?;
        for asked in [vec![], vec![BACKBONES.to_owned()]] {
            let (rows, too_small) = selected(&asked, &small);
            assert_eq!(names(too_small), ["inception-v3"]);
            assert!(rows.iter().any(|row| row.name == "vgg19-bn"));
            assert_eq!(rows.iter().any(|row| row.name == "eoi"), asked.is_empty());
        }
        let (rows, _) = selected(&["inception-v3".to_owned()], &small);
        let message =
            rows[1].config(&small).validate().map_or_else(|e| e.to_string(), |()| "".into());
        assert!(message.contains("75 pixels") && message.contains("image_scale"), "{message}");
        let larger = configs::load("ablation", &["simulation.image_scale=0.42".to_owned()])?;
        let (rows, too_small) = selected(&[BACKBONES.to_owned()], &larger);
        assert_eq!((rows.len(), too_small.len()), (11 - 1, 0));
        Ok(())
    }
}
