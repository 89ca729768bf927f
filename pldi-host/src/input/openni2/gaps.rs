//! Frames that were lost on the way, by their numbers.

/// Counts the numbers that are left out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Gaps {
    last: Option<i32>,
    /// Frames lost and not told yet.
    pub(super) lost: u64,
}

impl Gaps {
    /// Notes the number of a frame that came.
    pub(super) fn next(&mut self, number: i32) {
        let step = self.last.map_or(1, |last| i64::from(number) - i64::from(last));
        self.last = Some(number);
        self.lost += u64::try_from(step - 1).unwrap_or(0);
    }

    /// Numbers begin anew.
    pub(super) fn restart(&mut self) {
        self.last = None;
    }

    /// How many were lost since this was asked last.
    pub(super) fn take(&mut self) -> u64 {
        std::mem::take(&mut self.lost)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_left_out_are_counted() {
        let mut gaps = Gaps::default();
        for number in [7, 8, 11] {
            gaps.next(number);
        }
        assert_eq!((gaps.take(), gaps.take()), (2, 0));
        gaps.restart();
        gaps.next(1);
        // Backwards nothing is lost, and no number of a device is too much.
        for number in [1, 0, i32::MIN, i32::MAX] {
            gaps.next(number);
        }
        assert_eq!(gaps.take(), u64::from(u32::MAX) - 1);
    }
}
