//! Frames of a mesh stream, each in a packet whose checksum fits: what is read is an error or a sound mesh.
#![no_main]

use libfuzzer_sys::fuzz_target;
use polyreel::mesh_stream::{MAGIC, MeshReader};

/// CRC-32, bit by bit.
fn checksum(bytes: impl Iterator<Item = u8>) -> u32 {
    !bytes.fold(!0, |sum, byte| {
        (0..8).fold(sum ^ u32::from(byte), |sum, _| sum >> 1 ^ (0xedb8_8320 * (sum & 1)))
    })
}

fn packet(kind: u8, payload: &[u8]) -> Vec<u8> {
    let mut bytes = vec![kind];
    bytes.extend((payload.len() as u32).to_le_bytes());
    bytes.extend(checksum(std::iter::once(kind).chain(payload.iter().copied())).to_le_bytes());
    bytes.extend(payload);
    bytes
}

/// The bytes behind the first two, which are the length of the first part.
fn parts(bytes: &[u8]) -> Option<(&[u8], &[u8])> {
    let (length, rest) = bytes.split_first_chunk()?;
    Some(rest.split_at(usize::from(u16::from_le_bytes(*length)).min(rest.len())))
}

fuzz_target!(|bytes: &[u8]| {
    let Some((key, delta)) = parts(bytes) else { return };
    let mut stream = MAGIC.to_vec();
    stream.extend([2, 0, 2, 0, 64, 0, 0, 0, 48, 0, 0, 0]);
    stream.append(&mut packet(b'H', b"rate=25\n"));
    // Two frames at the time 0/1, of unknown length.
    let time: Vec<u8> = [0i64, 1, 0, 0].iter().flat_map(|word| word.to_le_bytes()).collect();
    stream.append(&mut packet(b'K', &[&time[..], key].concat()));
    stream.append(&mut packet(b'D', &[&time[..], delta].concat()));
    let Ok(mut reader) = MeshReader::new(&stream[..]) else { panic!("the header is sound") };
    while let Ok(Some(frame)) = reader.next_frame() {
        assert_eq!(frame.mesh.check(), Ok(()));
    }
});
