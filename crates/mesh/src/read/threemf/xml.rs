//! Elements and attributes of XML.

use std::borrow::Cow;
use std::io::BufRead;

use quick_xml::events::{BytesStart, Event};
use quick_xml::name::Prefix;
use quick_xml::{Reader, XmlVersion};

use super::namespace::{Namespace, Scope};
use crate::read::error::ReadError;

/// The start or the end of an element.
pub(super) enum Element<'a> {
    Start(&'a Tag<'a>),
    /// Its namespace, and its name without a prefix.
    End(Namespace, &'a str),
}

/// The start of an element.
pub(super) struct Tag<'a> {
    start: &'a BytesStart<'a>,
    /// The name of the element, without a prefix.
    pub(super) name: &'a str,
    prefix: &'a str,
    /// The namespace of the element.
    pub(super) namespace: Namespace,
    /// The declarations that are in effect.
    pub(super) scope: &'a Scope,
    /// Number of elements around it.
    pub(super) depth: u32,
}

/// Calls `visit` for the start and the end of every element, in order.
/// An error of `visit` is returned together with its location.
pub(super) fn each_element(
    entry: &str,
    source: &mut dyn BufRead,
    mut visit: impl FnMut(Element<'_>) -> Result<(), String>,
) -> Result<(), ReadError> {
    // Section 2.3.2 of the core specification allows only UTF-8.
    let start = source.fill_buf().unwrap_or_default();
    if start.starts_with(b"\xFE\xFF") || start.starts_with(b"\xFF\xFE") {
        let message = "XML is UTF-16, expected UTF-8".into();
        return Err(ReadError::Entry { entry: entry.to_owned(), byte: Some(0), message });
    }
    let mut reader = Reader::from_reader(source);
    let mut buffer = Vec::new();
    let mut scope = Scope::default();
    let mut depth = 0_u32;
    loop {
        buffer.clear();
        let error_at = |byte: u64, message: String| ReadError::Entry {
            entry: entry.to_owned(),
            byte: Some(byte),
            message,
        };
        let event = match reader.read_event_into(&mut buffer) {
            Ok(event) => event,
            Err(error) => return Err(error_at(reader.error_position(), error.to_string())),
        };
        let result = match &event {
            Event::Start(start) => {
                depth += 1;
                enter(&mut scope, start, depth, &mut visit).map(|_| ())
            }
            Event::Empty(start) => {
                let result =
                    enter(&mut scope, start, depth + 1, &mut visit).and_then(|namespace| {
                        visit(Element::End(namespace, start.local_name().as_ref()))
                    });
                scope.leave(depth + 1);
                result
            }
            Event::End(end) => {
                let (name, prefix) = end.name().decompose();
                let prefix = prefix.as_ref().map_or("", |prefix| prefix.as_ref());
                let result = visit(Element::End(scope.namespace(prefix), name.as_ref()));
                scope.leave(depth);
                depth = depth.saturating_sub(1);
                result
            }
            Event::DocType(_) => {
                Err("XML has a document type definition, which is not allowed".into())
            }
            Event::Eof if depth > 0 => Err("XML ends inside an element".into()),
            Event::Eof => return Ok(()),
            _ => Ok(()),
        };
        result.map_err(|message| error_at(reader.buffer_position(), message))?;
    }
}

/// Visits the start of an element at a depth; returns its namespace.
fn enter(
    scope: &mut Scope,
    start: &BytesStart<'_>,
    depth: u32,
    visit: &mut impl FnMut(Element<'_>) -> Result<(), String>,
) -> Result<Namespace, String> {
    scope.enter(start, depth)?;
    let (name, prefix) = start.name().decompose();
    let (name, prefix) = (name.into_inner(), prefix.map_or("", Prefix::into_inner));
    let namespace = scope.namespace(prefix);
    let scope = &*scope;
    visit(Element::Start(&Tag { start, name, prefix, namespace, scope, depth: depth - 1 }))?;
    Ok(namespace)
}

impl Tag<'_> {
    /// The name of the extension that the element belongs to, for messages after "the".
    pub(super) fn extension(&self) -> String {
        self.scope.extension(self.prefix)
    }

    /// The value of an attribute without a prefix, if the element has it.
    pub(super) fn attribute(&self, name: &str) -> Result<Option<Cow<'_, str>>, String> {
        let found = self.start.try_get_attribute(name).map_err(|error| error.to_string())?;
        let Some(found) = found else { return Ok(None) };
        found.normalized_value(XmlVersion::Explicit1_0).map(Some).map_err(|error| error.to_string())
    }

    /// The value of an attribute of a namespace, if the element has it.
    pub(super) fn attribute_in(
        &self,
        namespace: Namespace,
        name: &str,
    ) -> Result<Option<Cow<'_, str>>, String> {
        for attribute in self.start.attributes().with_checks(false) {
            let attribute = attribute.map_err(|error| error.to_string())?;
            let (local, prefix) = attribute.key.decompose();
            let Some(prefix) = prefix else { continue };
            if local.as_ref() == name && self.scope.namespace(prefix.as_ref()) == namespace {
                let value = attribute.normalized_value(XmlVersion::Explicit1_0);
                return value.map(Some).map_err(|error| error.to_string());
            }
        }
        Ok(None)
    }

    /// The value of an attribute that is an integer.
    pub(super) fn integer(&self, name: &str) -> Result<Option<u32>, String> {
        let Some(text) = self.attribute(name)? else { return Ok(None) };
        text.trim()
            .parse()
            .map(Some)
            .map_err(|_| format!("{name} is '{text}', expected an integer"))
    }

    /// Calls `visit` with the name and the raw value of every attribute.
    ///
    /// Faster than a search for each name; the frequent elements (vertices and triangles) need it.
    pub(super) fn each_attribute(
        &self,
        mut visit: impl FnMut(&str, &str) -> Result<(), String>,
    ) -> Result<(), String> {
        for attribute in self.start.attributes().with_checks(false) {
            let attribute = attribute.map_err(|error| error.to_string())?;
            visit(attribute.key.as_ref(), &attribute.value)?;
        }
        Ok(())
    }
}
