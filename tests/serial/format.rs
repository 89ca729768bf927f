//! The documented serial format: its example and its sizes are those of the code.

use super::*;

/// The bytes of a block of the protocol's document.
fn documented(name: &str) -> Vec<u8> {
    let document = include_str!("../../docs/serial.md");
    let block = document.split(&format!("```hex {name}\n")).nth(1).unwrap_or_else(|| panic!("no block {name}"));
    let hex = block.split("```").next().unwrap();
    hex.split_whitespace().map(|byte| u8::from_str_radix(byte, 16).unwrap()).collect()
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect::<Vec<_>>().join(" ")
}

#[test]
fn the_worked_example_is_right() {
    let ping = serial::Request::Ping(wire::Ping { token: 7.into() });
    let status = wire::Status { frame: 5.into(), code: 1, reserved: 0, missing: 12.into() };
    let mut line = Vec::new();
    let mut sink = |bytes: &[u8]| line.extend_from_slice(bytes);
    let payload = status.as_bytes();
    serial::packet::write(&mut sink, serial::kind::STATUS, 300, payload.len() as u16, |body| body.put(payload));
    for (name, line) in [("ping", packet(&ping, 258).unwrap()), ("status", line)] {
        assert_eq!(hex(&documented(&format!("{name} on the line"))), hex(&line));
        let (mut plain, mut decoder) = (Vec::new(), serial::cobs::Decoder::new());
        let mut input = &line[1..];
        while let Some(step) = decoder.step(&mut input) {
            match step {
                serial::cobs::Step::Bytes(bytes) => plain.extend_from_slice(bytes),
                serial::cobs::Step::Zero => plain.push(0),
                _ => {}
            }
        }
        assert_eq!(hex(&documented(name)), hex(&plain));
    }
    // What the device really says.
    let frames = frames();
    let mut packets = frame_packets(&outgoing(&frames[0], 5), FrameOptions::default(), 59).unwrap();
    packets.drain(229..241);
    let answer = Bench::new(&frames[0].intrinsics).answers([&packets.concat()[..]]);
    assert_eq!(hex(&answer), hex(&documented("status on the line")));
}

#[test]
fn the_documented_sizes_are_right() {
    let document = include_str!("../../docs/serial.md");
    let frame = &frames()[0];
    let size = |colour: bool, rgb565: bool| -> usize {
        let all = outgoing(frame, 0);
        let sent = Outgoing { colour: all.colour.filter(|_| colour), ..all };
        let options = FrameOptions { rgb565, ..FrameOptions::default() };
        frame_packets(&sent, options, 0).unwrap().iter().map(Vec::len).sum()
    };
    let result = |detections: usize, hypotheses: usize, rejected: usize| {
        serial::packet::wire_size(44 + detections * (36 + hypotheses * 14) + rejected * 24)
    };
    for (what, bytes, unit) in [
        ("depth and RGB565", size(true, true), 1e6),
        ("depth and RGB888", size(true, false), 1e6),
        ("depth alone", size(false, false), 1e6),
        ("nothing listed", result(3, 1, 0), 1e3),
        ("20 rejected clusters", result(5, 5, 20), 1e3),
    ] {
        let row = document.lines().find(|line| line.starts_with("| a ") && line.contains(what)).unwrap();
        let fields: Vec<&str> = row.split('|').map(str::trim).collect();
        let stated: f64 = fields[2].replace(',', "").parse().unwrap_or_else(|_| panic!("{what}: {bytes}"));
        // Stuffing depends on the content, by some bytes a row.
        assert!((stated - bytes as f64).abs() <= 0.005 * bytes as f64, "{what}: {bytes}");
        let rate: f64 = fields[3].split(' ').next().unwrap().parse().unwrap();
        assert!((rate - 30.0 * stated / unit).abs() < 0.06, "{what}: {}", 30.0 * stated / unit);
    }
    assert!(document.contains(&format!("({} bytes of buffer)", DEVICE_BUFFER)));
    assert!(document.contains(&format!("At most {} bytes.", serial::answer::LONGEST_RESULT)));
    let state = size_of::<Device<'_, DEVICE_BUFFER>>();
    assert!(state <= 250, "{state}");
}
