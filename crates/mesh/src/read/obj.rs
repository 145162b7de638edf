//! Wavefront OBJ files: polygons with objects, groups and materials.

use std::collections::{BTreeSet, HashMap};

use beadwork_base::Control;

use super::error::{ReadError, ReadLimits};
use super::polygon::Triangulator;
use super::text::{decoded, lines, point, shown, to_utf8};
use super::vertex_colours::VertexColours;
use crate::mesh::Mesh;
use crate::model::{Body, Material, Model};
use crate::warning::ReadWarning;
use crate::work::Work;

/// A warning shows this many unknown keywords.
const SHOWN_UNKNOWN: usize = 5;

/// Reads a file.
///
/// - An object (`o`) begins a body, unless the current body has no faces yet.
/// - A group (`g`) does not begin a body, because groups are often parts of one surface; it only
///   names a body that has no other name.
/// - Polygons are divided into triangles, concave ones too; `fo` is an old name of `f`.
/// - `usemtl` names a material; a body with several is painted.
///   Colours are in another file (`mtllib`), which is not read.
/// - Vertices may have a colour after their coordinates.
///   In a file without `usemtl`, each colour is a material.
///   A triangle whose corners differ has the colour of two of them, or else of the first.
/// - Texture coordinates and normals are ignored; so are, with a warning, points, lines, curves and
///   surfaces of higher order, and lines that begin with an unknown word.
pub(super) fn read(
    bytes: &[u8],
    limits: &ReadLimits,
    control: &Control<'_>,
) -> Result<Model, ReadError> {
    let bytes = &*decoded(bytes);
    if bytes.iter().take(1024).any(|&byte| byte == 0) {
        return Err(ReadError::WrongFormat { format: "OBJ", reason: "is not text" });
    }
    let mut work = Work::new(control, 1, bytes.len());
    let mut reader = Reader { limits: *limits, ..Reader::default() };
    // A backslash at the end of a line joins it with the next one.
    // Comments are removed first, because a comment may end in a path with a backslash.
    let mut joined = String::new();
    let mut last = 0;
    for (line, (position, text)) in (1..).zip(lines(bytes)) {
        work.tick(position)?;
        last = line;
        let text = to_utf8(text);
        // Old programs end a text with a control character.
        let text = without_comment(&text).trim_end_matches(|end: char| end <= ' ');
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
    reader.finish()
}

/// A line up to its comment.
/// A `#` inside a word is part of a name.
fn without_comment(text: &str) -> &str {
    let begins_comment = |&(index, _): &(usize, &str)| {
        index == 0 || text[..index].ends_with(|before: char| before.is_ascii_whitespace())
    };
    text.match_indices('#').find(begins_comment).map_or(text, |(index, _)| &text[..index])
}

/// The faces of a body.
/// Its triangles refer to the vertices of the whole file.
#[derive(Default)]
struct Faces {
    name: String,
    triangles: Vec<[u32; 3]>,
    /// For each triangle its material, if any.
    materials: Vec<Option<u8>>,
}

#[derive(Default)]
struct Reader {
    limits: ReadLimits,
    vertices: Vec<[f64; 3]>,
    /// Bodies that are complete.
    complete: Vec<Faces>,
    /// The body that is being read.
    current: Faces,
    triangles: usize,
    materials: Vec<Material>,
    /// The current material.
    material: Option<u8>,
    colours: VertexColours,
    triangulator: Triangulator,
    /// What has no effect, as a noun phrase.
    ignored: BTreeSet<&'static str>,
    /// The first unknown keywords.
    unknown: BTreeSet<String>,
}

impl Reader {
    fn line(&mut self, line: usize, text: &str) -> Result<(), ReadError> {
        let mut words = text.split_ascii_whitespace();
        match words.next() {
            Some("v") => {
                self.vertices.push(point(line, &mut words)?);
                self.ignored.extend(self.colours.add(line, words)?);
            }
            Some("f" | "fo") => self.face(line, words)?,
            Some("o") => {
                if !self.current.triangles.is_empty() {
                    self.complete.push(std::mem::take(&mut self.current));
                }
                self.current.name = words.collect::<Vec<_>>().join(" ");
            }
            Some("g") if self.current.name.is_empty() => {
                self.current.name = words.collect::<Vec<_>>().join(" ");
            }
            Some("usemtl") => {
                self.material = Some(self.material(line, &words.collect::<Vec<_>>().join(" "))?);
            }
            Some("mtllib") => {
                self.ignored.insert("colours of materials (mtllib)");
            }
            Some("p" | "l") => {
                self.ignored.insert("points and lines");
            }
            Some(
                "curv" | "curv2" | "surf" | "vp" | "cstype" | "deg" | "bmat" | "step" | "parm"
                | "trim" | "hole" | "scrv" | "sp" | "con" | "end" | "bzp" | "bsp" | "res" | "cdc"
                | "cdp",
            ) => {
                self.ignored.insert("curves and surfaces of higher order");
            }
            Some("call" | "csh") => {
                self.ignored.insert("other files and commands");
            }
            // They affect only how a picture of the model looks.
            Some(
                "vt" | "vn" | "g" | "s" | "mg" | "bevel" | "c_interp" | "d_interp" | "lod"
                | "ctech" | "stech" | "maplib" | "usemap" | "shadow_obj" | "trace_obj",
            )
            | None => {}
            // All keywords of OBJ are alphanumeric: this is a text file of another format.
            Some(word)
                if !word.bytes().all(|byte| byte.is_ascii_alphanumeric() || byte == b'_') =>
            {
                return Err(ReadError::line(line, format!("unknown keyword '{}'", shown(word))));
            }
            Some(word) => {
                if self.unknown.len() < SHOWN_UNKNOWN {
                    self.unknown.insert(shown(word));
                }
            }
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
            let message = format!("face has {} vertices, needs at least 3", corners.len());
            return Err(ReadError::line(line, message));
        }
        self.triangles += corners.len() - 2;
        if self.triangles > self.limits.triangles {
            return Err(ReadError::too_large(self.limits.triangles, "triangles"));
        }
        let points: Vec<_> = corners.iter().map(|&corner| self.vertices[corner as usize]).collect();
        for triangle in self.triangulator.divide(&points) {
            self.current.triangles.push(triangle.map(|at| corners[at]));
            self.current.materials.push(self.material);
        }
        Ok(())
    }

    /// The vertex of a corner such as `7`, `7/1`, `7//2` or `-1`: counted from 1, or backwards from
    /// the last vertex so far.
    fn vertex(&self, line: usize, word: &str) -> Result<u32, ReadError> {
        let count = self.vertices.len() as i64;
        let wrong = || {
            let word = shown(word);
            ReadError::line(
                line,
                format!("vertex '{word}' does not exist, file has {count} so far"),
            )
        };
        let number: i64 =
            word.split('/').next().and_then(|number| number.parse().ok()).ok_or_else(wrong)?;
        let vertex = if number < 0 { count.saturating_add(number) } else { number - 1 };
        if (0..count).contains(&vertex) { Ok(vertex as u32) } else { Err(wrong()) }
    }

    /// The number of a material, which is added if it is new.
    fn material(&mut self, line: usize, name: &str) -> Result<u8, ReadError> {
        let found = self.materials.iter().position(|material| material.name == name);
        let number = found.unwrap_or(self.materials.len());
        if found.is_none() {
            self.materials.push(Material { name: name.to_owned(), colour: None });
        }
        let message = "file has more than 256 materials";
        u8::try_from(number).map_err(|_| ReadError::line(line, message))
    }

    fn finish(mut self) -> Result<Model, ReadError> {
        self.complete.push(std::mem::take(&mut self.current));
        let mut warnings: Vec<ReadWarning> =
            self.ignored.iter().map(|&what| ReadWarning::Ignored { what: what.into() }).collect();
        if !self.unknown.is_empty() {
            let words: Vec<_> = self.unknown.iter().map(|word| format!("'{word}'")).collect();
            let what = format!("lines that begin with unknown words ({})", words.join(", "));
            warnings.push(ReadWarning::Ignored { what });
        }
        if self.colours.is_any() {
            if self.materials.is_empty() {
                self.use_vertex_colours(&mut warnings)?;
            } else {
                let what = "colours of vertices (the file has materials)".into();
                warnings.push(ReadWarning::Ignored { what });
            }
        }
        let mut model = Model { materials: self.materials, warnings, ..Model::default() };
        for faces in self.complete.into_iter().filter(|faces| !faces.triangles.is_empty()) {
            let first = faces.materials[0];
            let is_one = faces.materials.iter().all(|&material| material == first);
            // Faces before the first `usemtl` get the first material that follows.
            let fallback = faces.materials.iter().flatten().next().copied().unwrap_or_default();
            let paint =
                faces.materials.iter().map(|material| material.unwrap_or(fallback)).collect();
            if !is_one && faces.materials.contains(&None) {
                let warning = ReadWarning::Approximated {
                    what: "faces before the first material".into(),
                    how: "they have the material that follows".into(),
                };
                if !model.warnings.contains(&warning) {
                    model.warnings.push(warning);
                }
            }
            model.bodies.push(Body {
                object: model.bodies.len(),
                mesh: Mesh::of_used_vertices(&self.vertices, faces.triangles),
                name: faces.name,
                material: if is_one { first.map(usize::from) } else { None },
                paint: if is_one { Vec::new() } else { paint },
                ..Body::default()
            });
        }
        Ok(model)
    }

    /// Gives triangles the colours of their vertices as materials.
    fn use_vertex_colours(&mut self, warnings: &mut Vec<ReadWarning>) -> Result<(), ReadError> {
        let mut numbers = HashMap::new();
        let mut mixed = 0;
        for faces in &mut self.complete {
            for (triangle, material) in faces.triangles.iter().zip(&mut faces.materials) {
                let corners = triangle.map(|vertex| self.colours.of(vertex));
                let [a, b, c] = corners;
                mixed += usize::from(a != b || b != c);
                let Some(colour) = (if b == c { b } else { a }) else { continue };
                let next = numbers.len();
                let number = *numbers.entry(colour).or_insert(next);
                if number == next {
                    if next == Model::MAX_MATERIALS {
                        return Err(ReadError::too_large(next, "colours of vertices"));
                    }
                    self.materials.push(Material::of_colour(colour));
                }
                *material = Some(number as u8);
            }
        }
        if mixed > 0 {
            warnings.push(ReadWarning::MixedColours { triangles: mixed });
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Format;

    const TWO: &str = "# two bodies\nmtllib none.mtl\no first\n\
        v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0 # a corner\nv 0 0 1\nvt 0 0\n\
        usemtl red\nf 1/1 2/1 3/1 \\\n  4/1\nf 1 2 5\n\
        o second\nf -5//1 -4//1 -1//1\nusemtl blue\nf 1 3 5\n";

    fn refused(text: &str) -> String {
        Model::read(Format::Obj, text.as_bytes(), &ReadLimits::default(), &Control::default())
            .unwrap_err()
            .to_string()
    }

    #[test]
    fn bodies_polygons_and_materials_are_read() {
        let model = read(TWO.as_bytes(), &ReadLimits::default(), &Control::default()).unwrap();
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
    fn backslashes_join_lines_except_in_comments() {
        let text = "# C:\\parts\\\nv 0 0 0 # \\\nv 1 0 0\nv 0 1 0\nf 1 2 \\\n3";
        assert_eq!(
            read(text.as_bytes(), &ReadLimits::default(), &Control::default())
                .unwrap()
                .triangle_count(),
            1
        );
        // The last line too, though nothing follows it.
        let text = text.to_owned() + " \\";
        assert_eq!(
            read(text.as_bytes(), &ReadLimits::default(), &Control::default())
                .unwrap()
                .triangle_count(),
            1
        );
    }

    #[test]
    fn groups_are_not_bodies_and_names_may_contain_a_hash() {
        let text = "g front\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl paint#1\nf 1 2 3\n\
            g back\nusemtl paint#2 # the other\nf 1 3 2\n";
        let model = read(text.as_bytes(), &ReadLimits::default(), &Control::default()).unwrap();
        assert_eq!((model.bodies.len(), model.bodies[0].name.as_str()), (1, "front"));
        assert_eq!(model.bodies[0].paint, [0, 1]);
        let names: Vec<_> = model.materials.iter().map(|material| material.name.as_str()).collect();
        assert_eq!(names, ["paint#1", "paint#2"]);
    }

    // bambulab/BambuStudio#1892, #4422
    #[test]
    fn vertex_colours_are_materials() {
        // A tetrahedron, with colours as shares or as bytes, and one without.
        let text = |red: &str, blue: &str| {
            format!(
                "v 0 0 0 {red}\nv 1 0 0 {red}\nv 0 1 0 {red}\nv 0 0 1 {blue}\n\
                 f 1 3 2\nf 1 2 4\nf 4 4 4\nf 2 3 4\n"
            )
        };
        for (red, blue) in [("1 0 0", "0 0 1"), ("255 0 0", "0 0 255"), ("1.0 1 0 0", "1 0 0 1")] {
            let model =
                read(text(red, blue).as_bytes(), &ReadLimits::default(), &Control::default());
            let model = model.unwrap();
            assert_eq!(model.bodies[0].paint, [0, 0, 1, 0], "{red}");
            let colours: Vec<_> = model.materials.iter().map(|of| of.colour.unwrap()).collect();
            assert_eq!(colours, [[255, 0, 0], [0, 0, 255]]);
            assert_eq!(model.warnings, [ReadWarning::MixedColours { triangles: 2 }]);
        }
        let one =
            read(text("1 0 0", "1 0 0").as_bytes(), &ReadLimits::default(), &Control::default());
        let one = one.unwrap();
        assert_eq!((one.bodies[0].material, one.bodies[0].paint.len()), (Some(0), 0));
        assert_eq!(refused("v 0 0 0 1 0 x\n"), "line 1: 'x' is not a number");
    }

    #[test]
    fn odd_lines_are_read_or_reported() {
        let text = "\u{feff}# begins with a mark\r\ns off\rv 0 0 0\nv 1 0 0\nv 0 1 0\nvp 0 1\n\
            p 1\nl 1 2\nf 1 2 3\n\u{1a}";
        let model = read(text.as_bytes(), &ReadLimits::default(), &Control::default()).unwrap();
        assert_eq!(model.triangle_count(), 1);
        let warnings: Vec<_> = model.warnings.iter().map(ToString::to_string).collect();
        assert_eq!(
            warnings,
            ["curves and surfaces of higher order: not used", "points and lines: not used"]
        );
    }

    // Keywords that would be faces, and numbers after the coordinates, must not vanish silently.
    #[test]
    fn unknown_words_and_numbers_are_reported() {
        let read = |text: &str| {
            read(text.as_bytes(), &ReadLimits::default(), &Control::default()).unwrap()
        };
        let warnings =
            |model: &Model| model.warnings.iter().map(ToString::to_string).collect::<Vec<_>>();
        let start = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvn 0 0 1\ns 1\nlod 2\n";
        let model = read(&format!("{start}f 1 2 3\nfo 1 2 4\nF 1 3 4\nlump 3\nF 1 3 4\n"));
        assert_eq!(model.triangle_count(), 2);
        let expected = "lines that begin with unknown words ('F', 'lump'): not used";
        assert_eq!(warnings(&model), [expected]);
        let model = read(&format!("{start}f 1 2 3\ncstype bezier\ndeg 3\n"));
        assert_eq!(warnings(&model), ["curves and surfaces of higher order: not used"]);
        let model = read("v 0 0 0 1\nv 1 0 0 1.0\nv 0 1 0\nf 1 2 3\n");
        assert!(model.warnings.is_empty());
        let model = read("v 0 0 0 2\nv 1 0 0 1 2\nv 0 1 0 1 1 0 0 9\nf 1 2 3\n");
        assert!(warnings(&model).contains(&"weights of vertices: not used".to_owned()));
        let more = "more numbers of vertices than coordinates and a colour: not used";
        assert!(warnings(&model).contains(&more.to_owned()));
    }

    // Two materials whose names are not UTF-8 would become one.
    #[test]
    fn names_in_latin_1_stay_different() {
        let text = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl \xe4\nf 1 2 3\nusemtl \xf6\nf 1 3 2\n";
        let model = read(text, &ReadLimits::default(), &Control::default()).unwrap();
        let names: Vec<_> = model.materials.iter().map(|material| material.name.as_str()).collect();
        assert_eq!(names, ["ä", "ö"]);
    }

    #[test]
    fn errors_state_their_line() {
        assert_eq!(refused("v 0 0\n"), "line 1: vertex has 2 coordinates, expected 3");
        assert_eq!(refused("v 0 0 x\n"), "line 1: 'x' is not a number");
        assert_eq!(
            refused("v 0 0 0\nf 1 2 3\n"),
            "line 2: vertex '2' does not exist, file has 1 so far"
        );
        assert_eq!(
            refused("v 0 0 0\nf 1 1 0\n"),
            "line 2: vertex '0' does not exist, file has 1 so far"
        );
        assert_eq!(refused("v 0 0 0\nf 1 1\n"), "line 2: face has 2 vertices, needs at least 3");
        assert_eq!(refused("v 0 0 nan\n"), "line 1: 'nan' is not a finite number");
        assert_eq!(refused("v 0 0 0\n"), "file contains no triangles");
        assert_eq!(refused("<xml>\n"), "not a valid OBJ file: content is XML or HTML");
        assert_eq!(refused("[0]\n"), "line 1: unknown keyword '[0]'");
    }
}
