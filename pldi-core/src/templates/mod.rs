//! Template sets: the descriptors of known objects, read in place from a byte slice (a file, or flash).
//!
//! All numbers are little-endian and no alignment is asked for. The file is a [`layout::Header`], the class names,
//! the objects and the templates, one after the other; its CRC-32 covers everything but the checksum's own field.

pub mod layout;

pub use crate::crc::crc32;
pub use layout::{MAGIC, VERSION};

use crate::TemplateError;
use crate::canberra::canberra_with;
use crate::descriptor::{Descriptor, DescriptorKind};
use crate::view::{Framing, ViewParams};
use layout::{Class, Header, Object, Record};
use zerocopy::FromBytes;

/// Classes that a template set can have at most.
pub const MAX_CLASSES: usize = 64;

/// A template set, borrowed from the bytes that hold it.
#[derive(Debug, Clone, Copy)]
pub struct Templates<'a> {
    header: &'a Header,
    classes: &'a [Class],
    objects: &'a [Object],
    records: &'a [Record],
    view: ViewParams,
    checksum: u32,
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
        if header.version.get() != VERSION {
            return Err(TemplateError::Version(header.version.get()));
        }
        let (classes, objects, records) =
            (usize::from(header.classes), usize::from(header.objects), header.templates.get() as usize);
        let expected =
            layout::file_size(classes, objects, records).ok_or(TemplateError::Field("number of templates"))?;
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
        let records = <[Record]>::ref_from_bytes_with_elems(rest, records).map_err(|_| cut(expected))?;
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
        for record in self.records {
            if usize::from(record.object) >= self.objects.len() {
                return Err(TemplateError::Field("object of a template"));
            }
            if record.values.iter().any(|v| !v.get().is_finite()) {
                return Err(TemplateError::Field("descriptor"));
            }
        }
        if self.header.parameters.get() != self.view.hash() {
            return Err(TemplateError::Field("parameter hash"));
        }
        Ok(())
    }

    /// Checks that the templates were made with a pipeline's view parameters: otherwise distances mean nothing.
    ///
    /// # Errors
    /// `Parameters` with both hashes.
    pub fn require(&self, view: &ViewParams) -> Result<(), TemplateError> {
        let (file, pipeline) = (self.view.hash(), view.hash());
        if file == pipeline { Ok(()) } else { Err(TemplateError::Parameters { file, pipeline }) }
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
        self.records.is_empty()
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
    pub fn iter(&self) -> impl ExactSizeIterator<Item = Template<'a>> + use<'a> {
        let objects = self.objects;
        self.records.iter().map(move |record| Template {
            record,
            class: objects.get(usize::from(record.object)).map_or(u16::MAX, |o| o.class.get()),
        })
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
    record: &'a Record,
    class: u16,
}

impl Template<'_> {
    /// Index of its class.
    pub fn class(&self) -> u16 {
        self.class
    }

    /// Index of its object.
    pub fn object(&self) -> u16 {
        self.record.object.get()
    }

    /// Number of the view, as the set's maker counted them.
    pub fn view(&self) -> u16 {
        self.record.view.get()
    }

    /// The 58 numbers.
    pub fn descriptor(&self) -> Descriptor {
        core::array::from_fn(|i| self.record.values[i].get())
    }

    /// Canberra distance to a descriptor.
    #[inline(always)]
    pub fn distance(&self, descriptor: &Descriptor) -> f32 {
        canberra_with(descriptor, |i| self.record.values[i].get())
    }
}

#[cfg(test)]
mod tests;
