//! YUV 4:2:2 to RGB: ITU-R BT.601 in its limited range, rounded as OpenCV does.

/// Where luma and chroma of two pixels stand in their four bytes.
#[derive(Debug, Clone, Copy)]
pub(super) enum Order {
    Uyvy,
    Yuyv,
}

/// Factors of 2^20: 255/219 for luma, the others for chroma to red, green and blue.
const SHIFT: u32 = 20;
const Y: i32 = 1_220_542;
const V_RED: i32 = 1_673_527;
const V_GREEN: i32 = -852_492;
const U_GREEN: i32 = -409_993;
const U_BLUE: i32 = 2_116_026;

/// Red, green and blue of a row's pixels.
pub(super) fn to_rgb(row: &[u8], order: Order) -> impl Iterator<Item = u8> {
    row.as_chunks::<4>().0.iter().flat_map(move |&bytes| {
        let [u, y0, v, y1] = match order {
            Order::Uyvy => bytes,
            Order::Yuyv => [bytes[1], bytes[0], bytes[3], bytes[2]],
        };
        let [u, v] = [u, v].map(|c| i32::from(c) - 128);
        let rounding = 1 << (SHIFT - 1);
        let chroma = [V_RED * v, V_GREEN * v + U_GREEN * u, U_BLUE * u].map(|c| c + rounding);
        let pixel = move |y: u8| {
            let y = (i32::from(y) - 16).max(0) * Y;
            chroma.map(|c| ((y + c) >> SHIFT).clamp(0, 255) as u8)
        };
        [pixel(y0), pixel(y1)].into_iter().flatten()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// U, Y, V, Y; and what OpenCV 5.0 makes of them (`COLOR_YUV2RGB_UYVY`).
    const KNOWN: [([u8; 4], [u8; 6]); 7] = [
        ([128, 16, 128, 235], [0, 0, 0, 255, 255, 255]),
        ([90, 81, 240, 81], [254, 0, 0, 254, 0, 0]),
        ([54, 145, 34, 145], [0, 255, 1, 0, 255, 1]),
        ([240, 41, 110, 41], [0, 0, 255, 0, 0, 255]),
        ([0, 0, 255, 255], [203, 0, 0, 255, 225, 20]),
        ([255, 10, 0, 250], [0, 54, 255, 68, 255, 255]),
        ([130, 100, 77, 200], [16, 138, 102, 133, 255, 218]),
    ];

    #[test]
    fn the_numbers_are_those_of_opencv() {
        for ([u, y0, v, y1], rgb) in KNOWN {
            assert_eq!(to_rgb(&[u, y0, v, y1], Order::Uyvy).collect::<Vec<_>>(), rgb);
            assert_eq!(to_rgb(&[y0, u, y1, v], Order::Yuyv).collect::<Vec<_>>(), rgb);
        }
    }
}
