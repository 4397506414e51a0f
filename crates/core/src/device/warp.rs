//! The threads that walk together on a GPU. On a CPU every thread is alone.

#[cfg(target_arch = "nvptx64")]
mod target {
    use core::arch::asm;

    /// The lanes of a warp that came here together, as bits.
    #[derive(Clone, Copy)]
    pub(in super::super) struct Warp(u32);

    impl Warp {
        /// Those that are here.
        #[inline(always)]
        pub(in super::super) fn here() -> Warp {
            let lanes;
            // SAFETY: reads a register.
            unsafe {
                asm!("activemask.b32 {0};", out(reg32) lanes, options(nomem, nostack, preserves_flags))
            };
            Warp(lanes)
        }

        /// For how many this is true. All of them must ask, and do, since what they are told is the same.
        #[inline(always)]
        pub(in super::super) fn count(self, of: bool) -> u32 {
            let lanes: u32;
            // SAFETY: one warp: the mask is that of the lanes which vote here, all of which come.
            unsafe {
                asm!(
                    "{{.reg .pred p; setp.ne.u32 p, {1}, 0; vote.sync.ballot.b32 {0}, p, {2};}}",
                    out(reg32) lanes, in(reg32) of as u32, in(reg32) self.0, options(nostack)
                );
            }
            lanes.count_ones()
        }

        /// Whether the number is the same for all.
        #[inline(always)]
        pub(in super::super) fn agrees(self, number: u32) -> bool {
            let agrees: u32;
            // SAFETY: one warp: the mask is that of the lanes which compare here, all of which come.
            unsafe {
                asm!(
                    "{{.reg .pred p; .reg .b32 m; match.all.sync.b32 m|p, {1}, {2}; selp.u32 {0}, 1, 0, p;}}",
                    out(reg32) agrees, in(reg32) number, in(reg32) self.0, options(nostack)
                );
            }
            agrees != 0
        }
    }
}

#[cfg(not(target_arch = "nvptx64"))]
mod target {
    /// One thread.
    #[derive(Clone, Copy)]
    pub(in super::super) struct Warp;

    impl Warp {
        #[inline(always)]
        pub(in super::super) fn here() -> Warp {
            Warp
        }

        #[inline(always)]
        pub(in super::super) fn count(self, of: bool) -> u32 {
            of as u32
        }

        #[inline(always)]
        pub(in super::super) fn agrees(self, _number: u32) -> bool {
            true
        }
    }
}

pub(super) use target::Warp;
