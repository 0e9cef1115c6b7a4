//! Who in a leaf is compared with whom. Objects with the same filter are of one kind, and kinds that meet the
//! same kinds are one part of the world. Parts that do not meet are not compared.

use crate::access::Access;
use crate::filter::Filter;
use crate::pairs::pair_filter::PairFilter;
use crate::tree::Record;

/// The most filters that are told apart. Others count as meeting all.
const KNOWN: usize = 8;
/// The most parts. Where there are more, the last one is several, and meets what any of them meets.
const PARTS: usize = 4;
/// The code of an object: its part, and marks if it has not moved or meets nobody.
const PART: usize = PARTS - 1;
const RESTS: usize = PARTS;
pub(crate) const LONE: usize = 2 * PARTS;
pub(crate) const CODES: usize = 2 * LONE;
/// How many records there are of each part, and of none.
pub(crate) type Counts = [u64; PARTS + 1];
/// One more pass over a leaf pays if it spares one in so many pairs of records.
const PAYS: u64 = 8;

/// What to do in a leaf.
pub(crate) struct Plan {
    /// Which parts of the leaf each of them meets; if they are taken as one, that one alone.
    meets: [u8; PARTS],
    one: bool,
    moved_alone: bool,
    /// Whether all records are compared with each other.
    pub(crate) whole: bool,
    /// How many pairs of records are not, as their filters do not meet.
    pub(crate) spared: u64,
}

/// One pass over a leaf.
pub(crate) struct Pass {
    /// The side of a record of either bucket, by its code. Side 0 meets side 1, side 2 nobody.
    pub(crate) sides: [[u8; CODES]; 2],
    /// Whether side 0 is also compared with itself.
    pub(crate) within: bool,
}

#[derive(Clone, Copy)]
pub(crate) struct Kinds<'g> {
    /// The code of each object. Empty if all are compared with all.
    codes: &'g [u8],
    /// Whether there are filters that do not meet.
    has_filters: bool,
    /// Which parts each part meets, a bit each.
    meets: [u8; PARTS],
    /// Whether only pairs of moved objects are looked for.
    moved_alone: bool,
}

impl<'g> Kinds<'g> {
    /// The kinds of a world; `codes` has room for one of each object. O(slots).
    pub(crate) fn new(
        filters: Option<&PairFilter<'_>>,
        moved: Option<&'g [u32]>,
        codes: &'g mut [u8],
    ) -> Self {
        let filters = filters.filter(|filters| filters.tells_apart());
        let (has_filters, moved_alone) = (filters.is_some(), cfg!(feature = "large") && moved.is_some());
        let meets = match filters {
            Some(filters) => Self::tell_apart(filters, codes),
            None => [1, 0, 0, 0],
        };
        let moved = moved.filter(|_| moved_alone).unwrap_or_default();
        for (word, codes) in moved.iter().zip(codes.chunks_mut(32)) {
            for (bit, code) in codes.iter_mut().enumerate() {
                let part = if has_filters { *code } else { 0 };
                *code = part | if word >> bit & 1 == 0 { RESTS as u8 } else { 0 };
            }
        }
        let codes = if has_filters || moved_alone { &*codes } else { &[] };
        Self { codes, has_filters, meets, moved_alone }
    }

    /// Writes the part of each object, and returns which parts each of them meets.
    #[inline(never)]
    fn tell_apart(pair_filter: &PairFilter<'_>, codes: &mut [u8]) -> [u8; PARTS] {
        let (mut known, mut count) = ([Filter::ALL; KNOWN], 0);
        let mut last = None;
        for (filter, code) in pair_filter.filters.iter().zip(&mut *codes) {
            // Most objects have the filter of the one before.
            if last.is_none_or(|(known, _)| known != *filter) {
                let lone = filter.group == 0 || filter.mask == 0;
                let kind = known.iter().take(count).position(|known| known == filter).unwrap_or(count);
                if let (false, true, Some(new)) = (lone, kind == count, known.get_mut(kind)) {
                    *new = *filter;
                    count += 1;
                }
                last = Some((*filter, if lone { KNOWN + 1 } else { kind }));
            }
            *code = last.map_or(0, |(_, kind)| kind) as u8;
        }
        // Others are one more kind.
        let meet = |a: usize, b: usize| match (known.get(a), known.get(b)) {
            (Some(a), Some(b)) => pair_filter.meet(a, b),
            _ => true,
        };
        let kinds = if count == KNOWN { KNOWN + 1 } else { count };
        let mut rows = [0u16; KNOWN + 1];
        for (a, row) in rows.iter_mut().enumerate().take(kinds) {
            *row = (0..kinds).fold(0, |row, b| row | u16::from(meet(a, b)) << b);
        }
        let (mut part_of, mut parts) = ([LONE as u8; KNOWN + 2], 0);
        // Those that meet themselves first: a pass over a leaf is for one part and all later ones.
        for own in [1, 0] {
            for a in (0..kinds).filter(|&a| rows.at(a) != 0 && rows.at(a) >> a & 1 == own) {
                let twin = (0..a).find(|&b| rows.at(b) == rows.at(a));
                let part = twin.map_or(parts.min(PART as u8), |twin| part_of.at(twin));
                part_of.put(a, part);
                parts += u8::from(twin.is_none());
            }
        }
        let mut meets = [0; PARTS];
        for a in 0..kinds {
            for b in (0..kinds).filter(|b| rows.at(a) >> b & 1 != 0) {
                meets[part_of.at(a) as usize & PART] |= 1 << part_of.at(b);
            }
        }
        for code in codes {
            *code = part_of.at((*code).into());
        }
        meets
    }

    /// Whether all records of all leaves are compared.
    pub(crate) const fn are_one(&self) -> bool {
        self.codes.is_empty()
    }

    /// The code of an object, by its record.
    pub(super) fn code(&self, record: &Record) -> usize {
        self.codes.get(record.slot() as usize).map_or(0, |code| (*code).into())
    }

    /// Counts the objects of each part, and of none, if that has a say: fewer than 65,536, so in registers.
    #[inline(always)]
    pub(crate) fn count<'r>(&self, records: impl Iterator<Item = &'r Record>) -> Counts {
        let (mut sums, mut lone) = (0u64, 0);
        for record in records.filter(|_| self.has_filters) {
            let code = self.code(record);
            let is_lone = u64::from(code >= LONE);
            sums += (1 - is_lone) << (16 * (code & PART));
            lone += is_lone;
        }
        let part = |part: usize| sums >> (16 * part) & 0xffff;
        [part(0), part(1), part(2), part(3), lone]
    }

    /// What to do in a leaf with so many records of each part.
    pub(crate) fn plan(&self, counts: &Counts) -> Plan {
        let Self { mut meets, moved_alone, .. } = *self;
        if !self.has_filters {
            return Plan { meets, one: true, moved_alone, whole: !moved_alone, spared: 0 };
        }
        let (mut all, mut met, mut passes) = (0, 0, 0);
        for a in 0..PARTS {
            let (before, own) = (met, counts.at(a));
            for b in 0..=a {
                let pairs = if a == b { own * own.saturating_sub(1) / 2 } else { own * counts.at(b) };
                all += pairs;
                if pairs > 0 && meets.at(b) >> a & 1 != 0 {
                    met += pairs;
                } else {
                    let (of_a, of_b) = (meets.at(a) & !(1 << b), meets.at(b) & !(1 << a));
                    meets.put(a, of_a);
                    meets.put(b, of_b);
                }
            }
            passes += u64::from(met > before);
        }
        // So many passes must spare enough.
        let one = (all - met) * PAYS < all * passes;
        if one {
            (meets, met) = ([1, 0, 0, 0], all);
        }
        let count: u64 = counts.iter().sum();
        let whole = one && counts.at(PARTS) == 0 && !moved_alone;
        Plan { meets, one, moved_alone, whole, spared: count * count.saturating_sub(1) / 2 - met }
    }
}

impl Plan {
    fn part(&self, code: usize) -> usize {
        if self.one { 0 } else { code & PART }
    }

    /// Whether a record with this code is compared with any other one.
    pub(super) fn takes(&self, code: usize) -> bool {
        code < LONE && self.meets.at(self.part(code)) != 0
    }

    /// A pass over two buckets, below [`LONE`]: of each part the moved records, then the rest. If `across`,
    /// each record of the first bucket meets each of the second. `None` if nobody would meet.
    pub(crate) fn pass(&self, number: usize, across: bool) -> Option<Pass> {
        let (first, resting) = (number / 2, number & 1 != 0);
        let meets = self.meets.at(first);
        let later = if across { meets } else { meets & u8::MAX << first << 1 };
        let within = !across && !resting && meets >> first & 1 != 0;
        if later == 0 && !within || resting && !self.moved_alone {
            return None;
        }
        let mut sides = [[2; CODES]; 2];
        for (bucket, sides) in sides.iter_mut().enumerate() {
            for (code, side) in sides.iter_mut().take(LONE).enumerate() {
                let (part, rests) = (self.part(code), code & RESTS != 0);
                let is_other = later >> part & 1 != 0 && (!across || bucket == 1) && !(resting && rests);
                let is_first = part == first && rests == resting && !(across && bucket == 1);
                *side = if is_first { 0 } else { 2 - u8::from(is_other || within && part == first && rests) };
            }
        }
        Some(Pass { sides, within })
    }
}
