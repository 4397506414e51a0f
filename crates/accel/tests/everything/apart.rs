//! Hierarchies over a world alone, under a top level that was built apart: as frames have it, in which instances are
//! elsewhere.

use crate::support::World;
use crate::ways::{Way, add, add_with};
use eosphor_accel::{
    BuildOptions, Bvh, Bvh8, BvhPairs, BvhWide, Coherence, Exhaustive, Grid, GridOptions, KdTree,
    KdTreeOptions, Octree, OctreeOptions, OneByOne, SceneGeometry, SimdLevel,
};
use eosphor_core::hierarchy::{
    BvhTracer, ExhaustiveTracer, FarTracer, GridTracer, IgnoreWork, KdTreeTracer, Link,
    OctreeParametricTracer, OctreeTracer, PairTracer, PairView, WideTracer, WideView,
};

/// What is below, and what is above.
struct Levels<T> {
    below: T,
    top: T,
}

impl<T> Levels<T> {
    fn new(world: &World, build: impl Fn(&SceneGeometry) -> T) -> Levels<T> {
        let all = world.geometry();
        let below = SceneGeometry { instances: &all.instances[..1], ..all };
        Levels { below: build(&below), top: build(&SceneGeometry::of_instances(all.instances)) }
    }
}

/// A world under every structure whose top level is apart.
pub(crate) struct Apart {
    exhaustive: Levels<Exhaustive>,
    bvh: Levels<Bvh>,
    bvh8: Levels<Bvh8>,
    octree: Levels<Octree>,
    grid: Levels<Grid>,
    kdtree: Levels<KdTree>,
    /// With the tree over the instances in room that was made for it.
    pairs: (BvhPairs, Link),
    wide: (BvhWide, u32),
}

impl Apart {
    pub(crate) fn new(world: &World) -> Apart {
        let options = BuildOptions::default();
        let bvh = Levels::new(world, |scene| Bvh::build(scene, &options));
        let mut pairs = BvhPairs::new(&bvh.below).expect("it is small");
        let room = world.geometry().instances.len();
        let wide = BvhWide::new(&pairs).expect("it is small");
        let first = wide.nodes.len();
        let mut wide = wide.with_room(room).expect("it is small");
        let (own, root) = BvhPairs::over_instances(&bvh.top, pairs.roots[0].reach, 0);
        let (own, wide_root) = BvhWide::over_instances(&own, root, first as u32);
        wide.nodes[first..][..own.len()].copy_from_slice(&own);
        let first = pairs.pairs.len();
        // Not the first room, as it were.
        pairs.make_room(2 * room);
        let first = first + room;
        let (own, root) = BvhPairs::over_instances(&bvh.top, pairs.roots[0].reach, first as u32);
        pairs.pairs[first..][..own.len()].copy_from_slice(&own);
        Apart {
            exhaustive: Levels::new(world, Exhaustive::new),
            bvh,
            bvh8: Levels::new(world, |scene| Bvh8::build(scene, &options)),
            octree: Levels::new(world, |scene| Octree::build(scene, &OctreeOptions::default())),
            grid: Levels::new(world, |scene| Grid::build(scene, &GridOptions::default())),
            kdtree: Levels::new(world, |scene| KdTree::build(scene, &KdTreeOptions::default())),
            pairs: (pairs, root),
            wide: (wide, wide_root),
        }
    }

    pub(crate) fn add_ways<'a>(&'a self, ways: &mut Vec<Way<'a>>) {
        let (work, name) = (IgnoreWork, |name: &str| format!("{name}, the top level apart"));
        let Levels { below, top } = &self.exhaustive;
        let primitives = below.view_with_instances_of(top);
        add(ways, name("none"), OneByOne(ExhaustiveTracer { primitives, work }));
        let Levels { below, top } = &self.bvh;
        let bvh = below.view_with_instances_of(top);
        add(ways, name("bvh"), OneByOne(BvhTracer { bvh, work }));
        let (pairs, instance_root) = &self.pairs;
        let (instance_root, primitives) = (*instance_root, bvh.primitives);
        let view = PairView { instance_root, primitives, ..pairs.view(below) };
        add(ways, name("bvh in pairs"), OneByOne(PairTracer::<true> { view }));
        add(ways, name("bvh in pairs, for far rays"), OneByOne(FarTracer::<true> { view }));
        let (wide, instance_root) = &self.wide;
        let view = WideView { instance_root: *instance_root, ..wide.view(primitives) };
        add(ways, name("bvh wide"), OneByOne(WideTracer::<true> { view }));
        let Levels { below, top } = &self.bvh8;
        for level in SimdLevel::available() {
            let Some(tracer) = below.tracer_at(level) else { continue };
            let tracer = tracer.with_instances_of(top);
            add(ways, name(&format!("bvh8 at {level}, one ray")), OneByOne(tracer));
            for coherence in [Coherence::Auto, Coherence::Coherent] {
                add_with(ways, name(&format!("bvh8 at {level}, {coherence:?}")), tracer, coherence);
            }
        }
        let Levels { below, top } = &self.octree;
        let tree = below.view_with_instances_of(top);
        add(ways, name("octree"), OneByOne(OctreeTracer { tree, work }));
        add(ways, name("octree-parametric"), OneByOne(OctreeParametricTracer { tree, work }));
        let Levels { below, top } = &self.grid;
        let grid = below.view_with_instances_of(top);
        add(ways, name("grid"), OneByOne(GridTracer { grid, work }));
        let Levels { below, top } = &self.kdtree;
        let tree = below.view_with_instances_of(top);
        add(ways, name("kd-tree"), OneByOne(KdTreeTracer { tree, work }));
    }
}
