//! A chain that moves, as an SVG that does so by itself.

use std::fmt::Write;

use crate::backend::svg::{hex, number, with_elements};
use crate::map::palette::LINES;
use crate::moving::backdrop::{Backdrop, HIT, JOINED};
use crate::moving::motion::RATE;

impl Backdrop<'_> {
    /// The bytes of the file.
    pub(crate) fn svg(&self) -> Vec<u8> {
        let instants = &self.picture.instants;
        let seconds = number(instants.len() as f64 / RATE);
        let moves = |name: &str, mode: &str, values: String| {
            format!(
                "<animate attributeName=\"{name}\" dur=\"{seconds}s\" repeatCount=\"indefinite\"{mode} values=\"{values}\"/>"
            )
        };
        // The last value is the first again, so that nothing jumps that does not.
        let over_time = |value: &dyn Fn(usize) -> String| {
            (0..=instants.len()).map(|at| value(at % instants.len())).collect::<Vec<_>>().join(";")
        };
        let place = |at: usize, mass: usize| {
            self.place(mass, instants[at].displacement.get(mass).copied().unwrap_or(0.0)).unwrap_or([0.0; 2])
        };
        let tenth = |value: f64| number((10.0 * value).round() / 10.0);
        let mut text = String::new();
        if self.picture.length <= JOINED {
            for row in self.rows() {
                let points = |at: usize| {
                    let place = |mass: &usize| place(at, *mass).map(tenth).join(",");
                    row.iter().map(place).collect::<Vec<_>>().join(" ")
                };
                let (colour, moving) = (hex(LINES[5]), moves("points", "", over_time(&points)));
                let _ = writeln!(
                    text,
                    "<polyline fill=\"none\" stroke=\"{colour}\" points=\"{}\">{moving}</polyline>",
                    points(0)
                );
            }
        }
        for impact in self.impacts() {
            let Some([x, y]) = self.barrier(impact).map(|place| place.map(number)) else { continue };
            let glow = over_time(&|at| number(self.glow(at, impact)));
            let (colour, radius) = (hex(HIT), number(self.radius + self.page.px(4.0)));
            let moving = moves("opacity", " calcMode=\"discrete\"", glow);
            let _ = writeln!(
                text,
                "<circle cx=\"{x}\" cy=\"{y}\" r=\"{radius}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"3\" opacity=\"0\">{moving}</circle>"
            );
        }
        for mass in 0..instants[0].displacement.len() {
            let [x, y] = place(0, mass).map(number);
            let moving = moves("cy", "", over_time(&|at| tenth(place(at, mass)[1])));
            let (colour, radius) = (hex(LINES[0]), number(self.radius));
            let _ = writeln!(text, "<circle cx=\"{x}\" cy=\"{y}\" r=\"{radius}\" fill=\"{colour}\">{moving}</circle>");
        }
        let [from, to, y] = self.clock.map(number);
        let moving = moves("x2", "", format!("{from};{to}"));
        let colour = hex(LINES[1]);
        let _ = writeln!(
            text,
            "<line x1=\"{from}\" y1=\"{y}\" x2=\"{from}\" y2=\"{y}\" stroke=\"{colour}\" stroke-width=\"2\">{moving}</line>"
        );
        with_elements(&self.background, &text)
    }
}
