//! Known answers of small files that are made here.

mod animations;
mod fuzz;
mod geometry;
mod materials;
mod oracle;
mod samplers;
mod scenes;
mod skins;
mod wrong;

use crate::error::SceneError;
use crate::files::source::Source;
use crate::files::{LoadOptions, LoadedScene, load_from};
use eosphor_core::settings::Integrator;
use serde_json::{Value, json};
use std::borrow::Cow;
use std::path::{Path, PathBuf};

/// Component types by their numbers in the file.
const I8: u32 = 5120;
const U8: u32 = 5121;
const I16: u32 = 5122;
const U16: u32 = 5123;
const U32: u32 = 5125;
const F32: u32 = 5126;

/// A file in the making: arrays go into one buffer, the rest is JSON.
struct File {
    root: Value,
    buffer: Vec<u8>,
}

impl File {
    /// The rest of the JSON, without version, accessors and buffers.
    fn new(rest: Value) -> File {
        let mut root = rest;
        for (key, value) in [("accessors", json!([])), ("bufferViews", json!([]))] {
            root[key] = value;
        }
        root["asset"] = json!({"version": "2.0"});
        File { root, buffer: Vec::new() }
    }

    /// One mesh of one primitive in one node, and further keys of the primitive.
    fn of_primitive(primitive: Value) -> File {
        File::new(json!({"nodes": [{"mesh": 0}], "meshes": [{"primitives": [primitive]}]}))
    }

    /// Adds a view; its number.
    fn view(&mut self, bytes: &[u8], stride: Option<u32>) -> usize {
        self.buffer.resize(self.buffer.len().next_multiple_of(4), 0);
        let mut view = json!({"buffer": 0, "byteOffset": self.buffer.len(), "byteLength": bytes.len()});
        if let Some(stride) = stride {
            view["byteStride"] = stride.into();
        }
        self.buffer.extend_from_slice(bytes);
        push(&mut self.root["bufferViews"], view)
    }

    /// Adds an accessor of a view of its own; its number.
    fn accessor(&mut self, component: u32, kind: &str, count: usize, bytes: &[u8]) -> usize {
        let view = self.view(bytes, None);
        self.raw_accessor(
            json!({"bufferView": view, "componentType": component, "type": kind, "count": count}),
        )
    }

    fn raw_accessor(&mut self, accessor: Value) -> usize {
        push(&mut self.root["accessors"], accessor)
    }

    /// Adds an accessor of vectors.
    fn floats<const N: usize>(&mut self, values: &[[f32; N]]) -> usize {
        let kind = ["SCALAR", "VEC2", "VEC3", "VEC4"][N - 1];
        self.accessor(F32, kind, values.len(), &bytes(values.as_flattened()))
    }

    /// Adds indices of two bytes.
    fn indices(&mut self, values: &[u16]) -> usize {
        let bytes: Vec<u8> = values.iter().flat_map(|i| i.to_le_bytes()).collect();
        self.accessor(U16, "SCALAR", values.len(), &bytes)
    }

    fn glb(&self) -> Vec<u8> {
        let mut root = self.root.clone();
        root["buffers"] = json!([{"byteLength": self.buffer.len()}]);
        glb(&root.to_string(), &self.buffer)
    }

    fn load(&self) -> LoadedScene {
        read(&[("a.glb", &self.glb())]).unwrap_or_else(|e| panic!("{e}"))
    }

    fn error(&self) -> String {
        read(&[("a.glb", &self.glb())]).unwrap_err().to_string()
    }

    fn warnings(&self) -> Vec<String> {
        self.load().warnings.iter().map(|w| w.to_string()).collect()
    }
}

fn push(array: &mut Value, value: Value) -> usize {
    let array = array.as_array_mut().unwrap();
    array.push(value);
    array.len() - 1
}

fn bytes(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|x| x.to_le_bytes()).collect()
}

fn glb(json: &str, binary: &[u8]) -> Vec<u8> {
    let mut json = json.as_bytes().to_vec();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut file = b"glTF\x02\0\0\0".to_vec();
    let word = |n: usize| (n as u32).to_le_bytes();
    file.extend(word(28 + json.len() + binary.len()));
    file.extend(word(json.len()));
    file.extend(b"JSON");
    file.extend(json);
    file.extend(word(binary.len()));
    file.extend(b"BIN\0");
    file.extend(binary);
    file
}

/// Loads the first of some files in memory.
fn read_with(files: &[(&str, &[u8])], options: &LoadOptions) -> Result<LoadedScene, SceneError> {
    let first = PathBuf::from(files[0].0);
    let files = files.iter().map(|(name, bytes)| (PathBuf::from(name), Cow::Owned(bytes.to_vec())));
    load_from(Source::Memory(files.collect()), Path::new(&first), options)
}

fn read(files: &[(&str, &[u8])]) -> Result<LoadedScene, SceneError> {
    read_with(files, &LoadOptions::default())
}

/// As what Whitted's method renders.
fn whitted() -> LoadOptions {
    LoadOptions { integrator: Some(Integrator::Whitted), ..LoadOptions::default() }
}

/// Three corners of a triangle in the plane z = 0.
const CORNERS: [[f32; 3]; 3] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

/// A file with one triangle, and more keys of the root.
fn triangle(more: Value) -> File {
    let mut file = File::of_primitive(json!({"attributes": {"POSITION": 0}}));
    file.floats(&CORNERS);
    for (key, value) in more.as_object().unwrap() {
        file.root[key] = value.clone();
    }
    file
}
