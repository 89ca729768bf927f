//! Text that stays legible on any ground, and labels that keep out of each other's way.

use embedded_graphics::mono_font::MonoTextStyle;
use embedded_graphics::mono_font::iso_8859_1::FONT_7X13_BOLD;
use embedded_graphics::pixelcolor::Rgb888;
use embedded_graphics::prelude::*;
use embedded_graphics::primitives::Rectangle;
use embedded_graphics::text::{Baseline, Text};

use super::Canvas;

/// Width of a character in pixels.
const ADVANCE: u32 = 7;
/// Height of a label in pixels, with the dark border around the text.
pub(super) const LABEL_HEIGHT: u32 = 15;
/// Dark border to the left and right of a label's text, in pixels.
const MARGIN: u32 = 3;
/// Longest label in characters.
const LONGEST: usize = 40;

/// Writes a line of text with its top left corner at (x, y).
pub(super) fn write(canvas: &mut Canvas, text: &str, x: i32, y: i32, colour: Rgb888) {
    let style = MonoTextStyle::new(&FONT_7X13_BOLD, colour);
    let Ok(_) = Text::with_baseline(text, Point::new(x, y), style, Baseline::Top).draw(canvas);
}

/// Places labels in a part of the picture so that they do not overlap.
#[derive(Debug)]
pub(super) struct Labels {
    area: Rectangle,
    placed: Vec<Rectangle>,
}

impl Labels {
    /// Labels within `area`.
    pub(super) fn new(area: Rectangle) -> Self {
        Self { area, placed: Vec::new() }
    }

    /// Writes a label centred on x = `x`, its top at `y`, or as near below or above as there is room; a label for which
    /// there is none within a few lines is left out.
    pub(super) fn write(&mut self, canvas: &mut Canvas, text: &str, x: i32, y: i32, colour: Rgb888) {
        let text: String = text.chars().take(LONGEST).collect();
        let size = Size::new(text.chars().count() as u32 * ADVANCE + 2 * MARGIN, LABEL_HEIGHT);
        let low = self.area.top_left;
        let high = low + (self.area.size.saturating_sub(size)).cast_point();
        let x = (x - size.width as i32 / 2).clamp(low.x, high.x.max(low.x));
        let step = LABEL_HEIGHT as i32 + 1;
        let lines = [0, 1, -1, 2, -2, 3, -3, 4].into_iter();
        let spots = lines.map(|line| Rectangle::new(Point::new(x, (y + line * step).clamp(low.y, high.y)), size));
        let free = |spot: &Rectangle| !self.placed.iter().any(|other| !other.intersection(spot).is_zero_sized());
        let Some(spot) = spots.into_iter().find(free) else { return };
        let Point { x, y } = spot.top_left;
        canvas.darken(x, y, size.width, size.height);
        write(canvas, &text, x + MARGIN as i32, y + 1, colour);
        self.placed.push(spot);
    }
}

/// A size as the step to the opposite corner.
trait CastPoint {
    fn cast_point(self) -> Point;
}

impl CastPoint for Size {
    fn cast_point(self) -> Point {
        Point::new(self.width as i32, self.height as i32)
    }
}
