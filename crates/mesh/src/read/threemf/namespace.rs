//! Namespaces of XML: which vocabulary an element or an attribute belongs to.
//!
//! A prefix alone means nothing: `m:color` and `material:color` are the same element if both
//! prefixes stand for the same namespace.
//! An element without a prefix in a document without a default namespace counts as one of the core
//! specification, because some programs omit the declaration.

use quick_xml::events::BytesStart;

use crate::read::text::shown;

/// More declarations in effect at once than any program writes.
/// Prefixes are looked up one by one, so the number bounds the time of a lookup.
const MAX_DECLARATIONS: usize = 256;
/// Characters of an unknown namespace that a message shows.
const SHOWN_CHARS: usize = 80;

/// A namespace that the reader knows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Namespace {
    /// The core specification, or none.
    Core,
    /// The namespace of `xml:lang` and `xmlns`.
    Xml,
    Materials,
    Production,
    Alternatives,
    TriangleSets,
    /// Attributes of PrusaSlicer.
    Slic3r,
    /// Attributes of Bambu Studio and Orca Slicer.
    Bambu,
    /// An extension that changes the shape or the protection of objects, or one that is unknown: it
    /// is not supported.
    Other,
}

/// Known namespaces, and the names of their extensions.
const KNOWN: [(&str, Namespace, &str); 22] = [
    ("http://schemas.microsoft.com/3dmanufacturing/core/2015/02", Namespace::Core, "core"),
    (
        "http://schemas.microsoft.com/3dmanufacturing/material/2015/02",
        Namespace::Materials,
        "materials",
    ),
    (
        "http://schemas.microsoft.com/3dmanufacturing/production/2015/06",
        Namespace::Production,
        "production",
    ),
    (
        "http://schemas.microsoft.com/3dmanufacturing/production/alternatives/2021/04",
        Namespace::Alternatives,
        "production alternatives",
    ),
    (
        "http://schemas.microsoft.com/3dmanufacturing/trianglesets/2021/07",
        Namespace::TriangleSets,
        "triangle sets",
    ),
    ("http://schemas.slic3r.org/3mf/2017/06", Namespace::Slic3r, "PrusaSlicer"),
    ("http://schemas.bambulab.com/package/2021", Namespace::Bambu, "Bambu Studio"),
    ("http://www.w3.org/XML/1998/namespace", Namespace::Xml, "xml"),
    ("http://schemas.microsoft.com/3dmanufacturing/slice/2015/07", Namespace::Other, "slice"),
    (
        "http://schemas.microsoft.com/3dmanufacturing/beamlattice/2017/02",
        Namespace::Other,
        "beam lattice",
    ),
    (
        "http://schemas.microsoft.com/3dmanufacturing/beamlattice/balls/2020/07",
        Namespace::Other,
        "beam lattice balls",
    ),
    (
        "http://schemas.microsoft.com/3dmanufacturing/securecontent/2019/04",
        Namespace::Other,
        "secure content",
    ),
    (
        "http://schemas.microsoft.com/3dmanufacturing/securecontent/2019/07",
        Namespace::Other,
        "secure content",
    ),
    (
        "http://schemas.3mf.io/3dmanufacturing/booleanoperations/2023/07",
        Namespace::Other,
        "boolean operations",
    ),
    (
        "http://schemas.3mf.io/3dmanufacturing/displacement/2023/10",
        Namespace::Other,
        "displacement",
    ),
    (
        "http://schemas.microsoft.com/3dmanufacturing/displacement/2022/07",
        Namespace::Other,
        "displacement",
    ),
    (
        "http://schemas.microsoft.com/3dmanufacturing/volumetric/2018/11",
        Namespace::Other,
        "volumetric",
    ),
    ("http://schemas.3mf.io/3dmanufacturing/volumetric/2022/01", Namespace::Other, "volumetric"),
    (
        "http://schemas.microsoft.com/3dmanufacturing/volumetric/2022/01",
        Namespace::Other,
        "volumetric",
    ),
    ("http://schemas.3mf.io/3dmanufacturing/implicit/2023/12", Namespace::Other, "implicit"),
    ("http://schemas.microsoft.com/3dmanufacturing/implicit/2023/12", Namespace::Other, "implicit"),
    (
        "http://schemas.microsoft.com/3dmanufacturing/lasertoolpath/2019/05",
        Namespace::Other,
        "toolpath",
    ),
];

impl Namespace {
    fn of(uri: &str) -> Self {
        let known = KNOWN.iter().find(|(known, ..)| *known == uri.trim());
        known.map_or(Self::Other, |&(_, namespace, _)| namespace)
    }
}

/// The name of an extension, for messages after "the": its own if it is known, otherwise its
/// namespace.
pub(super) fn extension_name(uri: &str) -> String {
    match KNOWN.iter().find(|(known, ..)| *known == uri.trim()) {
        Some((.., name)) => format!("{name} extension"),
        None => format!("extension {}", uri.chars().take(SHOWN_CHARS).collect::<String>()),
    }
}

/// A prefix and the namespace it stands for.
struct Declaration {
    prefix: String,
    uri: String,
    namespace: Namespace,
    /// Depth of the element that declares it.
    depth: u32,
}

/// The declarations that are in effect at a position of a document.
pub(super) struct Scope {
    declarations: Vec<Declaration>,
    /// The namespace of elements without a prefix, which most elements are.
    default: Namespace,
}

impl Default for Scope {
    fn default() -> Self {
        Self { declarations: Vec::new(), default: Namespace::Core }
    }
}

impl Scope {
    /// Adds the declarations of an element at a depth.
    pub(super) fn enter(&mut self, start: &BytesStart<'_>, depth: u32) -> Result<(), String> {
        // Almost no element has declarations, and a search for a letter, and then for the word, is
        // faster than a look at all attributes.
        if !start.contains('m') || !start.contains("xmlns") {
            return Ok(());
        }
        for attribute in start.attributes().with_checks(false) {
            let attribute = attribute.map_err(|error| error.to_string())?;
            let key = attribute.key.as_ref();
            let Some(prefix) = key.strip_prefix("xmlns") else { continue };
            let prefix = match prefix.strip_prefix(':') {
                Some(prefix) => prefix,
                None if prefix.is_empty() => "",
                None => continue,
            };
            if self.declarations.len() == MAX_DECLARATIONS {
                return Err(format!("more than {MAX_DECLARATIONS} namespaces are declared"));
            }
            let uri = attribute.value.into_owned();
            let namespace = if uri.is_empty() { Namespace::Core } else { Namespace::of(&uri) };
            self.declarations.push(Declaration {
                prefix: prefix.to_owned(),
                uri,
                namespace,
                depth,
            });
        }
        self.default = self.find("").map_or(Namespace::Core, |found| found.namespace);
        Ok(())
    }

    /// Removes the declarations of the element that ends at a depth.
    pub(super) fn leave(&mut self, depth: u32) {
        if self.declarations.last().is_some_and(|last| last.depth >= depth) {
            self.declarations.retain(|declaration| declaration.depth < depth);
            self.default = self.find("").map_or(Namespace::Core, |found| found.namespace);
        }
    }

    fn find(&self, prefix: &str) -> Option<&Declaration> {
        self.declarations.iter().rev().find(|declaration| declaration.prefix == prefix)
    }

    /// The namespace of a prefix; the empty prefix is that of elements without one.
    pub(super) fn namespace(&self, prefix: &str) -> Namespace {
        if prefix.is_empty() {
            return self.default;
        }
        match (self.find(prefix), prefix) {
            (Some(declaration), _) => declaration.namespace,
            (None, "xml" | "xmlns") => Namespace::Xml,
            // PrusaSlicer itself recognizes its attributes by their prefix.
            (None, "slic3rpe") => Namespace::Slic3r,
            (None, _) => Namespace::Other,
        }
    }

    /// The name of the extension that a prefix stands for, for messages after "the".
    pub(super) fn extension(&self, prefix: &str) -> String {
        match self.find(prefix) {
            Some(declaration) => extension_name(&declaration.uri),
            None => format!("extension {}", shown(prefix)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prefixes_are_those_of_the_innermost_element() {
        let mut scope = Scope::default();
        let element = |content: &'static str| BytesStart::from_content(content, 1);
        assert_eq!(scope.namespace(""), Namespace::Core);
        let outer =
            r#"a xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02" xmlns:x="u""#;
        scope.enter(&element(outer), 1).unwrap();
        scope
            .enter(&element(r#"a xmlns="v" xmlns:x="http://schemas.slic3r.org/3mf/2017/06""#), 2)
            .unwrap();
        assert_eq!(
            (scope.namespace(""), scope.namespace("x")),
            (Namespace::Other, Namespace::Slic3r)
        );
        assert_eq!(scope.extension(""), "extension v");
        scope.leave(2);
        assert_eq!(
            (scope.namespace(""), scope.namespace("x")),
            (Namespace::Core, Namespace::Other)
        );
        scope.leave(1);
        assert_eq!(scope.extension("x"), "extension x");
        let many: Vec<_> = (0..300).map(|number| format!(" xmlns:p{number}=\"u\"")).collect();
        let many = many.concat();
        assert!(scope.enter(&BytesStart::from_content(format!("a{many}"), 1), 1).is_err());
    }
}
