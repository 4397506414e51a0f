//! Hierarchies over a world alone, under a top level that was built apart: as frames have it, in which instances are
//! elsewhere.

use crate::support::World;
use crate::ways::{Way, add, add_with};
use eosphor_accel::{
    BuildOptions, Bvh, Bvh8, BvhPairs, BvhWide, Coherence, Exhaustive, Grid, GridOptions, KdTree,
    KdTreeOptions, Octree, OctreeOptions, OneByOne, SceneGeometry, SimdLevel,
};
use eosphor_core::device::{BvhPair, FarTracer, Link, PairTracer, PairView, WideNode, WideTracer, WideView};
use eosphor_core::hierarchy::IgnoreWork;

/// What is below, and what is above.
struct Levels<T> {
    below: T,
    top: T,
}

impl<T> Levels<T> {
    fn new(world: &World, build: impl Fn(&SceneGeometry) -> T) -> Levels<T> {
        let all = world.geometry();
        let world = &all.instances()[..1];
        let below = SceneGeometry::new(all.triangles(), all.spheres(), all.geometries(), world);
        let below = below.expect("a world that holds together");
        Levels { below: build(&below), top: build(&SceneGeometry::of_instances(all.instances()).unwrap()) }
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
    pairs: (BvhPairs, Vec<BvhPair>, Link),
    wide: (BvhWide, Vec<WideNode>, u32),
}

impl Apart {
    pub(crate) fn new(world: &World) -> Apart {
        let options = BuildOptions::default();
        let bvh = Levels::new(world, |scene| Bvh::build(scene, &options));
        let mut pairs = BvhPairs::new(&bvh.below).expect("it is small");
        let room = world.geometry().instances().len();
        let wide = BvhWide::new(&pairs).expect("it is small");
        let first = wide.nodes().len();
        let wide = wide.with_room(room).expect("it is small");
        let mut wide_nodes = wide.nodes().to_vec();
        let (own, root) = BvhPairs::over_instances(&bvh.top, pairs.roots()[0].reach, 0);
        let (own, wide_root) = BvhWide::over_instances(&own, root, first as u32);
        wide_nodes[first..][..own.len()].copy_from_slice(&own);
        let first = pairs.pairs().len();
        // Not the first room, as it were.
        pairs.make_room(2 * room);
        let first = first + room;
        let (own, root) = BvhPairs::over_instances(&bvh.top, pairs.roots()[0].reach, first as u32);
        let mut all_pairs = pairs.pairs().to_vec();
        all_pairs[first..][..own.len()].copy_from_slice(&own);
        Apart {
            exhaustive: Levels::new(world, Exhaustive::new),
            bvh,
            bvh8: Levels::new(world, |scene| Bvh8::build(scene, &options)),
            octree: Levels::new(world, |scene| Octree::build(scene, &OctreeOptions::default())),
            grid: Levels::new(world, |scene| Grid::build(scene, &GridOptions::default())),
            kdtree: Levels::new(world, |scene| KdTree::build(scene, &KdTreeOptions::default())),
            pairs: (pairs, all_pairs, root),
            wide: (wide, wide_nodes, wide_root),
        }
    }

    pub(crate) fn add_ways<'a>(&'a self, ways: &mut Vec<Way<'a>>) {
        let (work, name) = (IgnoreWork, |name: &str| format!("{name}, the top level apart"));
        let Levels { below, top } = &self.exhaustive;
        add(ways, name("none"), OneByOne(below.tracer_with_instances_of(top, work)));
        let Levels { below, top } = &self.bvh;
        add(ways, name("bvh"), OneByOne(below.tracer_with_instances_of(top, work)));
        let primitives = below.view_with_instances_of(top).primitives;
        let (pairs, nodes, instance_root) = &self.pairs;
        let view = PairView { pairs: nodes, instance_root: *instance_root, primitives, ..pairs.view(below) };
        // SAFETY: closed view: pairs over instances, made for the place where they are, beside the pairs of all geometries.
        unsafe {
            add(ways, name("bvh in pairs"), OneByOne(PairTracer::<true>::new(view)));
            add(ways, name("bvh in pairs, for far rays"), OneByOne(FarTracer::<true>::new(view)));
        }
        let (wide, nodes, instance_root) = &self.wide;
        let view = WideView { nodes, instance_root: *instance_root, primitives, ..wide.view(below) };
        // SAFETY: closed view: as above.
        add(ways, name("bvh wide"), OneByOne(unsafe { WideTracer::<true>::new(view) }));
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
        add(ways, name("octree"), OneByOne(below.tracer_with_instances_of(top, work)));
        let parametric = below.parametric_tracer_with_instances_of(top, work);
        add(ways, name("octree-parametric"), OneByOne(parametric));
        let Levels { below, top } = &self.grid;
        add(ways, name("grid"), OneByOne(below.tracer_with_instances_of(top, work)));
        let Levels { below, top } = &self.kdtree;
        add(ways, name("kd-tree"), OneByOne(below.tracer_with_instances_of(top, work)));
    }
}
