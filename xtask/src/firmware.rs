//! `tests/firmware`: images for microcontrollers, built for each board, run in QEMU, and compared with the host bit by bit.

mod board;
mod budget;
mod build;
mod compare;
mod data;
mod log;
mod output;
mod page;
mod qemu;
mod tolerance;

use std::time::Duration;

pub(crate) use self::board::{Board, cpu};
pub(crate) use self::build::build;
pub(crate) use self::qemu::{command, qemu};

use self::board::BOARDS;
use self::budget::Measured;
use self::output::Run;
use crate::report::{Outcome, Report};

/// The golden frames that are run by default, by their number: the one with three candidates, which the budgets speak of,
/// one or two of each room, and two with the parameters that the others leave out.
const SUBSET: [usize; 7] = [0, 2, 6, 11, 16, 21, 26];

/// How long an image may run.
const LIMIT: Duration = Duration::from_secs(180);

/// What is asked for.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Options {
    /// All golden frames in place of some.
    all: bool,
    /// Write what is committed of the images' output anew.
    overwrite: bool,
    /// Write the tables anew.
    renew: bool,
    /// One board alone.
    board: Option<Board>,
}

impl Options {
    /// From the words of the command line; `None` if they are none.
    pub(crate) fn parse(words: &[&str]) -> Option<Self> {
        let mut options = Self::default();
        let mut words = words.iter();
        while let Some(word) = words.next() {
            match *word {
                "--all" => options.all = true,
                "--overwrite" => options.overwrite = true,
                "--renew" => options.renew = true,
                "--board" => options.board = Some(Board::of(words.next()?)?),
                _ => return None,
            }
        }
        // What is written anew must be whole.
        let whole = (options.all || !options.overwrite) && (options.board.is_none() || !options.renew);
        whole.then_some(options)
    }
}

/// The pipeline's arithmetic in an image.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Arithmetic {
    Fixed,
    Float,
}

impl Arithmetic {
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Fixed => "fixed",
            Self::Float => "float",
        }
    }

    /// As it is called in tables.
    pub(crate) const fn in_words(self) -> &'static str {
        match self {
            Self::Fixed => "integers",
            Self::Float => "floats",
        }
    }

    const fn feature(self) -> &'static str {
        match self {
            Self::Fixed => "",
            Self::Float => "float",
        }
    }
}

/// A step for each image, and one for the tables.
pub(crate) fn run(report: &mut Report, options: Options) {
    let mut made = Outcome::Passed;
    report.step("firmware: frames and template sets", || {
        made = data::folder().map_or_else(|outcome| outcome, |_| Outcome::Passed);
        made.clone()
    });
    if made != Outcome::Passed {
        return;
    }
    let mut measured = Vec::new();
    let mut overwritten = Vec::new();
    for board in BOARDS.into_iter().filter(|board| options.board.is_none_or(|only| only == *board)) {
        for arithmetic in [Arithmetic::Fixed, Arithmetic::Float] {
            if arithmetic == Arithmetic::Float && !board.fpu {
                continue;
            }
            let name = format!("firmware: {} ({}), {}", board.title, board.name, arithmetic.name());
            report.step(name, || {
                let overwrite = options.overwrite && !overwritten.contains(&arithmetic);
                image(board, arithmetic, options.all, overwrite).map_or_else(
                    |outcome| outcome,
                    |(budget, outcome)| {
                        overwritten.extend(overwrite.then_some(arithmetic));
                        measured.push(budget);
                        outcome
                    },
                )
            });
        }
    }
    if options.board.is_none() {
        report.step("firmware: budgets", || page::step(&measured, options.renew));
        log::run(report, options.overwrite);
    }
}

/// Builds, runs and judges an image: what it takes, and what came of it.
fn image(board: Board, arithmetic: Arithmetic, all: bool, overwrite: bool) -> Result<(Measured, Outcome), Outcome> {
    let image = build(board, arithmetic.feature(), "frames")?;
    let frames = data::folder()?.join("frames.bin");
    let list = if all { "all".to_owned() } else { SUBSET.map(|index| index.to_string()).join(",") };
    let text = qemu(board, &image, &[&frames.to_string_lossy(), &list], LIMIT)?;
    let run = Run::parse(&text).map_err(Outcome::Failed)?;
    let wanted = (!all).then_some(&SUBSET[..]);
    // Averages are those of the same frames, however many are run.
    let frames: Vec<_> = if all {
        SUBSET.iter().filter_map(|index| run.frames.get(*index)).collect()
    } else {
        run.frames.iter().collect()
    };
    let measured = Measured::new(board, arithmetic, &run, &frames, &image).map_err(Outcome::Failed)?;
    print!("{measured}");
    let failures: Vec<String> = [
        compare::with_host(&run, arithmetic, wanted),
        compare::with_committed(&run, arithmetic, overwrite),
        measured.check(&run),
    ]
    .concat();
    let outcome = if failures.is_empty() { Outcome::Passed } else { Outcome::Failed(failures.join("; ")) };
    Ok((measured, outcome))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options() {
        assert!(Options::parse(&[]).is_some());
        assert!(Options::parse(&["--all", "--overwrite", "--renew"]).is_some());
        assert_eq!(Options::parse(&["--board", "virt"]).unwrap().board.unwrap().name, "virt");
        for wrong in [&["--overwrite"][..], &["--board"], &["--board", "x"], &["--renew", "--board", "virt"], &["x"]] {
            assert!(Options::parse(wrong).is_none(), "{wrong:?}");
        }
    }
}
