//! Time stamps that never go back, though a device's clock starts anew when it was unplugged.

use std::time::Duration;

use crate::input::Stamp;

/// A device's clock went back by so many nanoseconds: it was set anew. Less is the disorder of two streams.
const RESTART: i64 = 1_000_000_000;

/// From the clock of a device to the one of its source.
#[derive(Debug, Default)]
pub(super) struct Clock {
    offset: i64,
    /// The latest stamp given.
    last: Option<i64>,
    /// The device was opened again: any step back is a new clock.
    reopened: bool,
}

impl Clock {
    /// The next stamp comes from a device that was opened again.
    pub(super) fn reopened(&mut self) {
        self.reopened = true;
    }

    /// The stamp for the device's `microseconds`, `passed` after the last one was asked for.
    pub(super) fn stamp(&mut self, microseconds: u64, passed: Duration) -> Stamp {
        let device = i64::try_from(microseconds).unwrap_or(i64::MAX).saturating_mul(1000);
        let mut stamp = device.saturating_add(self.offset);
        if let Some(last) = self.last {
            let back = last.saturating_sub(stamp);
            if back > RESTART || self.reopened && back >= 0 {
                let passed = i64::try_from(passed.as_nanos()).unwrap_or(i64::MAX).max(1);
                stamp = last.saturating_add(passed);
                self.offset = stamp.saturating_sub(device);
            }
        }
        self.reopened = false;
        self.last = self.last.max(Some(stamp));
        Stamp(stamp)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_clock_that_starts_anew_goes_on() {
        let mut clock = Clock::default();
        let ms = Duration::from_millis;
        assert_eq!(clock.stamp(1_000_000, ms(0)), Stamp(1_000_000_000));
        assert_eq!(clock.stamp(1_033_000, ms(33)), Stamp(1_033_000_000));
        // The other stream's image of the same moment.
        assert_eq!(clock.stamp(1_029_000, ms(1)), Stamp(1_029_000_000));
        clock.reopened();
        assert_eq!(clock.stamp(500_000, ms(700)), Stamp(1_733_000_000));
        assert_eq!(clock.stamp(533_000, ms(33)), Stamp(1_766_000_000));
        // One that goes on while the device is away is taken as it is.
        clock.reopened();
        assert_eq!(clock.stamp(5_000_000, ms(10)), Stamp(6_233_000_000));
        // Anew without a word.
        assert_eq!(clock.stamp(0, ms(20)), Stamp(6_253_000_000));
        assert_eq!(clock.stamp(u64::MAX, ms(1)), Stamp(i64::MAX));
    }
}
