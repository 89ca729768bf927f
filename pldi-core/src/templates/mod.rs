//! Template sets: the descriptors of known objects, read in place from a byte slice (a file, or flash).
//!
//! All numbers are little-endian and no alignment is asked for. The file is a [`layout::Header`], the class names,
//! the objects and the templates, one after the other; its CRC-32 covers everything but the checksum's own field. The
//! descriptors are floats, or codes for the fixed-point pipeline: [`Encoding`].

pub mod layout;

pub use crate::crc::crc32;
pub use layout::{Encoding, MAGIC, VERSION};

use crate::TemplateError;
use crate::descriptor::{self, Descriptor, DescriptorKind, LENGTH};
use crate::view::{Framing, ViewParams};
use layout::{Class, Header, LogRecord, Object, Record};
use zerocopy::FromBytes;
use zerocopy::little_endian::{F32, U16};

/// Classes that a template set can have at most.
pub const MAX_CLASSES: usize = 64;

/// A template set, borrowed from the bytes that hold it.
#[derive(Debug, Clone, Copy)]
pub struct Templates<'a> {
    header: &'a Header,
    classes: &'a [Class],
    objects: &'a [Object],
    records: Records<'a>,
    view: ViewParams,
    checksum: u32,
}

/// The templates in either encoding.
#[derive(Debug, Clone, Copy)]
enum Records<'a> {
    Float(&'a [Record]),
    Logarithmic(&'a [LogRecord]),
}

impl<'a> Records<'a> {
    fn len(&self) -> usize {
        match self {
            Self::Float(records) => records.len(),
            Self::Logarithmic(records) => records.len(),
        }
    }

    /// Object, view and numbers of a template.
    #[inline(always)]
    fn get(&self, i: usize) -> Option<(U16, U16, Values<'a>)> {
        match self {
            Self::Float(records) => records.get(i).map(|r| (r.object, r.view, Values::Float(&r.values))),
            Self::Logarithmic(records) => records.get(i).map(|r| (r.object, r.view, Values::Logarithmic(&r.values))),
        }
    }
}

impl<'a> Templates<'a> {
    /// Reads a template file in place. Every count, index and name is checked here, once.
    ///
    /// # Errors
    /// What is wrong with the file, see [`TemplateError`].
    pub fn parse(bytes: &'a [u8]) -> Result<Self, TemplateError> {
        let cut = |expected| TemplateError::Cut { expected, found: bytes.len() };
        let (header, body) = Header::ref_from_prefix(bytes).map_err(|_| cut(size_of::<Header>()))?;
        if header.magic != MAGIC {
            return Err(TemplateError::NotTemplates);
        }
        let version = header.version.get();
        if !(1..=VERSION).contains(&version) {
            return Err(TemplateError::Version(version));
        }
        let encoding = Encoding::from_number(header.encoding)
            .filter(|encoding| encoding.version() <= version)
            .ok_or(TemplateError::Field("encoding"))?;
        let (classes, objects, records) =
            (usize::from(header.classes), usize::from(header.objects), header.templates.get() as usize);
        let expected = layout::file_size(encoding, classes, objects, records)
            .ok_or(TemplateError::Field("number of templates"))?;
        if bytes.len() < expected {
            return Err(cut(expected));
        }
        if bytes.len() > expected {
            return Err(TemplateError::Field("length (bytes follow behind the last template)"));
        }
        let (stored, computed) = (header.checksum.get(), layout::checksum(bytes));
        if stored != computed {
            return Err(TemplateError::Checksum { stored, computed });
        }
        let (classes, rest) = <[Class]>::ref_from_prefix_with_elems(body, classes).map_err(|_| cut(expected))?;
        let (objects, rest) = <[Object]>::ref_from_prefix_with_elems(rest, objects).map_err(|_| cut(expected))?;
        let records = match encoding {
            Encoding::Float => {
                Records::Float(<[Record]>::ref_from_bytes_with_elems(rest, records).map_err(|_| cut(expected))?)
            }
            Encoding::Logarithmic => Records::Logarithmic(
                <[LogRecord]>::ref_from_bytes_with_elems(rest, records).map_err(|_| cut(expected))?,
            ),
        };
        let view = view_params(header)?;
        let set = Self { header, classes, objects, records, view, checksum: stored };
        set.check()?;
        Ok(set)
    }

    fn check(&self) -> Result<(), TemplateError> {
        if self.classes.len() > MAX_CLASSES {
            return Err(TemplateError::Field("number of classes"));
        }
        if self.classes.iter().any(|c| layout::text(&c.name).is_none_or(str::is_empty)) {
            return Err(TemplateError::Field("class name"));
        }
        for object in self.objects {
            if usize::from(object.class) >= self.classes.len() {
                return Err(TemplateError::Field("class of an object"));
            }
            if layout::text(&object.name).is_none() {
                return Err(TemplateError::Field("object name"));
            }
        }
        for template in self.iter() {
            if usize::from(template.object) >= self.objects.len() {
                return Err(TemplateError::Field("object of a template"));
            }
            let legal = match template.values {
                Values::Float(values) => values.iter().all(|v| crate::error::is_finite(v.get())),
                // No code: 0 has no sign.
                Values::Logarithmic(values) => values.iter().all(|v| v.get() != descriptor::fixed::SIGN),
            };
            if !legal {
                return Err(TemplateError::Field("descriptor"));
            }
        }
        if self.header.parameters.get() != self.view.hash() {
            return Err(TemplateError::Field("parameter hash"));
        }
        Ok(())
    }

    /// Checks that the templates were made with a pipeline's view parameters (by their hash), otherwise distances mean nothing, and that
    /// they are written as its search reads them.
    ///
    /// # Errors
    /// `Parameters` with both hashes; `Encoding` with both encodings.
    pub fn require(&self, pipeline: u32, encoding: Encoding) -> Result<(), TemplateError> {
        let file = self.view.hash();
        if file != pipeline {
            return Err(TemplateError::Parameters { file, pipeline });
        }
        self.require_encoding(encoding)
    }

    /// Checks that the descriptors are floats or codes, as a search needs them.
    ///
    /// # Errors
    /// `Encoding` with both encodings.
    pub fn require_encoding(&self, needed: Encoding) -> Result<(), TemplateError> {
        let file = self.encoding();
        if file == needed { Ok(()) } else { Err(TemplateError::Encoding { file, needed }) }
    }

    /// How the descriptors are written.
    pub fn encoding(&self) -> Encoding {
        match self.records {
            Records::Float(_) => Encoding::Float,
            Records::Logarithmic(_) => Encoding::Logarithmic,
        }
    }

    /// The parameters that the descriptors were made with.
    pub fn view_params(&self) -> &ViewParams {
        &self.view
    }

    /// Which descriptor the templates hold.
    pub fn kind(&self) -> DescriptorKind {
        self.view.descriptor
    }

    /// CRC-32 of the file: identifies the set.
    pub fn checksum(&self) -> u32 {
        self.checksum
    }

    /// Number of templates.
    pub fn len(&self) -> usize {
        self.records.len()
    }

    /// Whether there is no template at all.
    pub fn is_empty(&self) -> bool {
        self.records.len() == 0
    }

    /// The names of the classes, in the order of their indices.
    pub fn classes(&self) -> impl ExactSizeIterator<Item = &'a str> + use<'a> {
        self.classes.iter().map(|c| layout::text(&c.name).unwrap_or(""))
    }

    /// The name of a class; empty for an index that is out of range.
    pub fn class_name(&self, class: u16) -> &'a str {
        self.classes.get(usize::from(class)).and_then(|c| layout::text(&c.name)).unwrap_or("")
    }

    /// Class index and name of each object, in the order of their indices.
    pub fn objects(&self) -> impl ExactSizeIterator<Item = (u16, &'a str)> + use<'a> {
        self.objects.iter().map(|o| (o.class.get(), layout::text(&o.name).unwrap_or("")))
    }

    /// The name of an object; empty for an index that is out of range.
    pub fn object_name(&self, object: u16) -> &'a str {
        self.objects.get(usize::from(object)).and_then(|o| layout::text(&o.name)).unwrap_or("")
    }

    /// The templates in file order.
    #[inline(always)]
    pub fn iter(&self) -> impl Iterator<Item = Template<'a>> + use<'a> {
        let set = *self;
        (0..set.len()).filter_map(move |i| set.get(i))
    }

    /// A template by its place in the file.
    #[inline(always)]
    pub(crate) fn get(&self, index: usize) -> Option<Template<'a>> {
        let (object, view, values) = self.records.get(index)?;
        let class = self.objects.get(usize::from(object)).map_or(u16::MAX, |o| o.class.get());
        Some(Template { class, object: object.get(), view: view.get(), values })
    }
}

/// The view parameters that a header records.
fn view_params(header: &Header) -> Result<ViewParams, TemplateError> {
    let framing = match (header.framing, header.side.get()) {
        (0, _) => Framing::Fit,
        (1, side) => Framing::Metric { side },
        _ => return Err(TemplateError::Field("framing")),
    };
    let descriptor =
        DescriptorKind::from_number(header.descriptor).ok_or(TemplateError::Field("kind of descriptor"))?;
    let view = ViewParams { descriptor, framing, radius: header.radius.get() };
    view.validate().map_err(|_| TemplateError::Field("view parameters"))?;
    Ok(view)
}

/// One template: a view of an object.
#[derive(Debug, Clone, Copy)]
pub struct Template<'a> {
    class: u16,
    object: u16,
    view: u16,
    pub(crate) values: Values<'a>,
}

/// A descriptor as it stands in a file.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Values<'a> {
    Float(&'a [F32; LENGTH]),
    Logarithmic(&'a [U16; LENGTH]),
}

impl Template<'_> {
    /// Index of its class.
    pub fn class(&self) -> u16 {
        self.class
    }

    /// Index of its object.
    pub fn object(&self) -> u16 {
        self.object
    }

    /// Number of the view, as the set's maker counted them.
    pub fn view(&self) -> u16 {
        self.view
    }

    /// The 58 numbers; codes are decoded.
    pub fn descriptor(&self) -> Descriptor {
        match self.values {
            Values::Float(values) => values.map(F32::get),
            Values::Logarithmic(values) => values.map(|v| descriptor::fixed::decode(v.get())),
        }
    }

    /// The 58 codes; floats are encoded.
    pub fn codes(&self) -> descriptor::fixed::Descriptor {
        match self.values {
            Values::Float(values) => values.map(|v| descriptor::fixed::encode(v.get())),
            Values::Logarithmic(values) => values.map(U16::get),
        }
    }
}
