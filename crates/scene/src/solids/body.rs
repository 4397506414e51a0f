//! A solid in the world: its shape, what it is made of and how it is lit.

use super::shell::{Shell, diode_radius};
use super::solid::Solid;
use crate::double::{add, double, length, scale, single, sub};
use crate::error::Problem;
use crate::model::{
    Image, Instance, Light, MAX_COORDINATE, Material, MaterialKind, MaterialTextures, Mesh, NO_INDEX, Scene,
    Texels, Texture, Transform, Triangle,
};
use eosphor_core::math::{Vec3, sqrt64};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// More lights along an edge would be smaller than a thousandth of it.
pub const MAX_LIGHTS_PER_EDGE: u32 = 1000;

/// Exponent of the faces' highlight.
pub(crate) const SHININESS: f32 = 64.0;

/// Share of the colour that faces scatter.
pub(crate) const FACE_DIFFUSE: f32 = 0.5;

/// Power of PLATO's light in the middle of a body.
pub(crate) const PLATO_POWER: f32 = 0.7;

/// Colour of the ribs.
const RIB_COLOR: Vec3 = Vec3 { x: 0.055, y: 0.055, z: 0.06 };

/// A Platonic solid with ribs, lights along its edges and open corners.
///
/// ```
/// use eosphor_scene::{Body, BodyLighting, Scene, SceneData, Solid};
///
/// let mut scene = Scene::default();
/// let body = Body { lights_per_edge: 2, lighting: BodyLighting::Diodes { power: 1.0 }, ..Body::new(Solid::Cube) };
/// body.add_to(&mut scene)?;
/// let (data, _) = SceneData::flatten(&scene)?;
/// assert_eq!(data.triangles.len(), body.shape.triangle_count(2));
/// assert_eq!(data.lights.len(), 12 * 2);
/// # Ok::<(), eosphor_scene::SceneError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Body {
    /// The shape of the body.
    pub shape: Solid,
    /// Middle of the body, in world units.
    pub center: Vec3,
    /// Circumradius in world units, before faces and ribs are moved outward (by some 0.1 of it).
    pub radius: f32,
    /// Colour of faces, lights and shadow, 0 to 1.
    pub color: Vec3,
    /// Share of light that faces mirror, 0 to 1; also the weight of their highlight.
    pub reflection: f32,
    /// Share of light that passes a face, 0 to 1.
    pub transparency: f32,
    /// Evenly spaced along each edge; at most [`MAX_LIGHTS_PER_EDGE`].
    pub lights_per_edge: u32,
    /// How the body lights the scene.
    pub lighting: BodyLighting,
}

/// What lights a body from within. Without lights along the edges, nothing does.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
#[schemars(rename = "SolidLighting", extend("examples" = [{ "edges": { "power": 0.7 } }]))]
pub enum BodyLighting {
    /// The lights along the edges themselves: small triangles that face the middle, tinted by the body's colour. At a
    /// distance of one radius from the middle they give on average, all together, this irradiance.
    #[serde(rename = "edges")]
    Diodes {
        /// That irradiance.
        #[serde(default = "plato_power")]
        #[schemars(range(min = 0, max = 1_000_000))]
        power: f32,
    },
    /// One white point light in the middle (PLATO's own way); the lights along the edges are seen and light nothing.
    #[serde(rename = "center")]
    Centre {
        /// Its intensity.
        #[serde(default = "plato_power")]
        #[schemars(range(min = 0, max = 1_000_000))]
        power: f32,
    },
}

fn plato_power() -> f32 {
    PLATO_POWER
}

impl BodyLighting {
    /// PLATO's light in the middle.
    pub const PLATO: BodyLighting = BodyLighting::Centre { power: PLATO_POWER };
}

impl Body {
    /// A white one of radius 1 at the origin.
    pub fn new(shape: Solid) -> Body {
        Body {
            shape,
            center: Vec3::ZERO,
            radius: 1.0,
            color: Vec3::ONE,
            reflection: 0.5,
            transparency: 0.5,
            lights_per_edge: 0,
            lighting: BodyLighting::PLATO,
        }
    }

    /// Puts it into a scene: one mesh, three materials, and in [`BodyLighting::Centre`] a light.
    ///
    /// # Errors
    /// What is out of range.
    pub fn add_to(&self, scene: &mut Scene) -> Result<(), Problem> {
        self.check()?;
        let first = scene.materials.len() as u32;
        let lamp = self.lamp(scene);
        let name = |part: &str| format!("{} {}: {part}", self.shape, scene.meshes.len() + 1);
        let face = MaterialKind::Transparent {
            color: self.color,
            transparency: self.transparency,
            reflection: self.reflection,
            shininess: SHININESS,
            diffuse: FACE_DIFFUSE,
        };
        let rib = MaterialKind::Matte { color: RIB_COLOR };
        scene.materials.extend([
            Material::new(name("faces"), face),
            Material::new(name("ribs"), rib),
            Material { name: name("lights"), ..lamp },
        ]);
        scene.meshes.push(self.mesh([first, first + 1, first + 2]));
        scene.instances.push(Instance::new(scene.meshes.len() as u32 - 1, Transform::default()));
        if let (BodyLighting::Centre { power }, true) = (self.lighting, self.lights_per_edge > 0) {
            scene.lights.push(Light::Point { position: self.center, color: Vec3::splat(power) });
        }
        Ok(())
    }

    /// The surface in world space; the materials are those of faces, ribs and lights. Computed in double precision and
    /// rounded once.
    fn mesh(&self, [face, rib, lamp]: [u32; 3]) -> Mesh {
        let shell = Shell::new(self.shape, self.lights_per_edge);
        let place = |p| single(add(double(self.center), scale(p, f64::from(self.radius))));
        let mut positions: Vec<Vec3> = shell.corners.into_iter().map(place).collect();
        let triangle = |positions: [u32; 3], material: u32| Triangle {
            positions,
            normals: [NO_INDEX; 3],
            uvs: [NO_INDEX; 3],
            material,
        };
        let mut triangles: Vec<Triangle> = shell.faces.into_iter().map(|t| triangle(t, face)).collect();
        triangles.extend(shell.ribs.into_iter().map(|t| triangle(t, rib)));
        for corners in shell.diodes {
            let first = positions.len() as u32;
            positions.extend(corners.map(place));
            triangles.push(triangle([first, first + 1, first + 2], lamp));
        }
        Mesh { name: self.shape.to_string(), positions, triangles, ..Mesh::default() }
    }

    /// The colour of the lights: half white, so that they light what the body's colour would leave black.
    fn lamp_color(&self) -> Vec3 {
        (self.color + Vec3::ONE) * 0.5
    }

    /// The material of the lights along the edges, without a name.
    fn lamp(&self, scene: &mut Scene) -> Material {
        match self.lighting {
            BodyLighting::Diodes { power } => {
                let radiance = self.lamp_color() * (power * self.radiance_of_unit_power());
                Material::new("", MaterialKind::Emissive { radiance })
            }
            // Textured emitters are seen but light nothing.
            BodyLighting::Centre { .. } => {
                let emission = self.lights_per_edge > 0;
                let textures =
                    MaterialTextures { emission: emission.then(|| white(scene)), ..MaterialTextures::NONE };
                let kind = MaterialKind::Emissive { radiance: self.lamp_color() };
                Material { textures, ..Material::new("", kind) }
            }
        }
    }

    /// The radiance of each light with which they all together give an irradiance of 1 at a distance of one radius.
    ///
    /// A triangle of area S and radiance L that gives `L S cos / d^2` sends `pi L S` in all. N of them spread `pi N L S` over
    /// a sphere of area `4 pi R^2`, so the mean irradiance is `N L S / (4 R^2)`. S grows with `R^2`: R drops out.
    fn radiance_of_unit_power(&self) -> f32 {
        let [_, edges] = self.shape.faces_and_edges();
        let (vertices, edge) = (self.shape.vertices(), self.shape.edges()[0]);
        let [a, b] = edge.vertices.map(|v| vertices[v]);
        let radius = diode_radius(length(sub(b, a)), self.lights_per_edge);
        let area = 0.75 * sqrt64(3.0) * radius * radius;
        let count = edges as f64 * f64::from(self.lights_per_edge.max(1));
        (4.0 / (count * area)) as f32
    }

    fn check(&self) -> Result<(), Problem> {
        let what = |field: &str| format!("{}: {field}", self.shape);
        let unit = |field: &str, x: f32| match (0.0..=1.0).contains(&x) {
            true => Ok(()),
            false => Err(Problem::new(what(field), format!("{x} is out of range; it must be 0 to 1"))),
        };
        let (BodyLighting::Diodes { power } | BodyLighting::Centre { power }) = self.lighting;
        [self.color.x, self.color.y, self.color.z].into_iter().try_for_each(|x| unit("color", x))?;
        unit("reflection", self.reflection)?;
        unit("transparency", self.transparency)?;
        let reach = self.center.abs().max_component() + 2.0 * self.radius;
        if !(self.radius > 0.0 && reach <= MAX_COORDINATE) {
            let message = "the radius must be over 0, and the body within 1e12 of the origin";
            return Err(Problem::new(what("radius"), message));
        }
        if self.lights_per_edge > MAX_LIGHTS_PER_EDGE {
            let message =
                format!("{} are too many; there may be {MAX_LIGHTS_PER_EDGE}", self.lights_per_edge);
            return Err(Problem::new(what("lights an edge"), message));
        }
        if !(0.0..=1e6).contains(&power) {
            return Err(Problem::new(what("power"), format!("{power} is out of range; it must be 0 to 1e6")));
        }
        Ok(())
    }
}

/// The number of a texture of one white texel.
fn white(scene: &mut Scene) -> u32 {
    let texels = Texels::rgba8(vec![u32::MAX]);
    let image = scene.images.iter().position(|i| i.texels == texels).unwrap_or_else(|| {
        scene.images.push(Image { name: "white".into(), width: 1, height: 1, texels });
        scene.images.len() - 1
    });
    let texture = Texture::of_image(image as u32);
    let number = scene.textures.iter().position(|t| *t == texture).unwrap_or_else(|| {
        scene.textures.push(texture);
        scene.textures.len() - 1
    });
    number as u32
}
