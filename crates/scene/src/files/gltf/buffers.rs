//! The bytes that a file speaks of: its buffers, and the views into them.

use super::Part;
use super::document::Document;
use super::uri;
use crate::files::loader::Loader;
use std::borrow::Cow;
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// All buffers, read. One that is missing or broken is an error only where it is used.
pub(super) struct Buffers<'a> {
    root: &'a Document,
    /// Of each buffer, the number of its bytes.
    numbers: Vec<Result<usize, String>>,
    bytes: Vec<Cow<'a, [u8]>>,
}

/// A part of a buffer.
pub(super) struct View<'a> {
    pub(super) bytes: &'a [u8],
    /// Bytes from one element to the next, where the file says.
    pub(super) stride: Option<usize>,
}

impl<'a> Buffers<'a> {
    /// Reads all buffers; several that name one file share its bytes.
    pub(super) fn read(
        loader: &mut Loader,
        path: &Path,
        root: &'a Document,
        binary: Option<&'a [u8]>,
    ) -> Self {
        let folder = path.parent().unwrap_or(Path::new(""));
        let mut buffers = Buffers { root, numbers: Vec::new(), bytes: Vec::new() };
        let mut files: HashMap<PathBuf, Result<usize, String>> = HashMap::new();
        for (number, buffer) in root.buffers.iter().enumerate() {
            let found = match (&buffer.uri, binary) {
                (Some(uri), _) => match uri::data(uri) {
                    Some(data) => data.map(|bytes| buffers.add(Cow::Owned(bytes))),
                    None => match find(loader, folder, uri) {
                        Err(problem) => Err(problem),
                        Ok(file) => files
                            .entry(file.clone())
                            .or_insert_with(|| {
                                loader.read(&file).map(|b| buffers.add(b)).map_err(|e| e.to_string())
                            })
                            .clone(),
                    },
                },
                (None, Some(binary)) if number == 0 => Ok(buffers.add(Cow::Borrowed(binary))),
                (None, _) => {
                    Err("it has neither a uri nor bytes in a GLB file; export the file again".into())
                }
            };
            let name = Part::new("buffer", number, buffer.name.as_deref());
            buffers.numbers.push(found.map_err(|problem| format!("{name}: {problem}")));
        }
        buffers
    }

    fn add(&mut self, bytes: Cow<'a, [u8]>) -> usize {
        self.bytes.push(bytes);
        self.bytes.len() - 1
    }

    /// How many bytes were read.
    pub(super) fn total(&self) -> u64 {
        self.bytes.iter().map(|b| b.len() as u64).sum()
    }

    /// A view, checked to lie within its buffer.
    pub(super) fn view(&self, number: usize) -> Result<View<'_>, String> {
        let view = self.root.buffer_views.get(number).ok_or_else(|| {
            format!("bufferView {number} does not exist; there are {}", self.root.buffer_views.len())
        })?;
        let name = || Part::new("bufferView", number, view.name.as_deref());
        let buffer = view.buffer.value();
        let bytes = match self.numbers.get(buffer) {
            Some(found) => &self.bytes[*found.as_ref().map_err(Clone::clone)?],
            None => {
                let count = self.numbers.len();
                return Err(format!("{}: buffer {buffer} does not exist; there are {count}", name()));
            }
        };
        let start = view.byte_offset.unwrap_or_default();
        let within = part(bytes, start, view.byte_length).ok_or_else(|| {
            let (length, has) = (view.byte_length, bytes.len());
            format!(
                "{}: bytes {start} to {} of buffer {buffer}, which has {has}; get the buffer again",
                name(),
                u128::from(start) + u128::from(length)
            )
        })?;
        Ok(View { bytes: within, stride: view.byte_stride.filter(|&stride| stride != 0) })
    }
}

/// The file that a uri names, beside the glTF: percent codes resolved, else as written.
pub(super) fn find(loader: &Loader, folder: &Path, uri: &str) -> Result<PathBuf, String> {
    if uri::is_remote(uri) {
        return Err(format!("{} is not on this machine; get it and name the file", super::quoted(uri)));
    }
    let decoded = uri::percent_decoded(uri);
    loader.find(folder, &decoded).or_else(|| loader.find(folder, uri.as_bytes())).ok_or_else(|| {
        format!("{} is missing; put it beside the glTF", super::quoted(&String::from_utf8_lossy(&decoded)))
    })
}

/// `length` bytes from `start`, where there are so many.
pub(super) fn part(bytes: &[u8], start: u64, length: u64) -> Option<&[u8]> {
    let start = usize::try_from(start).ok()?;
    let end = start.checked_add(usize::try_from(length).ok()?)?;
    bytes.get(start..end)
}
