#![allow(clippy::unwrap_used)]
use vibrochain_breather::{End, Finder, Found, Wanted, Word};
use vibrochain_lattice::{Chain, Model};
use vibrochain_testkit::Random;
#[test]
fn lost() {
    let mut random = Random(17);
    let (mut finder, mut found) = (Finder::new(9), Found::default());
    let (mut all, mut lost, mut came) = (0, 0, 0);
    let mut counts = std::collections::BTreeMap::new();
    for round in 0..1400 {
        let gamma2 = random.between(0.05, 0.4);
        let chain = Chain::new(9, random.between(0.05, 0.6), gamma2).unwrap();
        let (omega, asymmetry) = (random.between(0.5, 2.0), random.between(0.0, 0.8));
        let (amplitude, restitution) = (random.between(0.02, 0.6), random.between(0.2, 0.99));
        let model = Model::forced(chain, omega, asymmetry, amplitude, restitution).unwrap();
        let word: Word =
            ["0+3+,0-3-", "0-,2-", "0-2-", "0+,4-,0-", "0+1-,0-1+", "0+", "0-,3+"][round % 7].parse().unwrap();
        if finder.find_word(&model, &word, Wanted::All, &mut found).is_err() { continue; }
        came += found.orbits.len();
        for ended in &found.ended {
            all += 1;
            let kind = format!("{:?}", ended.by);
            *counts.entry(kind.split(|c: char| !c.is_alphabetic()).next().unwrap().to_owned()).or_insert(0) += 1;
            if matches!(ended.by, End::Lost) { lost += 1; println!("LOST {round} {word} at {} of {gamma2}: {model}", ended.value); }
        }
    }
    println!("{all} ended, {lost} lost, {came} came; {counts:?}");
}
