//! Images: PNG, JPEG and GIF are read, PNG and JPEG written.

use std::io::Cursor;
use std::path::Path;

use ::image::codecs::jpeg::JpegEncoder;
use ::image::codecs::png::{CompressionType, FilterType, PngEncoder};
use ::image::metadata::Orientation;
use ::image::{
    DynamicImage, ExtendedColorType, ImageDecoder, ImageEncoder, ImageFormat, ImageReader, Limits,
};

use super::atomic;
use super::error::{Fault, IoError};
use super::source::read_bytes;
use crate::data::{Gray, Photo, Raster, Rgb};

/// Largest number of columns or rows: beyond any camera, and far below 32-bit overflow.
const MAX_SIDE: u32 = 20_000;
/// Largest number of pixels, millions. A photo takes 7 bytes per pixel (RGB and 32-bit grey), and
/// its decoding up to [`DECODER_BYTES_PER_PIXEL`] more: about 1 GB at this limit.
const MAX_MEGAPIXELS: u64 = 60;
/// Bytes per pixel of a decoded image: four channels of 16 bit.
const DECODER_BYTES_PER_PIXEL: u64 = 8;
/// Working memory of the decoder besides the pixels, bytes.
const DECODER_EXTRA_BYTES: u64 = 64 << 20;
/// Longest image file, MB: above an uncompressed 16-bit image of the largest size.
const MAX_FILE_MB: u64 = 512;

/// Reads a photo: PNG, JPEG or GIF by content (the file name extension does not matter), 8 or 16
/// bit, grey, palette or colour. The EXIF orientation is applied. Transparent pixels are composited
/// on black, the background of the projected pattern. 16-bit photos keep their fractions in `gray`;
/// `rgb` is rounded to 8 bit.
///
/// # Errors
/// [`IoError::Read`], [`IoError::TooLong`], [`IoError::ImageSize`] before anything of that size is
/// allocated, or [`IoError::Malformed`].
pub fn read_photo(path: &Path) -> Result<Photo, IoError> {
    let bytes = read_bytes(path, "image", MAX_FILE_MB)?;
    decode_photo(&bytes).map_err(|e| e.in_file(path))
}

/// Reads an image as 8-bit colour; see [`read_photo`].
///
/// # Errors
/// As [`read_photo`].
pub fn read_rgb(path: &Path) -> Result<Rgb, IoError> {
    read_photo(path).map(|photo| photo.rgb)
}

/// Why bytes cannot be read as an image.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum ImageFault {
    /// Malformed, or of another format.
    Content(Fault),
    /// Above the size limit.
    Size {
        /// Columns.
        width: u32,
        /// Rows.
        height: u32,
    },
}

impl ImageFault {
    /// The error for a file.
    fn in_file(self, path: &Path) -> IoError {
        match self {
            Self::Content(fault) => fault.in_file(path),
            Self::Size { width, height } => IoError::ImageSize {
                path: path.to_owned(),
                width,
                height,
                max_side: MAX_SIDE,
                max_megapixels: MAX_MEGAPIXELS,
            },
        }
    }

    /// The fault of an image inside another file.
    pub(super) fn into_fault(self) -> Fault {
        match self {
            Self::Content(fault) => fault,
            Self::Size { width, height } => Fault::new(format!(
                "{width}x{height} pixels are above the limit of {MAX_MEGAPIXELS} megapixels"
            )),
        }
    }
}

/// Decodes a photo from the bytes of a file; see [`read_photo`].
///
/// # Errors
/// [`ImageFault`] with what was found.
pub(super) fn decode_photo(bytes: &[u8]) -> Result<Photo, ImageFault> {
    let content = |message: String| ImageFault::Content(Fault::new(message));
    let broken = |e: ::image::ImageError| {
        content(format!("the image cannot be decoded ({e}); save it again as PNG"))
    };
    let format = known_format(bytes).map_err(ImageFault::Content)?;
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    let mut limits = Limits::default();
    limits.max_image_width = Some(MAX_SIDE);
    limits.max_image_height = Some(MAX_SIDE);
    limits.max_alloc =
        Some(MAX_MEGAPIXELS * 1_000_000 * DECODER_BYTES_PER_PIXEL + DECODER_EXTRA_BYTES);
    // The decoder's own size error does not give the size: it is checked here first.
    reader.limits({
        let mut any_size = limits.clone();
        any_size.max_image_width = None;
        any_size.max_image_height = None;
        any_size
    });
    let mut decoder = reader.into_decoder().map_err(broken)?;
    let (width, height) = decoder.dimensions();
    let too_many = u64::from(width) * u64::from(height) > MAX_MEGAPIXELS * 1_000_000;
    if width > MAX_SIDE || height > MAX_SIDE || too_many {
        return Err(ImageFault::Size { width, height });
    }
    if width == 0 || height == 0 {
        return Err(content(format!("the image is {width}x{height} pixels; it is empty")));
    }
    decoder.set_limits(limits).map_err(broken)?;
    let orientation = decoder.orientation().unwrap_or(Orientation::NoTransforms);
    let mut image = DynamicImage::from_decoder(decoder).map_err(broken)?;
    image.apply_orientation(orientation);
    to_photo(image).ok_or_else(|| content("the image's size does not fit its data".into()))
}

fn known_format(bytes: &[u8]) -> Result<ImageFormat, Fault> {
    match ::image::guess_format(bytes) {
        Ok(f @ (ImageFormat::Png | ImageFormat::Jpeg | ImageFormat::Gif)) => Ok(f),
        Ok(other) => Err(Fault::new(format!(
            "this is a {other:?} image; PNG, JPEG and GIF are read: convert it to PNG"
        ))),
        Err(_) => {
            let found = match bytes {
                [] => "the file is empty".to_owned(),
                [b'I', b'I', ..] | [b'M', b'M', ..] => "this is a TIFF or raw photo".to_owned(),
                [_, _, _, _, b'f', b't', b'y', b'p', ..] => {
                    "this is a HEIC photo or a video".into()
                }
                _ => "this is not an image".to_owned(),
            };
            Err(Fault::new(format!("{found}; PNG, JPEG and GIF are read: convert it to PNG")))
        }
    }
}

fn to_photo(image: DynamicImage) -> Option<Photo> {
    let (width, height) = (image.width() as usize, image.height() as usize);
    let deep = matches!(
        image,
        DynamicImage::ImageLuma16(_)
            | DynamicImage::ImageLumaA16(_)
            | DynamicImage::ImageRgb16(_)
            | DynamicImage::ImageRgba16(_)
    );
    if deep {
        let pixels = image.into_rgba16();
        let mut rgb = Vec::with_capacity(width * height);
        let mut gray = Vec::with_capacity(width * height);
        for &::image::Rgba([r, g, b, a]) in pixels.pixels() {
            // Alpha over black, and from 16 bit to 0..255: 65535 / 255 = 257 exactly.
            let scale = f32::from(a) / (65535.0 * 257.0);
            let c = [r, g, b].map(|v| f32::from(v) * scale);
            gray.push(0.299 * c[0] + 0.587 * c[1] + 0.114 * c[2]);
            rgb.push(c.map(|v| v.round() as u8));
        }
        let rgb = Raster::from_vec(width, height, rgb)?;
        return Some(Photo { rgb, gray: Raster::from_vec(width, height, gray)? });
    }
    let rgb: Vec<[u8; 3]> = if image.color().has_alpha() {
        let over_black = |v: u8, a: u8| ((u32::from(v) * u32::from(a) + 127) / 255) as u8;
        let pixels = image.into_rgba8();
        pixels.pixels().map(|p| [0, 1, 2].map(|c| over_black(p.0[c], p.0[3]))).collect()
    } else {
        image.into_rgb8().pixels().map(|p| p.0).collect()
    };
    Some(Photo::from_rgb(Raster::from_vec(width, height, rgb)?))
}

/// An image that can be written as PNG.
pub trait PngImage {
    /// Width, height, 8-bit samples row by row, and their kind.
    fn samples(&self) -> (usize, usize, Vec<u8>, ExtendedColorType);
}

impl PngImage for Rgb {
    fn samples(&self) -> (usize, usize, Vec<u8>, ExtendedColorType) {
        (self.width(), self.height(), self.data().as_flattened().to_vec(), ExtendedColorType::Rgb8)
    }
}

impl PngImage for Raster<u8> {
    fn samples(&self) -> (usize, usize, Vec<u8>, ExtendedColorType) {
        (self.width(), self.height(), self.data().to_vec(), ExtendedColorType::L8)
    }
}

impl PngImage for Gray {
    fn samples(&self) -> (usize, usize, Vec<u8>, ExtendedColorType) {
        self.to_u8().samples()
    }
}

/// The bytes of a PNG file, the same for the same image; grey values are rounded and clipped to
/// 8 bit.
///
/// # Errors
/// [`Fault`] for an image without pixels.
pub fn encode_png(image: &impl PngImage) -> Result<Vec<u8>, Fault> {
    let (width, height, samples, kind) = image.samples();
    let fail = || Fault::new(format!("an image of {width}x{height} pixels cannot be a PNG"));
    let (w, h) = (u32::try_from(width), u32::try_from(height));
    let (Ok(w @ 1..), Ok(h @ 1..)) = (w, h) else { return Err(fail()) };
    let mut out = Vec::new();
    // Adaptive filtering takes twice the time and does not make photographs smaller.
    PngEncoder::new_with_quality(&mut out, CompressionType::Fast, FilterType::Paeth)
        .write_image(&samples, w, h, kind)
        .map_err(|_| fail())?;
    Ok(out)
}

/// The bytes of a JPEG file of quality 1 to 100, for display: much smaller than PNG, but lossy.
///
/// # Errors
/// [`Fault`] for an image without pixels, or too large for JPEG.
pub fn encode_jpeg(image: &Rgb, quality: u8) -> Result<Vec<u8>, Fault> {
    let (width, height, samples, kind) = image.samples();
    let fail = || Fault::new(format!("an image of {width}x{height} pixels cannot be a JPEG"));
    let (Ok(w @ 1..), Ok(h @ 1..)) = (u32::try_from(width), u32::try_from(height)) else {
        return Err(fail());
    };
    let mut out = Vec::new();
    JpegEncoder::new_with_quality(&mut out, quality)
        .write_image(&samples, w, h, kind)
        .map_err(|_| fail())?;
    Ok(out)
}

/// Writes a PNG atomically.
///
/// # Errors
/// [`IoError::Write`], or [`IoError::Malformed`] for an image without pixels.
pub fn write_png(path: &Path, image: &impl PngImage) -> Result<(), IoError> {
    atomic::write(path, &encode_png(image).map_err(|f| f.in_file(path))?)
}

#[cfg(test)]
mod tests;
