//! A simulated run that counts, as it goes, how often each mass meets a barrier.

use vibrochain::{EventKind, Limits, Outcome, Point, Simulation, Time};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let point = Point::ring(5).gamma1(0.2).gamma2(0.1).omega(1.5).asymmetry(0.4);
    let model = point.amplitude(0.1).restitution(0.9).model()?;
    let mut simulation = Simulation::new(&model, 0.0, &[0.0; 5], &[2.0, -1.0, 1.5, 0.5, -0.5])?;
    let mut hits = [0; 5];
    let report = simulation.run(&Limits::until(Time::new(&model, 100, 0.0)), |event| {
        if event.kind == EventKind::Impact {
            hits[event.contact] += 1;
        }
    });
    println!("impacts of each mass: {hits:?}; energy at the end: {:?}", simulation.energy());
    assert_eq!(report.outcome, Outcome::TimeReached);
    assert_eq!(hits.iter().sum::<u64>(), report.work.impacts);
    Ok(())
}
