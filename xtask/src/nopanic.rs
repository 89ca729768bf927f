//! Both pipelines, linked for a microcontroller: no path to a panic may be in them.
//!
//! The compiler removes every check of an index, of a divisor or of a length that it can prove to hold. What it cannot
//! prove leaves a call of `core::panicking` behind, whose name the check looks for. Then it proves that it would see one:
//! built with one index more that may be out of bounds, the same check must fail.

use crate::report::{Outcome, Report};
use crate::symbols::Program;

/// A core with FPU for both arithmetics, and one without for the integers.
const PROGRAMS: [(&str, &str); 3] =
    [("fixed", "thumbv7em-none-eabihf"), ("float", "thumbv7em-none-eabihf"), ("fixed", "thumbv7m-none-eabi")];

/// One step for each program.
pub(crate) fn run(report: &mut Report) {
    for (name, target) in PROGRAMS {
        report.step(format!("no path to a panic in the {name} pipeline, {target}"), || {
            let clean = Program { name, target, feature: "" };
            clean
                .find(is_panic, |found| match found[..] {
                    [] => Outcome::Passed,
                    _ => Outcome::Failed(format!("the program can panic: {}", found.join(", "))),
                })
                .and_then(|| {
                    Program { feature: "panic", ..clean }.find(is_panic, |found| match found[..] {
                        [] => Outcome::Failed("an unchecked index was put in, and the check does not see it".into()),
                        _ => {
                            println!("with an unchecked index put in: {}", found.join(", "));
                            Outcome::Passed
                        }
                    })
                })
        });
    }
}

/// Whether a symbol is one of `core`'s ways to panic, in either mangling. The panic handler itself is none: in an archive
/// it is there whether anything calls it or not.
pub(crate) fn is_panic(name: &str) -> bool {
    // The module of most of them; the cold functions of options, results, slices, strings and cells.
    const PARTS: [&str; 7] =
        ["panicking", "panic_", "do_panic", "expect_failed", "unwrap_failed", "error_fail", "fail_rt"];
    // `slice_index_fail`, `slice_end_index_len_fail`, `len_mismatch_fail`: the name ends so.
    let fails = |name: &str| {
        ["index_fail", "len_fail", "order_fail", "overflow_fail", "mismatch_fail"]
            .iter()
            .any(|part| name.contains(part))
    };
    PARTS.iter().any(|part| name.contains(part)) || fails(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ways_to_panic_are_told_from_others() {
        for name in [
            "_ZN4core9panicking18panic_bounds_check17h0123456789abcdefE",
            "_RNvNtCsjx29ioQPlCq_4core9panicking9panic_fmt",
            "_RNvNtCsjx29ioQPlCq_4core6option13expect_failed",
            "_ZN4core6result13unwrap_failed17h0123456789abcdefE",
            "_RNvNtNtCsjx29ioQPlCq_4core5slice5index16slice_index_fail",
            "_ZN4core5slice5index24slice_end_index_len_fail17h0123456789abcdefE",
            "_RNvNtNtCsjx29ioQPlCq_4core3str16slice_error_fail",
            "_RNvNvNtCsjx29ioQPlCq_4core5slice20copy_from_slice_impl17len_mismatch_fail",
            "_RNvNtNtNtNtCs_4core5slice4sort6shared9smallsort22panic_on_ord_violation",
        ] {
            assert!(is_panic(name), "{name}");
        }
        for name in
            ["entry", "_RNvCs_7___rustc17rust_begin_unwind", "_RNvCs_5fixed5panic", "memcpy", "__aeabi_uldivmod"]
        {
            assert!(!is_panic(name), "{name}");
        }
    }
}
