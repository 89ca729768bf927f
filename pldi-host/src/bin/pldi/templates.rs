//! `pldi templates`: template sets.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use pldi_core::pipeline::{Fixed, Float};
use pldi_core::templates::Encoding;
use pldi_core::view::ViewParams;
use pldi_fixtures::Mesh;
use pldi_host::mesh::{Size, TriangleMesh, Unit, Up};
use pldi_host::output::atomic;
use pldi_host::templates::{
    Builder, EMBEDDED, Look, ObjectMesh, fixed_file, for_arithmetic, leave_one_object_out, procedural,
};
use pldi_host::{ArithmeticKind, Error, Numbers, parallel};

use crate::args::{ArithmeticArg, Threads, ViewArgs};
use crate::print;

/// The commands below `pldi templates`.
#[derive(Debug, clap::Subcommand)]
pub enum Templates {
    /// Render meshes from all sides and write their descriptors
    Build(Box<Build>),
    /// Show what a template file holds
    Info {
        /// The file [default: the embedded set]
        file: Option<PathBuf>,
    },
    /// Make a file for the fixed-point pipeline (16-bit logarithms) of a file of floats
    Convert {
        /// The file of floats
        file: PathBuf,
        /// The file to write
        #[arg(short, long, value_name = "FILE")]
        output: PathBuf,
    },
    /// Try each view against all views of the other objects: confusion matrix, precision and recall
    Evaluate {
        /// The file [default: the embedded set]
        file: Option<PathBuf>,
        #[command(flatten)]
        threads: Threads,
    },
}

/// Options of `pldi templates build`.
#[derive(Debug, clap::Args)]
pub struct Build {
    /// Meshes: OFF, OBJ, STL or PLY; with --by-folder also folders
    #[arg(value_name = "MESH", required_unless_present = "procedural")]
    meshes: Vec<PathBuf>,
    /// The procedural furniture, in place of meshes
    #[arg(long, conflicts_with_all = ["meshes", "class", "by_folder"])]
    procedural: bool,
    /// Objects of each class of the procedural furniture
    #[arg(long, value_name = "N", default_value_t = 8, requires = "procedural")]
    objects: u16,
    /// The file to write
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// The class of all meshes
    #[arg(long, value_name = "NAME", conflicts_with = "by_folder")]
    class: Option<String>,
    /// Each mesh's class is the name of its folder; of the first folder below where a folder of folders is given
    #[arg(long)]
    by_folder: bool,
    /// The axis that points up: z or y
    #[arg(long, value_name = "AXIS", default_value = "z")]
    up: Up,
    /// Unit of the meshes: m, cm, mm, inch, or metres per unit
    #[arg(long, value_name = "UNIT", default_value = "m")]
    unit: Unit,
    /// Scale each mesh so that its longest side has this many metres, whatever its unit
    #[arg(long, value_name = "M", conflicts_with = "unit")]
    longest: Option<f64>,
    /// Horizontal distance of the camera in m; several, separated by commas, make several rings
    #[arg(long, value_name = "M", default_value = "2", value_delimiter = ',')]
    distance: Vec<f32>,
    /// Height of the camera above the floor in m
    #[arg(long, value_name = "M", default_value_t = 1.2)]
    height: f32,
    /// Pitch of the camera in degrees, looking down [default: towards half of the object's height]
    #[arg(long, value_name = "DEGREES", allow_hyphen_values = true)]
    pitch: Option<f32>,
    /// Views on each ring
    #[arg(long, value_name = "M", default_value_t = 20)]
    views: u16,
    /// Exact depth, no filter, in place of the Kinect's simulation
    #[arg(long)]
    noise_free: bool,
    /// Keep the distance for objects too large to be seen whole from there
    #[arg(long)]
    exact_distance: bool,
    /// What the descriptors are computed in: float writes a file of floats, fixed one of 16-bit logarithms
    #[arg(long, value_enum, default_value = "float")]
    arithmetic: ArithmeticArg,
    /// Write descriptors computed in floats as 16-bit logarithms, as templates convert does
    #[arg(long, conflicts_with = "arithmetic")]
    fixed: bool,
    #[command(flatten)]
    view: ViewArgs,
    #[command(flatten)]
    threads: Threads,
}

impl Templates {
    /// Runs the command.
    pub fn run(&self) -> anyhow::Result<()> {
        match self {
            Self::Build(build) => build.run(),
            Self::Info { file } => info(file.as_deref()),
            Self::Convert { file, output } => convert(file, output),
            Self::Evaluate { file, threads } => {
                let bytes = read(file.as_deref())?;
                let set = parse(file.as_deref(), &bytes)?;
                print::line(leave_one_object_out(&set, threads.count()))
            }
        }
    }
}

/// The bytes of a template file, or the embedded ones.
pub fn read(file: Option<&Path>) -> Result<Vec<u8>, Error> {
    match file {
        None => Ok(EMBEDDED.to_vec()),
        Some(path) => std::fs::read(path).map_err(|cause| Error::Read { path: path.to_owned(), cause }),
    }
}

/// The bytes of a template file, or the embedded ones, as an arithmetic searches them.
pub fn read_for(file: Option<&Path>, arithmetic: ArithmeticKind) -> Result<Vec<u8>, Error> {
    let bytes = read(file)?;
    // Whatever is wrong with the file is to be told with its name.
    parse(file, &bytes)?;
    Ok(for_arithmetic(bytes.into(), arithmetic)?.into_owned())
}

/// The templates in some bytes.
pub fn parse<'a>(file: Option<&Path>, bytes: &'a [u8]) -> Result<pldi_core::templates::Templates<'a>, Error> {
    let path = file.unwrap_or(Path::new("the embedded templates")).to_owned();
    pldi_core::templates::Templates::parse(bytes).map_err(|cause| Error::Templates { path, cause })
}

fn info(file: Option<&Path>) -> anyhow::Result<()> {
    let bytes = read(file)?;
    let set = parse(file, &bytes)?;
    let view = set.view_params();
    print::line(format_args!(
        "{} bytes, CRC-32 {:08x}, view parameters {:08x}",
        bytes.len(),
        set.checksum(),
        view.hash()
    ))?;
    print::line(format_args!(
        "descriptor {}, framing {:?}, normals in {} m",
        view.descriptor.name(),
        view.framing,
        view.radius
    ))?;
    print::line(format_args!(
        "{} templates of {} objects in {} classes, {}",
        set.len(),
        set.objects().len(),
        set.classes().len(),
        set.encoding().name()
    ))?;
    for (i, class) in set.classes().enumerate() {
        let objects = set.objects().filter(|(c, _)| usize::from(*c) == i).count();
        let views = set.iter().filter(|t| usize::from(t.class()) == i).count();
        print::line(format_args!("{class:20} {objects:5} objects {views:7} views"))?;
    }
    Ok(())
}

fn convert(file: &Path, output: &Path) -> anyhow::Result<()> {
    let bytes = read(Some(file))?;
    let set = parse(Some(file), &bytes)?;
    set.require_encoding(Encoding::Float).map_err(|cause| Error::Templates { path: file.to_owned(), cause })?;
    atomic::write_bytes(output, &fixed_file(&bytes)?)?;
    eprintln!("{}: {} templates as {}", output.display(), set.len(), Encoding::Logarithmic.name());
    Ok(())
}

impl Build {
    fn run(&self) -> anyhow::Result<()> {
        let look = Look {
            distances: self.distance.clone(),
            height: self.height,
            views: self.views,
            pitch: self.pitch.map(f32::to_radians),
            simulate: !self.noise_free,
            exact_distance: self.exact_distance,
        };
        let builder = Builder::new(self.view.params(ViewParams::DEFAULT), look)?;
        let objects = if self.procedural { procedural(self.objects) } else { self.read_meshes()? };
        match self.arithmetic.into() {
            ArithmeticKind::Float => self.write::<Float>(&builder, &objects),
            ArithmeticKind::Fixed => self.write::<Fixed>(&builder, &objects),
        }
    }

    fn write<A: Numbers>(&self, builder: &Builder, objects: &[ObjectMesh]) -> anyhow::Result<()> {
        let bar = crate::progress::bar(Some(objects.len() as u64));
        let set = builder.build::<A>(objects, self.threads.count(), |_| {
            bar.inc(1);
            !crate::progress::interrupted()
        })?;
        bar.finish_and_clear();
        if self.fixed {
            atomic::write_bytes(&self.output, &fixed_file(&set.to_bytes()?)?)?;
        } else {
            set.write(&self.output)?;
        }
        let (views, objects, classes) = (set.views.len(), set.objects.len(), set.classes.len());
        eprintln!("{}: {views} templates of {objects} objects in {classes} classes", self.output.display());
        Ok(())
    }

    fn read_meshes(&self) -> anyhow::Result<Vec<ObjectMesh>> {
        let mut files = Vec::new();
        for path in &self.meshes {
            collect(path, None, &mut files)?;
        }
        files.sort();
        if files.is_empty() {
            return Err(Error::Usage("no mesh (.off, .obj, .stl, .ply) in what was given".to_owned()).into());
        }
        let size = self.longest.map_or(Size::Unit(self.unit), Size::Longest);
        let meshes = parallel::map_ordered(
            files.len(),
            self.threads.count(),
            || (),
            |(), i| {
                let (path, folder) = &files[i];
                let class = match (&self.class, self.by_folder) {
                    (Some(class), _) => class.clone(),
                    (None, true) => folder.clone().map_or_else(|| folder_name(path), Ok)?,
                    (None, false) => {
                        return Err(Error::Usage("give the meshes' class by --class or --by-folder".to_owned()));
                    }
                };
                let mesh = TriangleMesh::read(path)?.prepared(self.up, size)?;
                let (vertices, triangles) = mesh.into_parts();
                let name = path.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
                Ok(ObjectMesh { class, name, mesh: Arc::new(Mesh::from_triangles(vertices, &triangles)) })
            },
        )?;
        Ok(meshes)
    }
}

/// A mesh file's folder, as the name of its class.
fn folder_name(path: &Path) -> Result<String, Error> {
    let full = std::path::absolute(path).map_err(|cause| Error::Read { path: path.to_owned(), cause })?;
    let name = full.parent().and_then(Path::file_name).map(|n| n.to_string_lossy().into_owned());
    name.ok_or_else(|| Error::Usage(format!("{} lies in no folder that could name its class", path.display())))
}

/// The files themselves, and the meshes in folders and below, each with the name of the first folder below `path`.
fn collect(path: &Path, class: Option<&str>, files: &mut Vec<(PathBuf, Option<String>)>) -> Result<(), Error> {
    if !path.is_dir() {
        files.push((path.to_owned(), class.map(str::to_owned)));
        return Ok(());
    }
    let fails = |cause| Error::Read { path: path.to_owned(), cause };
    for entry in std::fs::read_dir(path).map_err(fails)? {
        let entry = entry.map_err(fails)?;
        let path = entry.path();
        let ending = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
        if path.is_dir() {
            let name = entry.file_name().to_string_lossy().into_owned();
            collect(&path, Some(class.unwrap_or(&name)), files)?;
        } else if ending.is_some_and(|e| ["off", "obj", "stl", "ply"].contains(&e.as_str())) {
            collect(&path, class, files)?;
        }
    }
    Ok(())
}
