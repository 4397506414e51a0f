//! Every way to ask for hits: structure, builder, traversal, SIMD level, what is known about the rays.

use crate::apart::Apart;
use crate::support::World;
use eosphor_accel::{
    BatchTracer, BuildOptions, Builder, Bvh, Bvh8, BvhPairs, BvhWide, Coherence, Exhaustive, Filters, Grid,
    GridOptions, KdTree, KdTreeOptions, Octree, OctreeOptions, OneByOne, SimdLevel,
};
use eosphor_core::device::WarpMode;
use eosphor_core::hierarchy::{CountWork, IgnoreWork, ShadowBatch};
use eosphor_core::ray::{Hit, Ray, RayFilter};

/// What every way answers, for many rays.
pub(crate) trait Answers {
    fn closest(&self, rays: &[Ray], filters: Filters, hits: &mut [Hit]);
    fn occluded(&self, rays: &[Ray], filters: Filters, hidden: &mut [bool]);
    fn next(&self, rays: &[Ray], filters: Filters, hits: &mut [Hit]);
    fn shadows1(&self, batch: &ShadowBatch<1>, filter: &RayFilter, active: &[bool; 1]) -> [bool; 1];
    fn shadows8(&self, batch: &ShadowBatch<8>, filter: &RayFilter, active: &[bool; 8]) -> [bool; 8];
    fn shadows16(&self, batch: &ShadowBatch<16>, filter: &RayFilter, active: &[bool; 16]) -> [bool; 16];
    fn shadows64(&self, batch: &ShadowBatch<64>, filter: &RayFilter, active: &[bool; 64]) -> [bool; 64];
}

/// A tracer, told this about its rays.
struct Asked<T>(T, Coherence);

impl<T: BatchTracer> Answers for Asked<T> {
    fn closest(&self, rays: &[Ray], filters: Filters, hits: &mut [Hit]) {
        self.0.closest_hits(rays, filters, self.1, hits);
    }
    fn occluded(&self, rays: &[Ray], filters: Filters, hidden: &mut [bool]) {
        self.0.occluded_rays(rays, filters, self.1, hidden);
    }
    fn next(&self, rays: &[Ray], filters: Filters, hits: &mut [Hit]) {
        self.0.next_hits(rays, filters, self.1, hits);
    }
    fn shadows1(&self, batch: &ShadowBatch<1>, filter: &RayFilter, active: &[bool; 1]) -> [bool; 1] {
        self.0.occluded_batch(batch, filter, active)
    }
    fn shadows8(&self, batch: &ShadowBatch<8>, filter: &RayFilter, active: &[bool; 8]) -> [bool; 8] {
        self.0.occluded_batch(batch, filter, active)
    }
    fn shadows16(&self, batch: &ShadowBatch<16>, filter: &RayFilter, active: &[bool; 16]) -> [bool; 16] {
        self.0.occluded_batch(batch, filter, active)
    }
    fn shadows64(&self, batch: &ShadowBatch<64>, filter: &RayFilter, active: &[bool; 64]) -> [bool; 64] {
        self.0.occluded_batch(batch, filter, active)
    }
}

/// A way and its name.
pub(crate) struct Way<'a> {
    pub(crate) name: String,
    pub(crate) answers: Box<dyn Answers + 'a>,
}

/// A world under every structure, with the settings that are usual and some that make other trees.
pub(crate) struct Structures {
    pub(crate) exhaustive: Exhaustive,
    bvhs: Vec<(String, (Bvh, BvhPairs, BvhWide))>,
    pub(crate) bvh8s: Vec<(String, Bvh8)>,
    pub(crate) octrees: Vec<(String, Octree)>,
    grids: Vec<(String, Grid)>,
    kdtrees: Vec<(String, KdTree)>,
    apart: Apart,
    /// Masks by which every instance is seen.
    all_seen: Vec<u32>,
}

/// With a name.
fn named<O, T>(options: Vec<(String, O)>, build: impl Fn(&O) -> T) -> Vec<(String, T)> {
    options.into_iter().map(|(name, options)| (name, build(&options))).collect()
}

fn two<O>(usual: O, fine: O) -> Vec<(String, O)> {
    vec![(String::new(), usual), (" fine".to_owned(), fine)]
}

fn binary_options() -> Vec<(String, BuildOptions)> {
    let usual = Builder::ALL.map(|b| (b.to_string(), BuildOptions::of(b)));
    let leaves = [(Builder::Binned, 1, 0.0), (Builder::Spatial, 1, 0.0), (Builder::Median, 255, 1e9)];
    let others = leaves.map(|(builder, max_leaf_primitives, traversal_cost)| {
        let options = BuildOptions { max_leaf_primitives, traversal_cost, ..BuildOptions::of(builder) };
        (format!("{builder} with leaves of {max_leaf_primitives}"), options)
    });
    usual.into_iter().chain(others).collect()
}

fn eight_wide_options() -> Vec<(String, BuildOptions)> {
    let usual = Builder::ALL.map(|b| (b.to_string(), BuildOptions::of(b)));
    let other = [Builder::Morton, Builder::Binned].map(|b| {
        let usual = BuildOptions::of(b);
        let cut = !usual.cut_large_triangles;
        let name = format!("{b}, large triangles {}", if cut { "cut" } else { "whole" });
        (name, BuildOptions { cut_large_triangles: cut, ..usual })
    });
    let moved = [Builder::Morton, Builder::Binned].map(|b| {
        let reinsertion = !BuildOptions::of(b).reinsertion;
        let name = format!("{b}, large nodes {}", if reinsertion { "moved" } else { "left" });
        (name, BuildOptions { reinsertion, ..BuildOptions::of(b) })
    });
    usual.into_iter().chain(other).chain(moved).collect()
}

impl Structures {
    pub(crate) fn new(world: &World) -> Structures {
        let scene = world.geometry();
        let (octree, grid, kdtree) =
            (OctreeOptions::default(), GridOptions::default(), KdTreeOptions::default());
        let octree_fine =
            OctreeOptions { max_leaf_primitives: 1, max_depth: 6, only_if_cheaper: false, ..octree };
        let grid_fine = GridOptions { density: 100.0, max_duplication: 200.0, ..grid };
        let kdtree_fine =
            KdTreeOptions { traversal_cost: 0.01, patience: 5, max_depth: 40, empty_bonus: 0.8, ..kdtree };
        Structures {
            exhaustive: Exhaustive::new(&scene),
            bvhs: named(binary_options(), |o| {
                let bvh = Bvh::build(&scene, o);
                let pairs = BvhPairs::new(&bvh).expect("it is small");
                let wide = BvhWide::new(&pairs).expect("it is small");
                (bvh, pairs, wide)
            }),
            bvh8s: named(eight_wide_options(), |o| Bvh8::build(&scene, o)),
            octrees: named(two(octree, octree_fine), |o| Octree::build(&scene, o)),
            grids: named(two(grid, grid_fine), |o| Grid::build(&scene, o)),
            kdtrees: named(two(kdtree, kdtree_fine), |o| KdTree::build(&scene, o)),
            apart: Apart::new(world),
            all_seen: vec![u32::MAX; world.instances.len()],
        }
    }

    /// All ways but the reference.
    pub(crate) fn ways(&self) -> Vec<Way<'_>> {
        let mut ways = Vec::new();
        for (name, (bvh, pairs, wide)) in &self.bvhs {
            let scalar = bvh.tracer(IgnoreWork);
            add(&mut ways, format!("bvh {name}"), OneByOne(scalar));
            add(&mut ways, format!("bvh {name}, in pairs"), OneByOne(pairs.tracer(bvh)));
            add(&mut ways, format!("bvh {name}, in pairs, in step"), OneByOne(pairs.tracer_in_step(bvh)));
            add(&mut ways, format!("bvh {name}, in pairs, for far rays"), OneByOne(pairs.far_tracer(bvh)));
            add(&mut ways, format!("bvh {name}, wide"), OneByOne(wide.tracer(bvh)));
            if bvh.primitives().instances().len() == 1 {
                for (how, warp_mode) in [("alone", WarpMode::INDEPENDENT), ("together", WarpMode::VOTING)] {
                    let tracer = pairs.world_tracer(bvh, warp_mode);
                    add(&mut ways, format!("bvh {name}, in pairs, {how}"), OneByOne(tracer));
                }
            }
        }
        for (name, bvh8) in &self.bvh8s {
            for level in SimdLevel::available() {
                let Some(tracer) = bvh8.tracer_at(level) else { continue };
                let name = format!("bvh8 {name} at {level}");
                add(&mut ways, format!("{name}, one ray"), OneByOne(tracer));
                let masked = tracer.with_masks(&self.all_seen, 1);
                add(&mut ways, format!("{name}, masked"), OneByOne(masked));
                for coherence in [Coherence::Auto, Coherence::Coherent, Coherence::Incoherent] {
                    add_with(&mut ways, format!("{name}, {coherence:?}"), tracer, coherence);
                }
            }
            let counting = OneByOne(bvh8.counting_tracer(CountWork::default()));
            add(&mut ways, format!("bvh8 {name}, counting"), counting);
        }
        for (name, octree) in &self.octrees {
            add(&mut ways, format!("octree{name}"), OneByOne(octree.tracer(IgnoreWork)));
            let parametric = octree.parametric_tracer(IgnoreWork);
            add(&mut ways, format!("octree{name}, parametric"), OneByOne(parametric));
        }
        for (name, grid) in &self.grids {
            add(&mut ways, format!("grid{name}"), OneByOne(grid.tracer(IgnoreWork)));
        }
        for (name, kdtree) in &self.kdtrees {
            add(&mut ways, format!("kd-tree{name}"), OneByOne(kdtree.tracer(IgnoreWork)));
        }
        self.apart.add_ways(&mut ways);
        ways
    }
}

pub(crate) fn add<'a>(ways: &mut Vec<Way<'a>>, name: String, tracer: impl BatchTracer + 'a) {
    add_with(ways, name, tracer, Coherence::Auto);
}

pub(crate) fn add_with<'a>(
    ways: &mut Vec<Way<'a>>,
    name: String,
    tracer: impl BatchTracer + 'a,
    coherence: Coherence,
) {
    ways.push(Way { name, answers: Box::new(Asked(tracer, coherence)) });
}
