//! TUM-style lists of a recording's files, and which colour image goes with which depth image.

use std::cmp::Ordering;
use std::path::Path;

use super::Stamp;
use crate::Error;
use crate::error::excerpt;

/// Colour and depth taken 0.02 s apart or more are not one frame (the limit of TUM's associate.py).
pub(super) const MAX_APART: u64 = 20_000_000;

/// One frame as listed.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Entry {
    /// Time of the depth image.
    pub(super) stamp: Stamp,
    /// Time of the colour image.
    pub(super) colour_stamp: Option<Stamp>,
    /// The colour image, as listed.
    pub(super) colour: Option<String>,
    /// The depth image, as listed.
    pub(super) depth: String,
    /// Line of the list, counted from 1; 0 where there is no list.
    pub(super) line: usize,
}

/// One line of `rgb.txt` or `depth.txt`.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Stamped {
    pub(super) stamp: Stamp,
    pub(super) file: String,
    pub(super) line: usize,
}

/// The lines that say something, as (number from 1, fields). Commas and tabs separate as blanks do.
fn lines(text: &str) -> impl Iterator<Item = (usize, Vec<&str>)> {
    text.lines()
        .enumerate()
        .map(|(i, line)| {
            let fields = line.split(|c: char| c.is_whitespace() || c == ',').filter(|f| !f.is_empty()).collect();
            (i + 1, fields)
        })
        .filter(|(_, fields): &(usize, Vec<&str>)| fields.first().is_some_and(|f| !f.starts_with('#')))
}

fn stamp(path: &Path, line: usize, text: &str) -> Result<Stamp, Error> {
    text.parse().map_err(|()| Error::Line {
        path: path.to_owned(),
        line,
        reason: format!("{:?} is not a time stamp in seconds", excerpt(text)),
    })
}

/// Parses `associations.txt`: `stamp file stamp file`, colour first unless the names say that depth is.
pub(super) fn parse_associations(path: &Path, text: &str) -> Result<Vec<Entry>, Error> {
    lines(text)
        .map(|(line, fields)| {
            let &[t0, f0, t1, f1] = fields.as_slice() else {
                return Err(Error::Line {
                    path: path.to_owned(),
                    line,
                    reason: format!(
                        "{} fields, an association has four: t_rgb rgb_file t_depth depth_file",
                        fields.len()
                    ),
                });
            };
            let (t0, t1) = (stamp(path, line, t0)?, stamp(path, line, t1)?);
            let says_depth = |f: &str| f.to_ascii_lowercase().contains("depth");
            let depth_first = says_depth(f0) && !says_depth(f1);
            let ((stamp, depth), (t, colour)) = if depth_first { ((t0, f0), (t1, f1)) } else { ((t1, f1), (t0, f0)) };
            let (colour_stamp, colour) = (Some(t), Some(colour.to_owned()));
            Ok(Entry { stamp, colour_stamp, colour, depth: depth.to_owned(), line })
        })
        .collect()
}

/// Parses `rgb.txt` or `depth.txt`: `stamp file`.
pub(super) fn parse_list(path: &Path, text: &str) -> Result<Vec<Stamped>, Error> {
    lines(text)
        .map(|(line, fields)| match fields.as_slice() {
            &[t, file] => Ok(Stamped { stamp: stamp(path, line, t)?, file: file.to_owned(), line }),
            _ => Err(Error::Line {
                path: path.to_owned(),
                line,
                reason: format!("{} fields, a list has two: stamp file", fields.len()),
            }),
        })
        .collect()
}

/// Pairs each depth image with a colour image, nearest pairs first, each file in one pair at most (as associate.py).
/// What finds no partner is left out. The result is in the order of the depth images' stamps.
pub(super) fn associate(path: &Path, colour: &[Stamped], depth: &[Stamped]) -> Result<Vec<Entry>, Error> {
    let mut by_time: Vec<usize> = (0..colour.len()).collect();
    by_time.sort_by_key(|&c| colour[c].stamp);
    let mut pairs = Vec::new();
    for (d, &Stamped { stamp, .. }) in depth.iter().enumerate() {
        let is_near = |c: usize| colour[c].stamp.apart(stamp) < MAX_APART;
        let from = by_time.partition_point(|&c| colour[c].stamp < stamp && !is_near(c));
        let near = by_time[from..].iter().take_while(|&&c| is_near(c));
        // Small numbers all: less than `MAX_APART`, and lines of a file of less than 4 GB.
        pairs.extend(near.map(|&c| (colour[c].stamp.apart(stamp) as u32, d as u32, c as u32)));
        // Streams of 400 images a second give so many; stamps that are all alike would give the square of the list.
        if pairs.len() > 8 * (colour.len() + depth.len()) {
            return Err(Error::Content {
                path: path.to_owned(),
                reason: "too many stamps lie within 0.02 s of each other: they must be in seconds".to_owned(),
            });
        }
    }
    pairs.sort_unstable();
    let (mut colour_used, mut depth_used) = (vec![false; colour.len()], vec![false; depth.len()]);
    let mut entries = Vec::new();
    for (_, d, c) in pairs {
        let (d, c) = (d as usize, c as usize);
        if !colour_used[c] && !depth_used[d] {
            (colour_used[c], depth_used[d]) = (true, true);
            let (Stamped { stamp, file, line }, colour) = (depth[d].clone(), colour[c].clone());
            let (colour_stamp, colour) = (Some(colour.stamp), Some(colour.file));
            entries.push(Entry { stamp, colour_stamp, colour, depth: file, line });
        }
    }
    entries.sort_by_key(|entry| (entry.stamp, entry.line));
    Ok(entries)
}

/// Order of file names in which numbers count by value: `f2.png` before `f10.png`, as recorders without padding mean it.
pub(super) fn natural(a: &str, b: &str) -> Ordering {
    let (mut a, mut b) = (a, b);
    loop {
        let (x, y) = (leading_digits(a), leading_digits(b));
        let order = if x.is_empty() || y.is_empty() {
            let (x, y) = (a.chars().next(), b.chars().next());
            if x.is_none() && y.is_none() {
                return Ordering::Equal;
            }
            a = &a[x.map_or(0, char::len_utf8)..];
            b = &b[y.map_or(0, char::len_utf8)..];
            x.cmp(&y)
        } else {
            (a, b) = (&a[x.len()..], &b[y.len()..]);
            let (p, q) = (x.trim_start_matches('0'), y.trim_start_matches('0'));
            // More digits, larger number; names that differ in padding alone still differ.
            p.len().cmp(&q.len()).then(p.cmp(q)).then(x.len().cmp(&y.len()))
        };
        if order != Ordering::Equal {
            return order;
        }
    }
}

fn leading_digits(s: &str) -> &str {
    &s[..s.bytes().take_while(u8::is_ascii_digit).count()]
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn stamped(stamps: &[f64]) -> Vec<Stamped> {
        let make = |(i, &s): (usize, &f64)| Stamped {
            stamp: Stamp::from_seconds(s).unwrap(),
            file: format!("{s}.png"),
            line: i + 1,
        };
        stamps.iter().enumerate().map(make).collect()
    }

    fn pairs(colour: &[f64], depth: &[f64]) -> Vec<(String, String)> {
        let entries = associate(Path::new("d"), &stamped(colour), &stamped(depth)).unwrap();
        entries.into_iter().map(|e| (e.colour.unwrap(), e.depth)).collect()
    }

    #[test]
    fn associations_in_either_order() {
        let text =
            "# comment\n\n1.5 rgb/a.png 1.25 depth/a.png\r\n  2.5,depth/b.png\t2.75 rgb/b.png # x".replace(" # x", "");
        let entries = parse_associations(Path::new("a.txt"), &text).unwrap();
        assert_eq!(entries.len(), 2);
        assert_eq!((entries[0].stamp.seconds(), entries[0].depth.as_str(), entries[0].line), (1.25, "depth/a.png", 3));
        assert_eq!((entries[1].stamp.seconds(), entries[1].depth.as_str(), entries[1].line), (2.5, "depth/b.png", 4));
        assert_eq!(entries[1].colour.as_deref(), Some("rgb/b.png"));
    }

    #[test]
    fn a_wrong_line_is_named() {
        for (text, what) in
            [("1 a.png 2", "3 fields"), ("x a 1 b", "\"x\""), ("1 a nan b", "\"nan\""), ("1 a 2 b c", "5 fields")]
        {
            let error = parse_associations(Path::new("a.txt"), &format!("# first\n{text}\n")).unwrap_err().to_string();
            assert!(error.contains("a.txt, line 2") && error.contains(what), "{error}");
        }
        assert!(parse_list(Path::new("rgb.txt"), "1.0 a.png b.png").is_err());
        assert!(parse_list(Path::new("rgb.txt"), "# nothing\n").unwrap().is_empty());
    }

    #[test]
    fn the_nearest_pairs_win_and_files_serve_once() {
        let p = |a: &str, b: &str| (format!("{a}.png"), format!("{b}.png"));
        // 1.011 is nearer to 1.01 than 1 is, and 1 is then free for 0.99.
        assert_eq!(pairs(&[1.0, 1.011], &[1.01, 0.99]), [p("1", "0.99"), p("1.011", "1.01")]);
        assert_eq!(pairs(&[1.0, 1.001, 1.002], &[1.001]), [p("1.001", "1.001")]);
        assert!(pairs(&[1.0], &[1.02]).is_empty(), "0.02 s apart is too far");
        assert!(pairs(&[], &[1.0]).is_empty());
        // Out of order in the list, in order in the recording.
        assert_eq!(pairs(&[3.0, 1.0], &[3.0, 1.0]), [p("1", "1"), p("3", "3")]);
    }

    #[test]
    fn stamps_all_alike_are_refused_before_they_fill_the_memory() {
        let same = stamped(&vec![1.0; 5000]);
        assert!(associate(Path::new("d"), &same, &same).unwrap_err().to_string().contains("in seconds"));
    }

    #[test]
    fn numbers_in_names_count_by_value() {
        let mut names = ["f10.png", "f2.png", "f1.png", "f01.png", "e", "f", ""];
        names.sort_by(|a, b| natural(a, b));
        assert_eq!(names, ["", "e", "f", "f1.png", "f01.png", "f2.png", "f10.png"]);
    }

    #[test]
    fn fast_streams_pair_and_stamps_all_alike_are_refused() {
        let path = Path::new("depth.txt");
        let list = |apart: i64| -> Vec<Stamped> {
            (0..2000).map(|i| Stamped { stamp: Stamp(i * apart), file: String::new(), line: 1 }).collect()
        };
        let four_hundred_hertz = list(2_500_000);
        assert_eq!(associate(path, &four_hundred_hertz, &four_hundred_hertz).unwrap().len(), 2000);
        assert!(associate(path, &list(0), &list(0)).unwrap_err().to_string().contains("too many stamps"));
    }

    proptest! {
        #[test]
        fn no_text_panics(text in "[0-9.e# ,\t\nrgbdepth/]{0,80}|\\PC{0,40}") {
            let path = Path::new("x");
            let _ = parse_associations(path, &text);
            if let Ok(list) = parse_list(path, &text) {
                let _ = associate(path, &list, &list);
            }
        }

        #[test]
        fn the_natural_order_is_an_order(a in "[0-9a]{0,5}", b in "[0-9a]{0,5}", c in "[0-9a]{0,5}") {
            prop_assert_eq!(natural(&a, &b), natural(&b, &a).reverse());
            prop_assert_eq!(natural(&a, &b) == Ordering::Equal, a == b);
            if natural(&a, &b).is_lt() && natural(&b, &c).is_lt() {
                prop_assert!(natural(&a, &c).is_lt());
            }
        }
    }
}
