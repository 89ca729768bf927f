//! Template files, read and searched in both encodings.

mod common;

use common::pldt::Set;
use pldi_core::TemplateError;
use pldi_core::descriptor::fixed::{decode, encode};
use pldi_core::descriptor::{Descriptor, LENGTH};
use pldi_core::matching;
use pldi_core::templates::layout::seal;
use pldi_core::templates::{Encoding, Templates};
use pldi_core::view::{Framing, ViewParams};
use proptest::prelude::*;

const BOTH: [Encoding; 2] = [Encoding::Float, Encoding::Logarithmic];

/// Where the classes, the objects and the templates of [`file`] begin.
const CLASSES: usize = 48;
const OBJECTS: usize = CLASSES + 2 * 32;
const RECORDS: usize = OBJECTS + 3 * 40;

/// A file with two classes, three objects and these templates.
fn file_of(view: &ViewParams, encoding: Encoding, templates: &[(u16, u16, Descriptor)]) -> Vec<u8> {
    let objects = &[(0, "a"), (0, "b"), (1, "c")];
    Set { classes: &["chair", "armoire à glace"], objects, templates }.file(view, encoding)
}

/// Six templates whose numbers are all equal.
fn file(view: ViewParams, encoding: Encoding) -> Vec<u8> {
    let templates: Vec<_> = (0..6u16).map(|i| (i / 2, i % 2, [1.0 + f32::from(i); LENGTH])).collect();
    file_of(&view, encoding, &templates)
}

#[test]
fn a_file_reads_as_it_was_written() {
    for encoding in BOTH {
        let bytes = file(ViewParams::DEFAULT, encoding);
        // From an odd address as well: flash gives no alignment.
        let mut shifted = vec![0; bytes.len() + 1];
        shifted[1..].copy_from_slice(&bytes);
        for bytes in [&bytes[..], &shifted[1..]] {
            let set = Templates::parse(bytes).unwrap();
            assert_eq!((set.len(), set.classes().len(), set.class_name(1)), (6, 2, "armoire à glace"));
            assert_eq!(set.objects().collect::<Vec<_>>(), [(0, "a"), (0, "b"), (1, "c")]);
            let last = set.iter().last().unwrap();
            assert_eq!((last.class(), last.object(), last.view()), (1, 2, 1));
            let six = if encoding == Encoding::Float { 6.0 } else { decode(encode(6.0)) };
            assert_eq!((last.descriptor(), last.codes()), ([six; LENGTH], [encode(6.0); LENGTH]));
            assert_eq!(set.require(ViewParams::DEFAULT.hash(), encoding), Ok(()));
        }
    }
    assert_eq!(file(ViewParams::DEFAULT, Encoding::Logarithmic).len(), RECORDS + 6 * 120);
}

#[test]
fn the_nearest_of_each_class_comes_best_first() {
    let bytes = file(ViewParams::DEFAULT, Encoding::Float);
    let set = Templates::parse(&bytes).unwrap();
    let found = matching::nearest(&set, &[3.0; LENGTH]).unwrap();
    assert_eq!(found.len(), 2);
    assert_eq!(
        (found[0].class, found[0].object, found[0].view, found[0].distance, found[0].score),
        (0, 1, 0, 0.0, 1.0)
    );
    assert_eq!((found[1].class, found[1].object, found[1].view), (1, 2, 0));
    assert!((found[1].distance - 58.0 * 2.0 / 8.0).abs() < 1e-4 && found[1].score == 0.0);

    let bytes = file(ViewParams::DEFAULT, Encoding::Logarithmic);
    let set = Templates::parse(&bytes).unwrap();
    let fixed = matching::fixed::nearest(&set, &[encode(3.0); LENGTH]).unwrap();
    assert_eq!(fixed.len(), 2);
    assert_eq!(
        (fixed[0].class, fixed[0].object, fixed[0].view, fixed[0].distance, fixed[0].score),
        (0, 1, 0, 0, 1 << 16)
    );
    assert_eq!((fixed[1].class, fixed[1].object, fixed[1].view), (1, 2, 0));
    assert!((fixed[1].distance as f32 / 65_536.0 - found[1].distance).abs() < 0.02 && fixed[1].score == 0);
}

#[test]
fn of_equally_near_templates_the_first_counts() {
    let templates: Vec<_> = (0..6u16).map(|i| (i / 2, i % 2, [0.5; LENGTH])).collect();
    let [float, coded] = BOTH.map(|encoding| file_of(&ViewParams::DEFAULT, encoding, &templates));
    let found = matching::nearest(&Templates::parse(&float).unwrap(), &[0.25; LENGTH]).unwrap();
    assert!(found.iter().map(|h| (h.class, h.object, h.view, h.score)).eq([(0, 0, 0, 0.5), (1, 2, 0, 0.5)]));
    let query = [encode(0.25); LENGTH];
    let found = matching::fixed::nearest(&Templates::parse(&coded).unwrap(), &query).unwrap();
    assert!(found.iter().map(|h| (h.class, h.object, h.view, h.score)).eq([(0, 0, 0, 1 << 15), (1, 2, 0, 1 << 15)]));
}

#[test]
fn a_search_in_the_other_encoding_is_refused() {
    for encoding in BOTH {
        let bytes = file(ViewParams::DEFAULT, encoding);
        let set = Templates::parse(&bytes).unwrap();
        assert_eq!(set.encoding(), encoding);
        let needed = if encoding == Encoding::Float { Encoding::Logarithmic } else { Encoding::Float };
        let error = TemplateError::Encoding { file: encoding, needed };
        assert_eq!(set.require(ViewParams::DEFAULT.hash(), needed), Err(error));
        match encoding {
            Encoding::Float => assert_eq!(matching::fixed::nearest(&set, &[0; LENGTH]), Err(error)),
            Encoding::Logarithmic => assert_eq!(matching::nearest(&set, &[0.0; LENGTH]), Err(error)),
        }
        assert!(error.to_string().contains(if needed == Encoding::Float { "float set" } else { "convert" }));
    }
}

#[test]
fn a_cut_file_is_refused_at_every_length() {
    for encoding in BOTH {
        let bytes = file(ViewParams::DEFAULT, encoding);
        for length in 0..bytes.len() {
            assert!(matches!(Templates::parse(&bytes[..length]), Err(TemplateError::Cut { .. })), "{length}");
        }
        let mut longer = bytes.clone();
        longer.push(0);
        assert!(matches!(Templates::parse(&longer), Err(TemplateError::Field(_))));
    }
}

#[test]
fn every_flipped_byte_is_noticed() {
    for encoding in BOTH {
        let good = file(ViewParams::DEFAULT, encoding);
        for i in 0..good.len() {
            for flip in [0xFF, 0x01] {
                let mut bytes = good.clone();
                bytes[i] ^= flip;
                assert!(Templates::parse(&bytes).is_err(), "byte {i}");
            }
        }
    }
}

/// The error of a file with a change, and a checksum that fits.
fn changed(encoding: Encoding, change: impl Fn(&mut Vec<u8>)) -> Result<usize, TemplateError> {
    let mut bytes = file(ViewParams::DEFAULT, encoding);
    change(&mut bytes);
    seal(&mut bytes);
    Templates::parse(&bytes).map(|set| set.len())
}

#[test]
fn consistent_nonsense_is_refused_by_name() {
    let field = |name| Err(TemplateError::Field(name));
    for encoding in BOTH {
        let with = |change: fn(&mut Vec<u8>)| changed(encoding, change);
        assert_eq!(with(|b| b[4] = 9), Err(TemplateError::Version(9)));
        assert_eq!(with(|b| b[4] = 0), Err(TemplateError::Version(0)));
        assert_eq!(with(|b| b[6] = 2), field("encoding"));
        assert_eq!(with(|b| b[24] = 7), field("kind of descriptor"));
        assert_eq!(with(|b| b[8] ^= 1), field("parameter hash"));
        assert_eq!(with(|b| b[CLASSES] = 0xFF), field("class name"));
        assert_eq!(with(|b| b[OBJECTS] = 2), field("class of an object"));
        assert_eq!(with(|b| b[RECORDS] = 3), field("object of a template"));
    }
    assert_eq!(changed(Encoding::Float, |b| b[RECORDS + 4..][..4].fill(0xFF)), field("descriptor"));
    assert_eq!(changed(Encoding::Logarithmic, |b| b[RECORDS + 4..][..2].fill(0xFF)), Ok(6));
    assert_eq!(
        changed(Encoding::Logarithmic, |b| b[RECORDS + 4..][..2].copy_from_slice(&[0, 0x80])),
        field("descriptor")
    );
    // Version 1 knew no codes; version 2 knows floats.
    assert_eq!(changed(Encoding::Logarithmic, |b| b[4] = 1), field("encoding"));
    assert_eq!(changed(Encoding::Float, |b| b[4] = 2), Ok(6));
    assert!(matches!(changed(Encoding::Logarithmic, |b| b[6] = 0), Err(TemplateError::Cut { .. })));
}

#[test]
fn other_parameters_are_an_error_with_both_hashes() {
    let metric = ViewParams { framing: Framing::Metric { side: 2.0 }, ..ViewParams::DEFAULT };
    for encoding in BOTH {
        let bytes = file(metric, encoding);
        let set = Templates::parse(&bytes).unwrap();
        assert_eq!(set.view_params(), &metric);
        assert_eq!(
            set.require(ViewParams::DEFAULT.hash(), encoding),
            Err(TemplateError::Parameters { file: metric.hash(), pipeline: ViewParams::DEFAULT.hash() })
        );
    }
}

proptest! {
    /// The searches leave sums early; what they find is what a comparison with every template finds.
    #[test]
    fn searches_find_the_nearest(
        values in proptest::collection::vec(proptest::collection::vec(0.0f32..1.0, LENGTH), 9), like in 0usize..8,
    ) {
        let mut all: Vec<Descriptor> = values.into_iter().map(|v| v.try_into().unwrap()).collect();
        let mut query = all.pop().unwrap();
        // Near to one of them.
        for (q, v) in query.iter_mut().zip(all[like]) {
            *q = 0.3 * *q + 0.7 * v;
        }
        let templates: Vec<_> = (0..).zip(&all).map(|(i, d)| (i % 3, i, *d)).collect();
        let classes = [0u16, 0, 1];
        let bytes = file_of(&ViewParams::DEFAULT, Encoding::Float, &templates);
        let found = matching::nearest(&Templates::parse(&bytes).unwrap(), &query).unwrap();
        for h in found {
            let of_class = templates.iter().filter(|t| classes[usize::from(t.0)] == h.class);
            let best = of_class.map(|t| (matching::canberra(&query, &t.2), t.1)).min_by(|a, b| a.partial_cmp(b).unwrap());
            prop_assert_eq!(Some((h.distance, h.view)), best);
        }
        let bytes = file_of(&ViewParams::DEFAULT, Encoding::Logarithmic, &templates);
        let codes = query.map(encode);
        for h in matching::fixed::nearest(&Templates::parse(&bytes).unwrap(), &codes).unwrap() {
            let of_class = templates.iter().filter(|t| classes[usize::from(t.0)] == h.class);
            let best = of_class.map(|t| (matching::fixed::canberra(&codes, &t.2.map(encode)), t.1)).min();
            prop_assert_eq!(Some((h.distance, h.view)), best);
        }
    }
}
