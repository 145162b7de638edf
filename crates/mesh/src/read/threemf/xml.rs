//! Elements and attributes of XML.

use std::borrow::Cow;
use std::io::BufRead;

use quick_xml::events::{BytesStart, Event};
use quick_xml::{Reader, XmlVersion};

use crate::read::error::ReadError;

/// The start or the end of an element.
pub(super) enum Element<'a> {
    Start(&'a BytesStart<'a>),
    /// Its name, without a prefix.
    End(&'a str),
}

/// Calls `visit` for the start and the end of every element, in order.
/// An error of `visit` is returned together with its location.
pub(super) fn each_element(
    entry: &str,
    source: &mut dyn BufRead,
    mut visit: impl FnMut(Element<'_>) -> Result<(), String>,
) -> Result<(), ReadError> {
    let mut reader = Reader::from_reader(source);
    let mut buffer = Vec::new();
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
                visit(Element::Start(start))
            }
            Event::Empty(start) => visit(Element::Start(start))
                .and_then(|()| visit(Element::End(start.local_name().as_ref()))),
            Event::End(end) => {
                depth = depth.saturating_sub(1);
                visit(Element::End(end.local_name().as_ref()))
            }
            Event::Eof if depth > 0 => Err("XML ends inside an element".into()),
            Event::Eof => return Ok(()),
            _ => Ok(()),
        };
        result.map_err(|message| error_at(reader.buffer_position(), message))?;
    }
}

/// The value of an attribute, if the element has it.
pub(super) fn attribute<'a>(
    start: &'a BytesStart<'_>,
    name: &str,
) -> Result<Option<Cow<'a, str>>, String> {
    let found = start.try_get_attribute(name).map_err(|error| error.to_string())?;
    let Some(found) = found else { return Ok(None) };
    found.normalized_value(XmlVersion::Explicit1_0).map(Some).map_err(|error| error.to_string())
}

/// The value of an attribute that is an integer.
pub(super) fn integer(start: &BytesStart<'_>, name: &str) -> Result<Option<u32>, String> {
    let Some(text) = attribute(start, name)? else { return Ok(None) };
    text.trim().parse().map(Some).map_err(|_| format!("{name} is '{text}', expected an integer"))
}

/// Calls `visit` with the name and the raw value of every attribute.
///
/// Faster than a search for each name; the frequent elements (vertices and triangles) need it.
pub(super) fn each_attribute(
    start: &BytesStart<'_>,
    mut visit: impl FnMut(&str, &str) -> Result<(), String>,
) -> Result<(), String> {
    for attribute in start.attributes().with_checks(false) {
        let attribute = attribute.map_err(|error| error.to_string())?;
        visit(attribute.key.as_ref(), &attribute.value)?;
    }
    Ok(())
}
