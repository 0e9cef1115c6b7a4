//! As much of the Thumb instruction set as leads from one function to another.

/// Where an instruction may go on, other than behind itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Flow {
    /// To the next one.
    On,
    /// To an address, to come back.
    Call(u32),
    /// To an address.
    To(u32),
    /// To an address in a register.
    Anywhere,
}

/// The bytes of the instruction that starts with this halfword.
pub(crate) fn length(first: u16) -> u32 {
    if first >> 11 >= 0b11101 { 4 } else { 2 }
}

/// What the instruction at `address` does.
pub(crate) fn flow(address: u32, first: u16, second: u16) -> Flow {
    let here = address.wrapping_add(4);
    let to = |offset: i32| Flow::To(here.wrapping_add_signed(offset));
    let call = |offset: i32| Flow::Call(here.wrapping_add_signed(offset));
    let (first, second) = (u32::from(first), u32::from(second));
    if first >> 11 == 0b11110 && second & 0x8000 != 0 {
        let sign = first >> 10 & 1;
        let (j1, j2) = (second >> 13 & 1, second >> 11 & 1);
        let low = second & 0x7ff;
        return match (second >> 14 & 1, second >> 12 & 1) {
            // BL; B.W is the same without the link.
            (link, 1) => {
                let (i1, i2) = (1 ^ j1 ^ sign, 1 ^ j2 ^ sign);
                let offset =
                    extended(sign << 24 | i1 << 23 | i2 << 22 | (first & 0x3ff) << 12 | low << 1, 25);
                if link == 1 { call(offset) } else { to(offset) }
            }
            // B<c>.W, unless the condition says that it is another instruction.
            (0, 0) if first >> 7 & 7 != 7 => {
                to(extended(sign << 20 | j2 << 19 | j1 << 18 | (first & 0x3f) << 12 | low << 1, 21))
            }
            _ => Flow::On,
        };
    }
    match first {
        0xe000..=0xe7ff => to(extended((first & 0x7ff) << 1, 12)),
        0xd000..=0xddff => to(extended((first & 0xff) << 1, 9)),
        // BX, but for the return, and BLX.
        0x4700..=0x47ff if first & 0x78 != 0x70 || first & 0x80 != 0 => Flow::Anywhere,
        _ => Flow::On,
    }
}

fn extended(value: u32, bits: u32) -> i32 {
    ((value << (32 - bits)) as i32) >> (32 - bits)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn branches_are_decoded() {
        // As llvm-mc assembles them.
        assert_eq!(flow(0x1000, 0xf000, 0xf802), Flow::Call(0x1008), "bl #4");
        assert_eq!(flow(0x1000, 0xf7ff, 0xfffe), Flow::Call(0x1000), "bl #-4");
        assert_eq!(flow(0x1000, 0xf000, 0xb802), Flow::To(0x1008), "b.w #4");
        assert_eq!(flow(0x1000, 0xf43f, 0xaffe), Flow::To(0x1000), "beq.w #-4");
        assert_eq!(flow(0x1000, 0xe7fe, 0), Flow::To(0x1000), "b #-4");
        assert_eq!(flow(0x1000, 0xd0fe, 0), Flow::To(0x1000), "beq #-4");
        assert_eq!(flow(0x1000, 0x4770, 0), Flow::On, "bx lr");
        assert_eq!(flow(0x1000, 0x4718, 0), Flow::Anywhere, "bx r3");
        assert_eq!(flow(0x1000, 0x4798, 0), Flow::Anywhere, "blx r3");
        assert_eq!(flow(0x1000, 0xf3bf, 0x8f4f), Flow::On, "dsb sy");
        assert_eq!((length(0xf000), length(0x4770)), (4, 2));
    }
}
