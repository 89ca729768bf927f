use super::*;
use crate::floor::fixed::Floor;
use crate::ground::fixed::Cluster;
use crate::pipeline::{Detection as Found, Hypotheses};
use crate::serial::{Decoder, HOST_BUFFER};
use proptest::prelude::*;

const ORIGIN: Origin = Origin { templates_hash: 0x0102_0304, params_hash: 7 };

fn begin(hypotheses: u8, options: u8) -> FrameBegin {
    FrameBegin {
        frame: 9.into(),
        stamp: (u64::MAX - 1).into(),
        width: 320.into(),
        height: 240.into(),
        depth: 0,
        colour: 0,
        hypotheses,
        options,
    }
}

/// Writes a result and hands what a host reads to `look`.
fn through<T>(report: &Report<Fixed>, begin: &FrameBegin, look: impl FnOnce(&Detections<'_>) -> T) -> T {
    let mut line = Vec::new();
    write_result(report, begin, ORIGIN, 513, &mut |bytes| line.extend_from_slice(bytes));
    let mut decoder = Box::new(Decoder::<HOST_BUFFER>::new());
    let mut bytes = &line[..];
    let packet = decoder.feed(&mut bytes).unwrap().unwrap();
    assert!(bytes.is_empty() && packet.sequence == 513);
    match Answer::parse(&packet).unwrap() {
        Answer::Detections(detections) => look(&detections),
        other => panic!("{other:?}"),
    }
}

/// A report whose numbers all differ, and come close to their limits.
fn report(clusters: usize, detections: usize, hypotheses: usize) -> Report<Fixed> {
    let mut report = Report::new();
    report.floor = Some(Floor { normal: [i32::MIN, -(1 << 30), i32::MAX], height: 1_280_000 });
    let rejections =
        [Rejection::Noise, Rejection::AtBorder, Rejection::TooSmall, Rejection::TooLarge, Rejection::Occluded];
    for i in 0..clusters {
        let n = i as i32;
        let cluster = Cluster {
            pixels: 1,
            bbox: [i as u16, 2, u16::MAX, 4],
            center: [n, -n, i32::MIN],
            size: [n + 1, n + 2, i32::MAX],
            rejection: (i >= detections).then(|| rejections[i % 5]),
            ..Cluster::EMPTY
        };
        report.clusters.push(cluster).unwrap();
    }
    for i in 0..detections {
        let hypothesis = |k: usize| crate::matching::Hypothesis {
            class: k as u16,
            object: i as u16,
            view: u16::MAX,
            distance: 58 << 16,
            score: u32::MAX - k as u32,
        };
        let hypotheses: Hypotheses<Fixed> = (0..hypotheses).map(hypothesis).collect();
        report.detections.push(Found { cluster: i as u16, descriptor: [0; 58], hypotheses }).unwrap();
    }
    report
}

fn check(report: &Report<Fixed>, most: u8, list: bool) {
    let begin = begin(most, if list { LIST_REJECTED } else { 0 });
    through(report, &begin, |read| {
        assert_eq!((read.result.frame.get(), read.result.stamp.get()), (9, u64::MAX - 1));
        assert_eq!((read.result.templates_hash.get(), read.result.params_hash.get()), (0x0102_0304, 7));
        assert_eq!(read.result.version, crate::serial::LIBRARY_VERSION);
        assert_eq!(read.has_floor(), report.floor.is_some());
        let floor = report.floor.unwrap_or(Floor { normal: [0; 3], height: 0 });
        assert_eq!((read.result.normal.map(|v| v.get()), read.result.height.get()), (floor.normal, floor.height));
        assert_eq!(read.iter().count(), report.detections.len());
        assert_eq!(usize::from(read.result.detections.get()), report.detections.len());
        for ((found, hypotheses), truth) in read.iter().zip(&report.detections) {
            let cluster = &report.clusters[usize::from(truth.cluster)];
            assert_eq!(found.id.get(), truth.cluster + 1);
            assert_eq!(found.centre.map(|v| v.get()), cluster.center);
            assert_eq!(found.size.map(|v| v.get()), cluster.size);
            assert_eq!(found.bbox.map(|v| v.get()), cluster.bbox);
            let most = if most == 0 { 5 } else { usize::from(most) };
            assert_eq!(hypotheses.len(), truth.hypotheses.len().min(most));
            for (a, b) in hypotheses.iter().zip(&truth.hypotheses) {
                assert_eq!((a.class.get(), a.object.get(), a.view.get()), (b.class, b.object, b.view));
                assert_eq!((a.distance.get(), a.score.get()), (b.distance, b.score));
            }
        }
        let truth: Vec<_> = report.clusters.iter().enumerate().filter(|(_, c)| c.rejection.is_some()).collect();
        assert_eq!(usize::from(read.result.rejected.get()), truth.len());
        assert_eq!(read.rejected().len(), if list { truth.len() } else { 0 });
        for (a, (i, b)) in read.rejected().iter().zip(truth) {
            assert_eq!((usize::from(a.id.get()), a.centre.map(|v| v.get())), (i + 1, b.center));
            assert_eq!((a.bbox.map(|v| v.get()), reason_name(a.reason)), (b.bbox, b.rejection.unwrap().name()));
        }
    });
}

#[test]
fn the_longest_result_is_read() {
    let report = report(MAX_CLUSTERS, MAX_DETECTIONS, MAX_HYPOTHESES);
    check(&report, 0, true);
    check(&report, 200, true);
    let mut line = 0;
    write_result(&report, &begin(0, LIST_REJECTED), ORIGIN, 0, &mut |bytes| line += bytes.len());
    let candidates = MAX_DETECTIONS * size_of::<Rejected>();
    assert!(line <= packet::wire_size(LONGEST_RESULT - candidates), "{line}");
}

#[test]
fn nothing_found() {
    check(&Report::new(), 0, true);
    // A candidate without a view, and a cluster without pixels.
    let mut report = report(2, 0, 0);
    report.clusters[0].rejection = None;
    report.clusters[1].pixels = 0;
    through(&report, &begin(0, LIST_REJECTED), |read| {
        let [only] = read.rejected() else { panic!("{read:?}") };
        assert_eq!((only.id.get(), only.reason, reason_name(only.reason)), (1, 0, "no view"));
    });
}

#[test]
fn counts_that_do_not_fit_are_refused() {
    let mut payload = vec![0; 44];
    let parse = |payload: &[u8]| {
        Answer::parse(&Packet { kind: kind::DETECTIONS, sequence: 0, payload, checksum: 0 }).map(|_| ())
    };
    assert_eq!(parse(&payload), Ok(()));
    assert_eq!(parse(&payload[..43]), Err(Reject::Payload));
    // Detections that are not there; hypotheses that are not there; bytes behind the last one.
    payload[40] = 1;
    assert_eq!(parse(&payload), Err(Reject::Payload));
    payload.extend([0; 36]);
    assert_eq!(parse(&payload), Ok(()));
    payload[46] = 1;
    assert_eq!(parse(&payload), Err(Reject::Payload));
    payload.extend([0; 14]);
    assert_eq!(parse(&payload), Ok(()));
    payload.push(0);
    assert_eq!(parse(&payload), Err(Reject::Payload));
    // Rejected ones count only where they are listed.
    payload.pop();
    payload[42] = 1;
    assert_eq!(parse(&payload), Ok(()));
    payload[23] = LIST_REJECTED;
    assert_eq!(parse(&payload), Err(Reject::Payload), "{payload:?}");
    payload.extend([0; 24]);
    assert_eq!(parse(&payload), Ok(()));
}

proptest! {
    #[test]
    fn what_was_written_is_read(
        clusters in 0usize..40, detections in 0usize..32, hypotheses in 0usize..=5, most in 0u8..7, list: bool,
    ) {
        check(&report(clusters.max(detections), detections, hypotheses), most, list);
    }

    #[test]
    fn no_payload_is_too_much(kind: u8, payload in proptest::collection::vec(any::<u8>(), 0..200)) {
        let packet = Packet { kind, sequence: 0, payload: &payload, checksum: 0 };
        let _ = crate::serial::Request::parse(&packet);
        if let Ok(Answer::Detections(detections)) = Answer::parse(&packet) {
            prop_assert_eq!(detections.iter().count(), usize::from(detections.result.detections.get()));
        }
    }
}
