//! `eosphor view SCENE`: a page that shows the scene.

use super::scene::apply;
use crate::arguments::{BackendChoice, DeviceFlags, ViewFlags};
use crate::backend::{asks_for_cpu, backend_for, check_device, cpu_options, limit_threads};
use crate::command_line::render_of_view;
use crate::failure::Failure;
use crate::streams::{self, Verbosity};
use eosphor::{
    Accel, Backend, CpuOptions, CudaOptions, LoadOptions, Scene, first_gpu, load, scene_over_base,
};
use eosphor_viewer::{Device, DeviceChoice, SceneSource, SourceError, SourceScene, Viewer, ViewerOptions};
use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::sync::{Mutex, PoisonError};

/// The scene of the command line, read with its flags.
struct FlaggedScene {
    flags: ViewFlags,
    /// What pages may choose from; the first one is what the flags ask for.
    devices: Vec<(BackendChoice, Device)>,
    /// The first reading, until the viewer takes it.
    first: Mutex<Option<SourceScene>>,
}

pub(crate) fn view(flags: &ViewFlags) -> Result<(), Failure> {
    limit_threads(&flags.device)?;
    check_device(&flags.device, flags.picture.accel)?;
    let token = token_file(flags.port).and_then(|path| std::fs::read_to_string(path).ok());
    let options = ViewerOptions { address: flags.listen, port: flags.port, token };
    // What is wrong at the start is said as by any other command.
    let first = Mutex::new(Some(load_scene(flags)?));
    let devices = devices(flags);
    let source = Box::new(FlaggedScene { flags: flags.clone(), devices, first });
    let viewer = Viewer::start(source, &options).map_err(Failure::because)?;
    keep_token(flags.port, viewer.token());
    let url = viewer.url();
    streams::result(&format!("{url}\n"))?;
    if !flags.listen.is_loopback() {
        let warning = "eosphor: warning: nothing is encrypted: whoever can read this network can see the page and its token";
        streams::message(warning);
    }
    if !flags.no_open && has_screen() {
        open_browser(&url);
    }
    streams::message("eosphor: Ctrl-C ends the viewer");
    loop {
        std::thread::park();
    }
}

fn load_scene(flags: &ViewFlags) -> Result<SourceScene, Failure> {
    let options = flags.settings.load_options(flags.camera.choice(), &flags.picture, &flags.textures);
    let loaded = load(&flags.scene, &options)?;
    loaded.warnings.iter().for_each(|warning| streams::message(&format!("eosphor: note: {warning}")));
    let mut scene = loaded.scene;
    apply(&mut scene, &flags.picture, &flags.settings, &flags.camera, &flags.textures)?;
    flags.device.check_paths()?;
    scene.settle_orbit()?;
    let mut files = loaded.files_read;
    files.extend(flags.picture.lights.environment_file().map(std::path::Path::to_path_buf));
    Ok(SourceScene { scene, files })
}

impl SceneSource for FlaggedScene {
    fn name(&self) -> String {
        self.flags.scene.display().to_string()
    }

    fn read(&self) -> Result<SourceScene, SourceError> {
        if let Some(first) = self.first.lock().unwrap_or_else(PoisonError::into_inner).take() {
            return Ok(first);
        }
        load_scene(&self.flags).map_err(|failure| {
            let line = failure.line().unwrap_or_default();
            let snippet = failure.snippet().map(|snippet| format!("\n{snippet}"));
            SourceError(line + &snippet.unwrap_or_default())
        })
    }

    fn backend(&self, choice: Option<&DeviceChoice>) -> Result<Box<dyn Backend>, SourceError> {
        let (flags, accel) = self.chosen(choice);
        backend_for(&flags, accel, false, Verbosity::Normal)
            .map_err(|failure| SourceError(failure.line().unwrap_or_default()))
    }

    fn devices(&self) -> Vec<Device> {
        self.devices.iter().map(|(_, device)| device.clone()).collect()
    }

    fn cpu_options(&self, choice: Option<&DeviceChoice>) -> CpuOptions {
        let (flags, accel) = self.chosen(choice);
        cpu_options(&flags, accel)
    }

    fn command(&self, flags: Vec<String>) -> String {
        render_of_view(flags)
    }

    fn scene_file(&self, shown: &Scene) -> Result<String, SourceError> {
        let said = |error: &dyn std::fmt::Display| SourceError(error.to_string());
        let file = &self.flags.scene;
        // Whoever saves it may put it anywhere on this machine.
        let base = match file.to_str() {
            Some(name) if name.starts_with("builtin:") => Some(name.to_owned()),
            _ => std::path::absolute(file).map_err(|error| said(&error))?.to_str().map(str::to_owned),
        };
        let base = base.ok_or_else(|| SourceError("the path of the scene is not UTF-8 text".into()))?;
        let mut options = LoadOptions::default();
        options.integrator = Some(shown.settings.integrator);
        let mut before = load(file, &options).map_err(|error| said(&error))?.scene;
        before.settle_orbit().map_err(|error| said(&error))?;
        let lights = &self.flags.picture.lights;
        let file = lights.environment_file().map(std::path::absolute).transpose();
        let file = file.map_err(|error| said(&error))?;
        let environment = file.or_else(|| lights.environment().map(std::path::Path::to_path_buf));
        let environment = environment.as_deref().and_then(std::path::Path::to_str);
        scene_over_base(&base, &before, shown, environment).map_err(|error| said(&error))
    }
}

impl FlaggedScene {
    /// The flags of the device and the hierarchy, as a page has chosen them. Names that are none change nothing.
    fn chosen(&self, choice: Option<&DeviceChoice>) -> (DeviceFlags, Option<Accel>) {
        let (mut flags, mut accel) = (self.flags.device.clone(), self.flags.picture.accel);
        let Some(choice) = choice else { return (flags, accel) };
        if let Some((backend, _)) = self.devices.iter().find(|(_, device)| device.backend == choice.backend) {
            flags.backend = Some(backend.clone());
        }
        accel = choice.accel.parse().ok().or(accel);
        (flags, accel)
    }
}

/// What pages may choose from. Without a hierarchy no frame would come in time.
fn devices(flags: &ViewFlags) -> Vec<(BackendChoice, Device)> {
    let asked = flags.picture.accel;
    let device = |backend: BackendChoice, name: String, default: Accel, suits: fn(Accel) -> bool| {
        let first = asked.filter(|&accel| suits(accel)).unwrap_or(default);
        let others = Accel::ALL.iter().copied().filter(|&accel| accel != first && accel != Accel::None);
        let accels = std::iter::once(first).chain(others.filter(|&accel| suits(accel)));
        (backend, Device { backend: name, accels: accels.map(|accel| accel.name().to_owned()).collect() })
    };
    let cpu = || device(BackendChoice::Cpu, "cpu".into(), CpuOptions::default().accel, |_| true);
    let gpu = |numbers: Vec<usize>| {
        let names: Vec<String> = numbers.iter().map(usize::to_string).collect();
        let name = if names.is_empty() { "cuda".into() } else { format!("cuda:{}", names.join(",")) };
        let suits = |accel| accel != Accel::Bvh8;
        device(BackendChoice::Cuda(numbers), name, CudaOptions::default().accel, suits)
    };
    let has_gpu = first_gpu().is_some();
    match flags.device.backend() {
        BackendChoice::Cuda(numbers) => vec![gpu(numbers.clone()), cpu()],
        BackendChoice::Auto if has_gpu && !asks_for_cpu(&flags.device, asked) => vec![gpu(Vec::new()), cpu()],
        BackendChoice::Auto | BackendChoice::Cpu if has_gpu => vec![cpu(), gpu(Vec::new())],
        BackendChoice::Auto | BackendChoice::Cpu => vec![cpu()],
    }
}

/// Where the token of a port is kept that the user has named, so that its pages find the next viewer there.
fn token_file(port: u16) -> Option<PathBuf> {
    let folder = |name: &str| std::env::var_os(name).filter(|value| !value.is_empty()).map(PathBuf::from);
    let state = folder("XDG_STATE_HOME").or_else(|| Some(folder("HOME")?.join(".local/state")))?;
    (port != 0).then(|| state.join(format!("eosphor/view-{port}.token")))
}

/// Keeps a token where only this user can read it. Where that fails, the next viewer has a token of its own.
#[cfg(unix)]
fn keep_token(port: u16, token: &str) {
    use std::io::Write;
    use std::os::unix::fs::{DirBuilderExt, OpenOptionsExt};
    let Some(path) = token_file(port) else { return };
    let Some(folder) = path.parent() else { return };
    let _ = std::fs::DirBuilder::new().recursive(true).mode(0o700).create(folder);
    // A file that others can read, or that leads elsewhere, is not written to.
    let _ = std::fs::remove_file(&path);
    let mut options = std::fs::OpenOptions::new();
    if let Ok(mut file) = options.write(true).create_new(true).mode(0o600).open(&path) {
        let _ = file.write_all(token.as_bytes());
    }
}

#[cfg(not(unix))]
fn keep_token(_port: u16, _token: &str) {}

/// Whether a browser could be seen on this machine.
fn has_screen() -> bool {
    let is_set = |name| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    cfg!(not(target_os = "linux")) || is_set("DISPLAY") || is_set("WAYLAND_DISPLAY")
}

/// Opens the page; where that fails, its address has been printed.
fn open_browser(url: &str) {
    let mut command = match std::env::consts::OS {
        "macos" => Command::new("open"),
        "windows" => Command::new("explorer"),
        _ => Command::new("xdg-open"),
    };
    command.arg(url).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    if command.spawn().is_err() {
        streams::message("eosphor: note: no browser was found; open the address in one");
    }
}
