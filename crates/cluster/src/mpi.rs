//! The functions of MPI that are in use, over the library that was opened at run time.
//!
//! Handles are `int` in MPICH's family and pointers in the others. Both travel as `usize`: in a register a function that
//! takes an `int` reads the lower half of it, and one that writes an `int` writes the lower half, of zero before, which
//! is right on little-endian 64-bit machines such as x86-64 and AArch64; others are refused.

use crate::error::ClusterError;
use crate::launcher::Launcher;
use crate::library::{Family, MpiLibrary};
use libloading::os::unix::Library;
use std::ffi::{CStr, c_char, c_int, c_void};
use std::path::Path;

/// A communicator, data type, request and the like.
pub(crate) type Handle = usize;

/// What a message was; larger than that of any library.
#[repr(C, align(16))]
#[derive(Default)]
pub(crate) struct Status([c_int; 16]);

macro_rules! functions {
    ($($field:ident = $name:literal: fn($($argument:ty),*);)*) => {
        /// Functions, by the names that they have in MPI.
        pub(crate) struct Functions {
            $(pub(crate) $field: unsafe extern "C" fn($($argument),*) -> c_int,)*
        }

        impl Functions {
            fn load(library: &Library, path: &Path) -> Result<Functions, ClusterError> {
                Ok(Functions {
                    $($field: {
                        // SAFETY: the function has this type in MPI 3 and later, with handles that are integers or pointers
                        // of 64 bits.
                        let symbol = unsafe {
                            library.get::<unsafe extern "C" fn($($argument),*) -> c_int>($name.to_bytes_with_nul())
                        };
                        *symbol.map_err(|_| lacks(path, $name))?
                    },)*
                })
            }
        }
    };
}

functions! {
    abort = c"MPI_Abort": fn(Handle, c_int);
    bcast = c"MPI_Bcast": fn(*mut u8, c_int, Handle, c_int, Handle);
    comm_free = c"MPI_Comm_free": fn(*mut Handle);
    comm_rank = c"MPI_Comm_rank": fn(Handle, *mut c_int);
    comm_set_errhandler = c"MPI_Comm_set_errhandler": fn(Handle, Handle);
    comm_size = c"MPI_Comm_size": fn(Handle, *mut c_int);
    comm_split_type = c"MPI_Comm_split_type": fn(Handle, c_int, c_int, Handle, *mut Handle);
    error_string = c"MPI_Error_string": fn(c_int, *mut c_char, *mut c_int);
    finalize = c"MPI_Finalize": fn();
    get_count = c"MPI_Get_count": fn(*const Status, Handle, *mut c_int);
    get_processor_name = c"MPI_Get_processor_name": fn(*mut c_char, *mut c_int);
    init_thread = c"MPI_Init_thread": fn(*mut c_void, *mut c_void, c_int, *mut c_int);
    iprobe = c"MPI_Iprobe": fn(c_int, c_int, Handle, *mut c_int, *mut Status);
    irecv = c"MPI_Irecv": fn(*mut u8, c_int, Handle, c_int, c_int, Handle, *mut Handle);
    isend = c"MPI_Isend": fn(*const u8, c_int, Handle, c_int, c_int, Handle, *mut Handle);
    recv = c"MPI_Recv": fn(*mut u8, c_int, Handle, c_int, c_int, Handle, *mut Status);
    test = c"MPI_Test": fn(*mut Handle, *mut c_int, *mut Status);
}

fn lacks(path: &Path, name: &CStr) -> ClusterError {
    let reason = format!("it has no {}: use a library of MPI 3 or later", name.to_string_lossy());
    ClusterError::Library { path: path.into(), reason }
}

/// What the families have other values for.
pub(crate) struct Constants {
    pub(crate) world: Handle,
    pub(crate) byte: Handle,
    errors_return: Handle,
    info_null: Handle,
    any_source: c_int,
    thread_funneled: c_int,
    comm_type_shared: c_int,
    /// Where in a status the source is.
    source_at: usize,
}

impl Constants {
    fn of(library: &MpiLibrary) -> Result<Constants, ClusterError> {
        let address = |name: &CStr| {
            // SAFETY: the address is not read from here: it is the handle.
            let symbol = unsafe { library.library.get::<*const c_void>(name.to_bytes_with_nul()) };
            symbol.map(|symbol| symbol.as_raw_ptr() as Handle).map_err(|_| lacks(&library.path, name))
        };
        Ok(match library.family {
            Family::Standard => Constants {
                world: 0x101,
                byte: 0x247,
                errors_return: 0x143,
                info_null: 0x130,
                any_source: -1,
                thread_funneled: 1024,
                comm_type_shared: 221,
                source_at: 0,
            },
            Family::Mpich => Constants {
                world: 0x4400_0000,
                byte: 0x4c00_010d,
                errors_return: 0x5400_0001,
                info_null: 0x1c00_0000,
                any_source: -2,
                thread_funneled: 1,
                comm_type_shared: 1,
                source_at: 2,
            },
            Family::OpenMpi => Constants {
                world: address(c"ompi_mpi_comm_world")?,
                byte: address(c"ompi_mpi_byte")?,
                errors_return: address(c"ompi_mpi_errors_return")?,
                info_null: address(c"ompi_mpi_info_null")?,
                any_source: -1,
                thread_funneled: 1,
                comm_type_shared: 0,
                source_at: 0,
            },
        })
    }
}

/// MPI, started. Calls come from the thread that started it.
pub(crate) struct Mpi {
    pub(crate) functions: Functions,
    pub(crate) constants: Constants,
    pub(crate) rank: u32,
    pub(crate) size: u32,
    pub(crate) host: String,
    /// The first line of what the library says that it is.
    pub(crate) version: String,
}

impl Mpi {
    /// Starts the library.
    pub(crate) fn start(library: MpiLibrary, launcher: &Launcher) -> Result<Mpi, ClusterError> {
        let failed =
            |reason: &str| ClusterError::Library { path: library.path.clone(), reason: reason.into() };
        if !cfg!(all(target_pointer_width = "64", target_endian = "little")) {
            return Err(failed("only little-endian 64-bit machines can call it"));
        }
        let functions = Functions::load(&library.library, &library.path)?;
        let constants = Constants::of(&library)?;
        let (mut provided, mut rank, mut size) = (0, 0, 0);
        // SAFETY: MPI allows null for the program's arguments; the other pointers are to live integers.
        unsafe {
            let funneled = constants.thread_funneled;
            let null = std::ptr::null_mut();
            if (functions.init_thread)(null, null, funneled, &mut provided) != 0 {
                return Err(failed("MPI_Init_thread failed: its own message stands above"));
            }
            if provided < funneled {
                return Err(failed(
                    "it does not allow threads beside the one that calls it: use another build",
                ));
            }
            let world = constants.world;
            // From now on errors come back instead of ending the process without a word of ours.
            if (functions.comm_set_errhandler)(world, constants.errors_return) != 0
                || (functions.comm_rank)(world, &mut rank) != 0
                || (functions.comm_size)(world, &mut size) != 0
            {
                return Err(failed("it does not tell this process's rank"));
            }
        }
        let (rank, size) = (rank as u32, size as u32);
        if let Some(started) = launcher.size.filter(|started| *started != size) {
            let (launcher, path) = (launcher.name.clone(), library.path);
            let library = library.version;
            return Err(ClusterError::WrongSize { launcher, started, library, path, seen: size });
        }
        let host = processor_name(&functions).unwrap_or_else(|| "an unnamed host".into());
        let version = library.version;
        // The functions are used until the process ends: the library is never closed.
        std::mem::forget(library.library);
        Ok(Mpi { functions, constants, rank, size, host, version })
    }

    /// The error of a call that returned something else than success.
    pub(crate) fn check(&self, call: &'static str, code: c_int) -> Result<(), ClusterError> {
        if code == 0 {
            return Ok(());
        }
        let (mut text, mut length) = (vec![0u8; 8192], 0);
        // SAFETY: the text is longer than MPI_MAX_ERROR_STRING of any library (512).
        unsafe { (self.functions.error_string)(code, text.as_mut_ptr().cast(), &mut length) };
        text.truncate(length.max(0) as usize);
        let reason = String::from_utf8_lossy(&text).trim().replace('\n', "; ");
        Err(ClusterError::Mpi { call, rank: self.rank, host: self.host.clone(), reason })
    }

    /// Whether a message of this tag has come: its source and how many bytes it has.
    pub(crate) fn probe(&self, tag: c_int) -> Result<Option<(u32, usize)>, ClusterError> {
        let (mut flag, mut count, mut status) = (0, 0, Status::default());
        let Constants { world, byte, any_source, source_at, .. } = self.constants;
        // SAFETY: pointers are to live integers and to a status that is larger than the library's.
        let code = unsafe { (self.functions.iprobe)(any_source, tag, world, &mut flag, &mut status) };
        self.check("MPI_Iprobe", code)?;
        if flag == 0 {
            return Ok(None);
        }
        // SAFETY: the library has just filled the status.
        let code = unsafe { (self.functions.get_count)(&status, byte, &mut count) };
        self.check("MPI_Get_count", code)?;
        Ok(Some((status.0[source_at] as u32, count as usize)))
    }

    /// A message that a probe has found, which is so small that it has come whole.
    pub(crate) fn receive(&self, source: u32, tag: c_int, count: usize) -> Result<Vec<u8>, ClusterError> {
        let (mut bytes, mut status) = (vec![0; count], Status::default());
        let Constants { world, byte, .. } = self.constants;
        let (to, count, source) = (bytes.as_mut_ptr(), count as c_int, source as c_int);
        // SAFETY: `to` points to `count` writable bytes, and `recv` returns when it has written them.
        let code = unsafe { (self.functions.recv)(to, count, byte, source, tag, world, &mut status) };
        self.check("MPI_Recv", code).map(|()| bytes)
    }

    /// Rank 0's bytes, at all. Waits by spinning, so all should be there.
    pub(crate) fn broadcast(&self, bytes: &mut [u8]) -> Result<(), ClusterError> {
        let Constants { world, byte, .. } = self.constants;
        let (at, count) = (bytes.as_mut_ptr(), bytes.len() as c_int);
        // SAFETY: `at` points to `count` writable bytes, and `bcast` returns when it is done with them.
        let code = unsafe { (self.functions.bcast)(at, count, byte, 0, world) };
        self.check("MPI_Bcast", code)
    }

    /// Begins to send bytes to a rank.
    ///
    /// # Safety
    ///
    /// The bytes stay where they are, and as they are, until [`Mpi::is_done`] says so of the request.
    pub(crate) unsafe fn begin_sending(
        &self,
        bytes: &[u8],
        to: u32,
        tag: c_int,
    ) -> Result<Handle, ClusterError> {
        let Constants { world, byte, .. } = self.constants;
        let (from, count, to, mut request) = (bytes.as_ptr(), bytes.len() as c_int, to as c_int, 0);
        // SAFETY: `from` points to `count` bytes, which stay there unchanged until the request is complete: the condition of
        // `begin_sending`.
        let code = unsafe { (self.functions.isend)(from, count, byte, to, tag, world, &mut request) };
        self.check("MPI_Isend", code).map(|()| request)
    }

    /// Begins to receive as many bytes from a rank.
    ///
    /// # Safety
    ///
    /// The bytes stay where they are, and nobody looks at them, until [`Mpi::is_done`] says so of the request.
    pub(crate) unsafe fn begin_receiving(
        &self,
        bytes: &mut [u8],
        from: u32,
        tag: c_int,
    ) -> Result<Handle, ClusterError> {
        let Constants { world, byte, .. } = self.constants;
        let (to, count, from, mut request) = (bytes.as_mut_ptr(), bytes.len() as c_int, from as c_int, 0);
        // SAFETY: `to` points to `count` bytes, which stay there and which nobody looks at until the request is complete: the
        // condition of `begin_receiving`.
        let code = unsafe { (self.functions.irecv)(to, count, byte, from, tag, world, &mut request) };
        self.check("MPI_Irecv", code).map(|()| request)
    }

    /// Whether a request is complete. It must not be asked for again then.
    pub(crate) fn is_done(&self, request: &mut Handle) -> Result<bool, ClusterError> {
        let (mut flag, mut status) = (0, Status::default());
        // SAFETY: the request is one that the library made, and is not yet complete.
        let code = unsafe { (self.functions.test)(request, &mut flag, &mut status) };
        self.check("MPI_Test", code).map(|()| flag != 0)
    }

    /// This process's number among those of its host, and how many these are.
    pub(crate) fn local(&self) -> Result<(u32, u32), ClusterError> {
        let Constants { world, comm_type_shared, info_null, .. } = self.constants;
        let (mut here, mut rank, mut size) = (0, 0, 0);
        // SAFETY: all ranks make these calls; pointers are to a live handle and to live integers.
        let code = unsafe {
            (self.functions.comm_split_type)(
                world,
                comm_type_shared,
                self.rank as c_int,
                info_null,
                &mut here,
            )
        };
        self.check("MPI_Comm_split_type", code)?;
        // SAFETY: `here` is the communicator just made, which only this function knows, and the pointers are to live integers.
        let codes = unsafe {
            let codes =
                [(self.functions.comm_rank)(here, &mut rank), (self.functions.comm_size)(here, &mut size)];
            (self.functions.comm_free)(&mut here);
            codes
        };
        codes.into_iter().try_for_each(|code| self.check("MPI_Comm_rank", code))?;
        Ok((rank as u32, size as u32))
    }

    /// Ends MPI. All ranks do, and wait for each other.
    pub(crate) fn finalize(&self) -> Result<(), ClusterError> {
        // SAFETY: MPI has started and not ended, and no message is under way: `World::finish` flushes them before.
        let code = unsafe { (self.functions.finalize)() };
        if code != 0 {
            // MPI has ended, so its words for errors are gone too.
            let (rank, host, reason) = (self.rank, self.host.clone(), format!("error {code}"));
            return Err(ClusterError::Mpi { call: "MPI_Finalize", rank, host, reason });
        }
        Ok(())
    }
}

fn processor_name(functions: &Functions) -> Option<String> {
    let (mut text, mut length) = (vec![0u8; 4096], 0);
    // SAFETY: the text is longer than MPI_MAX_PROCESSOR_NAME of any library (256).
    let code = unsafe { (functions.get_processor_name)(text.as_mut_ptr().cast(), &mut length) };
    let name = String::from_utf8_lossy(text.get(..length.max(0) as usize)?).trim().replace('\n', " ");
    (code == 0 && !name.is_empty()).then_some(name)
}
