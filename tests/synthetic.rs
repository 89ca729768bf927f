//! A reduced trial on generated rooms with held-out objects: what the embedded templates are worth end to end.

use pldi_core::Params;
use pldi_core::templates::Templates;
use pldi_host::ArithmeticKind::{Fixed, Float};
use pldi_host::templates::{EMBEDDED, for_arithmetic};
use pldi_host::trial::{Sighting, Trial};

#[test]
fn held_out_furniture_in_generated_rooms_is_found_and_recognised() {
    let templates = Templates::parse(EMBEDDED).unwrap();
    let params = Params { view: *templates.view_params(), ..Params::DEFAULT };
    let trial = Trial { rooms: 20, ..Trial::default() };
    let outcome = trial.run(Float, &params, &templates, 2, || true).unwrap();
    let classes: Vec<String> = templates.classes().map(str::to_owned).collect();
    let confusion = outcome.confusion(&classes);
    println!("{confusion}\nfound {:.1} %, {} strays", 100.0 * outcome.found_share(), outcome.strays);
    for class in &classes {
        let sightings = outcome.sightings.iter().filter(|s| s.verdict.truth.class == *class).count();
        assert!(sightings >= 5, "{class}: {sightings} sightings");
    }
    let (precision, recall) = confusion.macro_averages();
    assert!(precision >= 0.8 && recall >= 0.8, "precision {precision:.3}, recall {recall:.3}");
    assert!(outcome.found_share() >= 0.95, "found {:.3}", outcome.found_share());
}

#[test]
fn integers_see_and_say_what_floats_do() {
    let trial = Trial { rooms: 6, frames: 8, seed: 3 };
    let [float, fixed] = [Float, Fixed].map(|arithmetic| {
        let bytes = for_arithmetic(EMBEDDED.into(), arithmetic).unwrap();
        let templates = Templates::parse(&bytes).unwrap();
        let params = Params { view: *templates.view_params(), ..Params::DEFAULT };
        trial.run(arithmetic, &params, &templates, 2, || true).unwrap()
    });
    assert_eq!((float.frames, float.sightings.len()), (fixed.frames, fixed.sightings.len()));
    let class = |s: &Sighting| s.verdict.answer.as_ref().map(|(class, _)| class.clone());
    let same = float.sightings.iter().zip(&fixed.sightings).filter(|(a, b)| class(a) == class(b)).count();
    let all = float.sightings.len();
    assert!(
        all >= 30 && 20 * same >= 19 * all && float.strays.abs_diff(fixed.strays) <= 2,
        "{same} of {all} are alike"
    );
    assert!(fixed.found_share() >= 0.95, "found {:.3}", fixed.found_share());
}

#[test]
fn a_trial_does_not_depend_on_the_number_of_threads() {
    let templates = Templates::parse(EMBEDDED).unwrap();
    let params = Params { view: *templates.view_params(), ..Params::DEFAULT };
    let trial = Trial { rooms: 3, frames: 2, seed: 5 };
    let run = |threads| trial.run(Float, &params, &templates, threads, || true).unwrap();
    assert_eq!(run(1), run(3));
    assert!(matches!(trial.run(Float, &params, &templates, 2, || false), Err(pldi_host::Error::Interrupted)));
}
