//! Answers out of a stream of bytes.

use std::io::{self, Read};

use pldi_core::serial::{self, Decoder, HOST_BUFFER, Rejects};

use super::Answer;

/// An answer, and the number of the request that it answers.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Received {
    /// The request's sequence number.
    pub sequence: u16,
    /// What the device said.
    pub answer: Answer,
}

/// What came over the line so far.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Traffic {
    /// Bytes.
    pub bytes: u64,
    /// Answers, repeated ones left out.
    pub answers: u64,
    /// Answers with number and content of the one before. They are not handed on.
    pub repeated: u64,
    /// What was no answer, and why.
    pub rejects: Rejects,
}

/// Reads answers. What was corrupted on the way is counted and left out.
#[derive(Debug)]
pub struct Receiver<R> {
    reader: R,
    decoder: Box<Decoder<HOST_BUFFER>>,
    buffer: Vec<u8>,
    /// Bytes of the buffer that were looked at, and that are filled.
    at: usize,
    end: usize,
    traffic: Traffic,
    last: Option<(u16, u32)>,
}

impl<R: Read> Receiver<R> {
    /// Nothing is read yet.
    pub fn new(reader: R) -> Self {
        let (decoder, buffer) = (Box::new(Decoder::new()), vec![0; 4096]);
        Self { reader, decoder, buffer, at: 0, end: 0, traffic: Traffic::default(), last: None }
    }

    /// The counts so far.
    pub fn traffic(&self) -> Traffic {
        Traffic { rejects: self.decoder.rejects(), ..self.traffic }
    }

    /// The next answer; `None` where the stream ends. (No `Iterator`: after a time-out it can go on.)
    ///
    /// # Errors
    /// What the reader says, time-outs of serial lines included; then it may be called again, and nothing is lost.
    #[allow(clippy::should_implement_trait)]
    pub fn next(&mut self) -> io::Result<Option<Received>> {
        loop {
            if let Some(received) = self.buffered() {
                return Ok(Some(received));
            }
            match self.reader.read(&mut self.buffer) {
                Ok(0) => return Ok(None),
                Ok(count) => {
                    (self.at, self.end) = (0, count);
                    self.traffic.bytes += count as u64;
                }
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(error) => return Err(error),
            }
        }
    }

    /// The next answer among the bytes that are there.
    fn buffered(&mut self) -> Option<Received> {
        loop {
            let mut bytes = &self.buffer[self.at..self.end];
            let found = self.decoder.feed(&mut bytes);
            self.at = self.end - bytes.len();
            let reason = match found? {
                // The decoder has counted it.
                Err(_) => continue,
                Ok(packet) => match serial::Answer::parse(&packet) {
                    Ok(_) if self.last == Some((packet.sequence, packet.checksum)) => {
                        self.traffic.repeated += 1;
                        continue;
                    }
                    Ok(answer) => {
                        self.last = Some((packet.sequence, packet.checksum));
                        self.traffic.answers += 1;
                        return Some(Received { sequence: packet.sequence, answer: answer.into() });
                    }
                    Err(reason) => reason,
                },
            };
            self.decoder.reject(reason);
        }
    }
}
