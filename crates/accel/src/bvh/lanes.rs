//! Four numbers at a time: x, y, z and a fourth that carries what else belongs to a point.
//!
//! On x86-64 these are SSE registers (part of the architecture, so nothing is dispatched), elsewhere arrays. Both give
//! the same bits.

/// A box to add points and boxes to; the fourth lanes are without meaning.
#[derive(Clone, Copy)]
pub(super) struct Box4 {
    pub(super) low: Lanes,
    pub(super) high: Lanes,
}

impl Box4 {
    /// The box that holds nothing.
    #[inline(always)]
    pub(super) fn empty() -> Box4 {
        Box4 { low: Lanes::splat(f32::INFINITY), high: Lanes::splat(f32::NEG_INFINITY) }
    }

    #[inline(always)]
    pub(super) fn union(self, o: Box4) -> Box4 {
        Box4 { low: o.low.min(self.low), high: o.high.max(self.high) }
    }

    #[inline(always)]
    pub(super) fn including(self, p: Lanes) -> Box4 {
        Box4 { low: p.min(self.low), high: p.max(self.high) }
    }

    /// What both hold; inside out where that is nothing.
    #[inline(always)]
    pub(super) fn intersection(self, o: Box4) -> Box4 {
        Box4 { low: self.low.max(o.low), high: self.high.min(o.high) }
    }

    /// A box that adds nothing to others, if `yes`.
    #[inline(always)]
    pub(super) fn nothing_if(self, yes: bool) -> Box4 {
        Box4 { low: self.low.nan_if(yes), high: self.high.nan_if(yes) }
    }

    /// Whether it is not inside out.
    #[inline(always)]
    pub(super) fn holds_something(&self) -> bool {
        let (l, h) = (self.low.array(), self.high.array());
        (l[0] <= h[0]) & (l[1] <= h[1]) & (l[2] <= h[2])
    }

    /// Half the surface area of a box that holds something.
    #[inline(always)]
    pub(super) fn half_area(self) -> f32 {
        let d = self.high.minus(self.low).array();
        d[0] * d[1] + d[1] * d[2] + d[2] * d[0]
    }

    /// Half the surface area; 0 for boxes that are inside out.
    #[inline(always)]
    pub(super) fn half_area_or_zero(self) -> f32 {
        let d = self.high.minus(self.low).array();
        if (d[0] < 0.0) | (d[1] < 0.0) | (d[2] < 0.0) { 0.0 } else { d[0] * d[1] + d[1] * d[2] + d[2] * d[0] }
    }

    #[inline(always)]
    pub(super) fn bounds(self) -> eosphor_core::geometry::Bounds {
        let (l, h) = (self.low.array(), self.high.array());
        use eosphor_core::math::vec3;
        eosphor_core::geometry::Bounds { min: vec3(l[0], l[1], l[2]), max: vec3(h[0], h[1], h[2]) }
    }

    /// As `Bounds::with_slack`.
    #[inline(always)]
    pub(super) fn with_slack(self) -> Box4 {
        let slack = Lanes::splat(eosphor_core::intersect::BOX_SLACK);
        Box4 {
            low: self.low.minus(self.low.abs().times(slack)),
            high: self.high.plus(self.high.abs().times(slack)),
        }
    }
}

#[cfg(target_arch = "x86_64")]
mod imp {
    use core::arch::x86_64::*;
    use eosphor_core::math::Vec3;

    /// Calls intrinsics of SSE2.
    macro_rules! sse2 {
        ($e:expr) => {
            // SAFETY: instruction set: SSE2 is part of x86-64; pointers are to arrays of four numbers.
            unsafe { $e }
        };
    }

    #[derive(Clone, Copy)]
    #[repr(transparent)]
    pub(in super::super) struct Lanes(__m128);

    impl Lanes {
        #[inline(always)]
        pub(in super::super) fn new(x: f32, y: f32, z: f32, w: f32) -> Lanes {
            Lanes(sse2!(_mm_setr_ps(x, y, z, w)))
        }
        #[inline(always)]
        pub(in super::super) fn splat(x: f32) -> Lanes {
            Lanes(sse2!(_mm_set1_ps(x)))
        }
        #[inline(always)]
        pub(in super::super) fn array(self) -> [f32; 4] {
            let mut a = [0.0; 4];
            sse2!(_mm_storeu_ps(a.as_mut_ptr(), self.0));
            a
        }
        #[inline(always)]
        pub(in super::super) fn from_array(a: &[f32; 4]) -> Lanes {
            Lanes(sse2!(_mm_loadu_ps(a.as_ptr())))
        }
        /// The corners of a triangle; the fourth lanes are any of its coordinates.
        #[inline(always)]
        pub(in super::super) fn corners(triangle: &[Vec3; 3]) -> [Lanes; 3] {
            let p = triangle.as_ptr().cast::<f32>();
            // SAFETY: of the nine coordinates, these are 0 to 3, 3 to 6 and 5 to 8.
            let [a, b, c] = unsafe { [_mm_loadu_ps(p), _mm_loadu_ps(p.add(3)), _mm_loadu_ps(p.add(5))] };
            [Lanes(a), Lanes(b), Lanes(sse2!(_mm_shuffle_ps::<0b11_11_10_01>(c, c)))]
        }
        /// Lane by lane the smaller number; `o`'s where either is NaN.
        #[inline(always)]
        pub(in super::super) fn min(self, o: Lanes) -> Lanes {
            Lanes(sse2!(_mm_min_ps(self.0, o.0)))
        }
        /// Lane by lane the larger number; `o`'s where either is NaN.
        #[inline(always)]
        pub(in super::super) fn max(self, o: Lanes) -> Lanes {
            Lanes(sse2!(_mm_max_ps(self.0, o.0)))
        }
        #[inline(always)]
        pub(in super::super) fn plus(self, o: Lanes) -> Lanes {
            Lanes(sse2!(_mm_add_ps(self.0, o.0)))
        }
        #[inline(always)]
        pub(in super::super) fn minus(self, o: Lanes) -> Lanes {
            Lanes(sse2!(_mm_sub_ps(self.0, o.0)))
        }
        #[inline(always)]
        pub(in super::super) fn times(self, o: Lanes) -> Lanes {
            Lanes(sse2!(_mm_mul_ps(self.0, o.0)))
        }
        #[inline(always)]
        pub(in super::super) fn over(self, o: Lanes) -> Lanes {
            Lanes(sse2!(_mm_div_ps(self.0, o.0)))
        }
        #[inline(always)]
        pub(in super::super) fn abs(self) -> Lanes {
            Lanes(sse2!(_mm_andnot_ps(_mm_set1_ps(-0.0), self.0)))
        }
        /// The fourth lane becomes 0.
        #[inline(always)]
        pub(in super::super) fn xyz0(self) -> Lanes {
            let mask = sse2!(_mm_castsi128_ps(_mm_setr_epi32(-1, -1, -1, 0)));
            Lanes(sse2!(_mm_and_ps(self.0, mask)))
        }
        /// NaN in all lanes if `yes`, else unchanged. `min` and `max` of NaN with another number give that number.
        #[inline(always)]
        pub(in super::super) fn nan_if(self, yes: bool) -> Lanes {
            Lanes(sse2!(_mm_or_ps(self.0, _mm_castsi128_ps(_mm_set1_epi32(-i32::from(yes))))))
        }
        /// Whole parts of numbers between 0 and 2^31.
        #[inline(always)]
        pub(in super::super) fn whole(self) -> [u32; 4] {
            let mut a = [0; 4];
            sse2!(_mm_storeu_si128(a.as_mut_ptr().cast(), _mm_cvttps_epi32(self.0)));
            a
        }
        /// Whole parts of numbers between 0 and 2^10, their bits three places apart.
        #[inline(always)]
        pub(in super::super) fn spread_whole(self) -> [u32; 4] {
            macro_rules! step {
                ($x:ident, $by:literal, $mask:literal) => {
                    sse2!(_mm_and_si128(_mm_or_si128($x, _mm_slli_epi32::<$by>($x)), _mm_set1_epi32($mask)))
                };
            }
            let x = sse2!(_mm_cvttps_epi32(self.0));
            let x = step!(x, 16, 0x0300_00ff);
            let x = step!(x, 8, 0x0300_f00f);
            let x = step!(x, 4, 0x030c_30c3);
            let x = step!(x, 2, 0x0924_9249);
            let mut a = [0; 4];
            sse2!(_mm_storeu_si128(a.as_mut_ptr().cast(), x));
            a
        }
    }
}

#[cfg(not(target_arch = "x86_64"))]
mod imp {
    use eosphor_core::math::Vec3;

    #[derive(Clone, Copy)]
    #[repr(align(16))]
    pub(in super::super) struct Lanes([f32; 4]);

    impl Lanes {
        #[inline(always)]
        fn zip(self, o: Lanes, f: impl Fn(f32, f32) -> f32) -> Lanes {
            Lanes(std::array::from_fn(|i| f(self.0[i], o.0[i])))
        }
        #[inline(always)]
        pub(in super::super) fn new(x: f32, y: f32, z: f32, w: f32) -> Lanes {
            Lanes([x, y, z, w])
        }
        #[inline(always)]
        pub(in super::super) fn splat(x: f32) -> Lanes {
            Lanes([x; 4])
        }
        #[inline(always)]
        pub(in super::super) fn abs(self) -> Lanes {
            Lanes(self.0.map(f32::abs))
        }
        #[inline(always)]
        pub(in super::super) fn array(self) -> [f32; 4] {
            self.0
        }
        #[inline(always)]
        pub(in super::super) fn from_array(a: &[f32; 4]) -> Lanes {
            Lanes(*a)
        }
        /// The corners of a triangle; the fourth lanes are any of its coordinates.
        #[inline(always)]
        pub(in super::super) fn corners(triangle: &[Vec3; 3]) -> [Lanes; 3] {
            triangle.map(|v| Lanes([v.x, v.y, v.z, v.z]))
        }
        /// Lane by lane the smaller number; `o`'s where either is NaN.
        #[inline(always)]
        pub(in super::super) fn min(self, o: Lanes) -> Lanes {
            self.zip(o, |a, b| if a < b { a } else { b })
        }
        /// Lane by lane the larger number; `o`'s where either is NaN.
        #[inline(always)]
        pub(in super::super) fn max(self, o: Lanes) -> Lanes {
            self.zip(o, |a, b| if a > b { a } else { b })
        }
        #[inline(always)]
        pub(in super::super) fn plus(self, o: Lanes) -> Lanes {
            self.zip(o, |a, b| a + b)
        }
        #[inline(always)]
        pub(in super::super) fn minus(self, o: Lanes) -> Lanes {
            self.zip(o, |a, b| a - b)
        }
        #[inline(always)]
        pub(in super::super) fn times(self, o: Lanes) -> Lanes {
            self.zip(o, |a, b| a * b)
        }
        #[inline(always)]
        pub(in super::super) fn over(self, o: Lanes) -> Lanes {
            self.zip(o, |a, b| a / b)
        }
        /// The fourth lane becomes 0.
        #[inline(always)]
        pub(in super::super) fn xyz0(self) -> Lanes {
            Lanes([self.0[0], self.0[1], self.0[2], 0.0])
        }
        /// NaN in all lanes if `yes`, else unchanged. `min` and `max` of NaN with another number give that number.
        #[inline(always)]
        pub(in super::super) fn nan_if(self, yes: bool) -> Lanes {
            if yes { Lanes([f32::NAN; 4]) } else { self }
        }
        /// Whole parts of numbers between 0 and 2^31.
        #[inline(always)]
        pub(in super::super) fn whole(self) -> [u32; 4] {
            self.0.map(|x| x as u32)
        }
        /// Whole parts of numbers between 0 and 2^10, their bits three places apart.
        #[inline(always)]
        pub(in super::super) fn spread_whole(self) -> [u32; 4] {
            self.0.map(|x| {
                let x = x as u32;
                let x = (x | (x << 16)) & 0x0300_00ff;
                let x = (x | (x << 8)) & 0x0300_f00f;
                let x = (x | (x << 4)) & 0x030c_30c3;
                (x | (x << 2)) & 0x0924_9249
            })
        }
    }
}

pub(super) use imp::Lanes;
