//! Conversion of values to bytes and back: the only file that depends on the codec.
//!
//! The wire format is bincode 2's standard one.
//! The crate is unmaintained (RUSTSEC-2025-0141), but the format is simple enough to be
//! reimplemented if necessary; the tests hold golden bytes.
//! - Everything is little endian.
//! - `u8`, `i8` and `bool` take one byte.
//! - A wider unsigned integer below 251 takes one byte; others take a marker byte 251, 252 or 253,
//!   followed by 2, 4 or 8 bytes.
//! - Signed integers wider than a byte are zigzag-encoded as unsigned ones: 0, -1, 1, -2 become 0,
//!   1, 2, 3.
//! - Floats take 4 or 8 bytes.
//! - Sequences and strings start with their length, an option with 0 or 1, an enum with the number
//!   of its variant as `u32`.
//! - Structs and tuples are their fields in order, without names.

use serde::Serialize;
use serde::de::DeserializeOwned;
use thiserror::Error;

/// Maximum length of one encoded value in bytes.
pub(crate) const MAX_BYTES: usize = 1 << 26;

/// Limit on the bytes that bincode counts for one value.
///
/// bincode counts a variable-length integer at its full width, up to 16 bytes for one byte of
/// input, so the count of a valid value may be 16 times its encoded length.
/// It allocates memory for a string before it checks that the input is long enough; the limit
/// bounds how much a damaged length can allocate.
const MAX_COUNTED: usize = 16 * MAX_BYTES;

/// Why a value cannot be encoded or decoded.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum CodecError {
    /// The format cannot express the value: it has a sequence of unknown length, for example.
    #[error("value cannot be encoded: {0}")]
    Unencodable(String),
    /// The encoded value is too long.
    #[error("encoded value has {got} bytes, at most {max} are allowed")]
    TooLong {
        /// Length in bytes.
        got: usize,
        /// Maximum length in bytes.
        max: usize,
    },
    /// The bytes do not encode a value of the requested type.
    #[error("bytes do not encode a value of this type: {0}")]
    Malformed(String),
    /// Bytes follow the value.
    #[error("{left} bytes follow the value")]
    Trailing {
        /// Number of these bytes.
        left: usize,
    },
}

/// Encodes a value.
pub(crate) fn encode<T: Serialize + ?Sized>(value: &T) -> Result<Vec<u8>, CodecError> {
    let bytes = bincode::serde::encode_to_vec(value, bincode::config::standard())
        .map_err(|error| CodecError::Unencodable(error.to_string()))?;
    check_length(&bytes)?;
    Ok(bytes)
}

/// Decodes a value from all of `bytes`.
pub(crate) fn decode<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, CodecError> {
    check_length(bytes)?;
    let config = bincode::config::standard().with_limit::<MAX_COUNTED>();
    let (value, used) = bincode::serde::decode_from_slice(bytes, config)
        .map_err(|error| CodecError::Malformed(error.to_string()))?;
    if used < bytes.len() {
        return Err(CodecError::Trailing { left: bytes.len() - used });
    }
    Ok(value)
}

fn check_length(bytes: &[u8]) -> Result<(), CodecError> {
    if bytes.len() > MAX_BYTES {
        return Err(CodecError::TooLong { got: bytes.len(), max: MAX_BYTES });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::fmt::Debug;

    use proptest::prelude::*;
    use serde::Deserialize;

    use super::*;

    #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
    enum Shape {
        Point,
        Line(u16),
        Box { width: i8, height: i32 },
    }

    fn golden<T: Serialize + DeserializeOwned + PartialEq + Debug>(value: &T, bytes: &[u8]) {
        assert_eq!(encode(value).unwrap(), bytes, "{value:?}");
        assert_eq!(&decode::<T>(bytes).unwrap(), value);
    }

    #[test]
    fn golden_integers() {
        golden(&250_u64, &[250]);
        golden(&251_u64, &[251, 251, 0]);
        golden(&65_535_u64, &[251, 0xff, 0xff]);
        golden(&65_536_u64, &[252, 0, 0, 1, 0]);
        golden(&u64::from(u32::MAX), &[252, 0xff, 0xff, 0xff, 0xff]);
        golden(&(1_u64 << 32), &[253, 0, 0, 0, 0, 1, 0, 0, 0]);
        golden(&u64::MAX, &[253, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff]);
        golden(&300_u16, &[251, 44, 1]);
        golden(&255_u8, &[255]);
        golden(&-1_i8, &[255]);
        golden(&i8::MIN, &[128]);
        golden(&-1_i32, &[1]);
        golden(&1_i32, &[2]);
        golden(&-126_i32, &[251, 251, 0]);
        golden(&i32::MIN, &[252, 0xff, 0xff, 0xff, 0xff]);
    }

    #[test]
    fn golden_values() {
        golden(&vec![1_u32, 250, 251], &[3, 1, 250, 251, 251, 0]);
        golden(&vec![-1_i8, 2], &[2, 255, 2]);
        golden(&[1_u8, 2, 3], &[1, 2, 3]);
        golden(&"zé".to_owned(), &[3, b'z', 0xc3, 0xa9]);
        golden(&None::<u8>, &[0]);
        golden(&Some(7_u8), &[1, 7]);
        golden(&(true, 1.5_f32), &[1, 0, 0, 0xc0, 0x3f]);
        golden(&-2.0_f64, &[0, 0, 0, 0, 0, 0, 0, 0xc0]);
        golden(&Shape::Point, &[0]);
        golden(&Shape::Line(1000), &[1, 251, 232, 3]);
        golden(&Shape::Box { width: -3, height: -3 }, &[2, 253, 5]);
    }

    #[test]
    fn trailing_and_missing_bytes_are_refused() {
        assert_eq!(decode::<u8>(&[1, 2, 3]), Err(CodecError::Trailing { left: 2 }));
        assert!(matches!(decode::<u32>(&[251, 1]), Err(CodecError::Malformed(_))));
        assert!(matches!(decode::<bool>(&[2]), Err(CodecError::Malformed(_))));
        assert!(matches!(decode::<Shape>(&[3]), Err(CodecError::Malformed(_))));
    }

    #[test]
    fn lengths_beyond_the_limit_are_refused() {
        let huge = [253, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0x7f];
        assert!(matches!(decode::<String>(&huge), Err(CodecError::Malformed(_))));
        assert!(matches!(decode::<Vec<u64>>(&huge), Err(CodecError::Malformed(_))));
        let long = vec![0; MAX_BYTES + 1];
        let too_long = CodecError::TooLong { got: MAX_BYTES + 1, max: MAX_BYTES };
        assert_eq!(decode::<u8>(&long), Err(too_long.clone()));
        assert_eq!(encode(&String::from_utf8(long[5..].to_vec()).unwrap()), Err(too_long));
    }

    proptest! {
        #![proptest_config(ProptestConfig {
            failure_persistence: None,
            ..ProptestConfig::default()
        })]

        #[test]
        fn decode_undoes_encode(value: (u64, i64, Vec<Option<i16>>, String, Vec<u8>)) {
            type Value = (u64, i64, Vec<Option<i16>>, String, Vec<u8>);
            let bytes = encode(&value).unwrap();
            prop_assert_eq!(decode::<Value>(&bytes).unwrap(), value);
        }

        #[test]
        fn any_bytes_decode_or_are_refused(bytes: Vec<u8>) {
            let _ = decode::<Vec<(String, Option<u64>, i32)>>(&bytes);
        }
    }
}
