//! Assigns a material to every body.

use std::collections::HashMap;

use ndarray::Array2;

use crate::model::{Body, Material, Model, Role};
use crate::warning::ReadWarning;

/// Which bodies share a material.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MaterialRule {
    /// As the files state.
    /// Each body for which they state nothing gets a material of its own, which it shares with the
    /// copies of its mesh.
    #[default]
    Stated,
    /// Every body gets a material of its own, whatever the files state.
    PerBody,
    /// All bodies get the same material.
    Single,
}

impl Model {
    /// Gives every body a material by a rule, and removes materials that are not used.
    ///
    /// Afterwards every body has a material, or paint, except negative bodies without one.
    /// Materials with the same name and colour are merged.
    /// Materials of the file keep their order; the new ones follow.
    /// Purge volumes that the file states follow its materials; they are dropped, with a warning,
    /// if there are materials that the file does not state.
    /// Linear in the painted triangles.
    ///
    /// # Panics
    /// If a body or its paint refers to a material that does not exist.
    pub fn assign_materials(&mut self, rule: MaterialRule) {
        match rule {
            MaterialRule::Stated => self.assign_stated(),
            MaterialRule::PerBody => {
                self.purge_mm3 = None;
                self.materials.clear();
                for (number, body) in self.bodies.iter_mut().enumerate() {
                    self.materials.push(own_material(number, body));
                    (body.material, body.paint) = (Some(number), Vec::new());
                }
            }
            MaterialRule::Single => {
                self.purge_mm3 = None;
                self.materials.truncate(1);
                if self.materials.is_empty() {
                    self.materials.push(Material { name: "all".into(), colour: None });
                }
                for body in &mut self.bodies {
                    (body.material, body.paint) = (Some(0), Vec::new());
                }
            }
        }
    }

    fn assign_stated(&mut self) {
        let stated = std::mem::take(&mut self.materials);
        let mut is_used = vec![false; stated.len()];
        for body in &self.bodies {
            body.paint.iter().for_each(|&paint| is_used[usize::from(paint)] = true);
            if let Some(material) = body.material.filter(|_| body.paint.is_empty()) {
                is_used[material] = true;
            }
        }
        // For each stated material its new number, and for each new one its first old number.
        let mut number_of = vec![0; stated.len()];
        let mut kept = Vec::new();
        for (old, material) in stated.into_iter().enumerate().filter(|&(old, _)| is_used[old]) {
            let found = self.materials.iter().position(|other| *other == material);
            number_of[old] = found.unwrap_or(self.materials.len());
            if found.is_none() {
                self.materials.push(material);
                kept.push(old);
            }
        }
        // The materials of bodies without a stated one, by the mesh they are copies of.
        let mut of_copies = HashMap::new();
        for (number, body) in self.bodies.iter_mut().enumerate() {
            body.paint.iter_mut().for_each(|paint| *paint = number_of[usize::from(*paint)] as u8);
            body.material = match body.material {
                _ if !body.paint.is_empty() => None,
                Some(old) => Some(number_of[old]),
                // It is subtracted, so what it is made of does not matter.
                None if body.role == Role::Negative => None,
                None => {
                    let next = self.materials.len();
                    let copied = body.copy_of.map(|mesh| *of_copies.entry(mesh).or_insert(next));
                    let material = copied.unwrap_or(next);
                    if material == next {
                        self.materials.push(own_material(number, body));
                    }
                    Some(material)
                }
            };
        }
        if let Some(purge) = self.purge_mm3.take() {
            let count = self.materials.len();
            if kept.len() == count {
                let volume = |(from, to)| purge[[kept[from], kept[to]]];
                self.purge_mm3 = Some(Array2::from_shape_fn((count, count), volume));
            } else if count > 1 {
                let what = "purge volumes, because the file does not state all materials".into();
                self.warnings.push(ReadWarning::Ignored { what });
            }
        }
    }
}

/// A material named after a body.
fn own_material(number: usize, body: &Body) -> Material {
    let name =
        if body.name.is_empty() { format!("body {}", number + 1) } else { body.name.clone() };
    Material { name, colour: None }
}

#[cfg(test)]
mod tests {
    use ndarray::array;

    use super::*;
    use crate::solid::Solid;

    fn body(material: Option<usize>, copy_of: Option<usize>) -> Body {
        let mesh = Solid::Cuboid { size_mm: [1.0; 3] }.mesh();
        Body { mesh, material, copy_of, ..Body::default() }
    }

    fn material(name: &str) -> Material {
        Material { name: name.into(), colour: None }
    }
    // Clonephaze#24: objects given a tool each in turn
    #[test]
    fn copies_of_a_mesh_share_a_material() {
        let copies = [Some(0), Some(1), Some(0), None, Some(1), None];
        let bodies = copies.map(|copy| body(None, copy)).to_vec();
        let mut model = Model { bodies, ..Model::default() };
        model.assign_materials(MaterialRule::Stated);
        let numbers: Vec<_> = model.bodies.iter().map(|body| body.material.unwrap()).collect();
        assert_eq!(numbers, [0, 1, 0, 2, 1, 3]);
    }

    #[test]
    fn copies_of_two_files_are_not_the_same() {
        let file = || Model { bodies: vec![body(None, Some(0)); 2], ..Model::default() };
        let mut model = file();
        model.append(file()).unwrap();
        model.assign_materials(MaterialRule::Stated);
        assert_eq!(model.materials.len(), 2);
        assert_eq!(model.bodies.iter().map(|body| body.object).collect::<Vec<_>>(), [0, 0, 1, 1]);
    }

    #[test]
    fn purge_volumes_follow_their_materials() {
        let purge_mm3 = Some(array![[0.0, 1.0, 2.0], [10.0, 0.0, 12.0], [20.0, 21.0, 0.0]]);
        let materials = ["red", "green", "blue"].map(material).to_vec();
        let bodies = vec![body(Some(2), None), body(Some(0), None)];
        let mut model = Model { bodies, materials, purge_mm3, ..Model::default() };
        let mut unstated = model.clone();
        model.assign_materials(MaterialRule::Stated);
        assert_eq!(model.purge_mm3, Some(array![[0.0, 2.0], [20.0, 0.0]]));
        assert!(model.warnings.is_empty());

        unstated.bodies.push(body(None, None));
        unstated.assign_materials(MaterialRule::Stated);
        assert_eq!((unstated.purge_mm3, unstated.warnings.len()), (None, 1));
    }
}
