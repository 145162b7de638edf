//! STL files, binary and text.

use beadwork_base::Control;

use super::error::{ReadError, ReadLimits};
use super::text::{Words, decoded, point, shown};
use crate::model::{Body, Model};
use crate::warning::ReadWarning;
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
///
/// A binary file that is longer than its header declares, by whole triangles, is read to its end,
/// with a warning: programs that write the number last sometimes fail to.
/// So is a file whose header declares none.
pub(super) fn read(
    bytes: &[u8],
    limits: &ReadLimits,
    control: &Control<'_>,
) -> Result<Model, ReadError> {
    let declared = match bytes.get(HEADER - 4..HEADER) {
        Some(count) => u64::from(u32::from_le_bytes(count.try_into().expect("it has four bytes"))),
        None => 0,
    };
    let length_matches =
        bytes.len() >= HEADER && bytes.len() as u64 == HEADER as u64 + RECORD as u64 * declared;
    if !length_matches {
        let text = decoded(bytes);
        if begins_as_text(&text) {
            return read_text(&text, limits, &mut Work::new(control, 1, text.len()));
        }
    }
    if bytes.len() < HEADER {
        let reason = "begins neither with a binary header nor with 'solid'";
        return Err(ReadError::WrongFormat { format: "STL", reason });
    }
    let records = &bytes[HEADER..];
    let held = (records.len() / RECORD) as u64;
    if declared > held {
        return Err(ReadError::Truncated { declared, held });
    }
    let mut work = Work::new(control, 1, bytes.len());
    let more = records.len() as u64 - declared * RECORD as u64;
    let rest = more % RECORD as u64;
    let reads_all = more > 0 && (rest == 0 || declared == 0 && held > 0);
    let (count, more) = if reads_all { (held, rest) } else { (declared, more) };
    let mut model = read_binary(records, count as usize, limits, &mut work)?;
    if reads_all {
        model.warnings.push(ReadWarning::TriangleCount { declared, held });
    }
    if more > 0 {
        let what = format!("{more} bytes after the last triangle");
        model.warnings.push(ReadWarning::Ignored { what });
    }
    Ok(model)
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
    let mut has_attributes = false;
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
        has_attributes |= record[48..] != [0, 0];
    }
    let mut model = Model::default();
    add_body(&mut model, String::new(), welder)?;
    if has_attributes {
        let what = "attributes of triangles (colours)".into();
        model.warnings.push(ReadWarning::Ignored { what });
    }
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
    let mesh = welder.into_mesh().map_err(|error| {
        let body = if name.is_empty() { number.to_string() } else { name.clone() };
        ReadError::Mesh { body, error }
    })?;
    model.bodies.push(Body { name, mesh, material: None, ..Body::default() });
    Ok(())
}

/// Reads a text file: keywords and numbers, in any case, on any number of lines.
/// Each `solid` is a body.
/// Normals are ignored: the order of the corners states the same, and is correct more often.
fn read_text(bytes: &[u8], limits: &ReadLimits, work: &mut Work<'_>) -> Result<Model, ReadError> {
    let mut model = Model::default();
    let mut welder = Welder::default();
    let mut name = String::new();
    let mut corners: Vec<[f64; 3]> = Vec::with_capacity(3);
    let mut triangles = 0;
    let mut in_facet = false;
    let mut words = Words::new(bytes);
    while let Some(keyword) = words.next() {
        work.tick(words.position())?;
        let line = words.line();
        let is = |known: &str| keyword.eq_ignore_ascii_case(known);
        if is("vertex") {
            if !in_facet {
                return Err(ReadError::line(line, "vertex is outside a facet"));
            }
            corners.push(point(line, std::iter::from_fn(|| words.next_on_line()))?);
        } else if is("facet") {
            if in_facet {
                return Err(ReadError::line(line, "facet begins inside another facet"));
            }
            in_facet = true;
            while words.peek_on_line().is_some_and(|word| !is_keyword(word)) {
                words.next_on_line();
            }
        } else if is("endfacet") {
            let Ok(triangle) = <[_; 3]>::try_from(&corners[..]) else {
                let message = format!("facet has {} vertices, expected 3", corners.len());
                return Err(ReadError::line(line, message));
            };
            triangles += 1;
            check_count(triangles, limits)?;
            welder.add_triangle(triangle);
            corners.clear();
            in_facet = false;
        } else if is("solid") {
            name = solid_name(&mut words, begins_facet);
        } else if is("endsolid") {
            solid_name(&mut words, begins_solid);
            // A solid without triangles is not a body: it could not be repaired.
            if welder.len() == 0 {
                name.clear();
            } else {
                add_body(&mut model, std::mem::take(&mut name), std::mem::take(&mut welder))?;
            }
        } else if !is_keyword(keyword) {
            return Err(ReadError::line(line, format!("unknown keyword '{}'", shown(keyword))));
        }
    }
    if in_facet || welder.len() > 0 {
        return Err(ReadError::line(words.line(), "file ends before 'endsolid'"));
    }
    Ok(model)
}

/// Whether a word is a keyword inside a solid.
fn is_keyword(word: &str) -> bool {
    let keywords = ["facet", "outer", "loop", "vertex", "endloop", "endfacet", "endsolid"];
    keywords.iter().any(|keyword| word.eq_ignore_ascii_case(keyword))
}

/// The words up to the end of the line, which are the name of a solid.
/// In a file of one line they end before what `begins` recognises.
fn solid_name(words: &mut Words<'_>, begins: impl Fn(Words<'_>) -> bool) -> String {
    let mut name = Vec::new();
    while words.peek_on_line().is_some() && !begins(words.clone()) {
        name.extend(words.next_on_line());
    }
    name.join(" ")
}

/// Whether the next words of the line begin a facet.
fn begins_facet(mut words: Words<'_>) -> bool {
    is_next(&mut words, "facet") && is_next(&mut words, "normal")
}

/// Whether the next word of the line begins a solid.
fn begins_solid(mut words: Words<'_>) -> bool {
    is_next(&mut words, "solid")
}

fn is_next(words: &mut Words<'_>, keyword: &str) -> bool {
    words.next_on_line().is_some_and(|word| word.eq_ignore_ascii_case(keyword))
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
        // A name may contain keywords.
        let named = text("solid facet of a solid", &triangles());
        let model_of_named =
            read(named.as_bytes(), &ReadLimits::default(), &Control::default()).unwrap();
        assert_eq!(model_of_named.bodies[0].name, "solid facet of a solid");
        // A solid without triangles is not one.
        let three = "solid nothing\nendsolid nothing\n".to_owned() + &two;
        assert_eq!(
            read(three.as_bytes(), &ReadLimits::default(), &Control::default()).unwrap(),
            model
        );
    }

    // CADMesh#40, with a byte order mark, line ends of old Macs, one line, and UTF-16
    #[test]
    fn text_in_any_encoding_and_layout_is_read() {
        let plain = text("left", &triangles()) + &text("right", &triangles());
        let expected = read(plain.as_bytes(), &ReadLimits::default(), &Control::default()).unwrap();
        let utf16: Vec<u8> =
            format!("\u{feff}{plain}").encode_utf16().flat_map(u16::to_le_bytes).collect();
        let ended = format!("{plain}\u{1a}\0\0");
        for bytes in [
            format!("\u{feff}{plain}").into_bytes(),
            plain.replace('\n', "\r").into_bytes(),
            plain.replace('\n', " ").into_bytes(),
            ended.into_bytes(),
            utf16,
        ] {
            let model = read(&bytes, &ReadLimits::default(), &Control::default()).unwrap();
            assert_eq!(model, expected);
        }
    }

    // mikedh/trimesh#1720
    #[test]
    fn a_count_that_is_too_small_is_reported() {
        let good = binary(&triangles());
        for declared in [0_u32, 5] {
            let mut bytes = good.clone();
            bytes[80..84].copy_from_slice(&declared.to_le_bytes());
            let model = read(&bytes, &ReadLimits::default(), &Control::default()).unwrap();
            assert_eq!(model.bodies[0].mesh.triangles().len(), 12);
            let warning = ReadWarning::TriangleCount { declared: declared.into(), held: 12 };
            assert_eq!(model.warnings, [warning]);
        }
        let mut both = good.clone();
        both[80..84].copy_from_slice(&[0; 4]);
        both.extend([1; 7]);
        let model = read(&both, &ReadLimits::default(), &Control::default()).unwrap();
        assert_eq!((model.triangle_count(), model.warnings.len()), (12, 2));
        let mut longer = good;
        longer.extend([1; 7]);
        let model = read(&longer, &ReadLimits::default(), &Control::default()).unwrap();
        assert_eq!(model.warnings[0].to_string(), "7 bytes after the last triangle: not used");
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
            matches!(error, ReadError::Mesh { error: MeshError::NotFinite { .. }, .. }),
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
