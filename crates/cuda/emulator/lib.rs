//! A CUDA driver without a device, for tests: `libcuda`, as far as this crate calls it, which executes the kernels' PTX on CPUs.
//! `cargo xtask emulate` runs the tests of pictures with it.
//!
//! It executes what the driver is handed, with the host's code around it. So it finds what is wrong with kernels, launches and
//! memory where no device is. It says nothing of speed, and little of races: the threads of a warp go together wherever they
//! can, and warps one after the other on each core.
//!
//! | variable | says |
//! |---|---|
//! | `CUDA_EMULATOR_DEVICES` | how many devices there are, 1 otherwise |
//! | `CUDA_EMULATOR_BYTES` | what memory they have together, 2^30 otherwise |
//!
//! | file | has |
//! |---|---|
//! | `driver.rs` | the functions of `libcuda` |
//! | `parse.rs`, `operands.rs`, `names.rs` | reading PTX |
//! | `program.rs` | what it is read into |
//! | `launch.rs` | warps of a launch |
//! | `execute.rs` | a warp, instruction by instruction |
//! | `compute.rs` | what instructions compute |

mod compute;
mod driver;
mod execute;
mod launch;
mod names;
mod operands;
mod parse;
mod program;

#[cfg(test)]
mod tests {
    use crate::execute::{Place, Warp};
    use crate::parse::read;

    /// Each thread adds its number to a sum by shuffles, half of them after a detour.
    const PTX: &str = "
.visible .func  (.param .b32 func_retval0) twice
(
	.param .b32 twice_param_0
)
{
	.reg .b32 	%r<3>;
	ld.param.b32 	%r1, [twice_param_0];
	add.s32 	%r2, %r1, %r1;
	st.param.b32 	[func_retval0], %r2;
	ret;
}
.visible .entry sums(
	.param .u64 sums_param_0
)
{
	.reg .pred 	%p<2>;
	.reg .b32 	%r<20>;
	.reg .b64 	%rd<5>;
	ld.param.b64 	%rd1, [sums_param_0];
	mov.u32 	%r1, %tid.x;
	and.b32 	%r2, %r1, 1;
	setp.eq.b32 	%p1, %r2, 0;
	@%p1 bra 	$L__BB0_2;
	{ // callseq 0, 0
	.param .b32 	param0;
	.param .b32 	retval0;
	st.param.b32 	[param0], %r1;
	call.uni (retval0), twice, (param0);
	ld.param.b32 	%r3, [retval0];
	} // callseq 0
	mov.b32 	%r1, %r3;
$L__BB0_2:
	mov.b32 	%r4, 1;
$L__BB0_3:
	shfl.sync.bfly.b32 %r5, %r1, %r4, 31, 0xffffffff;
	add.s32 	%r1, %r1, %r5;
	shl.b32 	%r4, %r4, 1;
	setp.lt.u32 	%p1, %r4, 32;
	@%p1 bra 	$L__BB0_3;
	mov.u32 	%r6, %tid.x;
	mul.wide.u32 	%rd2, %r6, 4;
	add.s64 	%rd3, %rd1, %rd2;
	st.global.b32 	[%rd3], %r1;
	ret;
}
";

    #[test]
    fn threads_part_and_meet_again() {
        let program = read(PTX).unwrap();
        let place = Place { first_thread: 0, block: 0, block_size: 32, blocks: 1 };
        let mut sums = [0u32; 32];
        let mut warp = Warp::new(&program, place);
        let argument = sums.as_mut_ptr();
        let parameters = [&raw const argument as u64];
        // SAFETY: the kernel writes a number for each of its threads.
        unsafe { warp.run_kernel(program.numbers["sums"], &parameters, place, 32) };
        let sum: u32 = (0..32).map(|thread| if thread % 2 == 1 { 2 * thread } else { thread }).sum();
        assert_eq!(sums, [sum; 32]);
    }

    #[test]
    fn what_is_unknown_is_said() {
        let unknown = PTX.replace("shl.b32", "shl.wrap.b32");
        assert!(read(&unknown).err().unwrap().contains("sums: shl.wrap.b32"));
        let lost = PTX.replace("twice, (", "thrice, (");
        assert_eq!(read(&lost).err().unwrap(), "no function thrice");
    }
}
