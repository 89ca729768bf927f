//! Procedural furniture: twelve classes, every seed another object with sizes as sold.
//!
//! Objects stand on z = 0, centred on x = y = 0, with their front (where a person sits down, opens a door or pulls a
//! drawer) towards +x.

mod bed;
mod bin;
mod cabinet;
mod carton;
mod chair;
mod desk;
mod palette;
mod plant;
mod sofa;
mod stool;
mod swivel_chair;
mod table;

use crate::mesh::Mesh;
use crate::rng::{Rng, derive};

/// First seed of the objects that templates are made from: seeds from here up to [`HELD_OUT_SEEDS`].
pub const TEMPLATE_SEEDS: u64 = 0;

/// First seed of the objects kept for testing: never make a template from one of these or a later seed.
pub const HELD_OUT_SEEDS: u64 = 1000;

/// What kind of object it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Class {
    /// Cardboard box, closed or with open flaps.
    Box,
    /// Four-legged chair with a back, with or without armrests.
    Chair,
    /// Office chair: five-star base with castors, gas column.
    SwivelChair,
    /// Round or square stool on three or four legs, no back.
    Stool,
    /// Table: a top on legs or a column.
    Table,
    /// Sofa for two or three.
    Sofa,
    /// Upholstered chair for one.
    Armchair,
    /// Cabinet or shelf, taller than wide or about so.
    Cabinet,
    /// Waste bin: tapered, open at the top or with a lid.
    Bin,
    /// Plant in a pot.
    Plant,
    /// Bed with mattress and pillows.
    Bed,
    /// Desk with a drawer unit or side panels.
    Desk,
}

impl Class {
    /// All classes.
    pub const ALL: [Self; 12] = [
        Self::Box,
        Self::Chair,
        Self::SwivelChair,
        Self::Stool,
        Self::Table,
        Self::Sofa,
        Self::Armchair,
        Self::Cabinet,
        Self::Bin,
        Self::Plant,
        Self::Bed,
        Self::Desk,
    ];

    /// The class's name as reports and truth files write it.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Box => "box",
            Self::Chair => "chair",
            Self::SwivelChair => "swivel chair",
            Self::Stool => "stool",
            Self::Table => "table",
            Self::Sofa => "sofa",
            Self::Armchair => "armchair",
            Self::Cabinet => "cabinet",
            Self::Bin => "bin",
            Self::Plant => "plant",
            Self::Bed => "bed",
            Self::Desk => "desk",
        }
    }

    /// The class of this name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|class| class.name() == name)
    }

    /// Least and greatest height of the class's objects, in metres.
    #[must_use]
    pub const fn height_range(self) -> [f32; 2] {
        match self {
            Self::Box => [0.20, 0.75],
            Self::Chair => [0.72, 1.10],
            Self::SwivelChair => [0.80, 1.40],
            Self::Stool => [0.40, 0.80],
            Self::Table => [0.65, 0.80],
            Self::Sofa => [0.65, 0.98],
            Self::Armchair => [0.65, 1.12],
            Self::Cabinet => [0.70, 1.35],
            Self::Bin => [0.28, 0.75],
            Self::Plant => [0.55, 1.60],
            Self::Bed => [0.40, 1.20],
            Self::Desk => [0.68, 1.00],
        }
    }
}

/// The object of this class and seed. Seeds below [`HELD_OUT_SEEDS`] are for templates, the others for testing.
#[must_use]
pub fn furniture(class: Class, seed: u64) -> Mesh {
    let mut rng = Rng::new(derive(seed, class as u64));
    let mut mesh = match class {
        Class::Box => carton::build(&mut rng),
        Class::Chair => chair::build(&mut rng),
        Class::SwivelChair => swivel_chair::build(&mut rng),
        Class::Stool => stool::build(&mut rng),
        Class::Table => table::build(&mut rng),
        Class::Sofa => sofa::build(&mut rng, false),
        Class::Armchair => sofa::build(&mut rng, true),
        Class::Cabinet => cabinet::build(&mut rng),
        Class::Bin => bin::build(&mut rng),
        Class::Plant => plant::build(&mut rng),
        Class::Bed => bed::build(&mut rng),
        Class::Desk => desk::build(&mut rng),
    };
    mesh.stand_on_floor();
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_unique_and_found_again() {
        for class in Class::ALL {
            assert_eq!(Class::from_name(class.name()), Some(class));
        }
        assert_eq!(Class::from_name("piano"), None);
    }

    #[test]
    fn objects_stand_on_the_floor_in_their_class_sizes() {
        for class in Class::ALL {
            for seed in (0..24).chain(HELD_OUT_SEEDS..HELD_OUT_SEEDS + 24) {
                let mesh = furniture(class, seed);
                let b = mesh.bounds().unwrap();
                let [low, high] = class.height_range();
                let name = class.name();
                assert!(b.min[2] == 0.0 && (low..=high).contains(&b.max[2]), "{name} {seed}: height {}", b.max[2]);
                assert!((b.min[0] + b.max[0]).abs() < 1e-3 && (b.min[1] + b.max[1]).abs() < 1e-3, "{name} {seed}");
                assert!(b.size()[0] < 2.3 && b.size()[1] < 2.5, "{name} {seed}: {:?}", b.size());
                assert!(mesh.triangles.len() <= 5000, "{name} {seed}: {} triangles", mesh.triangles.len());
                assert!(mesh.triangles.iter().all(|t| usize::from(t.material) < mesh.materials.len()));
            }
        }
    }

    #[test]
    fn eight_seeds_are_eight_objects() {
        for class in Class::ALL {
            let meshes: Vec<Mesh> =
                (0..8).chain(HELD_OUT_SEEDS..HELD_OUT_SEEDS + 8).map(|s| furniture(class, s)).collect();
            for (i, a) in meshes.iter().enumerate() {
                for b in &meshes[..i] {
                    let (sa, sb) = (a.bounds().unwrap().size(), b.bounds().unwrap().size());
                    let difference = (0..3).map(|k| (sa[k] - sb[k]).abs() / sa[k]).fold(0.0, f32::max);
                    assert!(difference > 0.01 || a.triangles.len() != b.triangles.len(), "{}: {sa:?}", class.name());
                }
            }
        }
    }

    #[test]
    fn the_same_seed_is_the_same_object() {
        for class in Class::ALL {
            assert_eq!(furniture(class, 5), furniture(class, 5));
        }
    }
}
