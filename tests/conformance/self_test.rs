//! The suite's own test: each bound of the table, loosened or exceeded, is told.

use std::collections::BTreeMap;

use crate::errors::{Errors, Key};
use crate::rows::QUANTITIES;
use crate::table::TABLE;

/// Loosens every bound to three times what it is, one by one, and lets every error exceed its bound; returns how many bounds
/// were tried, and what went unnoticed.
pub fn run(measured: &BTreeMap<Key, Errors>) -> (usize, Vec<String>) {
    let (mut tried, mut unnoticed) = (0, Vec::new());
    for row in TABLE {
        let Some(errors) = measured.get(&Key { stage: row.stage, pair: row.pair, set: row.set }) else { continue };
        for quantity in QUANTITIES {
            let Some(loose) = row.loosened(quantity, 3.0) else { continue };
            tried += 1;
            if loose.complaints(errors).is_empty() {
                unnoticed.push(format!("{} {:?} {:?}: {quantity:?} loosened", row.stage, row.pair, row.set));
            }
        }
        let exceeding = row.complaints(&errors.scaled(3.0));
        if exceeding.len() < QUANTITIES.iter().filter(|q| row.loosened(**q, 3.0).is_some()).count() {
            unnoticed.push(format!("{} {:?} {:?}: exceeded, but only {exceeding:?}", row.stage, row.pair, row.set));
        }
    }
    (tried, unnoticed)
}
