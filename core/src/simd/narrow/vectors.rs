//! The operations that an instruction set of 128 bits must offer.

/// The operations of one instruction set on 16 bytes: lanes of 8, 16 or 32 bits, as the name of an operation says. A
/// value of the type is the proof that the CPU has it. A mask has lanes of all ones or all zeros.
pub(crate) trait Vectors: Copy + Send + Sync {
    /// Its name, as [`Kernels::name`](crate::Kernels::name) gives it.
    const NAME: &'static str;

    /// The proof, if the target guarantees it.
    const GUARANTEED: Option<Self>;

    /// Asks the CPU, if the target guarantees nothing.
    #[inline(always)]
    fn detect() -> Option<Self> {
        Self::GUARANTEED
    }

    /// Whether pairs are tested four at a time. It takes more code.
    const TESTS_SOME_PAIRS: bool = true;

    /// 16 bytes in a register, the first one lowest.
    type Vector: Copy;

    /// As [`Simd::call`](crate::simd::Simd::call).
    fn call<R>(self, work: impl FnOnce() -> R) -> R;

    /// As [`Simd::prefetch`](crate::simd::Simd::prefetch).
    #[inline(always)]
    fn prefetch<T>(self, _: &[T], _: usize) {}

    fn load(self, bytes: &[u8; 16]) -> Self::Vector;
    fn store(self, bytes: &mut [u8; 16], a: Self::Vector);
    /// Four words.
    fn words(self, words: [u32; 4]) -> Self::Vector;
    /// One word, four times.
    fn splat(self, word: u32) -> Self::Vector;
    /// The first word.
    fn first(self, a: Self::Vector) -> u32;
    /// The first three words, then another one.
    fn with_fourth(self, a: Self::Vector, word: u32) -> Self::Vector;

    fn and(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    fn or(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    fn xor(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    /// The bytes of `a` where the mask is set, else those of `b`.
    fn select(self, mask: Self::Vector, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    /// Whether a bit is set.
    fn any(self, a: Self::Vector) -> bool;
    /// Whether a bit is set in the first three words.
    #[inline(always)]
    fn any_of_three(self, a: Self::Vector) -> bool {
        self.any(self.and(a, self.words([u32::MAX, u32::MAX, u32::MAX, 0])))
    }
    /// The bytes at these places; zero for the place [`NO_BYTE`].
    fn shuffle(self, a: Self::Vector, places: Self::Vector) -> Self::Vector;

    fn equal8(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    fn equal16(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    fn equal32(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    /// How much `a` exceeds `b`, or zero.
    fn excess8(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    fn excess16(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    /// A lane of 8 bits for each two lanes of `a` and then of `b`: zero where both are.
    fn join8(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    /// A lane of 16 bits for each two lanes of `a` and then of `b`: zero where both are.
    fn join16(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;

    /// Lanes of the first halves, one of `a` and one of `b` in turn.
    fn zip_first16(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    /// The same of the last halves.
    fn zip_last16(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    fn zip_first32(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    fn zip_last32(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    fn zip_first64(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    fn zip_last64(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    /// The last word of `a`, then the first three of `b`.
    fn fourth_on(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    /// The last two words of `a`, then the first two of `b`.
    fn third_on(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    /// The first three words of `a`, then the last one of `b`.
    fn three_and_last(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;

    /// Whether `a` is above `b`, with signs.
    fn above32(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    /// The lower of two numbers with signs.
    fn lower32(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    /// The upper of two numbers with signs.
    fn upper32(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    /// The lower of two numbers without signs.
    fn least32(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    /// The upper of two numbers without signs.
    fn most32(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    fn minus32(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    /// The absolute value; the least number stays.
    fn magnitude32(self, a: Self::Vector) -> Self::Vector;
    /// The keys of `f32`: see [`key`](crate::geometry::key::key).
    #[inline(always)]
    fn keys(self, a: Self::Vector) -> Self::Vector {
        let negative = self.above32(self.splat(0), a);
        // The magnitude with the sign, which turns -0.0 into zero.
        let magnitude = self.and(a, self.splat(i32::MAX as u32));
        self.minus32(self.xor(magnitude, negative), negative)
    }
    /// The `f32` of keys.
    #[inline(always)]
    fn floats(self, a: Self::Vector) -> Self::Vector {
        self.or(self.magnitude32(a), self.and(a, self.splat(1 << 31)))
    }
    /// Shifts the lower halves up, above zeros.
    fn raised32(self, a: Self::Vector) -> Self::Vector;

    /// The sum of `f32`. Those below are of `f32` too.
    fn add(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    fn subtract(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    fn multiply(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    /// `a` where it is above `b`, else `b`, also if one is NaN.
    fn maximum(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    /// `a` where it is below `b`, else `b`, also if one is NaN.
    fn minimum(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    /// Whether `a` is at most `b`.
    fn at_most(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    /// Lanes of 16 bits: the whole parts of numbers, those of `a` first. What is below zero or NaN gives zero, what is above 65,535
    /// that.
    fn steps16(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;

    /// A mask of 16 bytes, one for each four of four vectors: whether none of them is below that of the query.
    #[inline(always)]
    fn reached(self, [a, b, c, d]: [Self::Vector; 4], query: Self::Vector) -> Self::Vector {
        // How much the query's bytes exceed the others: zero where none does.
        let (a, b) = (self.excess8(query, a), self.excess8(query, b));
        let (c, d) = (self.excess8(query, c), self.excess8(query, d));
        self.equal8(self.join8(self.join16(a, b), self.join16(c, d)), self.splat(0))
    }

    /// A bit for each lane of a mask of 32 bits.
    fn bits4(self, mask: Self::Vector) -> u32;
    /// The same, and how many bits are set.
    #[inline(always)]
    fn counted4(self, mask: Self::Vector) -> (u32, u32) {
        let bits = self.bits4(mask);
        (bits, bits.count_ones())
    }
    /// A bit for each of six lanes of 32 bits in two masks: the first four and the last four, of which two are in both.
    #[inline(always)]
    fn bits6(self, [first, last]: [Self::Vector; 2]) -> u32 {
        self.bits4(first) | self.bits4(last) << 2
    }
    /// A bit for each lane of a mask of 8 bits.
    fn bits16(self, mask: Self::Vector) -> u32;
    /// The same of two masks.
    #[inline(always)]
    fn bits32(self, [a, b]: [Self::Vector; 2]) -> u32 {
        self.bits16(a) | self.bits16(b) << 16
    }
    /// The same of four masks.
    #[inline(always)]
    fn bits64(self, [a, b, c, d]: [Self::Vector; 4]) -> u64 {
        u64::from(self.bits32([a, b])) | u64::from(self.bits32([c, d])) << 32
    }
}

/// A place for [`Vectors::shuffle`] that gives zero.
pub(crate) const NO_BYTE: u8 = u8::MAX;

/// Functions whose operands and results are all vectors.
macro_rules! operations {
    ($($name:ident($($operand:ident),+) = $result:expr;)+) => {$(
        #[inline(always)]
        fn $name(self, $($operand: Self::Vector),+) -> Self::Vector {
            $result
        }
    )+};
}
pub(crate) use operations;
