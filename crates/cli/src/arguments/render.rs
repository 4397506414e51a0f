//! Flags of `eosphor render`.

use super::camera::CameraFlags;
use super::settings::SettingsFlags;
use super::values::{place, whole};
use super::{
    BackendChoice, ClusterFlags, DeviceFlags, FrameFlags, KeepFlags, LightFlags, Need, TextureFlags, check,
    scene_help,
};
use crate::failure::Failure;
use crate::streams::Verbosity;
use clap::builder::{OsStringValueParser, TypedValueParser};
use clap::{ArgAction, Args};
use eosphor::{Accel, Format, GpuScheduler, Layer, Preset, Region, Traversal};
use std::ops::Range;
use std::path::{Path, PathBuf};

#[derive(Debug, Args)]
pub(crate) struct RenderFlags {
    #[arg(help = scene_help())]
    pub(crate) scene: PathBuf,
    /// The output file: .png, .ppm, .jpg or .data (width, height and bytes of red, green, blue, alpha), or with linear
    /// colours .exr or .hdr; for an animation a numbered name such as frame_%04d.png, or .mp4; - is standard output. If given
    /// several times, the picture is written to each. Missing folders are created [default: the output that the scene file
    /// names]
    #[arg(short, long = "output", value_name = "OUT", value_parser = path())]
    pub(crate) outputs: Vec<PathBuf>,
    /// Show something other than the colours of the scene. cost: how many nodes and primitives the camera rays of each pixel
    /// test, from dark for few to bright for many
    #[arg(long, value_name = "WHAT", conflicts_with = "layers", value_parser = super::values::named([("cost", Show::Cost)]))]
    pub(crate) show: Option<Show>,
    /// The number of nodes and tests that --show cost draws in its brightest colour, 1 to 4294967295 [default: the number that
    /// one pixel in a thousand exceeds]
    #[arg(long, value_name = "N", requires = "show", value_parser = whole::<u32>(1..=u32::MAX), allow_hyphen_values = true)]
    pub(crate) show_max: Option<u32>,
    #[command(flatten)]
    pub(crate) picture: PictureFlags,
    #[command(flatten)]
    pub(crate) file: FileFlags,
    #[command(flatten)]
    pub(crate) keep: KeepFlags,
    #[command(flatten)]
    pub(crate) animation: FrameFlags,
    #[command(flatten)]
    pub(crate) settings: SettingsFlags,
    #[command(flatten)]
    pub(crate) textures: TextureFlags,
    #[command(flatten)]
    pub(crate) camera: CameraFlags,
    #[command(flatten)]
    pub(crate) device: DeviceFlags,
    #[command(flatten)]
    pub(crate) cluster: ClusterFlags,
    #[command(flatten)]
    pub(crate) report: ReportFlags,
    /// Long names of the flags that the command line has.
    #[arg(skip)]
    pub(crate) given: Vec<String>,
}

impl RenderFlags {
    /// Whether the command line has a flag, by its long name.
    pub(crate) fn is_given(&self, flag: &str) -> bool {
        self.given.iter().any(|given| given == flag)
    }

    /// The output; of several ones the first.
    pub(crate) fn output(&self) -> &Path {
        self.outputs.first().map_or(Path::new(""), PathBuf::as_path)
    }
}

/// What `render` and `bench render` share besides the larger groups.
#[derive(Clone, Debug, Args)]
pub(crate) struct PictureFlags {
    /// Use the settings of a reference system: eos (Thessaly 2015), pg1 (CTU Prague 2025) or course (PLATO); other flags
    /// override them
    #[arg(long, value_name = "NAME", value_parser = super::values::named([("eos", Preset::Eos), ("pg1", Preset::Pg1), ("course", Preset::Course)]))]
    pub(crate) preset: Option<Preset>,
    /// Move all geometry by this vector; camera and lights stay in place
    #[arg(long, value_name = "X,Y,Z", value_parser = place, allow_hyphen_values = true)]
    pub(crate) translate: Option<[f64; 3]>,
    /// The hierarchy (acceleration structure) that rays are traced through; changes no pixel. GPUs support all but bvh8
    /// [default: bvh8 on the CPU, bvh on GPUs]
    #[arg(long, value_name = "NAME", value_parser = super::device::accel())]
    pub(crate) accel: Option<Accel>,
    #[command(flatten)]
    pub(crate) lights: LightFlags,
}

impl PictureFlags {
    /// Whether the light of flags takes the place of what is added to a file without any. A preset says itself what is added.
    pub(crate) fn are_lit(&self) -> bool {
        self.lights.is_given() && self.preset.is_none()
    }
}

/// A path, which may be empty: then the scene's file has to name one.
fn path() -> impl TypedValueParser<Value = PathBuf> {
    OsStringValueParser::new().map(PathBuf::from)
}

/// What is shown instead of the picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Show {
    /// Work on camera rays.
    Cost,
}

/// What the file is like. None of these changes the picture.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "File")]
pub(crate) struct FileFlags {
    /// Format of the picture on standard output (-o -) [default: png]
    #[arg(long, value_name = "NAME", value_parser = super::values::named(Format::ALL.map(|format| (format.extensions()[0], format))))]
    pub(crate) format: Option<Format>,
    /// Extra channels in an .exr, of the first surface that each pixel's camera rays hit: a comma-separated list of albedo,
    /// normal, depth, object, material, cost; or all [default: none]
    #[arg(long, value_name = "LIST", value_parser = layers)]
    layers: Option<Layers>,
    /// Leave the background out of a .png or .exr, and add an alpha channel with the coverage of each pixel. Background that is
    /// seen in mirrors and through glass stays
    #[arg(long, conflicts_with_all = ["show", "sample_range"])]
    pub(crate) alpha: bool,
    /// Write 16-bit floats to an .exr; depth and whole numbers keep 32 bits
    #[arg(long)]
    pub(crate) exr_half: bool,
    /// Quality of a .jpg, 1 to 100; below 90 colours have half the resolution [default: 90]
    #[arg(long, value_name = "N", value_parser = whole::<u8>(1..=100), allow_hyphen_values = true)]
    pub(crate) jpeg_quality: Option<u8>,
    /// Do not store the command line and the hash of the scene in .png and .exr
    #[arg(long)]
    pub(crate) no_metadata: bool,
    /// Render share K of N of the picture's rows, N at most 500, for jobs that run independently. Writes OUT.K-of-N.share;
    /// eosphor merge joins all shares
    #[arg(long, value_name = "K/N", value_parser = share, allow_hyphen_values = true)]
    pub(crate) tiles: Option<Share>,
    /// Render only the samples A to B - 1 of each pixel, for jobs that run independently. Writes OUT.A-B.sums; eosphor merge
    /// joins all ranges
    #[arg(long, value_name = "A..B", value_parser = sample_range, allow_hyphen_values = true, conflicts_with_all = ["tiles", "layers", "show"])]
    pub(crate) sample_range: Option<SampleRange>,
    /// Render only a part of the picture: W x H pixels with the upper left one at X,Y. The pixels are those of the whole
    /// picture, bit for bit; the file has the size of the part, and an .exr records its position
    #[arg(long, value_name = "X,Y,WxH", value_parser = super::values::region, allow_hyphen_values = true, conflicts_with = "show")]
    pub(crate) region: Option<Region>,
    /// Rows that are rendered before any of them is written, 1 to 65535; changes no pixel [default: what memory allows]
    #[arg(long, value_name = "N", value_parser = whole::<u32>(1..=65_535), allow_hyphen_values = true, hide = true)]
    pub(crate) band_rows: Option<u32>,
}

/// A share of a picture: its number, from 1, and how many there are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Share(pub(crate) (u32, u32));

/// `3/8`.
fn share(text: &str) -> Result<Share, String> {
    let numbers = text.split_once('/').and_then(|(k, n)| Some((k.parse().ok()?, n.parse().ok()?)));
    match numbers {
        Some((number, count)) if number >= 1 && number <= count && count <= 500 => Ok(Share((number, count))),
        _ => {
            Err("it must be the number of the share, from 1, a stroke and how many there are, at most 500, as in 3/8"
                .into())
        }
    }
}

/// Samples by number.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct SampleRange(pub(crate) Range<u32>);

/// `0..64`.
fn sample_range(text: &str) -> Result<SampleRange, String> {
    let numbers = text.split_once("..").and_then(|(a, b)| Some(a.parse().ok()?..b.parse().ok()?));
    numbers.filter(|range: &Range<u32>| !range.is_empty()).map(SampleRange).ok_or_else(|| {
        "it must be the first sample, two dots and the one after the last, as in 0..64".to_owned()
    })
}

/// A list of layers. (clap takes a bare `Vec` to mean a flag that may be given several times.)
#[derive(Clone, Debug, PartialEq, Eq)]
struct Layers(Vec<Layer>);

/// `depth,normal` or `all`.
fn layers(text: &str) -> Result<Layers, String> {
    match text {
        "all" => Ok(Layers(Layer::ALL.to_vec())),
        _ => text.split(',').map(|name| name.trim().parse()).collect::<Result<_, _>>().map(Layers),
    }
}

impl FileFlags {
    pub(crate) fn layers(&self) -> &[Layer] {
        self.layers.as_ref().map_or(&[], |layers| &layers.0)
    }

    /// Whether a share of the picture is asked for.
    pub(crate) fn is_share(&self) -> bool {
        self.tiles.is_some() || self.sample_range.is_some()
    }

    /// Whether each flag is for one of these formats, of which a video has none.
    pub(crate) fn check(&self, formats: &[Format], to_stdout: bool) -> Result<(), Failure> {
        check(&[Need {
            flag: "--format",
            is_given: self.format.is_some(),
            is_met: to_stdout,
            needs: "standard output (-o -), as names of files say their format",
        }])?;
        let wrong =
            |flag, ending| Err(Failure::Usage(format!("{flag} is for pictures that end in {ending}")));
        let has = |format| formats.contains(&format);
        match () {
            _ if !self.layers().is_empty() && !formats.iter().any(|format| format.has_layers()) => {
                wrong("--layers", ".exr")
            }
            _ if self.alpha && !formats.iter().any(|format| format.has_alpha()) => {
                wrong("--alpha", ".png or .exr")
            }
            _ if self.exr_half && !has(Format::Exr) => wrong("--exr-half", ".exr"),
            _ if self.jpeg_quality.is_some() && !has(Format::Jpeg) => wrong("--jpeg-quality", ".jpg"),
            _ => Ok(()),
        }
    }
}

#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Report")]
pub(crate) struct ReportFlags {
    /// Print the statistics as JSON to standard output
    #[arg(long)]
    pub(crate) json: bool,
    /// Count nodes and tests per ray, and time traversal and intersection. Renders several times slower, because rays are
    /// traced one by one and clocks are read often
    #[arg(long)]
    pub(crate) stats: bool,
    /// Print errors only
    #[arg(short, long, conflicts_with = "verbose")]
    quiet: bool,
    /// Print more messages
    #[arg(short, long, action = ArgAction::SetTrue)]
    verbose: bool,
}

impl ReportFlags {
    /// Fails where the work that is to be counted is not done by who counts.
    pub(crate) fn check(
        &self,
        device: &DeviceFlags,
        show: Option<Show>,
        to_stdout: bool,
    ) -> Result<(), Failure> {
        let need = |flag, is_given, is_met, needs| Need { flag, is_given, is_met, needs };
        let one_way = "a render without --stats, which goes the way of one ray";
        let one_by_one = "a render without --stats, which follows one path after the other";
        let traversal = device.gpu_traversal != Traversal::default();
        let scheduler = device.gpu_scheduler != GpuScheduler::default();
        let is_cuda = matches!(device.backend(), BackendChoice::Cuda(_));
        check(&[
            need(
                "--backend cuda",
                is_cuda,
                show.is_none(),
                "a picture of the scene, not --show, which is of the CPU's work",
            ),
            need("--json", self.json, !to_stdout, "standard output for itself, not -o -"),
            need("--stats", self.stats, show.is_none(), "a picture of the scene, not --show"),
            need("--gpu-traversal", traversal, !self.stats, one_way),
            need("--gpu-scheduler", scheduler, !self.stats, one_by_one),
            need("--gpu-paths", device.gpu_paths.is_some(), !self.stats, one_by_one),
        ])
    }

    pub(crate) fn verbosity(&self) -> Verbosity {
        match (self.quiet, self.verbose) {
            (true, _) => Verbosity::Quiet,
            (_, true) => Verbosity::Verbose,
            _ => Verbosity::Normal,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_of_samples() {
        assert_eq!(sample_range("3..64").unwrap().0, 3..64);
        for bad in ["", "3", "..4", "4..", "4..4", "5..4", "-1..2", "a..b", "0..99999999999"] {
            assert!(sample_range(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn lists_of_layers() {
        assert_eq!(layers("depth, cost").unwrap().0, [Layer::Depth, Layer::Cost]);
        assert_eq!(layers("all").unwrap().0, Layer::ALL);
        for bad in ["", "depth,", "Depth", "all,depth", "z"] {
            assert!(layers(bad).unwrap_err().contains("albedo, normal"), "{bad}");
        }
    }
}
