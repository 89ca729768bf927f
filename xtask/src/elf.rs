//! Symbols and sections of a little-endian 32-bit ELF file: as much of the format as that takes.

/// A section of symbols.
const SYMTAB: u32 = 2;

/// A section without contents in the file.
const NOBITS: u32 = 8;

/// Flag of a section that takes memory on the target.
const ALLOC: u32 = 2;

/// A section that takes memory on the target.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Section {
    pub(crate) name: String,
    pub(crate) size: u64,
    /// Whether the file has its contents: they lie in flash, maybe to be copied from there.
    pub(crate) in_flash: bool,
}

/// The sections that take memory; `None` where the file is no such ELF file.
pub(crate) fn sections(file: &[u8]) -> Option<Vec<Section>> {
    let (headers, names) = (headers(file)?, half(file, 50)?);
    let names = word(headers.get(names as usize)?, 16)?;
    let section = |header: &[u8]| {
        Some(Section {
            name: text(file, names + word(header, 0)?)?,
            size: word(header, 20)?.into(),
            in_flash: word(header, 4)? != NOBITS,
        })
    };
    headers
        .iter()
        .filter(|header| word(header, 8).is_some_and(|flags| flags & ALLOC != 0))
        .map(|header| section(header))
        .collect()
}

/// The names of all symbols that are defined or asked for; `None` where the file is no such ELF file, or has none.
pub(crate) fn symbols(file: &[u8]) -> Option<Vec<String>> {
    let headers = headers(file)?;
    let table = headers.iter().find(|header| word(header, 4) == Some(SYMTAB))?;
    let (start, length, names) = (word(table, 16)?, word(table, 20)?, word(table, 24)?);
    let names = word(headers.get(names as usize)?, 16)?;
    let entries = file.get(start as usize..(start + length) as usize)?;
    let (entries, _) = entries.as_chunks::<16>();
    let name = |entry: &[u8; 16]| text(file, names + word(entry, 0)?);
    Some(entries.iter().filter_map(name).filter(|name| !name.is_empty()).collect())
}

/// The headers of all sections.
fn headers(file: &[u8]) -> Option<Vec<&[u8]>> {
    // Magic, 32 bits, little-endian.
    if file.get(..6)? != b"\x7fELF\x01\x01" {
        return None;
    }
    let (offset, size, count) = (word(file, 32)?, half(file, 46)?, half(file, 48)?);
    (0..count).map(|i| file.get((offset + i * size) as usize..)).collect()
}

/// The text that begins there and ends before a zero.
fn text(file: &[u8], at: u32) -> Option<String> {
    let text = file.get(at as usize..)?;
    let end = text.iter().position(|byte| *byte == 0)?;
    Some(String::from_utf8_lossy(text.get(..end)?).into_owned())
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
        let put_word = |file: &mut [u8], at: usize, value: u32| file[at..at + 4].copy_from_slice(&value.to_le_bytes());
        let mut put = |at, value| put_word(&mut file, at, value);
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
        // Sections by name: the symbols' one as one without contents.
        put_word(&mut file, 48, 3 | 2 << 16);
        put_word(&mut file, 92, 1);
        put_word(&mut file, 92 + 8, ALLOC);
        let section = |in_flash| Section { name: "name".to_owned(), size: 32, in_flash };
        assert_eq!(sections(&file), Some(vec![section(true)]));
        put_word(&mut file, 92 + 4, NOBITS);
        assert_eq!(sections(&file), Some(vec![section(false)]));
        assert_eq!(symbols(&file[..60]), None);
        assert_eq!(symbols(b"\x7fELF\x02\x01"), None);
    }
}
