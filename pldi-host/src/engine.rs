//! The pipeline in either arithmetic, with the same results to look at.

use pldi_core::descriptor::{self, Descriptor, DescriptorKind};
use pldi_core::pipeline::{Fixed, Params, QvgaFixedPipeline, QvgaFixedWorkspace, QvgaPipeline, QvgaWorkspace, mix};
use pldi_core::reconstruct::FilterKind;
use pldi_core::templates::Templates;
use pldi_core::{Floor, Frame, Intrinsics, TemplateError};

use crate::Error;
use crate::numbers::{ArithmeticKind, Numbers};

/// The pipeline for a camera and a set of parameters. Whatever it computes in, what the stages make is left in a workspace
/// of floats: whoever draws, reports or judges need not know.
#[derive(Debug, Clone)]
pub struct Engine {
    params: Params,
    intrinsics: Intrinsics,
    inner: Inner,
}

#[derive(Debug, Clone)]
enum Inner {
    Float(Box<QvgaPipeline>),
    Fixed(Box<Integers>),
}

/// The fixed-point pipeline with its own memory.
#[derive(Debug, Clone)]
struct Integers {
    pipeline: QvgaFixedPipeline,
    workspace: QvgaFixedWorkspace,
}

/// Both descriptors of a view.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Descriptors {
    /// Mean, standard deviation and skewness.
    pub paper: Descriptor,
    /// Upper and lower mean, standard deviation.
    pub halves: Descriptor,
}

impl Descriptors {
    fn new(of: impl Fn(DescriptorKind) -> Descriptor) -> Self {
        Self { paper: of(DescriptorKind::Paper), halves: of(DescriptorKind::Halves) }
    }
}

impl Engine {
    /// Checks the parameters and fills the tables.
    ///
    /// # Errors
    /// As [`Engine::check`]; `Core` for intrinsics that are out of range or of another size than QVGA.
    pub fn new(kind: ArithmeticKind, params: &Params, intrinsics: &Intrinsics) -> Result<Self, Error> {
        Self::check(kind, params)?;
        let inner = match kind {
            ArithmeticKind::Float => {
                Inner::Float(Box::new(QvgaPipeline::new(params, intrinsics).map_err(Error::core)?))
            }
            ArithmeticKind::Fixed => {
                let (params, intrinsics) = (Fixed::params(params)?, Fixed::intrinsics(intrinsics)?);
                let pipeline = QvgaFixedPipeline::new(&params, &intrinsics).map_err(Error::core)?;
                Inner::Fixed(Box::new(Integers { pipeline, workspace: QvgaFixedWorkspace::new() }))
            }
        };
        Ok(Self { params: *params, intrinsics: *intrinsics, inner })
    }

    /// Checks the parameters alone.
    ///
    /// # Errors
    /// `Usage` for the exact filter in integers; `Core` with the first parameter that is out of range.
    pub fn check(kind: ArithmeticKind, params: &Params) -> Result<(), Error> {
        match kind {
            ArithmeticKind::Float => params.validate().map_err(Error::core),
            ArithmeticKind::Fixed if params.filter.kind == FilterKind::Exact => {
                let text = "--filter exact is computed in floats only: leave out --arithmetic fixed";
                Err(Error::Usage(text.to_owned()))
            }
            ArithmeticKind::Fixed => Fixed::params(params).map(|_| ()),
        }
    }

    /// Checks that templates were made with these view parameters, and hold what this arithmetic searches.
    ///
    /// # Errors
    /// `Parameters` or `Encoding`.
    pub fn require(&self, templates: &Templates<'_>) -> Result<(), TemplateError> {
        templates.require(self.params.view.hash(), self.kind().encoding())
    }

    /// Which arithmetic it runs in.
    pub fn kind(&self) -> ArithmeticKind {
        match &self.inner {
            Inner::Float(_) => ArithmeticKind::Float,
            Inner::Fixed(_) => ArithmeticKind::Fixed,
        }
    }

    /// The parameters.
    pub fn params(&self) -> &Params {
        &self.params
    }

    /// The camera.
    pub fn intrinsics(&self) -> &Intrinsics {
        &self.intrinsics
    }

    /// Takes a frame all the way, as [`QvgaPipeline::run`] does. Of the images, view and coefficients may be missing.
    ///
    /// # Errors
    /// `Core` as the pipeline says; templates must have the arithmetic's [encoding](ArithmeticKind::encoding).
    pub fn run(
        &mut self,
        frame: &Frame<'_, 320, 240>,
        templates: &Templates<'_>,
        workspace: &mut QvgaWorkspace,
    ) -> Result<(), Error> {
        self.require(templates).map_err(|cause| Error::core(cause.into()))?;
        match &mut self.inner {
            Inner::Float(pipeline) => pipeline.run(frame, templates, workspace),
            Inner::Fixed(integers) => integers.run(frame, templates, workspace),
        }
        .map_err(Error::core)
    }

    /// First stage, with an empty report: the reconstructed depth.
    pub fn reconstruct(&mut self, frame: &Frame<'_, 320, 240>, workspace: &mut QvgaWorkspace) {
        workspace.report.clear();
        match &mut self.inner {
            Inner::Float(pipeline) => pipeline.reconstruct(frame, workspace),
            Inner::Fixed(integers) => integers.stage(workspace, |pipeline, own| {
                own.report.clear();
                pipeline.reconstruct(frame, own);
            }),
        }
    }

    /// Second stage: the floor, also in the report.
    pub fn find_floor(&mut self, workspace: &mut QvgaWorkspace) -> Option<Floor> {
        match &mut self.inner {
            Inner::Float(pipeline) => pipeline.find_floor(workspace),
            Inner::Fixed(integers) => {
                let floor = integers.stage(workspace, |pipeline, own| pipeline.find_floor(own));
                floor.map(|floor| floor.to_float())
            }
        }
    }

    /// Third stage: clusters and their tests. Nothing happens where the second stage found no floor.
    ///
    /// # Errors
    /// `Core` where the frame has more clusters or contour points than there is room for.
    pub fn find_candidates(&mut self, workspace: &mut QvgaWorkspace) -> Result<(), Error> {
        match &mut self.inner {
            Inner::Float(pipeline) => match workspace.report.floor {
                Some(floor) => pipeline.find_candidates(&floor, workspace),
                None => Ok(()),
            },
            Inner::Fixed(integers) => integers.stage(workspace, |pipeline, own| match own.report.floor {
                Some(floor) => pipeline.find_candidates(&floor, own),
                None => Ok(()),
            }),
        }
        .map_err(Error::core)
    }

    /// Fourth stage: N at the pixels of candidates.
    pub fn diffuse_candidates(&mut self, workspace: &mut QvgaWorkspace) {
        match &mut self.inner {
            Inner::Float(pipeline) => pipeline.diffuse_candidates(workspace),
            Inner::Fixed(integers) => integers.stage(workspace, |pipeline, own| pipeline.diffuse_candidates(own)),
        }
    }

    /// N of the whole image.
    pub fn diffuse_all(&mut self, workspace: &mut QvgaWorkspace) {
        match &mut self.inner {
            Inner::Float(pipeline) => pipeline.diffuse_all(workspace),
            Inner::Fixed(integers) => integers.stage(workspace, |pipeline, own| pipeline.diffuse_all(own)),
        }
    }

    /// Fifth to seventh stage: view, coefficients and descriptors of a cluster; `None` where it has no pixels.
    pub fn describe(&mut self, cluster: usize, workspace: &mut QvgaWorkspace) -> Option<Descriptors> {
        match &mut self.inner {
            Inner::Float(pipeline) => {
                pipeline.describe(cluster, &workspace.report.floor?, workspace)?;
                let plane = &workspace.images.coefficients;
                Some(Descriptors::new(|kind| descriptor::from_coefficients(plane, kind)))
            }
            Inner::Fixed(integers) => {
                let Integers { pipeline, workspace: own } = &mut **integers;
                pipeline.frame_view(cluster, &own.report.floor?, own)?;
                let view = own.images.views()?.plane.as_flattened();
                for (to, from) in workspace.images.view.as_flattened_mut().iter_mut().zip(view) {
                    // N in 1/128 of its unit.
                    *to = (from >> 7) as u16;
                }
                integers.stage(workspace, |pipeline, own| pipeline.describe_view(own));
                let plane = integers.workspace.images.views()?.plane;
                let numbers = |kind| descriptor::fixed::from_coefficients(plane, kind);
                Some(Descriptors::new(|kind| numbers(kind).map(descriptor::fixed::decode)))
            }
        }
    }
}

impl Integers {
    /// Runs some stages and translates what they leave.
    fn stage<T>(
        &mut self,
        workspace: &mut QvgaWorkspace,
        work: impl FnOnce(&QvgaFixedPipeline, &mut QvgaFixedWorkspace) -> T,
    ) -> T {
        let result = work(&self.pipeline, &mut self.workspace);
        mix::images_to_float(&self.workspace.images, &mut workspace.images);
        mix::report_to_float(&self.workspace.report, &mut workspace.report);
        result
    }

    fn run(
        &mut self,
        frame: &Frame<'_, 320, 240>,
        templates: &Templates<'_>,
        workspace: &mut QvgaWorkspace,
    ) -> Result<(), pldi_core::Error> {
        // The ground map is there until N takes its place.
        let floor = self.stage(workspace, |pipeline, own| {
            own.report.clear();
            pipeline.reconstruct(frame, own);
            let floor = pipeline.find_floor(own);
            floor.map(|floor| pipeline.find_candidates(&floor, own).map(|()| floor)).transpose()
        })?;
        self.stage(workspace, |pipeline, own| match floor {
            Some(floor) => pipeline.classify(&floor, templates, own),
            None => Ok(()),
        })
    }
}
