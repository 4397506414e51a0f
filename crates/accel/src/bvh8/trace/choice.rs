//! What suits the rays of a chunk.

use eosphor_core::math::Vec3;
use eosphor_core::ray::Ray;

/// Ways to trace a chunk.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Way {
    /// Packets of neighbours.
    Packets,
    /// Packets of neighbours that go into one octant, where the hierarchy is small.
    SortedPackets,
    /// Each on its own way: in a stream, where there are enough of them.
    Scattered,
}

/// Rays of a packet.
const GROUP: usize = 16;
/// Groups that are looked at, spread over the chunk.
const SAMPLES: usize = 8;
/// Rays of a group that are looked at.
const LOOKED_AT: usize = 4;
/// Directions of a coherent group differ by no more than this in a component.
const NARROW: f32 = 0.25;
/// Neighbours start close together if the distance is no more than this times the scene's extent, in the middle.
const CLOSE: f32 = 0.04;
/// Those that go into nearly the same direction may start further apart.
const CLOSE_IF_NARROW: f32 = 0.2;

/// Blocks of a hierarchy that is so flat that rays of one octant meet most of it: they stay together wherever they start. (A box
/// of 36 triangles: paths 1.2 times as fast. With hundreds of blocks there is no gain, with thousands it is a loss.)
pub(super) const FLAT: usize = 16;
/// Blocks of a hierarchy that is so small that rays which start close together stay together for much of their way: their packets
/// are up to twice as fast as streams. (With 22,000 blocks both are equal around a bunny, and in a room streams are 1.6 times as
/// fast.)
const SMALL: usize = 8000;
/// With so many rays, each octant has some registers of them.
const OCTANTS_FULL: usize = 256;

/// Looks at some rays of a chunk, for a hierarchy of so many blocks, and chooses.
#[inline(always)]
pub(super) fn choose(rays: &[Ray], extent: f32, blocks: usize) -> Way {
    if rays.len() < GROUP {
        return Way::Scattered;
    }
    let groups = rays.len() / GROUP;
    let step = (groups / SAMPLES).max(1);
    let seen = groups.min(SAMPLES);
    // Copied first, so that all of them are on their way from memory at a time.
    let mut samples = [[rays[0]; LOOKED_AT]; SAMPLES];
    for (k, sample) in samples[..seen].iter_mut().enumerate() {
        let group = &rays[k * step * GROUP..][..GROUP];
        for (lane, ray) in sample.iter_mut().enumerate() {
            *ray = group[lane * (GROUP - 1) / (LOOKED_AT - 1)];
        }
    }
    let (mut narrow, mut close) = (0, 0);
    for sample in &samples[..seen] {
        let (direction, origin) = (spread(sample, |r| r.direction), spread(sample, |r| r.origin));
        // NaN is neither narrow nor close.
        narrow += ((direction <= NARROW) & (origin <= CLOSE_IF_NARROW * extent)) as usize;
        close += (origin <= CLOSE * extent) as usize;
    }
    if 2 * narrow >= seen {
        Way::Packets
    } else if ((2 * close >= seen) & (blocks <= SMALL)) | ((blocks <= FLAT) & (rays.len() >= OCTANTS_FULL)) {
        Way::SortedPackets
    } else {
        Way::Scattered
    }
}

/// The largest difference in a component.
#[inline(always)]
fn spread(rays: &[Ray], of: impl Fn(&Ray) -> Vec3) -> f32 {
    let first = of(&rays[0]);
    let (mut low, mut high) = (first, first);
    for ray in rays {
        (low, high) = (low.min(of(ray)), high.max(of(ray)));
    }
    (high - low).max_component()
}

#[cfg(test)]
mod tests {
    use super::*;
    use eosphor_core::math::vec3;

    fn rays(count: usize, of: impl Fn(f32) -> (Vec3, Vec3)) -> Vec<Ray> {
        let ray = |k: usize| {
            let (origin, direction) = of(k as f32);
            Ray { origin, t_min: 0.0, direction, t_max: f32::INFINITY }
        };
        (0..count).map(ray).collect()
    }

    #[test]
    fn camera_rays_go_in_packets_scattered_ones_alone() {
        let camera = rays(4096, |k| (Vec3::ZERO, vec3((k % 64.0) / 200.0 - 0.16, k / 40960.0, 1.0)));
        assert_eq!(choose(&camera, 1.0, 1000), Way::Packets);
        let bounce =
            rays(4096, |k| (vec3(k / 4096.0, 0.0, 0.0), vec3((k * 7.7).sin(), (k * 3.1).cos(), 0.3)));
        assert_eq!(choose(&bounce, 1.0, 1000), Way::SortedPackets);
        assert_eq!(choose(&bounce, 1.0, 10_000), Way::Scattered);
        let anywhere =
            rays(4096, |k| (vec3((k * 1.3).sin(), 0.0, 0.0), vec3((k * 7.7).sin(), (k * 3.1).cos(), 0.3)));
        assert_eq!(choose(&anywhere, 1.0, 1000), Way::Scattered);
        assert_eq!(choose(&anywhere, 1.0, 16), Way::SortedPackets);
        assert_eq!(choose(&anywhere[..255], 1.0, 16), Way::Scattered);
    }
}
