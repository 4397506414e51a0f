//! A scene of what model files bring: metallic-roughness materials, holes, bodies that attenuate, normal maps, textures
//! of all kinds, vertex colours, second texture coordinates, instances with materials of their own.

use eosphor_core::math::{Vec3, vec3};
use eosphor_core::settings::ShadowMode;
use eosphor_core::texture::{TextureFilter, TextureWrap};
use eosphor_scene::{
    AlphaMode, Camera, Channel, DeviceSettings, Image, Instance, Light, Material, MaterialKind, Mesh,
    NO_INDEX, Parallelogram, Pbr, RenderSettings, Scene, Sphere, TexelLayout, Texels, Texture,
    TextureChannel, TextureContent, Transform, Triangle,
};

/// A bumpy sheet of `n` by `n` quads with colours and two sets of texture coordinates.
fn sheet(n: u32) -> Mesh {
    let mut mesh = Mesh { name: "sheet".into(), ..Mesh::default() };
    for (i, j) in (0..=n).flat_map(|i| (0..=n).map(move |j| (i, j))) {
        let (x, z) = (i as f32 / n as f32, j as f32 / n as f32);
        mesh.positions.push(vec3(x - 0.5, 0.08 * ((i * 7 + j * 13) % 5) as f32 - 0.1, z - 0.5));
        mesh.uvs.push([x, z]);
        mesh.uvs1.push([3.0 * z, 2.0 - 2.5 * x]);
        mesh.colors.push([1.0, x, 1.0 - z, 0.3 + 0.7 * x]);
    }
    for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
        let a = i * (n + 1) + j;
        for positions in [[a, a + 1, a + n + 2], [a, a + n + 2, a + n + 1]] {
            mesh.triangles.push(Triangle { positions, uvs: positions, normals: [NO_INDEX; 3], material: 0 });
        }
    }
    mesh
}

/// Four pictures, each of another layout: colours with alpha, data, floats of either kind.
fn images() -> Vec<Image> {
    let words =
        |k: u32, texel_bytes: u32| (0..12 * texel_bytes).map(move |i| (i + k).wrapping_mul(0x9e37_79b9));
    let image = |name: &str, layout, words: Vec<u32>| {
        let texels = Texels::new(layout, 48, words);
        Image { name: name.into(), width: 8, height: 6, texels }
    };
    vec![
        image("colors", TexelLayout::Bytes(4), words(1, 4).collect()),
        image("data", TexelLayout::Bytes(3), words(2, 3).collect()),
        // Below 1, denormal ones too.
        image("halves", TexelLayout::Halves(4), words(3, 8).map(|two| two & 0x3bff_3bff).collect()),
        image("radiance", TexelLayout::Rgbe, words(4, 4).map(|w| w & 0x00ff_ffff | 0x8000_0000).collect()),
    ]
}

fn textures() -> Vec<Texture> {
    let turned = [[1.5, 0.5, 0.1], [-0.5, 2.0, 0.3]];
    vec![
        Texture { wrap_u: TextureWrap::Mirror, ..Texture::of_image(0) },
        Texture { content: TextureContent::Data, filter: TextureFilter::Nearest, ..Texture::of_image(1) },
        Texture { wrap_v: TextureWrap::Clamp, picture_from_mesh_uv: turned, ..Texture::of_image(2) },
        Texture { uv_set: 1, ..Texture::of_image(3) },
    ]
}

fn materials() -> Vec<Material> {
    let base = Pbr { color: vec3(0.9, 0.6, 0.4), ..Pbr::default() };
    let pbr = |name: &str, pbr: Pbr| Material::new(name, MaterialKind::Pbr(pbr));
    let channel = |texture, channel| Some(TextureChannel { texture, channel });
    let mut list = vec![
        pbr("plastic", Pbr { roughness: 0.4, ..base }),
        pbr("metal", Pbr { metallic: 1.0, roughness: 0.3, ..base }),
        pbr("mirror", Pbr { metallic: 1.0, roughness: 0.0, ..base }),
        pbr(
            "body",
            Pbr {
                color: Vec3::ONE,
                roughness: 0.0,
                transmission: 1.0,
                solid: true,
                attenuation_color: vec3(0.9, 0.5, 0.2),
                attenuation_distance: Some(0.8),
                ..base
            },
        ),
        pbr("frosted", Pbr { roughness: 0.35, transmission: 0.9, ..base }),
        pbr("mapped", Pbr { metallic: 0.9, specular: 0.7, ..base }),
        pbr("cut out", base),
        pbr("veil", Pbr { opacity: 0.8, emission: vec3(0.1, 0.2, 0.3), ..base }),
        Material::new("ground", MaterialKind::Matte { color: vec3(0.7, 0.7, 0.7) }),
    ];
    list[5].textures.color = Some(2);
    list[5].textures.metallic = channel(1, Channel::Blue);
    list[5].textures.roughness = channel(1, Channel::Green);
    list[5].textures.normal = Some(0);
    list[5].textures.normal_scale = 0.6;
    list[6].textures.color = Some(0);
    list[6].textures.opacity = channel(0, Channel::Alpha);
    list[6].alpha = AlphaMode::Mask { cutoff: 0.5 };
    list[7].textures.color = Some(3);
    list[7].textures.emission = Some(2);
    list[7].textures.opacity = channel(3, Channel::Red);
    list[7].alpha = AlphaMode::Blend;
    list[8].textures.color = Some(2);
    list[5].single_sided = true;
    list
}

/// The scene.
pub(crate) fn scene() -> Scene {
    let placed = |k: u32| {
        let (x, y) = ((k % 4) as f32 * 1.1 - 1.65, 0.5 + (k / 4) as f32 * 0.9);
        let world_from_object = Transform {
            rotate_degrees: vec3(50.0, 15.0 * k as f32, 5.0),
            scale: vec3(1.0, if k == 2 { -1.0 } else { 1.0 }, 0.9),
            ..Transform::translation(vec3(x, y, 0.4 * (k % 2) as f32))
        };
        Instance {
            mesh: 0,
            material: (k > 0).then_some([1, 5, 6, 7, 0, 4, 7][k as usize % 7]),
            world_from_object,
            moves: Vec::new(),
        }
    };
    let ball = |k: u32| Sphere {
        center: vec3(k as f32 * 0.9 - 1.8, 0.35, 1.6),
        radius: 0.35,
        material: [0, 1, 2, 3, 4][k as usize],
    };
    let ground = Parallelogram {
        corner: vec3(-4.0, 0.0, 4.0),
        edge_u: vec3(8.0, 0.0, 0.0),
        edge_v: vec3(0.0, 0.0, -8.0),
        material: 8,
    };
    let (camera, mut settings) = (Camera::default(), RenderSettings::default());
    settings.size = [97, 71];
    settings.samples = 2;
    settings.shadows = ShadowMode::Coloured;
    settings.background = vec3(0.2, 0.3, 0.4);
    settings.ambient = 0.1;
    Scene {
        environment: None,
        origin: [0.0; 3],
        // 288 triangles: too many to be baked.
        meshes: vec![sheet(12)],
        instances: (0..8).map(placed).collect(),
        spheres: (0..5).map(ball).collect(),
        parallelograms: vec![ground],
        materials: materials(),
        images: images(),
        textures: textures(),
        lights: vec![
            Light::Point { position: vec3(1.0, 4.0, 3.0), color: Vec3::splat(14.0) },
            Light::Directional { direction: vec3(1.0, -2.0, -1.0), color: Vec3::splat(0.6) },
        ],
        camera: Some(Camera {
            position: vec3(0.3, 2.2, 6.5),
            look_at: Some(vec3(0.0, 0.7, 0.0)),
            fov_y_degrees: Some(32.0),
            ..camera
        }),
        settings,
        device: DeviceSettings::default(),
        output: None,
        animation: None,
        frame: 0,
    }
}
