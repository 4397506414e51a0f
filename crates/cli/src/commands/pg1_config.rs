//! What becomes of each key of a configuration of PG1, for `-v`.

use crate::arguments::RenderFlags;
use crate::streams::Verbosity;
use eosphor::settings::LightingModel;
use eosphor::{ConfigKey, KeyUse, Scene, config_keys, scene_requests};

/// Says it, a line for each key, where the scene is such a configuration.
pub(super) fn tell(flags: &RenderFlags, scene: &Scene) {
    let verbosity = flags.report.verbosity();
    if verbosity != Verbosity::Verbose {
        return;
    }
    for key in config_keys(&flags.scene) {
        let ConfigKey { key: name, value, .. } = &key;
        let file = flags.scene.display();
        verbosity.say(Verbosity::Verbose, &format!("{file}: {name} = {value}: {}", said(&key, flags, scene)));
    }
}

fn said(key: &ConfigKey, flags: &RenderFlags, scene: &Scene) -> String {
    let (setting, winners) = match key.used {
        KeyUse::Not(reason) => return format!("not used: {reason}"),
        KeyUse::As { setting, flags } => (setting, flags),
    };
    if key.key == "renderer.max_distance" && scene.settings.lighting != LightingModel::Distance {
        return "not used: it is for the lighting distance".into();
    }
    match winners.iter().find(|flag| wins(flag, flags)) {
        Some(flag) => format!("overridden by --{flag}"),
        None => format!("obeyed as {setting}"),
    }
}

/// Whether a flag was given that wins. A structure that the file names too leaves the file its limits.
fn wins(flag: &str, flags: &RenderFlags) -> bool {
    let is_same = || {
        let asked = scene_requests(&flags.scene).device.accel.map(|accel| accel.name());
        flags.picture.accel.map(|accel| accel.name()) == asked
    };
    flags.is_given(flag) && !(flag == "accel" && is_same())
}
