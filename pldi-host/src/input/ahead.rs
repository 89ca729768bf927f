//! A thread that reads while others compute.

use std::sync::mpsc::{self, Receiver};

use super::{RawFrame, Source, Stop};
use crate::Error;

/// Frames that wait between the reading thread and those who take them, for a recording.
const AHEAD: usize = 4;

/// Lets `body` take the frames of `source` from a thread that stays a few frames ahead of it; for a live source it has one
/// in hand at most, because a waiting frame is an old one. An error of the source is the last that comes. The thread has
/// ended when this returns, whether `body` took all frames or not.
///
/// # Errors
/// `Thread`.
pub(crate) fn with_frames<R>(
    mut source: Box<dyn Source>,
    stop: &Stop,
    body: impl FnOnce(Receiver<Result<RawFrame, Error>>) -> R,
) -> Result<R, Error> {
    let enough = stop.child();
    let (send, receive) = mpsc::sync_channel(if source.is_live() { 1 } else { AHEAD });
    std::thread::scope(|scope| {
        let read = || {
            let enough = &enough;
            move || {
                // The end, or nobody takes frames any more.
                while let Some(next) = source.next(enough).transpose() {
                    let failed = next.is_err();
                    if send.send(next).is_err() || failed {
                        return;
                    }
                }
            }
        };
        std::thread::Builder::new().name("frames".into()).spawn_scoped(scope, read()).map_err(Error::Thread)?;
        let result = body(receive);
        enough.raise();
        Ok(result)
    })
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;
    use std::sync::atomic::{AtomicUsize, Ordering};

    use super::*;
    use crate::input::Stamp;

    /// Gives so many frames, then an error, or waits for ever.
    struct Numbers {
        given: Arc<AtomicUsize>,
        count: usize,
        waits: bool,
    }

    impl Source for Numbers {
        fn next(&mut self, stop: &Stop) -> Result<Option<RawFrame>, Error> {
            let i = self.given.fetch_add(1, Ordering::SeqCst);
            if i >= self.count {
                if !self.waits {
                    return Err(Error::Interrupted);
                }
                while !stop.is_raised() {
                    std::thread::yield_now();
                }
                return Ok(None);
            }
            let (camera, colour_stamp, dropped) = Default::default();
            let images = Box::new(|| Err(Error::Interrupted));
            Ok(Some(RawFrame {
                stamp: Stamp(i as i64),
                colour_stamp,
                name: String::new(),
                frame_id: None,
                camera,
                dropped,
                images,
            }))
        }
    }

    #[test]
    fn frames_come_in_order_and_an_error_is_the_last() {
        let given = Arc::default();
        let source = Box::new(Numbers { given: Arc::clone(&given), count: 100, waits: false });
        let frames = with_frames(source, &Stop::default(), |frames| frames.into_iter().collect::<Vec<_>>()).unwrap();
        assert_eq!(frames.len(), 101);
        assert!(frames[..100].iter().enumerate().all(|(i, f)| f.as_ref().unwrap().stamp.0 == i as i64));
        assert!(frames[100].is_err());
        assert_eq!(given.load(Ordering::SeqCst), 101, "it was asked again behind its error");
    }

    #[test]
    fn it_is_a_few_frames_ahead_and_ends_with_its_taker() {
        let given = Arc::default();
        let source = Box::new(Numbers { given: Arc::clone(&given), count: 1000, waits: false });
        with_frames(source, &Stop::default(), |frames| {
            frames.recv().unwrap().unwrap();
            std::thread::sleep(std::time::Duration::from_millis(50));
        })
        .unwrap();
        assert!(given.load(Ordering::SeqCst) <= 1 + AHEAD + 1);
        // One that waits for a device is told to give up.
        let source = Box::new(Numbers { given: Arc::default(), count: 2, waits: true });
        with_frames(source, &Stop::default(), |frames| assert!(frames.recv().unwrap().is_ok())).unwrap();
    }
}
