//! Tables compared number by number: compilers and their settings move figures a little.

/// By how much instructions and sizes may differ from what is committed.
const INSTRUCTIONS: f64 = 0.03;
const SIZES: f64 = 0.05;

/// The same where another compiler's figures are committed.
const OTHER_COMPILER: f64 = 0.15;

/// What is always granted: instructions are rounded to hundredths of a million, sizes to tenths of a KiB.
const ROUNDED_INSTRUCTIONS: f64 = 0.015;
const ROUNDED_SIZES: f64 = 0.15;

/// The rows of tables where a number differs by more than is granted, or a word. Text around tables is not looked at.
pub(crate) fn differences(old: &str, new: &str, same_compiler: bool) -> Vec<String> {
    let (old, new) = (rows(old), rows(new));
    if old.len() != new.len() {
        return vec![format!("{} rows of tables, not {}", old.len(), new.len())];
    }
    let mut found = Vec::new();
    let mut heads = &Vec::new();
    for (i, (old_row, new_row)) in old.iter().zip(&new).enumerate() {
        if new.get(i + 1).is_some_and(|row| row.iter().all(|cell| cell.starts_with("---"))) {
            heads = new_row;
        }
        let is_size =
            |column: usize| [new_row.first(), heads.get(column)].into_iter().flatten().any(|name| name.contains("KiB"));
        let alike = |column: usize, old: &str, new: &str| {
            let (granted, rounded) =
                if is_size(column) { (SIZES, ROUNDED_SIZES) } else { (INSTRUCTIONS, ROUNDED_INSTRUCTIONS) };
            let granted = if same_compiler { granted } else { OTHER_COMPILER };
            let words = |cell: &str| cell.split_whitespace().map(str::to_owned).collect::<Vec<_>>();
            let (old, new) = (words(old), words(new));
            old.len() == new.len() && old.iter().zip(&new).all(|(old, new)| close(old, new, granted, rounded))
        };
        let same = old_row.len() == new_row.len()
            && old_row.iter().zip(new_row).enumerate().all(|(column, (old, new))| alike(column, old, new));
        if !same {
            found.push(format!("'{}' is now '{}'", old_row.join(" | "), new_row.join(" | ")));
        }
    }
    found
}

/// Rows of tables by their cells.
fn rows(text: &str) -> Vec<Vec<String>> {
    let cells = |line: &str| line.trim().trim_matches('|').split('|').map(|cell| cell.trim().to_owned()).collect();
    text.lines().filter(|line| line.starts_with('|')).map(cells).collect()
}

fn close(old: &str, new: &str, granted: f64, rounded: f64) -> bool {
    match (old.parse::<f64>(), new.parse::<f64>()) {
        (Ok(old), Ok(new)) => (old - new).abs() <= (old * granted).max(rounded),
        _ => old == new,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TABLE: &str = "text 1\n| | integers | RAM, KiB |\n|---|---:|---:|\n| rows | 10.00 / 20.00 | 100.0 + 6.0 |\n| code, KiB | 100 | 100 |\n";

    #[test]
    fn numbers_may_move_a_little() {
        let changed = |from: &str, to: &str, same| differences(TABLE, &TABLE.replacen(from, to, 1), same).len();
        assert_eq!(changed("text 1", "text 2", true), 0);
        assert_eq!(changed("20.00", "20.59", true), 0);
        assert_eq!(changed("20.00", "20.61", true), 1);
        assert_eq!(changed("20.00", "20.61", false), 0);
        assert_eq!(changed("20.00", "16.00", false), 1);
        assert_eq!(changed("100.0", "104.9", true), 0);
        assert_eq!(changed("100.0", "105.1", true), 1);
        assert_eq!(changed("6.0", "6.1", true), 0);
        assert_eq!(changed("KiB | 100", "KiB | 104", true), 0);
        assert_eq!(changed("KiB | 100", "KiB | 106", true), 1);
        assert_eq!(changed("rows", "lines", true), 1);
        assert_eq!(changed("| rows | 10.00 / 20.00 | 100.0 + 6.0 |\n", "", true), 1);
    }
}
