//! `pldi demo`: the first command anybody runs.

mod common;

use common::{lines, pldi};

/// First column of a row's outcome, behind the columns of fixed width.
const OUTCOME: usize = 54;

#[test]
fn the_demo_makes_a_recording_and_recognises_most_of_it() {
    let folder = tempfile::tempdir().unwrap();
    let (out, picture) = (folder.path().join("demo"), folder.path().join("picture.png"));
    let run = || pldi(arguments!["demo", "--out", out, "--picture", picture, "--threads", "2"]).ok();
    let stdout = String::from_utf8(run().stdout).unwrap();
    let rows: Vec<&str> = stdout.lines().skip(1).take_while(|line| !line.is_empty()).collect();
    assert!(rows.len() >= 40, "{stdout}");
    let outcomes: Vec<&str> = rows.iter().map(|row| row[OUTCOME..].trim()).collect();
    let count = |name: &str| outcomes.iter().filter(|o| o.starts_with(name)).count();
    let (right, whole) = (count("right"), count("right") + count("wrong") + count("missed"));
    assert!(whole >= 24 && 10 * right >= 8 * whole, "{right} of {whole}\n{stdout}");
    assert!(
        stdout.contains(&format!("{right} of {whole} whole, unoccluded objects in 12 frames are right")),
        "{stdout}"
    );
    for frame in 0..12 {
        assert!(rows.iter().any(|row| row.trim_start().starts_with(&format!("{frame} "))), "frame {frame}\n{stdout}");
        let image = image::open(out.join(format!("overlay/{frame:04}.png"))).unwrap();
        assert!(image.width() > 640 && image.height() == 480);
        for part in ["rgb", "depth", "masks"] {
            assert!(out.join("recording").join(part).join(format!("{frame:04}.png")).is_file());
        }
    }
    let results = std::fs::read(out.join("detections.jsonl")).unwrap();
    assert_eq!(lines(&results).len(), 12);
    assert!(std::fs::metadata(&picture).unwrap().len() <= 400_000);
    // The results are those of `pldi run` on the folder.
    assert_eq!(pldi(arguments!["run", out.join("recording")]).ok().stdout, results);

    // A second time nothing is written that is there already; a damaged file is made anew.
    let age = |name: &str| std::fs::metadata(out.join(name)).unwrap().modified().unwrap();
    let before = age("recording/rgb/0003.png");
    let damaged = out.join("recording/depth/0007.png");
    let whole = std::fs::read(&damaged).unwrap();
    std::fs::write(&damaged, &whole[..whole.len() / 2]).unwrap();
    assert_eq!(String::from_utf8(run().stdout).unwrap(), stdout);
    assert_eq!((age("recording/rgb/0003.png"), std::fs::read(&damaged).unwrap()), (before, whole));
}

#[test]
fn a_folder_that_cannot_be_made_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("file");
    std::fs::write(&file, "x").unwrap();
    let outcome = pldi(arguments!["demo", "--out", file.join("demo")]);
    assert_eq!(outcome.code, Some(1));
    assert!(outcome.stderr.contains("file") && outcome.stdout.is_empty(), "{}", outcome.stderr);
}
