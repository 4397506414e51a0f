//! Surfaces of four corners of a JSON scene.

use super::build::{Builder, MaterialNames};
use super::format::QuadrilateralEntry;
use super::semantics;
use super::tree::way;
use crate::double::sub;
use crate::error::SceneError;
use crate::model::{Quadrilateral, Transform, double, single};

impl Builder<'_> {
    pub(super) fn add_quadrilaterals(
        &mut self,
        entries: Vec<QuadrilateralEntry>,
        materials: &MaterialNames,
    ) -> Result<(), SceneError> {
        for (i, QuadrilateralEntry { corners, material }) in entries.into_iter().enumerate() {
            let material = self.material(material, materials, &way!["quadrilaterals", i, "material"])?;
            let material = material.unwrap_or_else(|| self.loader.default_material());
            let exact = [0, 1, 2, 3].map(|k| {
                let of_file = self.exact(&way!["quadrilaterals", i, "corners", k]);
                of_file.unwrap_or(double(corners[k]))
            });
            let about_first = exact.map(|corner| single(sub(corner, exact[0])));
            semantics::check_corners(self.document, i, &about_first)?;
            let size = about_first.iter().fold(0.0, |most: f32, p| most.max(p.abs().max_component()));
            let is_apart = self.is_beyond(exact[0], f64::from(size));
            let scene = &mut self.loader.scene;
            if is_apart {
                let place = Transform { offset: exact[0], ..Transform::default() };
                Quadrilateral { corners: about_first, material }.add_mesh(scene, place);
            } else {
                Quadrilateral { corners, material }.add_to(scene);
            }
        }
        Ok(())
    }
}
