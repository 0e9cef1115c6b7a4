//! The operations that an instruction set must offer.

use crate::geometry::key::KeyBox;
use crate::simd::Row;

/// Calls another macro with the operations whose operands and results are all vectors.
macro_rules! of_vectors {
    ($then:ident) => {
        $then! {
            and(a, b);
            or(a, b);
            xor(a, b);
            /// The bytes of `a` where the mask is set, else of `b`.
            select(mask, a, b);
            /// The bytes at these places of the same half; zero for the place [`NO_BYTE`].
            shuffle(a, places);
            equal16(a, b);
            equal32(a, b);
            /// How much `a` exceeds `b`, or zero.
            excess16(a, b);
            /// A lane of 8 bits for each two lanes of `a` and then of `b`: zero where both are.
            join8(a, b);
            /// A lane of 16 bits for each two lanes of `a` and then of `b`: zero where both are.
            join16(a, b);
            /// The first lanes, one of `a` and one of `b` in turn.
            zip_first16(a, b);
            /// The same of the last lanes.
            zip_last16(a, b);
            zip_first32(a, b);
            zip_last32(a, b);
            zip_first64(a, b);
            zip_last64(a, b);
            /// The last word of `a`, then the first three of `b`.
            fourth_on(a, b);
            /// Whether `a` is above `b`, with signs.
            above32(a, b);
            /// The upper of two numbers with signs.
            upper32(a, b);
            minus32(a, b);
            /// The absolute value; the least number stays.
            magnitude32(a);
            /// The sum of `f32`. Those below are of `f32` too.
            add(a, b);
            subtract(a, b);
            multiply(a, b);
            /// `a` where it is above `b`, else `b`, also if one is NaN.
            maximum(a, b);
            /// `a` where it is below `b`, else `b`, also if one is NaN.
            minimum(a, b);
            /// Whether `a` is at most `b`.
            at_most(a, b);
        }
    };
}
pub(super) use of_vectors;

macro_rules! declare {
    ($($(#[$doc:meta])* $name:ident($($operand:ident),+);)+) => {
        $($(#[$doc])* fn $name(self, $($operand: Self::Vector),+) -> Self::Vector;)+
    };
}

/// The operations of one instruction set on vectors of one half or two halves, of 16 bytes each: lanes of 8,
/// 16 or 32 bits, as the name of an operation says. Both halves do the same. A value of the type is the proof
/// that the CPU has the instructions. A mask has lanes of all ones or all zeros.
pub(crate) trait Vectors: Copy + Send + Sync {
    /// The name of its level, as [`Kernels::name`](crate::Kernels::name) gives it.
    const NAME: &'static str;

    /// The proof, if the target guarantees it.
    const GUARANTEED: Option<Self>;

    /// Asks the CPU, if the target guarantees nothing.
    #[inline(always)]
    fn detect() -> Option<Self> {
        Self::GUARANTEED
    }

    /// As [`Simd::MORE_CODE`](crate::simd::Simd::MORE_CODE).
    const MORE_CODE: bool = true;

    /// A vector in registers, the first byte lowest.
    type Vector: Copy;

    /// As [`Simd::call`](crate::simd::Simd::call).
    #[inline(never)]
    fn call<R>(self, work: impl FnOnce() -> R) -> R {
        work()
    }

    /// Four words, in each half.
    fn words(self, words: [u32; 4]) -> Self::Vector;
    /// One word everywhere.
    fn splat(self, word: u32) -> Self::Vector;

    of_vectors!(declare);

    /// Whether a bit is set.
    fn any(self, a: Self::Vector) -> bool;
    /// Whether a bit is set in the first three words of a half.
    #[inline(always)]
    fn any_of_three(self, a: Self::Vector) -> bool {
        self.any(self.and(a, self.words([u32::MAX, u32::MAX, u32::MAX, 0])))
    }

    /// Numbers with the other sign where `ways` are below zero. Where these are zero, a number must be zero, too.
    #[inline(always)]
    fn turned(self, a: Self::Vector, ways: Self::Vector) -> Self::Vector {
        let negative = self.above32(self.splat(0), ways);
        self.minus32(self.xor(a, negative), negative)
    }
    /// The keys of `f32`: see [`key`](crate::geometry::key::key).
    #[inline(always)]
    fn keys(self, a: Self::Vector) -> Self::Vector {
        // The magnitude with the sign, which turns -0.0 into zero.
        self.turned(self.and(a, self.splat(i32::MAX as u32)), a)
    }
    /// The `f32` of keys.
    #[inline(always)]
    fn floats(self, a: Self::Vector) -> Self::Vector {
        self.or(self.magnitude32(a), self.and(a, self.splat(1 << 31)))
    }
}

/// Vectors of one half.
pub(crate) trait Half: Vectors {
    fn load(self, bytes: &[u8; 16]) -> Self::Vector;
    fn store(self, bytes: &mut [u8; 16], a: Self::Vector);
    /// The first word.
    fn first(self, a: Self::Vector) -> u32;
    /// The first and the third word of `a` and of `b`.
    fn even32(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    /// The second and the last word of `a` and of `b`.
    fn odd32(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    /// As [`Halves::steps16`], first of `a`.
    fn steps16(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    /// A mask of 16 bytes, one for each four of four vectors: whether none is below the query's.
    fn reached(self, rows: [Self::Vector; 4], query: Self::Vector) -> Self::Vector;
    /// A bit for each lane of a mask of 32 bits.
    fn bits4(self, mask: Self::Vector) -> u32;
    /// A bit for each lane of four masks of 8 bits.
    fn bits64(self, masks: [Self::Vector; 4]) -> u64;
}

/// The vectors of one half of some vectors.
pub(crate) type HalfOf<W> = <<W as Halves>::Half as Vectors>::Vector;

/// Vectors of two halves.
pub(crate) trait Halves: Vectors {
    /// The operations on one half.
    type Half: Half;

    /// The proof of these.
    fn half(self) -> Self::Half;
    fn split(self, a: Self::Vector) -> [HalfOf<Self>; 2];
    fn joined(self, first: HalfOf<Self>, last: HalfOf<Self>) -> Self::Vector;
    /// Both halves from memory.
    #[inline(always)]
    fn pick(self, first: &[u8; 16], last: &[u8; 16]) -> Self::Vector {
        self.joined(self.half().load(first), self.half().load(last))
    }
    /// Both halves to memory.
    #[inline(always)]
    fn put(self, first: &mut [u8; 16], last: &mut [u8; 16], a: Self::Vector) {
        let halves = self.split(a);
        self.half().store(first, halves[0]);
        self.half().store(last, halves[1]);
    }
    /// The same half twice.
    #[inline(always)]
    fn both(self, bytes: &[u8; 16]) -> Self::Vector {
        self.pick(bytes, bytes)
    }

    /// The six keys of a box, in an order of the instruction set.
    fn sides(self, bounds: &KeyBox) -> Self::Vector;
    /// The minima of two boxes, a half each, and the maxima of the other one, by the bytes from the start of
    /// either on. The last word of a half means nothing.
    fn opposed(self, boxes: [&[u8; 32]; 2]) -> [Self::Vector; 2];
    /// In another order: the minima in the first three words of the first half, the maxima in the last half.
    fn halved(self, sides: Self::Vector) -> Self::Vector;
    /// The bits of a mask of six such lanes, as in [`Simd::above`](crate::simd::Simd::above).
    fn six(self, mask: Self::Vector) -> u32;
    /// Lanes of 16 bits: the whole parts of numbers. What is below zero or NaN gives zero, what is above 65,535
    /// that.
    fn steps16(self, a: Self::Vector) -> HalfOf<Self>;
    /// A bit for each lane of a mask of 32 bits.
    fn bits8(self, mask: Self::Vector) -> u32;
    /// Whether lanes of 64 bits are zero, a bit each.
    fn zeros64(self, a: Self::Vector) -> u32;
    /// As [`Simd::window`](crate::simd::Simd::window).
    fn window<const N: usize>(self, rows: &[Row; N], count: usize, query: Self::Vector) -> u64;

    /// The lanes of 64 bits whose bit is set.
    fn kept64(self, a: Self::Vector, mask: u32, to: &mut [[u8; 16]; 2]);
}

/// For each mask of four lanes, of so many parts together, the places of the parts of the lanes that it
/// keeps.
pub(crate) const fn kept<const PARTS: usize>() -> [[u8; PARTS]; 16] {
    let mut table = [[0; PARTS]; 16];
    let mut mask = 0;
    while mask < 16 {
        let (mut part, mut to) = (0, 0);
        while part < PARTS {
            if mask >> (4 * part / PARTS) & 1 != 0 {
                table[mask][to] = part as u8;
                to += 1;
            }
            part += 1;
        }
        mask += 1;
    }
    table
}

/// The first and the last four keys of a box.
#[inline(always)]
pub(crate) fn ends(bounds: &KeyBox) -> [&[u8; 16]; 2] {
    let bytes: &[u8; 24] = bytemuck::cast_ref(bounds);
    // There are as many.
    [bytes.first_chunk().unwrap_or(&[0; 16]), bytes.last_chunk().unwrap_or(&[0; 16])]
}

/// A place for [`Vectors::shuffle`] that gives zero.
pub(crate) const NO_BYTE: u8 = u8::MAX;

/// The places of the bytes of four words.
pub(crate) const fn places([a, b, c, d]: [u8; 4]) -> [u8; 16] {
    let [a, b, c, d] = [4 * a, 4 * b, 4 * c, 4 * d];
    [a, a + 1, a + 2, a + 3, b, b + 1, b + 2, b + 3, c, c + 1, c + 2, c + 3, d, d + 1, d + 2, d + 3]
}

/// Functions, each with what it gives, for which `self` may have a name. Operands and results without a type
/// are vectors.
macro_rules! operations {
    (@type) => {
        Self::Vector
    };
    (@type $type:ty) => {
        $type
    };
    (|$this:ident| $($name:ident($($operand:ident $(: $type:ty)?),*) $(-> $result:ty)? = $value:expr;)+) => {$(
        #[inline(always)]
        fn $name(self, $($operand: operations!(@type $($type)?)),*) -> operations!(@type $($result)?) {
            let $this = self;
            $value
        }
    )+};
    ($($name:ident $of:tt $(-> $result:ty)? = $value:expr;)+) => {
        operations! { |_this| $($name $of $(-> $result)? = $value;)+ }
    };
}
pub(crate) use operations;

/// The same with instructions that a value of the type proves. None reads or writes beyond its operand, or a row
/// of a table.
#[allow(unused_macros, reason = "WebAssembly needs no proof")]
macro_rules! proven {
    ($($name:ident $of:tt $(-> $result:ty)? = $value:expr;)+) => {
        operations! { $($name $of $(-> $result)? =
            // SAFETY: `self` proves that the CPU has them, and memory is that of a reference.
            unsafe { $value };)+ }
    };
}
#[allow(unused_imports, reason = "WebAssembly needs no proof")]
pub(crate) use proven;
