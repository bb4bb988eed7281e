//! The numbers after the header, one after another.

use super::Trouble;
use super::header::Kind;

/// Where numbers come from. Every number takes room in the file, so that no header can have more read than there is.
pub(super) trait Source {
    /// The next number.
    fn next(&mut self, kind: Kind) -> Result<f64, Trouble>;
}

/// Numbers between white space.
pub(super) struct Text<'a> {
    rest: &'a [u8],
}

impl<'a> Text<'a> {
    pub fn new(rest: &'a [u8]) -> Self {
        Self { rest }
    }
}

impl Source for Text<'_> {
    fn next(&mut self, _: Kind) -> Result<f64, Trouble> {
        let start = self.rest.trim_ascii_start();
        let end = start.iter().position(u8::is_ascii_whitespace).unwrap_or(start.len());
        if end == 0 {
            return Err(Trouble::End);
        }
        let (word, rest) = start.split_at(end);
        self.rest = rest;
        let number = str::from_utf8(word).ok().and_then(|word| word.parse().ok());
        number
            .ok_or_else(|| Trouble::Value(format!("'{}' is no number; repair the file", String::from_utf8_lossy(word))))
    }
}

/// Numbers as bytes.
pub(super) struct Binary<'a> {
    rest: &'a [u8],
    is_big_endian: bool,
}

impl<'a> Binary<'a> {
    pub fn new(rest: &'a [u8], is_big_endian: bool) -> Self {
        Self { rest, is_big_endian }
    }

    /// The next bytes in little endian order.
    fn take<const N: usize>(&mut self) -> Result<[u8; N], Trouble> {
        let (&bytes, rest) = self.rest.split_first_chunk::<N>().ok_or(Trouble::End)?;
        self.rest = rest;
        let mut bytes = bytes;
        if self.is_big_endian {
            bytes.reverse();
        }
        Ok(bytes)
    }
}

impl Source for Binary<'_> {
    fn next(&mut self, kind: Kind) -> Result<f64, Trouble> {
        Ok(match kind {
            Kind::I8 => i8::from_le_bytes(self.take()?).into(),
            Kind::U8 => u8::from_le_bytes(self.take()?).into(),
            Kind::I16 => i16::from_le_bytes(self.take()?).into(),
            Kind::U16 => u16::from_le_bytes(self.take()?).into(),
            Kind::I32 => i32::from_le_bytes(self.take()?).into(),
            Kind::U32 => u32::from_le_bytes(self.take()?).into(),
            Kind::F32 => f32::from_le_bytes(self.take()?).into(),
            Kind::F64 => f64::from_le_bytes(self.take()?),
        })
    }
}
