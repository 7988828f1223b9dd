//! A map over frequency and coupling as a vector of cells, the first axis fastest.

use vibrochain::{Class, Scene, Worker};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let text = r#"
        model = { sites = 21, gamma1 = 0.2, asymmetry = 0.4 }
        compute = { families = ["double-sided", "single-sided"], stability = true }
        [sweep]
        x = { parameter = "omega", from = 0.4, to = 3.0, points = 40 }
        y = { parameter = "gamma2", from = 0.0, to = 0.3, points = 30 }
    "#;
    let scene = Scene::parse("map.toml".as_ref(), text)?;
    let (mut worker, mut cells) = (Worker::new(21), Vec::new());
    scene.walk_models(0..scene.cells(), |model| {
        cells.push(worker.cell(model, &scene.task));
        true
    });
    let stable = cells.iter().filter(|cell| cell.class == Some(Class::StableDouble)).count();
    println!("{stable} of {} cells have a stable double-sided breather", cells.len());
    assert_eq!(cells.len(), 1200);
    assert!(stable > 700);
    Ok(())
}
