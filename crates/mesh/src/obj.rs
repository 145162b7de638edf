//! Wavefront OBJ files: polygons, their objects, groups and materials.

use std::collections::HashMap;

use super::model::{Body, Material, Model, ReadError, ReadLimits};
use super::stl::point;
use super::surface::Mesh;

/// Reads a file.
///
/// An `o` begins a body, unless it comes before the first face of the last one; groups (`g`) are
/// stretches of one surface as often as bodies, so they only name what has no other name.
/// Polygons are cut into fans.
/// Each `usemtl` names a material; a body of several is painted.
/// Colours stand in another file (`mtllib`) and are not read; curves and surfaces of higher order
/// are passed over, as are texture coordinates and normals.
pub(super) fn read(bytes: &[u8], limits: &ReadLimits) -> Result<Model, ReadError> {
    let mut reader = Reader { limits: *limits, ..Reader::default() };
    // A backslash at the end of a line joins it to the next; not one in a comment, which may end in
    // the name of a folder.
    let mut joined = String::new();
    let mut last = 0;
    for (line, text) in (1..).zip(bytes.split(|&byte| byte == b'\n')) {
        last = line;
        let text = String::from_utf8_lossy(text);
        let text = without_comment(&text).trim_end();
        if let Some(begun) = text.strip_suffix('\\') {
            joined.push_str(begun);
            joined.push(' ');
        } else if joined.is_empty() {
            reader.line(line, text)?;
        } else {
            joined.push_str(text);
            reader.line(line, &joined)?;
            joined.clear();
        }
    }
    reader.line(last, &joined)?;
    Ok(reader.finish())
}

/// A line up to its comment.
/// A `#` within a word is part of a name.
fn without_comment(text: &str) -> &str {
    let begins = |&(at, _): &(usize, &str)| {
        at == 0 || text[..at].ends_with(|before: char| before.is_ascii_whitespace())
    };
    text.match_indices('#').find(begins).map_or(text, |(at, _)| &text[..at])
}

/// A body of which the faces are being read; its triangles name the vertices of the whole file.
#[derive(Default)]
struct Faces {
    name: String,
    triangles: Vec<[u32; 3]>,
    /// For each triangle the number of its material in the file, if it has one.
    materials: Vec<Option<u8>>,
}

#[derive(Default)]
struct Reader {
    limits: ReadLimits,
    vertices: Vec<[f64; 3]>,
    done: Vec<Faces>,
    faces: Faces,
    count: usize,
    materials: Vec<Material>,
    material: Option<u8>,
}

impl Reader {
    fn line(&mut self, line: usize, text: &str) -> Result<(), ReadError> {
        let mut words = text.split_ascii_whitespace();
        match words.next() {
            Some("v") => self.vertices.push(point(line, words)?),
            Some("f") => self.face(line, words)?,
            Some("o") => {
                if !self.faces.triangles.is_empty() {
                    self.done.push(std::mem::take(&mut self.faces));
                }
                self.faces.name = words.collect::<Vec<_>>().join(" ");
            }
            Some("g") if self.faces.name.is_empty() => {
                self.faces.name = words.collect::<Vec<_>>().join(" ")
            }
            Some("usemtl") => {
                self.material = Some(self.material(line, &words.collect::<Vec<_>>().join(" "))?);
            }
            // What a text file of another kind would begin with is no number of any OBJ keyword.
            Some(word)
                if !word.bytes().all(|byte| byte.is_ascii_alphanumeric() || byte == b'_') =>
            {
                let word: String = word.chars().take(20).collect();
                return Err(ReadError::text(line, format!("unknown word {word:?}")));
            }
            _ => {}
        }
        Ok(())
    }

    fn face<'a>(
        &mut self,
        line: usize,
        words: impl Iterator<Item = &'a str>,
    ) -> Result<(), ReadError> {
        let corners = words.map(|word| self.vertex(line, word)).collect::<Result<Vec<_>, _>>()?;
        if corners.len() < 3 {
            return Err(ReadError::text(line, format!("a face of {} vertices", corners.len())));
        }
        self.count += corners.len() - 2;
        if self.count > self.limits.triangles {
            return Err(ReadError::TooLarge {
                most: self.limits.triangles as u64,
                what: "triangles",
            });
        }
        for pair in corners[1..].windows(2) {
            self.faces.triangles.push([corners[0], pair[0], pair[1]]);
            self.faces.materials.push(self.material);
        }
        Ok(())
    }

    /// The vertex that a corner such as `7`, `7/1`, `7//2` or `-1` names: from 1, or back from the
    /// last.
    fn vertex(&self, line: usize, word: &str) -> Result<u32, ReadError> {
        let wrong = || {
            let word: String = word.chars().take(20).collect();
            ReadError::text(
                line,
                format!("{word:?} names no vertex, of {} so far", self.vertices.len()),
            )
        };
        let number: i64 =
            word.split('/').next().and_then(|number| number.parse().ok()).ok_or_else(wrong)?;
        let count = self.vertices.len() as i64;
        let vertex = if number < 0 { count.saturating_add(number) } else { number - 1 };
        if (0..count).contains(&vertex) { Ok(vertex as u32) } else { Err(wrong()) }
    }

    fn material(&mut self, line: usize, name: &str) -> Result<u8, ReadError> {
        let found = self.materials.iter().position(|material| material.name == name);
        let number = found.unwrap_or(self.materials.len());
        if found.is_none() {
            self.materials.push(Material { name: name.to_owned(), colour: None });
        }
        u8::try_from(number).map_err(|_| ReadError::text(line, "more than 256 materials"))
    }

    fn finish(mut self) -> Model {
        self.done.push(self.faces);
        let mut model = Model { bodies: Vec::new(), materials: self.materials };
        for faces in self.done.into_iter().filter(|faces| !faces.triangles.is_empty()) {
            let first = faces.materials[0];
            let is_one = faces.materials.iter().all(|&material| material == first);
            // Faces before the first `usemtl` are of the first material used after it.
            let fallback = faces.materials.iter().flatten().next().copied().unwrap_or_default();
            let paint =
                faces.materials.iter().map(|material| material.unwrap_or(fallback)).collect();
            model.bodies.push(Body {
                mesh: used_only(&self.vertices, faces.triangles),
                name: faces.name,
                material: if is_one { first.map(usize::from) } else { None },
                paint: if is_one { Vec::new() } else { paint },
            });
        }
        model
    }
}

/// A mesh with those of the vertices that its triangles use, in the order of their first use.
fn used_only(vertices: &[[f64; 3]], mut triangles: Vec<[u32; 3]>) -> Mesh {
    let mut number_of = HashMap::new();
    let mut used = Vec::new();
    for vertex in triangles.iter_mut().flatten() {
        *vertex = *number_of.entry(*vertex).or_insert_with_key(|&old| {
            used.push(vertices[old as usize]);
            used.len() as u32 - 1
        });
    }
    Mesh::new(used, triangles).expect("coordinates and numbers were checked when they were read")
}

#[cfg(test)]
mod tests {
    use beadwork_base::Control;

    use super::*;
    use crate::Format;

    const TWO: &str = "# two bodies\nmtllib none.mtl\no first\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0 # a corner\nv 0 0 1\nvt 0 0\n\
        usemtl red\nf 1/1 2/1 3/1 \\\n  4/1\nf 1 2 5\no second\nf -5//1 -4//1 -1//1\nusemtl blue\nf 1 3 5\n";

    fn refused(text: &str) -> String {
        Model::read(Format::Obj, text.as_bytes(), &ReadLimits::default(), &Control::default())
            .unwrap_err()
            .to_string()
    }

    #[test]
    fn bodies_polygons_and_materials_are_read() {
        let model = read(TWO.as_bytes(), &ReadLimits::default()).unwrap();
        let [first, second] = &model.bodies[..] else { panic!("two bodies") };
        assert_eq!((first.name.as_str(), first.material), ("first", Some(0)));
        assert_eq!(first.mesh.triangles(), [[0, 1, 2], [0, 2, 3], [0, 1, 4]]);
        assert_eq!((second.name.as_str(), second.material), ("second", None));
        assert_eq!(second.paint, [0, 1]);
        assert_eq!(second.mesh.triangles(), [[0, 1, 2], [0, 3, 2]]);
        let names: Vec<_> = model.materials.iter().map(|material| material.name.as_str()).collect();
        assert_eq!(names, ["red", "blue"]);
    }

    #[test]
    fn lines_are_joined_but_not_over_comments() {
        let text = "# C:\\parts\\\nv 0 0 0 # \\\nv 1 0 0\nv 0 1 0\nf 1 2 \\\n3";
        assert_eq!(read(text.as_bytes(), &ReadLimits::default()).unwrap().triangle_count(), 1);
        // The last line too, though nothing follows it.
        let text = text.to_owned() + " \\";
        assert_eq!(read(text.as_bytes(), &ReadLimits::default()).unwrap().triangle_count(), 1);
    }

    #[test]
    fn groups_are_no_bodies_and_names_may_hold_a_hash() {
        let text = "g front\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl paint#1\nf 1 2 3\ng back\nusemtl paint#2 # the other\nf 1 3 2\n";
        let model = read(text.as_bytes(), &ReadLimits::default()).unwrap();
        assert_eq!((model.bodies.len(), model.bodies[0].name.as_str()), (1, "front"));
        assert_eq!(model.bodies[0].paint, [0, 1]);
        let names: Vec<_> = model.materials.iter().map(|material| material.name.as_str()).collect();
        assert_eq!(names, ["paint#1", "paint#2"]);
    }

    #[test]
    fn what_is_wrong_is_named_with_its_line() {
        assert_eq!(refused("v 0 0\n"), "line 1: a vertex of less than 3 coordinates");
        assert_eq!(refused("v 0 0 x\n"), "line 1: \"x\" is no number");
        assert_eq!(refused("v 0 0 0\nf 1 2 3\n"), "line 2: \"2\" names no vertex, of 1 so far");
        assert_eq!(refused("v 0 0 0\nf 1 1 0\n"), "line 2: \"0\" names no vertex, of 1 so far");
        assert_eq!(refused("v 0 0 0\nf 1 1\n"), "line 2: a face of 2 vertices");
        assert_eq!(refused("v 0 0 nan\n"), "line 1: the coordinate NaN");
        assert_eq!(refused("v 0 0 0\n"), "it holds no triangles");
        assert_eq!(refused("<xml>\n"), "line 1: unknown word \"<xml>\"");
    }
}
