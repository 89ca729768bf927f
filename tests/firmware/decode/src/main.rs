//! Reads defmt's stream from standard input and prints its events, one a line: time, level, text.
//!
//! Argument: the image that wrote the stream; the texts are in it alone.

use std::error::Error;
use std::io::Read as _;

use defmt_decoder::{DecodeError, Table};

fn main() -> Result<(), Box<dyn Error>> {
    let image = std::env::args_os().nth(1).ok_or("usage: decode IMAGE < STREAM")?;
    let table = Table::parse(&std::fs::read(image)?)?.ok_or("the image logs nothing through defmt")?;
    let mut stream = Vec::new();
    std::io::stdin().read_to_end(&mut stream)?;
    let mut decoder = table.new_stream_decoder();
    decoder.received(&stream);
    loop {
        match decoder.decode() {
            Ok(frame) => {
                let time = frame.display_timestamp().map(|time| time.to_string()).unwrap_or_default();
                let level = frame.level().map_or("-", |level| level.as_str());
                println!("{time} {level} {}", frame.display_message());
            }
            Err(DecodeError::UnexpectedEof) => return Ok(()),
            Err(DecodeError::Malformed) => return Err("the stream is damaged".into()),
        }
    }
}
