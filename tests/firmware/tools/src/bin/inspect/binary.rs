//! What the checks need to know of a linked file.

use anyhow::{Context, Result};
use object::{Object, ObjectSection, ObjectSymbol, SymbolKind};
use std::collections::{BTreeMap, HashMap};

/// A function.
pub(crate) struct Function {
    pub(crate) name: String,
    pub(crate) start: u32,
    pub(crate) end: u32,
    /// The bytes of its frame, where the compiler has told them.
    pub(crate) frame: Option<u32>,
}

/// A linked file.
pub(crate) struct Binary {
    /// In ascending order.
    pub(crate) functions: Vec<Function>,
    /// Bytes by name.
    pub(crate) sections: HashMap<String, u64>,
    pub(crate) text: Vec<u8>,
    pub(crate) text_start: u32,
    /// Where code (true) and data (false) begin among the code, by address.
    pub(crate) kinds: BTreeMap<u32, bool>,
    /// All words outside the code, where addresses of functions may be.
    pub(crate) words: Vec<u32>,
}

impl Binary {
    pub(crate) fn read(bytes: &[u8]) -> Result<Self> {
        let file = object::File::parse(bytes)?;
        let text = file.section_by_name(".text").context("no .text")?;
        let frames = file.section_by_name(".stack_sizes").map_or(Ok(&[][..]), |section| section.data())?;
        let frames = frames_of(frames).context(".stack_sizes is cut off")?;
        let mut functions = Vec::new();
        let mut kinds = BTreeMap::new();
        for symbol in file.symbols() {
            let (name, address) = (symbol.name()?, symbol.address() as u32);
            if name.starts_with("$t") || name.starts_with("$d") {
                kinds.insert(address, name.starts_with("$t"));
            } else if symbol.kind() == SymbolKind::Text && symbol.size() > 0 {
                // The lowest bit of an address says Thumb.
                let start = address & !1;
                functions.push(Function {
                    name: format!("{:#}", rustc_demangle::demangle(name)),
                    start,
                    end: start + symbol.size() as u32,
                    frame: frames.get(&start).copied(),
                });
            }
        }
        functions.sort_by_key(|function| function.start);
        functions.dedup_by_key(|function| function.start);
        let data = file.section_by_name(".rodata").map_or(Ok(&[][..]), |section| section.data())?;
        Ok(Self {
            functions,
            sections: file.sections().map(|s| Ok((s.name()?.to_owned(), s.size()))).collect::<Result<_>>()?,
            text: text.data()?.to_vec(),
            text_start: text.address() as u32,
            kinds,
            words: data.chunks_exact(4).map(word).collect(),
        })
    }

    /// The function that an address lies in.
    pub(crate) fn function_at(&self, address: u32) -> Option<&Function> {
        let next = self.functions.partition_point(|function| function.start <= address);
        self.functions[..next].last().filter(|function| address < function.end)
    }

    /// A halfword of the code.
    pub(crate) fn half(&self, address: u32) -> Option<u16> {
        let at = (address - self.text_start) as usize;
        self.text.get(at..at + 2).map(|half| u16::from_le_bytes([half[0], half[1]]))
    }

    /// Whether an address among the code holds data.
    pub(crate) fn is_data(&self, address: u32) -> bool {
        self.kinds.range(..=address).next_back().is_some_and(|(_, code)| !code)
    }
}

pub(crate) fn word(bytes: &[u8]) -> u32 {
    u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]])
}

/// An address and a LEB128 number for each function.
fn frames_of(mut bytes: &[u8]) -> Option<HashMap<u32, u32>> {
    let mut frames = HashMap::new();
    while !bytes.is_empty() {
        let (address, mut rest) = bytes.split_at_checked(4)?;
        let (mut frame, mut shift) = (0, 0);
        loop {
            let (&byte, tail) = rest.split_first()?;
            rest = tail;
            frame |= u32::from(byte & 0x7f) << shift;
            shift += 7;
            if byte & 0x80 == 0 {
                break;
            }
        }
        frames.insert(word(address) & !1, frame);
        bytes = rest;
    }
    Some(frames)
}
