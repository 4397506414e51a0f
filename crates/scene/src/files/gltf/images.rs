//! Pictures of the file, decoded side by side.

use super::Part;
use super::buffers::{Buffers, find};
use super::document::Document;
use super::uri;
use crate::files::images::{self, Header, Picture};
use crate::files::loader::Loader;
use rayon::prelude::*;
use std::borrow::Cow;
use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};

/// Numbers of the model's images.
#[derive(Default)]
pub(super) struct Images {
    /// By the file's number; those that are missing or broken are not here.
    numbers: HashMap<usize, u32>,
}

/// Where a picture is. Two of the file's images at one place are one image.
#[derive(Clone, PartialEq, Eq, Hash)]
enum Place {
    File(PathBuf),
    View(usize),
    /// Written into the image of this number.
    Data(usize),
}

/// A picture to decode.
struct Job<'a> {
    place: Place,
    name: String,
    bytes: Cow<'a, [u8]>,
    header: Header,
    /// Whether the textures' budget admits it.
    fits: bool,
}

impl Images {
    pub(super) fn number(&self, image: usize) -> Option<u32> {
        self.numbers.get(&image).copied()
    }

    /// Reads the wanted images, in this order. What is missing or broken warns.
    pub(super) fn read(
        loader: &mut Loader,
        path: &Path,
        root: &Document,
        buffers: &Buffers<'_>,
        wanted: &[usize],
    ) -> Images {
        let mut numbers: HashMap<Place, u32> = HashMap::new();
        let mut seen = HashSet::new();
        let mut places = Vec::new();
        let mut jobs: Vec<Job<'_>> = Vec::new();
        let mut broken: HashMap<Place, String> = HashMap::new();
        for &image in wanted {
            let place = match place(loader, path, root, image) {
                Ok(place) => place,
                Err(problem) => {
                    warn(loader, path, root, image, &problem);
                    continue;
                }
            };
            places.push((image, place.clone()));
            if let Place::File(file) = &place
                && let Some(known) = loader.known_image(file)
            {
                numbers.insert(place, known);
                continue;
            }
            if !seen.insert(place.clone()) {
                continue;
            }
            let bytes = match bytes(loader, root, buffers, &place) {
                Ok(bytes) => bytes,
                Err(problem) => {
                    warn(loader, path, root, image, &problem);
                    continue;
                }
            };
            let name = name(root, image, &place);
            match images::header(&bytes, &name) {
                Ok(header) => {
                    let fits = loader.admits(&header, || match &place {
                        Place::File(file) => file.display().to_string(),
                        _ => format!("{}: {name}", path.display()),
                    });
                    jobs.push(Job { place, name, bytes, header, fits });
                }
                Err(problem) => drop(broken.insert(place, problem)),
            }
        }
        // Decoding takes nearly all the time; what it gives is put in the order of the jobs.
        let decode = |job: &Job<'_>| match job.fits {
            true => images::decode(&job.bytes, &job.name),
            false => Ok(Picture::white()),
        };
        let pictures: Vec<Result<Picture, String>> = jobs.par_iter().map(decode).collect();
        for (job, picture) in jobs.into_iter().zip(pictures) {
            match picture {
                Ok(picture) => {
                    let file = if let Place::File(file) = &job.place { Some(file.as_path()) } else { None };
                    let number = loader.add_image(file, job.name, picture);
                    numbers.insert(job.place, number);
                }
                Err(problem) => {
                    loader.release(&job.header);
                    broken.insert(job.place, problem);
                }
            }
        }
        let mut images = Images::default();
        for (image, place) in places {
            if let Some(&number) = numbers.get(&place) {
                images.numbers.insert(image, number);
            } else if let Some(problem) = broken.get(&place) {
                warn(loader, path, root, image, problem);
            }
        }
        images
    }
}

fn place(loader: &Loader, path: &Path, root: &Document, number: usize) -> Result<Place, String> {
    let image = root.images.get(number).ok_or("it does not exist")?;
    match (&image.uri, image.buffer_view) {
        (Some(uri), _) if uri.get(..5).is_some_and(|s| s.eq_ignore_ascii_case("data:")) => {
            Ok(Place::Data(number))
        }
        (Some(uri), _) => find(loader, path.parent().unwrap_or(Path::new("")), uri).map(Place::File),
        (None, Some(view)) => Ok(Place::View(view.value())),
        (None, None) => Err("it has neither a uri nor a bufferView".into()),
    }
}

fn bytes<'a>(
    loader: &mut Loader,
    root: &Document,
    buffers: &'a Buffers<'_>,
    place: &Place,
) -> Result<Cow<'a, [u8]>, String> {
    match place {
        Place::File(file) => loader.read(file).map_err(|e| e.to_string()),
        Place::View(view) => buffers.view(*view).map(|view| Cow::Borrowed(view.bytes)),
        Place::Data(image) => {
            let uri = root.images.get(*image).and_then(|image| image.uri.as_deref()).unwrap_or_default();
            uri::data(uri).unwrap_or_else(|| Err("no data".into())).map(Cow::Owned)
        }
    }
}

/// For messages: the file's name, else the image's.
fn name(root: &Document, number: usize, place: &Place) -> String {
    match place {
        Place::File(file) => file.file_name().unwrap_or_default().to_string_lossy().into_owned(),
        _ => match root.images.get(number).and_then(|image| image.name.as_deref()) {
            Some(name) => super::clean(name),
            None => format!("image {number}"),
        },
    }
}

fn warn(loader: &mut Loader, path: &Path, root: &Document, number: usize, problem: &str) {
    let name = root.images.get(number).and_then(|image| image.name.as_deref());
    let message = format!("{}: {problem}; the surface is untextured", Part::new("image", number, name));
    loader.warnings.add(path, None, message);
}
