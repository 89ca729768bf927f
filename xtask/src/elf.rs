//! The names of the symbols in a little-endian 32-bit ELF file: as much of the format as that takes.

/// A section of symbols.
const SYMTAB: u32 = 2;

/// The names of all symbols that are defined or asked for; `None` where the file is no such ELF file, or has none.
pub(crate) fn symbols(file: &[u8]) -> Option<Vec<String>> {
    // Magic, 32 bits, little-endian.
    if file.get(..6)? != b"\x7fELF\x01\x01" {
        return None;
    }
    let (offset, size, count) = (word(file, 32)?, half(file, 46)?, half(file, 48)?);
    let section = |i: u32| file.get((offset + i * size) as usize..);
    let table = (0..count).filter_map(section).find(|header| word(header, 4) == Some(SYMTAB))?;
    let (start, length, names) = (word(table, 16)?, word(table, 20)?, word(table, 24)?);
    let names = word(section(names)?, 16)?;
    let entries = file.get(start as usize..(start + length) as usize)?;
    let (entries, _) = entries.as_chunks::<16>();
    let name = |entry: &[u8; 16]| {
        let text = file.get((names + word(entry, 0)?) as usize..)?;
        let end = text.iter().position(|byte| *byte == 0)?;
        Some(String::from_utf8_lossy(text.get(..end)?).into_owned())
    };
    Some(entries.iter().filter_map(name).filter(|name| !name.is_empty()).collect())
}

fn word(bytes: &[u8], at: usize) -> Option<u32> {
    Some(u32::from_le_bytes(*bytes.get(at..)?.first_chunk()?))
}

fn half(bytes: &[u8], at: usize) -> Option<u32> {
    Some(u32::from(u16::from_le_bytes(*bytes.get(at..)?.first_chunk()?)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn symbols_of_a_small_file() {
        // Header; section headers 0 (none), 1 (symbols), 2 (names); two symbols; names.
        let mut file = vec![0u8; 52 + 3 * 40 + 2 * 16];
        file[..6].copy_from_slice(b"\x7fELF\x01\x01");
        let mut put = |at: usize, value: u32| file[at..at + 4].copy_from_slice(&value.to_le_bytes());
        put(32, 52);
        put(46, 40 | 3 << 16);
        let symbols_at = 52 + 3 * 40;
        for (at, value) in
            [(92 + 4, SYMTAB), (92 + 16, symbols_at), (92 + 20, 32), (92 + 24, 2), (132 + 16, symbols_at + 32)]
        {
            put(at, value);
        }
        put(symbols_at as usize + 16, 1);
        file.extend_from_slice(b"\0name\0");
        assert_eq!(symbols(&file), Some(vec!["name".to_owned()]));
        assert_eq!(symbols(&file[..60]), None);
        assert_eq!(symbols(b"\x7fELF\x02\x01"), None);
    }
}
