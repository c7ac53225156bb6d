//! A report as tests need one.

use std::collections::BTreeMap;

use evpose_gap::StatisticBlock;
use evpose_gap::locate::{Arrow, Located, Profile, Region};
use evpose_gap::report::{
    Ablation, AxisScale, BlockGap, Confusability, Fact, ModelChange, Plot, ProbeRow, ReportData,
    SideBySide, SideBySideFrame,
};
use evpose_gap::verdict::{
    Answer, Explained, Finding, FindingKind, GapValue, Limit, Location, Quantity, SCHEMA,
    TwoSample, Unexplained, Verdict,
};

fn gap(value: f64) -> GapValue {
    GapValue { value, lo: 0.9 * value, hi: 1.1 * value }
}

/// A verdict that names a leak.
pub(crate) fn verdict() -> Verdict {
    let rate =
        Quantity { value: 2.04, lo90: 1.95, hi90: 2.11, unit: "Hz".to_owned(), halves: None };
    Verdict {
        schema: SCHEMA,
        verdict: Answer::Effects,
        effects: vec![Finding {
            name: "leak_on".to_owned(),
            kind: FindingKind::Effect,
            formula: None,
            parameters: BTreeMap::from([("rate_hz".to_owned(), rate)]),
            probability: Some(0.99),
            confusable_with: vec!["parasitic_photo_leak".to_owned()],
            signature: None,
            explained: Some(Explained { alone: 0.95, beside_others: 0.93, p: 1e-7 }),
        }],
        demoted: Vec::new(),
        unexplained: Unexplained {
            fraction: 0.04,
            p: 0.21,
            is_significant: false,
            nearest_stage: "detector".to_owned(),
            sentence: "No part of the image differs.".to_owned(),
            shares: BTreeMap::from([("brightness".to_owned(), 0.6), ("time".to_owned(), 0.4)]),
            responses: Vec::new(),
        },
        gap_before: gap(11.8),
        gap_after: gap(1.1),
        grr: 0.99,
        p: 1e-9,
        place: Location {
            sentence: "Excess x9.1 [8.8, 9.5] of ON events where light is at rest, everywhere in \
                       the image: 9120 measured, 1002 expected."
                .to_owned(),
            shares: BTreeMap::from([("age".to_owned(), 0.8), ("polarity".to_owned(), 0.2)]),
        },
        stage_shares: BTreeMap::from([("detector".to_owned(), 0.93), ("clock".to_owned(), 0.07)]),
        limits: vec![Limit {
            name: "hot_pixels".to_owned(),
            parameter: "fraction".to_owned(),
            value: 2e-4,
            unit: String::new(),
        }],
        untestable: BTreeMap::from([("arbiter".to_owned(), "never busy <enough>".to_owned())]),
        c2st_before: Some(TwoSample { auc: 0.91, p: 0.01 }),
        c2st_after: Some(TwoSample { auc: 0.52, p: 0.31 }),
        corrections: Vec::new(),
        is_out_of_time: false,
        next: "record it again".to_owned(),
        notes: vec!["stamps are whole microseconds".to_owned()],
    }
}

/// A report in which nothing is left out.
pub(crate) fn data() -> ReportData {
    let mut data = ReportData::from_verdict(verdict());
    data.provenance = vec![Fact::new("recording", "events.npz & more")];
    let block = |block| BlockGap { block, before: gap(20.0), after: gap(1.0) };
    data.blocks = vec![block(StatisticBlock::Quiet), block(StatisticBlock::LogIntensityStep)];
    data.probes = vec![ProbeRow {
        block: StatisticBlock::Quiet,
        name: "ON, darkest".to_owned(),
        before: 41.2,
        after: 0.4,
        relative: Some(8.1),
    }];
    data.confusability = Confusability {
        names: vec!["leak_on".to_owned(), "parasitic_photo_leak".to_owned()],
        cosines: vec![vec![1.0, 0.97], vec![0.97, 1.0]],
    };
    data.ablation = [
        (ModelChange::None, "", 11.8),
        (ModelChange::Added, "leak_on", 1.1),
        (ModelChange::Dropped, "leak_on", 11.7),
        (ModelChange::Swapped, "parasitic_photo_leak", 2.3),
    ]
    .into_iter()
    .map(|(change, effect, value)| Ablation { change, effect: effect.to_owned(), gap: gap(value) })
    .collect();
    data.before = located();
    data.after = Some(Located::default());
    let curve = |title: &str, scale| Plot {
        title: title.to_owned(),
        caption: "what to look for".to_owned(),
        x_scale: scale,
        y_scale: scale,
        x: vec![1.0, 2.0, 3.0, 4.0],
        ..Plot::default()
    };
    let runs = [vec![1.0, 2.0, 3.0, f64::NAN], vec![1.2, 2.4, 2.0, f64::NAN]];
    let measured = vec![2.0, f64::NAN, 5.0, 1.0];
    data.plots = vec![
        curve("evenly", AxisScale::Linear).with(measured.clone(), &runs, &[]),
        curve("by the logarithm", AxisScale::Log).with(measured, &runs, &runs),
    ];
    data.side_by_side = Some(SideBySide {
        names: vec!["measured".to_owned(), "model".to_owned()],
        width: 2,
        height: 2,
        frame_us: 10_000,
        frames: vec![SideBySideFrame {
            t_us: 0,
            images: vec!["0f41".to_owned(), "0000".to_owned()],
        }],
    });
    data.model_before = "[[effect]]\nname = \"level_crossing\"".to_owned();
    data.model_after = "[[effect]]\nname = \"level_crossing\"\n[[effect]]".to_owned();
    data
}

fn located() -> Located {
    let mut located = Located::default();
    let profile = |n: usize| Profile { z: vec![1.5; n], is_significant: vec![true; n] };
    located.maps.image.width = 2;
    located.maps.image.height = 2;
    located.maps.image.side_px = 1;
    located.maps.image.residuals = profile(4);
    located.maps.rows = profile(2);
    located.maps.columns = profile(2);
    located.maps.times = profile(5);
    let arrow = Arrow { x: 0.5, y: 0.5, dx_px: 1.25, dy_px: 0.0, is_significant: true };
    located.maps.arrows = vec![arrow];
    located.scan.regions = vec![Region { sentence: "Excess here".to_owned(), ..Region::default() }];
    located
}
