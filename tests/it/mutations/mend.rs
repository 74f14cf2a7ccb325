//! Checksums made right after a mutation.

/// Gives the chunks of a PNG their right checksums, as far as its chunks can be followed.
pub(super) fn png(png: &mut [u8]) {
    let mut at = 8;
    while let Some(head) = png.get(at..at + 4) {
        let length = u32::from_be_bytes(head.try_into().expect("four bytes")) as usize;
        let Some(end) = at.checked_add(8 + length).filter(|end| end + 4 <= png.len()) else {
            return;
        };
        let crc = crc32(&png[at + 4..end]);
        png[end..end + 4].copy_from_slice(&crc.to_be_bytes());
        at = end + 4;
    }
}

/// Gives the packets of a mesh stream their right checksums, as far as they can be followed.
pub(super) fn mesh_stream(stream: &mut [u8]) {
    // Behind the header: a kind, a length, a checksum of kind and payload, and the payload.
    let mut at = 20;
    while let Some(head) = stream.get(at..at + 9) {
        let length = u32::from_le_bytes(head[1..5].try_into().expect("four bytes")) as usize;
        let Some(end) = at.checked_add(9 + length).filter(|&end| end <= stream.len()) else {
            return;
        };
        let crc = crc32(&[&stream[at..=at], &stream[at + 9..end]].concat());
        stream[at + 5..at + 9].copy_from_slice(&crc.to_le_bytes());
        at = end;
    }
}

/// The checksum of both, bit by bit.
pub(super) fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0u32, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |crc, _| {
            (crc >> 1) ^ (0xedb8_8320 & (crc & 1).wrapping_neg())
        })
    })
}
