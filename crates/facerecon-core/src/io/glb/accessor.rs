//! Accessors: rows of numbers in the binary chunk.

use serde_json::Value;

use super::constants::{BYTE, FLOAT, SHORT, UNSIGNED_BYTE, UNSIGNED_INT, UNSIGNED_SHORT};
use super::container::{Container, list, number};
use crate::io::error::Fault;

/// Rows of `width` numbers.
pub(super) struct Rows {
    pub(super) values: Vec<f64>,
    pub(super) width: usize,
}

/// Reads an accessor with at least `least` numbers in a row; `what` names it in errors.
pub(super) fn rows(
    file: &Container<'_>,
    accessor: &Value,
    least: usize,
    what: &str,
) -> Result<Rows, Fault> {
    let fault = |message: String| Fault::new(format!("the GLB's {what}: {message}"));
    let accessor = number(accessor)
        .and_then(|i| list(file.root, "accessors").get(i))
        .ok_or_else(|| fault("the accessor does not exist".into()))?;
    let layout = Layout::of(accessor).map_err(fault)?;
    if layout.width < least || !accessor["sparse"].is_null() {
        return Err(fault(format!(
            "rows of {} numbers, or sparse ones, are not supported",
            layout.width
        )));
    }
    let view = number(&accessor["bufferView"])
        .and_then(|i| list(file.root, "bufferViews").get(i))
        .ok_or_else(|| fault("the buffer view does not exist".into()))?;
    let data =
        file.view(view).ok_or_else(|| fault("the buffer view is beyond the file's end".into()))?;
    let data = number(&accessor["byteOffset"]).map_or(Some(data), |at| data.get(at..));
    let stride = number(&view["byteStride"]).unwrap_or(layout.row_bytes());
    let count = number(&accessor["count"]).unwrap_or(0);
    let short = || fault(format!("{count} rows do not fit into the buffer"));
    let data = data.filter(|d| layout.fits(count, stride, d.len())).ok_or_else(short)?;
    let mut values = Vec::with_capacity(count * layout.width);
    for row in 0..count {
        for column in 0..layout.width {
            let at = row * stride + column * layout.size;
            let value = layout.value(&data[at..at + layout.size]);
            if !value.is_finite() {
                return Err(fault(format!("row {row} has {value}; a finite number is expected")));
            }
            values.push(value);
        }
    }
    Ok(Rows { values, width: layout.width })
}

/// How the rows of an accessor are stored.
struct Layout {
    /// Numbers in a row.
    width: usize,
    component: u32,
    /// Bytes of a number.
    size: usize,
    /// Stored value of 1.
    scale: f64,
}

impl Layout {
    fn of(accessor: &Value) -> Result<Self, String> {
        let width = match accessor["type"].as_str() {
            Some("SCALAR") => 1,
            Some("VEC2") => 2,
            Some("VEC3") => 3,
            Some("VEC4") => 4,
            other => return Err(format!("unknown type {other:?}")),
        };
        let component = number(&accessor["componentType"]).and_then(|c| u32::try_from(c).ok());
        let component = component.unwrap_or(0);
        let (size, largest) = match component {
            BYTE => (1, 127.0),
            UNSIGNED_BYTE => (1, 255.0),
            SHORT => (2, 32767.0),
            UNSIGNED_SHORT => (2, 65535.0),
            UNSIGNED_INT | FLOAT => (4, 1.0),
            other => return Err(format!("unknown component type {other}")),
        };
        let normalized = accessor["normalized"].as_bool() == Some(true);
        Ok(Self { width, component, size, scale: if normalized { largest } else { 1.0 } })
    }

    fn row_bytes(&self) -> usize {
        self.width * self.size
    }

    /// Whether `count` rows, `stride` bytes apart, fit into a buffer.
    fn fits(&self, count: usize, stride: usize, bytes: usize) -> bool {
        let needed = count.checked_sub(1).map_or(Some(0), |last| {
            last.checked_mul(stride).and_then(|n| n.checked_add(self.row_bytes()))
        });
        needed.is_some_and(|n| n <= bytes) && stride >= self.row_bytes()
    }

    fn value(&self, bytes: &[u8]) -> f64 {
        let stored = match (self.component, bytes) {
            (BYTE, &[a]) => f64::from(a as i8),
            (UNSIGNED_BYTE, &[a]) => f64::from(a),
            (SHORT, &[a, b]) => f64::from(i16::from_le_bytes([a, b])),
            (UNSIGNED_SHORT, &[a, b]) => f64::from(u16::from_le_bytes([a, b])),
            (UNSIGNED_INT, &[a, b, c, d]) => f64::from(u32::from_le_bytes([a, b, c, d])),
            (FLOAT, &[a, b, c, d]) => f64::from(f32::from_le_bytes([a, b, c, d])),
            _ => f64::NAN,
        };
        stored / self.scale
    }
}
