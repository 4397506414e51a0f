//! A ray tracer of double precision: triangles and spheres under a hierarchy of its own. It shares no arithmetic with the
//! tracers that it judges.
//!
//! Rays are given by numbers of single precision. Their origin is first moved to where they pass the scene, without
//! rounding that matters: so its hits are as good for rays from 10^12 radii as for those from near.

use crate::vector::*;

/// A primitive in world space.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Shape {
    Triangle([V; 3]),
    Sphere { center: V, radius: f64 },
}

impl Shape {
    fn bounds(&self) -> [V; 2] {
        match *self {
            Shape::Triangle([a, b, c]) => [0, 1].map(|k| {
                [0, 1, 2].map(|i| if k == 0 { a[i].min(b[i]).min(c[i]) } else { a[i].max(b[i]).max(c[i]) })
            }),
            Shape::Sphere { center, radius } => [center.map(|x| x - radius), center.map(|x| x + radius)],
        }
    }

    /// Where the line from `o` along `d` meets it beyond `t_min`; `own` says that `o` lies on it.
    fn meet(&self, o: V, d: V, t_min: f64, own: bool) -> Option<f64> {
        match *self {
            // A ray meets the triangle that it starts on nowhere else.
            Shape::Triangle(corners) => {
                if own { None } else { meet_triangle(o, d, corners) }.filter(|t| *t > t_min)
            }
            Shape::Sphere { center, radius } => {
                let from = sub(o, center);
                let squared = dot(d, d);
                if own {
                    // One of the roots is 0.
                    return Some(-2.0 * dot(from, d) / squared).filter(|t| *t > t_min);
                }
                let middle = -dot(from, d) / squared;
                let nearest = along(from, d, middle);
                let rest = radius * radius - dot(nearest, nearest);
                if rest < 0.0 {
                    return None;
                }
                let half = (rest / squared).sqrt();
                [middle - half, middle + half].into_iter().find(|t| *t > t_min)
            }
        }
    }
}

/// Möller and Trumbore (1997).
fn meet_triangle(o: V, d: V, [a, b, c]: [V; 3]) -> Option<f64> {
    let (e1, e2) = (sub(b, a), sub(c, a));
    let p = cross(d, e2);
    let determinant = dot(e1, p);
    if determinant == 0.0 {
        return None;
    }
    let from = sub(o, a);
    let u = dot(from, p) / determinant;
    let q = cross(from, e1);
    let v = dot(d, q) / determinant;
    (u >= 0.0 && v >= 0.0 && u + v <= 1.0).then(|| dot(e2, q) / determinant)
}

/// Where a ray meets a primitive: at `entry + rest`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Meeting {
    /// Number of the primitive.
    pub(crate) primitive: usize,
    /// Where the ray's origin was moved to: a number that `t` is large beside `rest`.
    pub(crate) entry: f64,
    pub(crate) rest: f64,
    pub(crate) point: V,
}

impl Meeting {
    pub(crate) fn t(&self) -> f64 {
        self.entry + self.rest
    }
}

struct Node {
    bounds: [V; 2],
    /// Inner: the second child (the first follows the node). Leaf: the first primitive.
    first: usize,
    /// 0 for inner nodes.
    count: usize,
}

/// A hierarchy that is split at the median.
pub(crate) struct Double {
    shapes: Vec<Shape>,
    order: Vec<usize>,
    nodes: Vec<Node>,
    center: V,
}

impl Double {
    pub(crate) fn new(shapes: Vec<Shape>) -> Double {
        let bounds: Vec<[V; 2]> = shapes.iter().map(Shape::bounds).collect();
        let mut tree =
            Double { order: (0..shapes.len()).collect(), shapes, nodes: Vec::new(), center: [0.0; 3] };
        if !tree.shapes.is_empty() {
            tree.split(&bounds, 0, bounds.len());
            // The middle of the primitives, not of the box: a large ground is one of them.
            let middles = bounds.iter().map(|[low, high]| scaled(add(*low, *high), 0.5));
            tree.center = scaled(middles.fold([0.0; 3], add), 1.0 / bounds.len() as f64);
        }
        tree
    }

    fn split(&mut self, bounds: &[[V; 2]], first: usize, last: usize) {
        let all = self.order[first..last].iter().fold([[f64::MAX; 3], [f64::MIN; 3]], |[low, high], &k| {
            let [l, h] = bounds[k];
            [[0, 1, 2].map(|i| low[i].min(l[i])), [0, 1, 2].map(|i| high[i].max(h[i]))]
        });
        // Wider than any rounding of the boxes' tests.
        let slack = 1e-12 * largest(all[0]).max(largest(all[1]));
        let padded = [all[0].map(|x| x - slack), all[1].map(|x| x + slack)];
        let at = self.nodes.len();
        self.nodes.push(Node { bounds: padded, first, count: last - first });
        if last - first <= 4 {
            return;
        }
        let size = sub(all[1], all[0]);
        let axis = (0..3).max_by(|&i, &j| size[i].total_cmp(&size[j])).unwrap_or(0);
        let middle = first + (last - first) / 2;
        let key = |k: &usize| bounds[*k][0][axis] + bounds[*k][1][axis];
        self.order[first..last].select_nth_unstable_by(middle - first, |a, b| key(a).total_cmp(&key(b)));
        self.split(bounds, first, middle);
        let second = self.nodes.len();
        self.split(bounds, middle, last);
        self.nodes[at] = Node { bounds: padded, first: second, count: 0 };
    }

    pub(crate) fn shape(&self, primitive: usize) -> &Shape {
        &self.shapes[primitive]
    }

    /// The first primitive on the ray within `0 < t <= t_max`. `start` is the primitive that the origin lies on.
    pub(crate) fn closest(&self, o: V, d: V, t_max: f64, start: Option<usize>) -> Option<Meeting> {
        self.first(o, d, t_max, start, false)
    }

    /// Whether there is one.
    pub(crate) fn any(&self, o: V, d: V, t_max: f64, start: Option<usize>) -> bool {
        self.first(o, d, t_max, start, true).is_some()
    }

    fn first(&self, o: V, d: V, t_max: f64, start: Option<usize>, any: bool) -> Option<Meeting> {
        // From a surface, the origin is where it is.
        let (from, entry) = if start.is_some() { (o, 0.0) } else { self.approach(o, d) };
        // Nearer than this is the surface that the ray starts on, at a neighbour's edge.
        let nearest = if start.is_some() { 1e-13 * (largest(o) + 1e-30) / length(d) } else { -entry };
        let inverse = d.map(|x| 1.0 / x);
        let (mut best, mut limit) = (None, t_max - entry);
        let mut pending = vec![0usize];
        while let Some(at) = pending.pop() {
            let Some(node) = self.nodes.get(at) else { break };
            if !enters(&node.bounds, from, inverse, nearest, limit) {
                continue;
            }
            if node.count == 0 {
                pending.extend([node.first, at + 1]);
                continue;
            }
            for &primitive in &self.order[node.first..node.first + node.count] {
                let met = self.shapes[primitive].meet(from, d, nearest, start == Some(primitive));
                // A tie goes to the lowest number.
                let wins = |t: f64| t < limit || (t == limit && best.is_none_or(|(_, k)| primitive < k));
                if let Some(t) = met.filter(|t| wins(*t)) {
                    (best, limit) = (Some((t, primitive)), t);
                    if any {
                        pending.clear();
                    }
                }
            }
        }
        best.map(|(rest, primitive)| Meeting { primitive, entry, rest, point: along(from, d, rest) })
    }

    /// Moves an origin along its ray to where it passes the middle of the scene, where that lies ahead. A step has 28 bits
    /// and the direction's numbers have 24: products are exact, and a sum of two numbers that nearly cancel is, too.
    fn approach(&self, o: V, d: V) -> (V, f64) {
        let (mut from, mut entry) = (o, 0.0);
        for _ in 0..3 {
            let step = dot(sub(self.center, from), d) / dot(d, d);
            let step = f64::from_bits(step.to_bits() & !((1 << 25) - 1));
            if entry + step <= 0.0 || !step.is_finite() {
                break;
            }
            from = along(from, d, step);
            entry += step;
        }
        (from, entry)
    }
}

fn enters([low, high]: &[V; 2], o: V, inverse: V, t_min: f64, t_max: f64) -> bool {
    let (mut near, mut far) = (t_min, t_max);
    for i in 0..3 {
        let (a, b) = ((low[i] - o[i]) * inverse[i], (high[i] - o[i]) * inverse[i]);
        // Zero times infinity: in a plane of the box, which does not limit then.
        if !a.is_nan() && !b.is_nan() {
            near = near.max(a.min(b));
            far = far.min(a.max(b));
        }
    }
    near <= far + 1e-12 * far.abs().max(near.abs())
}
