//! What stands in an SVG of a picture: its words and lines with their places.

/// Words and where their first letter stands.
pub fn texts(svg: &str) -> Vec<((f64, f64), String)> {
    let text = |tag: &str| {
        let words = tag.split('"').next()?;
        let (x, y) = tag.split("translate(").nth(1)?.split(')').next()?.split_once(' ')?;
        let plain = words.replace("&lt;", "<").replace("&gt;", ">").replace("&quot;", "\"").replace("&amp;", "&");
        Some(((x.parse().ok()?, y.parse().ok()?), plain))
    };
    svg.split("<g aria-label=\"").skip(1).filter_map(text).collect()
}

/// The points of all lines whose attributes contain `style`.
pub fn lines(svg: &str, style: &str) -> Vec<Vec<(f64, f64)>> {
    let mut all = Vec::new();
    for tag in svg.split("<path").skip(1) {
        let tag = tag.split('>').next().unwrap_or_default();
        let Some(commands) = tag.split(" d=\"").nth(1).and_then(|d| d.split('"').next()) else { continue };
        if !tag.contains(style) {
            continue;
        }
        for line in commands.split('M').skip(1) {
            let point = |text: &str| text.split_once(' ').and_then(|(x, y)| Some((x.parse().ok()?, y.parse().ok()?)));
            all.push(line.trim_end_matches('Z').split('L').filter_map(point).collect());
        }
    }
    all
}

/// The ticks along x and y: where each stands along its axis, the place of its axis, and its number.
pub fn ticks(svg: &str) -> [Vec<(f64, f64, f64)>; 2] {
    let numbers: Vec<((f64, f64), f64)> = texts(svg)
        .into_iter()
        .filter_map(|(place, text)| Some((place, text.replace('−', "-").parse().ok()?)))
        .collect();
    let nearest = |x: f64, y: f64| {
        let far = |place: &(f64, f64)| (place.0 - x).hypot(place.1 - y);
        let near = numbers.iter().min_by(|a, b| far(&a.0).total_cmp(&far(&b.0)))?;
        (far(&near.0) < 60.0).then_some(near.1)
    };
    let mut ticks = [Vec::new(), Vec::new()];
    for line in lines(svg, "stroke=\"#000000\" stroke-width=\"1\"") {
        let [(x0, y0), (x1, y1)] = line[..] else { continue };
        let short = (x1 - x0).hypot(y1 - y0) < 8.0;
        if short && x0 == x1 {
            ticks[0].extend(nearest(x0 - 8.0, y1 + 14.0).map(|number| (x0, y0, number)));
        } else if short && y0 == y1 {
            ticks[1].extend(nearest(x0 - 20.0, y0 + 5.0).map(|number| (y0, x1, number)));
        }
    }
    ticks
}
