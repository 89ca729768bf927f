//! The memory that the documentation promises.

use pldi_core::pipeline::{QvgaPipeline, QvgaWorkspace};

#[test]
fn the_workspace_has_the_size_that_the_front_page_gives() {
    let megabytes = size_of::<QvgaWorkspace>() as f64 / 1e6;
    assert!((megabytes * 10.0).round() == 22.0, "{megabytes}");
    assert!(size_of::<QvgaPipeline>() < 16_384, "{}", size_of::<QvgaPipeline>());
}
