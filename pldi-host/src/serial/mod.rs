//! The host's side of the serial protocol: frames to a device that runs the pipeline in integers, and its answers.
//!
//! ```no_run
//! use pldi_host::serial::{Answer, FrameOptions, Outgoing, Receiver, Sender, port};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let (reader, writer) = port::open_both("/dev/ttyACM0".as_ref(), 115_200)?;
//! let (mut sender, mut receiver) = (Sender::new(writer), Receiver::new(reader));
//! sender.hello(1)?;
//! # let (depth, colour) = (vec![0; 320 * 240], vec![0; 3 * 320 * 240]);
//! let frame = Outgoing { number: 0, stamp: 0, depth: &depth, colour: Some(&colour) };
//! sender.frame(&frame, FrameOptions::default())?;
//! while let Some(received) = receiver.next()? {
//!     if let Answer::Detections(found) = received.answer {
//!         println!("{} objects", found.detections.len());
//!         break;
//!     }
//! }
//! # Ok(())
//! # }
//! ```

mod answer;
pub mod port;
mod receiver;
mod report;
mod sender;

pub use answer::{Answer, Detection, Detections};
pub use receiver::{Received, Receiver, Traffic};
pub use report::{Names, SerialReport};
pub use sender::{FrameOptions, Outgoing, Sender, frame_packets, packet};
