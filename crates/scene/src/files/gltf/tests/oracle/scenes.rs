//! Scenes, nodes, meshes, cameras and lights.

use super::{crate_index, index, known, same};
use crate::files::gltf::document::{Document, Node, Primitive};
use gltf::json::mesh::{Primitive as CratePrimitive, Semantic};
use gltf::json::scene::Node as CrateNode;
use gltf::json::validation::Checked;
use gltf::json::{Root, Value};

pub(super) fn agree(ours: &Document, theirs: &Root) {
    for (i, (a, b)) in ours.scenes.iter().zip(&theirs.scenes).enumerate() {
        let nodes: Vec<usize> = a.nodes.iter().map(|node| node.value()).collect();
        same(&format!("scene {i}"), nodes, b.nodes.iter().map(|node| node.value()).collect::<Vec<_>>());
    }
    for (i, (a, b)) in ours.nodes.iter().zip(&theirs.nodes).enumerate() {
        node(&format!("node {i}"), a, b);
    }
    for (i, (a, b)) in ours.meshes.iter().zip(&theirs.meshes).enumerate() {
        let place = &format!("mesh {i}");
        same(place, (&a.name, &a.weights, a.primitives.len()), (&b.name, &b.weights, b.primitives.len()));
        for (a, b) in a.primitives.iter().zip(&b.primitives) {
            primitive(place, a, b);
        }
    }
    for (i, (a, b)) in ours.skins.iter().zip(&theirs.skins).enumerate() {
        let place = &format!("skin {i}");
        same(place, (&a.name, a.joints.len()), (&b.name, b.joints.len()));
        let joints = a.joints.iter().zip(&b.joints);
        joints.for_each(|(a, b)| same(place, a.value(), b.value()));
        same(place, index(a.inverse_bind_matrices), crate_index(b.inverse_bind_matrices));
    }
    cameras(ours, theirs);
    lights(ours, theirs);
}

fn node(place: &str, a: &Node, b: &CrateNode) {
    let children: Option<Vec<usize>> = a.children.as_ref().map(|all| all.iter().map(|c| c.value()).collect());
    let of_crate: Option<Vec<usize>> = b.children.as_ref().map(|all| all.iter().map(|c| c.value()).collect());
    same(place, (&a.name, children), (&b.name, of_crate));
    same(
        place,
        (a.matrix, a.translation, a.rotation, a.scale),
        (b.matrix, b.translation, b.rotation.map(|q| q.0), b.scale),
    );
    same(
        place,
        (index(a.mesh), index(a.camera), index(a.skin), &a.weights),
        (crate_index(b.mesh), crate_index(b.camera), crate_index(b.skin), &b.weights),
    );
    let light = b.extensions.as_ref().and_then(|e| e.khr_lights_punctual.as_ref());
    same(place, index(a.light()), light.map(|light| light.light.value()));
    let instancing = b.extensions.as_ref().and_then(|e| e.others.get("EXT_mesh_gpu_instancing"));
    let of_crate = |name: &str| instancing.and_then(|e| e["attributes"][name].as_u64());
    let attributes = a.instancing().and_then(|instancing| instancing.attributes.as_ref());
    same(
        place,
        attributes.map_or([None; 3], |a| [a.translation, a.rotation, a.scale].map(index)),
        ["TRANSLATION", "ROTATION", "SCALE"].map(of_crate),
    );
    same(place, a.instancing().is_some(), instancing.is_some_and(|value| *value != Value::Null));
}

fn primitive(place: &str, a: &Primitive, b: &CratePrimitive) {
    let attribute = |semantic| b.attributes.get(&Checked::Valid(semantic)).map(|index| index.value());
    let attributes = &a.attributes;
    same(
        place,
        (
            index(attributes.position),
            index(attributes.normal),
            index(attributes.tex_coord_0),
            index(attributes.tex_coord_1),
            index(attributes.color_0),
        ),
        (
            attribute(Semantic::Positions),
            attribute(Semantic::Normals),
            attribute(Semantic::TexCoords(0)),
            attribute(Semantic::TexCoords(1)),
            attribute(Semantic::Colors(0)),
        ),
    );
    for n in 0..4 {
        let of_ours = [&attributes.joints, &attributes.weights].map(|sets| index(sets.get(&n).copied()));
        let of_crate = [attribute(Semantic::Joints(n)), attribute(Semantic::Weights(n))];
        same(place, of_ours, of_crate);
    }
    let draco = a.extensions.as_ref().is_some_and(|e| e.draco.is_some());
    let of_crate = b.extensions.as_ref().is_some_and(|e| e.others.contains_key("KHR_draco_mesh_compression"));
    same(
        place,
        (index(a.indices), index(a.material), a.mode, draco),
        (crate_index(b.indices), crate_index(b.material), known(&b.mode), of_crate),
    );
    let targets = a.targets.as_ref();
    let of_crate = b.targets.as_ref();
    same(
        place,
        targets.map(|all| all.iter().map(|t| (index(t.position), index(t.normal))).collect::<Vec<_>>()),
        of_crate.map(|all| {
            all.iter().map(|t| (crate_index(t.positions), crate_index(t.normals))).collect::<Vec<_>>()
        }),
    );
}

fn cameras(ours: &Document, theirs: &Root) {
    for (i, (a, b)) in ours.cameras.iter().zip(&theirs.cameras).enumerate() {
        same(
            &format!("camera {i}"),
            (
                &a.name,
                a.camera_type,
                a.perspective.as_ref().map(|view| view.yfov),
                a.orthographic.as_ref().map(|view| view.ymag),
            ),
            (
                &b.name,
                known(&b.type_),
                b.perspective.as_ref().map(|view| view.yfov),
                b.orthographic.as_ref().map(|view| view.ymag),
            ),
        );
    }
}

fn lights(ours: &Document, theirs: &Root) {
    let of_crate = theirs.extensions.as_ref().and_then(|e| e.khr_lights_punctual.as_ref());
    let of_crate = of_crate.map_or(&[][..], |extension| &extension.lights);
    assert_eq!(ours.lights().len(), of_crate.len());
    for (i, (a, b)) in ours.lights().iter().zip(of_crate).enumerate() {
        same(
            &format!("light {i}"),
            (
                &a.name,
                a.light_type,
                a.color,
                a.intensity,
                a.spot.as_ref().map(|spot| (spot.inner_cone_angle, spot.outer_cone_angle)),
            ),
            (
                &b.name,
                known(&b.type_),
                b.color,
                b.intensity,
                b.spot.as_ref().map(|spot| (spot.inner_cone_angle, spot.outer_cone_angle)),
            ),
        );
    }
}
