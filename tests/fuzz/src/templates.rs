//! Template files.

use std::borrow::Cow;

use pldi_core::descriptor::DescriptorKind;
use pldi_core::matching;
use pldi_core::templates::layout::{self, Header};
use pldi_core::templates::{Encoding, MAX_CLASSES, Templates};
use pldi_core::view::{Framing, ViewParams};
use pldi_host::ArithmeticKind;
use pldi_host::templates::for_arithmetic;
use zerocopy::{FromBytes, IntoBytes};

/// A file as it comes; and once more with its check sums made right, behind which nothing else would get.
pub fn templates(bytes: &[u8]) {
    walk(bytes);
    let mut sealed = bytes.to_vec();
    if let Ok((header, _)) = Header::mut_from_prefix(&mut sealed) {
        header.magic = pldi_core::templates::MAGIC;
        if let Some(descriptor) = DescriptorKind::from_number(header.descriptor) {
            let framing = if header.framing == 0 { Framing::Fit } else { Framing::Metric { side: header.side.get() } };
            header.parameters = ViewParams { descriptor, framing, radius: header.radius.get() }.hash().into();
        }
        layout::seal(&mut sealed);
        walk(&sealed);
    }
}

fn walk(bytes: &[u8]) {
    let Ok(set) = Templates::parse(bytes) else { return };
    assert_eq!(set.view_params().validate(), Ok(()));
    assert!(set.classes().len() <= MAX_CLASSES && set.classes().all(|name| !name.is_empty()));
    for (class, _) in set.objects() {
        assert!(!set.class_name(class).is_empty());
    }
    assert_eq!(set.iter().count(), set.len());
    for template in set.iter() {
        assert!(usize::from(template.class()) < set.classes().len());
        assert!(usize::from(template.object()) < set.objects().len());
        assert!(template.descriptor().iter().all(|v| v.is_finite()));
        let _ = set.object_name(template.object());
    }
    // Each template of the first and last few is searched for among all, with the numbers of either arithmetic.
    for template in set.iter().take(3).chain(set.iter().skip(set.len().saturating_sub(2))) {
        let (floats, codes) = (template.descriptor(), template.codes());
        match set.encoding() {
            Encoding::Float => {
                let best = matching::nearest(&set, &floats).unwrap();
                assert_eq!(best.first().map(|h| h.distance), Some(0.0), "{floats:?}");
                assert!(best.is_sorted_by(|a, b| a.distance <= b.distance));
                assert!(best.iter().all(|h| (0.0..=1.0).contains(&h.score)), "{best:?}");
            }
            Encoding::Logarithmic => {
                let best = matching::fixed::nearest(&set, &codes).unwrap();
                assert_eq!(best.first().map(|h| h.distance), Some(0), "{codes:?}");
                assert!(best.is_sorted_by(|a, b| a.distance <= b.distance));
                assert!(best.iter().all(|h| h.score <= 1 << 16), "{best:?}");
            }
        }
    }
    if set.encoding() == Encoding::Float {
        let coded = for_arithmetic(Cow::Borrowed(bytes), ArithmeticKind::Fixed).unwrap();
        let coded = Templates::parse(&coded).unwrap();
        assert_eq!((coded.len(), coded.encoding()), (set.len(), Encoding::Logarithmic));
    }
    assert_eq!(Header::read_from_prefix(bytes).unwrap().0.as_bytes(), &bytes[..size_of::<Header>()]);
}
