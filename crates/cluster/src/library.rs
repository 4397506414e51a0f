//! The library of MPI: which to open, and of what kind it is.

use crate::error::ClusterError;
use crate::launcher::{Launcher, Vendor};
use libloading::os::unix::{Library, RTLD_GLOBAL, RTLD_LAZY, RTLD_LOCAL, RTLD_NOW};
use std::ffi::{c_char, c_int, c_void};
use std::path::{Path, PathBuf};

/// How a library passes handles and what its constants are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Family {
    /// The standard ABI of MPI 5.
    Standard,
    /// MPICH, Intel MPI, Cray MPICH, MVAPICH: handles are numbers.
    Mpich,
    /// Open MPI: handles are addresses.
    OpenMpi,
}

/// A library that is open, and stays so: nothing of an MPI can be unloaded once it has started.
pub(crate) struct MpiLibrary {
    pub(crate) library: Library,
    pub(crate) path: PathBuf,
    pub(crate) family: Family,
    /// The first line of what it says that it is.
    pub(crate) version: String,
}

/// Names of Open MPI's library; of MPICH's relatives there is one with some of these too, so files are asked what they are.
const OPEN_MPI_NAMES: [&str; 6] =
    ["libmpi.so.40", "libmpi.so.80", "libmpi_abi.so.1", "libmpi_abi.so", "libmpi_ibm.so", "libmpi.so"];
/// Names of MPICH's library and its relatives. Cray has one for each compiler, and all do.
const MPICH_NAMES: [&str; 17] = [
    "libmpi_abi.so.1",
    "libmpi_abi.so",
    "libmpich.so.12",
    "libmpi.so.12",
    "libmpi_cray.so.12",
    "libmpi_gnu_123.so.12",
    "libmpi_gnu_112.so.12",
    "libmpi_gnu_103.so.12",
    "libmpi_gnu_91.so.12",
    "libmpi_amd.so.12",
    "libmpi_aocc.so.12",
    "libmpi_intel.so.12",
    "libmpi_nvidia.so.12",
    "libmpi_pgi.so.12",
    "libmpich.so",
    "libmpi.so",
    "libmpi.so.0",
];

impl MpiLibrary {
    /// The one that EOSPHOR_MPI names, else the first that fits the launcher.
    pub(crate) fn open(launcher: &Launcher) -> Result<MpiLibrary, ClusterError> {
        if let Some(chosen) = std::env::var_os("EOSPHOR_MPI").filter(|chosen| !chosen.is_empty()) {
            let library = probe(Path::new(&chosen))?;
            return fits(&library, launcher).and_then(|()| library.keep());
        }
        let names: Vec<&str> = match launcher.likely {
            Vendor::OpenMpi => OPEN_MPI_NAMES.iter().chain(&MPICH_NAMES).copied().collect(),
            Vendor::Mpich => MPICH_NAMES.iter().chain(&OPEN_MPI_NAMES).copied().collect(),
        };
        first_that_fits(launcher, &names, &launcher.folders())
    }

    /// Makes the library's symbols visible to the plug-ins that it loads.
    fn keep(self) -> Result<MpiLibrary, ClusterError> {
        // SAFETY: the library is open already, so that none of its code runs: its symbols become visible.
        match unsafe { Library::open(Some(&self.path), RTLD_NOW | RTLD_GLOBAL) } {
            Ok(library) => Ok(MpiLibrary { library, ..self }),
            Err(error) => Err(ClusterError::Library { path: self.path, reason: why(&error) }),
        }
    }
}

/// The first library of these names, in these folders and else where the system looks, that fits the launcher.
fn first_that_fits(
    launcher: &Launcher,
    names: &[&str],
    folders: &[PathBuf],
) -> Result<MpiLibrary, ClusterError> {
    let near = folders.iter().flat_map(|folder| names.iter().map(move |name| folder.join(name)));
    let near = near.filter(|path| path.exists());
    // Of the errors the one that says most: a library of the wrong kind is more than one that is not there.
    let mut wrong = None;
    for path in near.chain(names.iter().map(PathBuf::from)) {
        let Ok(library) = probe(&path) else { continue };
        match fits(&library, launcher) {
            Ok(()) => return library.keep(),
            Err(error) => wrong = wrong.or(Some(error)),
        }
    }
    Err(wrong.unwrap_or_else(|| {
        let mut looked_for = names.join(", ");
        for folder in folders {
            looked_for.push_str(&format!(", also in {}", folder.display()));
        }
        let launcher_name = launcher.name.clone();
        ClusterError::NoLibrary { launcher: launcher_name, looked_for, install: launcher.install().into() }
    }))
}

/// Whether the library understands the launcher. If not, every process would take itself for the only one.
fn fits(library: &MpiLibrary, launcher: &Launcher) -> Result<(), ClusterError> {
    let vendor = match library.family {
        Family::Mpich => Vendor::Mpich,
        Family::OpenMpi => Vendor::OpenMpi,
        Family::Standard if library.version.contains("Open MPI") => Vendor::OpenMpi,
        Family::Standard if is_mpich(&library.version) => Vendor::Mpich,
        Family::Standard => return Ok(()),
    };
    match launcher.vendor {
        Some(needed) if needed != vendor => Err(ClusterError::WrongLibrary {
            launcher: launcher.name.clone(),
            library: library.version.clone(),
            path: library.path.clone(),
        }),
        _ => Ok(()),
    }
}

/// Opens a library such that others do not see its symbols, and asks it what it is.
fn probe(path: &Path) -> Result<MpiLibrary, ClusterError> {
    let failed = |reason: String| ClusterError::Library { path: path.into(), reason };
    // SAFETY: start-up code of MPI libraries only sets up their own data; like any library's it has to be trusted.
    let library =
        unsafe { Library::open(Some(path), RTLD_LAZY | RTLD_LOCAL) }.map_err(|error| failed(why(&error)))?;
    let Some(version) = version(&library) else {
        return Err(failed("it has no MPI_Get_library_version: this is no library of MPI 3 or later".into()));
    };
    let family = if has_standard_abi(&library) {
        Family::Standard
    } else if has_symbol(&library, c"ompi_mpi_comm_world") {
        Family::OpenMpi
    } else if is_mpich(&version) {
        Family::Mpich
    } else {
        return Err(failed(format!(
            "it is {version}, whose binary interface is not known: use Open MPI, MPICH or a relative of it (Intel, \
             Cray, MVAPICH), or a library with the standard ABI (libmpi_abi.so)"
        )));
    };
    Ok(MpiLibrary { library, path: path.into(), family, version })
}

fn is_mpich(version: &str) -> bool {
    ["MPICH", "Intel(R) MPI", "MVAPICH", "ParaStation"].iter().any(|name| version.contains(name))
}

fn has_symbol(library: &Library, name: &std::ffi::CStr) -> bool {
    // SAFETY: the address is only compared with null, never used.
    unsafe { library.get::<*const c_void>(name.to_bytes_with_nul()) }
        .is_ok_and(|symbol| !symbol.as_raw_ptr().is_null())
}

/// MPICH 5 has the function in both of its libraries; that with its own ABI answers -1.
fn has_standard_abi(library: &Library) -> bool {
    type GetVersion = unsafe extern "C" fn(*mut c_int, *mut c_int) -> c_int;
    let (mut major, mut minor) = (-1, -1);
    // SAFETY: the function has this type in MPI 5, which also says that it may be called before MPI is started.
    unsafe {
        library
            .get::<GetVersion>(c"MPI_Abi_get_version".to_bytes_with_nul())
            .is_ok_and(|get| get(&mut major, &mut minor) == 0 && major >= 1)
    }
}

/// The first line of what a library says that it is.
fn version(library: &Library) -> Option<String> {
    type GetVersion = unsafe extern "C" fn(*mut c_char, *mut c_int) -> c_int;
    // The standard allows at most 8192 bytes; the rest is for libraries that count badly.
    let (mut text, mut length) = (vec![0u8; 16384], 0);
    // SAFETY: the function has this type since MPI 3, which also says that it may be called before MPI is started, and
    // that it writes no more than MPI_MAX_LIBRARY_VERSION_STRING bytes.
    let code = unsafe {
        let get = library.get::<GetVersion>(c"MPI_Get_library_version".to_bytes_with_nul()).ok()?;
        get(text.as_mut_ptr().cast(), &mut length)
    };
    let text = String::from_utf8_lossy(text.get(..length.max(0) as usize)?).into_owned();
    let line = text.trim_matches(['\0', ' ', '\n']).lines().next()?;
    (code == 0).then(|| line.split_whitespace().collect::<Vec<_>>().join(" "))
}

/// The reason that the system gives.
fn why(error: &libloading::Error) -> String {
    let source = std::error::Error::source(error).map_or_else(|| error.to_string(), ToString::to_string);
    format!("it cannot be opened: {source}")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn launcher() -> Launcher {
        let (vendor, likely) = (Some(Vendor::Mpich), Vendor::Mpich);
        Launcher { name: "mpirun of MPICH (PMI_SIZE=2)".into(), vendor, likely, size: Some(2) }
    }

    #[test]
    fn without_a_library_the_error_names_what_was_looked_for_and_what_to_install() {
        let error = first_that_fits(&launcher(), &["libmpi_nowhere.so.1"], &[PathBuf::from("/nowhere")]);
        let text = error.err().unwrap().to_string();
        for part in ["PMI_SIZE=2", "libmpi_nowhere.so.1", "/nowhere", "apt install libmpich12", "EOSPHOR_MPI"]
        {
            assert!(text.contains(part), "{part} is not in: {text}");
        }
    }

    #[test]
    fn a_library_that_is_not_mpi_is_refused() {
        let text = probe(Path::new("libc.so.6")).err().unwrap().to_string();
        assert!(text.contains("libc.so.6") && text.contains("no library of MPI"), "{text}");
    }
}
