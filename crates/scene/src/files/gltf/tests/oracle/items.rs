//! Accessors, buffers, images, samplers, textures and animations.

use super::{crate_index, index, known, same};
use crate::files::gltf::document::{ComponentType, Document};
use gltf::json::Root;
use gltf::json::animation::Property;

pub(super) fn agree(ours: &Document, theirs: &Root) {
    accessors(ours, theirs);
    buffers(ours, theirs);
    pictures(ours, theirs);
    animations(ours, theirs);
}

fn accessors(ours: &Document, theirs: &Root) {
    for (i, (a, b)) in ours.accessors.iter().zip(&theirs.accessors).enumerate() {
        let place = &format!("accessor {i}");
        same(
            place,
            (&a.name, index(a.buffer_view), a.byte_offset, a.count, a.component_type, a.element_type),
            (
                &b.name,
                crate_index(b.buffer_view),
                b.byte_offset.map(|x| x.0),
                b.count.0,
                known(&b.component_type).map(|x| x.0),
                known(&b.type_),
            ),
        );
        same(place, (a.normalized, a.sparse.is_some()), (b.normalized, b.sparse.is_some()));
        let (Some(a), Some(b)) = (&a.sparse, &b.sparse) else { continue };
        let (at, to) = (&a.indices, &b.indices);
        let component = at
            .component_type
            .filter(|c| matches!(c, ComponentType::U8 | ComponentType::U16 | ComponentType::U32));
        same(
            place,
            (a.count, at.buffer_view.value(), at.byte_offset, component),
            (b.count.0, to.buffer_view.value(), to.byte_offset.0, known(&to.component_type).map(|x| x.0)),
        );
        same(
            place,
            (a.values.buffer_view.value(), a.values.byte_offset),
            (b.values.buffer_view.value(), b.values.byte_offset.0),
        );
    }
}

fn buffers(ours: &Document, theirs: &Root) {
    for (i, (a, b)) in ours.buffers.iter().zip(&theirs.buffers).enumerate() {
        same(&format!("buffer {i}"), (&a.name, &a.uri), (&b.name, &b.uri));
    }
    for (i, (a, b)) in ours.buffer_views.iter().zip(&theirs.buffer_views).enumerate() {
        same(
            &format!("bufferView {i}"),
            (&a.name, a.buffer.value(), a.byte_offset, a.byte_length, a.byte_stride),
            (
                &b.name,
                b.buffer.value(),
                b.byte_offset.map(|x| x.0),
                b.byte_length.0,
                b.byte_stride.map(|x| x.0),
            ),
        );
    }
}

fn pictures(ours: &Document, theirs: &Root) {
    for (i, (a, b)) in ours.images.iter().zip(&theirs.images).enumerate() {
        same(
            &format!("image {i}"),
            (&a.name, &a.uri, index(a.buffer_view)),
            (&b.name, &b.uri, crate_index(b.buffer_view)),
        );
    }
    for (i, (a, b)) in ours.samplers.iter().zip(&theirs.samplers).enumerate() {
        same(
            &format!("sampler {i}"),
            (a.mag_filter, a.wrap_s, a.wrap_t),
            (b.mag_filter.as_ref().and_then(known), known(&b.wrap_s), known(&b.wrap_t)),
        );
    }
    for (i, (a, b)) in ours.textures.iter().zip(&theirs.textures).enumerate() {
        // The crate's number for no image.
        let source = Some(b.source.value()).filter(|&source| source != u32::MAX as usize);
        let source_of_ours = index(a.source).filter(|&source| source != u32::MAX as usize);
        let mut extensions: Vec<&String> = b.extensions.iter().flat_map(|e| e.others.keys()).collect();
        extensions.sort();
        same(
            &format!("texture {i}"),
            (&a.name, index(a.sampler), source_of_ours),
            (&b.name, crate_index(b.sampler), source),
        );
        let extensions_of_ours: Vec<&String> = a.extensions.iter().flatten().map(|(name, _)| name).collect();
        same(&format!("texture {i}"), extensions_of_ours, extensions);
    }
}

fn animations(ours: &Document, theirs: &Root) {
    for (i, (a, b)) in ours.animations.iter().zip(&theirs.animations).enumerate() {
        let place = &format!("animation {i}");
        same(
            place,
            (&a.name, a.channels.len(), a.samplers.len()),
            (&b.name, b.channels.len(), b.samplers.len()),
        );
        for (a, b) in a.channels.iter().zip(&b.channels) {
            let path = known(&b.target.path).map(|path| match path {
                Property::Translation => "Translation",
                Property::Rotation => "Rotation",
                Property::Scale => "Scale",
                Property::MorphTargetWeights => "Weights",
            });
            let path_of_ours = a.target.path.map(|path| format!("{path:?}"));
            same(
                place,
                (a.sampler.value(), index(a.target.node), path_of_ours),
                (b.sampler.value(), Some(b.target.node.value()), path),
            );
        }
        for (a, b) in a.samplers.iter().zip(&b.samplers) {
            same(
                place,
                (a.input.value(), a.output.value(), a.interpolation),
                (b.input.value(), b.output.value(), known(&b.interpolation)),
            );
        }
    }
}
