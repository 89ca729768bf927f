//! What the pipeline logs, in the arithmetic's own units.

use super::{Arithmetic, Detection, Report};
use crate::Error;

/// The first stage is done.
pub(super) fn reconstructed<const W: usize, const H: usize>() {
    event!(debug, "depth of {}x{} pixels reconstructed", W, H);
}

/// The second stage is done.
pub(super) fn floor<A: Arithmetic>(floor: Option<&A::Floor>) {
    match floor {
        Some(floor) => event!(debug, "floor {}", floor),
        None => event!(warn, "no floor"),
    }
}

/// The third stage is done.
pub(super) fn clusters<A: Arithmetic>(report: &Report<A>) {
    // Without the feature, nothing is left that the compiler would weigh when it decides what to inline.
    if !cfg!(feature = "defmt") {
        return;
    }
    let candidates = || report.clusters.iter().filter(|cluster| cluster.rejection.is_none()).count();
    event!(debug, "{} clusters, {} of them candidates", report.clusters.len(), candidates());
    for (i, cluster) in report.clusters.iter().enumerate() {
        match cluster.rejection {
            None => event!(trace, "cluster {}: {} pixels at {}, candidate", i, cluster.pixels, cluster.centroid),
            Some(reason) => event!(trace, "cluster {}: {} pixels, rejected: {}", i, cluster.pixels, reason),
        }
    }
}

/// A candidate went through all stages.
pub(super) fn detection<A: Arithmetic>(Detection { cluster, hypotheses, .. }: &Detection<A>) {
    match hypotheses.first() {
        Some(best) => {
            let (class, score, distance) = (best.class, &best.score, &best.distance);
            event!(info, "cluster {}: class {}, score {}, distance {}", cluster, class, score, distance);
        }
        None => event!(info, "cluster {}: no templates", cluster),
    }
}

/// A candidate has no view.
pub(super) fn no_view(cluster: usize) {
    event!(debug, "cluster {}: no pixels in its view", cluster);
}

/// Logs the error, if it is one.
pub(super) fn error<T>(result: Result<T, Error>) -> Result<T, Error> {
    if cfg!(feature = "defmt")
        && let Err(error) = &result
    {
        event!(error, "{}", error);
    }
    result
}
