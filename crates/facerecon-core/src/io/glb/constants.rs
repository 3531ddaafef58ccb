//! Numbers and chunk names of the glTF 2.0 specification.

pub(super) const MAGIC: &[u8; 4] = b"glTF";
pub(super) const VERSION: u32 = 2;
pub(super) const JSON_CHUNK: &[u8; 4] = b"JSON";
pub(super) const BINARY_CHUNK: &[u8; 4] = b"BIN\0";
/// Bytes of the file header: magic, version, length of the file.
pub(super) const HEADER_BYTES: usize = 12;
/// Bytes of a chunk header: length, name.
pub(super) const CHUNK_HEADER_BYTES: usize = 8;

// Component types of accessors.
pub(super) const BYTE: u32 = 5120;
pub(super) const UNSIGNED_BYTE: u32 = 5121;
pub(super) const SHORT: u32 = 5122;
pub(super) const UNSIGNED_SHORT: u32 = 5123;
pub(super) const UNSIGNED_INT: u32 = 5125;
pub(super) const FLOAT: u32 = 5126;

// Targets of buffer views.
pub(super) const ARRAY_BUFFER: u32 = 34962;
pub(super) const ELEMENT_ARRAY_BUFFER: u32 = 34963;

/// Mode of a primitive: separate triangles.
pub(super) const TRIANGLES: usize = 4;

// Filters and wrap mode of samplers.
pub(super) const LINEAR: u32 = 9729;
pub(super) const LINEAR_MIPMAP_LINEAR: u32 = 9987;
pub(super) const CLAMP_TO_EDGE: u32 = 33071;

/// glTF is in metres, meshes in millimetres.
pub(super) const METRES_PER_MM: f64 = 0.001;
pub(super) const MM_PER_METRE: f64 = 1000.0;

// Custom vertex attributes; glTF requires that their names begin with an underscore.
/// Standard deviation of a vertex along its normal, mm (not scaled by the node).
pub(super) const SIGMA_ATTRIBUTE: &str = "_SIGMA_MM";
/// 1 where measured points support the vertex, else 0.
pub(super) const MEASURED_ATTRIBUTE: &str = "_MEASURED";
