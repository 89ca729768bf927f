//! Which colour image goes with which depth image, while both streams are still coming in.
//!
//! The rule is the one of a folder's lists: nearest pairs first, each image in one pair at most. Taking the smallest
//! distance of all again and again gives the same pairs as taking, in any order, those in which each is the other's
//! nearest; and that is known of a pair as soon as both streams have gone on far enough to hold nothing nearer.

use std::collections::VecDeque;

use super::Stamp;
use super::lists::MAX_APART;

/// A stamp that lies so far behind the latest of its stream is no late image: the clock was set anew.
const CLOCK_RESTART: i64 = 1_000_000_000;

/// A depth image with the colour image that belongs to it; none where there is no colour stream.
pub type Pair<C, D> = (Stamp, D, Option<(Stamp, C)>);

/// What became no frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct LeftOut {
    /// Depth images without a colour image of their time, or that came after a later one had been handed out.
    pub depth: u64,
    /// Images of either kind that were given up because too many were waiting; the depth images among them are
    /// counted in `depth` too.
    pub crowded: u64,
}

/// Pairs two streams of images by their stamps. Push what comes, and pop until there is nothing after each push.
#[derive(Debug)]
pub struct Pairer<C, D> {
    /// Most images of a kind that wait for a partner.
    bound: usize,
    /// Images of one stream are promised to be at least this far apart, in nanoseconds.
    spacing: i64,
    /// Waiting images in the order of their stamps, and of their coming where those are equal.
    colour: VecDeque<(Stamp, C)>,
    depth: VecDeque<Pair<C, D>>,
    /// The latest stamp of each stream.
    colour_seen: Option<Stamp>,
    depth_seen: Option<Stamp>,
    /// Stamp of the depth image that was settled last.
    settled: Option<Stamp>,
    ready: VecDeque<Pair<C, D>>,
    left_out: LeftOut,
    without_colour: bool,
    ended: bool,
}

impl<C, D> Pairer<C, D> {
    /// A pairer that keeps up to `bound` (at least one) images of each kind waiting.
    pub fn new(bound: usize) -> Self {
        Self {
            bound: bound.max(1),
            spacing: 0,
            colour: VecDeque::new(),
            depth: VecDeque::new(),
            colour_seen: None,
            depth_seen: None,
            settled: None,
            ready: VecDeque::new(),
            left_out: LeftOut::default(),
            without_colour: false,
            ended: false,
        }
    }

    /// One for a source that has no colour stream: depth images go through as they come.
    pub fn depth_only() -> Self {
        Self { without_colour: true, ..Self::new(1) }
    }

    /// Takes it that images of one stream are at least `nanoseconds` apart, as those of a sensor are: a pair is then
    /// known without waiting for the next image.
    #[must_use]
    pub fn spaced(self, nanoseconds: i64) -> Self {
        Self { spacing: nanoseconds.max(0), ..self }
    }

    /// Takes a colour image.
    pub fn push_colour(&mut self, stamp: Stamp, image: C) {
        if self.without_colour {
            return;
        }
        if restarted(self.colour_seen, stamp) {
            self.start_anew();
        }
        self.colour_seen = self.colour_seen.max(Some(stamp));
        let at = self.colour.partition_point(|(s, _)| *s <= stamp);
        self.colour.insert(at, (stamp, image));
        self.settle();
        while self.colour.len() > self.bound {
            let Some(&(stamp, _)) = self.colour.front() else { break };
            match nearest(stamp, &self.depth, |d| d.2.is_none().then_some(d.0)) {
                Some(depth) => self.pair_near(depth),
                None => {
                    self.colour.pop_front();
                    self.left_out.crowded += 1;
                }
            }
            self.settle();
        }
    }

    /// Takes a depth image.
    pub fn push_depth(&mut self, stamp: Stamp, image: D) {
        if self.without_colour {
            self.ready.push_back((stamp, image, None));
            return;
        }
        if restarted(self.depth_seen, stamp) {
            self.start_anew();
        }
        self.depth_seen = self.depth_seen.max(Some(stamp));
        if self.settled.is_some_and(|settled| stamp < settled) {
            self.left_out.depth += 1;
            return;
        }
        let at = self.depth.partition_point(|d| d.0 <= stamp);
        self.depth.insert(at, (stamp, image, None));
        self.settle();
        while self.depth.len() > self.bound {
            // The first one is not settled: it would not be there otherwise.
            if self.candidate(0).is_some() {
                self.pair_near(0);
            } else {
                self.depth.pop_front();
                self.left_out.depth += 1;
                self.left_out.crowded += 1;
            }
            self.settle();
        }
    }

    /// Both streams have ended: what waits finds a partner among what is there, or none.
    pub fn end(&mut self) {
        self.ended = true;
        self.settle();
    }

    /// The next frame whose images are known, in the order of the depth images' stamps.
    pub fn pop(&mut self) -> Option<Pair<C, D>> {
        self.ready.pop_front()
    }

    /// What was left out since this was last asked.
    pub fn take_left_out(&mut self) -> LeftOut {
        std::mem::take(&mut self.left_out)
    }

    /// The clock went back: nothing from before belongs to anything from now on.
    fn start_anew(&mut self) {
        let ended = std::mem::replace(&mut self.ended, true);
        self.settle();
        self.ended = ended;
        self.colour.clear();
        (self.colour_seen, self.depth_seen, self.settled) = (None, None, None);
    }

    /// Settles all that the images to come cannot change.
    fn settle(&mut self) {
        while let Some((d, c)) = (0..self.depth.len()).find_map(|d| Some((d, self.mutual(d)?))) {
            self.join(d, c);
        }
        while let Some(first) = self.depth.front() {
            let stamp = first.0;
            if first.2.is_some() {
                self.ready.extend(self.depth.pop_front());
            } else if self.candidate(0).is_none() && self.colour_beyond(stamp, MAX_APART) {
                self.depth.pop_front();
                self.left_out.depth += 1;
            } else {
                break;
            }
            self.settled = Some(stamp);
        }
        while let Some(&(stamp, _)) = self.colour.front() {
            let wanted = nearest(stamp, &self.depth, |d| d.2.is_none().then_some(d.0)).is_some();
            if wanted || !self.depth_beyond(stamp, MAX_APART) {
                break;
            }
            self.colour.pop_front();
        }
    }

    /// The colour image that certainly belongs to the depth image `d`.
    fn mutual(&self, d: usize) -> Option<usize> {
        let c = self.candidate(d)?;
        let (depth, colour) = (self.depth[d].0, self.colour[c].0);
        let apart = depth.apart(colour);
        let back = nearest(colour, &self.depth, |d| d.2.is_none().then_some(d.0));
        (back == Some(d) && self.colour_beyond(depth, apart) && self.depth_beyond(colour, apart)).then_some(c)
    }

    /// The waiting colour image nearest to the depth image `d`, if that has none yet.
    fn candidate(&self, d: usize) -> Option<usize> {
        let depth = self.depth.get(d).filter(|d| d.2.is_none())?;
        nearest(depth.0, &self.colour, |c| Some(c.0))
    }

    /// Pairs the depth image `d`, or images that take its candidate away, although something nearer may yet come.
    fn pair_near(&mut self, mut d: usize) {
        // Each step leads to a nearer pair, so that it ends.
        while let Some(c) = self.candidate(d) {
            match nearest(self.colour[c].0, &self.depth, |d| d.2.is_none().then_some(d.0)) {
                Some(back) if back != d => d = back,
                _ => return self.join(d, c),
            }
        }
    }

    fn join(&mut self, d: usize, c: usize) {
        if let Some(depth) = self.depth.get_mut(d) {
            depth.2 = self.colour.remove(c);
        }
    }

    /// Whether no colour image to come can be nearer to `stamp` than `apart`.
    fn colour_beyond(&self, stamp: Stamp, apart: u64) -> bool {
        self.beyond(self.colour_seen, stamp, apart)
    }

    fn depth_beyond(&self, stamp: Stamp, apart: u64) -> bool {
        self.beyond(self.depth_seen, stamp, apart)
    }

    fn beyond(&self, seen: Option<Stamp>, stamp: Stamp, apart: u64) -> bool {
        let earliest = seen.map(|seen| seen.0.saturating_add(self.spacing));
        self.ended || apart == 0 || earliest.is_some_and(|earliest| earliest >= stamp.0.saturating_add_unsigned(apart))
    }
}

/// Whether the stream's clock was set back.
fn restarted(seen: Option<Stamp>, stamp: Stamp) -> bool {
    seen.is_some_and(|seen| seen.0.saturating_sub(stamp.0) > CLOCK_RESTART)
}

/// The one of `images` nearest to `stamp` and near enough; the first one of several. They are in the order of their
/// stamps; those of which `stamp_of` gives none do not count.
fn nearest<T>(stamp: Stamp, images: &VecDeque<T>, stamp_of: impl Fn(&T) -> Option<Stamp>) -> Option<usize> {
    let apart = |image: &T| stamp_of(image).map(|s| s.apart(stamp));
    let near = images.iter().enumerate().filter_map(|(i, image)| Some((apart(image)?, i)));
    near.filter(|&(apart, _)| apart < MAX_APART).min().map(|(_, i)| i)
}

#[cfg(test)]
mod tests;
