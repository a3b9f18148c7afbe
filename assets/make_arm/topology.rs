//! Which vertex is joined to which: rings along the arm that divide into a thumb and four fingers.
//!
//! Everything counts in multiples of a fineness `m`. A ring of the arm has `28 m` columns. In the hand, columns
//! `-m..=m` are the thumb's side, `m..=13 m` the palm, `13 m..=15 m` the little finger's side, `15 m..=27 m` the
//! back; each finger takes `3 m` columns of the palm and as many of the back, and webs of `2 m` edges part them.
//! The thumb grows out of a hole of `2 m` by `2 m` cells in its side of the palm, columns 0 to `2 m`.

use std::collections::BTreeMap;

/// How fine the mesh is.
#[derive(Clone, Copy, Debug)]
pub struct Fineness {
    /// The multiple: 1 or more.
    pub m: usize,
    /// Rings from the shoulder's pole to the webs of the fingers.
    pub rings: usize,
    /// First ring of the thumb's hole.
    pub thumb_ring: usize,
    /// Rings of the thumb and of every finger beyond its root.
    pub digit_rings: [usize; 5],
}

impl Fineness {
    /// Vertices of one ring of the arm.
    pub fn columns(&self) -> usize {
        28 * self.m
    }
}

/// What a vertex is, for the one who places it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// The pole of the shoulder.
    Shoulder,
    /// On a ring of arm or palm.
    Ring {
        /// Counted from the shoulder.
        ring: usize,
        /// Counted from the thumb's side over the palm.
        column: usize,
    },
    /// Between two fingers, from the palm's side to the back.
    Web {
        /// The digit on its thumb's side: 1 to 3.
        finger: usize,
        /// 1 to `2 m - 1`.
        step: usize,
    },
    /// On a ring of a digit.
    Digit {
        /// 0 is the thumb.
        digit: usize,
        /// Counted from the root.
        ring: usize,
        /// Counted along the root's loop.
        index: usize,
    },
    /// The tip of a digit.
    Tip {
        /// 0 is the thumb.
        digit: usize,
    },
}

/// The joined vertices.
pub struct Topology {
    /// What every vertex is.
    pub places: Vec<Place>,
    /// Counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Edges that split a cell in two.
    pub diagonals: Vec<[u32; 2]>,
    /// Per digit the closed loop that it grows from.
    pub roots: [Vec<u32>; 5],
}

/// Joins the vertices for a fineness.
pub fn build(fineness: &Fineness) -> Topology {
    let mut builder = Builder {
        fineness: *fineness,
        places: Vec::new(),
        ring_vertex: BTreeMap::new(),
        triangles: Vec::new(),
        diagonals: Vec::new(),
    };
    builder.places.push(Place::Shoulder);
    builder.limb();
    let webs = builder.webs();
    let roots =
        std::array::from_fn(|digit| if digit == 0 { builder.thumb_root() } else { builder.finger_root(digit, &webs) });
    for (digit, root) in roots.iter().enumerate() {
        builder.digit(digit, root);
    }
    Topology { places: builder.places, triangles: builder.triangles, diagonals: builder.diagonals, roots }
}

struct Builder {
    fineness: Fineness,
    places: Vec<Place>,
    ring_vertex: BTreeMap<(usize, usize), u32>,
    triangles: Vec<[u32; 3]>,
    diagonals: Vec<[u32; 2]>,
}

impl Builder {
    fn add(&mut self, place: Place) -> u32 {
        self.places.push(place);
        self.places.len() as u32 - 1
    }

    fn at(&self, ring: usize, column: usize) -> u32 {
        self.ring_vertex[&(ring, column % self.fineness.columns())]
    }

    /// Whether a cell (from its ring to the next, from its column to the next) lies in the thumb's hole.
    fn in_hole(&self, ring: usize, column: usize) -> bool {
        let Fineness { m, thumb_ring, .. } = self.fineness;
        (thumb_ring..thumb_ring + 2 * m).contains(&ring) && column < 2 * m
    }

    /// Two triangles between two neighbouring pairs; `near` is the pair closer to the shoulder.
    fn cell(&mut self, near: [u32; 2], far: [u32; 2]) {
        self.triangles.push([near[0], near[1], far[1]]);
        self.triangles.push([near[0], far[1], far[0]]);
        self.diagonals.push([near[0], far[1]]);
    }

    fn limb(&mut self) {
        let columns = self.fineness.columns();
        let inside_hole = |builder: &Builder, ring: usize, column: usize| {
            let before = (column + columns - 1) % columns;
            ring > 0
                && [(ring - 1, before), (ring - 1, column), (ring, before), (ring, column)]
                    .iter()
                    .all(|&(r, c)| builder.in_hole(r, c))
        };
        for ring in 0..self.fineness.rings {
            for column in 0..columns {
                if !inside_hole(self, ring, column) {
                    let vertex = self.add(Place::Ring { ring, column });
                    self.ring_vertex.insert((ring, column), vertex);
                }
            }
        }
        for column in 0..columns {
            self.triangles.push([0, self.at(0, column + 1), self.at(0, column)]);
        }
        for ring in 0..self.fineness.rings - 1 {
            for column in 0..columns {
                if !self.in_hole(ring, column) {
                    let near = [self.at(ring, column), self.at(ring, column + 1)];
                    let far = [self.at(ring + 1, column), self.at(ring + 1, column + 1)];
                    self.cell(near, far);
                }
            }
        }
    }

    /// Inner vertices of the three webs, each from the palm's side to the back.
    fn webs(&mut self) -> [Vec<u32>; 3] {
        let steps = 2 * self.fineness.m;
        [1, 2, 3].map(|finger| (1..steps).map(|step| self.add(Place::Web { finger, step })).collect())
    }

    /// Palm from thumb's to little finger's side, web, back, web: the way that columns run.
    fn finger_root(&self, finger: usize, webs: &[Vec<u32>; 3]) -> Vec<u32> {
        let Fineness { m, rings, .. } = self.fineness;
        let columns = self.fineness.columns();
        let last = rings - 1;
        let (from, to) = (m + 3 * m * (finger - 1), m + 3 * m * finger);
        let mut root: Vec<u32> = (from..=to).map(|c| self.at(last, c)).collect();
        match finger {
            4 => root.extend((13 * m + 1..15 * m).map(|c| self.at(last, c))),
            _ => root.extend(&webs[finger - 1]),
        }
        root.extend((columns - to..=columns - from).map(|c| self.at(last, c)));
        match finger {
            1 => root.extend((columns - m + 1..columns + m).map(|c| self.at(last, c))),
            _ => root.extend(webs[finger - 2].iter().rev()),
        }
        root
    }

    /// The rim of the thumb's hole, counter-clockwise seen from outside.
    fn thumb_root(&self) -> Vec<u32> {
        let Fineness { m, thumb_ring: first, .. } = self.fineness;
        let side = 2 * m;
        let mut rim: Vec<u32> = (0..side).map(|i| self.at(first, i)).collect();
        rim.extend((0..side).map(|i| self.at(first + i, side)));
        rim.extend((0..side).map(|i| self.at(first + side, side - i)));
        rim.extend((0..side).map(|i| self.at(first + side - i, 0)));
        rim
    }

    fn digit(&mut self, digit: usize, root: &[u32]) {
        let count = root.len();
        let mut near = root.to_vec();
        for ring in 0..self.fineness.digit_rings[digit] {
            let far: Vec<u32> = (0..count).map(|index| self.add(Place::Digit { digit, ring, index })).collect();
            for i in 0..count {
                let j = (i + 1) % count;
                self.cell([near[i], near[j]], [far[i], far[j]]);
            }
            near = far;
        }
        let tip = self.add(Place::Tip { digit });
        for i in 0..count {
            self.triangles.push([near[i], near[(i + 1) % count], tip]);
        }
    }
}
