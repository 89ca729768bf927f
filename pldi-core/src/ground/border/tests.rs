use super::*;
use proptest::prelude::*;

type Grid = std::vec::Vec<std::vec::Vec<u8>>;

/// Runs the border following on a drawing placed with its corner at (column, row).
fn found(drawing: &[&str], column: usize, row: usize) -> Found {
    let mut density = boxed(0.0f32);
    for (y, line) in drawing.iter().enumerate() {
        for (x, c) in line.bytes().enumerate() {
            density[row + y][column + x] = if c == b'#' { 1.0 } else { 0.0 };
        }
    }
    run(&density).unwrap()
}

fn boxed<T: Copy>(value: T) -> Box<Map<T>> {
    vec![[value; MAP_WIDTH]; MAP_DEPTH].into_boxed_slice().try_into().ok().unwrap()
}

type Found = (std::vec::Vec<Contour>, std::vec::Vec<ContourPoint>, Box<Map<u8>>);

fn run(density: &Map<f32>) -> Result<Found, Error> {
    let (mut marks, mut labels) = (boxed(0u8), boxed(0u8));
    let (mut contours, mut points) = (Vec::new(), vec![ContourPoint::default(); MAX_CONTOUR_POINTS]);
    crate::ground::density::occupied(density, 0.5, &mut marks);
    find(&mut marks, &mut labels, &mut contours, &mut points)?;
    points.truncate(point_count(&contours));
    Ok((contours.to_vec(), points, labels))
}

#[test]
fn a_square_has_its_area_and_length() {
    let (contours, points, _) = found(&["####", "####", "####"], 100, 50);
    assert_eq!(contours.len(), 1);
    assert_eq!((contours[0].cells, contours[0].points), (12, 10));
    assert!((contours[0].length() - 10.0 * CELL).abs() < 1e-6);
    assert_eq!(points[0], ContourPoint { column: 100, row: 50 });
}

#[test]
fn regions_at_every_edge_of_the_map_are_found() {
    for (column, row) in [(0, 0), (0, 90), (MAP_WIDTH - 3, 7), (9, MAP_DEPTH - 2), (MAP_WIDTH - 3, MAP_DEPTH - 2)] {
        let (contours, _, labels) = found(&["###", "###"], column, row);
        assert_eq!(contours.len(), 1, "{column} {row}");
        assert_eq!(contours[0].cells, 6);
        assert_eq!(labels[row][column], 1);
    }
}

#[test]
fn single_cells_and_thin_lines() {
    let (contours, ..) = found(&["#...#", ".....", "..#.."], 10, 10);
    assert_eq!(
        contours.iter().map(|c| (c.cells, c.points, c.length())).collect::<std::vec::Vec<_>>(),
        [(1, 1, 0.0); 3]
    );
    let (contours, ..) = found(&["#...", ".#..", "..#.", "...#"], 10, 10);
    assert_eq!((contours.len(), contours[0].cells, contours[0].points), (1, 4, 6));
}

#[test]
fn holes_and_what_lies_in_them_belong_to_the_outer_border() {
    let (contours, _, labels) = found(&["#######", "#.....#", "#.#.#.#", "#.....#", "#######"], 30, 40);
    assert_eq!(contours.len(), 1);
    assert_eq!(contours[0].cells, 35);
    assert!((40..45).all(|r| (30..37).all(|c| labels[r][c] == 1)));
}

#[test]
fn an_open_bay_is_outside() {
    let (contours, _, labels) = found(&["#####", "#...#", "#.#.#", "#...."], 30, 40);
    assert_eq!(contours.len(), 2);
    assert_eq!((contours[0].cells, contours[1].cells), (10, 1));
    assert_eq!((labels[41][31], labels[42][32]), (0, 2));
}

#[test]
fn too_many_regions_name_the_capacity() {
    let mut density = boxed(0.0f32);
    for i in 0..=MAX_CLUSTERS {
        density[2 * (i / 100)][2 * (i % 100)] = 1.0;
    }
    assert_eq!(run(&density).err(), Some(Error::Capacity("clusters")));
}

#[test]
fn too_long_borders_name_the_capacity() {
    let mut density = boxed(0.0f32);
    for row in (0..MAP_DEPTH).step_by(2) {
        density[row].fill(1.0);
        density[row + 1][0] = 1.0;
    }
    assert_eq!(run(&density).err(), Some(Error::Capacity("contour points")));
}

/// What is not reached from outside through empty cells (4-connected): regions with their holes filled.
fn filled(grid: &Grid) -> Grid {
    let (h, w) = (grid.len() + 2, grid[0].len() + 2);
    let mut outside = vec![vec![false; w]; h];
    let mut stack = vec![(0, 0)];
    while let Some((x, y)) = stack.pop() {
        let empty = x == 0 || y == 0 || x == w - 1 || y == h - 1 || grid[y - 1][x - 1] == 0;
        if !empty || outside[y][x] {
            continue;
        }
        outside[y][x] = true;
        if x > 0 {
            stack.push((x - 1, y));
        }
        if y > 0 {
            stack.push((x, y - 1));
        }
        if x < w - 1 {
            stack.push((x + 1, y));
        }
        if y < h - 1 {
            stack.push((x, y + 1));
        }
    }
    (1..h - 1).map(|y| (1..w - 1).map(|x| u8::from(!outside[y][x])).collect()).collect()
}

/// Number of 8-connected regions.
fn regions(grid: &Grid) -> usize {
    let mut grid = grid.clone();
    let mut count = 0;
    for y in 0..grid.len() {
        for x in 0..grid[0].len() {
            let mut stack = vec![(x as i32, y as i32)];
            count += usize::from(grid[y][x] != 0);
            while let Some((x, y)) = stack.pop() {
                if x < 0
                    || y < 0
                    || y as usize >= grid.len()
                    || x as usize >= grid[0].len()
                    || grid[y as usize][x as usize] == 0
                {
                    continue;
                }
                grid[y as usize][x as usize] = 0;
                stack.extend(STEPS.map(|(dx, dy)| (x + dx, y + dy)));
            }
        }
    }
    count
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    /// Against a flood fill: the same regions, the same cells.
    #[test]
    fn labels_are_the_regions_with_their_holes_filled(
        grid in proptest::collection::vec(proptest::collection::vec(prop_oneof![2 => Just(0u8), 3 => Just(1u8)], 14), 11),
        column in prop_oneof![Just(0usize), Just(MAP_WIDTH - 14), Just(77)],
        row in prop_oneof![Just(0usize), Just(MAP_DEPTH - 11), Just(60)],
    ) {
        let mut density = boxed(0.0f32);
        for y in 0..11 {
            for x in 0..14 {
                density[row + y][column + x] = f32::from(grid[y][x]);
            }
        }
        let (contours, _, labels) = run(&density).unwrap();
        let filled = filled(&grid);
        prop_assert_eq!(contours.len(), regions(&filled));
        for y in 0..11 {
            for x in 0..14 {
                prop_assert_eq!(labels[row + y][column + x] != 0, filled[y][x] != 0, "{} {}", x, y);
            }
        }
        let cells: u32 = contours.iter().map(|c| c.cells).sum();
        prop_assert_eq!(cells as usize, filled.iter().flatten().filter(|v| **v != 0).count());
    }
}
