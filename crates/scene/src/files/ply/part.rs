//! Vertices and triangles of a run of rows. Runs are read side by side and joined in the order of the file.

use super::role::{COLOR, Kind, NORMAL, POSITION, Plan, SLOTS, UV};
use super::rows::Fault;
use crate::files::face_ranges::Polygon;
use crate::model::{MAX_COORDINATE, NO_INDEX, Triangle};
use eosphor_core::math::{Vec3, vec3};

/// A line, where there are lines, and the number of a row.
pub(super) type Place = (Option<u32>, u64);

#[derive(Default)]
pub(super) struct Part {
    pub(super) positions: Vec<Vec3>,
    pub(super) normals: Vec<Vec3>,
    pub(super) colors: Vec<[f32; 4]>,
    pub(super) uvs: Vec<[f32; 2]>,
    /// u and v of corners, where faces have them.
    pub(super) corner_uvs: Vec<[f32; 2]>,
    /// [`Triangle::material`] is the number of a picture here.
    pub(super) triangles: Vec<Triangle>,
    /// Faces of more than three corners.
    pub(super) polygons: Vec<Polygon>,
    /// The largest index and the face it is of: vertices may come after the faces.
    pub(super) largest: Option<(u32, &'static str, Place)>,
    pub(super) oddities: Oddities,
}

/// How often something odd was met.
#[derive(Clone, Copy, Default)]
pub(super) struct Oddities {
    /// Faces with fewer than 3 corners.
    pub(super) small_faces: u64,
    /// Normals, colours or texture coordinates that are not finite.
    pub(super) not_finite: u64,
    /// Rows of text with more numbers than properties.
    pub(super) long_rows: u64,
}

impl Part {
    #[inline]
    pub(super) fn vertex(&mut self, plan: &Plan, slots: &[f32; SLOTS]) -> Result<(), String> {
        let of = |first: usize| vec3(slots[first], slots[first + 1], slots[first + 2]);
        let p = of(POSITION);
        check_position(p)?;
        self.positions.push(p);
        let mut harmless = |finite: bool| {
            self.oddities.not_finite += u64::from(!finite);
            finite
        };
        if plan.normals {
            // A normal without a length is that of the triangle.
            let n = of(NORMAL);
            self.normals.push(if harmless(n.is_finite()) { n } else { Vec3::ZERO });
        }
        if plan.colors {
            let c = [slots[COLOR], slots[COLOR + 1], slots[COLOR + 2], slots[COLOR + 3]];
            self.colors.push(if harmless(c.iter().all(|x| x.is_finite())) { c } else { [1.0; 4] });
        }
        if plan.uvs {
            let uv = [slots[UV], slots[UV + 1]];
            self.uvs.push(if harmless(uv.iter().all(|x| x.is_finite())) { uv } else { [0.0; 2] });
        }
        Ok(())
    }

    /// A polygon as a fan of triangles.
    #[inline]
    pub(super) fn face(
        &mut self,
        plan: &Plan,
        indices: &[i64],
        corner_uvs: &[f32],
        picture: i64,
        place: Place,
    ) -> Result<(), String> {
        if indices.len() < 3 {
            self.oddities.small_faces += 1;
            return Ok(());
        }
        for &index in indices {
            self.index(index, "face", place)?;
        }
        let first_uv = if plan.corner_uvs { self.corner_uvs(indices.len(), corner_uvs)? } else { None };
        let material = u32::try_from(picture).unwrap_or(0);
        if indices.len() > 3 {
            let (first_triangle, triangles) = (self.triangles.len() as u32, indices.len() as u32 - 2);
            self.polygons.push(Polygon { first_triangle, triangles });
        }
        for k in 1..indices.len() - 1 {
            let positions = [indices[0], indices[k], indices[k + 1]].map(|i| i as u32);
            let mut triangle = triangle(plan, positions, material);
            if let Some(first) = first_uv {
                triangle.uvs = [first, first + k as u32, first + k as u32 + 1];
            }
            self.triangles.push(triangle);
        }
        Ok(())
    }

    /// Adds the texture coordinates of a polygon's corners; the number of the first.
    fn corner_uvs(&mut self, corners: usize, list: &[f32]) -> Result<Option<u32>, String> {
        if list.len() != corners * 2 {
            return Ok(None);
        }
        let first = self.corner_uvs.len();
        for uv in list.chunks_exact(2) {
            let finite = uv.iter().all(|x| x.is_finite());
            self.oddities.not_finite += u64::from(!finite);
            self.corner_uvs.push(if finite { [uv[0], uv[1]] } else { [0.0; 2] });
        }
        if self.corner_uvs.len() >= NO_INDEX as usize {
            return Err(TOO_MANY_UVS.into());
        }
        Ok(Some(first as u32))
    }

    /// Strips of triangles, divided by -1. Every second triangle of a strip runs the other way round.
    pub(super) fn strip(&mut self, plan: &Plan, indices: &[i64], place: Place) -> Result<(), String> {
        // An unsigned type writes -1 as its largest number.
        let restarts = |&i: &i64| i < 0 || i == i64::from(NO_INDEX);
        for strip in indices.split(restarts) {
            for &index in strip {
                self.index(index, "strip", place)?;
            }
            for (k, corners) in strip.windows(3).enumerate() {
                let [a, b, c] = [corners[0], corners[1], corners[2]].map(|i| i as u32);
                // Repeated vertices only turn a strip.
                if a != b && b != c && c != a {
                    let positions = if k % 2 == 0 { [a, b, c] } else { [b, a, c] };
                    self.triangles.push(triangle(plan, positions, 0));
                }
            }
        }
        Ok(())
    }

    #[inline]
    fn index(&mut self, index: i64, what: &'static str, place: Place) -> Result<(), String> {
        if !(0..i64::from(NO_INDEX)).contains(&index) {
            return Err(format!("vertex index {index} is out of range"));
        }
        let index = index as u32;
        if self.largest.is_none_or(|(largest, ..)| index > largest) {
            self.largest = Some((index, what, place));
        }
        Ok(())
    }

    /// Makes room for rows of an element, which are known to be there.
    pub(super) fn reserve(&mut self, kind: Kind, plan: &Plan, rows: usize) {
        match kind {
            Kind::Vertex => {
                self.positions.reserve(rows);
                self.normals.reserve(if plan.normals { rows } else { 0 });
                self.colors.reserve(if plan.colors { rows } else { 0 });
                self.uvs.reserve(if plan.uvs { rows } else { 0 });
            }
            Kind::Face => self.triangles.reserve(rows),
            Kind::Strips | Kind::Other => {}
        }
    }

    /// Parts in the order of the file as one; else what is wrong in the first that is.
    pub(super) fn joined(parts: Vec<Result<Part, Fault>>) -> Result<Part, Fault> {
        let parts: Vec<Part> = parts.into_iter().collect::<Result<_, _>>()?;
        let mut whole = Part::default();
        if parts.len() > 1 {
            whole.positions.reserve_exact(parts.iter().map(|p| p.positions.len()).sum());
            whole.triangles.reserve_exact(parts.iter().map(|p| p.triangles.len()).sum());
        }
        for part in parts {
            whole.append(part)?;
        }
        Ok(whole)
    }

    /// Adds what comes later in the file.
    pub(super) fn append(&mut self, later: Part) -> Result<(), Fault> {
        let first_uv = self.corner_uvs.len();
        if first_uv + later.corner_uvs.len() >= NO_INDEX as usize {
            return Err(Fault { line: None, message: TOO_MANY_UVS.into() });
        }
        let has_corner_uvs = !later.corner_uvs.is_empty();
        let first_triangle = self.triangles.len();
        join(&mut self.positions, later.positions);
        join(&mut self.normals, later.normals);
        join(&mut self.colors, later.colors);
        join(&mut self.uvs, later.uvs);
        join(&mut self.corner_uvs, later.corner_uvs);
        let (before, more) = (self.polygons.len(), later.polygons);
        join(&mut self.polygons, more);
        self.polygons[before..].iter_mut().for_each(|p| p.first_triangle += first_triangle as u32);
        join(&mut self.triangles, later.triangles);
        if has_corner_uvs && first_uv > 0 {
            for uv in self.triangles[first_triangle..].iter_mut().flat_map(|t| &mut t.uvs) {
                if *uv != NO_INDEX {
                    *uv += first_uv as u32;
                }
            }
        }
        if let Some(later) = later.largest
            && self.largest.is_none_or(|(largest, ..)| later.0 > largest)
        {
            self.largest = Some(later);
        }
        self.oddities.small_faces += later.oddities.small_faces;
        self.oddities.not_finite += later.oddities.not_finite;
        self.oddities.long_rows += later.oddities.long_rows;
        Ok(())
    }
}

const TOO_MANY_UVS: &str = "too many texture coordinates; the limit is 2^32 - 2";

/// Moves the first one where no room is made yet: it is often the only one.
fn join<T>(all: &mut Vec<T>, mut later: Vec<T>) {
    if all.capacity() == 0 { *all = later } else { all.append(&mut later) }
}

/// Whether a vertex is where single precision can square.
#[inline]
pub(super) fn check_position(p: Vec3) -> Result<(), String> {
    let [x, y, z] = [p.x, p.y, p.z];
    if [x, y, z].iter().all(|c| c.abs() <= MAX_COORDINATE) {
        return Ok(());
    }
    if p.is_finite() {
        return Err(format!(
            "({x:e}, {y:e}, {z:e}) is out of range; coordinates must be within {MAX_COORDINATE:e}"
        ));
    }
    Err(format!("({x}, {y}, {z}) is no point; coordinates must be finite numbers; mend the file"))
}

/// Normals and texture coordinates of vertices have the vertex's index.
#[inline]
pub(super) fn triangle(plan: &Plan, positions: [u32; 3], material: u32) -> Triangle {
    Triangle {
        positions,
        normals: if plan.normals { positions } else { [NO_INDEX; 3] },
        uvs: if plan.uvs { positions } else { [NO_INDEX; 3] },
        material,
    }
}
