//! Photographs and pictures: PNG, JPEG and GIF in, PNG out.

use std::io::Cursor;
use std::path::Path;

use ::image::codecs::jpeg::JpegEncoder;
use ::image::codecs::png::{CompressionType, FilterType, PngEncoder};
use ::image::metadata::Orientation;
use ::image::{
    DynamicImage, ExtendedColorType, ImageDecoder, ImageEncoder, ImageFormat, ImageReader, Limits,
};

use super::source::read_bytes;
use super::{Fault, IoError, atomic};
use crate::data::{Gray, Photo, Raster, Rgb};

/// Most columns or rows.
const MAX_SIDE: u32 = 20_000;
/// Most pixels, millions: a photo takes 7 bytes a pixel, and its decoding up to 8 more.
const MAX_MEGAPIXELS: u64 = 60;
/// Longest image file, MB.
const MAX_FILE_MB: u64 = 512;

/// Reads a photo: PNG, JPEG or GIF by content (the ending does not matter), 8 or 16 bit, grey,
/// palette or colour, turned upright by its EXIF orientation. Transparent pixels are composited on
/// black, which is what a cut-out photo shows where nothing was measured. 16-bit photos keep their
/// fractions in `gray`.
///
/// # Errors
/// [`IoError::Read`], [`IoError::TooLong`], [`IoError::ImageSize`] before anything of that size is
/// allocated, or [`IoError::Malformed`].
pub fn read_photo(path: &Path) -> Result<Photo, IoError> {
    let bytes = read_bytes(path, "picture", MAX_FILE_MB)?;
    decode_photo(&bytes).map_err(|e| e.in_file(path))
}

/// Reads a picture as 8-bit colour; see [`read_photo`].
///
/// # Errors
/// As [`read_photo`].
pub fn read_rgb(path: &Path) -> Result<Rgb, IoError> {
    read_photo(path).map(|photo| photo.rgb)
}

/// Why bytes are no picture.
#[derive(Clone, Debug, PartialEq)]
pub enum ImageFault {
    /// Not understood.
    Content(Fault),
    /// Too large to hold.
    Size {
        /// Columns.
        width: u32,
        /// Rows.
        height: u32,
    },
}

impl ImageFault {
    /// The error for a file.
    pub fn in_file(self, path: &Path) -> IoError {
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
}

/// Decodes a photo from the bytes of a file; see [`read_photo`].
///
/// # Errors
/// [`ImageFault`] with what was found.
pub fn decode_photo(bytes: &[u8]) -> Result<Photo, ImageFault> {
    let content = |message: String| ImageFault::Content(Fault::new(message));
    let broken = |e: ::image::ImageError| {
        content(format!("the picture cannot be decoded ({e}); save it anew as PNG"))
    };
    let format = known_format(bytes).map_err(ImageFault::Content)?;
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    let mut limits = Limits::default();
    limits.max_image_width = Some(MAX_SIDE);
    limits.max_image_height = Some(MAX_SIDE);
    limits.max_alloc = Some(MAX_MEGAPIXELS * 1_000_000 * 8 + (64 << 20));
    // The decoder's own dimension error hides the figures: look at them first.
    reader.limits({
        let mut open = limits.clone();
        open.max_image_width = None;
        open.max_image_height = None;
        open
    });
    let mut decoder = reader.into_decoder().map_err(broken)?;
    let (width, height) = decoder.dimensions();
    let too_many = u64::from(width) * u64::from(height) > MAX_MEGAPIXELS * 1_000_000;
    if width > MAX_SIDE || height > MAX_SIDE || too_many {
        return Err(ImageFault::Size { width, height });
    }
    if width == 0 || height == 0 {
        return Err(content(format!("the picture is {width}x{height} pixels; it is empty")));
    }
    decoder.set_limits(limits).map_err(broken)?;
    let orientation = decoder.orientation().unwrap_or(Orientation::NoTransforms);
    let mut picture = DynamicImage::from_decoder(decoder).map_err(broken)?;
    picture.apply_orientation(orientation);
    to_photo(picture).ok_or_else(|| content("the picture's size and data disagree".into()))
}

fn known_format(bytes: &[u8]) -> Result<ImageFormat, Fault> {
    match ::image::guess_format(bytes) {
        Ok(f @ (ImageFormat::Png | ImageFormat::Jpeg | ImageFormat::Gif)) => Ok(f),
        Ok(other) => Err(Fault::new(format!(
            "this is a {other:?} picture; PNG, JPEG and GIF are read: convert it to PNG"
        ))),
        Err(_) => {
            let found = match bytes {
                [] => "the file is empty".to_owned(),
                [b'I', b'I', ..] | [b'M', b'M', ..] => "this is a TIFF or raw photo".to_owned(),
                [_, _, _, _, b'f', b't', b'y', b'p', ..] => "this is a HEIC photo or film".into(),
                _ => "this is no picture".to_owned(),
            };
            Err(Fault::new(format!("{found}; PNG, JPEG and GIF are read: convert it to PNG")))
        }
    }
}

fn to_photo(picture: DynamicImage) -> Option<Photo> {
    let (width, height) = (picture.width() as usize, picture.height() as usize);
    let deep = matches!(
        picture,
        DynamicImage::ImageLuma16(_)
            | DynamicImage::ImageLumaA16(_)
            | DynamicImage::ImageRgb16(_)
            | DynamicImage::ImageRgba16(_)
    );
    if deep {
        let pixels = picture.into_rgba16();
        let mut rgb = Vec::with_capacity(width * height);
        let mut gray = Vec::with_capacity(width * height);
        for &::image::Rgba([r, g, b, a]) in pixels.pixels() {
            // 65535 / 255 = 257 exactly.
            let cover = f32::from(a) / (65535.0 * 257.0);
            let c = [r, g, b].map(|v| f32::from(v) * cover);
            gray.push(0.299 * c[0] + 0.587 * c[1] + 0.114 * c[2]);
            rgb.push(c.map(|v| v.round() as u8));
        }
        let rgb = Raster::from_vec(width, height, rgb)?;
        return Some(Photo { rgb, gray: Raster::from_vec(width, height, gray)? });
    }
    let rgb: Vec<[u8; 3]> = if picture.color().has_alpha() {
        let over_black = |v: u8, a: u8| ((u32::from(v) * u32::from(a) + 127) / 255) as u8;
        let pixels = picture.into_rgba8();
        pixels.pixels().map(|p| [0, 1, 2].map(|c| over_black(p.0[c], p.0[3]))).collect()
    } else {
        picture.into_rgb8().pixels().map(|p| p.0).collect()
    };
    Some(Photo::from_rgb(Raster::from_vec(width, height, rgb)?))
}

/// A picture that can be written as PNG.
pub trait PngPicture {
    /// Width, height, raw 8-bit samples and their kind.
    fn samples(&self) -> (usize, usize, Vec<u8>, ExtendedColorType);
}

impl PngPicture for Rgb {
    fn samples(&self) -> (usize, usize, Vec<u8>, ExtendedColorType) {
        (self.width(), self.height(), self.data().as_flattened().to_vec(), ExtendedColorType::Rgb8)
    }
}

impl PngPicture for Raster<u8> {
    fn samples(&self) -> (usize, usize, Vec<u8>, ExtendedColorType) {
        (self.width(), self.height(), self.data().to_vec(), ExtendedColorType::L8)
    }
}

impl PngPicture for Gray {
    fn samples(&self) -> (usize, usize, Vec<u8>, ExtendedColorType) {
        self.to_u8().samples()
    }
}

/// The bytes of a PNG file, the same for the same picture; grey values are rounded to 8 bit.
///
/// # Errors
/// [`Fault`] for a picture without pixels.
pub fn encode_png(picture: &impl PngPicture) -> Result<Vec<u8>, Fault> {
    let (width, height, samples, kind) = picture.samples();
    let fail = || Fault::new(format!("a picture of {width}x{height} pixels cannot be a PNG"));
    let (w, h) = (u32::try_from(width), u32::try_from(height));
    let (Ok(w @ 1..), Ok(h @ 1..)) = (w, h) else { return Err(fail()) };
    let mut out = Vec::new();
    // Adaptive filtering takes twice the time and gains nothing on photographs.
    PngEncoder::new_with_quality(&mut out, CompressionType::Fast, FilterType::Paeth)
        .write_image(&samples, w, h, kind)
        .map_err(|_| fail())?;
    Ok(out)
}

/// The bytes of a JPEG file: a photograph to look at, a fraction of its size as PNG.
///
/// # Errors
/// [`Fault`] for a picture without pixels, or too large for JPEG.
pub fn encode_jpeg(picture: &Rgb, quality: u8) -> Result<Vec<u8>, Fault> {
    let (width, height, samples, kind) = picture.samples();
    let fail = || Fault::new(format!("a picture of {width}x{height} pixels cannot be a JPEG"));
    let (Ok(w @ 1..), Ok(h @ 1..)) = (u32::try_from(width), u32::try_from(height)) else {
        return Err(fail());
    };
    let mut out = Vec::new();
    JpegEncoder::new_with_quality(&mut out, quality)
        .write_image(&samples, w, h, kind)
        .map_err(|_| fail())?;
    Ok(out)
}

/// Writes a PNG, whole or not at all.
///
/// # Errors
/// [`IoError::Write`], or [`IoError::Malformed`] for a picture without pixels.
pub fn write_png(path: &Path, picture: &impl PngPicture) -> Result<(), IoError> {
    atomic::write(path, &encode_png(picture).map_err(|f| f.in_file(path))?)
}

#[cfg(test)]
mod tests;
