//! Which topics of a recording are its colour, its depth and its camera's calibration.

use std::path::Path;

use super::decode::Sample;
use super::{Encoding, compressed};
use crate::Error;
use crate::input::OpenOptions;

/// So many topics are named in a message.
const MOST_LISTED: usize = 40;

/// What a topic's messages are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::input) enum Kind {
    Image,
    Compressed,
    Info,
}

impl Kind {
    /// By the name of the type, as ROS 1 or ROS 2 writes it.
    fn of(type_name: &str) -> Option<Self> {
        match type_name {
            "sensor_msgs/Image" | "sensor_msgs/msg/Image" => Some(Self::Image),
            "sensor_msgs/CompressedImage" | "sensor_msgs/msg/CompressedImage" => Some(Self::Compressed),
            "sensor_msgs/CameraInfo" | "sensor_msgs/msg/CameraInfo" => Some(Self::Info),
            _ => None,
        }
    }

    /// Its name.
    pub(in crate::input) fn name(self) -> &'static str {
        match self {
            Self::Image => "Image",
            Self::Compressed => "CompressedImage",
            Self::Info => "CameraInfo",
        }
    }
}

/// A topic as its recording declares it.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Default)]
pub(in crate::input) struct Channel {
    /// Name of the topic.
    pub(in crate::input) topic: String,
    /// Name of the messages' type.
    pub(in crate::input) type_name: String,
    /// Name of the messages' encoding: `cdr`, `ros1`, or one that is not read.
    pub(in crate::input) encoding: String,
}

impl Channel {
    /// How to read its messages, if they are such that frames are made of.
    pub(in crate::input) fn readable(&self) -> Option<(Kind, Encoding)> {
        let encoding = match self.encoding.as_str() {
            "cdr" => Encoding::Cdr,
            "ros1" => Encoding::Ros1,
            _ => return None,
        };
        Some((Kind::of(&self.type_name)?, encoding))
    }
}

/// A topic and what is known of its messages.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::input) struct Topic {
    pub(in crate::input) channel: Channel,
    /// Number of messages, in the whole recording or in its beginning.
    pub(in crate::input) count: u64,
    /// What the first message holds.
    pub(in crate::input) sample: Option<Sample>,
}

impl Topic {
    fn name(&self) -> &str {
        &self.channel.topic
    }

    fn kind(&self) -> Option<Kind> {
        self.channel.readable().map(|(kind, _)| kind)
    }

    /// The name without what image transports append to it.
    fn base(&self) -> &str {
        let name = self.name();
        let cut = ["/compressedDepth", "/compressed"].iter().find_map(|suffix| name.strip_suffix(suffix));
        cut.filter(|_| self.kind() == Some(Kind::Compressed)).unwrap_or(name)
    }

    /// Whether the name has a part that begins with one of these words.
    fn speaks_of(&self, words: &[&str]) -> bool {
        let lower = self.name().to_ascii_lowercase();
        lower.split(|c: char| !c.is_ascii_alphabetic()).any(|part| words.iter().any(|word| part.starts_with(word)))
    }

    fn is_infrared(&self) -> bool {
        self.speaks_of(&["ir", "infra"])
    }

    fn is_image(&self) -> bool {
        matches!(self.kind(), Some(Kind::Image | Kind::Compressed))
    }

    fn is_depth(&self) -> bool {
        // `aligned_depth_to_infra1` is depth, but not the colour camera's.
        let named = self.speaks_of(&["depth"]);
        let sampled = self.sample.as_ref().map(|sample| match sample.encoding.as_str() {
            "16UC1" | "32FC1" => named || !self.is_infrared(),
            "mono16" | "png" => named,
            format => self.kind() == Some(Kind::Compressed) && compressed::is_depth(format),
        });
        self.is_image() && sampled.unwrap_or(named)
    }

    /// Whether the depth was brought to the colour camera's view.
    fn is_registered(&self) -> bool {
        let name = self.name();
        let to_colour = ["depth_registered", "depth_to_color", "depth_to_rgb", "depth_to_colour"];
        to_colour.iter().any(|part| name.contains(part))
    }

    /// Order among depth topics that serve: registered ones first.
    fn depth_class(&self) -> u8 {
        u8::from(!self.is_registered()) + 2 * u8::from(self.is_infrared())
    }

    /// Order among colour topics that serve.
    fn colour_class(&self) -> u8 {
        match () {
            () if self.is_infrared() => 2,
            () if self.speaks_of(&["color", "colour", "rgb"]) => 0,
            () => 1,
        }
    }

    /// Order of what is the same image: as it is, or compressed; and as raw as can be, or rectified.
    fn form(&self) -> (bool, bool) {
        let plain = ["/image_raw", "/image_rect_color", "/image_color", "/image_rect_raw", "/image_rect", "/image"];
        (self.kind() == Some(Kind::Compressed), !plain.iter().any(|end| self.base().ends_with(end)))
    }
}

/// The names that two topics have in common from the left.
fn common(a: &str, b: &str) -> usize {
    a.split('/').zip(b.split('/')).take_while(|(a, b)| a == b).count()
}

/// The topics that were chosen.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::input) struct Chosen {
    pub(in crate::input) depth: Channel,
    pub(in crate::input) colour: Option<Channel>,
    pub(in crate::input) info: Option<Channel>,
}

/// Chooses by the options, else by types, encodings and names. `path` names the recording in messages.
///
/// # Errors
/// `Usage` where a topic that was asked for is not there or of another type; `Content` where there is no depth.
pub(in crate::input) fn choose(path: &Path, topics: &[Topic], options: &OpenOptions) -> Result<Chosen, Error> {
    let asked = |name: &Option<String>, option: &str, kinds: &[Kind]| {
        let Some(name) = name else { return Ok(None) };
        match topics.iter().find(|topic| topic.name() == name) {
            Some(topic) if topic.kind().is_some_and(|kind| kinds.contains(&kind)) => Ok(Some(topic)),
            Some(topic) => {
                let Channel { type_name, encoding, .. } = &topic.channel;
                Err(Error::Usage(format!(
                    "{option} {name}: its messages in {} are {type_name} in {encoding}, {} are needed in cdr or ros1",
                    path.display(),
                    kinds.iter().map(|kind| kind.name()).collect::<Vec<_>>().join(" or "),
                )))
            }
            None => {
                Err(Error::Usage(format!("{option} {name}: not in {}, which has {}", path.display(), list(topics))))
            }
        }
    };
    let images = [Kind::Image, Kind::Compressed];
    let depth = match asked(&options.depth_topic, "--depth", &images)? {
        Some(topic) => topic,
        None => {
            let serve: Vec<&Topic> =
                topics.iter().filter(|t| t.is_depth() && options.colour_topic.as_deref() != Some(t.name())).collect();
            best(path, "depth", &serve, |t| (t.count == 0, t.depth_class())).ok_or_else(|| Error::Content {
                path: path.to_owned(),
                reason: format!(
                    "no depth topic (Image or CompressedImage of ROS with 16UC1, 32FC1 or compressedDepth) among {}",
                    list(topics)
                ),
            })?
        }
    };
    let colour = match asked(&options.colour_topic, "--color", &images)? {
        Some(topic) => Some(topic),
        None => {
            let serve: Vec<&Topic> =
                topics.iter().filter(|t| t.is_image() && !t.is_depth() && t.name() != depth.name()).collect();
            let sizes = |t: &Topic| Some((t.sample.as_ref()?.size?, depth.sample.as_ref()?.size?));
            let other_size = |t: &Topic| sizes(t).is_some_and(|(colour, depth)| colour != depth);
            // Of several cameras the depth's own; it shares the most names, as /left/color does with /left/depth.
            let near = |t: &Topic| usize::MAX - common(t.name(), depth.name());
            best(path, "colour", &serve, |t| (t.count == 0, t.colour_class(), near(t), other_size(t)))
        }
    };
    let info = match asked(&options.info_topic, "--info", &[Kind::Info])? {
        Some(topic) => Some(topic),
        None => {
            let infos: Vec<&Topic> = topics.iter().filter(|t| t.kind() == Some(Kind::Info)).collect();
            let found = beside(depth, &infos).or_else(|| beside(colour?, &infos));
            if let (None, [first, ..]) = (found, infos.as_slice()) {
                tracing::warn!(
                    "{}: no CameraInfo stands beside {}; choose one with --info (there is {})",
                    path.display(),
                    depth.name(),
                    first.name()
                );
            }
            found
        }
    };
    let channel = |topic: &Topic| topic.channel.clone();
    Ok(Chosen { depth: channel(depth), colour: colour.map(channel), info: info.map(channel) })
}

/// The topic that comes first by `order`; says so where another could as well be meant.
fn best<'a, K: Ord>(path: &Path, what: &str, topics: &[&'a Topic], order: impl Fn(&Topic) -> K) -> Option<&'a Topic> {
    let full = |t: &&&Topic| (order(t), t.form(), t.name().to_owned());
    let chosen = *topics.iter().min_by_key(full)?;
    let others = topics.iter().filter(|t| t.base() != chosen.base()).map(|t| t.name());
    let others: Vec<&str> = others.take(MOST_LISTED).collect();
    let equal = topics.iter().any(|t| t.base() != chosen.base() && order(t) == order(chosen));
    let (path, name, option) = (path.display(), chosen.name(), if what == "depth" { "--depth" } else { "--color" });
    if equal {
        tracing::warn!("{path}: {what} is taken from {name}; {option} chooses another: {}", others.join(", "));
    } else if !others.is_empty() {
        tracing::info!("{path}: {what} is taken from {name}, not from {}", others.join(", "));
    }
    Some(chosen)
}

/// The calibration in the same namespace, or in the nearest one around it.
fn beside<'a>(image: &Topic, infos: &[&'a Topic]) -> Option<&'a Topic> {
    let mut namespace = image.base();
    while let Some((outer, _)) = namespace.rsplit_once('/') {
        let name = format!("{outer}/camera_info");
        if let Some(info) = infos.iter().find(|info| info.name() == name) {
            return Some(info);
        }
        // Not up to a calibration of everything.
        if outer.matches('/').count() < 2 {
            return None;
        }
        namespace = outer;
    }
    None
}

/// The topics with their types, for messages.
fn list(topics: &[Topic]) -> String {
    if topics.is_empty() {
        return "no topics at all".to_owned();
    }
    let mut lines: Vec<String> = topics
        .iter()
        .map(|t| format!("{} ({} in {}, {} messages)", t.name(), t.channel.type_name, t.channel.encoding, t.count))
        .collect();
    lines.sort();
    let more = lines.len().saturating_sub(MOST_LISTED);
    lines.truncate(MOST_LISTED);
    if more > 0 {
        lines.push(format!("and {more} more"));
    }
    lines.join(", ")
}

#[cfg(test)]
mod tests;
