//! Assigns a material to every body.

use crate::model::{Body, Material, Model};

/// Which bodies share a material.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MaterialRule {
    /// As the files state; each body for which they state nothing gets a material of its own.
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
    /// Afterwards every body has a material, or paint.
    /// Materials with the same name and colour are merged.
    /// Materials of the file keep their order; the new ones follow.
    /// Linear in the painted triangles.
    ///
    /// # Panics
    /// If a body or its paint refers to a material that does not exist.
    pub fn assign_materials(&mut self, rule: MaterialRule) {
        match rule {
            MaterialRule::Stated => self.assign_stated(),
            MaterialRule::PerBody => {
                self.materials.clear();
                for (number, body) in self.bodies.iter_mut().enumerate() {
                    self.materials.push(own_material(number, body));
                    (body.material, body.paint) = (Some(number), Vec::new());
                }
            }
            MaterialRule::Single => {
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
        // For each stated material its new number.
        let mut number_of = vec![0; stated.len()];
        for (old, material) in stated.into_iter().enumerate().filter(|&(old, _)| is_used[old]) {
            let found = self.materials.iter().position(|other| *other == material);
            number_of[old] = found.unwrap_or(self.materials.len());
            if found.is_none() {
                self.materials.push(material);
            }
        }
        for (number, body) in self.bodies.iter_mut().enumerate() {
            body.paint.iter_mut().for_each(|paint| *paint = number_of[usize::from(*paint)] as u8);
            body.material = match body.material {
                _ if !body.paint.is_empty() => None,
                Some(old) => Some(number_of[old]),
                None => {
                    self.materials.push(own_material(number, body));
                    Some(self.materials.len() - 1)
                }
            };
        }
    }
}

/// A material named after a body.
fn own_material(number: usize, body: &Body) -> Material {
    let name =
        if body.name.is_empty() { format!("body {}", number + 1) } else { body.name.clone() };
    Material { name, colour: None }
}
