//! Eosphor, a ray tracer that gives the same picture on every device, bit for bit.
//!
//! ```
//! use eosphor::{CpuBackend, CpuOptions, LoadOptions, SaveOptions, load, render, save};
//!
//! let mut scene = load("builtin:cornell", &LoadOptions::default())?.scene;
//! scene.settings.size = [64, 64];
//! let backend = CpuBackend::new(CpuOptions::default())?;
//! let picture = render(&scene, &backend)?;
//! let folder = tempfile::tempdir()?;
//! save(&picture.film, &folder.path().join("cornell.png"), &SaveOptions::from(&scene.settings))?;
//! println!("{} rays", picture.statistics.total_rays());
//! # assert!(picture.film.pixels.iter().any(|p| p.max_component() > 0.1));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! The way of the data: a file ([`load`]) or code makes a [`Scene`], what people write; [`SceneData::flatten`] makes
//! flat arrays of it, what machines read; a [`Backend`] builds a hierarchy over them and traces rays; the result is a
//! linear [`Film`]; developing makes bytes of it ([`Developed`]); [`save`] writes a file. [`render`] is the short way
//! from scene to film; with [`Backend::prepare`] and [`PreparedScene::render`] a program keeps the hierarchy, watches
//! the progress and can stop. Pictures that do not fit in memory are rendered in [`Bands`] of rows
//! ([`PreparedScene::render_rows`]) and streamed to a [`PictureWriter`]; [`job`] does that, and all else that a program needs.
//!
//! # Jobs
//!
//! All that the program `eosphor render` does is a call of [`job`]: stills that are kept while they go on ([`job::Still`]), a
//! part or a share of one, frames of an animation as files or as a video ([`job::Sequence`]), all with resume, progress and
//! cancel.
//!
//! ```
//! use eosphor::job::{Cancel, FrameNames, JobControl, Sequence, Still};
//! use eosphor::{CpuBackend, CpuOptions, LoadOptions, load};
//!
//! let mut scene = load("builtin:cornell", &LoadOptions::default())?.scene;
//! scene.settings.size = [32, 24];
//! let backend = CpuBackend::new(CpuOptions::default())?;
//! let folder = tempfile::tempdir()?;
//!
//! // Another thread may ask `cancel` to end the job; the same with `resume` goes on from there.
//! let cancel = Cancel::new();
//! let control = JobControl {
//!     on_progress: &|now| println!("{} of {} pixels", now.pixels_done, now.pixels_total),
//!     on_event: &|event| println!("{event:?}"),
//!     cancel: &cancel,
//! };
//! let mut still = Still::new(&scene, &backend).to_file(&folder.path().join("cornell.exr"))?;
//! still.resume = true;
//! let outcome = still.run(&control)?;
//! assert!(outcome.complete);
//!
//! // A turntable of the same scene: a file of each frame. `write_video` makes one file of all.
//! scene.turntable(3)?;
//! let names = FrameNames::pattern(&folder.path().join("turn_%03d.png"))?;
//! let outcome = Sequence::new(&scene, &backend).write_frames(&names, &control)?;
//! assert_eq!((outcome.done, outcome.kept), (3, 0));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Units
//!
//! Lengths are in the scene's own unit, angles in degrees, colours linear RGB. Axes are right-handed. Pixel (0, 0) is at
//! the top left.
//!
//! # A scene in code
//!
//! ```
//! use eosphor::math::{Vec3, vec3};
//! use eosphor::{Backend, Camera, CpuBackend, CpuOptions, Light, Material, MaterialKind, Scene, Sphere, render};
//!
//! let red = MaterialKind::Matte { color: vec3(0.8, 0.1, 0.1) };
//! // Light of this irradiance makes what faces it as bright as its colour.
//! let white = Vec3::splat(std::f32::consts::PI);
//! let mut scene = Scene {
//!     materials: vec![Material::new("red", red)],
//!     spheres: vec![Sphere { center: Vec3::ZERO, radius: 1.0, material: 0 }],
//!     lights: vec![Light::Directional { direction: vec3(0.0, 0.0, -1.0), color: white }],
//!     camera: Some(Camera::default()),
//!     ..Scene::default()
//! };
//! scene.settings.size = [33, 33];
//! let film = render(&scene, &CpuBackend::new(CpuOptions::default())?)?.film;
//! let middle = film.pixels[33 * 16 + 16];
//! assert!(middle.x > 0.7 && middle.y < 0.2);
//! # Ok::<(), eosphor::Error>(())
//! ```
#![warn(missing_docs)]

mod device;
mod error;
pub mod job;
mod render;

pub use device::{first_gpu, gpu_or_cpu};
pub use error::Error;
pub use render::render;

#[doc(inline)]
pub use eosphor_core::develop::{ToneCurve, Transfer};
#[doc(inline)]
pub use eosphor_core::sums::ExactSum;
#[doc(inline)]
pub use eosphor_cuda::{
    CudaBackend, CudaOptions, DeviceInfo, GpuScheduler, Traversal, devices as cuda_devices,
};
#[doc(inline)]
pub use eosphor_picture::output::{
    Format, Layer, MAX_SIDE, Metadata, OutputError, PICTURE_VERSION, Picture, PictureWriter, SaveOptions,
    Stream, Window, check_writable, explain, partial_path, save, save_developed, save_developed_within,
    save_within,
};
#[doc(inline)]
pub use eosphor_picture::{CostMap, scene_hash};
#[doc(inline)]
pub use eosphor_render::{
    Accel, Backend, BackendError, Bands, Builder, CameraSpeed, CameraWork, CpuBackend, CpuOptions,
    DevelopSettings, Developed, Fallback, FeaturePass, FeatureRows, Film, Hierarchy, HierarchyOption,
    HierarchyOptions, HierarchyStatistics, MisfitKind, OptionMisfit, PickedRows, PixelFeatures,
    PreparedRegion, PreparedRows, PreparedScene, Progress, Quality, QueryTimes, RayStatistics, Region,
    RenderControl, Rendered, RenderedBytes, SahCosts, SampleSums, Sampled, Scheduler, ShapedScene,
    ShapedScenes, SimdLevel, StageWork, build_hierarchy, check_rows, check_samples,
};
#[doc(inline)]
pub use eosphor_scene::{
    AlphaMode, Animation, BUILTINS, Body, BodyLighting, Builtin, Camera, CameraKey, CameraMotion, CannotSave,
    Channel, Composition, ConfigKey, CourseBody, CourseFloor, CourseInput, CourseLight, CourseLines,
    CourseOptions, Deformation, DeviceKind, DeviceSettings, EnvironmentMap, EnvironmentSource, FrameBounds,
    FrameState, FrameStates, Image, Instance, Interpolation, KeyUse, Law, LeftOut, Lens, Light, LightKey,
    LightMotion, LightSelection, LightUnits, LoadOptions, LoadedScene, MAX_FRAMES, Material, MaterialKind,
    MaterialTextures, Mesh, Move, MoveKey, Mtl, NO_INDEX, NormalMode, Note, Parallelogram, Pbr,
    PixelSampling, Place, Places, Preset, Problem, READ_FORMATS, RenderSettings, Scene, SceneData,
    SceneError, SceneRequests, ShapedArrays, Shapes, Sky, Snippet, Solid, Sphere, Structure, SunPosition,
    TexelLayout, Texels, Texture, TextureChannel, TextureContent, Transform, TreeBuilder, Triangle,
    UnknownPreset, UnknownSolid, View, Warning, config_keys, load, load_image, near_name, scene_over_base,
    scene_reference, scene_requests, scene_schema, sun_position,
};

/// Rendering animations to numbered files: names, the account of the frames, sharing them among processes.
pub mod frames {
    #[doc(inline)]
    pub use eosphor_picture::frames::*;
}

/// Stills in pieces, and what is kept of those that end early.
pub mod still {
    #[doc(inline)]
    pub use eosphor_picture::still::*;
}

/// Pictures in shares, which jobs that know nothing of each other render.
pub mod shares {
    #[doc(inline)]
    pub use eosphor_picture::output::{
        BAND_ROWS, ShareError, ShareHeader, ShareReader, ShareWriter, merge, share_path,
    };
}

/// Encoding animations as video (H.264 in MP4).
#[cfg(feature = "video")]
pub mod video {
    #[doc(inline)]
    pub use eosphor_picture::output::{
        FfmpegOptions, FfmpegPipe, FrameRate, InvalidFrameRate, LiveEncoder, LiveFrame, MAX_FRAMES,
        SEGMENT_FRAMES, VideoOptions, VideoWriter, check_video_size, padded_size,
    };
}

/// Queries about rays without a picture, for benchmarks.
pub mod rays {
    #[doc(inline)]
    pub use eosphor_core::ray::{Hit, PrimitiveId, Ray};
    #[doc(inline)]
    pub use eosphor_cuda::{CudaRays, Timed};
    #[doc(inline)]
    pub use eosphor_render::RaySets;
}

/// Vectors, colours and transforms.
pub mod math {
    #[doc(inline)]
    pub use eosphor_core::math::{Affine, Vec3, vec3};
}

/// Closed sets that [`RenderSettings`] chooses from.
pub mod settings {
    #[doc(inline)]
    pub use eosphor_core::settings::{FresnelMode, Integrator, LightingModel, ShadowMode};
}

/// How textures are filtered between texels and continued beyond their borders.
pub mod texture {
    #[doc(inline)]
    pub use eosphor_core::texture::{TextureFilter, TextureWrap};
}

/// Comparing two pictures: identical, or where and by how much they differ.
pub mod compare {
    #[doc(inline)]
    pub use eosphor_picture::compare::{
        CompareError, Comparison, FirstDifference, compare, difference_image,
    };
}
