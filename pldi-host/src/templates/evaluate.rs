//! How well a template set tells its own classes apart: each view is a query against the views of all other objects
//! (paper, section 6, ModelNet10).

use pldi_core::matching::{canberra, fixed};
use pldi_core::templates::{Encoding, Templates};

use crate::parallel;

/// How often each class was taken for each.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Confusion {
    /// Names of the classes.
    pub classes: Vec<String>,
    /// `counts[truth][answer]`.
    pub counts: Vec<Vec<u32>>,
}

impl Confusion {
    /// An empty matrix.
    pub fn new(classes: Vec<String>) -> Self {
        let n = classes.len();
        Self { classes, counts: vec![vec![0; n]; n] }
    }

    /// Of the answers with this class, the share that is right; `None` without an answer.
    pub fn precision(&self, class: usize) -> Option<f64> {
        let answers: u32 = self.counts.iter().map(|row| row[class]).sum();
        (answers > 0).then(|| f64::from(self.counts[class][class]) / f64::from(answers))
    }

    /// Of the queries of this class, the share that is right; `None` without a query.
    pub fn recall(&self, class: usize) -> Option<f64> {
        let queries: u32 = self.counts[class].iter().sum();
        (queries > 0).then(|| f64::from(self.counts[class][class]) / f64::from(queries))
    }

    /// Macro averages of precision and recall over the classes that have queries. A class that is never answered has a
    /// precision of 0.
    pub fn macro_averages(&self) -> (f64, f64) {
        let asked: Vec<usize> = (0..self.classes.len()).filter(|c| self.recall(*c).is_some()).collect();
        let mean = |f: &dyn Fn(usize) -> Option<f64>| {
            asked.iter().map(|c| f(*c).unwrap_or(0.0)).sum::<f64>() / asked.len().max(1) as f64
        };
        (mean(&|c| self.precision(c)), mean(&|c| self.recall(c)))
    }
}

impl std::fmt::Display for Confusion {
    /// A table: a row per true class, a column per answer, precision and recall.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let width = self.classes.iter().map(|c| c.chars().count()).max().unwrap_or(0).max(9);
        write!(f, "{:width$}", "")?;
        for i in 0..self.classes.len() {
            write!(f, "{:>6}", format!("[{i}]"))?;
        }
        writeln!(f, "   recall  precision")?;
        for (i, name) in self.classes.iter().enumerate() {
            write!(f, "{name:width$}")?;
            for count in &self.counts[i] {
                write!(f, "{count:>6}")?;
            }
            let percent = |v: Option<f64>| v.map_or("-".to_owned(), |v| format!("{:.1}", 100.0 * v));
            writeln!(f, "   {:>6}  {:>9}  [{i}]", percent(self.recall(i)), percent(self.precision(i)))?;
        }
        let (precision, recall) = self.macro_averages();
        write!(f, "macro averages: precision {:.1} %, recall {:.1} %", 100.0 * precision, 100.0 * recall)
    }
}

/// Takes every template as a query against the templates of all other objects. Templates of one object stand together, as
/// the writer puts them.
pub fn leave_one_object_out(set: &Templates<'_>, threads: usize) -> Confusion {
    match set.encoding() {
        Encoding::Float => {
            let all: Vec<_> = set.iter().map(|t| t.descriptor()).collect();
            ask(set, threads, |a, b| canberra(&all[a], &all[b]))
        }
        Encoding::Logarithmic => {
            let all: Vec<_> = set.iter().map(|t| t.codes()).collect();
            ask(set, threads, |a, b| fixed::canberra(&all[a], &all[b]))
        }
    }
}

/// The queries, by any distance between the templates of two indices.
fn ask<D: PartialOrd>(set: &Templates<'_>, threads: usize, distance: impl Fn(usize, usize) -> D + Sync) -> Confusion {
    let all: Vec<(u16, u16)> = set.iter().map(|t| (t.class(), t.object())).collect();
    let mut confusion = Confusion::new(set.classes().map(str::to_owned).collect());
    let answers = parallel::map_ordered(
        all.len(),
        threads,
        || (),
        |(), i| {
            let mut best: Option<(D, u16)> = None;
            for (j, (class, _)) in all.iter().enumerate().filter(|(_, (_, object))| *object != all[i].1) {
                let distance = distance(i, j);
                if best.as_ref().is_none_or(|(least, _)| distance < *least) {
                    best = Some((distance, *class));
                }
            }
            Ok::<_, std::convert::Infallible>(best.map(|(_, class)| class))
        },
    );
    let Ok(answers) = answers;
    for ((class, _), answer) in all.iter().zip(answers) {
        if let Some(answer) = answer {
            confusion.counts[usize::from(*class)][usize::from(answer)] += 1;
        }
    }
    confusion
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn averages_are_over_classes_not_queries() {
        let mut c = Confusion::new(["a", "b", "c"].map(str::to_owned).to_vec());
        c.counts = vec![vec![8, 2, 0], vec![0, 1, 0], vec![0, 0, 0]];
        assert_eq!((c.recall(0), c.recall(1), c.recall(2)), (Some(0.8), Some(1.0), None));
        let (p, r) = c.macro_averages();
        assert!((p - (1.0 + 1.0 / 3.0) / 2.0).abs() < 1e-12 && (r - 0.9).abs() < 1e-12);
        assert!(c.to_string().ends_with("macro averages: precision 66.7 %, recall 90.0 %"));
    }
}
