//! STL files, binary and text.

use beadwork_base::Control;

use super::error::{ReadError, ReadLimits};
use super::text::{point, shown};
use crate::model::{Body, Model};
use crate::weld::Welder;
use crate::work::Work;

/// Length of a binary file's header: 80 bytes without meaning, and the number of triangles.
const HEADER: usize = 84;
/// Length of a triangle in a binary file: normal, three corners, and two bytes of attributes.
const RECORD: usize = 50;

/// Reads a binary or text file.
///
/// A file is binary if its length matches the number of triangles in its header, whatever the
/// header begins with: many programs write "solid" there, like in a text file.
pub(super) fn read(
    bytes: &[u8],
    limits: &ReadLimits,
    control: &Control<'_>,
) -> Result<Model, ReadError> {
    let mut work = Work::new(control, 1, bytes.len());
    let declared = match bytes.get(HEADER - 4..HEADER) {
        Some(count) => u64::from(u32::from_le_bytes(count.try_into().expect("it has four bytes"))),
        None => 0,
    };
    let length_matches =
        bytes.len() >= HEADER && bytes.len() as u64 == HEADER as u64 + RECORD as u64 * declared;
    if !length_matches && begins_as_text(bytes) {
        return read_text(bytes, limits, &mut work);
    }
    if bytes.len() < HEADER {
        let reason = "begins neither with a binary header nor with 'solid'";
        return Err(ReadError::WrongFormat { format: "STL", reason });
    }
    let held = ((bytes.len() - HEADER) / RECORD) as u64;
    if declared > held {
        return Err(ReadError::Truncated { declared, held });
    }
    read_binary(&bytes[HEADER..], declared as usize, limits, &mut work)
}

fn begins_as_text(bytes: &[u8]) -> bool {
    let word = bytes.trim_ascii_start().get(..5);
    // A truncated binary file, whose header may begin with "solid", soon contains zero bytes.
    word.is_some_and(|word| word.eq_ignore_ascii_case(b"solid"))
        && !bytes.iter().take(1024).any(|&byte| byte == 0)
}

fn read_binary(
    records: &[u8],
    count: usize,
    limits: &ReadLimits,
    work: &mut Work<'_>,
) -> Result<Model, ReadError> {
    check_count(count, limits)?;
    let mut welder = Welder::with_capacity(count);
    for (number, record) in records.chunks_exact(RECORD).take(count).enumerate() {
        work.tick(HEADER + RECORD * number)?;
        // The first 12 bytes are the normal, which the order of the corners implies.
        let value = |index: usize| {
            let bytes = record[12 + 4 * index..][..4].try_into().expect("it has four bytes");
            f64::from(f32::from_le_bytes(bytes))
        };
        welder.add_triangle(
            [0, 3, 6].map(|corner| [value(corner), value(corner + 1), value(corner + 2)]),
        );
    }
    let mut model = Model::default();
    add_body(&mut model, String::new(), welder)?;
    Ok(model)
}

fn check_count(count: usize, limits: &ReadLimits) -> Result<(), ReadError> {
    if count > limits.triangles {
        return Err(ReadError::too_large(limits.triangles, "triangles"));
    }
    Ok(())
}

fn add_body(model: &mut Model, name: String, welder: Welder) -> Result<(), ReadError> {
    let number = model.bodies.len() + 1;
    let mesh = welder.into_mesh().map_err(|source| {
        let body = if name.is_empty() { number.to_string() } else { name.clone() };
        ReadError::Mesh { body, source }
    })?;
    model.bodies.push(Body { name, mesh, material: None, ..Body::default() });
    Ok(())
}

/// Reads a text file: one keyword per line, in any case.
/// Each `solid` is a body.
/// Normals are ignored: the order of the corners states the same, and is correct more often.
fn read_text(bytes: &[u8], limits: &ReadLimits, work: &mut Work<'_>) -> Result<Model, ReadError> {
    let mut model = Model::default();
    let mut welder = Welder::default();
    let mut name = String::new();
    let mut corners: Vec<[f64; 3]> = Vec::with_capacity(3);
    let mut triangles = 0;
    let mut in_facet = false;
    let mut last = 0;
    let mut position = 0;
    for (line, text) in (1..).zip(bytes.split(|&byte| byte == b'\n')) {
        work.tick(position)?;
        position += text.len() + 1;
        last = line;
        let text = String::from_utf8_lossy(text);
        let mut words = text.split_ascii_whitespace();
        let Some(keyword) = words.next() else { continue };
        match keyword.to_ascii_lowercase().as_str() {
            "solid" => name = words.collect::<Vec<_>>().join(" "),
            // A solid without triangles is not a body: it could not be repaired.
            "endsolid" if welder.len() == 0 => name.clear(),
            "endsolid" => {
                add_body(&mut model, std::mem::take(&mut name), std::mem::take(&mut welder))?;
            }
            "facet" if in_facet => {
                return Err(ReadError::line(line, "facet begins inside another facet"));
            }
            "facet" => in_facet = true,
            "vertex" if !in_facet => {
                return Err(ReadError::line(line, "vertex is outside a facet"));
            }
            "vertex" => corners.push(point(line, words)?),
            "endfacet" => {
                let Ok(triangle) = <[_; 3]>::try_from(&corners[..]) else {
                    let message = format!("facet has {} vertices, expected 3", corners.len());
                    return Err(ReadError::line(line, message));
                };
                triangles += 1;
                check_count(triangles, limits)?;
                welder.add_triangle(triangle);
                corners.clear();
                in_facet = false;
            }
            "outer" | "endloop" => {}
            _ => {
                return Err(ReadError::line(line, format!("unknown keyword '{}'", shown(keyword))));
            }
        }
    }
    if in_facet || welder.len() > 0 {
        return Err(ReadError::line(last, "file ends before 'endsolid'"));
    }
    Ok(model)
}

#[cfg(test)]
mod tests {
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
    fn binary_and_text_give_the_same_mesh() {
        let from_text = read(
            text("a box", &triangles()).as_bytes(),
            &ReadLimits::default(),
            &Control::default(),
        )
        .unwrap();
        let from_binary =
            read(&binary(&triangles()), &ReadLimits::default(), &Control::default()).unwrap();
        assert_eq!(from_text.bodies[0].name, "a box");
        assert_eq!(from_text.bodies[0].mesh, from_binary.bodies[0].mesh);
        assert_eq!(from_text.bodies[0].mesh.vertices().len(), 8);
        assert!((from_binary.bodies[0].mesh.volume_mm3() - 24.0).abs() < 1e-9);
    }

    #[test]
    fn every_solid_is_a_body() {
        let two = text("left", &triangles())
            + &text("right", &triangles()).to_uppercase().replace('\n', "\r\n");
        let model = read(two.as_bytes(), &ReadLimits::default(), &Control::default()).unwrap();
        let names: Vec<_> = model.bodies.iter().map(|body| body.name.as_str()).collect();
        assert_eq!(names, ["left", "RIGHT"]);
        assert_eq!(model.bodies[0].mesh, model.bodies[1].mesh);
        // A solid without triangles is not one.
        let three = "solid nothing\nendsolid nothing\n".to_owned() + &two;
        assert_eq!(
            read(three.as_bytes(), &ReadLimits::default(), &Control::default()).unwrap(),
            model
        );
    }

    #[test]
    fn errors_state_their_location() {
        assert!(matches!(refused(b""), ReadError::Empty));
        assert!(matches!(refused(b"the cat sat on the mat\n"), ReadError::WrongFormat { .. }));
        assert!(matches!(refused(b"solid nothing\nendsolid\n"), ReadError::NoTriangles));
        let good = text("x", &triangles());
        let wrong = good.replacen("vertex 0", "vertex zero", 1);
        assert!(
            matches!(refused(wrong.as_bytes()), ReadError::Line { line: 4, .. }),
            "{}",
            refused(wrong.as_bytes())
        );
        let wrong = good.replacen("vertex 0", "vertex inf", 1);
        assert_eq!(refused(wrong.as_bytes()).to_string(), "line 4: 'inf' is not a finite number");
        let cut = &good[..good.len() - 40];
        assert!(matches!(refused(cut.as_bytes()), ReadError::Line { .. }));
        let mut short = binary(&triangles());
        short.truncate(300);
        assert!(matches!(refused(&short), ReadError::Truncated { declared: 12, held: 4 }));
        let mut nan = binary(&triangles());
        nan[HEADER + 12..HEADER + 16].copy_from_slice(&f32::NAN.to_le_bytes());
        let error = refused(&nan);
        assert!(
            matches!(error, ReadError::Mesh { source: MeshError::NotFinite { .. }, .. }),
            "{error}"
        );
        let few = ReadLimits { triangles: 11, ..ReadLimits::default() };
        assert!(matches!(
            read(&binary(&triangles()), &few, &Control::default()),
            Err(ReadError::TooLarge { limit: 11, .. })
        ));
        assert!(matches!(
            read(good.as_bytes(), &few, &Control::default()),
            Err(ReadError::TooLarge { limit: 11, .. })
        ));
    }
}
