//! Frames from a recording of messages, whatever its container.

use std::collections::{HashMap, HashSet, VecDeque};
use std::path::{Path, PathBuf};

use pldi_core::Intrinsics;

use super::decode::{self, Sample};
use super::log::{Log, Message, Step};
use super::topics::{Channel, Chosen, Kind, Topic, choose};
use super::{CameraInfo, Encoding, camera_info};
use crate::Error;
use crate::error::IntrinsicsOrigin;
use crate::input::pair::Pairer;
use crate::input::{DepthScale, Images, OpenOptions, RawFrame, Source, Stamp, Stop};

/// So much of a file is looked through for its topics and what they hold, where its index does not tell.
const SURVEY: u64 = 64 << 20;
/// So much for the first calibration.
const SURVEY_INFO: u64 = 512 << 20;
/// So much is read between two looks at whether to stop.
const STEP: u64 = 8 << 20;
/// Images of each topic that wait for their partners: those of a second.
const WAITING: usize = 30;

/// An image's message, not decoded yet.
struct Packed {
    message: Message,
    kind: Kind,
    encoding: Encoding,
    stamp: Stamp,
}

/// What a recording's beginning and index tell.
struct Survey {
    topics: Vec<Topic>,
    /// The first calibration of each topic.
    infos: HashMap<String, Message>,
    indexed: bool,
}

/// The frames of a recording of messages.
struct Frames {
    log: Box<dyn Log>,
    chosen: Chosen,
    pairer: Pairer<Packed, Packed>,
    camera: Option<(Intrinsics, IntrinsicsOrigin)>,
    /// The calibration that `camera` is from.
    info: Option<CameraInfo>,
    scale: DepthScale,
    /// Depth images that the index announces, and of how many it is known what became of them.
    announced: Option<u64>,
    settled: u64,
    given: u64,
    left_out: u64,
    warned_stamp: bool,
    warned_info: bool,
    ready: VecDeque<RawFrame>,
    ended: bool,
    /// Whether it has been said what the end tells.
    told: bool,
}

/// Frames of `log`: its topics are chosen here.
///
/// # Errors
/// Where the file cannot be read, has no depth, not the topics that were asked for, or a calibration that makes no sense.
pub(in crate::input) fn open(mut log: Box<dyn Log>, options: &OpenOptions) -> Result<Box<dyn Source>, Error> {
    let mut survey = survey(log.as_mut())?;
    let mut chosen = choose(log.path(), &survey.topics, options)?;
    if options.intrinsics.is_some() || options.camera_info.is_some() {
        chosen.info = None;
    }
    if let Some(info) = &chosen.info
        && !survey.infos.contains_key(&info.topic)
        && let Step::Message(message) = log.next(SURVEY_INFO, &|channel| channel == info)?
    {
        survey.infos.insert(info.topic.clone(), message);
    }
    log.rewind();
    let counted = survey.topics.iter().find(|topic| topic.channel == chosen.depth).map(|topic| topic.count);
    let mut frames = Frames {
        pairer: if chosen.colour.is_some() { Pairer::new(WAITING) } else { Pairer::depth_only() },
        log,
        camera: None,
        info: None,
        scale: options.depth_scale,
        announced: counted.filter(|_| survey.indexed),
        settled: 0,
        given: 0,
        left_out: 0,
        warned_stamp: false,
        warned_info: false,
        ready: VecDeque::new(),
        ended: false,
        told: false,
        chosen,
    };
    let names = |channel: &Option<Channel>| channel.as_ref().map_or("none", |c| c.topic.as_str()).to_owned();
    tracing::debug!(
        "{}: depth {}, colour {}, calibration {}",
        frames.log.path().display(),
        frames.chosen.depth.topic,
        names(&frames.chosen.colour),
        names(&frames.chosen.info)
    );
    if let Some(first) = frames.chosen.info.as_ref().and_then(|info| survey.infos.remove(&info.topic)) {
        frames.calibrate(&first)?;
    }
    Ok(Box::new(frames))
}

/// Looks through the beginning of a recording.
fn survey(log: &mut dyn Log) -> Result<Survey, Error> {
    let index = log.index();
    let mut samples: HashMap<String, Option<Sample>> = HashMap::new();
    let mut infos = HashMap::new();
    let wanted = |samples: &HashMap<_, _>, channel: &Channel| {
        channel.readable().is_some() && !samples.contains_key(&channel.topic)
    };
    // Topics that the index announces messages of, and of which none was found yet.
    let readable = |(channel, count): &&(Channel, u64)| *count > 0 && channel.readable().is_some();
    let mut missing: Option<HashSet<String>> =
        index.as_ref().map(|index| index.iter().filter(readable).map(|(c, _)| c.topic.clone()).collect());
    while missing.as_ref().is_none_or(|missing| !missing.is_empty()) {
        let Step::Message(message) = log.next(SURVEY, &|channel| wanted(&samples, channel))? else { break };
        let Some((kind, encoding)) = message.channel.readable() else { continue };
        let sample = decode::sample(&message.data, encoding, kind).ok();
        samples.insert(message.channel.topic.clone(), sample);
        if let Some(missing) = &mut missing {
            missing.remove(&message.channel.topic);
        }
        if kind == Kind::Info {
            infos.insert(message.channel.topic.clone(), message);
        }
    }
    let indexed = index.is_some();
    let mut channels = index.unwrap_or_else(|| log.seen());
    channels.sort();
    let mut topics: Vec<Topic> = Vec::new();
    for (channel, count) in channels {
        match topics.last_mut() {
            // Several publishers of one topic.
            Some(topic) if topic.channel == channel => topic.count = topic.count.saturating_add(count),
            _ => {
                let sample = samples.get(&channel.topic).cloned().flatten();
                topics.push(Topic { channel, count, sample });
            }
        }
    }
    Ok(Survey { topics, infos, indexed })
}

/// Tells a message in errors: its file, topic and time.
fn place(path: &Path, topic: &str, stamp: Stamp) -> PathBuf {
    format!("{}: {topic} at {stamp}", path.display()).into()
}

impl Frames {
    /// Takes the camera from a calibration, if it is not the one it is from.
    fn calibrate(&mut self, message: &Message) -> Result<(), Error> {
        let Some((Kind::Info, encoding)) = message.channel.readable() else { return Ok(()) };
        let name = PathBuf::from(format!("{}: {}", self.log.path().display(), message.channel.topic));
        let info = decode::info(&name, &message.data, encoding)?;
        if self.info.as_ref() != Some(&info) {
            let intrinsics = camera_info::intrinsics(&name, &info);
            self.info = Some(info);
            self.camera = Some((intrinsics?, IntrinsicsOrigin::Source(name.display().to_string())));
        }
        Ok(())
    }

    /// Takes a message of one of the topics.
    fn take(&mut self, message: Message) {
        if self.chosen.info.as_ref() == Some(&*message.channel) {
            if let Err(error) = self.calibrate(&message)
                && !std::mem::replace(&mut self.warned_info, true)
            {
                tracing::warn!("{error}; the calibration before goes on to be used");
            }
            return;
        }
        let Some((kind, encoding)) = message.channel.readable() else { return };
        // One whose stamp cannot be read cannot be decoded either: the frame will say so.
        let stamp = match decode::stamp(&message.data, encoding) {
            // A recording may begin at 0.
            Ok(0) if message.time != 0 => {
                if !std::mem::replace(&mut self.warned_stamp, true) {
                    tracing::warn!(
                        "{}: the headers of {} have no stamps; the times of recording are taken",
                        self.log.path().display(),
                        message.channel.topic
                    );
                }
                message.time
            }
            Ok(stamp) => stamp,
            Err(_) => message.time,
        };
        let stamp = Stamp(stamp);
        let is_depth = *message.channel == self.chosen.depth;
        let packed = Packed { message, kind, encoding, stamp };
        if is_depth {
            self.pairer.push_depth(stamp, packed);
        } else {
            self.pairer.push_colour(stamp, packed);
        }
    }

    /// Turns the pairs that are known into frames.
    fn collect(&mut self) {
        while let Some((stamp, depth, colour)) = self.pairer.pop() {
            let colour = colour.map(|(_, packed)| packed);
            let (scale, path) = (self.scale, self.log.path().to_owned());
            self.ready.push_back(RawFrame {
                stamp,
                colour_stamp: colour.as_ref().map(|packed| packed.stamp),
                name: format!("{} at {stamp}", depth.message.channel.topic),
                frame_id: decode::frame_id(&depth.message.data, depth.encoding).ok().filter(|name| !name.is_empty()),
                camera: self.camera.clone(),
                dropped: 0,
                images: Box::new(move || decode_pair(&path, &depth, colour.as_ref(), scale)),
            });
            self.settled += 1;
        }
        let left_out = self.pairer.take_left_out().depth;
        self.left_out += left_out;
        self.settled += left_out;
    }

    /// What the end of the file tells.
    fn end(&mut self) -> Result<(), Error> {
        let Some(colour) = &self.chosen.colour else {
            return if self.given > 0 { Ok(()) } else { Err(self.no_frame("it has no message that can be read")) };
        };
        let reason = format!("{} depth images have no image of {} within 0.02 s", self.left_out, colour.topic);
        match (self.given, self.left_out) {
            (0, 0) => Err(self.no_frame("it has no message that can be read")),
            (0, _) => Err(self.no_frame(&format!("{reason}: choose another with --color"))),
            (_, 0) => Ok(()),
            _ => {
                tracing::warn!("{}: {reason} and were left out", self.log.path().display());
                Ok(())
            }
        }
    }

    fn no_frame(&self, reason: &str) -> Error {
        let reason = format!("no frame of {}: {reason}", self.chosen.depth.topic);
        Error::Content { path: self.log.path().to_owned(), reason }
    }
}

impl Source for Frames {
    fn next(&mut self, stop: &Stop) -> Result<Option<RawFrame>, Error> {
        loop {
            if let Some(frame) = self.ready.pop_front() {
                self.given += 1;
                return Ok(Some(frame));
            }
            if self.ended {
                if !std::mem::replace(&mut self.told, true) {
                    self.end()?;
                }
                return Ok(None);
            }
            if stop.is_raised() {
                return Ok(None);
            }
            let Chosen { depth, colour, info } = &self.chosen;
            let wanted =
                |channel: &Channel| channel == depth || [colour, info].iter().any(|c| c.as_ref() == Some(channel));
            match self.log.next(self.log.position().saturating_add(STEP), &wanted)? {
                Step::Message(message) => self.take(message),
                Step::Nothing => {}
                Step::End => {
                    self.ended = true;
                    self.pairer.end();
                }
            }
            self.collect();
        }
    }

    fn frames(&self) -> Option<usize> {
        let left = self.announced?.saturating_sub(self.settled).saturating_add(self.ready.len() as u64);
        usize::try_from(left).ok()
    }
}

/// Decodes the images of a frame.
fn decode_pair(path: &Path, depth: &Packed, colour: Option<&Packed>, scale: DepthScale) -> Result<Images, Error> {
    let name = |packed: &Packed| place(path, &packed.message.channel.topic, packed.stamp);
    let depth_name = name(depth);
    let decode::Depth { pixels, millimetres } =
        decode::depth(&depth_name, &depth.message.data, depth.encoding, depth.kind)?;
    let size = (pixels.width, pixels.height);
    let scale = if millimetres { DepthScale::Millimetres } else { scale };
    let images = Images { size, depth: pixels.values, scale, colour: None };
    let Some(colour) = colour else { return Ok(images) };
    let colour_name = name(colour);
    let pixels = decode::colour(&colour_name, &colour.message.data, colour.encoding, colour.kind)?;
    if (pixels.width, pixels.height) == size {
        return Ok(Images { colour: Some(pixels.values), ..images });
    }
    let reason = format!(
        "{}x{}, but {} is {}x{}: colour and depth must be registered and of one size; choose the depth that is \
         registered to the colour camera with --depth (such as depth_registered or aligned_depth_to_color), or record it",
        size.0,
        size.1,
        colour_name.display(),
        pixels.width,
        pixels.height
    );
    Err(Error::Content { path: depth_name, reason })
}

#[cfg(test)]
mod tests;
