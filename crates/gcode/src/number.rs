//! Decimal numbers as G-code writes them, kept exactly.

use std::fmt;
use std::str::FromStr;

use thiserror::Error;

/// A decimal number in millionths.
///
/// Printers and slicers write three to five decimals; whole millionths hold them exactly, so that a
/// number which is written and read again is the same number, whatever a binary fraction would make
/// of it.
/// The range is about ±9.2 million millions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Number(i64);

/// Why a text or a value is no [`Number`].
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum NumberError {
    /// It is not a sign, digits and at most one point.
    #[error("is not a number")]
    Junk,
    /// It is not finite, or beyond ±9.2 million millions.
    #[error("is too large")]
    TooLarge,
}

const DECIMALS: usize = 6;
const SCALE: i64 = 1_000_000;

/// Digits, point and sign of the longest number.
const LONGEST: usize = 21;

impl Number {
    /// Nothing.
    pub const ZERO: Self = Self(0);

    /// The number of so many millionths.
    pub const fn from_millionths(millionths: i64) -> Self {
        Self(millionths)
    }

    /// How many millionths it is.
    pub const fn millionths(self) -> i64 {
        self.0
    }

    /// A whole number.
    pub const fn whole(value: i32) -> Self {
        Self(value as i64 * SCALE)
    }

    /// The nearest number of at most `decimals` decimals, 0 to 6; halves are rounded away from
    /// zero.
    pub fn from_f64(value: f64, decimals: u32) -> Result<Self, NumberError> {
        let fine = 10_i64.pow(decimals.min(DECIMALS as u32));
        let units = (value * fine as f64).round();
        // Casts saturate: the bound keeps what follows from overflowing, and turns away what is not
        // a number.
        let limit = (i64::MAX / SCALE * fine) as f64;
        if units.abs() <= limit {
            Ok(Self(units as i64 * (SCALE / fine)))
        } else {
            Err(NumberError::TooLarge)
        }
    }

    /// The nearest binary fraction.
    pub fn to_f64(self) -> f64 {
        // Numbers of usual size are exact in millionths, so this rounds once.
        self.0 as f64 / SCALE as f64
    }

    /// The number at the beginning of a text, and how many bytes it takes.
    /// Decimals beyond the sixth are rounded, halves away from zero.
    pub(super) fn scan(text: &[u8]) -> Result<(Self, usize), NumberError> {
        let (negative, mut at) = match text.first() {
            Some(b'-') => (true, 1),
            Some(b'+') => (false, 1),
            _ => (false, 0),
        };
        // Counted downwards, for there is one more number below zero than above.
        let mut below = 0_i64;
        let mut digits = 0;
        let mut decimals = None;
        while let Some(&byte) = text.get(at) {
            match byte {
                b'0'..=b'9' => {
                    let digit = i64::from(byte - b'0');
                    digits += 1;
                    let kept = decimals.is_none_or(|count| count < DECIMALS);
                    if kept {
                        below = below
                            .checked_mul(10)
                            .and_then(|value| value.checked_sub(digit))
                            .ok_or(NumberError::TooLarge)?;
                    } else if decimals == Some(DECIMALS) && digit >= 5 {
                        below = below.checked_sub(1).ok_or(NumberError::TooLarge)?;
                    }
                    decimals = decimals.map(|count: usize| count + 1);
                }
                b'.' if decimals.is_none() => decimals = Some(0),
                _ => break,
            }
            at += 1;
        }
        if digits == 0 {
            return Err(NumberError::Junk);
        }
        let missing = DECIMALS.saturating_sub(decimals.unwrap_or(0)) as u32;
        below = below.checked_mul(10_i64.pow(missing)).ok_or(NumberError::TooLarge)?;
        let value = if negative { Some(below) } else { below.checked_neg() };
        Ok((Self(value.ok_or(NumberError::TooLarge)?), at))
    }

    /// Appends the shortest text that reads as this number: no zeros at the end, no point without
    /// decimals.
    pub(super) fn push_to(self, out: &mut String) {
        let mut text = [0; LONGEST];
        out.push_str(self.text(&mut text));
    }

    /// The shortest text, written from its end: formatting through the general machinery would take
    /// most of the time of writing a file.
    fn text(self, buffer: &mut [u8; LONGEST]) -> &str {
        let scale = SCALE.unsigned_abs();
        let (mut whole, mut decimals) =
            (self.0.unsigned_abs() / scale, self.0.unsigned_abs() % scale);
        let mut at = buffer.len();
        if decimals > 0 {
            let mut count = DECIMALS;
            while decimals.is_multiple_of(10) {
                decimals /= 10;
                count -= 1;
            }
            for _ in 0..count {
                at -= 1;
                buffer[at] = b'0' + (decimals % 10) as u8;
                decimals /= 10;
            }
            at -= 1;
            buffer[at] = b'.';
        }
        loop {
            at -= 1;
            buffer[at] = b'0' + (whole % 10) as u8;
            whole /= 10;
            if whole == 0 {
                break;
            }
        }
        if self.0 < 0 {
            at -= 1;
            buffer[at] = b'-';
        }
        std::str::from_utf8(&buffer[at..]).expect("digits are ASCII")
    }
}

impl fmt::Display for Number {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.text(&mut [0; LONGEST]))
    }
}

impl FromStr for Number {
    type Err = NumberError;

    fn from_str(text: &str) -> Result<Self, NumberError> {
        match Self::scan(text.as_bytes())? {
            (number, length) if length == text.len() => Ok(number),
            _ => Err(NumberError::Junk),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn usual_and_odd_spellings() {
        for (text, millionths, shortest) in [
            ("1", 1_000_000, "1"),
            ("-.5", -500_000, "-0.5"),
            ("+3.", 3_000_000, "3"),
            ("1.23456", 1_234_560, "1.23456"),
            ("007.10", 7_100_000, "7.1"),
            ("-0", 0, "0"),
            ("0.0000005", 1, "0.000001"),
            ("-0.0000005", -1, "-0.000001"),
            ("0.00000049999999999999999999999", 0, "0"),
            ("9223372036854.775807", i64::MAX, "9223372036854.775807"),
            ("-9223372036854.775808", i64::MIN, "-9223372036854.775808"),
        ] {
            let number: Number = text.parse().unwrap();
            assert_eq!(
                (number.millionths(), number.to_string().as_str()),
                (millionths, shortest),
                "{text}"
            );
        }
    }

    #[test]
    fn what_is_no_number() {
        for text in ["", "-", "+", ".", "-.", "1.2.3", "1,5", "1e5", "x", "--1", " 1", "1 ", "٣"] {
            assert_eq!(text.parse::<Number>(), Err(NumberError::Junk), "{text}");
        }
        for text in ["9223372036854.775808", "-9223372036854.7758085", "99999999999999999999999999"]
        {
            assert_eq!(text.parse::<Number>(), Err(NumberError::TooLarge), "{text}");
        }
    }

    #[test]
    fn fractions_are_rounded_to_the_decimals_asked() {
        let text =
            |value, decimals| Number::from_f64(value, decimals).map(|number| number.to_string());
        assert_eq!(text(1.23456, 3), Ok("1.235".to_owned()));
        assert_eq!(text(-0.0005, 3), Ok("-0.001".to_owned()));
        assert_eq!(text(0.1 + 0.2, 5), Ok("0.3".to_owned()));
        assert_eq!(text(2.5, 0), Ok("3".to_owned()));
        for value in [f64::NAN, f64::INFINITY, -1e30, 1e13] {
            assert_eq!(Number::from_f64(value, 5), Err(NumberError::TooLarge));
        }
        assert_eq!(Number::whole(-7).to_f64().to_bits(), (-7.0_f64).to_bits());
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 4_000, failure_persistence: None, ..ProptestConfig::default() })]

        #[test]
        fn a_written_number_reads_as_itself(millionths: i64, small in -2_000_000_i64..2_000_000) {
            for number in [Number(millionths), Number(small)] {
                let text = number.to_string();
                prop_assert!(!text.contains('.') || !text.ends_with(['0', '.']));
                prop_assert_eq!(text.parse(), Ok(number));
                prop_assert_eq!(Number::from_f64(Number(small).to_f64(), 6), Ok(Number(small)));
            }
        }

        #[test]
        fn any_text_is_a_number_or_an_error(text in "[-+.0-9eE ,]{0,30}") {
            if let Ok(number) = text.parse::<Number>() {
                prop_assert!((number.to_f64() - text.parse::<f64>().unwrap()).abs() <= 1e-6 * number.to_f64().abs().max(1.0));
            }
        }
    }
}
