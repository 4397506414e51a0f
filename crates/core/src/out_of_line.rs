//! Functions of their own for what is rare and large, so that its code is not repeated in every traversal of every query.
//!
//! What traversals inline is compiled for their instruction set. A function of its own is not: here it is compiled for CPUs
//! with fused multiply-adds and for those without, and chosen when it is called. On GPUs it is a function with a name that
//! can be found in the PTX, so that its registers are not those of its callers.

/// Whether the CPU has fused multiply-adds. Asked once and remembered by the standard library.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
pub(crate) fn has_fma() -> bool {
    std::arch::is_x86_feature_detected!("fma") && std::arch::is_x86_feature_detected!("avx2")
}

/// Whether code takes one way where two would be faster, so that there is less of it: drivers of GPUs compile kernels when they
/// are first asked for.
pub(crate) const IS_SMALL: bool = cfg!(target_arch = "nvptx64");

/// Defines a function that is never inlined into its callers.
macro_rules! out_of_line {
    ($($function:tt)*) => {
        $crate::out_of_line::on_cpus! {
            #[cfg_attr(target_arch = "nvptx64", unsafe(no_mangle))]
            $($function)*
        }
    };
}

/// The same of a function that no device calls: one that prepares what devices read.
macro_rules! on_cpus {
    (
        $(#[$attribute:meta])*
        $visibility:vis fn $name:ident($($argument:ident: $type:ty),* $(,)?) -> $result:ty $body:block
    ) => {
        $(#[$attribute])*
        #[inline(never)]
        $visibility fn $name($($argument: $type),*) -> $result {
            #[inline(always)]
            fn body($($argument: $type),*) -> $result $body

            #[cfg(target_arch = "x86_64")]
            {
                #[target_feature(enable = "avx2,fma")]
                fn with_fma($($argument: $type),*) -> $result {
                    body($($argument),*)
                }
                // A function with a name, so that `cargo xtask fma` can tell it from what other CPUs run.
                #[inline(never)]
                fn without_fma($($argument: $type),*) -> $result {
                    body($($argument),*)
                }
                if $crate::out_of_line::has_fma() {
                    // SAFETY: the CPU has these instructions.
                    return unsafe { with_fma($($argument),*) };
                }
                without_fma($($argument),*)
            }
            #[cfg(not(target_arch = "x86_64"))]
            body($($argument),*)
        }
    };
}

/// Defines a function that is one of its own on GPUs only, where what it does is rare and needs many registers; on CPUs it is
/// inlined.
macro_rules! out_of_line_on_gpus {
    ($(#[$attribute:meta])* $visibility:vis fn $($function:tt)*) => {
        $(#[$attribute])*
        #[cfg_attr(target_arch = "nvptx64", inline(never), unsafe(no_mangle))]
        #[cfg_attr(not(target_arch = "nvptx64"), inline(always))]
        $visibility fn $($function)*
    };
}

pub(crate) use {on_cpus, out_of_line, out_of_line_on_gpus};
