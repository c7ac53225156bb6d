//! Progress of a training.

use std::sync::Once;

use evpose_app::progress::bar;
use evpose_train::ProgressCallback;

/// A progress bar of a training, and the callback that advances it.
pub(crate) fn training_bar(model: &str) -> (indicatif::ProgressBar, ProgressCallback) {
    let progress = bar(model, 0, "windows");
    let (handle, began) = (progress.clone(), Once::new());
    let callback = ProgressCallback::new(move |done| {
        began.call_once(|| {
            handle.set_length(done.total_samples);
            handle.set_position(done.samples);
            // Samples of an earlier process carry no information about the speed of this one.
            handle.reset_eta();
        });
        handle.set_position(done.samples);
    });
    (progress, callback)
}
