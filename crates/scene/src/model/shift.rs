//! Moving all geometry of a scene.

use super::{Move, Scene, Transform};
use eosphor_core::math::Vec3;
use std::sync::Arc;

impl Scene {
    /// Moves all geometry, in coordinates of the file; camera and lights stay.
    pub fn move_geometry(&mut self, by: [f64; 3]) {
        if self.move_far_geometry(by) {
            return;
        }
        let offset = Vec3::from(by.map(|x| x as f32));
        let motion = Arc::new(Move { transform: Transform::translation(offset), ..Move::default() });
        for instance in &mut self.instances {
            if !instance.moves.is_empty() {
                // What moves is moved as it comes out of its motions.
                instance.moves.push(Arc::clone(&motion));
                continue;
            }
            let Transform { translate, matrix, .. } = &mut instance.world_from_object;
            match matrix {
                // The matrix comes after the translation.
                Some(rows) => {
                    rows.iter_mut().zip(<[f32; 3]>::from(offset)).for_each(|(row, by)| row[3] += by)
                }
                None => *translate += offset,
            }
        }
        self.spheres.iter_mut().for_each(|sphere| sphere.center += offset);
        self.parallelograms.iter_mut().for_each(|parallelogram| parallelogram.corner += offset);
    }
}
