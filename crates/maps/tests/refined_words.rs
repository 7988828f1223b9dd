//! Refined maps of impact words against all cells of the finest grid: no stripe of instability, and no band between two, is lost.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test stops at the first surprise")]

use std::path::Path;

use rayon::ThreadPoolBuilder;
use vibrochain_lattice::Stop;
use vibrochain_maps::cell::{Cell, Class};
use vibrochain_maps::scene::Scene;
use vibrochain_maps::sweep::{Ended, Job, refined, sweep};

/// Of a model and words, over frequency and coupling with so many points, halved so often.
fn scene(model: &str, [omega, gamma2]: [[f64; 2]; 2], [columns, rows]: [u32; 2], depth: u32, words: &str) -> Scene {
    let axis = |name: &str, [from, to]: [f64; 2], points: u32| {
        format!("{{ parameter = \"{name}\", from = {from}, to = {to}, points = {points} }}")
    };
    let (x, y) = (axis("omega", omega, columns), axis("gamma2", gamma2, rows));
    let text = format!(
        "[model]\n{model}\n[sweep]\nx = {x}\ny = {y}\nrefine = {{ depth = {depth} }}\n\
         [compute]\nfamilies = [{words}]\nstability = true\n"
    );
    Scene::parse(Path::new("scene.toml"), &text).unwrap()
}

/// A scene's map from leaves and cell by cell.
struct Maps {
    columns: usize,
    leaves: usize,
    refined: Vec<Option<Class>>,
    full: Vec<Option<Class>>,
}

impl Maps {
    fn of(scene: &Scene) -> Self {
        let (pool, stop) = (ThreadPoolBuilder::new().num_threads(2).build().unwrap(), Stop::default());
        let finest = scene.finest();
        let (columns, cells) = (finest.axes[0].points(), finest.cells() as usize);
        let (mut leaves, mut painted) = (0, vec![None; cells]);
        let paint = |some: &[(u64, Cell)]| {
            for (_, cell) in some {
                let extent = cell.extent.unwrap();
                leaves += 1;
                for row in extent.row..extent.row + extent.size {
                    let first = row as usize * columns + extent.column as usize;
                    painted[first..first + extent.size as usize].fill(cell.class);
                }
            }
            Ok::<_, ()>(())
        };
        let all = 0..scene.cells();
        let ended = refined(&Job { scene, pool: &pool, stop: &stop }, std::slice::from_ref(&all), |_| {}, paint);
        assert!(matches!(ended, Ended::Complete(_)));
        let mut full = Vec::new();
        let keep = |_, cells: &[Cell]| {
            full.extend(cells.iter().map(|cell| cell.class));
            Ok::<_, ()>(())
        };
        assert!(matches!(sweep(&finest, &pool, &stop, |_| {}, keep), Ended::Complete(_)));
        Self { columns, leaves, refined: painted, full }
    }

    /// Cells of another class than their leaf. The edge of existence is no stripe: where either is empty does not count.
    fn lost(&self) -> usize {
        let lives = |class: Option<Class>| class.is_some_and(|class| class != Class::None);
        let both = self.refined.iter().zip(&self.full);
        both.filter(|(leaf, cell)| leaf != cell && lives(**leaf) && lives(**cell)).count()
    }

    /// Cells that are unlike both neighbours of their row, which are alike: a stripe thinner than the finest grid shows well.
    fn thin(&self) -> usize {
        let rows = self.full.chunks(self.columns);
        rows.flat_map(|row| row.windows(3)).filter(|cells| cells[0] == cells[2] && cells[1] != cells[0]).count()
    }
}

#[test]
fn every_stripe_and_band_of_the_full_map_is_in_the_refined_one() {
    let (mut thin, mut leaves, mut cells) = (0, 0, 0);
    for (model, words) in [
        ("sites = 6", "\"0+1+,0-1-\""),
        ("sites = 10", "\"0+3+,0-3-\""),
        ("sites = 21", "\"0+1+,0-1-\""),
        ("sites = 5\nends = \"free\"", "\"0+1+,0-1-\""),
        ("sites = 8\nends = \"free\"", "\"3-4-\""),
        ("sites = 4\nlayers = 2\ngamma3 = 0.05", "\"0:0+0:1+,0:0-0:1-\""),
        ("sites = 6", "\"double-sided\", \"0+1+,0-1-\""),
    ] {
        let model = format!("gamma1 = 0.2\nasymmetry = 0.2\n{model}");
        let maps = Maps::of(&scene(&model, [[0.7, 2.5], [0.002, 0.2]], [20, 15], 3, words));
        assert_eq!(maps.lost(), 0, "{model} {words}");
        (thin, leaves, cells) = (thin + maps.thin(), leaves + maps.leaves, cells + maps.full.len());
    }
    println!("{thin} thin cells, {leaves} leaves for {cells} cells");
    // And it is worth it.
    assert!(thin > 500 && leaves < cells / 3, "{thin} {leaves} {cells}");
}

/// The first word is stable in a band while the other one, at both sides of it, is not; and a stripe of the one lies next to where the other
/// takes over. Orders of the best orbit alone lose 28 cells here.
#[test]
fn no_stripe_is_lost_where_one_word_takes_over_from_another() {
    let model = "sites = 5\nends = \"free\"\ngamma1 = 0.05\nasymmetry = 0.191";
    let words = "\"1-3+,1+3-\", \"0-1-3+,0+1+3-\"";
    let maps = Maps::of(&scene(model, [[0.65, 0.95], [0.04, 0.09]], [4, 4], 4, words));
    assert_eq!(maps.lost(), 0);
    assert!(maps.leaves < maps.full.len() / 4, "{}", maps.leaves);
}
