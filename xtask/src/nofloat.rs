//! The pipeline in integers, linked for a core without FPU: no routine of software floating point may be in it.
//!
//! The check looks for the names of the compiler's float routines among the program's symbols, and then proves that it
//! would see one: built with one float multiplication more, the same check must fail.

use crate::report::{Outcome, Report};
use crate::symbols::Program;

/// A core without FPU.
const TARGET: &str = "thumbv7m-none-eabi";

/// One step.
pub(crate) fn run(report: &mut Report) {
    report.step(format!("no float routine in the integer pipeline, {TARGET}"), || {
        let clean = Program { name: "fixed", target: TARGET, feature: "" };
        clean
            .find(is_float_routine, |found| match found[..] {
                [] => Outcome::Passed,
                _ => Outcome::Failed(format!("the program has float routines: {}", found.join(", "))),
            })
            .and_then(|| {
                Program { feature: "float", ..clean }.find(is_float_routine, |found| match found[..] {
                    [] => Outcome::Failed("a float multiplication was put in, and the check does not see it".into()),
                    _ => {
                        println!("with a float multiplication put in: {}", found.join(", "));
                        Outcome::Passed
                    }
                })
            })
    });
}

/// Whether a symbol is one of the compiler's or libm's float routines (the names of the ARM run-time ABI, section 4.1.2,
/// and of libgcc's soft-float routines).
pub(crate) fn is_float_routine(name: &str) -> bool {
    let aeabi = ["__aeabi_f", "__aeabi_d", "__aeabi_cf", "__aeabi_cd", "__aeabi_cr", "__aeabi_h2f"];
    let from_integer = ["__aeabi_i2", "__aeabi_ui2", "__aeabi_l2", "__aeabi_ul2"];
    let libgcc =
        ["sf2", "sf3", "df2", "df3", "sfdf2", "dfsf2", "sfsi", "sfdi", "dfsi", "dfdi", "sisf", "disf", "sidf", "didf"];
    aeabi.iter().chain(&from_integer).any(|prefix| name.starts_with(prefix))
        || (name.starts_with("__") && libgcc.iter().any(|suffix| name.ends_with(suffix)))
        || name.contains("compiler_builtins5float")
        || name.contains("libm4math")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn float_routines_are_told_from_others() {
        for name in ["__aeabi_fadd", "__mulsf3", "__aeabi_ui2d", "__floatunsisf", "__aeabi_cfcmple", "__fixunssfsi"] {
            assert!(is_float_routine(name), "{name}");
        }
        for name in ["__aeabi_uidiv", "__aeabi_memcpy", "__aeabi_ldivmod", "__udivmoddi4", "entry", "__aeabi_lmul"] {
            assert!(!is_float_routine(name), "{name}");
        }
    }
}
