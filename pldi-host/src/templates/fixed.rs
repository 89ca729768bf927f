//! Template files for the fixed-point pipeline.

use std::borrow::Cow;

use pldi_core::TemplateError;
use pldi_core::templates::layout::{self, Header, LogRecord};
use pldi_core::templates::{Encoding, Templates};
use zerocopy::{FromBytes, IntoBytes};

use crate::{ArithmeticKind, Error};

/// A file of codes from a file of floats: half the size, everything else as it was. The same on every machine.
///
/// # Errors
/// `Core` with what is wrong with the file: `Encoding` where it holds codes already.
pub fn fixed_file(bytes: &[u8]) -> Result<Vec<u8>, Error> {
    convert(bytes).map_err(|cause| Error::core(cause.into()))
}

/// A file as an arithmetic searches it: floats become codes for integers; everything else stays as it is, so that the
/// search can refuse codes in floats by their name.
///
/// # Errors
/// `Core` with what is wrong with a file that is to be converted.
pub fn for_arithmetic(bytes: Cow<'_, [u8]>, kind: ArithmeticKind) -> Result<Cow<'_, [u8]>, Error> {
    let encoding = Templates::parse(&bytes).map_err(|cause| Error::core(cause.into()))?.encoding();
    Ok(if kind == ArithmeticKind::Fixed && encoding == Encoding::Float { fixed_file(&bytes)?.into() } else { bytes })
}

fn convert(bytes: &[u8]) -> Result<Vec<u8>, TemplateError> {
    let set = Templates::parse(bytes)?;
    set.require_encoding(Encoding::Float)?;
    let (mut header, _) = Header::read_from_prefix(bytes).map_err(|_| TemplateError::NotTemplates)?;
    header.version = Encoding::Logarithmic.version().into();
    header.encoding = Encoding::Logarithmic as u8;
    let mut out = header.as_bytes().to_vec();
    let records = bytes.len() - set.len() * Encoding::Float.record_size();
    out.extend_from_slice(&bytes[out.len()..records]);
    for template in set.iter() {
        let (object, view) = (template.object().into(), template.view().into());
        out.extend_from_slice(LogRecord { object, view, values: template.codes().map(Into::into) }.as_bytes());
    }
    layout::seal(&mut out);
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parallel;
    use crate::templates::EMBEDDED;
    use pldi_core::matching::{self, fixed};

    #[test]
    fn everything_but_the_numbers_stays() {
        let coded = fixed_file(EMBEDDED).unwrap();
        let [a, b] = [EMBEDDED, &coded].map(|bytes| Templates::parse(bytes).unwrap());
        assert_eq!((a.encoding(), b.encoding()), (Encoding::Float, Encoding::Logarithmic));
        assert_eq!((a.len(), a.view_params()), (b.len(), b.view_params()));
        assert!(a.classes().eq(b.classes()) && a.objects().eq(b.objects()));
        for (a, b) in a.iter().zip(b.iter()) {
            assert_eq!((a.class(), a.object(), a.view()), (b.class(), b.object(), b.view()));
            for (x, y) in a.descriptor().iter().zip(b.descriptor()) {
                assert!((x - y).abs() <= 3.6e-4 * x.abs() + 1.5e-8, "{x} {y}");
            }
        }
        let codes = TemplateError::Encoding { file: Encoding::Logarithmic, needed: Encoding::Float };
        assert_eq!(convert(&coded), Err(codes));
        assert!(matches!(
            fixed_file(&coded[..99]),
            Err(Error::Core(pldi_core::Error::Templates(TemplateError::Cut { .. })))
        ));
    }

    /// What the codes change: hardly an answer of the embedded set, asked with its own views (each without the object's).
    #[test]
    fn codes_answer_as_floats_do() {
        let set = Templates::parse(EMBEDDED).unwrap();
        let all: Vec<_> = set.iter().map(|t| (t.class(), t.object(), t.descriptor(), t.codes())).collect();
        let queries: Vec<usize> = (0..all.len()).step_by(7).collect();
        let Ok(same) = parallel::map_ordered(
            queries.len(),
            2,
            || (),
            |(), q| {
                let query = &all[queries[q]];
                let others = || all.iter().filter(|t| t.1 != query.1);
                let float =
                    others().map(|t| (matching::canberra(&query.2, &t.2), t.0)).min_by(|a, b| a.0.total_cmp(&b.0));
                let codes = others().map(|t| (fixed::canberra(&query.3, &t.3), t.0)).min_by_key(|t| t.0);
                let (Some(float), Some(codes)) = (float, codes) else { return Ok(false) };
                assert!((float.0 - codes.0 as f32 / 65_536.0).abs() < 0.01, "{float:?} {codes:?}");
                Ok::<_, std::convert::Infallible>(float.1 == codes.1)
            },
        );
        let share = same.iter().filter(|same| **same).count() as f64 / same.len() as f64;
        assert!(share > 0.995, "{share}");
    }
}
