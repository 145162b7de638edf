//! STL files, binary and text.

use super::model::{Body, Model, ReadError, ReadLimits};
use super::surface::Welder;

/// Length of a binary file's header, which says nothing, and of the count of triangles behind it.
const HEADER: usize = 84;
/// Normal, three corners and two bytes of attributes.
const RECORD: usize = 50;

/// Reads a file.
/// Each `solid` of a text file is a body.
///
/// A file is binary if its length fits the count of triangles in its header, whatever that header
/// begins with: many programs write "solid" there.
pub(super) fn read(bytes: &[u8], limits: &ReadLimits) -> Result<Model, ReadError> {
    let promised = match bytes.get(HEADER - 4..HEADER) {
        Some(count) => u64::from(u32::from_le_bytes(count.try_into().expect("it has four bytes"))),
        None => 0,
    };
    let room = (bytes.len().saturating_sub(HEADER) / RECORD) as u64;
    let fits =
        bytes.len() >= HEADER && bytes.len() as u64 == HEADER as u64 + RECORD as u64 * promised;
    if !fits && begins_as_text(bytes) {
        return read_text(bytes, limits);
    }
    if bytes.len() < HEADER {
        return Err(ReadError::Kind("neither a binary nor a text STL file"));
    }
    if promised > room {
        return Err(ReadError::Short { promised, room });
    }
    read_binary(&bytes[HEADER..], promised as usize, limits)
}

fn begins_as_text(bytes: &[u8]) -> bool {
    let word = bytes.trim_ascii_start().get(..5);
    // A binary file cut short has zeros soon.
    word.is_some_and(|word| word.eq_ignore_ascii_case(b"solid"))
        && !bytes.iter().take(1024).any(|&byte| byte == 0)
}

fn read_binary(records: &[u8], count: usize, limits: &ReadLimits) -> Result<Model, ReadError> {
    check_count(count, limits)?;
    let mut welder = Welder::with_capacity(count);
    for record in records.chunks_exact(RECORD).take(count) {
        let value = |at: usize| {
            let bytes = record[12 + 4 * at..][..4].try_into().expect("it has four bytes");
            f64::from(f32::from_le_bytes(bytes))
        };
        welder.triangle(
            [0, 3, 6].map(|corner| [value(corner), value(corner + 1), value(corner + 2)]),
        );
    }
    let mut model = Model::default();
    push(&mut model, String::new(), welder)?;
    Ok(model)
}

fn check_count(count: usize, limits: &ReadLimits) -> Result<(), ReadError> {
    if count > limits.triangles {
        return Err(ReadError::TooLarge { most: limits.triangles as u64, what: "triangles" });
    }
    Ok(())
}

fn push(model: &mut Model, name: String, welder: Welder) -> Result<(), ReadError> {
    let number = model.bodies.len();
    let named =
        |name: &str| if name.is_empty() { (number + 1).to_string() } else { name.to_owned() };
    let mesh = welder.mesh().map_err(|source| ReadError::Mesh { body: named(&name), source })?;
    model.bodies.push(Body { name, mesh, material: None, paint: Vec::new() });
    Ok(())
}

/// Text: keywords in any case, one to a line.
/// Normals are not read, for the corners' order says the same and is right more often.
fn read_text(bytes: &[u8], limits: &ReadLimits) -> Result<Model, ReadError> {
    let mut model = Model::default();
    let mut welder = Welder::default();
    let mut name = String::new();
    let mut corners: Vec<[f64; 3]> = Vec::with_capacity(3);
    let mut triangles = 0;
    let mut in_facet = false;
    let mut last = 0;
    for (line, text) in (1..).zip(bytes.split(|&byte| byte == b'\n')) {
        last = line;
        let text = String::from_utf8_lossy(text);
        let mut words = text.split_ascii_whitespace();
        let Some(keyword) = words.next() else { continue };
        match keyword.to_ascii_lowercase().as_str() {
            "solid" => name = words.collect::<Vec<_>>().join(" "),
            // Nothing is no body: it could not be repaired.
            "endsolid" if welder.len() == 0 => name.clear(),
            "endsolid" => {
                push(&mut model, std::mem::take(&mut name), std::mem::take(&mut welder))?;
            }
            "facet" if in_facet => {
                return Err(ReadError::text(line, "a facet begins within another"));
            }
            "facet" => in_facet = true,
            "vertex" if !in_facet => {
                return Err(ReadError::text(line, "a vertex outside any facet"));
            }
            "vertex" => corners.push(point(line, words)?),
            "endfacet" => {
                let Ok(triangle) = <[_; 3]>::try_from(&corners[..]) else {
                    return Err(ReadError::text(
                        line,
                        format!("a facet of {} vertices, not 3", corners.len()),
                    ));
                };
                triangles += 1;
                check_count(triangles, limits)?;
                welder.triangle(triangle);
                corners.clear();
                in_facet = false;
            }
            "outer" | "endloop" => {}
            _ => {
                let word: String = keyword.chars().take(20).collect();
                return Err(ReadError::text(line, format!("unknown word {word:?}")));
            }
        }
    }
    if in_facet || welder.len() > 0 {
        return Err(ReadError::text(last, "the file ends before its endsolid"));
    }
    Ok(model)
}

/// The next three words as coordinates in the line of that number.
pub(super) fn point<'a>(
    line: usize,
    mut words: impl Iterator<Item = &'a str>,
) -> Result<[f64; 3], ReadError> {
    let mut point = [0.0; 3];
    for value in &mut point {
        let word = words
            .next()
            .ok_or_else(|| ReadError::text(line, "a vertex of less than 3 coordinates"))?;
        *value = number(word).map_err(|what| ReadError::text(line, what))?;
    }
    Ok(point)
}

/// A finite number, or what is wrong with it.
pub(super) fn number(word: &str) -> Result<f64, String> {
    match word.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        Ok(value) => Err(format!("the coordinate {value}")),
        Err(_) => Err(format!("{:?} is no number", word.chars().take(20).collect::<String>())),
    }
}

#[cfg(test)]
mod tests {
    use beadwork_base::Control;

    use super::*;
    use crate::{Format, MeshError, Solid};

    fn text(name: &str, triangles: &[[[f64; 3]; 3]]) -> String {
        let corner = |[x, y, z]: &[f64; 3]| format!("      vertex {x} {y} {z}\n");
        let facet = |corners: &[[f64; 3]; 3]| {
            let corners: String = corners.iter().map(corner).collect();
            format!(
                "  facet normal nan nan nan\n    outer loop\n{corners}    endloop\n  endfacet\n"
            )
        };
        let facets: String = triangles.iter().map(facet).collect();
        format!("solid {name}\n{facets}endsolid {name}\n")
    }

    pub(super) fn binary(triangles: &[[[f64; 3]; 3]]) -> Vec<u8> {
        let mut bytes = b"solid in name only".to_vec();
        bytes.resize(80, b' ');
        bytes.extend((triangles.len() as u32).to_le_bytes());
        for corners in triangles {
            bytes.extend([0; 12]);
            corners.iter().flatten().for_each(|&value| bytes.extend((value as f32).to_le_bytes()));
            bytes.extend([0; 2]);
        }
        bytes
    }

    fn triangles() -> Vec<[[f64; 3]; 3]> {
        let mesh = Solid::Cuboid { size_mm: [2.0, 3.0, 4.0] }.mesh();
        mesh.triangles().iter().map(|&triangle| mesh.corners(triangle)).collect()
    }

    fn refused(bytes: &[u8]) -> ReadError {
        Model::read(Format::Stl, bytes, &ReadLimits::default(), &Control::default()).unwrap_err()
    }

    #[test]
    fn both_kinds_give_the_same_mesh() {
        let from_text =
            read(text("a box", &triangles()).as_bytes(), &ReadLimits::default()).unwrap();
        let from_binary = read(&binary(&triangles()), &ReadLimits::default()).unwrap();
        assert_eq!(from_text.bodies[0].name, "a box");
        assert_eq!(from_text.bodies[0].mesh, from_binary.bodies[0].mesh);
        assert_eq!(from_text.bodies[0].mesh.vertices().len(), 8);
        assert!((from_binary.bodies[0].mesh.volume_mm3() - 24.0).abs() < 1e-9);
    }

    #[test]
    fn every_solid_is_a_body() {
        let two = text("left", &triangles())
            + &text("right", &triangles()).to_uppercase().replace('\n', "\r\n");
        let model = read(two.as_bytes(), &ReadLimits::default()).unwrap();
        let names: Vec<_> = model.bodies.iter().map(|body| body.name.as_str()).collect();
        assert_eq!(names, ["left", "RIGHT"]);
        assert_eq!(model.bodies[0].mesh, model.bodies[1].mesh);
        // But one of nothing is none.
        let three = "solid nothing\nendsolid nothing\n".to_owned() + &two;
        assert_eq!(read(three.as_bytes(), &ReadLimits::default()).unwrap(), model);
    }

    #[test]
    fn what_is_wrong_is_named_with_its_place() {
        assert!(matches!(refused(b""), ReadError::Empty));
        assert!(matches!(refused(b"the cat sat on the mat\n"), ReadError::Kind(_)));
        assert!(matches!(refused(b"solid nothing\nendsolid\n"), ReadError::NoTriangles));
        let good = text("x", &triangles());
        let wrong = good.replacen("vertex 0", "vertex zero", 1);
        assert!(
            matches!(refused(wrong.as_bytes()), ReadError::Text { line: 4, .. }),
            "{}",
            refused(wrong.as_bytes())
        );
        let wrong = good.replacen("vertex 0", "vertex inf", 1);
        assert_eq!(refused(wrong.as_bytes()).to_string(), "line 4: the coordinate inf");
        let cut = &good[..good.len() - 40];
        assert!(matches!(refused(cut.as_bytes()), ReadError::Text { .. }));
        let mut short = binary(&triangles());
        short.truncate(300);
        assert!(matches!(refused(&short), ReadError::Short { promised: 12, room: 4 }));
        let mut nan = binary(&triangles());
        nan[HEADER + 12..HEADER + 16].copy_from_slice(&f32::NAN.to_le_bytes());
        let error = refused(&nan);
        assert!(
            matches!(error, ReadError::Mesh { source: MeshError::NotFinite { .. }, .. }),
            "{error}"
        );
        let few = ReadLimits { triangles: 11, ..ReadLimits::default() };
        assert!(matches!(
            read(&binary(&triangles()), &few),
            Err(ReadError::TooLarge { most: 11, .. })
        ));
        assert!(matches!(read(good.as_bytes(), &few), Err(ReadError::TooLarge { most: 11, .. })));
    }
}
