//! Records and plays through libOpenNI2, as a judge of our driver and a maker of `.oni` files.
//!
//! ```text
//! oni list                        names of the devices
//! oni record FILE WIDTH FRAMES    records so many frames of each stream of the first device, losslessly
//! oni take URI FILM WIDTH FRAMES  writes so many frames of a device, or all of a file, as a film
//! oni take-raw FILM FRAMES        so many frames as the first device gives them when it is told nothing
//! oni survive FRAMES              reads so many depth images over unplugging and plugging in
//! ```

mod library;

use std::process::ExitCode;
use std::time::Duration;
use std::{env, fs, thread};

use library::{COLOR, DEPTH, Device, FOV, Image, Library, MIRRORING, REGISTRATION, REPEAT, SPEED, Stream, VIDEO_MODE};

/// How long an image is waited for, in ms.
const PATIENCE: i32 = 2000;

fn main() -> ExitCode {
    let words: Vec<String> = env::args().skip(1).collect();
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    let result = match words[..] {
        ["list"] => list(),
        ["record", file, width, frames] => record(file, number(width), number(frames)),
        ["take", uri, film, width, frames] => take(uri, film, number(width), number(frames)),
        ["take-raw", film, frames] => take_raw(film, number(frames)),
        ["survive", frames] => survive(number(frames)),
        _ => Err("usage: oni list | record FILE WIDTH FRAMES | take URI FILM WIDTH FRAMES | take-raw FILM FRAMES | survive FRAMES".into()),
    };
    result.map_or_else(
        |error| {
            eprintln!("oni: {error}");
            ExitCode::FAILURE
        },
        |()| ExitCode::SUCCESS,
    )
}

fn number(word: &str) -> usize {
    word.parse().expect("a number")
}

fn list() -> Result<(), String> {
    Library::new()?.devices()?.iter().for_each(|uri| println!("{uri}"));
    Ok(())
}

/// The first device's name.
fn first(library: &Library) -> Result<String, String> {
    library.devices()?.into_iter().next().ok_or_else(|| "there is no device".into())
}

/// Depth and colour of a device.
fn streams<'a>(device: &'a Device<'_>, width: usize) -> Result<[Stream<'a>; 2], String> {
    let streams = [device.stream(DEPTH)?, device.stream(COLOR)?];
    for (stream, format) in streams.iter().zip([100, 200]) {
        stream.set(VIDEO_MODE, [format, width as i32, width as i32 * 3 / 4, 30])?;
        stream.set(MIRRORING, 0)?;
    }
    Ok(streams)
}

/// Starts both streams and registers depth to colour, which has to be in this order.
fn start(device: &Device<'_>, [depth, color]: &[Stream<'_>; 2]) -> Result<(), String> {
    device.set(REGISTRATION, 1)?;
    assert_eq!(device.get(REGISTRATION)?, 0, "set too early, it is lost");
    depth.start()?;
    color.start()?;
    device.set(REGISTRATION, 1)?;
    assert_eq!(device.get(REGISTRATION)?, 1);
    Ok(())
}

/// Reads so many images of each stream, or until no more come; says when each was taken.
fn read(library: &Library, streams: &[Stream<'_>; 2], frames: usize) -> Result<[Vec<Image>; 2], String> {
    let mut images = [Vec::new(), Vec::new()];
    while images.iter().any(|images| images.len() < frames) {
        let Some(which) = library.wait(&[&streams[0], &streams[1]], PATIENCE)? else { break };
        let image = streams[which].read()?;
        println!("{} {} {}", ["depth", "color"][which], image.index, image.stamp);
        images[which].push(image);
    }
    Ok(images)
}

fn record(file: &str, width: usize, frames: usize) -> Result<(), String> {
    let library = Library::new()?;
    let device = library.open(&first(&library)?)?;
    let streams = streams(&device, width)?;
    let recorder = library.recorder(file)?;
    for stream in &streams {
        recorder.attach(stream)?;
    }
    recorder.start()?;
    // The recorder works in a thread of its own, takes nothing before it has got the message, and does not say when.
    thread::sleep(Duration::from_millis(500));
    start(&device, &streams)?;
    let images = read(&library, &streams, frames)?;
    drop(recorder);
    if images.iter().all(|images| images.len() == frames) { Ok(()) } else { Err("too few images came".into()) }
}

fn take(uri: &str, film: &str, width: usize, frames: usize) -> Result<(), String> {
    let library = Library::new()?;
    let file = fs::exists(uri).is_ok_and(|exists| exists);
    let uri = if uri == "first" { first(&library)? } else { uri.into() };
    let device = library.open(&uri)?;
    let streams = if file { [device.stream(DEPTH)?, device.stream(COLOR)?] } else { streams(&device, width)? };
    if file {
        device.set(SPEED, -1.0f32)?;
        device.set(REPEAT, 0)?;
        streams[0].start()?;
        streams[1].start()?;
    } else {
        start(&device, &streams)?;
    }
    write(&library, &streams, film, frames)
}

fn take_raw(film: &str, frames: usize) -> Result<(), String> {
    let library = Library::new()?;
    let device = library.open(&first(&library)?)?;
    let streams = [device.stream(DEPTH)?, device.stream(COLOR)?];
    streams[0].start()?;
    streams[1].start()?;
    write(&library, &streams, film, frames)
}

/// Reads so many images of each stream and writes them as a film.
fn write(library: &Library, streams: &[Stream<'_>; 2], film: &str, frames: usize) -> Result<(), String> {
    let [_, columns, rows, rate] = streams[0].get::<4>(VIDEO_MODE)?;
    let fov = [streams[0].get::<1>(FOV[0])?[0], streams[0].get::<1>(FOV[1])?[0]];
    let [depth, color] = read(library, streams, frames)?;
    streams.iter().for_each(Stream::stop);
    // The thread that plays a file goes through the list of its streams without a lock. Once they are stopped it sleeps
    // nearly all the time; destroyed at once they take the process with them one time in a hundred.
    thread::sleep(Duration::from_millis(50));
    if depth.len() != color.len() {
        return Err(format!("{} depth and {} colour images", depth.len(), color.len()));
    }
    let mut bytes = b"PLDIFILM".to_vec();
    for word in [columns, rows, rate, depth.len() as u32, fov[0], fov[1]] {
        bytes.extend(word.to_le_bytes());
    }
    for image in depth.iter().zip(&color).flat_map(|(depth, color)| [depth, color]) {
        bytes.extend(&image.bytes);
    }
    fs::write(film, bytes).map_err(|error| error.to_string())
}

fn survive(frames: usize) -> Result<(), String> {
    let library = Library::new()?;
    let mut left = frames;
    while left > 0 {
        let (_, went) = Library::came_and_went();
        let device = library.open(&first(&library)?)?;
        let depth = device.stream(DEPTH)?;
        depth.start()?;
        println!("opened");
        while left > 0 {
            if library.wait(&[&depth], 300)?.is_some() {
                let image = depth.read()?;
                println!("depth {} {}", image.index, image.stamp);
                left -= 1;
                continue;
            }
            if Library::came_and_went().1 > went {
                println!("gone");
                break;
            }
        }
        drop(depth);
        drop(device);
        while left > 0 && library.devices()?.is_empty() {
            thread::sleep(Duration::from_millis(20));
        }
    }
    Ok(())
}
