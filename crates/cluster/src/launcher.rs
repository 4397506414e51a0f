//! Launchers: whether one started this process, and what it says of itself.

use std::path::PathBuf;

/// Makers of MPI whose launchers and libraries fit each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Vendor {
    /// MPICH, Intel MPI, Cray MPICH, MVAPICH.
    Mpich,
    /// Open MPI and what is made of it.
    OpenMpi,
}

/// What started this process.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Launcher {
    /// In words, with the variable by which it was recognized.
    pub(crate) name: String,
    /// Whose library it needs, where that is certain.
    pub(crate) vendor: Option<Vendor>,
    /// Whose library to try first, where it is not.
    pub(crate) likely: Vendor,
    /// How many processes it started.
    pub(crate) size: Option<u32>,
}

/// Any of these says that a launcher is there. Slurm's own variables do not: `srun` sets them for jobs without MPI too.
const SIGNS: [&str; 7] = [
    "OMPI_COMM_WORLD_SIZE",
    "PMI_SIZE",
    "PMI_RANK",
    "PMI_FD",
    "PMI_CONTROL_PORT",
    "PALS_RANKID",
    "PMIX_RANK",
];

/// The rank of this process, as its launcher says it, before MPI is opened; `None` without a launcher, or where it says
/// nothing.
pub fn launched_rank() -> Option<u32> {
    Launcher::of_this_process()?;
    let names = ["OMPI_COMM_WORLD_RANK", "PMI_RANK", "PMIX_RANK", "PALS_RANKID", "SLURM_PROCID"];
    names.iter().find_map(|name| std::env::var(name).ok()?.parse().ok())
}

/// The number of this process among those of its host, as the launcher's environment says it; `None` without a launcher.
pub fn launched_local_rank() -> Option<u32> {
    Launcher::of_this_process()?;
    let names = ["OMPI_COMM_WORLD_LOCAL_RANK", "MPI_LOCALRANKID", "PALS_LOCAL_RANKID", "SLURM_LOCALID"];
    names.iter().find_map(|name| std::env::var(name).ok()?.parse().ok())
}

impl Launcher {
    /// The launcher that started this process, if one did.
    pub(crate) fn of_this_process() -> Option<Launcher> {
        // A way to say that the variables are not meant for this process.
        if std::env::var("EOSPHOR_MPI").as_deref() == Ok("none") {
            return None;
        }
        Launcher::from_variables(&|name| std::env::var_os(name)?.into_string().ok())
    }

    fn from_variables(variable: &dyn Fn(&str) -> Option<String>) -> Option<Launcher> {
        let (sign, value) = SIGNS.iter().find_map(|sign| Some((*sign, variable(sign)?)))?;
        let number = |name: &str| variable(name)?.parse().ok();
        let is_slurm = variable("SLURM_PROCID").is_some();
        let (name, vendor, likely, size) = match sign {
            "OMPI_COMM_WORLD_SIZE" => {
                ("mpirun of Open MPI", Some(Vendor::OpenMpi), Vendor::OpenMpi, number(sign))
            }
            // Slurm's PMI serves both makers. Its number of tasks is that of the processes only where srun started them
            // itself: mpirun starts its own helpers by srun.
            "PMIX_RANK" if is_slurm => {
                ("srun of Slurm", None, Vendor::OpenMpi, number("SLURM_STEP_NUM_TASKS"))
            }
            "PMIX_RANK" => ("a launcher with PMIx", None, Vendor::OpenMpi, None),
            _ if is_slurm => ("srun of Slurm or mpirun of MPICH", None, Vendor::Mpich, number("PMI_SIZE")),
            _ => ("mpirun of MPICH or Intel MPI", Some(Vendor::Mpich), Vendor::Mpich, number("PMI_SIZE")),
        };
        Some(Launcher { name: format!("{name} ({sign}={value})"), vendor, likely, size })
    }

    /// This process's rank, 0 where the launcher does not say it, and the same in words.
    pub(crate) fn rank_in_words(&self) -> (u32, String) {
        let of = self.size.map_or_else(String::new, |size| format!(" of {size}"));
        match launched_rank() {
            Some(rank) => (rank, format!("rank {rank}{of}")),
            None => (0, format!("a rank{of}")),
        }
    }

    /// Packages with a library for it.
    pub(crate) fn install(&self) -> &'static str {
        match self.vendor {
            Some(Vendor::Mpich) => "Debian and Ubuntu: apt install libmpich12; any: pip install mpich",
            Some(Vendor::OpenMpi) => "Debian and Ubuntu: apt install libopenmpi3, or libopenmpi40",
            None => "the MPI of the cluster, often by `module load`",
        }
    }

    /// Folders where its own library may lie: beside the launcher, which is a parent of this process, and where
    /// variables point to.
    pub(crate) fn folders(&self) -> Vec<PathBuf> {
        let variables = ["I_MPI_ROOT", "CRAY_MPICH_DIR", "OPAL_PREFIX", "MPI_HOME", "MPI_ROOT"];
        let mut roots: Vec<PathBuf> = parent_launcher_root().into_iter().collect();
        roots.extend(variables.iter().filter_map(std::env::var_os).map(PathBuf::from));
        let mut folders = Vec::new();
        for root in roots {
            for below in ["lib", "lib64", "lib/release"] {
                let folder = root.join(below);
                if folder.is_dir() && !folders.contains(&folder) {
                    folders.push(folder);
                }
            }
        }
        folders
    }
}

/// The folder that the nearest launcher among this process's parents is installed in. Scripts may stand between.
fn parent_launcher_root() -> Option<PathBuf> {
    const NAMES: [&str; 8] =
        ["mpirun", "mpiexec", "hydra_pmi_proxy", "pmi_proxy", "orterun", "orted", "prterun", "prted"];
    let mut process = std::process::id();
    for _ in 0..8 {
        process = parent(process)?;
        let Ok(program) = std::fs::read_link(format!("/proc/{process}/exe")) else { continue };
        let name = program.file_name()?.to_string_lossy().into_owned();
        if NAMES.iter().any(|known| name == *known || name.starts_with(&format!("{known}."))) {
            return Some(program.parent()?.parent()?.to_path_buf());
        }
    }
    None
}

/// The process that started this one.
fn parent(process: u32) -> Option<u32> {
    let stat = std::fs::read_to_string(format!("/proc/{process}/stat")).ok()?;
    // The name, in parentheses, may itself have spaces and parentheses.
    stat.rsplit_once(')')?.1.split_whitespace().nth(1)?.parse().ok().filter(|parent| *parent > 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn launcher(variables: &[(&str, &str)]) -> Option<Launcher> {
        Launcher::from_variables(&|name| {
            variables.iter().find(|(known, _)| *known == name).map(|(_, value)| value.to_string())
        })
    }

    #[test]
    fn nothing_but_slurm_is_no_launcher() {
        assert_eq!(launcher(&[]), None);
        assert_eq!(launcher(&[("SLURM_PROCID", "0"), ("SLURM_STEP_NUM_TASKS", "4")]), None);
    }

    #[test]
    fn launchers_say_whose_they_are_and_how_many_they_started() {
        let of = |variables: &[(&str, &str)]| {
            let launcher = launcher(variables).unwrap();
            (launcher.vendor, launcher.likely, launcher.size)
        };
        let (mpich, open_mpi) = (Vendor::Mpich, Vendor::OpenMpi);
        assert_eq!(of(&[("PMI_RANK", "1"), ("PMI_SIZE", "4")]), (Some(mpich), mpich, Some(4)));
        assert_eq!(
            of(&[("OMPI_COMM_WORLD_SIZE", "3"), ("PMIX_RANK", "0")]),
            (Some(open_mpi), open_mpi, Some(3))
        );
        assert_eq!(of(&[("PMIX_RANK", "0")]), (None, open_mpi, None));
        let slurm = ("SLURM_PROCID", "0");
        assert_eq!(
            of(&[slurm, ("SLURM_STEP_NUM_TASKS", "8"), ("PMIX_RANK", "0")]),
            (None, open_mpi, Some(8))
        );
        assert_eq!(of(&[slurm, ("SLURM_STEP_NUM_TASKS", "2"), ("PMI_SIZE", "8")]), (None, mpich, Some(8)));
    }
}
