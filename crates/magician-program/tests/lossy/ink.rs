//! Drawings as what they are: ink along lines, in its order.

use magician::sim::world::{Drawing, StrokeKind};

/// As far as a line that was followed in other steps may be from itself, mm: a drawing's corners are that true.
pub(crate) const TRUE: f64 = 0.02;
/// Points nearer than this are the same, mm.
const SAME: f64 = 1e-6;
/// Between two looks along a line, mm.
const LOOKS: f64 = 0.1;

/// A straight piece of ink.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Piece {
    kind: StrokeKind,
    power: f64,
    from: [f64; 2],
    to: [f64; 2],
}

impl Piece {
    fn length(&self) -> f64 {
        apart(self.from, self.to)
    }
}

/// All ink in the order in which it came.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Ink {
    pieces: Vec<Piece>,
    /// How much there is before each piece, and in all, mm.
    upto: Vec<f64>,
}

fn apart(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

impl Ink {
    pub(crate) fn of(drawing: &Drawing) -> Self {
        let mut pieces = Vec::new();
        for stroke in drawing.strokes() {
            let ends = stroke.points.iter().zip(stroke.points.iter().skip(1));
            pieces.extend(ends.map(|(from, to)| Piece {
                kind: stroke.kind,
                power: stroke.power,
                from: *from,
                to: *to,
            }));
        }
        let mut sum = 0.0;
        let mut upto = vec![0.0];
        for piece in &pieces {
            sum += piece.length();
            upto.push(sum);
        }
        Self { pieces, upto }
    }

    /// How much there is, mm.
    pub(crate) fn length(&self) -> f64 {
        self.upto.last().copied().unwrap_or(0.0)
    }

    /// Where it is after so much ink.
    fn at(&self, length: f64) -> Option<[f64; 2]> {
        let begun = self.upto.partition_point(|upto| *upto <= length);
        let next = begun.clamp(1, self.pieces.len().max(1)) - 1;
        let piece = self.pieces.get(next)?;
        let begun = self.upto.get(next).copied().unwrap_or(length);
        let share = ((length - begun) / piece.length().max(SAME)).clamp(0.0, 1.0);
        Some([0, 1].map(|axis| piece.from[axis] + share * (piece.to[axis] - piece.from[axis])))
    }

    /// Whether both are the same strokes to the millionth of a millimetre, however often they were set down and taken up
    /// at the same place.
    pub(crate) fn is_the_same(&self, other: &Self) -> bool {
        let (one, two) = (self.joined(), other.joined());
        let same = |a: [f64; 2], b: [f64; 2]| apart(a, b) <= SAME;
        one.len() == two.len()
            && one.iter().zip(&two).all(|(one, two)| {
                one.kind == two.kind
                    && one.power == two.power
                    && same(one.from, two.from)
                    && same(one.to, two.to)
            })
    }

    /// With the pieces of a straight line made one.
    fn joined(&self) -> Vec<Piece> {
        let mut joined: Vec<Piece> = Vec::new();
        for piece in self.pieces.iter().filter(|piece| piece.length() > SAME) {
            match joined.last_mut() {
                Some(last) if last.goes_on_with(piece) => last.to = piece.to,
                _ => joined.push(*piece),
            }
        }
        joined
    }

    /// How far it is at most from the beginning of another one, mm; nothing if it is longer than that.
    pub(crate) fn off_the_beginning_of(&self, whole: &Self) -> Option<f64> {
        if self.length() > whole.length() + TRUE {
            return None;
        }
        let looks = (self.length() / LOOKS).ceil() as u64;
        let off = (0..=looks).filter_map(|nth| {
            let length = (nth as f64 * LOOKS).min(self.length());
            // Rounding adds up along a curve: the nearest place thereabouts counts.
            let at = self.at(length)?;
            let near =
                (-4..=4).filter_map(|shift| whole.at(length + f64::from(shift) * TRUE / 2.0));
            near.map(|there| apart(at, there)).min_by(f64::total_cmp)
        });
        Some(off.fold(0.0, f64::max))
    }
}

impl Piece {
    fn goes_on_with(&self, next: &Self) -> bool {
        let way = self.length() + next.length();
        self.kind == next.kind
            && self.power == next.power
            && apart(self.to, next.from) <= SAME
            && way - apart(self.from, next.to) <= SAME * way.max(1.0)
    }
}
