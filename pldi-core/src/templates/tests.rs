use super::layout::{Class, Header, Object, Record, padded};
use super::*;
use crate::descriptor::LENGTH;
use crate::matching;
use crate::view::Framing;
use zerocopy::IntoBytes;

/// A file with two classes, three objects and six templates whose numbers are all equal.
pub(crate) fn file(view: ViewParams) -> Vec<u8> {
    let (framing, side) = view.framing_fields();
    let header = Header {
        magic: MAGIC,
        version: VERSION.into(),
        reserved: 0.into(),
        parameters: view.hash().into(),
        checksum: 0.into(),
        classes: 2.into(),
        objects: 3.into(),
        templates: 6.into(),
        descriptor: view.descriptor as u8,
        framing,
        reserved2: 0.into(),
        side: side.into(),
        radius: view.radius.into(),
        distance: 2.0.into(),
        height: 1.2.into(),
        simulated: 1,
        reserved3: [0; 3],
    };
    let mut bytes = header.as_bytes().to_vec();
    for name in ["chair", "armoire à glace"] {
        bytes.extend(Class { name: padded(name) }.as_bytes());
    }
    for (class, name) in [(0, "a"), (0, "b"), (1, "c")] {
        bytes.extend(Object { class: class.into(), name: padded(name) }.as_bytes());
    }
    for i in 0..6u16 {
        let value = 1.0 + f32::from(i);
        bytes
            .extend(Record { object: (i / 2).into(), view: (i % 2).into(), values: [value.into(); LENGTH] }.as_bytes());
    }
    let sum = layout::checksum(&bytes);
    bytes[12..16].copy_from_slice(&sum.to_le_bytes());
    bytes
}

#[test]
fn a_file_reads_as_it_was_written() {
    let bytes = file(ViewParams::DEFAULT);
    // From an odd address as well: flash gives no alignment.
    let mut shifted = vec![0; bytes.len() + 1];
    shifted[1..].copy_from_slice(&bytes);
    for bytes in [&bytes[..], &shifted[1..]] {
        let set = Templates::parse(bytes).unwrap();
        assert_eq!((set.len(), set.classes().len(), set.class_name(1)), (6, 2, "armoire à glace"));
        assert_eq!(set.objects().collect::<Vec<_>>(), [(0, "a"), (0, "b"), (1, "c")]);
        let last = set.iter().last().unwrap();
        assert_eq!((last.class(), last.object(), last.view(), last.descriptor()), (1, 2, 1, [6.0; LENGTH]));
        assert_eq!(set.require(&ViewParams::DEFAULT), Ok(()));
    }
}

#[test]
fn the_nearest_of_each_class_comes_best_first() {
    let bytes = file(ViewParams::DEFAULT);
    let set = Templates::parse(&bytes).unwrap();
    let found = matching::nearest(&set, &[3.0; LENGTH]);
    assert_eq!(found.len(), 2);
    assert_eq!(
        (found[0].class, found[0].object, found[0].view, found[0].distance, found[0].score),
        (0, 1, 0, 0.0, 1.0)
    );
    assert_eq!((found[1].class, found[1].object, found[1].view), (1, 2, 0));
    assert!((found[1].distance - 58.0 * 2.0 / 8.0).abs() < 1e-4 && found[1].score == 0.0);
}

#[test]
fn a_cut_file_is_refused_at_every_length() {
    let bytes = file(ViewParams::DEFAULT);
    for length in 0..bytes.len() {
        assert!(matches!(Templates::parse(&bytes[..length]), Err(TemplateError::Cut { .. })), "{length}");
    }
    let mut longer = bytes.clone();
    longer.push(0);
    assert!(matches!(Templates::parse(&longer), Err(TemplateError::Field(_))));
}

#[test]
fn every_flipped_byte_is_noticed() {
    let good = file(ViewParams::DEFAULT);
    for i in 0..good.len() {
        for flip in [0xFF, 0x01] {
            let mut bytes = good.clone();
            bytes[i] ^= flip;
            assert!(Templates::parse(&bytes).is_err(), "byte {i}");
        }
    }
}

#[test]
fn consistent_nonsense_is_refused_by_name() {
    let with = |change: fn(&mut Vec<u8>)| {
        let mut bytes = file(ViewParams::DEFAULT);
        change(&mut bytes);
        let sum = layout::checksum(&bytes);
        bytes[12..16].copy_from_slice(&sum.to_le_bytes());
        Templates::parse(&bytes).unwrap_err()
    };
    assert_eq!(with(|b| b[4] = 9), TemplateError::Version(9));
    assert_eq!(with(|b| b[24] = 7), TemplateError::Field("kind of descriptor"));
    assert_eq!(with(|b| b[8] ^= 1), TemplateError::Field("parameter hash"));
    assert_eq!(with(|b| b[48] = 0xFF), TemplateError::Field("class name"));
    assert_eq!(with(|b| b[48 + 2 * 32] = 2), TemplateError::Field("class of an object"));
    assert_eq!(with(|b| b[48 + 2 * 32 + 3 * 40] = 3), TemplateError::Field("object of a template"));
    assert_eq!(with(|b| b[48 + 2 * 32 + 3 * 40 + 4..][..4].fill(0xFF)), TemplateError::Field("descriptor"));
}

#[test]
fn other_parameters_are_an_error_with_both_hashes() {
    let metric = ViewParams { framing: Framing::Metric { side: 2.0 }, ..ViewParams::DEFAULT };
    let bytes = file(metric);
    let set = Templates::parse(&bytes).unwrap();
    assert_eq!(set.view_params(), &metric);
    assert_eq!(
        set.require(&ViewParams::DEFAULT),
        Err(TemplateError::Parameters { file: metric.hash(), pipeline: ViewParams::DEFAULT.hash() })
    );
}
