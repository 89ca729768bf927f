//! Golden bits: what every stage leaves behind, in both arithmetics, is what is committed.

#[path = "golden/digests.rs"]
mod digests;

#[test]
fn every_stage_leaves_the_golden_bits() {
    let golden = include_str!("golden/digests.txt");
    // The workspaces pass through the stack before they are boxed.
    let made = std::thread::Builder::new().stack_size(64 << 20).spawn(digests::text).unwrap();
    let text = made.join().unwrap();
    let changed: Vec<String> = golden
        .lines()
        .zip(text.lines())
        .filter(|(old, new)| old != new)
        .map(|(old, new)| format!("-{old}\n+{new}"))
        .collect();
    assert!(
        changed.is_empty() && golden.len() == text.len(),
        "if that is meant, `cargo xtask golden` renews tests/golden/digests.txt:\n{}",
        changed.join("\n")
    );
}
