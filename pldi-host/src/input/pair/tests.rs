//! Pairs of streams that stop, jump and crowd, and the folder's rule as the measure.

use std::path::Path;

use proptest::prelude::*;

use super::*;
use crate::input::lists::{Stamped, associate};

/// One step of the stamps in nanoseconds: about 2 ms.
const STEP: i64 = 2_000_000;

#[derive(Debug, Clone, Copy, PartialEq)]
enum Push {
    Colour(i64),
    Depth(i64),
}
use Push::{Colour, Depth};

/// Steps of depth and colour image of each frame, as they come out.
fn feed(pairer: &mut Pairer<i64, i64>, pushes: &[Push]) -> Vec<(i64, Option<i64>)> {
    let mut out = Vec::new();
    for &push in pushes {
        match push {
            Colour(t) => pairer.push_colour(Stamp(t * STEP), t),
            Depth(t) => pairer.push_depth(Stamp(t * STEP), t),
        }
        drain(pairer, &mut out);
    }
    out
}

fn drain(pairer: &mut Pairer<i64, i64>, out: &mut Vec<(i64, Option<i64>)>) {
    while let Some((stamp, depth, colour)) = pairer.pop() {
        assert_eq!(stamp.0, depth * STEP);
        out.push((depth, colour.map(|(_, c)| c)));
    }
}

fn all(pairer: &mut Pairer<i64, i64>, pushes: &[Push]) -> Vec<(i64, Option<i64>)> {
    let mut out = feed(pairer, pushes);
    pairer.end();
    drain(pairer, &mut out);
    out
}

#[test]
fn equal_stamps_are_a_pair_at_once() {
    let mut pairer = Pairer::new(8);
    assert_eq!(feed(&mut pairer, &[Colour(0), Depth(0), Depth(17), Colour(17)]), [(0, Some(0)), (17, Some(17))]);
    assert_eq!(pairer.take_left_out(), LeftOut::default());
}

#[test]
fn a_promised_spacing_saves_the_wait_for_the_next_image() {
    let pushes = [Depth(0), Colour(2), Colour(19), Depth(17)];
    assert_eq!(feed(&mut Pairer::new(8), &pushes), [(0, Some(2))]);
    assert_eq!(feed(&mut Pairer::new(8).spaced(8 * STEP), &pushes), [(0, Some(2)), (17, Some(19))]);
}

#[test]
fn the_nearer_image_wins_though_it_comes_later() {
    // 9 could go with 0; but 10 is nearer to it.
    assert_eq!(all(&mut Pairer::new(8), &[Depth(0), Colour(9), Depth(10)]), [(10, Some(9))]);
    assert_eq!(all(&mut Pairer::new(8), &[Colour(0), Depth(9), Colour(10)]), [(9, Some(10))]);
}

#[test]
fn depth_without_colour_of_its_time_is_left_out() {
    let mut pairer = Pairer::new(8);
    assert_eq!(feed(&mut pairer, &[Colour(0), Depth(12), Colour(40), Depth(40)]), [(40, Some(40))]);
    assert_eq!(pairer.take_left_out(), LeftOut { depth: 1, crowded: 0 });
    assert_eq!(pairer.take_left_out(), LeftOut::default(), "told once");
}

#[test]
fn a_stream_that_stops_fills_no_memory_and_may_go_on() {
    let mut pairer = Pairer::new(4);
    let mut pushes: Vec<Push> = (0..100).map(|i| Depth(17 * i)).collect();
    assert_eq!(feed(&mut pairer, &pushes), []);
    assert_eq!(pairer.depth.len(), 4);
    assert_eq!(pairer.take_left_out(), LeftOut { depth: 96, crowded: 96 });
    // The last four are still there.
    assert_eq!(feed(&mut pairer, &[Colour(99 * 17), Colour(100 * 17), Depth(100 * 17)]).len(), 2);
    assert_eq!(pairer.take_left_out(), LeftOut { depth: 3, crowded: 0 });
    pushes = (101..200).map(|i| Colour(17 * i)).collect();
    assert_eq!(feed(&mut pairer, &pushes), []);
    assert_eq!(pairer.colour.len(), 4);
    assert_eq!(pairer.take_left_out(), LeftOut { depth: 0, crowded: 95 });
}

#[test]
fn what_must_go_goes_in_a_pair_if_it_can() {
    let mut pairer = Pairer::new(2);
    // Something nearer than 5 might have come for 0, but there is no room to wait for it.
    assert_eq!(feed(&mut pairer, &[Colour(-5), Depth(0), Depth(17)]), []);
    assert_eq!(feed(&mut pairer, &[Depth(34)]), [(0, Some(-5))]);
    assert_eq!(pairer.take_left_out(), LeftOut::default());
}

#[test]
fn without_a_colour_stream_depth_goes_through() {
    let mut pairer = Pairer::depth_only();
    assert_eq!(feed(&mut pairer, &[Depth(3), Colour(3), Depth(1)]), [(3, None), (1, None)]);
}

#[test]
fn a_clock_that_is_set_back_starts_anew() {
    let mut pairer = Pairer::new(8);
    let pushes = [Depth(10_000), Colour(10_001), Depth(0), Colour(10_018), Colour(17), Depth(17)];
    // One colour image is still of the old clock.
    assert_eq!(all(&mut pairer, &pushes), [(10_000, Some(10_001)), (17, Some(17))]);
    assert_eq!(pairer.take_left_out(), LeftOut { depth: 1, crowded: 0 });
    let mut pairer = Pairer::new(8);
    assert_eq!(all(&mut pairer, &[Depth(100), Colour(100), Depth(90), Colour(90)]), [(100, Some(100))]);
    assert_eq!(pairer.take_left_out(), LeftOut { depth: 1, crowded: 0 }, "a late image is left out");
}

fn listed(stamps: &[i64]) -> Vec<Stamped> {
    let stamped = |(i, t): (usize, &i64)| Stamped { stamp: Stamp(t * STEP), file: t.to_string(), line: i };
    stamps.iter().enumerate().map(stamped).collect()
}

fn ascending(steps: &[i64]) -> Vec<i64> {
    steps.iter().scan(0, |t, step| (*t += step, Some(*t)).1).collect()
}

proptest! {
    /// The streams come in any order between each other; the bound leaves room for all.
    #[test]
    fn the_pairs_are_those_of_a_folder(
        colour in proptest::collection::vec(0i64..25, 0..40),
        depth in proptest::collection::vec(0i64..25, 0..40),
        turns in proptest::collection::vec(any::<bool>(), 80),
    ) {
        let (colour, depth) = (ascending(&colour), ascending(&depth));
        let entries = associate(Path::new("d"), &listed(&colour), &listed(&depth)).unwrap();
        let expected: Vec<(i64, Option<i64>)> =
            entries.iter().map(|e| (e.depth.parse().unwrap(), e.colour.as_ref().map(|c| c.parse().unwrap()))).collect();
        let (mut c, mut d) = (colour.iter().copied().map(Colour), depth.iter().copied().map(Depth));
        let mut pushes: Vec<Push> = Vec::new();
        for turn in turns {
            pushes.extend(if turn { c.next() } else { d.next() });
        }
        pushes.extend(c.chain(d));
        let mut pairer = Pairer::new(80);
        prop_assert_eq!(all(&mut pairer, &pushes), expected.clone());
        prop_assert_eq!(pairer.take_left_out().depth as usize, depth.len() - expected.len());
    }

    #[test]
    fn any_stamps_give_frames_in_bounds(
        pushes in proptest::collection::vec((any::<bool>(), prop_oneof![any::<i64>(), 0i64..100_000_000]), 0..60),
        spacing in any::<i64>(),
    ) {
        let mut pairer = Pairer::new(3).spaced(spacing);
        let (mut depths, mut frames) = (0, 0);
        for (colour, stamp) in pushes {
            if colour {
                pairer.push_colour(Stamp(stamp), stamp);
            } else {
                pairer.push_depth(Stamp(stamp), stamp);
                depths += 1;
            }
            prop_assert!(pairer.colour.len() <= 3 && pairer.depth.len() <= 3);
            while let Some((d, image, colour)) = pairer.pop() {
                let (c, _) = colour.unwrap();
                prop_assert!(d.0 == image && d.apart(c) < MAX_APART);
                frames += 1;
            }
        }
        pairer.end();
        frames += std::iter::from_fn(|| pairer.pop()).count();
        prop_assert_eq!(frames + pairer.take_left_out().depth as usize, depths);
    }
}
