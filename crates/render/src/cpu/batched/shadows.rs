//! Light by light: shadow rays of all points of a batch.

use super::lit::{Block, LANES, LitPoints, Side};
use eosphor_accel::{BatchTracer, Coherence, Filters};
use eosphor_core::integrator::transmittance;
use eosphor_core::integrator::whitted::{
    LightLanes, LightSums, gather, is_lit_from_behind, light_key, shade_direct,
};
use eosphor_core::integrator::whitted::{highlight, shadow_filter};
use eosphor_core::light::Light;
use eosphor_core::math::Vec3;
use eosphor_core::ray::{Ray, RayFilter};
use eosphor_core::settings::ShadowMode;
use eosphor_core::view::SceneView;
use std::sync::atomic::{AtomicBool, Ordering};

/// A light with at least this many samples fills packets from each point by itself; of others, one sample of all points
/// is traced together.
const MIN_SAMPLES_FOR_OWN_PACKETS: u32 = 12;

/// Samples of such a light that are traced together: of the 50 of PG1, no lane but two of the last four is idle.
const SAMPLES_TOGETHER: usize = 48;

/// What a block's points may get of a light.
#[derive(Clone, Copy)]
struct Offered {
    lanes: LightLanes<LANES>,
    got: [LightSums; LANES],
    /// The lanes that the light reaches unless something is in the way.
    active: [bool; LANES],
}

/// Shadow rays of a batch.
#[derive(Default)]
pub(super) struct Shadows {
    rays: Vec<Ray>,
    filters: Vec<RayFilter>,
    hidden: Vec<bool>,
    offered: Vec<Offered>,
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
            for lane in 0..LANES {
                side.key[lane] = light_key(block.key(view.settings, lane), self.number, self.side);
                side.index[lane] = block.sample[lane].wrapping_mul(samples).wrapping_add(sample);
            }
        }
        for lane in 0..LANES {
            side.highlights[lane] = self.highlight(block, lane).1;
            side.any_highlights |= side.highlights[lane];
        }
        side
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

    /// Adds what the first `count` points of a block make of the light that they got.
    #[inline(always)]
    fn add_to(&self, view: &SceneView, block: &mut Block, count: usize, got: &[LightSums; LANES]) {
        let color = self.light.le();
        for lane in 0..count {
            if self.shines_on(view, block, lane) {
                let (diffuse, (specular, _)) = (block.diffuse(lane), self.highlight(block, lane));
                let transmission = block.transmission(lane);
                let light = shade_direct(color, diffuse, specular, transmission, self.side, &got[lane]);
                block.add_light(lane, light);
            }
        }
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
        for (number, light) in view.lights.iter().enumerate() {
            for side in 0..sides {
                let lamp = Lamp { light, number: number as u32, side };
                if light.samples() >= MIN_SAMPLES_FOR_OWN_PACKETS {
                    self.point_by_point(view, tracer, &lamp, points, shadow_rays, cancel)?;
                } else {
                    self.sample_by_sample(view, tracer, &lamp, points, shadow_rays);
                }
            }
            if cancel.load(Ordering::Relaxed) {
                return None;
            }
        }
        Some(())
    }

    /// One sample of all points after the other.
    #[inline(always)]
    fn sample_by_sample<T: BatchTracer>(
        &mut self,
        view: &SceneView,
        tracer: &T,
        lamp: &Lamp,
        points: &mut LitPoints,
        shadow_rays: &mut u64,
    ) {
        let samples = lamp.light.samples();
        for sample in 0..samples {
            self.ask(view, lamp, points, sample);
            if view.settings.shadow_mode != ShadowMode::None {
                *shadow_rays += self.rays.len() as u64;
                self.hidden.resize(self.rays.len(), false);
                let filters = Filters::Each(&self.filters);
                tracer.occluded_rays(&self.rays, filters, Coherence::Coherent, &mut self.hidden);
            }
            self.take(view, tracer);
        }
        for number in 0..points.blocks.len() {
            let count = points.points_in(number);
            lamp.add_to(view, &mut points.blocks[number], count, &self.offered[number].got);
        }
    }

    /// Rays of one sample of each point.
    #[inline(always)]
    fn ask(&mut self, view: &SceneView, lamp: &Lamp, points: &LitPoints, sample: u32) {
        self.rays.clear();
        self.filters.clear();
        if sample == 0 {
            self.offered.clear();
        }
        for (number, block) in points.blocks.iter().enumerate() {
            let side = lamp.receivers(view, block, sample);
            let lanes = LightLanes::<LANES>::new(view.settings, lamp.light, &side);
            if sample == 0 {
                self.offered.push(Offered {
                    lanes,
                    got: [LightSums::default(); LANES],
                    active: [false; LANES],
                });
            }
            let offered = &mut self.offered[number];
            offered.lanes = lanes;
            for lane in 0..LANES {
                let reached = lane < points.points_in(number) && lanes.brings(lane);
                offered.active[lane] = reached && lamp.shines_on(view, block, lane);
                if offered.active[lane] {
                    self.rays.push(lanes.ray(lane, side.receiver(lane).origin));
                    self.filters.push(shadow_filter(lamp.light, block.id[lane]));
                }
            }
        }
    }

    /// What gets through.
    #[inline(always)]
    fn take<T: BatchTracer>(&mut self, view: &SceneView, tracer: &T) {
        let mode = view.settings.shadow_mode;
        let mut ray = 0;
        for offered in &mut self.offered {
            for lane in 0..LANES {
                if !offered.active[lane] {
                    continue;
                }
                let asked = ray;
                ray += 1;
                let through = if mode == ShadowMode::None || !self.hidden[asked] {
                    Vec3::ONE
                } else if mode == ShadowMode::Coloured {
                    transmittance(view, tracer, &self.rays[asked], &self.filters[asked])
                } else {
                    continue;
                };
                offered.got[lane].add(through, offered.lanes.diffuse[lane], offered.lanes.specular[lane]);
            }
        }
    }

    /// All samples of one point after the other.
    #[inline(always)]
    fn point_by_point<T: BatchTracer>(
        &mut self,
        view: &SceneView,
        tracer: &T,
        lamp: &Lamp,
        points: &mut LitPoints,
        shadow_rays: &mut u64,
        cancel: &AtomicBool,
    ) -> Option<()> {
        for number in 0..points.blocks.len() {
            let count = points.points_in(number);
            let block = &points.blocks[number];
            let side = lamp.receivers(view, block, 0);
            let mut got = [LightSums::default(); LANES];
            for lane in 0..count {
                if lamp.shines_on(view, block, lane) {
                    let (receiver, filter) = (side.receiver(lane), shadow_filter(lamp.light, block.id[lane]));
                    got[lane] = gather::<T, SAMPLES_TOGETHER>(
                        view,
                        tracer,
                        lamp.light,
                        &receiver,
                        &filter,
                        shadow_rays,
                    );
                }
            }
            lamp.add_to(view, &mut points.blocks[number], count, &got);
            if cancel.load(Ordering::Relaxed) {
                return None;
            }
        }
        Some(())
    }
}
