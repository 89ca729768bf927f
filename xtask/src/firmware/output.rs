//! What an image prints, taken apart.

use std::collections::BTreeMap;

/// What the image said of one frame.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Frame {
    /// The golden frame's name and the arithmetic.
    pub(crate) name: String,
    /// The lines after the name: what was found, and the digests.
    pub(crate) lines: Vec<String>,
    /// Instructions by stage, in the order in which they were printed.
    pub(crate) budgets: Vec<(String, u64)>,
}

/// What the image said.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Run {
    pub(crate) frames: Vec<Frame>,
    /// Instructions that were counted, and those that there were.
    pub(crate) calibration: (u64, u64),
    /// Bytes of stack that were used.
    pub(crate) stack: u64,
}

impl Run {
    /// Takes the output apart: a first line with the board's name, then the frames, parted by empty lines.
    pub(crate) fn parse(text: &str) -> Result<Self, String> {
        let mut frames: Vec<Frame> = Vec::new();
        let mut whole = BTreeMap::new();
        let mut lines = text.lines().skip(1);
        while let Some(line) = lines.next() {
            if line.is_empty() {
                let name = lines.next().ok_or("the output ends where a frame begins")?.to_owned();
                frames.push(Frame { name, lines: Vec::new(), budgets: Vec::new() });
            } else if let Some(budget) = line.strip_prefix("budget ") {
                let (name, value) = budget.split_once(": ").ok_or_else(|| format!("not understood: {line}"))?;
                match (name, frames.last_mut()) {
                    ("stack" | "calibration", _) => drop(whole.insert(name, value)),
                    (_, Some(frame)) => frame.budgets.push((name.to_owned(), number(value)?)),
                    _ => return Err(format!("not understood: {line}")),
                }
            } else {
                frames.last_mut().ok_or_else(|| format!("not understood: {line}"))?.lines.push(line.to_owned());
            }
        }
        let of = |name| whole.get(name).copied().ok_or_else(|| format!("the image did not say its {name}"));
        let calibration = of("calibration")?.split_once(" of ").ok_or("the calibration is not understood")?;
        let calibration = (number(calibration.0)?, number(calibration.1)?);
        Ok(Self { frames, calibration, stack: number(of("stack")?)? })
    }
}

impl Frame {
    /// The digests, as the golden file has them in a line.
    pub(crate) fn digests(&self) -> Vec<(&str, &str)> {
        self.lines.iter().filter_map(|line| line.strip_prefix("digest ")?.split_once(' ')).collect()
    }

    /// Instructions of a stage.
    pub(crate) fn budget(&self, stage: &str) -> Option<u64> {
        self.budgets.iter().find(|(name, _)| name == stage).map(|(_, count)| *count)
    }
}

fn number(text: &str) -> Result<u64, String> {
    text.parse().map_err(|_| format!("no number: {text}"))
}

#[cfg(test)]
pub(crate) const EXAMPLE: &str = "board Cortex, fixed\nbudget calibration: 2000006 of 2000000\n\n\
    three candidates fixed\nfound desk: template 12\ndigest depth 4ce1fbc3\ndigest floor b89ec569\nbudget rows: 100\nbudget filter: 200\n\
    budget recognise: 300\n\nroom 4 fixed\ndigest depth 2a36b81e\nbudget rows: 300\nbudget stack: 6868\n";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_output_is_taken_apart() {
        let run = Run::parse(EXAMPLE).unwrap();
        assert_eq!((run.calibration, run.stack, run.frames.len()), ((2_000_006, 2_000_000), 6868, 2));
        let [first, second] = &run.frames[..] else { unreachable!() };
        assert_eq!(first.name, "three candidates fixed");
        assert_eq!(first.digests(), [("depth", "4ce1fbc3"), ("floor", "b89ec569")]);
        assert_eq!((first.budget("filter"), second.budget("rows"), second.budget("x")), (Some(200), Some(300), None));
    }

    #[test]
    fn what_is_cut_is_told() {
        assert!(Run::parse("").is_err());
        assert!(Run::parse(EXAMPLE.trim_end_matches("budget stack: 6868\n")).unwrap_err().contains("stack"));
        assert!(Run::parse("board\nx\n").is_err());
    }
}
