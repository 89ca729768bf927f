//! What an image takes: memory by section, stack, instructions by stage.

use std::path::Path;
use std::{fmt, fs};

use super::Arithmetic;
use super::board::Board;
use super::data;
use super::output::{Frame, Run};
use crate::elf;

/// Instructions that the frame with three candidates may take on a Cortex-M7, in integers.
const MOST_INSTRUCTIONS: u64 = 97_000_000;

/// Bytes of RAM, stack and all, and of stack, that the pipeline in integers may take.
const MOST_RAM: u64 = 512 << 10;
const MOST_STACK: u64 = 16 << 10;

/// The budgets' frame.
const THREE: &str = "three candidates ";

/// The stages that make up a frame.
const WHOLE: [&str; 3] = ["rows", "filter", "recognise"];

/// What an image takes; memory in bytes.
#[derive(Debug, Clone)]
pub(crate) struct Measured {
    pub(crate) board: Board,
    pub(crate) arithmetic: Arithmetic,
    /// Statics that are copied from flash at the start.
    pub(crate) data: u64,
    /// Statics that begin as zeros.
    pub(crate) bss: u64,
    /// The most that was in use.
    pub(crate) stack: u64,
    pub(crate) code: u64,
    /// Without the template set.
    pub(crate) constants: u64,
    pub(crate) templates: u64,
    /// Instructions of each stage and of the whole frame: in the frame with three candidates, and on average.
    pub(crate) stages: Vec<(String, u64, u64)>,
}

impl Measured {
    /// Of an image that has run; averages are those of `frames`.
    pub(crate) fn new(
        board: Board,
        arithmetic: Arithmetic,
        run: &Run,
        frames: &[&Frame],
        image: &Path,
    ) -> Result<Self, String> {
        let bytes = fs::read(image).map_err(|error| format!("{}: {error}", image.display()))?;
        let sections = elf::sections(&bytes).ok_or_else(|| format!("{} is no 32-bit ELF file", image.display()))?;
        let size = |wanted: &dyn Fn(&elf::Section) -> bool| -> u64 {
            sections.iter().filter(|section| wanted(section)).map(|section| section.size).sum()
        };
        let named = |name: &str| size(&|section| section.name == name);
        let folder = data::folder().map_err(|_| "no template set")?;
        let templates = fs::metadata(folder.join(format!("{}.pldt", arithmetic.name())))
            .map_err(|error| format!("template set: {error}"))?
            .len();
        let (data, constants) = (named(".data"), named(".rodata"));
        Ok(Self {
            board,
            arithmetic,
            data,
            bss: named(".bss") + named(".uninit"),
            stack: run.stack,
            code: size(&|section| section.in_flash) - data - constants,
            constants: constants.checked_sub(templates).ok_or("the template set is not among the constants")?,
            templates,
            stages: stages(frames)?,
        })
    }

    /// Static RAM.
    pub(crate) fn ram(&self) -> u64 {
        self.data + self.bss
    }

    /// Flash without the template set.
    pub(crate) fn flash(&self) -> u64 {
        self.code + self.constants + self.data
    }

    /// Instructions of the frame with three candidates.
    pub(crate) fn instructions(&self) -> u64 {
        self.stages.last().map_or(0, |(_, three, _)| *three)
    }

    /// Which limits are not kept.
    pub(crate) fn check(&self, run: &Run) -> Vec<String> {
        let mut failures = Vec::new();
        let mut fail = |wrong: bool, what: String| failures.extend(wrong.then_some(what));
        let (counted, expected) = run.calibration;
        fail(counted.abs_diff(expected) * 1000 > expected, format!("{counted} instructions counted of {expected}"));
        if self.arithmetic == Arithmetic::Fixed {
            let (ram, stack) = (self.ram() + self.stack, self.stack);
            fail(ram > MOST_RAM, format!("{ram} bytes of RAM, more than {MOST_RAM}"));
            fail(stack > MOST_STACK, format!("{stack} bytes of stack, more than {MOST_STACK}"));
            let instructions = self.instructions();
            let too_many = self.board.cpu == "cortex-m7" && instructions > MOST_INSTRUCTIONS;
            fail(too_many, format!("{instructions} instructions for a frame, more than {MOST_INSTRUCTIONS}"));
        }
        failures
    }
}

/// Each stage's instructions in the frame with three candidates, and on average; the last is the whole frame.
fn stages(frames: &[&Frame]) -> Result<Vec<(String, u64, u64)>, String> {
    let three = frames.iter().find(|frame| frame.name.starts_with(THREE)).ok_or("the three candidates were not run")?;
    let whole = |frame: &Frame| WHOLE.iter().filter_map(|stage| frame.budget(stage)).sum::<u64>();
    let count = frames.len().max(1) as u64;
    let average = |of: &dyn Fn(&Frame) -> u64| frames.iter().map(|frame| of(frame)).sum::<u64>() / count;
    let parts = three.budgets.iter().filter(|(stage, _)| stage != "recognise").map(|(stage, instructions)| {
        (stage.clone(), *instructions, average(&|frame| frame.budget(stage).unwrap_or_default()))
    });
    Ok(parts.chain([("whole frame".to_owned(), whole(three), average(&whole))]).collect())
}

impl fmt::Display for Measured {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { data, bss, stack, code, constants, templates, .. } = self;
        writeln!(f, "RAM: .data {data}, .bss {bss}, stack {stack} bytes")?;
        writeln!(f, "flash: code {code}, constants {constants}, template set {templates} bytes")?;
        writeln!(f, "{:>26} {:>16} {:>12}", "instructions", "three candidates", "average")?;
        self.stages.iter().try_for_each(|(stage, three, average)| writeln!(f, "{stage:>26} {three:>16} {average:>12}"))
    }
}

#[cfg(test)]
mod tests {
    use super::super::output::EXAMPLE;
    use super::*;

    #[test]
    fn stages_are_averaged_and_summed() {
        let run = Run::parse(EXAMPLE).unwrap();
        let frames: Vec<&Frame> = run.frames.iter().collect();
        let stages = stages(&frames).unwrap();
        let expected = [("rows", 100, 200), ("filter", 200, 100), ("whole frame", 600, 450)];
        assert_eq!(stages, expected.map(|(stage, three, average)| (stage.to_owned(), three, average)));
        assert!(super::stages(&frames[1..]).is_err());
    }

    #[test]
    fn limits() {
        let mut run = Run::parse(EXAMPLE).unwrap();
        let board = Board::of("an500").unwrap();
        let stages = vec![("whole frame".to_owned(), MOST_INSTRUCTIONS, 0)];
        let arithmetic = Arithmetic::Fixed;
        let mut measured =
            Measured { board, arithmetic, data: 0, bss: 0, stack: 1, code: 0, constants: 0, templates: 0, stages };
        assert!(measured.check(&run).is_empty());
        measured.stack = MOST_STACK + 1;
        measured.bss = MOST_RAM - MOST_STACK;
        measured.stages[0].1 += 1;
        run.calibration = (1_998_000 - 1, 2_000_000);
        assert_eq!(measured.check(&run).len(), 4);
        measured.arithmetic = Arithmetic::Float;
        assert_eq!(measured.check(&run).len(), 1);
    }
}
