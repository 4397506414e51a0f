//! Examples below the help of each command. A test runs them all.

/// Of the program.
pub(super) const PROGRAM: &str = "\
Examples:
  eosphor render builtin:cornell -o cornell.png
  eosphor info builtin:hare
  eosphor help render";

pub(super) const RENDER: &str = "\
Examples:
  eosphor render builtin:cornell -o cornell.png --samples 64
  eosphor render builtin:hare -o hare.exr --size 1280x720 --fov 30 --layers depth,normal
  eosphor render builtin:glass -o turn/frame_%03d.png --orbit 36";

pub(super) const COURSE: &str = "\
Examples:
  eosphor course --default > input.txt
  eosphor course < input.txt
  eosphor course --cpu --bodies cube,none,icosahedron -o frames/%04d.png < input.txt";

pub(super) const INFO: &str = "\
Examples:
  eosphor info builtin:glass
  eosphor info builtin:hare --accel octree --leaf-size 8
  eosphor info builtin:cornell --accel builders --json";

pub(super) const COMPARE: &str = "\
Examples:
  eosphor compare a.png b.png
  eosphor compare a.png b.ppm --diff difference.png
  eosphor compare a.exr b.hdr --json";

pub(super) const MERGE: &str = "\
Examples:
  eosphor render builtin:cornell -o picture.png --tiles 1/2
  eosphor render builtin:cornell -o picture.png --tiles 2/2
  eosphor merge -o picture.png";

pub(super) const BENCH_RAYS: &str = "\
Examples:
  eosphor bench rays builtin:hare
  eosphor bench rays builtin:hare --size 3840x2160 --repeats 10
  eosphor bench rays builtin:hare --accel kdtree --json";

#[cfg(feature = "view")]
pub(super) const VIEW: &str = "\
Examples:
  eosphor view builtin:cornell
  eosphor view model.glb --size 1280x720 --samples 64
  eosphor view scene.json --port 8080 --no-open";

pub(super) const LAB_RUN: &str = "\
Examples:
  eosphor lab run structures
  eosphor lab run --all --quick
  eosphor lab run my-experiment.json -o results && eosphor lab report -o results";

pub(super) const BENCH_RENDER: &str = "\
Examples:
  eosphor bench render builtin:glass
  eosphor bench render builtin:glass --samples 16 --repeats 5 --developed
  eosphor bench render builtin:glass --backend cpu --simd avx2 --json";

pub(super) const BENCH_NOISE: &str = "\
Examples:
  eosphor bench noise builtin:cornell
  eosphor bench noise builtin:cornell --samples 64 --size 160x128
  eosphor bench noise builtin:cornell --samples 64 --size 160x128 --independent";

pub(super) const LAB_COMPARE: &str = "\
Examples:
  eosphor lab run structures builders -o before
  eosphor lab compare before after
  eosphor lab compare before/structures.jsonl after/structures.jsonl";

pub(super) const LAB_REPORT: &str = "\
Examples:
  eosphor lab report
  eosphor lab report -o results
  eosphor lab report --table eosphor-lab/structures.jsonl";
