//! scratch
fn main() {
    for name in ["robot_lab", "office_boxes", "lounge", "dining", "classroom"] {
        let root = format!("/work/shared/data/recordings/{name}");
        let d = image::open(format!("{root}/depth/0000.png")).unwrap().into_luma16();
        let (w, h) = d.dimensions();
        let raw = d.as_raw();
        let at = |u: u32, v: u32| raw[(v * w + u) as usize];
        let (mut l, mut r) = (0, 0);
        for v in 0..h {
            let mut u = 1;
            while u < w {
                if at(u, v) == 0 && at(u - 1, v) > 0 {
                    let s = u;
                    while u < w && at(u, v) == 0 {
                        u += 1;
                    }
                    if u < w && u - s >= 4 && u - s < 40 {
                        let (a, b) = (i32::from(at(s - 1, v)), i32::from(at(u, v)));
                        if b < a - 300 {
                            l += 1
                        }
                        if a < b - 300 {
                            r += 1
                        }
                    }
                } else {
                    u += 1
                }
            }
        }
        println!(
            "{name} {w}x{h} zeros {:.3}; shadow left of near {l}, right of near {r}",
            raw.iter().filter(|&&d| d == 0).count() as f64 / raw.len() as f64
        );
        let c = image::open(format!("{root}/rgb/0000.png"))
            .map(|i| i.into_rgb8())
            .unwrap_or_else(|_| image::RgbImage::new(w, h));
        let mut out = image::RgbImage::new(2 * w, h);
        for v in 0..h {
            for u in 0..w {
                out.put_pixel(u, v, *c.get_pixel(u, v));
                let x = at(u, v);
                out.put_pixel(
                    w + u,
                    v,
                    image::Rgb(if x == 0 {
                        [0, 0, 70]
                    } else {
                        [(255 - (u32::from(x) / 24).min(215)) as u8 - (x % 100 / 4) as u8; 3]
                    }),
                );
            }
        }
        out.save(format!("/tmp/w/out/real_{name}.png")).unwrap();
    }
}
