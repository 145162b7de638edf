//! Assigns a material to every body.

use std::collections::HashMap;

use ndarray::Array2;

use crate::model::{Body, Material, Model, Role};
use crate::repair::shells;
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
    /// A painted body that consists of closed shells is split into them; a shell of one colour is
    /// not painted.
    /// Of two shells that overlap, the one with the smaller volume counts.
    ///
    /// Afterwards every body has a material, or paint, except negative bodies without one.
    /// Materials with the same name and colour are merged.
    /// Materials of the file keep their order; the new ones follow.
    /// Purge volumes that the file states follow its materials; they are dropped, with a warning,
    /// if there are materials that the file does not state.
    /// O(n log n) in the painted triangles.
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
        let bodies = std::mem::take(&mut self.bodies);
        self.bodies = bodies.into_iter().flat_map(shells::split).collect();
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
    use beadwork_base::Control;
    use ndarray::array;

    use super::*;
    use crate::RepairSettings;
    use crate::mesh::Mesh;
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

    /// A box from corner to corner, with its inside out if `is_cavity`.
    fn cuboid(min: [f64; 3], max: [f64; 3], is_cavity: bool) -> Mesh {
        let mut mesh =
            Solid::Cuboid { size_mm: [0, 1, 2].map(|axis| max[axis] - min[axis]) }.mesh();
        mesh.map_vertices(|point| [0, 1, 2].map(|axis| point[axis] + min[axis]), is_cavity);
        mesh
    }

    /// One body of several meshes with a colour each.
    fn painted(meshes: &[(Mesh, u8)]) -> Model {
        let (mut vertices, mut triangles, mut paint) = (Vec::new(), Vec::new(), Vec::new());
        for (mesh, colour) in meshes {
            let base = vertices.len() as u32;
            vertices.extend(mesh.vertices());
            triangles.extend(mesh.triangles().iter().map(|corners| corners.map(|at| at + base)));
            paint.resize(triangles.len(), *colour);
        }
        let mesh = Mesh::new(vertices, triangles).unwrap();
        let mut body = Body { mesh, paint, ..Body::default() };
        body.repair(&RepairSettings::default(), &Control::default()).unwrap();
        let materials = ["red", "blue", "green"].map(material).to_vec();
        Model { bodies: vec![body], materials, ..Model::default() }
    }

    /// Volumes and materials of the bodies after materials are assigned.
    fn assigned(mut model: Model) -> Vec<(i64, Option<usize>)> {
        model.assign_materials(MaterialRule::Stated);
        let body = |body: &Body| (body.mesh.volume_mm3().round() as i64, body.material);
        model.bodies.iter().map(body).collect()
    }

    // CNCKitchen/stlTexturizer#110
    #[test]
    fn shells_that_touch_or_overlap_have_their_own_material() {
        let red = cuboid([0.0; 3], [10.0, 10.0, 4.0], false);
        let beside = cuboid([10.0, 0.0, 0.0], [14.0, 10.0, 4.0], false);
        let inside = cuboid([3.0; 3], [5.0, 5.0, 4.0], false);
        let touching = [(red.clone(), 0), (beside, 1)];
        assert_eq!(assigned(painted(&touching)), [(400, Some(0)), (160, Some(1))]);
        // The order in the file does not matter.
        let overlapping = [(inside.clone(), 1), (red.clone(), 0)];
        assert_eq!(assigned(painted(&overlapping)), [(400, Some(0)), (4, Some(1))]);
        // A cavity that is filled by another shell, with or without contact.
        let cavity = cuboid([3.0, 3.0, 1.0], [5.0, 5.0, 3.0], true);
        let filling = cuboid([3.0, 3.0, 1.0], [5.0, 5.0, 3.0], false);
        let small = cuboid([3.5, 3.5, 1.5], [4.5, 4.5, 2.5], false);
        let filled = [(red.clone(), 0), (cavity.clone(), 0), (filling, 1)];
        assert_eq!(assigned(painted(&filled)), [(392, Some(0)), (8, Some(1))]);
        let loose = [(small, 1), (cavity, 0), (red, 0)];
        assert_eq!(assigned(painted(&loose)), [(392, Some(0)), (1, Some(1))]);
    }

    #[test]
    fn shells_of_several_colours_stay_painted() {
        let mut model = painted(&[
            (cuboid([0.0; 3], [10.0; 3], false), 0),
            (cuboid([4.0; 3], [6.0; 3], true), 1),
            (cuboid([20.0, 0.0, 0.0], [24.0, 4.0, 4.0], false), 2),
        ]);
        model.assign_materials(MaterialRule::Stated);
        let [hollow, apart] = &model.bodies[..] else { panic!("two bodies") };
        assert!((hollow.mesh.volume_mm3() - 992.0).abs() < 1e-9);
        assert_eq!((hollow.material, hollow.paint.len()), (None, 24));
        assert_eq!((apart.material, apart.paint.len()), (Some(2), 0));
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
