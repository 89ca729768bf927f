//! MCAP files of the profile `ros2`: what was recognised, for viewers to show beside the recording; and recordings.

mod boxes;
mod cdr;
mod file;
mod messages;
mod results;
mod schemas;

pub(crate) use file::{McapFile, Topic};
pub(crate) use messages::{Encoding, Header, camera_info, image};
pub use results::{FrameMessages, Results};

/// The coordinate frame (x right, y down, z forward) of a depth camera whose source has no name for it.
pub(crate) const FRAME: &str = "camera_depth_optical_frame";
