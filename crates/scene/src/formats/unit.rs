//! The length that the number 1 in a file stands for.

use std::str::FromStr;

/// A unit of length.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Unit {
    /// 1 m, glTF's unit.
    #[default]
    Metre,
    /// 0.01 m.
    Centimetre,
    /// 0.001 m.
    Millimetre,
    /// 0.0254 m.
    Inch,
    /// 0.3048 m.
    Foot,
    /// 1000 m.
    Kilometre,
    /// Any other, in metres; positive and finite.
    Metres(f64),
}

impl Unit {
    /// Its length in metres.
    pub fn metres(self) -> f64 {
        match self {
            Self::Metre => 1.0,
            Self::Centimetre => 0.01,
            Self::Millimetre => 0.001,
            Self::Inch => 0.0254,
            Self::Foot => 0.3048,
            Self::Kilometre => 1000.0,
            Self::Metres(length) => length,
        }
    }
}

impl FromStr for Unit {
    type Err = String;

    /// Reads `m`, `cm`, `mm`, `in`, `ft`, `km` or a number of metres.
    fn from_str(text: &str) -> Result<Self, String> {
        match text.trim() {
            "m" => Ok(Self::Metre),
            "cm" => Ok(Self::Centimetre),
            "mm" => Ok(Self::Millimetre),
            "in" => Ok(Self::Inch),
            "ft" => Ok(Self::Foot),
            "km" => Ok(Self::Kilometre),
            number => match number.parse::<f64>() {
                Ok(length) if length.is_finite() && length > 0.0 => Ok(Self::Metres(length)),
                _ => Err(format!(
                    "'{text}' is no unit of length; give m, cm, mm, in, ft, km or a positive number of metres"
                )),
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_read_by_name_and_number() {
        let metres = |text: &str| text.parse::<Unit>().map(Unit::metres);
        assert_eq!(metres("mm"), Ok(0.001));
        assert_eq!(metres("in"), Ok(0.0254));
        assert_eq!(metres("0.5"), Ok(0.5));
        for bad in ["", "-1", "0", "nan", "inf", "yard"] {
            assert!(metres(bad).is_err(), "{bad}");
        }
    }
}
