//! The data folder: a mesh, sets of rays, and Eosphor's closest hits.

use std::fs::{self, File};
use std::io::Read;
use std::path::Path;

/// Three corners.
pub type Triangle = [[f32; 3]; 3];

/// A ray as it lies in a file.
#[derive(Clone, Copy, Debug)]
pub struct Ray {
    /// Where it starts.
    pub origin: [f32; 3],
    /// Hits nearer than this do not count.
    pub t_min: f32,
    /// Of length 1.
    pub direction: [f32; 3],
    /// Hits farther than this do not count. May be infinite.
    pub t_max: f32,
}

/// A closest hit.
#[derive(Clone, Copy, Debug)]
pub struct Hit {
    /// Distance.
    pub t: f32,
    /// Which triangle of the mesh, or [`MISS`].
    pub triangle: u32,
}

/// The triangle of a ray that meets none.
pub const MISS: u32 = u32::MAX;

/// The sets of rays, in the order in which they are measured.
pub(crate) const SETS: [&str; 3] = ["primary", "bounce", "shuffled"];

pub(crate) struct RaySet {
    pub name: &'static str,
    /// Neighbours in the file take similar ways.
    pub coherent: bool,
    pub rays: Vec<Ray>,
    /// The triangles that Eosphor finds.
    pub expected: Vec<u32>,
}

pub(crate) struct Data {
    pub mesh: Vec<Triangle>,
    pub sets: Vec<RaySet>,
}

impl Data {
    pub fn read(folder: &Path) -> Result<Self, String> {
        let mesh = read_mesh(&folder.join("mesh.tris"))?;
        let sets = SETS
            .into_iter()
            .map(|name| {
                let rays = read_rays(&folder.join(format!("{name}.rays")))?;
                let expected = read_hits(&folder.join(format!("{name}.hits")), rays.len(), mesh.len())?;
                Ok(RaySet { name, coherent: name == "primary", rays, expected })
            })
            .collect::<Result<_, String>>()?;
        Ok(Self { mesh, sets })
    }
}

fn read_mesh(path: &Path) -> Result<Vec<Triangle>, String> {
    let mesh: Vec<Triangle> = records(path)?
        .into_iter()
        .map(|words: [u32; 9]| {
            let [a, b, c, d, e, f, g, h, i] = words.map(f32::from_bits);
            [[a, b, c], [d, e, f], [g, h, i]]
        })
        .collect();
    // Some libraries stop with a panic at these, which would be no clear message.
    match mesh.iter().position(|triangle| !triangle.as_flattened().iter().all(|x| x.is_finite())) {
        Some(at) => Err(format!("{}: triangle {at} has a corner that is not finite", path.display())),
        None => Ok(mesh),
    }
}

fn read_rays(path: &Path) -> Result<Vec<Ray>, String> {
    let rays: Vec<Ray> = records(path)?
        .into_iter()
        .map(|words: [u32; 8]| {
            let [x, y, z, t_min, dx, dy, dz, t_max] = words.map(f32::from_bits);
            Ray { origin: [x, y, z], t_min, direction: [dx, dy, dz], t_max }
        })
        .collect();
    let is_good = |ray: &Ray| {
        let finite = ray.origin.iter().chain(&ray.direction).all(|x| x.is_finite());
        let length = ray.direction.iter().map(|x| f64::from(*x).powi(2)).sum::<f64>().sqrt();
        // Distances of libraries that normalise are compared with those of libraries that do not.
        finite && (length - 1.0).abs() < 1e-3 && ray.t_min >= 0.0 && ray.t_max >= ray.t_min
    };
    match rays.iter().position(|ray| !is_good(ray)) {
        Some(at) => Err(format!("{}: ray {at} is none: {:?}", path.display(), rays[at])),
        None => Ok(rays),
    }
}

/// The triangles of as many hits as there are rays.
fn read_hits(path: &Path, rays: usize, triangles: usize) -> Result<Vec<u32>, String> {
    let hits: Vec<u32> = records(path)?.into_iter().map(|[_, triangle]: [u32; 2]| triangle).collect();
    if hits.len() != rays {
        return Err(format!("{}: {} hits for {rays} rays", path.display(), hits.len()));
    }
    match hits.iter().find(|&&triangle| triangle != MISS && triangle as usize >= triangles) {
        Some(triangle) => Err(format!("{}: triangle {triangle} of {triangles}", path.display())),
        None => Ok(hits),
    }
}

/// A count, then as many records of `N` words. The length is compared before anything is allocated.
fn records<const N: usize>(path: &Path) -> Result<Vec<[u32; N]>, String> {
    let fail = |what: &dyn std::fmt::Display| format!("{}: {what}", path.display());
    // Asked before opening: to open a pipe would wait for a writer.
    let about = fs::metadata(path).map_err(|error| fail(&error))?;
    if !about.is_file() {
        return Err(fail(&"is not a file"));
    }
    let mut file = File::open(path).map_err(|error| fail(&error))?;
    let mut count = [0; 4];
    file.read_exact(&mut count).map_err(|_| fail(&"is too short for a count"))?;
    let count = u32::from_le_bytes(count);
    let needed = u64::from(count) * 4 * N as u64;
    if about.len() != needed + 4 {
        return Err(fail(&format!("has {} bytes; its count of {count} needs {}", about.len(), needed + 4)));
    }
    if count == 0 {
        return Err(fail(&"is empty"));
    }
    let mut bytes = Vec::new();
    file.take(needed).read_to_end(&mut bytes).map_err(|error| fail(&error))?;
    if bytes.len() as u64 != needed {
        return Err(fail(&"became shorter while it was read"));
    }
    let (words, _) = bytes.as_chunks::<4>();
    let (records, _) = words.as_chunks::<N>();
    Ok(records.iter().map(|record| record.map(u32::from_le_bytes)).collect())
}
