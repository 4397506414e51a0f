//! Surface points that lights are added to.

use super::Path;
use eosphor_core::integrator::whitted::{LampLobe, Receiver, Receivers, point_key, takes_light};
use eosphor_core::integrator::whitted::{shadow_origin, side_sign};
use eosphor_core::math::{Vec3, vec3};
use eosphor_core::ray::PrimitiveId;
use eosphor_core::settings::Settings;
use eosphor_core::shading::{PointLanes, SurfacePoint};
use eosphor_core::sums::ExactSum;
use eosphor_core::view::SceneView;

/// Points in a block: as many lanes as AVX-512 has.
pub(super) const LANES: usize = 16;

/// Numbers of the points of a block.
type Lanes = [f32; LANES];

/// Vectors of the points of a block: x of all, y, z.
type Lanes3 = [Lanes; 3];

/// Some points, each number an array over them, so that loops over points become SIMD code.
#[derive(Clone, Copy)]
pub(super) struct Block {
    /// How many there are; the other lanes are idle.
    count: usize,
    position: Lanes3,
    normal: Lanes3,
    geometric_normal: Lanes3,
    to_viewer: Lanes3,
    offset: Lanes,
    shininess: Lanes,
    diffuse: Lanes3,
    specular: Lanes3,
    transmission: Lanes3,
    lamp_highlights: [bool; LANES],
    lobe: [LampLobe; LANES],
    any_lobes: bool,
    pub(super) id: [PrimitiveId; LANES],
    /// What the points' random numbers depend on: where their paths ended, pixels and samples.
    path: [u32; LANES],
    x: [u32; LANES],
    y: [u32; LANES],
    pub(super) sample: [u32; LANES],
    /// What the point gives by itself, and the weight of everything that it gives.
    local: Lanes3,
    shown: Lanes3,
    pixel: [u32; LANES],
    /// Light that has been added.
    light: Lanes3,
}

#[inline(always)]
pub(super) fn get(lanes: &Lanes3, lane: usize) -> Vec3 {
    vec3(lanes[0][lane], lanes[1][lane], lanes[2][lane])
}

#[inline(always)]
pub(super) fn set(lanes: &mut Lanes3, lane: usize, v: Vec3) {
    (lanes[0][lane], lanes[1][lane], lanes[2][lane]) = (v.x, v.y, v.z);
}

impl Block {
    const EMPTY: Block = Block {
        count: 0,
        position: [[0.0; LANES]; 3],
        normal: [[0.0; LANES]; 3],
        geometric_normal: [[0.0; LANES]; 3],
        to_viewer: [[0.0; LANES]; 3],
        offset: [0.0; LANES],
        shininess: [0.0; LANES],
        diffuse: [[0.0; LANES]; 3],
        specular: [[0.0; LANES]; 3],
        transmission: [[0.0; LANES]; 3],
        lamp_highlights: [false; LANES],
        lobe: [LampLobe::NONE; LANES],
        any_lobes: false,
        id: [PrimitiveId::NONE; LANES],
        path: [0; LANES],
        x: [0; LANES],
        y: [0; LANES],
        sample: [0; LANES],
        local: [[0.0; LANES]; 3],
        shown: [[0.0; LANES]; 3],
        pixel: [0; LANES],
        light: [[0.0; LANES]; 3],
    };

    #[inline(always)]
    pub(super) fn diffuse(&self, lane: usize) -> Vec3 {
        get(&self.diffuse, lane)
    }

    #[inline(always)]
    pub(super) fn specular(&self, lane: usize) -> Vec3 {
        get(&self.specular, lane)
    }

    #[inline(always)]
    pub(super) fn transmission(&self, lane: usize) -> Vec3 {
        get(&self.transmission, lane)
    }

    /// Whether any point has a lobe.
    #[inline(always)]
    pub(super) fn has_lobes(&self) -> bool {
        self.any_lobes
    }

    /// Key of a point's random numbers.
    #[inline(always)]
    pub(super) fn key(&self, settings: &Settings, lane: usize) -> u32 {
        point_key(settings, self.path[lane], self.x[lane], self.y[lane])
    }

    #[inline(always)]
    pub(super) fn lamp_highlights(&self, lane: usize) -> bool {
        self.lamp_highlights[lane]
    }

    #[inline(always)]
    pub(super) fn lobe(&self, lane: usize) -> &LampLobe {
        &self.lobe[lane]
    }

    /// Sets which primitive a lane's point is of, the path that found it, and the weight with which it is seen.
    #[inline(always)]
    pub(super) fn set_path(&mut self, lane: usize, id: PrimitiveId, path: &Path, pixel: usize, shown: Vec3) {
        self.id[lane] = id;
        self.path[lane] = path.ray.path;
        (self.x[lane], self.y[lane]) = (path.x, path.y);
        self.sample[lane] = path.sample;
        set(&mut self.shown, lane, shown);
        self.pixel[lane] = pixel as u32;
    }

    #[inline(always)]
    pub(super) fn add_light(&mut self, lane: usize, light: Vec3) {
        let sum = get(&self.light, lane) + light;
        set(&mut self.light, lane, sum);
    }
}

/// One side of the points of a block, as lights see it.
pub(super) struct Side<'a> {
    block: &'a Block,
    origin: Lanes3,
    normal: Lanes3,
    above: Lanes3,
    pub(super) highlights: [bool; LANES],
    pub(super) any_highlights: bool,
    pub(super) key: [u32; LANES],
    pub(super) index: [u32; LANES],
}

impl<'a> Side<'a> {
    /// Side 0 or 1, without highlights, keys and samples.
    #[inline(always)]
    pub(super) fn new(block: &'a Block, side: u32) -> Side<'a> {
        let none = [[0.0; LANES]; 3];
        let (mut origin, mut normal, mut above) = (none, none, none);
        let sign = side_sign(side);
        for lane in 0..LANES {
            let up = get(&block.geometric_normal, lane) * sign;
            set(&mut above, lane, up);
            set(&mut normal, lane, get(&block.normal, lane) * sign);
            set(&mut origin, lane, shadow_origin(get(&block.position, lane), up, block.offset[lane]));
        }
        let (highlights, key) = ([false; LANES], [0; LANES]);
        Side { block, origin, normal, above, highlights, any_highlights: false, key, index: key }
    }

    /// One of its points.
    #[inline(always)]
    pub(super) fn receiver(&self, lane: usize) -> Receiver {
        Receiver {
            origin: self.origin(lane),
            normal: self.normal(lane),
            above: self.above(lane),
            to_viewer: self.to_viewer(lane),
            shininess: self.shininess(lane),
            highlights: self.highlights[lane],
            lobe: *self.block.lobe(lane),
            key: self.key[lane],
            first: self.index[lane],
            scale: self.scale(),
        }
    }
}

impl Receivers for Side<'_> {
    #[inline(always)]
    fn origin(&self, lane: usize) -> Vec3 {
        get(&self.origin, lane)
    }
    #[inline(always)]
    fn normal(&self, lane: usize) -> Vec3 {
        get(&self.normal, lane)
    }
    #[inline(always)]
    fn above(&self, lane: usize) -> Vec3 {
        get(&self.above, lane)
    }
    #[inline(always)]
    fn to_viewer(&self, lane: usize) -> Vec3 {
        get(&self.block.to_viewer, lane)
    }
    #[inline(always)]
    fn shininess(&self, lane: usize) -> f32 {
        self.block.shininess[lane]
    }
    #[inline(always)]
    fn highlights(&self, lane: usize) -> bool {
        self.highlights[lane]
    }
    #[inline(always)]
    fn any_highlights(&self) -> bool {
        self.any_highlights
    }
    #[inline(always)]
    fn lobe(&self, lane: usize) -> &LampLobe {
        self.block.lobe(lane)
    }
    #[inline(always)]
    fn any_lobes(&self) -> bool {
        self.block.any_lobes
    }
    #[inline(always)]
    fn key(&self, lane: usize) -> u32 {
        self.key[lane]
    }
    #[inline(always)]
    fn index(&self, lane: usize) -> u32 {
        self.index[lane]
    }
    #[inline(always)]
    fn scale(&self) -> f32 {
        1.0
    }
}

/// The points of a batch.
#[derive(Default)]
pub(super) struct LitPoints {
    pub(super) blocks: Vec<Block>,
}

impl LitPoints {
    #[inline(always)]
    pub(super) fn clear(&mut self) {
        self.blocks.clear();
    }

    #[inline(always)]
    pub(super) fn is_empty(&self) -> bool {
        self.blocks.is_empty()
    }

    /// Points in a block; the first lanes have them.
    #[inline(always)]
    pub(super) fn points_in(&self, block: usize) -> usize {
        self.blocks[block].count
    }

    /// Whether lights change what the point gives.
    #[inline(always)]
    pub(super) fn takes(view: &SceneView, point: &SurfacePoint, lobe: &LampLobe) -> bool {
        view.settings.lighting_model.is_lit() && !view.lights.is_empty() && takes_light(point, lobe)
    }

    /// Appends a point that `path` found. `local` is what it gives by itself, `shown` the weight of all that it gives.
    #[inline(always)]
    pub(super) fn push(
        &mut self,
        (point, lobe): (&SurfacePoint, &LampLobe),
        path: &Path,
        pixel: usize,
        shown: Vec3,
        local: Vec3,
    ) {
        if self.blocks.last().is_none_or(|last| last.count == LANES) {
            self.blocks.push(Block::EMPTY);
        }
        let Some(block) = self.blocks.last_mut() else { return };
        let lane = block.count;
        block.count += 1;
        set(&mut block.position, lane, point.position);
        set(&mut block.normal, lane, point.normal);
        set(&mut block.geometric_normal, lane, point.geometric_normal);
        set(&mut block.to_viewer, lane, point.to_viewer);
        block.offset[lane] = point.offset;
        block.shininess[lane] = point.material_values.shininess;
        set(&mut block.diffuse, lane, point.material_values.diffuse);
        set(&mut block.specular, lane, point.material_values.specular);
        set(&mut block.transmission, lane, point.material_values.transmission);
        block.lamp_highlights[lane] = point.material_values.lamp_highlights;
        block.lobe[lane] = *lobe;
        block.any_lobes |= lobe.is_there();
        block.set_path(lane, point.id, path, pixel, shown);
        set(&mut block.local, lane, local);
    }

    /// Appends some points that are all of the material of `point`, and what each gives by itself; they have no lobes. The caller
    /// sets the lanes' paths.
    #[inline(always)]
    pub(super) fn push_alike(
        &mut self,
        points: &PointLanes<LANES>,
        count: usize,
        point: &SurfacePoint,
        local: Vec3,
    ) -> &mut Block {
        let values = &point.material_values;
        let mut block = Block { count, offset: points.offset, ..Block::EMPTY };
        block.shininess = [values.shininess; LANES];
        block.lamp_highlights = [values.lamp_highlights; LANES];
        for lane in 0..LANES {
            set(&mut block.position, lane, points.position.get(lane));
            set(&mut block.normal, lane, points.normal.get(lane));
            set(&mut block.geometric_normal, lane, points.geometric_normal.get(lane));
            set(&mut block.to_viewer, lane, points.to_viewer.get(lane));
            set(&mut block.diffuse, lane, values.diffuse);
            set(&mut block.specular, lane, values.specular);
            set(&mut block.transmission, lane, values.transmission);
            set(&mut block.local, lane, local);
        }
        let number = self.blocks.len();
        self.blocks.push(block);
        &mut self.blocks[number]
    }

    /// Adds what the points give, lights included, to the sums of their pixels.
    #[inline(always)]
    pub(super) fn add_to(&self, sums: &mut [ExactSum]) {
        for (number, block) in self.blocks.iter().enumerate() {
            for lane in 0..self.points_in(number) {
                let found = get(&block.local, lane) + get(&block.light, lane);
                sums[block.pixel[lane] as usize].add(get(&block.shown, lane) * found);
            }
        }
    }
}
