//! The header of a PLY file: what elements there are and what each consists of.

use super::Fault;

/// How the values are written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Encoding {
    Text,
    LittleEndian,
    BigEndian,
}

/// A type of number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Kind {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

/// A number of an element, or a list of numbers preceded by its length.
#[derive(Debug)]
pub(super) struct Property {
    pub name: String,
    pub kind: Kind,
    /// The type of a list's length.
    pub length: Option<Kind>,
}

/// Rows of equal properties.
#[derive(Debug)]
pub(super) struct Element {
    pub name: String,
    /// As the header says, which may lie.
    pub count: u64,
    pub properties: Vec<Property>,
}

impl Element {
    /// The rows to read: none of what takes no room, so that reading ends where the file does.
    pub fn rows(&self) -> u64 {
        if self.properties.is_empty() { 0 } else { self.count }
    }
}

/// What a header says.
#[derive(Debug)]
pub(super) struct Header {
    pub encoding: Encoding,
    pub elements: Vec<Element>,
}

/// Reads the header; returns the bytes after it as well.
pub(super) fn read(bytes: &[u8]) -> Result<(Header, &[u8]), Fault> {
    let (mut encoding, mut elements, mut rest, mut number) = (None, Vec::new(), bytes, 0);
    loop {
        number += 1;
        let Some((line, after)) = split_line(rest) else {
            return Err(Fault::new("header", "the file ends within its header; it was cut short"));
        };
        rest = after;
        let line = String::from_utf8_lossy(line);
        let words: Vec<&str> = line.split_whitespace().collect();
        let result = match words[..] {
            ["end_header"] => break,
            [] | ["ply" | "comment" | "obj_info", ..] => Ok(()),
            ["format", name, _] => encoding_of(name).map(|known| encoding = Some(known)),
            ["element", name, count] => element(name, count).map(|element| elements.push(element)),
            ["property", ..] => property(&words[1..], elements.last_mut()),
            _ => Err(format!("'{}' is no statement of PLY; export the file again", line.trim())),
        };
        result.map_err(|message| Fault::new(format!("line {number}"), message))?;
    }
    let Some(encoding) = encoding else {
        return Err(Fault::new("header", "it has no line 'format'; export the file again"));
    };
    Ok((Header { encoding, elements }, rest))
}

/// The first line, without its end, and what follows; old files end lines with a carriage return alone.
fn split_line(bytes: &[u8]) -> Option<(&[u8], &[u8])> {
    let end = bytes.iter().position(|&byte| byte == b'\n' || byte == b'\r')?;
    let skip = if bytes[end..].starts_with(b"\r\n") { 2 } else { 1 };
    Some((&bytes[..end], &bytes[end + skip..]))
}

fn encoding_of(name: &str) -> Result<Encoding, String> {
    match name {
        "ascii" => Ok(Encoding::Text),
        "binary_little_endian" => Ok(Encoding::LittleEndian),
        "binary_big_endian" => Ok(Encoding::BigEndian),
        _ => Err(format!("there is no format '{name}'; export the file again")),
    }
}

fn element(name: &str, count: &str) -> Result<Element, String> {
    let count = count.parse().map_err(|_| format!("'{count}' is no number of elements; export the file again"))?;
    Ok(Element { name: name.into(), count, properties: Vec::new() })
}

fn property(words: &[&str], element: Option<&mut Element>) -> Result<(), String> {
    let Some(element) = element else { return Err("a property comes before any element".into()) };
    let property = match *words {
        ["list", length, kind, name] => {
            Property { name: name.into(), kind: self::kind(kind)?, length: Some(self::kind(length)?) }
        }
        [kind, name] => Property { name: name.into(), kind: self::kind(kind)?, length: None },
        _ => return Err("a property has a type and a name, or 'list', two types and a name".into()),
    };
    element.properties.push(property);
    Ok(())
}

fn kind(name: &str) -> Result<Kind, String> {
    match name {
        "char" | "int8" => Ok(Kind::I8),
        "uchar" | "uint8" => Ok(Kind::U8),
        "short" | "int16" => Ok(Kind::I16),
        "ushort" | "uint16" => Ok(Kind::U16),
        "int" | "int32" => Ok(Kind::I32),
        "uint" | "uint32" => Ok(Kind::U32),
        "float" | "float32" => Ok(Kind::F32),
        "double" | "float64" => Ok(Kind::F64),
        _ => Err(format!("there is no type '{name}'; export the file again")),
    }
}
