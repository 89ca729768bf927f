//! A summary as people read it.

use std::fmt::{Display, Formatter, Result};

use super::{Registration, Summary, Timing, Verdict};

impl Display for Summary {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        let mut row = |name: &str, text: String| writeln!(f, "{name:13} {text}");
        row("frames", format!("{}, looked at {}", self.frames, self.looked_at))?;
        row("time", time(&self.timing))?;
        let sizes: Vec<String> =
            self.sizes.iter().map(|s| format!("{}x{} (reduced by {})", s.width, s.height, s.factor)).collect();
        row(
            "images",
            format!("{}, {}", sizes.join(", "), if self.colour { "colour and depth" } else { "depth alone" }),
        )?;
        if let Some(camera) = &self.intrinsics {
            let [fx, fy, cx, cy] = camera.k;
            row("intrinsics", format!("fx {fx} fy {fy} cx {cx} cy {cy}, from {}", camera.origin))?;
        }
        let d = &self.depth;
        let depth = match (d.min, d.p1, d.p50, d.p99, d.max) {
            (Some(min), Some(p1), Some(p50), Some(p99), Some(max)) => {
                format!("{min:.3} m to {max:.3} m; 1 % below {p1:.3}, half below {p50:.3}, 99 % below {p99:.3}")
            }
            _ => "no reading at all".to_owned(),
        };
        row("depth", depth)?;
        row("no reading", format!("{:.1} % of the pixels", 100.0 * d.invalid))?;
        let read = self.looked_at - self.unreadable.len().min(self.looked_at);
        row("floor", format!("found in {} of {read} frames", self.floors))?;
        if let (Some([low, height, high]), Some([least, pitch, most])) = (self.height, self.pitch) {
            row(
                "camera",
                format!(
                    "{height:.2} m above the floor ({low:.2} to {high:.2}), looking down {pitch:.0}\u{b0} ({least:.0}\u{b0} to {most:.0}\u{b0})"
                ),
            )?;
        }
        row("registration", self.registration.as_ref().map_or("no colour to compare with".to_owned(), registration))?;
        for frame in &self.unreadable {
            row("unreadable", format!("frame {}: {}", frame.frame, frame.error))?;
        }
        Ok(())
    }
}

fn time(timing: &Timing) -> String {
    let Some(rate) = timing.rate else { return format!("{:.3} s", timing.duration) };
    let mut text = format!("{:.3} s at {rate:.2} frames a second", timing.duration);
    match timing.longest {
        Some((longest, after)) if timing.gaps > 0 => {
            text += &format!("; {} gaps, the longest of {longest:.3} s after frame {after}", timing.gaps);
        }
        _ => text += ", no gaps",
    }
    if timing.backwards > 0 {
        text += &format!("; {} frames are not later than the one before", timing.backwards);
    }
    text
}

fn registration(r: &Registration) -> String {
    let [dx, dy] = r.shift;
    let verdict = match r.verdict {
        Verdict::Registered => "registered".to_owned(),
        Verdict::Off => format!("off by ({dx},{dy}) pixels (so far right and down the depth would have to move)"),
        Verdict::CannotTell if r.jumps == 0 => return "cannot tell: too few jumps in the depth".to_owned(),
        Verdict::CannotTell => {
            "cannot tell: no shift fits better than the others (if the images are rich in edges: not \
                                registered)"
                .to_owned()
        }
    };
    format!("{verdict}; agreement {:.3} ({:.2} times chance), best {:.3} at ({dx},{dy})", r.agreement, r.ratio, r.best)
}
