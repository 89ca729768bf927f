//! An RGB image to draw on.

use std::convert::Infallible;

use embedded_graphics::pixelcolor::Rgb888;
use embedded_graphics::prelude::*;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder};

use crate::Error;

/// An RGB image that `embedded-graphics` draws on; what lies outside is left out.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Canvas {
    width: u32,
    height: u32,
    pixels: Vec<u8>,
}

impl Canvas {
    /// A black image.
    pub fn new(width: u32, height: u32) -> Self {
        Self { width, height, pixels: vec![0; 3 * width as usize * height as usize] }
    }

    /// Width and height in pixels.
    pub fn dimensions(&self) -> (u32, u32) {
        (self.width, self.height)
    }

    /// Red, green and blue, row by row.
    pub fn pixels(&self) -> &[u8] {
        &self.pixels
    }

    /// Sets a pixel; outside of the image nothing happens.
    pub fn set(&mut self, x: i32, y: i32, colour: [u8; 3]) {
        if let Some(pixel) = self.pixel(x, y) {
            *pixel = colour;
        }
    }

    /// Darkens a rectangle to a quarter of its brightness, as a ground for text.
    pub fn darken(&mut self, x: i32, y: i32, width: u32, height: u32) {
        for y in y..y.saturating_add_unsigned(height) {
            for x in x..x.saturating_add_unsigned(width) {
                if let Some(pixel) = self.pixel(x, y) {
                    *pixel = pixel.map(|c| c / 4);
                }
            }
        }
    }

    /// The bytes of a PNG file.
    ///
    /// # Errors
    /// `Usage` where the encoder refuses, as for an image without pixels.
    pub fn to_png(&self) -> Result<Vec<u8>, Error> {
        let mut bytes = Vec::new();
        if self.pixels.is_empty() {
            return Err(Error::Usage("an image without pixels cannot be written".to_owned()));
        }
        PngEncoder::new_with_quality(&mut bytes, CompressionType::Fast, FilterType::Adaptive)
            .write_image(&self.pixels, self.width, self.height, ExtendedColorType::Rgb8)
            .map_err(|e| Error::Usage(format!("the picture cannot be encoded: {e}")))?;
        Ok(bytes)
    }

    fn pixel(&mut self, x: i32, y: i32) -> Option<&mut [u8; 3]> {
        let (x, y) = (u32::try_from(x).ok()?, u32::try_from(y).ok()?);
        if x >= self.width || y >= self.height {
            return None;
        }
        self.pixels.as_chunks_mut::<3>().0.get_mut(y as usize * self.width as usize + x as usize)
    }
}

impl OriginDimensions for Canvas {
    fn size(&self) -> Size {
        Size::new(self.width, self.height)
    }
}

impl DrawTarget for Canvas {
    type Color = Rgb888;
    type Error = Infallible;

    fn draw_iter<I: IntoIterator<Item = Pixel<Rgb888>>>(&mut self, pixels: I) -> Result<(), Infallible> {
        for Pixel(at, colour) in pixels {
            self.set(at.x, at.y, [colour.r(), colour.g(), colour.b()]);
        }
        Ok(())
    }
}
