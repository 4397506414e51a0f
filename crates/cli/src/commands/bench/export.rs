//! Triangles, rays and hits as files, for programs that measure other libraries (`peers/`).

use crate::failure::Failure;
use eosphor::SceneData;
use eosphor::rays::{Hit, Ray};
use std::fs::{self, File};
use std::io::{BufWriter, Error, Write};
use std::path::Path;

/// What stands for the triangle of a ray that hits nothing.
const MISS: u32 = u32::MAX;

/// Writes `mesh.tris`, and `SET.rays` and `SET.hits` of each set; `peers/README.md` has their form.
pub(super) fn export(
    folder: &Path,
    data: &SceneData,
    sets: [(&str, &Vec<Ray>); 3],
    closest_hits: impl Fn(&[Ray]) -> Vec<Hit>,
) -> Result<(), Failure> {
    if !data.spheres.is_empty() || data.instances.len() > 1 {
        let problem = "--export needs a scene of triangles alone, without spheres and placed models";
        return Err(Failure::usage(problem));
    }
    let cannot = |error: Error| Failure::Failed(format!("cannot write to {}: {error}", folder.display()));
    fs::create_dir_all(folder).map_err(cannot)?;
    let triangles =
        data.triangles.iter().map(|corners| corners.iter().flat_map(|p| [p.x, p.y, p.z]).collect());
    write(&folder.join("mesh.tris"), data.triangles.len(), triangles).map_err(cannot)?;
    for (name, rays) in sets {
        let of_ray = |ray: &Ray| {
            let (o, d) = (ray.origin, ray.direction);
            vec![o.x, o.y, o.z, ray.t_min, d.x, d.y, d.z, ray.t_max]
        };
        write(&folder.join(format!("{name}.rays")), rays.len(), rays.iter().map(of_ray)).map_err(cannot)?;
        let of_hit = |hit: &Hit| match hit.is_miss() {
            true => vec![f32::INFINITY, f32::from_bits(MISS)],
            false => vec![hit.t, f32::from_bits(hit.id.primitive)],
        };
        let hits = closest_hits(rays);
        write(&folder.join(format!("{name}.hits")), rays.len(), hits.iter().map(of_hit)).map_err(cannot)?;
    }
    Ok(())
}

/// A count, and so many rows of numbers.
fn write(path: &Path, count: usize, rows: impl Iterator<Item = Vec<f32>>) -> Result<(), Error> {
    let mut file = BufWriter::new(File::create(path)?);
    let count = u32::try_from(count).map_err(|_| Error::other("more than 4 billion of them"))?;
    file.write_all(&count.to_le_bytes())?;
    for row in rows {
        row.iter().try_for_each(|number| file.write_all(&number.to_bits().to_le_bytes()))?;
    }
    file.flush()
}
