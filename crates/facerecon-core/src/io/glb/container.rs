//! The two chunks of a GLB file: the JSON description and the binary data.

use serde_json::Value;

use super::constants::{
    BINARY_CHUNK, CHUNK_HEADER_BYTES, HEADER_BYTES, JSON_CHUNK, MAGIC, VERSION,
};
use crate::io::error::Fault;

/// The parsed chunks of a GLB file.
pub(super) struct Container<'a> {
    pub(super) root: &'a Value,
    pub(super) binary: &'a [u8],
}

impl<'a> Container<'a> {
    /// The bytes of a buffer view; `None` outside the binary chunk.
    pub(super) fn view(&self, view: &Value) -> Option<&'a [u8]> {
        if number(&view["buffer"]) != Some(0) {
            return None;
        }
        let start = number(&view["byteOffset"]).unwrap_or(0);
        let length = number(&view["byteLength"])?;
        self.binary.get(start..start.checked_add(length)?)
    }
}

/// The JSON and the binary chunk.
pub(super) fn chunks(bytes: &[u8]) -> Result<(&[u8], &[u8]), Fault> {
    let word = |at: usize| {
        let four = bytes.get(at..at + 4).and_then(|b| <[u8; 4]>::try_from(b).ok());
        four.map(u32::from_le_bytes)
    };
    if !bytes.starts_with(MAGIC) {
        return Err(Fault::new("this is not a GLB; it does not begin with \"glTF\""));
    }
    if word(4) != Some(VERSION) {
        let found = word(4).unwrap_or(0);
        return Err(Fault::new(format!("the GLB has version {found}; version {VERSION} is read")));
    }
    let mut parts: [&[u8]; 2] = [&[], &[]];
    let mut at = HEADER_BYTES;
    while let (Some(length), Some(kind)) = (word(at), word(at + 4)) {
        let start = at + CHUNK_HEADER_BYTES;
        let end = start.checked_add(length as usize);
        let data = end.and_then(|end| bytes.get(start..end)).ok_or_else(|| {
            Fault::new(format!("the GLB is truncated: a chunk of {length} bytes is incomplete"))
        })?;
        match &kind.to_le_bytes() {
            JSON_CHUNK => parts[0] = data,
            BINARY_CHUNK => parts[1] = data,
            _ => {}
        }
        at = start + data.len();
    }
    Ok((parts[0], parts[1]))
}

/// The entries of an array; none where there is no such array.
pub(super) fn list<'a>(value: &'a Value, name: &str) -> &'a [Value] {
    value[name].as_array().map_or(&[], Vec::as_slice)
}

/// A whole number that is not negative.
pub(super) fn number(value: &Value) -> Option<usize> {
    value.as_u64().and_then(|n| usize::try_from(n).ok())
}
