//! The two long bones of a limb, among clavicles, twist joints, metacarpals and fingers.

use super::reach::Tree;
use glam::Vec3;

/// A hand: three branches or more that reach this share of the farthest, all of it shorter than this share of the limb
/// above.
const BRANCH_REACH: f32 = 0.4;
const HAND_REACH: f32 = 0.7;
/// A joint on the way may lie this far off a bone's line, radians, before the bone is taken for two.
const STRAIGHT: f32 = 0.15;
/// What one radian more costs, beside the logarithm of the bones' ratio: in a bone, and between the two.
const BENT_COST: f32 = 2.0;
const HINGE_COST: f32 = 0.4;
/// Fewest chains off a hand, thumb included: one alone is the hand itself.
const FEWEST_DIGITS: usize = 2;
/// A first piece shorter than this share of the bone belongs to the shoulder.
const STUB: f32 = 0.2;
/// Most joints on the way that are tried: a tentacle has hundreds.
const MOST_JOINTS: usize = 24;
/// Joints nearer to the wrist than this share of the lower bone are the palm's.
const PALM: f32 = 0.15;
/// Joints of a digit that bend, its last ones.
const PHALANGES: usize = 3;
/// A thumb starts nearer to the wrist than this share of the others' mean.
const THUMB: f32 = 0.75;

/// A limb.
pub(super) struct Chain {
    pub upper: u32,
    pub lower: u32,
    pub end: Option<u32>,
    pub places: [Vec3; 3],
}

impl Chain {
    /// The limb at or below a joint: of all ways to cut the way to its tip into two bones and an end, the one with the
    /// longest, straightest and most equal bones.
    pub fn below(tree: &Tree, root: u32) -> Option<Chain> {
        let way = way(tree, root);
        let place = |k: usize| tree.places[way[k] as usize];
        // Where the skin ends stands for a last joint that is missing.
        let last = *way.last()?;
        let tip = tree.tips[last as usize].filter(|_| way.len() < 3);
        let points: Vec<Vec3> = (0..way.len()).map(place).chain(tip).collect();
        let mut best: Option<(f32, [usize; 3])> = None;
        for j in 1..points.len().saturating_sub(1).min(way.len()) {
            for i in 0..j {
                for k in j + 1..points.len() {
                    let cost = cost(&points, i, j, k);
                    if cost.is_finite() && best.is_none_or(|(least, _)| cost < least) {
                        best = Some((cost, [i, j, k]));
                    }
                }
            }
        }
        let (_, [i, j, k]) = best?;
        Some(Chain {
            upper: way[i],
            lower: way[j],
            end: way.get(k).copied(),
            places: [points[i], points[j], points[k]],
        })
    }

    /// Fingers or toes, and the thumb: chains of joints off the limb's end, or beside it.
    pub fn digits(&self, tree: &Tree) -> (Vec<Vec<u32>>, Option<Vec<u32>>) {
        let Some(end) = self.end else { return (Vec::new(), None) };
        let [_, elbow, wrist] = self.places;
        let far = |joint: u32| tree.places[joint as usize].distance(wrist);
        let beside = tree.children[self.lower as usize].iter().copied().filter(|&joint| joint != end);
        let mut starts: Vec<u32> = tree.children[end as usize].clone();
        starts.extend(beside.filter(|&joint| far(joint) < 0.5 * elbow.distance(wrist) && !tree.is_above(joint, end)));
        let mut digits: Vec<Vec<u32>> = Vec::new();
        for start in starts {
            let way = std::iter::successors(Some(start), |&joint| tree.next(joint));
            let mut digit: Vec<u32> =
                way.take(MOST_JOINTS).filter(|&joint| far(joint) > PALM * elbow.distance(wrist)).collect();
            digit.drain(..digit.len().saturating_sub(PHALANGES));
            if digit.len() > 1 {
                digits.push(digit);
            }
        }
        if digits.len() < FEWEST_DIGITS {
            return (Vec::new(), None);
        }
        let from_wrist = |digit: &Vec<u32>| far(digit[0]);
        let nearest = (0..digits.len()).min_by(|&a, &b| from_wrist(&digits[a]).total_cmp(&from_wrist(&digits[b])));
        let thumb = nearest.filter(|&t| {
            let others = digits.len() as f32 - 1.0;
            let sum = digits.iter().map(from_wrist).sum::<f32>() - from_wrist(&digits[t]);
            others > 0.0 && from_wrist(&digits[t]) < THUMB * sum / others
        });
        let thumb = thumb.map(|t| digits.remove(t));
        (digits, thumb)
    }
}

/// Joints from the root to the tip that reaches farthest, or to the hand.
fn way(tree: &Tree, root: u32) -> Vec<u32> {
    let (mut way, mut length) = (vec![root], 0.0);
    while let Some(&joint) = way.last() {
        let branches = tree.children[joint as usize].iter();
        let many = branches.filter(|&&b| tree.reach_from(joint, b) > BRANCH_REACH * tree.reach[joint as usize]).count();
        let hand = many > 2 && tree.reach[joint as usize] < HAND_REACH * length;
        let Some(next) = tree.next(joint).filter(|_| !hand && way.len() < MOST_JOINTS) else { break };
        length += tree.places[next as usize].distance(tree.places[joint as usize]);
        way.push(next);
    }
    way
}

/// What speaks against bones between three of the points.
fn cost(points: &[Vec3], i: usize, j: usize, k: usize) -> f32 {
    let lengths = [points[i].distance(points[j]), points[j].distance(points[k])];
    let bent = |from: usize, to: usize| {
        let line = points[to] - points[from];
        let pieces = points[from..=to].windows(2).map(|w| w[1] - w[0]).filter(|piece| piece.length_squared() > 0.0);
        let most = pieces.map(|piece| piece.angle_between(line)).fold(0.0, f32::max);
        (most - STRAIGHT).max(0.0)
    };
    let first = points[i].distance(points[i + 1]);
    // Twist joints may lie on the joint itself.
    let stub = i + 1 < j && first > 1e-3 * lengths[0] && first < STUB * lengths[0];
    if stub || lengths[0] <= 0.0 || lengths[1] <= 0.0 {
        return f32::INFINITY;
    }
    let hinge = (points[j] - points[i]).angle_between(points[k] - points[j]);
    let unequal = (lengths[0] / lengths[1]).ln().abs() - (lengths[0] + lengths[1]).ln();
    unequal + BENT_COST * (bent(i, j) + bent(j, k)) + HINGE_COST * hinge
}
