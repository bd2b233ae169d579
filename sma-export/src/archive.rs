//! A zip archive of a few files that are stored as they are, to the same bytes every time.

/// Date of all entries in the archive's own form: the first that it can hold, 1980-01-01.
const DATE: u16 = (1 << 5) | 1;
/// Version of the format that a reader needs for stored files, times ten.
const VERSION: u16 = 20;
/// Names are UTF-8.
const UTF_8: u16 = 1 << 11;

/// A file of an archive: its path inside, and its bytes.
pub(crate) type Entry<'a> = (&'a str, &'a [u8]);

/// The archive; `None` if it would be larger than its format can hold.
pub(crate) fn archive(entries: &[Entry<'_>]) -> Option<Vec<u8>> {
    let mut bytes = Vec::new();
    let mut directory = Vec::new();
    for (path, content) in entries {
        let size = u32::try_from(content.len()).ok()?;
        let name_length = u16::try_from(path.len()).ok()?;
        let start = u32::try_from(bytes.len()).ok()?;
        let mut common = Vec::new();
        for short in [VERSION, UTF_8, 0, 0, DATE] {
            common.extend(short.to_le_bytes());
        }
        for long in [crc_32(content), size, size] {
            common.extend(long.to_le_bytes());
        }
        common.extend(name_length.to_le_bytes());
        common.extend(0_u16.to_le_bytes());
        bytes.extend(b"PK\x03\x04");
        bytes.extend(&common);
        bytes.extend(path.as_bytes());
        bytes.extend(*content);
        directory.extend(b"PK\x01\x02");
        directory.extend(VERSION.to_le_bytes());
        directory.extend(&common);
        // No comment, first disk, no attributes.
        directory.extend([0; 10]);
        directory.extend(start.to_le_bytes());
        directory.extend(path.as_bytes());
    }
    let count = u16::try_from(entries.len()).ok()?;
    let start = u32::try_from(bytes.len()).ok()?;
    let size = u32::try_from(directory.len()).ok()?;
    bytes.extend(directory);
    bytes.extend(b"PK\x05\x06");
    for short in [0, 0, count, count] {
        bytes.extend(short.to_le_bytes());
    }
    bytes.extend(size.to_le_bytes());
    bytes.extend(start.to_le_bytes());
    bytes.extend(0_u16.to_le_bytes());
    Some(bytes)
}

/// CRC-32 of the format, polynomial 0xEDB88320.
fn crc_32(bytes: &[u8]) -> u32 {
    let mut table = [0_u32; 256];
    for (value, row) in (0_u32..).zip(&mut table) {
        *row = (0..8).fold(value, |row, _| {
            (row >> 1) ^ (0xEDB8_8320 & (row & 1).wrapping_neg())
        });
    }
    !bytes.iter().fold(!0, |sum, &byte| {
        table[((sum ^ u32::from(byte)) & 0xff) as usize] ^ (sum >> 8)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sum_is_that_of_the_format() {
        // Its check value.
        assert_eq!(crc_32(b"123456789"), 0xCBF4_3926);
        assert_eq!(crc_32(b""), 0);
    }

    #[test]
    fn an_archive_has_its_files_and_its_directory() {
        let bytes = archive(&[("a/b.txt", b"hello"), ("c", b"")]).unwrap();
        assert_eq!(&bytes[..4], b"PK\x03\x04");
        assert_eq!(&bytes[30..37], b"a/b.txt");
        assert_eq!(&bytes[37..42], b"hello");
        // 30 + 7 + 5, 30 + 1, then 46 + 7 and 46 + 1 of the directory, and 22 of its end.
        assert_eq!(bytes.len(), 42 + 31 + 53 + 47 + 22);
        let end = &bytes[bytes.len() - 22..];
        assert_eq!(&end[..4], b"PK\x05\x06");
        assert_eq!(end[10..12], 2_u16.to_le_bytes());
        assert_eq!(end[16..20], 73_u32.to_le_bytes());
    }
}
