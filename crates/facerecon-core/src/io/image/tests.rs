use ::image::{ImageBuffer, Luma, LumaA, Rgb as PixelRgb, Rgba};
use proptest::prelude::*;

use super::*;

fn encoded(image: &DynamicImage, format: ImageFormat) -> Vec<u8> {
    let mut out = Cursor::new(Vec::new());
    image.write_to(&mut out, format).unwrap();
    out.into_inner()
}

fn message(bytes: &[u8]) -> String {
    match decode_photo(bytes) {
        Err(ImageFault::Content(fault)) => fault.message,
        other => panic!("{other:?}"),
    }
}

#[test]
fn colour_survives_a_round_trip_and_bytes_repeat() {
    let rgb = Rgb::from_fn(37, 21, |x, y| [(x * 7) as u8, (y * 11) as u8, (x ^ y) as u8]);
    let png = encode_png(&rgb).unwrap();
    assert_eq!(png, encode_png(&rgb).unwrap());
    let photo = decode_photo(&png).unwrap();
    assert_eq!(photo.rgb, rgb);
    assert_eq!(photo.gray, rgb.to_gray());
    let gray = Raster::from_fn(5, 4, |x, y| (x + 10 * y) as u8);
    assert_eq!(decode_photo(&encode_png(&gray).unwrap()).unwrap().rgb, gray.map(|v| [v; 3]));
    assert!(encode_png(&Rgb::filled(0, 3, [0; 3])).is_err());
}

#[test]
fn sixteen_bit_keeps_its_fractions() {
    let deep: ImageBuffer<Luma<u16>, _> =
        ImageBuffer::from_fn(4, 3, |x, y| Luma([(x * 15_000 + y * 100) as u16]));
    let photo = decode_photo(&encoded(&DynamicImage::ImageLuma16(deep), ImageFormat::Png)).unwrap();
    let value = 45_200.0 / 257.0;
    assert!((photo.gray.at(3, 2) - value).abs() < 1e-3, "{}", photo.gray.at(3, 2));
    assert_eq!(photo.rgb.at(3, 2), [(value + 0.5) as u8; 3]);
}

#[test]
fn transparent_pixels_are_composited_on_black() {
    let pixel = ImageBuffer::from_pixel(2, 2, Rgba([200u8, 100, 50, 51]));
    let photo = decode_photo(&encoded(&DynamicImage::ImageRgba8(pixel), ImageFormat::Png)).unwrap();
    assert_eq!(photo.rgb.at(0, 0), [40, 20, 10]);
    let grey = ImageBuffer::from_pixel(2, 2, LumaA([200u8, 255]));
    let photo = decode_photo(&encoded(&DynamicImage::ImageLumaA8(grey), ImageFormat::Png)).unwrap();
    assert_eq!(photo.rgb.at(1, 1), [200; 3]);
}

#[test]
fn gif_and_jpeg_are_read_by_content() {
    let picture = ImageBuffer::from_pixel(8, 6, PixelRgb([90u8, 90, 90]));
    for format in [ImageFormat::Gif, ImageFormat::Jpeg] {
        let bytes = encoded(&DynamicImage::ImageRgb8(picture.clone()), format);
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("photo.png");
        std::fs::write(&path, bytes).unwrap();
        let photo = read_photo(&path).unwrap();
        assert_eq!(photo.size(), (8, 6));
        assert!((photo.gray.at(4, 3) - 90.0).abs() < 3.0);
    }
}

/// A JPEG with an EXIF block that says "turn by 90 degrees clockwise" (orientation 6).
#[test]
fn exif_orientation_is_applied() {
    let wide = ImageBuffer::from_fn(32, 16, |x, _| Luma([if x < 16 { 20u8 } else { 220 }]));
    let jpeg = encoded(&DynamicImage::ImageLuma8(wide), ImageFormat::Jpeg);
    let mut exif =
        b"Exif\0\0MM\0*\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01\0\x06\0\0\0\0\0\0".to_vec();
    let length = (exif.len() + 2) as u16;
    let mut bytes = jpeg[..2].to_vec();
    bytes.extend([0xff, 0xe1]);
    bytes.extend(length.to_be_bytes());
    bytes.append(&mut exif);
    bytes.extend(&jpeg[2..]);
    let photo = decode_photo(&bytes).unwrap();
    assert_eq!(photo.size(), (16, 32));
    assert!(photo.gray.at(8, 4) < 60.0 && photo.gray.at(8, 28) > 180.0);
}

#[test]
fn what_is_not_an_image_is_named() {
    assert!(message(b"").contains("empty"));
    assert!(
        message(b"II*\0aaaaaaaa").contains("TIFF") || message(b"II*\0aaaaaaaa").contains("Tiff")
    );
    assert!(message(b"hello, I am a text").contains("not an image"));
    let png = encode_png(&Raster::filled(40, 40, 7u8)).unwrap();
    assert!(message(&png[..png.len() / 2]).contains("decoded"));
}

#[test]
fn a_false_size_is_refused_before_it_is_allocated() {
    let mut png = encode_png(&Raster::filled(4, 4, 7u8)).unwrap();
    png[16..20].copy_from_slice(&100_000u32.to_be_bytes());
    png[20..24].copy_from_slice(&100_000u32.to_be_bytes());
    // The checksum of the header covers type and content.
    let crc = crc32(&png[12..29]);
    png[29..33].copy_from_slice(&crc.to_be_bytes());
    assert_eq!(decode_photo(&png), Err(ImageFault::Size { width: 100_000, height: 100_000 }));
    let error = ImageFault::Size { width: 9, height: 8 }.in_file(Path::new("a.png")).to_string();
    assert!(error.contains("a.png is 9x8"), "{error}");
}

fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0u32, |crc, &b| {
        (0..8).fold(
            crc ^ u32::from(b),
            |c, _| if c & 1 == 1 { (c >> 1) ^ 0xedb8_8320 } else { c >> 1 },
        )
    })
}

proptest! {
    #[test]
    fn damaged_images_never_panic(at in 0usize..400, value: u8, cut in 0usize..400) {
        let rgb = Rgb::from_fn(16, 12, |x, y| [(x * 16) as u8, (y * 20) as u8, 99]);
        for format in [ImageFormat::Png, ImageFormat::Jpeg, ImageFormat::Gif] {
            let buffer = ImageBuffer::from_fn(16, 12, |x, y| PixelRgb(rgb.at(x as usize, y as usize)));
            let mut bytes = encoded(&DynamicImage::ImageRgb8(buffer), format);
            let at = at % bytes.len();
            bytes[at] = value;
            let _ = decode_photo(&bytes);
            bytes.truncate(cut);
            let _ = decode_photo(&bytes);
        }
    }
}
