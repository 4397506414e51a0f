//! What a scene's file asks for besides the picture (`device` in a scene, `renderer` in PG1's configurations), where the command
//! line does not say it.

use crate::arguments::{AccelChoice, BackendChoice, DeviceFlags, InfoFlags, RenderFlags};
use crate::failure::Failure;
use eosphor::{
    Accel, DeviceKind, DeviceSettings, Format, HierarchyOption, HierarchyOptions, MisfitKind, OptionMisfit,
    SahCosts, SceneRequests, scene_requests,
};
use std::path::{Path, PathBuf};

/// Fills in what is missing of a render's flags.
pub(crate) fn obey_for_picture(flags: &mut RenderFlags) -> Result<(), Failure> {
    // The work that is shown is the CPU's.
    if flags.show.is_some() && flags.device.backend.is_none() {
        flags.device.backend = Some(BackendChoice::Cpu);
    }
    let SceneRequests { output, .. } = obey(&flags.scene, &mut flags.device, &mut flags.picture.accel)?;
    if flags.outputs.iter().all(|output| output.as_os_str().is_empty()) {
        // (Standard output is for the command line to name.)
        let file = |name: String| if name == "-" { PathBuf::from("./-") } else { PathBuf::from(name) };
        let named = output.map(file).filter(|output| !output.as_os_str().is_empty());
        let without_name = "the picture has no name: give one by --output, as in -o picture.png (or \"output\" in the scene)";
        let named = named.ok_or_else(|| Failure::Usage(without_name.into()))?;
        let is_video = named.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("mp4"));
        if !is_video {
            let scene = flags.scene.display();
            Format::of(&named).map_err(|error| Failure::Failed(format!("{scene}: output: {error}")))?;
        }
        flags.outputs = vec![named];
    }
    Ok(())
}

/// Fills in what is missing of the flags of `info`. A table is of all structures, as they usually are.
pub(crate) fn obey_for_info(flags: &mut InfoFlags) -> Result<(), Failure> {
    if !flags.is_table() {
        let mut accel = flags.one();
        obey(&flags.scene, &mut flags.device, &mut accel)?;
        flags.accel = accel.map(AccelChoice::One);
    }
    Ok(())
}

/// Takes what the scene's file asks for into flags that the command line leaves out, and returns all that the file asks
/// for. Options of a hierarchy belong to the hierarchy that the file names: where the command line names another, they
/// are left out.
pub(crate) fn obey(
    scene: &Path,
    flags: &mut DeviceFlags,
    accel: &mut Option<Accel>,
) -> Result<SceneRequests, Failure> {
    let requests = scene_requests(scene);
    let asked = &requests.device;
    if flags.backend.is_none() {
        flags.backend = asked.backend.map(|kind| match kind {
            DeviceKind::Auto => BackendChoice::Auto,
            DeviceKind::Cpu => BackendChoice::Cpu,
            DeviceKind::Cuda => BackendChoice::Cuda(Vec::new()),
        });
    }
    let (asked_accel, own) = hierarchy_of(asked);
    let in_file = |misfit: OptionMisfit| Failure::Failed(in_words(scene, &misfit, requests.is_pg1));
    own.check(asked_accel).map_err(in_file)?;
    if accel.is_some() && *accel != asked_accel {
        return Ok(requests);
    }
    *accel = asked_accel;
    flags.builder = flags.builder.or(own.builder);
    flags.leaf_size = flags.leaf_size.or(own.leaf_size);
    flags.tree_depth = flags.tree_depth.or(own.tree_depth);
    flags.sah_costs = flags.sah_costs.or(own.sah_costs);
    Ok(requests)
}

/// The structure, and how it is built.
fn hierarchy_of(asked: &DeviceSettings) -> (Option<Accel>, HierarchyOptions) {
    // Files know the names that the command line has: see the test.
    let accel = asked.accel.and_then(|structure| structure.name().parse().ok());
    let options = HierarchyOptions {
        builder: asked.builder.and_then(|builder| builder.name().parse().ok()),
        leaf_size: asked.leaf_size,
        tree_depth: asked.tree_depth,
        sah_costs: asked.sah_costs.map(|[node, primitive]| SahCosts { node, primitive }),
    };
    (accel, options)
}

/// What is wrong with a key, and what to do.
fn in_words(scene: &Path, misfit: &OptionMisfit, is_pg1: bool) -> String {
    let (key, pg1) = match misfit.option {
        HierarchyOption::Builder => ("builder", ""),
        HierarchyOption::LeafSize => ("leaf-size", " (max_triangles_per_BB)"),
        HierarchyOption::TreeDepth => ("tree-depth", " (max_depth of the data structure)"),
        HierarchyOption::SahCosts => ("sah-costs", ""),
    };
    let (scene, pg1) = (scene.display(), if is_pg1 { pg1 } else { "" });
    match misfit.kind {
        MisfitKind::Structure(names) => {
            format!("{scene}: device: {key}{pg1} would do nothing: it needs \"accel\": {names}: leave it out")
        }
        MisfitKind::Range(range) => format!("{scene}: device: {key}{pg1} must be {range}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use eosphor::{Builder, Structure, TreeBuilder};
    use std::collections::BTreeSet;

    #[test]
    fn files_have_the_names_of_the_command_line() {
        let files: Vec<&str> = Structure::ALL.iter().map(|structure| structure.name()).collect();
        let flags: Vec<&str> = Accel::ALL.iter().map(|accel| accel.name()).collect();
        assert_eq!(files, flags);
        let files: BTreeSet<&str> = TreeBuilder::ALL.iter().map(|builder| builder.name()).collect();
        let flags: BTreeSet<&str> = Builder::ALL.iter().map(|builder| builder.name()).collect();
        assert_eq!(files, flags);
    }
}
