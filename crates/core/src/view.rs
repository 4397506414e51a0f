//! A whole scene, borrowed: what shading reads. Its arrays are declared once, in [`scene_arrays!`](crate::scene_arrays).

use crate::camera::Camera;
use crate::environment::Environment;
use crate::geometry::{Geometry, Instance, Sphere, TriangleExtra, TriangleShading};
use crate::light::{Light, LightNode, LightTree};
use crate::material::{Material, NONE};
use crate::math::Vec3;
use crate::memory::prefetch;
use crate::ray::Hit;
use crate::settings::Settings;
use crate::texture::{Texture, Textures};
use core::fmt::Debug;

/// The arrays of a scene: the one list of them. It calls `$macro!` with the `$arguments` in parentheses, then with a row per array:
/// documentation, variant of [`SceneArray`](crate::view::SceneArray), label, field, access and type of an item.
///
/// What derives from this list: [`SceneView`](crate::view::SceneView), its visitors (the copy to a GPU, the hash of a scene, the
/// check of its indices), [`SceneCounts`](crate::view::SceneCounts) and the parameters of all GPU kernels.
///
/// Access says what a GPU kernel knows of an array: `indexed` arrays are read at the scene's own indices, without their length;
/// `counted` ones have it; `one` is a single item.
#[macro_export]
macro_rules! scene_arrays {
    ($macro:ident($($arguments:tt)*)) => {
        $macro! {
            ($($arguments)*)
            /// Vertices of all triangles, geometry after geometry.
            Triangles "triangles" triangles: indexed [$crate::math::Vec3; 3],
            /// All spheres, geometry after geometry.
            Spheres "spheres" spheres: indexed $crate::geometry::Sphere,
            /// Per triangle: normals, texture coordinates and material.
            TriangleShading "shading" triangle_shading: indexed $crate::geometry::TriangleShading,
            /// Vertex colours and second texture coordinates of the triangles that have them.
            TriangleExtras "extras" triangle_extras: indexed $crate::geometry::TriangleExtra,
            /// Per sphere: the index of its material.
            SphereMaterials "sphere materials" sphere_materials: indexed u32,
            /// Words of the texels of all textures.
            TextureWords "texture words" texture_words: counted u32,
            /// Linear value of each sRGB byte.
            SrgbDecode "sRGB" srgb_decode: one [f32; 256],
            /// Ranges of triangles and spheres; index 0 is the world.
            Geometries "geometries" geometries: indexed $crate::geometry::Geometry,
            /// Placed geometries; index 0 is the world itself.
            Instances "instances" instances: indexed $crate::geometry::Instance,
            /// Materials.
            Materials "materials" materials: indexed $crate::material::Material,
            /// Headers of the textures.
            Textures "textures" textures: counted $crate::texture::Texture,
            /// Lights.
            Lights "lights" lights: counted $crate::light::Light,
            /// The tree by which lights are chosen.
            LightNodes "light nodes" light_nodes: counted $crate::light::LightNode,
            /// Of each light, its place among the leaves of that.
            LightPlaces "light places" light_places: counted u32,
            /// What surrounds the scene.
            Environment "environment" environment: one $crate::environment::Environment,
            /// Its cells by how bright they are: running sums.
            EnvironmentTable "environment table" environment_table: counted u32,
            /// The camera.
            Camera "camera" camera: one $crate::camera::Camera,
            /// Settings that reach a pixel.
            Settings "settings" settings: one $crate::settings::Settings,
        }
    };
}

macro_rules! field_type {
    (one $lifetime:lifetime $item:ty) => { &$lifetime $item };
    ($access:ident $lifetime:lifetime $item:ty) => { &$lifetime [$item] };
}

macro_rules! as_slice {
    (one $field:expr) => {
        core::slice::from_ref($field)
    };
    ($access:ident $field:expr) => {
        $field
    };
}

macro_rules! show {
    (one $visitor:ident, $array:expr, $field:expr) => {
        $visitor.one($array, $field)
    };
    ($access:ident $visitor:ident, $array:expr, $field:expr) => {
        $visitor.array($array, $field)
    };
}

macro_rules! declare_view {
    (() $($(#[$doc:meta])* $array:ident $label:literal $field:ident: $access:ident $item:ty,)*) => {
        /// Borrowed arrays of a scene, in the scene's own order (hierarchies have copies in theirs).
        ///
        /// The indices in these arrays must lead to items that are there, as those of eosphor-scene's `SceneData` do
        /// (`SceneData::check`): shading panics where one does not.
        #[derive(Clone, Copy, Debug)]
        pub struct SceneView<'a> {
            $($(#[$doc])* pub $field: field_type!($access 'a $item),)*
        }

        /// Names an array of a scene.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum SceneArray {
            $($(#[$doc])* $array,)*
        }

        impl SceneArray {
            /// All of them, in the order in which visitors meet them and kernels take them.
            pub const ALL: &[SceneArray] = &[$(SceneArray::$array),*];

            /// For messages and hashes.
            pub const fn label(self) -> &'static str {
                match self {
                    $(SceneArray::$array => $label,)*
                }
            }
        }

        /// How many items each array of a scene has; for GPU kernels, which get arrays without their lengths.
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
        #[repr(C)]
        pub struct SceneCounts {
            $($(#[$doc])* pub $field: u64,)*
        }

        impl SceneCounts {
            /// How many items this array has.
            pub fn of(&self, array: SceneArray) -> u64 {
                match array {
                    $(SceneArray::$array => self.$field,)*
                }
            }
        }

        impl<'a> SceneView<'a> {
            /// Shows all arrays to a visitor, in the order of [`SceneArray::ALL`].
            pub fn visit(&self, visitor: &mut impl SceneVisitor<'a>) {
                $(show!($access visitor, SceneArray::$array, self.$field);)*
            }

            /// How many items each array has.
            pub fn counts(&self) -> SceneCounts {
                SceneCounts { $($field: as_slice!($access self.$field).len() as u64),* }
            }
        }
    };
}

scene_arrays!(declare_view());

impl<'a> SceneView<'a> {
    /// The textures, as they are sampled.
    #[inline(always)]
    pub fn textures(&self) -> Textures<'a> {
        Textures { textures: self.textures, words: self.texture_words, srgb_decode: self.srgb_decode }
    }

    /// The tree by which lights are chosen.
    #[inline(always)]
    pub fn light_tree(&self) -> LightTree<'a> {
        LightTree { nodes: self.light_nodes, places: self.light_places }
    }

    /// Tells memory that what shading reads of a triangle that was hit will be read soon.
    #[inline(always)]
    pub fn prefetch_triangle(&self, hit: &Hit) {
        let Some(instance) = self.instances.get(hit.id.instance as usize) else { return };
        let Some(geometry) = self.geometries.get(instance.geometry as usize) else { return };
        if hit.id.primitive < geometry.triangle_count {
            let number = (geometry.first_triangle + hit.id.primitive) as usize;
            prefetch(self.triangles, number);
            prefetch(self.triangle_shading, number);
        }
    }
}

/// Sees the arrays of a scene one after the other: [`SceneView::visit`].
pub trait SceneVisitor<'a> {
    /// An array.
    fn array<T: SceneItem>(&mut self, array: SceneArray, items: &'a [T]);

    /// A single item; by default as an array of one.
    fn one<T: SceneItem>(&mut self, array: SceneArray, item: &'a T) {
        self.array(array, core::slice::from_ref(item));
    }
}

/// An item of a scene's array: `repr(C)` without pointers, so that hosts and devices agree on it.
pub trait SceneItem: Copy + Debug {
    /// Calls `link` with each index in the item and the array into which it leads. Indices that stand for "none" are left out.
    fn links(&self, _link: &mut impl FnMut(SceneArray, u64)) {}

    /// Whether [`SceneItem::words`] gives the whole item: for types of which scenes have millions. What `Debug` writes is the
    /// whole of the others.
    const HAS_WORDS: bool = false;

    /// Calls `word` with the bits of each number in the item, in order.
    fn words(&self, _word: &mut impl FnMut(u32)) {}
}

impl SceneItem for [Vec3; 3] {
    const HAS_WORDS: bool = true;

    fn words(&self, word: &mut impl FnMut(u32)) {
        self.iter().for_each(|corner| vector(corner, word));
    }
}

impl SceneItem for Sphere {
    const HAS_WORDS: bool = true;

    fn words(&self, word: &mut impl FnMut(u32)) {
        let Sphere { center, radius } = self;
        vector(center, word);
        word(radius.to_bits());
    }
}

impl SceneItem for TriangleShading {
    fn links(&self, link: &mut impl FnMut(SceneArray, u64)) {
        link(SceneArray::Materials, self.material.into());
        optional(self.extra, SceneArray::TriangleExtras, link);
    }

    const HAS_WORDS: bool = true;

    fn words(&self, word: &mut impl FnMut(u32)) {
        let TriangleShading { normals, uvs, material, extra, object } = self;
        normals.iter().for_each(|normal| vector(normal, word));
        numbers(uvs.as_flattened(), word);
        [*material, *extra, *object].into_iter().for_each(word);
    }
}

impl SceneItem for TriangleExtra {
    const HAS_WORDS: bool = true;

    fn words(&self, word: &mut impl FnMut(u32)) {
        let TriangleExtra { colors, uvs1 } = self;
        numbers(colors.as_flattened(), word);
        numbers(uvs1.as_flattened(), word);
    }
}

impl SceneItem for u32 {
    const HAS_WORDS: bool = true;

    fn words(&self, word: &mut impl FnMut(u32)) {
        word(*self);
    }
}

impl SceneItem for [f32; 256] {
    const HAS_WORDS: bool = true;

    fn words(&self, word: &mut impl FnMut(u32)) {
        numbers(self, word);
    }
}

impl SceneItem for Geometry {
    fn links(&self, link: &mut impl FnMut(SceneArray, u64)) {
        range(self.first_triangle, self.triangle_count, SceneArray::Triangles, link);
        range(self.first_sphere, self.sphere_count, SceneArray::Spheres, link);
    }
}

impl SceneItem for Instance {
    fn links(&self, link: &mut impl FnMut(SceneArray, u64)) {
        link(SceneArray::Geometries, self.geometry.into());
        optional(self.material, SceneArray::Materials, link);
    }
}

impl SceneItem for Material {
    fn links(&self, link: &mut impl FnMut(SceneArray, u64)) {
        self.textures().into_iter().for_each(|texture| optional(texture, SceneArray::Textures, link));
    }
}

impl SceneItem for Texture {}
impl SceneItem for Light {}

impl SceneItem for LightNode {
    fn links(&self, link: &mut impl FnMut(SceneArray, u64)) {
        if self.is_leaf() {
            link(SceneArray::Lights, self.number.into());
        } else {
            link(SceneArray::LightNodes, u64::from(self.children) + 1);
        }
    }

    const HAS_WORDS: bool = true;

    fn words(&self, word: &mut impl FnMut(u32)) {
        let LightNode { center, radius, normal, variance, power, first_chance, children, number } = self;
        [center, normal].into_iter().for_each(|v| vector(v, word));
        numbers(&[*radius, *variance, *power, *first_chance], word);
        [*children, *number].into_iter().for_each(word);
    }
}

impl SceneItem for Environment {
    fn links(&self, link: &mut impl FnMut(SceneArray, u64)) {
        optional(self.texture, SceneArray::Textures, link);
        if self.chance > 0.0 {
            link(SceneArray::EnvironmentTable, self.table_length().saturating_sub(1));
        }
    }
}

impl SceneItem for Camera {}
impl SceneItem for Settings {}

fn vector(v: &Vec3, word: &mut impl FnMut(u32)) {
    [v.x, v.y, v.z].into_iter().for_each(|x| word(x.to_bits()));
}

fn numbers(all: &[f32], word: &mut impl FnMut(u32)) {
    all.iter().for_each(|x| word(x.to_bits()));
}

fn optional(index: u32, array: SceneArray, link: &mut impl FnMut(SceneArray, u64)) {
    if index != NONE {
        link(array, index.into());
    }
}

/// A range must end within its array, an empty one too.
fn range(first: u32, count: u32, array: SceneArray, link: &mut impl FnMut(SceneArray, u64)) {
    let end = u64::from(first) + u64::from(count);
    if end > 0 {
        link(array, end - 1);
    }
}

/// An item of a scene's array.
///
/// # Panics
/// Where there is none of this number. (Not on GPUs, whose arrays have no length of their own.)
#[inline(always)]
pub(crate) fn item<T>(items: &[T], index: u32) -> &T {
    #[cfg(target_arch = "nvptx64")]
    {
        // SAFETY: uploaded arrays: who makes a kernel's view promises every index that the scene holds.
        unsafe { items.get_unchecked(index as usize) }
    }
    #[cfg(not(target_arch = "nvptx64"))]
    &items[index as usize]
}
