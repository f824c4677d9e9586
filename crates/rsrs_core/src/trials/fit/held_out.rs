//! How good a sensor is in a polygon, by readings that did not influence where the polygon is.

use super::contour::contour;
use super::detection_rate::{Rate, SensorPoint};
use super::inscribed::{contains, inscribed};

/// Parts into which the readings of each place are dealt.
const N_PARTS: usize = 5;

/// Readings of one place beyond which chance does not influence where the polygon is.
const MANY: u64 = 100_000;

/// How many detections of a place count in a rate: those of parts that the others' polygon holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct HeldOut {
    /// Detections.
    pub detections: u64,
    /// Readings.
    pub samples: u64,
    /// As how many independent readings they count.
    pub independent: f64,
}

/// Counts detections in polygons that other readings drew; `None` if no reading lies in one. Two
/// centres are at least `contact_m` apart.
///
/// A place comes into the polygon because its readings were good, so the same readings make the
/// sensor look better than it is; near 80 % by a lot. So the readings of every place are dealt into
/// five parts; each part is counted where the polygon of the other four goes.
///
/// Parts of a place that some polygons hold and others do not are not independent: a good part
/// draws the others in. For normal shares the variance of what they come to is 1.5 times that of
/// independent readings for a place on the edge, and at most twice; so their readings count half.
///
/// # Source
///
/// M. Stone, "Cross-validatory choice and assessment of statistical predictions", Journal of the Royal
/// Statistical Society B 36, 1974.
pub(super) fn held_out(nodes: &[SensorPoint], contact_m: f64) -> Option<HeldOut> {
    let dealt: Vec<[Count; N_PARTS]> =
        (0..).zip(nodes).map(|(place, node)| deal(node.rate, &mut Shuffle(place))).collect();
    let mut is_inside = vec![[false; N_PARTS]; nodes.len()];
    for part in 0..N_PARTS {
        let others: Vec<SensorPoint> = nodes
            .iter()
            .zip(&dealt)
            .filter_map(|(node, parts)| without(node, parts[part]))
            .collect();
        let polygon_m =
            contour(&others, contact_m).and_then(|contour| inscribed(&contour.corners_m));
        let Some(polygon_m) = polygon_m else { continue };
        for (node, inside) in nodes.iter().zip(&mut is_inside) {
            inside[part] = contains(&polygon_m, node.place_m());
        }
    }
    let mut total = HeldOut { detections: 0, samples: 0, independent: 0.0 };
    for (parts, inside) in dealt.iter().zip(&is_inside) {
        let is_agreed = inside.iter().all(|is_inside| *is_inside);
        for (part, _) in parts.iter().zip(inside).filter(|(_, is_inside)| **is_inside) {
            total.detections += part.detections;
            total.samples += part.samples;
            total.independent += part.samples as f64 * if is_agreed { 1.0 } else { 0.5 };
        }
    }
    (total.samples > 0).then_some(total)
}

#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Count {
    detections: u64,
    samples: u64,
}

/// A place without some of its readings; `None` if none are left.
fn without(node: &SensorPoint, part: Count) -> Option<SensorPoint> {
    let samples = node.rate.samples - part.samples;
    let rate = (samples > 0).then(|| Rate::new(node.rate.detections - part.detections, samples))?;
    Some(SensorPoint { rate, ..*node })
}

/// Deals the readings of a place, in an order that is independent of their values.
fn deal(rate: Rate, shuffle: &mut Shuffle) -> [Count; N_PARTS] {
    let mut parts = [Count::default(); N_PARTS];
    if rate.samples > MANY {
        let n_parts = N_PARTS as u64;
        let share = |whole: u64, part: u64| whole * (part + 1) / n_parts - whole * part / n_parts;
        for (part, count) in (0..).zip(&mut parts) {
            let samples = share(rate.samples, part);
            *count = Count { detections: share(rate.detections, part).min(samples), samples };
        }
        return parts;
    }
    let first = shuffle.below(N_PARTS as u64);
    let mut detections = rate.detections;
    for reading in 0..rate.samples {
        let part = &mut parts[((first + reading) % N_PARTS as u64) as usize];
        part.samples += 1;
        if shuffle.below(rate.samples - reading) < detections {
            part.detections += 1;
            detections -= 1;
        }
    }
    parts
}

/// Numbers that are the same each time and for each place others.
///
/// # Source
///
/// G. L. Steele, D. Lea, C. H. Flood, "Fast splittable pseudorandom number generators", OOPSLA 2014:
/// `SplitMix64`.
struct Shuffle(u64);

impl Shuffle {
    /// A whole number below a limit of at most 2^32.
    fn below(&mut self, limit: u64) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut mixed = self.0;
        mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (((mixed ^ (mixed >> 31)) >> 32) * limit) >> 32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_reading_is_dealt_once_and_chance_decides_to_which_part() {
        for (detections, samples) in [(0, 1), (1, 1), (37, 40), (80_000, 100_000), (7, 200_003)] {
            let parts = deal(Rate::new(detections, samples), &mut Shuffle(3));

            assert_eq!(parts.iter().map(|part| part.samples).sum::<u64>(), samples);
            assert_eq!(parts.iter().map(|part| part.detections).sum::<u64>(), detections);
            assert!(parts.iter().all(|part| part.detections <= part.samples), "{parts:?}");
            let sizes = parts.map(|part| part.samples);
            assert!(sizes.iter().max().unwrap() - sizes.iter().min().unwrap() <= 1, "{sizes:?}");
        }
        // Of 8 readings in a part, 6 detect on average, with a variance of 8 * 3/4 * 1/4 * 32/39.
        let found: Vec<f64> = (0..2000)
            .map(|place| deal(Rate::new(30, 40), &mut Shuffle(place))[2].detections as f64)
            .collect();
        let mean = found.iter().sum::<f64>() / 2000.0;
        let variance = found.iter().map(|n| (n - mean) * (n - mean)).sum::<f64>() / 1999.0;
        assert!((mean - 6.0).abs() < 0.1 && (variance - 1.23).abs() < 0.15, "{mean} {variance}");
    }
}
