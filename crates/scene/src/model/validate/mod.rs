//! What a scene must satisfy to be rendered: checked once, in one place, for files, flags and programs alike.

mod animation;

use super::{
    AlphaMode, Camera, CameraMotion, Composition, EnvironmentMap, EnvironmentSource, Image, Light,
    LightParts, LightSelection, LightUnits, Material, MaterialKind, Mesh, Mtl, NO_INDEX, Pbr, PixelSampling,
    RenderSettings, Scene, Sky, TexelLayout, Texture,
};
use crate::error::Problem;
use eosphor_core::math::Vec3;
use eosphor_core::settings::Integrator;
use std::fmt::Display;

/// The largest absolute coordinate. Squares of sums of such numbers stay finite in single precision.
pub(crate) const MAX_COORDINATE: f32 = 1e12;

type Check = Result<(), Problem>;

impl RenderSettings {
    /// Whether every setting is in its range; the error names the setting and the range.
    pub fn validate(&self) -> Check {
        let [width, height] = self.size;
        whole("size (width)", width, 1, 65_535)?;
        whole("size (height)", height, 1, 65_535)?;
        whole("samples", self.samples, 1, 65_536)?;
        if let PixelSampling::Grid(side) = self.pixel_sampling {
            whole("pixel-sampling (grid)", side, 1, 256)?;
        }
        whole("light-samples", self.light_samples, 1, 65_536)?;
        whole("depth", self.depth, 0, 64)?;
        whole("roulette", self.roulette, 0, 64)?;
        if let Some(limit) = self.clamp_indirect {
            over_zero("settings.clamp-indirect", limit)?;
        }
        if self.integrator == Integrator::Path {
            self.validate_for_paths()?;
        }
        setting("energy-threshold", self.energy_threshold, 0.0, 1.0)?;
        setting("crease-degrees", self.crease_degrees, 0.0, 180.0)?;
        setting("ambient", self.ambient, 0.0, 1e6)?;
        if let Some(d) = self.max_distance {
            over_zero("settings.max-distance", d)?;
        }
        color("settings.background", self.background)?;
        setting("exposure", self.exposure, -64.0, 64.0)
    }

    /// What path tracing cannot do.
    fn validate_for_paths(&self) -> Check {
        let refused = |what: &str, why: &str| {
            let message = format!(
                "{why}, and path tracing has none of it; use the integrator whitted, or leave it out"
            );
            Err(Problem::new(format!("settings.{what}"), message))
        };
        if !self.lighting.is_lit() {
            return refused("lighting", "this model shows surfaces without light");
        }
        if self.lights == Some(LightSelection::All) {
            return refused("lights", "\"all\" asks for a shadow ray to each light");
        }
        if self.light_units != LightUnits::Physical {
            return refused("light-units", "plain units are those of the reference systems");
        }
        if !self.light_falloff {
            return refused("light-falloff", "light without falloff is that of the reference systems");
        }
        if self.composition != Composition::Native {
            return refused("composition", "this composition is that of a reference system");
        }
        Ok(())
    }
}

impl Scene {
    /// Whether the scene can be rendered: settings in range, every number finite, every index in range. Loading and
    /// flattening call it.
    pub fn validate(&self) -> Check {
        self.settings.validate()?;
        if !self.origin.iter().all(|x| x.abs() <= f64::from(MAX_COORDINATE)) {
            let message =
                format!("{:?} is out of range; coordinates must be within {MAX_COORDINATE:e}", self.origin);
            return Err(Problem::new("origin", message));
        }
        if let Some(camera) = &self.camera {
            let motion = self.animation.as_ref().and_then(|animation| animation.camera.as_ref());
            check_camera(camera, motion.is_some_and(CameraMotion::sets_view))?;
        }
        if let Some(animation) = &self.animation {
            animation::check(animation, self.lights.len())?;
        }
        self.check_frame()?;
        for (i, light) in self.lights.iter().enumerate() {
            check_light(light, &format!("lights[{i}]"))?;
        }
        for image in &self.images {
            check_image(image)?;
        }
        for (i, texture) in self.textures.iter().enumerate() {
            check_texture(texture, i, self.images.len())?;
        }
        if let Some(environment) = &self.environment {
            check_environment(environment, self.images.len())?;
        }
        for material in &self.materials {
            check_material(material, self.textures.len())?;
        }
        for mesh in &self.meshes {
            check_mesh(mesh, self.materials.len())?;
        }
        for (i, instance) in self.instances.iter().enumerate() {
            let what = || format!("instances[{i}]");
            index(what, "mesh", instance.mesh, self.meshes.len())?;
            if let Some(material) = instance.material {
                index(what, "material", material, self.materials.len())?;
            }
            if !instance.world_from_object.affine().is_finite() {
                return Err(Problem::new(what(), "its transform is not finite; use smaller numbers"));
            }
            animation::check_moves(&what(), instance.moves.iter().map(|motion| &**motion))?;
        }
        for (i, sphere) in self.spheres.iter().enumerate() {
            let what = || format!("spheres[{i}]");
            point(what, "center", sphere.center)?;
            over_zero(&format!("spheres[{i}].radius"), sphere.radius)?;
            index(what, "material", sphere.material, self.materials.len())?;
        }
        for (i, p) in self.parallelograms.iter().enumerate() {
            let what = || format!("parallelograms[{i}]");
            point(what, "corner", p.corner)?;
            point(what, "edge-u", p.edge_u)?;
            point(what, "edge-v", p.edge_v)?;
            index(what, "material", p.material, self.materials.len())?;
        }
        Ok(())
    }
}

/// `is_aimed`: its motion says which point it looks at.
fn check_camera(camera: &Camera, is_aimed: bool) -> Check {
    let what = || "camera".to_string();
    point(what, "position", camera.position)?;
    point(what, "look-at", camera.look_at.unwrap_or(Vec3::ZERO))?;
    point(what, "direction", camera.direction)?;
    point(what, "up", camera.up)?;
    let fov = camera.fov_x_degrees;
    if !(fov > 0.0 && fov < 180.0) {
        return Err(Problem::new("camera.fov-x-degrees", format!("{fov} must be over 0 and under 180")));
    }
    if let Some(fov) = camera.fov_y_degrees.filter(|fov| !(*fov > 0.0 && *fov < 180.0)) {
        return Err(Problem::new("camera.fov-y-degrees", format!("{fov} must be over 0 and under 180")));
    }
    if let Some(height) = camera.orthographic_height {
        over_zero("camera.orthographic-height", height)?;
    }
    let Some(lens) = camera.lens else { return Ok(()) };
    number("camera.lens.aperture-radius", lens.aperture_radius, 0.0, MAX_COORDINATE)?;
    match lens.focus_distance {
        Some(distance) => over_zero("camera.lens.focus-distance", distance),
        None if camera.look_at.is_some() || is_aimed => Ok(()),
        None => Err(Problem::new(
            "camera.lens",
            "which distance is sharp? Give focus-distance, or let the camera look-at a point",
        )),
    }
}

fn check_light(light: &Light, name: &str) -> Check {
    let mut light = *light;
    let own = light.own_numbers();
    let LightParts { position, direction, color: c } = light.parts();
    if let Some(position) = position {
        point(|| name.to_string(), "position", *position)?;
    }
    if let Some(direction) = direction {
        unit_able(name, *direction)?;
    }
    color(&format!("{name}.color"), *c)?;
    own.into_iter()
        .try_for_each(|(key, value, least, most)| number(&format!("{name}.{key}"), value, least, most))
}

fn check_environment(environment: &EnvironmentMap, images: usize) -> Check {
    match environment.source {
        EnvironmentSource::Image(image) => index(|| "environment".into(), "image", image, images)?,
        EnvironmentSource::Sky(sky) => {
            let Sky { sun_elevation_degrees, sun_azimuth_degrees, turbidity, albedo, sun_strength } = sky;
            for (key, value, least, most) in [
                ("sun-elevation-degrees", sun_elevation_degrees, 0.0, 90.0),
                ("sun-azimuth-degrees", sun_azimuth_degrees, -360.0, 360.0),
                ("turbidity", turbidity, 1.0, 10.0),
                ("albedo", albedo, 0.0, 1.0),
                ("sun-strength", sun_strength, 0.0, 1e6),
            ] {
                number(&format!("environment.sky.{key}"), value, least, most)?;
            }
        }
    }
    number("environment.strength", environment.strength, 0.0, 1e6)?;
    number("environment.rotation-degrees", environment.rotation_degrees, -1e6, 1e6)?;
    if environment.up.is_finite() && environment.up.normalize_or(Vec3::ZERO) != Vec3::ZERO {
        return Ok(());
    }
    Err(Problem::new("environment.up", "it has no length; give the way to the top of the picture"))
}

fn check_material(material: &Material, textures: usize) -> Check {
    let name = format!("material \"{}\"", material.name);
    let t = &material.textures;
    let whole = [t.color, t.specular, t.emission, t.normal];
    let channels = [t.opacity, t.metallic, t.roughness, t.transmission].map(|c| c.map(|c| c.texture));
    for texture in whole.into_iter().chain(channels).flatten() {
        index(|| name.clone(), "texture", texture, textures)?;
    }
    let field = |key: &str| format!("{name}, {key}");
    number(&field("normal-scale"), t.normal_scale, -1e6, 1e6)?;
    number(&field("diffuse-roughness"), material.diffuse_roughness, 0.0, 1.0)?;
    if material.diffuse_roughness > 0.0 && !material.kind.has_ground() {
        let message = "this kind has no ground that it could be the roughness of; leave it out";
        return Err(Problem::new(field("diffuse-roughness"), message));
    }
    if let AlphaMode::Mask { cutoff } = material.alpha {
        number(&field("cutoff"), cutoff, 0.0, 1e6)?;
    }
    match material.kind {
        MaterialKind::Mtl(Mtl { Kd, Ks, Ke, Tf, Ns, Ni, d, illum, Pr, Pm, .. }) => {
            color(&field("Kd"), Kd)?;
            color(&field("Ks"), Ks)?;
            color(&field("Ke"), Ke)?;
            color(&field("Tf"), Tf.unwrap_or(Vec3::ZERO))?;
            number(&field("Ns"), Ns, 0.0, 1e6)?;
            ior(&field("Ni"), Ni.unwrap_or(1.0))?;
            number(&field("d"), d, 0.0, 1.0)?;
            number(&field("Pr"), Pr.unwrap_or(0.0), 0.0, 1.0)?;
            number(&field("Pm"), Pm.unwrap_or(0.0), 0.0, 1.0)?;
            if illum > 10 {
                return Err(Problem::new(field("illum"), format!("{illum} must be 0 to 10")));
            }
            Ok(())
        }
        MaterialKind::Pbr(pbr) => check_pbr(&pbr, field),
        MaterialKind::Matte { color: c } => color(&field("color"), c),
        MaterialKind::Mirror { reflectance } => color(&field("reflectance"), reflectance),
        MaterialKind::Dielectric { ior: i, tint } => {
            ior(&field("ior"), i)?;
            color(&field("tint"), tint)
        }
        MaterialKind::Glossy { reflectance, exponent, rays, color: c } => {
            color(&field("reflectance"), reflectance)?;
            color(&field("color"), c)?;
            number(&field("exponent"), exponent, 0.0, 1e6)?;
            number(&field("rays"), rays as f32, 1.0, 65_536.0)
        }
        MaterialKind::Transparent { color: c, transparency, reflection, shininess, diffuse } => {
            color(&field("color"), c)?;
            number(&field("transparency"), transparency, 0.0, 1.0)?;
            number(&field("reflection"), reflection, 0.0, 1.0)?;
            number(&field("shininess"), shininess, 0.0, 1e6)?;
            number(&field("diffuse"), diffuse, 0.0, 1.0)
        }
        MaterialKind::Emissive { radiance } => color(&field("radiance"), radiance),
    }
}

fn check_pbr(pbr: &Pbr, field: impl Fn(&str) -> String) -> Check {
    color(&field("color"), pbr.color)?;
    color(&field("emission"), pbr.emission)?;
    color(&field("specular-color"), pbr.specular_color)?;
    color(&field("attenuation-color"), pbr.attenuation_color)?;
    ior(&field("ior"), pbr.ior)?;
    for (key, x) in [
        ("opacity", pbr.opacity),
        ("metallic", pbr.metallic),
        ("roughness", pbr.roughness),
        ("specular", pbr.specular),
        ("transmission", pbr.transmission),
        ("attenuation-color", pbr.attenuation_color.max_component()),
    ] {
        number(&field(key), x, 0.0, 1.0)?;
    }
    pbr.attenuation_distance.map_or(Ok(()), |d| over_zero(&field("attenuation-distance"), d))
}

fn check_image(image: &Image) -> Check {
    let what = || format!("image \"{}\"", image.name);
    let sides = 1..=65_535;
    if !sides.contains(&image.width) || !sides.contains(&image.height) {
        let message = format!("its size is {} x {}; sides must be 1 to 65535", image.width, image.height);
        return Err(Problem::new(what(), message));
    }
    if u64::from(image.width) * u64::from(image.height) != image.texels.len() as u64 {
        let sides = format!("{} x {}", image.width, image.height);
        return Err(Problem::new(what(), format!("{} texels do not fill {sides}", image.texels.len())));
    }
    let words = image.texels.words();
    match image.texels.layout() {
        TexelLayout::Floats(_) if words.iter().any(|&x| !f32::from_bits(x).is_finite()) => {
            Err(Problem::new(what(), "a texel is not finite"))
        }
        TexelLayout::Halves(_) if words.iter().any(|&two| two & 0xffff > 0x7c00 || two >> 16 > 0x7c00) => {
            Err(Problem::new(what(), "a texel is negative or no number"))
        }
        _ => Ok(()),
    }
}

fn check_texture(texture: &Texture, number: usize, images: usize) -> Check {
    let what = || format!("textures[{number}]");
    index(what, "image", texture.image, images)?;
    if texture.uv_set > 1 {
        return Err(Problem::new(what(), format!("uv-set {} does not exist; there are 2", texture.uv_set)));
    }
    if texture.picture_from_mesh_uv.iter().flatten().any(|x| !x.is_finite()) {
        return Err(Problem::new(what(), "its map of texture coordinates is not finite"));
    }
    Ok(())
}

fn check_mesh(mesh: &Mesh, materials: usize) -> Check {
    let what = || format!("mesh \"{}\"", mesh.name);
    for &p in &mesh.positions {
        point(what, "a vertex", p)?;
    }
    if mesh.uvs.iter().flatten().any(|x| !x.is_finite()) || mesh.normals.iter().any(|n| !n.is_finite()) {
        return Err(Problem::new(what(), "a normal or texture coordinate is not finite"));
    }
    for (name, length) in [("colours", mesh.colors.len()), ("second texture coordinates", mesh.uvs1.len())] {
        if length != 0 && length != mesh.positions.len() {
            let message =
                format!("{length} {name} for {} vertices; there must be one each", mesh.positions.len());
            return Err(Problem::new(what(), message));
        }
    }
    let is_color = |c: &[f32; 4]| c.iter().all(|x| (0.0..=MAX_COORDINATE).contains(x));
    if mesh.uvs1.iter().flatten().any(|x| !x.is_finite()) || !mesh.colors.iter().all(is_color) {
        return Err(Problem::new(what(), "a vertex colour or texture coordinate is negative or not finite"));
    }
    let outside = |indices: [u32; 3], len: usize, optional: bool| {
        indices.iter().any(|&i| i as usize >= len && !(optional && i == NO_INDEX))
    };
    if mesh.deformation.as_ref().is_some_and(|deformation| !deformation.fits(mesh)) {
        return Err(Problem::new(what(), "its vertices are not those that its deformation was made for"));
    }
    for (i, t) in mesh.triangles.iter().enumerate() {
        if outside(t.positions, mesh.positions.len(), false)
            || outside(t.normals, mesh.normals.len(), true)
            || outside(t.uvs, mesh.uvs.len(), true)
        {
            return Err(Problem::new(what(), format!("triangle {i} has an index out of range")));
        }
        index(what, "material", t.material, materials)?;
    }
    Ok(())
}

fn whole(name: &str, x: u32, low: u32, high: u32) -> Check {
    in_range(format!("settings.{name}"), x, low, high)
}

fn setting(name: &str, x: f32, low: f32, high: f32) -> Check {
    in_range(format!("settings.{name}"), x, low, high)
}

fn number(what: &str, x: f32, low: f32, high: f32) -> Check {
    in_range(what.to_string(), x, low, high)
}

fn in_range<T: PartialOrd + Display>(what: String, x: T, low: T, high: T) -> Check {
    if x >= low && x <= high {
        return Ok(());
    }
    Err(Problem::new(what, format!("{x} is out of range; it must be {low} to {high}")))
}

fn over_zero(what: &str, x: f32) -> Check {
    if x > 0.0 && x <= MAX_COORDINATE {
        return Ok(());
    }
    Err(Problem::new(what, format!("{x} must be over 0 and at most {MAX_COORDINATE:e}")))
}

fn ior(what: &str, x: f32) -> Check {
    if (0.01..=100.0).contains(&x) {
        return Ok(());
    }
    Err(Problem::new(what, format!("{x} is no index of refraction; it must be 0.01 to 100")))
}

fn color(what: &str, c: Vec3) -> Check {
    if c.is_finite() && c.min_component() >= 0.0 && c.max_component() <= MAX_COORDINATE {
        return Ok(());
    }
    let [r, g, b] = <[f32; 3]>::from(c);
    Err(Problem::new(
        what,
        format!("({r}, {g}, {b}) is no colour; components must be 0 to {MAX_COORDINATE:e}"),
    ))
}

fn point(what: impl Fn() -> String, field: &str, p: Vec3) -> Check {
    if p.is_finite() && p.abs().max_component() <= MAX_COORDINATE {
        return Ok(());
    }
    let [x, y, z] = <[f32; 3]>::from(p);
    let message =
        format!("{field} ({x}, {y}, {z}) is out of range; coordinates must be within {MAX_COORDINATE:e}");
    Err(Problem::new(what(), message))
}

fn unit_able(name: &str, direction: Vec3) -> Check {
    if direction.normalize_or(Vec3::ZERO) != Vec3::ZERO {
        return Ok(());
    }
    Err(Problem::new(format!("{name}.direction"), "it has no length; give the way the light goes"))
}

fn index(what: impl Fn() -> String, field: &str, i: u32, len: usize) -> Check {
    if (i as usize) < len {
        return Ok(());
    }
    Err(Problem::new(what(), format!("{field} {i} does not exist; there are {len}")))
}
