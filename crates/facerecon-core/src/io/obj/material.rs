//! Material files and the texture they name.

use std::io::Cursor;
use std::path::Path;

use super::parse::Parsed;
use crate::data::Rgb;
use crate::io::image::read_rgb;
use crate::io::source::{decode_text, find_beside, read_bytes};

/// Longest material file, MB: thousands of materials.
const MAX_FILE_MB: u64 = 16;

/// The texture of most of the triangles; missing files and other textures give warnings.
pub(super) fn texture(parsed: &Parsed, folder: &Path, warnings: &mut Vec<String>) -> Option<Rgb> {
    let mut images = Vec::new();
    for library in &parsed.libraries {
        // A name may contain blanks, and one statement may name several files.
        let whole = find_beside(folder, library);
        let paths = match whole {
            Some(path) => vec![path],
            None => {
                library.split_whitespace().filter_map(|word| find_beside(folder, word)).collect()
            }
        };
        if paths.is_empty() {
            warnings
                .push(format!("the material file {library} does not exist; no texture is read"));
        }
        for path in paths {
            match read_bytes(&path, "material file", MAX_FILE_MB) {
                Ok(bytes) => images.extend(parse_materials(&bytes)),
                Err(e) => warnings.push(e.to_string()),
            }
        }
    }
    let covered = |name: &str| {
        parsed.materials.iter().find(|(n, _)| n == name).map_or(0, |(_, faces)| *faces)
    };
    // By image: several materials may share one.
    let mut totals: Vec<(String, usize)> = Vec::new();
    for (material, image) in images {
        let faces = covered(&material);
        match totals.iter_mut().find(|(i, _)| *i == image) {
            Some((_, total)) => *total += faces,
            None => totals.push((image, faces)),
        }
    }
    let used = totals.iter().filter(|(_, faces)| *faces > 0).count();
    // The first of those with most triangles.
    let (image, _) = totals.iter().rev().max_by_key(|(_, faces)| *faces)?;
    if used > 1 {
        warnings.push(format!("the mesh has {used} textures; only {image} is read"));
    }
    let Some(path) = find_beside(folder, image) else {
        warnings.push(format!("the texture {image} does not exist"));
        return None;
    };
    read_rgb(&path).map_err(|e| warnings.push(format!("the texture is not read: {e}"))).ok()
}

/// `(material, image)` of every material with a colour image.
pub(super) fn parse_materials(bytes: &[u8]) -> Vec<(String, String)> {
    // `tobj` panics on a malformed colour and rejects other lines: it gets only the lines needed.
    let mut clean = String::new();
    for line in decode_text(bytes).lines() {
        let line = line.trim().split(" #").next().unwrap_or_default().trim_end();
        let (keyword, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
        let name = match keyword.to_lowercase().as_str() {
            "newmtl" => rest.trim().to_owned(),
            "map_kd" => without_options(rest),
            _ => continue,
        };
        if !name.is_empty() {
            let key = if keyword.eq_ignore_ascii_case("newmtl") { "newmtl" } else { "map_Kd" };
            clean += &format!("{key} {name}\n");
        }
    }
    let Ok((materials, _)) = tobj::load_mtl_buf(&mut Cursor::new(clean)) else {
        return Vec::new();
    };
    materials.into_iter().filter_map(|m| Some((m.name, m.diffuse_texture?))).collect()
}

/// The file name of a map statement, which may contain blanks, after options such as `-s 1 1 1`.
fn without_options(rest: &str) -> String {
    let mut words = rest.split_whitespace().peekable();
    while words.next_if(|w| w.starts_with('-') && w.parse::<f64>().is_err()).is_some() {
        while words.next_if(|w| w.parse::<f64>().is_ok() || matches!(*w, "on" | "off")).is_some() {}
    }
    words.collect::<Vec<_>>().join(" ").trim_matches('"').replace('\\', "/")
}
