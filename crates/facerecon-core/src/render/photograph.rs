//! The textured mesh as a camera photographs it.

use super::error::{LARGEST_SIDE, RenderError};
use super::light::{linear_table, to_rgb};
use super::surface::{SAMPLES, Sample, surface_color};
use super::zbuffer::{rasterize, supersampled};
use crate::camera::Pinhole;
use crate::data::{Mesh, Raster, Rgb};
use crate::math::{Similarity, Vec3};

/// The textured mesh as a given camera would photograph it, without further light; the second raster
/// is the fraction of each pixel that shows the mesh (0 to 1). For comparing a texture with a photo.
///
/// # Errors
/// [`RenderError`] for an invalid mesh, size or camera.
pub fn photograph(
    mesh: &Mesh,
    texture: Option<&Rgb>,
    camera: &Pinhole,
    camera_from_mesh: &Similarity,
    (width, height): (usize, usize),
) -> Result<(Rgb, Raster<f32>), RenderError> {
    if width == 0 || height == 0 || width.max(height) > LARGEST_SIDE / SAMPLES {
        return Err(RenderError::Size { width, height });
    }
    let fine = supersampled(camera, SAMPLES);
    let buffers = rasterize(mesh, &fine, camera_from_mesh, (width * SAMPLES, height * SAMPLES))?;
    let linear = linear_table();
    let pixels = Raster::par_from_fn(width, height, |x, y| {
        let (mut sum, mut count) = (Vec3::zeros(), 0.0);
        for sy in y * SAMPLES..(y + 1) * SAMPLES {
            for sx in x * SAMPLES..(x + 1) * SAMPLES {
                let Some(sample) = Sample::at(&buffers, sx, sy) else { continue };
                sum += surface_color(mesh, texture, &sample, &linear);
                count += 1.0;
            }
        }
        let share = count / (SAMPLES * SAMPLES) as f64;
        (to_rgb(&(sum / f64::max(count, 1.0))), share as f32)
    });
    Ok(pixels.unzip())
}
