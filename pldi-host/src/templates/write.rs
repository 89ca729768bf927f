//! A template set in memory, and its file.

use std::path::Path;

use pldi_core::pipeline::Float;
use pldi_core::templates::MAGIC;
use pldi_core::templates::layout::{self, Class, Header, Object, padded};
use pldi_core::view::ViewParams;
use zerocopy::IntoBytes;

use crate::output::atomic;
use crate::{Error, Numbers};

/// One view of an object.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct View<A: Numbers = Float> {
    /// Index of the object.
    pub object: u16,
    /// Number of the view on its ring, from 0 on the +x axis counter-clockwise.
    pub view: u16,
    /// Its numbers.
    pub descriptor: A::Descriptor,
}

/// A template set as it is put together, in the numbers of an arithmetic.
#[derive(Debug, Clone, PartialEq)]
pub struct TemplateSet<A: Numbers = Float> {
    /// What the descriptors were made with.
    pub view: ViewParams,
    /// Horizontal distance of the camera in metres.
    pub distance: f32,
    /// Height of the camera above the floor in metres.
    pub height: f32,
    /// Whether the views went through the sensor's simulation.
    pub simulated: bool,
    /// Names of the classes.
    pub classes: Vec<String>,
    /// Class index and name of each object.
    pub objects: Vec<(u16, String)>,
    /// The views.
    pub views: Vec<View<A>>,
}

impl<A: Numbers> TemplateSet<A> {
    /// The bytes of the file: of floats, or of codes from integers. ([`fixed_file`](super::fixed_file) makes codes of floats.)
    ///
    /// # Errors
    /// `Usage` where there are more classes, objects or views than the format holds.
    pub fn to_bytes(&self) -> Result<Vec<u8>, Error> {
        let too_many = |what: &str, n: usize| Error::Usage(format!("{n} {what} are more than a template file holds"));
        if self.classes.len() > pldi_core::templates::MAX_CLASSES {
            return Err(too_many("classes", self.classes.len()));
        }
        let objects = u16::try_from(self.objects.len()).map_err(|_| too_many("objects", self.objects.len()))?;
        let templates = u32::try_from(self.views.len()).map_err(|_| too_many("views", self.views.len()))?;
        let encoding = A::KIND.encoding();
        let (framing, side) = self.view.framing_fields();
        let header = Header {
            magic: MAGIC,
            version: encoding.version().into(),
            encoding: encoding as u8,
            reserved: 0,
            parameters: self.view.hash().into(),
            checksum: 0.into(),
            classes: (self.classes.len() as u16).into(),
            objects: objects.into(),
            templates: templates.into(),
            descriptor: self.view.descriptor as u8,
            framing,
            reserved2: 0.into(),
            side: side.into(),
            radius: self.view.radius.into(),
            distance: self.distance.into(),
            height: self.height.into(),
            simulated: u8::from(self.simulated),
            reserved3: [0; 3],
        };
        let mut bytes = header.as_bytes().to_vec();
        for name in &self.classes {
            bytes.extend_from_slice(Class { name: padded(name) }.as_bytes());
        }
        for (class, name) in &self.objects {
            bytes.extend_from_slice(Object { class: (*class).into(), name: padded(name) }.as_bytes());
        }
        for v in &self.views {
            bytes.extend(A::record(v.object, v.view, &v.descriptor));
        }
        layout::seal(&mut bytes);
        Ok(bytes)
    }

    /// Writes the file, whole or not at all.
    ///
    /// # Errors
    /// What [`TemplateSet::to_bytes`] says; `Write` where the system refuses.
    pub fn write(&self, path: &Path) -> Result<(), Error> {
        atomic::write_bytes(path, &self.to_bytes()?)
    }
}
