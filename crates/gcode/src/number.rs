//! Exact decimal numbers, as G-code contains them.

use std::fmt;
use std::str::FromStr;

use thiserror::Error;

/// A decimal number with six decimals: an integer number of millionths.
///
/// Slicers write three to five decimals, which this type holds exactly, so a number that is written
/// and read again stays the same; a binary fraction would be rounded.
/// The range is about ±9.2 · 10¹².
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Number(i64);

/// Why a text or a value is not a [`Number`].
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum NumberError {
    /// The text is not an optional sign, digits and at most one point.
    #[error("not a number")]
    Malformed,
    /// The value is not finite, or beyond ±9.2 · 10¹².
    #[error("too large")]
    TooLarge,
}

const DECIMALS: usize = 6;
const SCALE: i64 = 1_000_000;

/// Length of the longest number: sign, digits and point.
const MAX_LENGTH: usize = 21;

impl Number {
    /// Zero.
    pub const ZERO: Self = Self(0);

    /// The number of a count of millionths.
    pub const fn from_millionths(millionths: i64) -> Self {
        Self(millionths)
    }

    /// The value in millionths.
    pub const fn millionths(self) -> i64 {
        self.0
    }

    /// The number of an integer.
    pub const fn whole(value: i32) -> Self {
        Self(value as i64 * SCALE)
    }

    /// The nearest number with at most `decimals` decimals, 0 to 6; ties are rounded away from
    /// zero.
    pub fn from_f64(value: f64, decimals: u32) -> Result<Self, NumberError> {
        let fine = 10_i64.pow(decimals.min(DECIMALS as u32));
        let units = (value * fine as f64).round();
        // Beyond this limit the multiplication below would overflow.
        // The comparison is false for NaN, too.
        let limit = (i64::MAX / SCALE * fine) as f64;
        if units.abs() <= limit {
            Ok(Self(units as i64 * (SCALE / fine)))
        } else {
            Err(NumberError::TooLarge)
        }
    }

    /// The nearest floating-point number.
    pub fn to_f64(self) -> f64 {
        // Up to 2^53 millionths (9 · 10⁹) the conversion is exact, and only the division rounds.
        self.0 as f64 / SCALE as f64
    }

    /// Reads the number that a text begins with; also returns its length in bytes.
    /// Decimals beyond the sixth are rounded, ties away from zero.
    pub(crate) fn scan(text: &[u8]) -> Result<(Self, usize), NumberError> {
        let (negative, mut at) = match text.first() {
            Some(b'-') => (true, 1),
            Some(b'+') => (false, 1),
            _ => (false, 0),
        };
        // Accumulated as a negative number, because the range of i64 has one more of them.
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
            return Err(NumberError::Malformed);
        }
        let missing = DECIMALS.saturating_sub(decimals.unwrap_or(0)) as u32;
        below = below.checked_mul(10_i64.pow(missing)).ok_or(NumberError::TooLarge)?;
        let value = if negative { Some(below) } else { below.checked_neg() };
        Ok((Self(value.ok_or(NumberError::TooLarge)?), at))
    }

    /// Appends the shortest text that is read as this number: without trailing zeros, and without a
    /// point if there are no decimals.
    pub(crate) fn push_to(self, out: &mut String) {
        let mut text = [0; MAX_LENGTH];
        out.push_str(self.text(&mut text));
    }

    /// The shortest text, written from its end.
    /// Not done with the standard formatting, which would dominate the time of emitting a program.
    fn text(self, buffer: &mut [u8; MAX_LENGTH]) -> &str {
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
        f.write_str(self.text(&mut [0; MAX_LENGTH]))
    }
}

impl FromStr for Number {
    type Err = NumberError;

    fn from_str(text: &str) -> Result<Self, NumberError> {
        match Self::scan(text.as_bytes())? {
            (number, length) if length == text.len() => Ok(number),
            _ => Err(NumberError::Malformed),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn common_and_unusual_spellings() {
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
    fn texts_that_are_not_numbers() {
        for text in ["", "-", "+", ".", "-.", "1.2.3", "1,5", "1e5", "x", "--1", " 1", "1 ", "٣"] {
            assert_eq!(text.parse::<Number>(), Err(NumberError::Malformed), "{text}");
        }
        for text in ["9223372036854.775808", "-9223372036854.7758085", "99999999999999999999999999"]
        {
            assert_eq!(text.parse::<Number>(), Err(NumberError::TooLarge), "{text}");
        }
    }

    #[test]
    fn values_are_rounded_to_the_given_decimals() {
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
        #![proptest_config(ProptestConfig {
            cases: 4_000,
            failure_persistence: None,
            ..ProptestConfig::default()
        })]

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
                let (number, expected) = (number.to_f64(), text.parse::<f64>().unwrap());
                prop_assert!((number - expected).abs() <= 1e-6 * number.abs().max(1.0));
            }
        }
    }
}
