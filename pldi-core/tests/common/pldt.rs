//! Template files made on the spot.

use pldi_core::descriptor::Descriptor;
use pldi_core::descriptor::fixed::encode;
use pldi_core::templates::MAGIC;
use pldi_core::templates::layout::{self, Class, Encoding, Header, LogRecord, Object, Record};
use pldi_core::view::ViewParams;
use zerocopy::IntoBytes;

/// What goes into a template file.
#[derive(Debug, Clone)]
pub struct Set<'a> {
    /// The names of the classes.
    pub classes: &'a [&'a str],
    /// Class and name of each object.
    pub objects: &'a [(u16, &'a str)],
    /// Object, view and numbers of each template.
    pub templates: &'a [(u16, u16, Descriptor)],
}

impl Set<'_> {
    /// The file.
    pub fn file(&self, view: &ViewParams, encoding: Encoding) -> Vec<u8> {
        let (framing, side) = view.framing_fields();
        let header = Header {
            magic: MAGIC,
            version: encoding.version().into(),
            encoding: encoding as u8,
            reserved: 0,
            parameters: view.hash().into(),
            checksum: 0.into(),
            classes: (self.classes.len() as u16).into(),
            objects: (self.objects.len() as u16).into(),
            templates: (self.templates.len() as u32).into(),
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
        for name in self.classes {
            bytes.extend(Class { name: layout::padded(name) }.as_bytes());
        }
        for (class, name) in self.objects {
            bytes.extend(Object { class: (*class).into(), name: layout::padded(name) }.as_bytes());
        }
        for (object, view, values) in self.templates {
            let (object, view) = ((*object).into(), (*view).into());
            match encoding {
                Encoding::Float => bytes.extend(Record { object, view, values: values.map(Into::into) }.as_bytes()),
                Encoding::Logarithmic => {
                    bytes.extend(LogRecord { object, view, values: values.map(|v| encode(v).into()) }.as_bytes());
                }
            }
        }
        layout::seal(&mut bytes);
        bytes
    }
}

/// A file of floats in which each template is one view of one object of one class, which have its name.
pub fn file(view: &ViewParams, templates: &[(&str, Descriptor)]) -> Vec<u8> {
    let classes: Vec<&str> = templates.iter().map(|(name, _)| *name).collect();
    let objects: Vec<(u16, &str)> = (0..).zip(classes.iter().copied()).collect();
    let views: Vec<(u16, u16, Descriptor)> = (0..).zip(templates).map(|(i, (_, d))| (i, 0, *d)).collect();
    Set { classes: &classes, objects: &objects, templates: &views }.file(view, Encoding::Float)
}
