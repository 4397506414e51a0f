//! Light by light: shadow rays of all points of a batch.

use super::lit::{Block, LANES, LitPoints, Side};
use eosphor_accel::{BatchTracer, Coherence, Filters};
use eosphor_core::integrator::transmittance_beyond;
use eosphor_core::integrator::whitted::{
    LightLanes, LightSums, Receivers, choose_lamps, choose_lamps_from, drawn_lamp, gather, highlight,
    is_lit_from_behind, light_key, lights_alone, shade_direct, shadow_filter, ways_to_lamps,
};
use eosphor_core::light::{ChosenLight, Light, TopWays, TreeTop, TriangleLampLanes};
use eosphor_core::math::{Vec3, Vec3Lanes};
use eosphor_core::ray::{Hit, Ray, RayFilter};
use eosphor_core::settings::ShadowMode;
use eosphor_core::view::SceneView;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};

/// Rays from one point to samples of a light: so many fill a packet of sixteen. Of those that do not, one sample of all points
/// is traced together.
const MIN_SAMPLES_OF_A_PACKET: u32 = 12;

/// Samples of a light that are traced together from one point: three packets, as PG1's 50 have.
const SAMPLES_TOGETHER: usize = 48;

/// Of this many samples of a light, how many first ones each point's own packets take.
fn samples_of_own_packets(samples: u32) -> u32 {
    if samples % 16 < MIN_SAMPLES_OF_A_PACKET { samples - samples % 16 } else { samples }
}

/// Lamps of one point that are drawn together.
const DRAWS_TOGETHER: u32 = 16;

/// With so many draws, and nodes of the tree of lights, all ways through the tree's first levels are followed at once.
const MIN_DRAWS_FOR_WAYS: u32 = 6;
const MIN_NODES_FOR_WAYS: usize = 16;

/// A lamp that is drawn for each point.
struct Draw {
    /// Its number among the draws of a point.
    number: u32,
    /// Its place in [`Shadows::chosen`] for the first block, and how far it is from there to that for the next one.
    place: usize,
    step: usize,
}

/// What a block's points may get of a light.
#[derive(Clone, Copy)]
struct Offered {
    lanes: LightLanes<LANES>,
    got: Got,
    /// The lanes that the light reaches unless something is in the way.
    active: [bool; LANES],
}

impl Offered {
    const NOTHING: Offered = Offered { lanes: LightLanes::NONE, got: Got::NOTHING, active: [false; LANES] };
}

/// What a block's points get of a light.
#[derive(Clone, Copy)]
struct Got {
    diffuse: Vec3Lanes<LANES>,
    specular: Vec3Lanes<LANES>,
}

impl Got {
    const NOTHING: Got = Got { diffuse: Vec3Lanes::ZERO, specular: Vec3Lanes::ZERO };

    #[inline(always)]
    fn get(&self, lane: usize) -> LightSums {
        LightSums { diffuse: self.diffuse.get(lane), specular: self.specular.get(lane) }
    }

    #[inline(always)]
    fn set(&mut self, lane: usize, sums: &LightSums) {
        self.diffuse.set(lane, sums.diffuse);
        self.specular.set(lane, sums.specular);
    }
}

/// Shadow rays of a batch.
#[derive(Default)]
pub(super) struct Shadows {
    rays: Vec<Ray>,
    filters: Vec<RayFilter>,
    hidden: Vec<bool>,
    /// Of those that something hides, where shadows have colours: the rays, and what they meet first.
    behind: (Vec<Ray>, Vec<RayFilter>, Vec<Hit>),
    offered: Vec<Offered>,
    /// Lamps that are drawn, for each block, side and draw.
    chosen: Vec<[Option<ChosenLight>; LANES]>,
    /// Of each ray to a lamp that was drawn, the number of that.
    drawn: Vec<u32>,
}

/// A light, and which side of the points it shines on.
struct Lamp<'a> {
    light: &'a Light,
    number: u32,
    side: u32,
}

impl Lamp<'_> {
    /// The points of a block as the lamp sees them, for sample `sample` of each.
    #[inline(always)]
    fn receivers<'b>(&self, view: &SceneView, block: &'b Block, sample: u32) -> Side<'b> {
        let mut side = Side::new(block, self.side);
        // Only lights with a size are sampled at random places.
        if self.light.is_lamp() {
            let samples = self.light.samples();
            self.set_keys(view, block, &mut side);
            for lane in 0..LANES {
                side.index[lane] = block.sample[lane].wrapping_mul(samples).wrapping_add(sample);
            }
        }
        self.set_highlights(block, &mut side);
        side
    }

    /// The points of a block that lamps are drawn for.
    #[inline(always)]
    fn drawing_receivers<'b>(&self, view: &SceneView, block: &'b Block) -> Side<'b> {
        let mut side = Side::new(block, self.side);
        self.set_keys(view, block, &mut side);
        side.index = block.sample;
        self.set_highlights(block, &mut side);
        side
    }

    #[inline(always)]
    fn set_keys(&self, view: &SceneView, block: &Block, side: &mut Side) {
        for lane in 0..LANES {
            side.key[lane] = light_key(block.key(view.settings, lane), self.number, self.side);
        }
    }

    #[inline(always)]
    fn set_highlights(&self, block: &Block, side: &mut Side) {
        for lane in 0..LANES {
            side.highlights[lane] = self.highlight(block, lane).1;
            side.any_highlights |= side.highlights[lane];
        }
    }

    /// Its highlight on a point: the colour, and whether there is one.
    #[inline(always)]
    fn highlight(&self, block: &Block, lane: usize) -> (Vec3, bool) {
        highlight(self.light, block.specular(lane), block.lamp_highlights(lane), block.lobe(lane))
    }

    /// Whether a point has the side.
    #[inline(always)]
    fn shines_on(&self, view: &SceneView, block: &Block, lane: usize) -> bool {
        self.side == 0 || is_lit_from_behind(view.settings, block.transmission(lane))
    }

    /// The lanes of the first `count` points of a block that have the side.
    #[inline(always)]
    fn lit_lanes(&self, view: &SceneView, block: &Block, count: usize) -> [bool; LANES] {
        let mut is_lit = [false; LANES];
        for lane in 0..count {
            is_lit[lane] = self.shines_on(view, block, lane);
        }
        is_lit
    }

    /// Adds what the first `count` points of a block make of the light that they got.
    #[inline(always)]
    fn add_to(&self, view: &SceneView, block: &mut Block, count: usize, got: &Got) {
        let color = self.light.le();
        if self.side == 0 && !block.has_lobes() {
            // All lanes together: idle ones got nothing.
            for lane in 0..LANES {
                let (diffuse, specular) = (block.diffuse(lane), block.specular(lane));
                block.add_light(lane, shade_direct(color, diffuse, specular, Vec3::ZERO, 0, &got.get(lane)));
            }
            return;
        }
        for lane in 0..count {
            if self.shines_on(view, block, lane) {
                self.add_to_lane(color, block, lane, &got.get(lane));
            }
        }
    }

    /// Adds what a point makes of light of this colour that it got.
    #[inline(always)]
    fn add_to_lane(&self, color: Vec3, block: &mut Block, lane: usize, got: &LightSums) {
        let (diffuse, (specular, _)) = (block.diffuse(lane), self.highlight(block, lane));
        let transmission = block.transmission(lane);
        block.add_light(lane, shade_direct(color, diffuse, specular, transmission, self.side, got));
    }
}

impl Shadows {
    /// Adds the light of all lights to all points: lights by number, sides and samples by number, as `direct_light`
    /// does it for one point. `None` where the tile is given up.
    #[inline(always)]
    pub(super) fn add_light<T: BatchTracer>(
        &mut self,
        view: &SceneView,
        tracer: &T,
        points: &mut LitPoints,
        shadow_rays: &mut u64,
        cancel: &AtomicBool,
    ) -> Option<()> {
        let sides = 1 + view.settings.light_from_behind as u32;
        let alone = lights_alone(view);
        for (number, light) in view.lights[..alone as usize].iter().enumerate() {
            for side in 0..sides {
                let lamp = Lamp { light, number: number as u32, side };
                self.offered.clear();
                self.offered.resize(points.blocks.len(), Offered::NOTHING);
                let samples = light.samples();
                let own = samples_of_own_packets(samples);
                if own > 0 {
                    self.point_by_point(view, tracer, (&lamp, own), points, shadow_rays, cancel)?;
                }
                self.sample_by_sample(view, tracer, (&lamp, own..samples), points, shadow_rays);
                for number in 0..points.blocks.len() {
                    let count = points.points_in(number);
                    lamp.add_to(view, &mut points.blocks[number], count, &self.offered[number].got);
                }
            }
            if cancel.load(Ordering::Relaxed) {
                return None;
            }
        }
        let Some(light) = view.lights.get(alone as usize) else { return Some(()) };
        // The first lamp stands for all.
        let lamps = [0, 1].map(|side| Lamp { light, number: alone, side });
        let lamps = &lamps[..sides as usize];
        let draws = view.settings.lamp_samples;
        let has_ways = draws >= MIN_DRAWS_FOR_WAYS && view.light_nodes.len() >= MIN_NODES_FOR_WAYS;
        let top = has_ways.then(|| TreeTop::new(&view.light_tree()));
        for first in (0..draws).step_by(DRAWS_TOGETHER as usize) {
            let draws = first..draws.min(first + DRAWS_TOGETHER);
            self.choose(view, top.as_ref(), lamps, draws.clone(), points);
            for number in draws.clone() {
                for (side, lamp) in lamps.iter().enumerate() {
                    let place = side * draws.len() + (number - first) as usize;
                    let draw = Draw { number, place, step: lamps.len() * draws.len() };
                    self.add_drawn(view, tracer, lamp, &draw, points, shadow_rays);
                }
                if cancel.load(Ordering::Relaxed) {
                    return None;
                }
            }
        }
        Some(())
    }

    /// Chooses lamps for all points: of each block for each side, of each side for each draw.
    #[inline(always)]
    fn choose(
        &mut self,
        view: &SceneView,
        top: Option<&TreeTop>,
        lamps: &[Lamp],
        draws: Range<u32>,
        points: &LitPoints,
    ) {
        self.chosen.clear();
        for (number, block) in points.blocks.iter().enumerate() {
            for lamp in lamps {
                let side = lamp.drawing_receivers(view, block);
                let is_wanted = lamp.lit_lanes(view, block, points.points_in(number));
                let receiver = |lane| side.receiver(lane);
                let Some(top) = top else {
                    for draw in draws.clone() {
                        let mut chosen = choose_lamps(view, &is_wanted, receiver, draw);
                        for lane in (0..LANES).filter(|&lane| !is_wanted[lane]) {
                            chosen[lane] = None;
                        }
                        self.chosen.push(chosen);
                    }
                    continue;
                };
                let mut ways = [TopWays::NONE; LANES];
                for lane in (0..LANES).filter(|&lane| is_wanted[lane]) {
                    ways[lane] = ways_to_lamps(top, &receiver(lane));
                }
                for draw in draws.clone() {
                    self.chosen.push(choose_lamps_from(view, (top, &ways), &is_wanted, receiver, draw));
                }
            }
        }
    }

    /// The light of a lamp that is drawn for each point.
    #[inline(always)]
    fn add_drawn<T: BatchTracer>(
        &mut self,
        view: &SceneView,
        tracer: &T,
        lamp: &Lamp,
        draw: &Draw,
        points: &mut LitPoints,
        shadow_rays: &mut u64,
    ) {
        self.ask_drawn(view, lamp, points, draw);
        self.trace(view, tracer, Coherence::Incoherent, shadow_rays);
        self.take(view, tracer);
        let mut drawn = self.drawn.iter();
        for (block, offered) in points.blocks.iter_mut().zip(&self.offered) {
            for lane in (0..LANES).filter(|&lane| offered.active[lane]) {
                // As many as there are active lanes.
                let Some(&number) = drawn.next() else { return };
                let light = &view.lights[number as usize];
                lamp.add_to_lane(light.le(), block, lane, &offered.got.get(lane));
            }
        }
    }

    /// Traces the rays. Where shadows have colours, also what hides light first.
    #[inline(always)]
    fn trace<T: BatchTracer>(
        &mut self,
        view: &SceneView,
        tracer: &T,
        coherence: Coherence,
        shadow_rays: &mut u64,
    ) {
        if view.settings.shadow_mode != ShadowMode::None {
            *shadow_rays += self.rays.len() as u64;
            self.hidden.resize(self.rays.len(), false);
            tracer.occluded_rays(&self.rays, Filters::Each(&self.filters), coherence, &mut self.hidden);
        }
        if view.settings.shadow_mode == ShadowMode::Coloured {
            let (rays, filters, hits) = &mut self.behind;
            rays.clear();
            filters.clear();
            for (at, _) in self.hidden.iter().enumerate().filter(|(_, hidden)| **hidden) {
                rays.push(self.rays[at]);
                filters.push(self.filters[at]);
            }
            hits.resize(rays.len(), Hit::miss(f32::INFINITY));
            tracer.closest_hits(rays, Filters::Each(filters), coherence, hits);
        }
    }

    /// Rays to the lamps that are drawn for the points.
    #[inline(always)]
    fn ask_drawn(&mut self, view: &SceneView, lamp: &Lamp, points: &LitPoints, draw: &Draw) {
        self.rays.clear();
        self.filters.clear();
        self.offered.clear();
        self.drawn.clear();
        let chosen = self.chosen.iter().skip(draw.place).step_by(draw.step);
        for (block, chosen) in points.blocks.iter().zip(chosen) {
            let mut side = lamp.drawing_receivers(view, block);
            let (mut triangles, mut scale) = (TriangleLampLanes::NONE, [0.0; LANES]);
            let mut others = [None; LANES];
            for lane in 0..LANES {
                let Some(chosen) = &chosen[lane] else { continue };
                let (number, receiver) = drawn_lamp(view, &side.receiver(lane), draw.number, chosen);
                match view.lights[number as usize].triangle_lamp() {
                    Some(triangle) => {
                        triangles.set(lane, &triangle);
                        (scale[lane], side.index[lane]) = (receiver.scale, receiver.first);
                    }
                    None => others[lane] = Some(receiver),
                }
            }
            let mut lanes = LightLanes::of_triangles(view.settings, &triangles, &scale, &side);
            let mut active = [false; LANES];
            for lane in 0..LANES {
                let Some(chosen) = &chosen[lane] else { continue };
                let light = &view.lights[chosen.number as usize];
                if let Some(receiver) = &others[lane] {
                    lanes.set(lane, &LightLanes::<1>::new(view.settings, light, receiver));
                }
                if lanes.brings(lane) {
                    active[lane] = true;
                    self.rays.push(lanes.ray(lane, side.origin(lane)));
                    self.filters.push(shadow_filter(light, block.id[lane]));
                    self.drawn.push(chosen.number);
                }
            }
            let offered = Offered { lanes, got: Got::NOTHING, active };
            self.offered.push(offered);
        }
    }

    /// One sample of all points after the other.
    #[inline(always)]
    fn sample_by_sample<T: BatchTracer>(
        &mut self,
        view: &SceneView,
        tracer: &T,
        (lamp, samples): (&Lamp, Range<u32>),
        points: &LitPoints,
        shadow_rays: &mut u64,
    ) {
        for sample in samples {
            self.ask(view, lamp, points, sample);
            self.trace(view, tracer, Coherence::Coherent, shadow_rays);
            self.take(view, tracer);
        }
    }

    /// Rays of one sample of each point.
    #[inline(always)]
    fn ask(&mut self, view: &SceneView, lamp: &Lamp, points: &LitPoints, sample: u32) {
        self.rays.clear();
        self.filters.clear();
        for (number, block) in points.blocks.iter().enumerate() {
            let side = lamp.receivers(view, block, sample);
            let lanes = LightLanes::<LANES>::new(view.settings, lamp.light, &side);
            let offered = &mut self.offered[number];
            offered.lanes = lanes;
            for lane in 0..LANES {
                let reached = lane < points.points_in(number) && lanes.brings(lane);
                offered.active[lane] = reached && lamp.shines_on(view, block, lane);
                if offered.active[lane] {
                    self.rays.push(lanes.ray(lane, side.origin(lane)));
                    self.filters.push(shadow_filter(lamp.light, block.id[lane]));
                }
            }
        }
    }

    /// What gets through.
    #[inline(always)]
    fn take<T: BatchTracer>(&mut self, view: &SceneView, tracer: &T) {
        let mode = view.settings.shadow_mode;
        let (mut ray, mut hits) = (0, self.behind.2.iter());
        for offered in &mut self.offered {
            for lane in 0..LANES {
                if !offered.active[lane] {
                    continue;
                }
                let asked = ray;
                ray += 1;
                let through = if mode == ShadowMode::None || !self.hidden[asked] {
                    Vec3::ONE
                } else if let Some(hit) = hits.next().filter(|_| mode == ShadowMode::Coloured) {
                    transmittance_beyond(view, tracer, &self.rays[asked], &self.filters[asked], hit)
                } else {
                    continue;
                };
                let mut got = offered.got.get(lane);
                got.add(through, offered.lanes.diffuse[lane], offered.lanes.specular[lane]);
                offered.got.set(lane, &got);
            }
        }
    }

    /// Their first samples, one point after the other.
    #[inline(always)]
    fn point_by_point<T: BatchTracer>(
        &mut self,
        view: &SceneView,
        tracer: &T,
        (lamp, samples): (&Lamp, u32),
        points: &LitPoints,
        shadow_rays: &mut u64,
        cancel: &AtomicBool,
    ) -> Option<()> {
        for number in 0..points.blocks.len() {
            let count = points.points_in(number);
            let block = &points.blocks[number];
            let side = lamp.receivers(view, block, 0);
            let got = &mut self.offered[number].got;
            for lane in 0..count {
                if lamp.shines_on(view, block, lane) {
                    let (receiver, filter) = (side.receiver(lane), shadow_filter(lamp.light, block.id[lane]));
                    let sums = gather::<T, SAMPLES_TOGETHER>(
                        view,
                        tracer,
                        (lamp.light, samples),
                        &receiver,
                        &filter,
                        shadow_rays,
                    );
                    got.set(lane, &sums);
                }
            }
            if cancel.load(Ordering::Relaxed) {
                return None;
            }
        }
        Some(())
    }
}
