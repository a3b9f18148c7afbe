//! The report of `sinew extract`: a page of sections per region, the muscles on the skin, and a table.

use crate::failure::Failure;
use crate::progress::Progress;
use glam::{DVec2, DVec3};
use sinew::error::{FigureError, OutputError};
use sinew::extract::{
    Extracted, Extraction, body::Body, bump, chain::Section, ellipse::Ellipse, limb::Verdict, muscle::Found,
    section::Surface,
};
use sinew::figures::plot::{Align, INK, Label, PALE, Page, RULE, SERIES, polyline};
use sinew::io::{
    atomic::{FileSet, WholeFile},
    png,
};
use sinew::rig::{Character, Image, roles::Roles};
use std::collections::HashMap;
use std::f64::consts::TAU;
use std::path::Path;

/// The table's name.
pub const TABLE: &str = "muscles.csv";
/// Sections side by side, the pixels that each has, and those of the heading.
const COLUMNS: usize = 8;
const CELL: u32 = 190;
const HEAD: u32 = 46;
/// Points of an ellipse.
const AROUND: usize = 40;
/// Pixels of a picture of the skin along each side.
const SKIN: u32 = 1000;
/// A line farther behind the skin than this, in heights of the body, is hidden.
const BEHIND: f64 = 0.03;

/// Writes the report: `regions` pages of sections, three pictures of the skin, and the table.
pub fn write(folder: &Path, character: &Character, roles: &Roles, extraction: &Extraction) -> Result<usize, Failure> {
    let mut files = FileSet::open(folder).map_err(Failure::input)?;
    let limbs =
        extraction.regions.iter().map(|(region, found)| (character.joints[region.joint as usize].name.clone(), found));
    let sweeps = extraction.sweeps.iter().map(|(sweep, found)| (sweep.title().to_owned(), found));
    let regions: Vec<(String, &Found)> = limbs.chain(sweeps).filter(|(_, found)| !found.sections.is_empty()).collect();
    let views = views(character, roles);
    let progress = Progress::steps("drawing", (regions.len() + views.len()) as u64);
    for (index, (name, found)) in regions.iter().enumerate() {
        let image = page(name, found).map_err(Failure::input)?;
        let letters = name.chars().map(|c| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { '_' });
        let file = format!("{index:02}_{}.png", letters.collect::<String>().trim_matches('_'));
        files.write(&file, |path| put(path, &image)).map_err(Failure::input)?;
        progress.step()?;
    }
    let surface = Surface::new(character);
    for view in &views {
        let image = view.draw(&surface, &extraction.muscles).map_err(Failure::input)?;
        files.write(&format!("skin_{}.png", view.name), |path| put(path, &image)).map_err(Failure::input)?;
        progress.step()?;
    }
    files.write(TABLE, |path| table(path, &extraction.muscles)).map_err(Failure::input)?;
    Ok(files.keep().map_err(Failure::input)?.len())
}

fn put(path: &Path, image: &Image) -> Result<(), OutputError> {
    png::write(path, image.width, image.height, &image.rgba)
}

fn table(path: &Path, muscles: &[Extracted]) -> Result<(), OutputError> {
    let mut file = WholeFile::create(path)?;
    file.put(
        b"muscle,found_by,shapes,degrees,sections,length_m,width_m,alpha,beta,eccentricity,ellipses_off_mm,profile_off_mm,\
          muscle_off_skin_mm,confidence,origin,insertion\n",
    )?;
    for m in muscles {
        let quoted = |text: &str| format!("\"{}\"", text.replace('"', "\"\""));
        let length = m.tips_rest.first().zip(m.tips_rest.last()).map_or(0.0, |(a, b)| a.distance(*b));
        let row = format!(
            "{},{},{},{:.0},{},{length:.4},{:.4},{},{},{:.3},{:.2},{:.2},{:.2},{:.2},{},{}\n",
            quoted(&m.spec.name),
            quoted(&format!("{:?}", m.place)),
            quoted(&m.spec.bone),
            m.degrees,
            m.sections,
            m.width(),
            m.spec.rest.alpha,
            m.spec.rest.beta,
            m.spec.rest.eccentricity,
            m.ellipse_rms * 1e3,
            m.profile_rms * 1e3,
            m.skin_rms * 1e3,
            m.confidence,
            quoted(&m.spec.origin.bone),
            quoted(&m.spec.insertion.bone),
        );
        file.put(row.as_bytes())?;
    }
    file.finish()
}

/// All sections of a region: their triangles, their bumps and the ellipses in them. A muscle has a colour; what was taken for
/// something else is grey.
fn page(name: &str, found: &Found) -> Result<Image, FigureError> {
    let rows = found.sections.len().div_ceil(COLUMNS) as u32;
    let mut page = Page::new(COLUMNS as u32 * CELL, HEAD + rows * CELL)?;
    let muscles = found.bellies.iter().filter(|(_, v)| matches!(v, Verdict::Muscle | Verdict::Marked)).count();
    let title = format!(
        "{name}: {} sections, {} planes without an outline, {} bellies, {muscles} of them muscles",
        found.sections.len(),
        found.rejected,
        found.bellies.len()
    );
    let plain = title.replace('_', " ");
    Label::new(&plain, 17.0).align(Align::Left).draw(&mut page, 14.0, 0.5 * f64::from(HEAD))?;
    let mut of_bump = HashMap::new();
    let mut next = 0;
    for (belly, verdict) in &found.bellies {
        let is_muscle = matches!(verdict, Verdict::Muscle | Verdict::Marked);
        let color = if is_muscle { SERIES[1 + next % (SERIES.len() - 1)] } else { PALE };
        next += usize::from(is_muscle);
        of_bump.extend(belly.links.iter().map(|link| ((link.section, link.bump), color)));
    }
    let middle = |section: &Section| section.outline.iter().sum::<DVec2>() / section.outline.len() as f64;
    let reach = |section: &Section| {
        let middle = middle(section);
        section.outline.iter().map(|p| (*p - middle).abs().max_element()).fold(0.0, f64::max)
    };
    let half = found.sections.iter().map(reach).fold(1e-6, f64::max);
    for (s, section) in found.sections.iter().enumerate() {
        let corner = [(s % COLUMNS) as f64 * f64::from(CELL), f64::from(HEAD) + (s / COLUMNS) as f64 * f64::from(CELL)];
        let (middle, scale) = (middle(section), 0.45 * f64::from(CELL) / half);
        let cell = 0.5 * f64::from(CELL);
        // The plane's first axis, the front, points down.
        let at = |p: DVec2| [corner[0] + cell + (p.y - middle.y) * scale, corner[1] + cell + (p.x - middle.x) * scale];
        draw(&mut page, section, &at, &|bump| of_bump.get(&(s, bump)).copied())?;
        let number = section.number.to_string();
        Label::new(&number, 11.0).color(PALE).draw(&mut page, corner[0] + 12.0, corner[1] + 10.0)?;
    }
    Ok(page.finish())
}

fn draw(
    page: &mut Page,
    section: &Section,
    at: &dyn Fn(DVec2) -> [f64; 2],
    color: &dyn Fn(usize) -> Option<[u8; 3]>,
) -> Result<(), FigureError> {
    let outline = &section.outline;
    let count = outline.len();
    for triangle in bump::triangulate(outline).unwrap_or_default() {
        for k in 0..3 {
            // A side within is two triangles': it is drawn once, and alone, for slivers' corners would be spikes.
            let (a, b) = (triangle[k], triangle[(k + 1) % 3]);
            if a < b {
                polyline(page, &[at(outline[a]), at(outline[b])], RULE, 0.7)?;
            }
        }
    }
    for k in 0..count {
        let ink = if section.bridged[k] { PALE } else { INK };
        polyline(
            page,
            &[at(outline[k]), at(outline[(k + 1) % count])],
            ink,
            if section.bridged[k] { 0.6 } else { 1.2 },
        )?;
    }
    for (b, bump) in section.bumps.iter().enumerate() {
        let Some(color) = color(b) else {
            page.dot(at(outline[bump.tip]), 1.8, PALE)?;
            continue;
        };
        let span = bump.span(count);
        let along: Vec<[f64; 2]> = (0..=span).map(|k| at(outline[(bump.begin + k) % count])).collect();
        polyline(page, &along, color, 2.4)?;
        polyline(page, &round(&section.ellipses[b]).map(at).collect::<Vec<_>>(), color, 1.0)?;
        page.dot(at(outline[bump.tip]), 2.8, color)?;
    }
    Ok(())
}

fn round(ellipse: &Ellipse) -> impl Iterator<Item = DVec2> {
    let (e, way) = (*ellipse, DVec2::from_angle(ellipse.angle));
    (0..=AROUND).map(move |k| {
        let (sin, cos) = (TAU * k as f64 / AROUND as f64).sin_cos();
        e.centre + way * (e.long * cos) + way.perp() * (e.short * sin)
    })
}

/// A direction from which the skin is seen.
struct Seen {
    name: &'static str,
    right: DVec3,
    up: DVec3,
    middle: DVec3,
    /// Pixels a metre.
    scale: f64,
    height: f64,
}

/// Front, back and side; of a character without a front one along each axis.
fn views(character: &Character, roles: &Roles) -> Vec<Seen> {
    let (low, high) = character.bounds_rest();
    let (middle, size) = ((low + high).as_dvec3() * 0.5, (high - low).as_dvec3());
    let (left, up, ahead) = match Body::of(character, roles) {
        Some(body) => (body.left, body.up, body.ahead),
        None => (DVec3::X, DVec3::Y, DVec3::Z),
    };
    let height = size.max_element();
    let seen = |name, right: DVec3| Seen { name, right, up, middle, scale: 0.94 * f64::from(SKIN) / height, height };
    vec![seen("front", left), seen("back", -left), seen("side", -ahead)]
}

impl Seen {
    /// Pixel and nearness of a point.
    fn at(&self, p: DVec3) -> ([f64; 2], f64) {
        let off = p - self.middle;
        let half = 0.5 * f64::from(SKIN);
        (
            [half + off.dot(self.right) * self.scale, half - off.dot(self.up) * self.scale],
            off.dot(self.right.cross(self.up)),
        )
    }

    fn draw(&self, surface: &Surface, muscles: &[Extracted]) -> Result<Image, FigureError> {
        let (rgba, near) = self.shade(surface);
        let mut page = Page::new(SKIN, SKIN)?;
        page.paste(&Image { width: SKIN, height: SKIN, rgba }, 0, 0);
        let shows = |p: DVec3| {
            let ([x, y], depth) = self.at(p);
            let inside = (0.0..f64::from(SKIN)).contains(&x) && (0.0..f64::from(SKIN)).contains(&y);
            inside && depth > near[y as usize * SKIN as usize + x as usize] - BEHIND * self.height
        };
        for (k, muscle) in muscles.iter().enumerate() {
            let color = SERIES[1 + k % (SERIES.len() - 1)];
            for pair in muscle.tips_rest.windows(2).filter(|pair| shows(pair[0]) && shows(pair[1])) {
                polyline(&mut page, &[self.at(pair[0]).0, self.at(pair[1]).0], color, 3.0)?;
            }
            let middle = muscle.tips_rest[muscle.tips_rest.len() / 2];
            if shows(middle) {
                let [x, y] = self.at(middle).0;
                let name = muscle.spec.name.replace('_', " ");
                let label = Label { rimmed: true, ..Label::new(&name, 11.0).align(Align::Left) };
                label.draw(&mut page, x + 4.0, y)?;
            }
        }
        Ok(page.finish())
    }

    /// The skin in light from the upper left, and how near it is at every pixel.
    fn shade(&self, surface: &Surface) -> (Vec<u8>, Vec<f64>) {
        let mut normals = vec![DVec3::ZERO; surface.positions_rest.len()];
        for t in &surface.triangles {
            let [a, b, c] = t.map(|v| surface.positions_rest[v as usize]);
            t.iter().for_each(|&v| normals[v as usize] += (b - a).cross(c - a));
        }
        let light = (self.right * -0.6 + self.up * 0.55 + self.right.cross(self.up) * 0.58).normalize();
        let lit: Vec<f64> = normals.iter().map(|n| n.normalize_or_zero().dot(light).max(0.0) * 0.8 + 0.18).collect();
        let side = SKIN as usize;
        let (mut rgba, mut near) = (vec![255; side * side * 4], vec![f64::NEG_INFINITY; side * side]);
        for t in &surface.triangles {
            let corners = t.map(|v| self.at(surface.positions_rest[v as usize]));
            let [a, b, c] = corners.map(|(p, _)| DVec2::from_array(p));
            let area = (b - a).perp_dot(c - a);
            let (low, high) = (a.min(b).min(c).max(DVec2::ZERO), a.max(b).max(c).min(DVec2::splat(side as f64 - 1.0)));
            if area.abs() < 1e-9 || low.cmpgt(high).any() {
                continue;
            }
            for y in low.y as usize..=high.y.ceil() as usize {
                for x in low.x as usize..=high.x.ceil() as usize {
                    let p = DVec2::new(x as f64, y as f64);
                    let shares =
                        [(c - b).perp_dot(p - b), (a - c).perp_dot(p - c), (b - a).perp_dot(p - a)].map(|s| s / area);
                    let at = y.min(side - 1) * side + x.min(side - 1);
                    let depth: f64 = (0..3).map(|k| shares[k] * corners[k].1).sum();
                    if shares.iter().all(|&s| s >= -1e-9) && depth > near[at] {
                        near[at] = depth;
                        let shade: f64 = (0..3).map(|k| shares[k] * lit[t[k] as usize]).sum();
                        let grey = (shade.clamp(0.0, 1.0).powf(0.8) * 255.0) as u8;
                        rgba[4 * at..4 * at + 3].fill(grey);
                    }
                }
            }
        }
        (rgba, near)
    }
}
