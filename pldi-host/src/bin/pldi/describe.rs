//! `pldi describe` and `pldi match`: descriptors of single images.

use std::path::{Path, PathBuf};

use anyhow::Context;
use pldi_core::descriptor::{self, Descriptor, LENGTH, View};
use pldi_core::matching::canberra;
use pldi_core::wavelet::SIZE;
use pldi_host::output::png;
use serde_json::{Value, json};

use crate::args::DescriptorArg;
use crate::print;

/// Options of `pldi describe`.
#[derive(Debug, clap::Args)]
pub struct Describe {
    /// A 128x128 16-bit grey PNG, 65535 = 1
    image: PathBuf,
    /// Which statistics describe the view
    #[arg(long, value_enum, default_value = "halves")]
    descriptor: DescriptorArg,
}

impl Describe {
    /// Runs the command.
    pub fn run(&self) -> anyhow::Result<()> {
        let kind = self.descriptor.into();
        let pixels = png::read_view(&self.image)?;
        let mut view: View = [[0; SIZE]; SIZE];
        for (to, from) in view.as_flattened_mut().iter_mut().zip(pixels) {
            *to = from;
        }
        let numbers = descriptor::describe(&view, kind, &mut Box::new([[0.0; SIZE]; SIZE]));
        print::line(json!({ "descriptor": kind.name(), "values": numbers.to_vec() }))
    }
}

/// Options of `pldi match`.
#[derive(Debug, clap::Args)]
pub struct Match {
    /// A descriptor as `pldi describe` prints it
    a: PathBuf,
    /// Another
    b: PathBuf,
}

impl Match {
    /// Runs the command.
    pub fn run(&self) -> anyhow::Result<()> {
        let ((kind_a, a), (kind_b, b)) = (read(&self.a)?, read(&self.b)?);
        anyhow::ensure!(
            kind_a == kind_b,
            "{} holds a {kind_a:?} descriptor and {} a {kind_b:?} one: they cannot be compared",
            self.a.display(),
            self.b.display()
        );
        print::line(json!({ "descriptor": kind_a, "distance": canberra(&a, &b) }))
    }
}

/// Largest descriptor file that is read, in bytes.
const MAX_BYTES: u64 = 1 << 20;

/// Kind and numbers of a descriptor file.
fn read(path: &Path) -> anyhow::Result<(String, Descriptor)> {
    let fails = || format!("cannot read {}", path.display());
    let size = std::fs::metadata(path).with_context(fails)?.len();
    anyhow::ensure!(size <= MAX_BYTES, "{} has {size} bytes: not a descriptor", path.display());
    let text = std::fs::read_to_string(path).with_context(fails)?;
    let value: Value = serde_json::from_str(&text).with_context(|| format!("{} is not JSON", path.display()))?;
    let form = || format!("{}: {{\"descriptor\": NAME, \"values\": [58 numbers]}} is expected", path.display());
    let kind = value["descriptor"].as_str().with_context(form)?;
    let values: Option<Vec<f32>> =
        value["values"].as_array().and_then(|v| v.iter().map(|n| n.as_f64().map(|n| n as f32)).collect());
    let values = values.with_context(form)?;
    let count = values.len();
    let values: Descriptor =
        values.try_into().ok().with_context(|| format!("{} holds {count} numbers, not {LENGTH}", path.display()))?;
    anyhow::ensure!(values.iter().all(|v| v.is_finite()), "{} holds numbers that are not finite", path.display());
    Ok((kind.to_owned(), values))
}
